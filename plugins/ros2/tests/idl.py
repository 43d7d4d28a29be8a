"""Types of ROS 2 for Cyclone DDS: of the packages that have no wheel, and what they are made of.

Written from the definitions of simulation_interfaces 2.1, nav2_msgs (NavigateToPose), rmf_fleet_msgs,
rmf_door_msgs, rmf_lift_msgs and tf2_msgs. On DDS the fields of a message have a fixed order and no
names.
"""

from dataclasses import dataclass, field
from types import new_class

from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int16, int32, sequence, uint8
from cyclonedds.idl.types import uint16, uint32, uint64


def message(package, kind="msg"):
    """Declares a message of a package of ROS."""

    def declare(cls):
        typename = f"{package}::{kind}::dds_::{cls.__name__}_"
        entries = {"__annotations__": cls.__annotations__, "__module__": cls.__module__}
        entries |= {name: cls.__dict__[name] for name in cls.__annotations__}
        return dataclass(
            new_class(cls.__name__, (IdlStruct,), {"typename": typename}, lambda it: it.update(entries))
        )

    return declare


def empty(kind):
    return field(default_factory=kind)


@message("builtin_interfaces")
class Time:
    sec: int32 = 0
    nanosec: uint32 = 0


@message("std_msgs")
class Header:
    stamp: Time = empty(Time)
    frame_id: str = ""


@message("geometry_msgs")
class Point:
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0


@message("geometry_msgs")
class Quaternion:
    x: float64 = 0.0
    y: float64 = 0.0
    z: float64 = 0.0
    w: float64 = 1.0


@message("geometry_msgs")
class Pose:
    position: Point = empty(Point)
    orientation: Quaternion = empty(Quaternion)


@message("geometry_msgs")
class PoseStamped:
    header: Header = empty(Header)
    pose: Pose = empty(Pose)


@message("geometry_msgs")
class Twist:
    linear: Point = empty(Point)
    angular: Point = empty(Point)


@message("geometry_msgs")
class Transform:
    translation: Point = empty(Point)
    rotation: Quaternion = empty(Quaternion)


@message("geometry_msgs")
class TransformStamped:
    header: Header = empty(Header)
    child_frame_id: str = ""
    transform: Transform = empty(Transform)


@message("tf2_msgs")
class TFMessage:
    transforms: sequence[TransformStamped] = empty(list)


# simulation_interfaces


@message("simulation_interfaces")
class Result:
    result: uint8 = 0
    error_message: str = ""


@message("simulation_interfaces")
class EntityCategory:
    category: uint8 = 0


@message("simulation_interfaces")
class TagsFilter:
    tags: sequence[str] = empty(list)
    filter_mode: uint8 = 0


@message("simulation_interfaces")
class Bounds:
    type: uint8 = 0
    points: sequence[Point] = empty(list)


@message("simulation_interfaces")
class EntityFilters:
    filter: str = ""
    categories: sequence[EntityCategory] = empty(list)
    tags: TagsFilter = empty(TagsFilter)
    bounds: Bounds = empty(Bounds)


@message("simulation_interfaces")
class EntityState:
    header: Header = empty(Header)
    pose: Pose = empty(Pose)
    twist: Twist = empty(Twist)
    acceleration: Twist = empty(Twist)


@message("simulation_interfaces")
class Resource:
    uri: str = ""
    resource_string: str = ""


@message("simulation_interfaces")
class SimulationState:
    state: uint8 = 0


@message("simulation_interfaces")
class SimulatorFeatures:
    features: sequence[uint16] = empty(list)
    spawn_formats: sequence[str] = empty(list)
    custom_info: str = ""


@message("simulation_interfaces", "srv")
class GetSimulatorFeatures_Request:
    structure_needs_at_least_one_member: uint8 = 0


@message("simulation_interfaces", "srv")
class GetSimulatorFeatures_Response:
    features: SimulatorFeatures = empty(SimulatorFeatures)


@message("simulation_interfaces", "srv")
class GetEntities_Request:
    filters: EntityFilters = empty(EntityFilters)


@message("simulation_interfaces", "srv")
class GetEntities_Response:
    result: Result = empty(Result)
    entities: sequence[str] = empty(list)


@message("simulation_interfaces", "srv")
class GetEntityState_Request:
    entity: str = ""


@message("simulation_interfaces", "srv")
class GetEntityState_Response:
    result: Result = empty(Result)
    state: EntityState = empty(EntityState)


@message("simulation_interfaces", "srv")
class SpawnEntity_Request:
    name: str = ""
    allow_renaming: bool = False
    entity_resource: Resource = empty(Resource)
    entity_namespace: str = ""
    initial_pose: PoseStamped = empty(PoseStamped)


@message("simulation_interfaces", "srv")
class SpawnEntity_Response:
    result: Result = empty(Result)
    entity_name: str = ""


@message("simulation_interfaces", "srv")
class DeleteEntity_Request:
    entity: str = ""


@message("simulation_interfaces", "srv")
class DeleteEntity_Response:
    result: Result = empty(Result)


@message("simulation_interfaces", "srv")
class GetSimulationState_Request:
    structure_needs_at_least_one_member: uint8 = 0


@message("simulation_interfaces", "srv")
class GetSimulationState_Response:
    state: SimulationState = empty(SimulationState)
    result: Result = empty(Result)


@message("simulation_interfaces", "srv")
class SetSimulationState_Request:
    state: SimulationState = empty(SimulationState)


@message("simulation_interfaces", "srv")
class SetSimulationState_Response:
    result: Result = empty(Result)


@message("simulation_interfaces", "srv")
class StepSimulation_Request:
    steps: uint64 = 1


@message("simulation_interfaces", "srv")
class StepSimulation_Response:
    result: Result = empty(Result)


# The action NavigateToPose of nav2_msgs, as of Jazzy


@message("unique_identifier_msgs")
class UUID:
    uuid: array[uint8, 16] = field(default_factory=lambda: [0] * 16)


@message("nav2_msgs", "action")
class NavigateToPose_Goal:
    pose: PoseStamped = empty(PoseStamped)
    behavior_tree: str = ""


@message("nav2_msgs", "action")
class NavigateToPose_Result:
    error_code: uint16 = 0


@message("nav2_msgs", "action")
class NavigateToPose_Feedback:
    current_pose: PoseStamped = empty(PoseStamped)
    navigation_time: Time = empty(Time)
    estimated_time_remaining: Time = empty(Time)
    number_of_recoveries: int16 = 0
    distance_remaining: float32 = 0.0


@message("nav2_msgs", "action")
class NavigateToPose_SendGoal_Request:
    goal_id: UUID = empty(UUID)
    goal: NavigateToPose_Goal = empty(NavigateToPose_Goal)


@message("nav2_msgs", "action")
class NavigateToPose_SendGoal_Response:
    accepted: bool = False
    stamp: Time = empty(Time)


@message("nav2_msgs", "action")
class NavigateToPose_GetResult_Request:
    goal_id: UUID = empty(UUID)


@message("nav2_msgs", "action")
class NavigateToPose_GetResult_Response:
    status: int8 = 0
    result: NavigateToPose_Result = empty(NavigateToPose_Result)


@message("nav2_msgs", "action")
class NavigateToPose_FeedbackMessage:
    goal_id: UUID = empty(UUID)
    feedback: NavigateToPose_Feedback = empty(NavigateToPose_Feedback)


@message("action_msgs")
class GoalInfo:
    goal_id: UUID = empty(UUID)
    stamp: Time = empty(Time)


@message("action_msgs", "srv")
class CancelGoal_Request:
    goal_info: GoalInfo = empty(GoalInfo)


@message("action_msgs", "srv")
class CancelGoal_Response:
    return_code: int8 = 0
    goals_canceling: sequence[GoalInfo] = empty(list)


# Open-RMF


@message("rmf_fleet_msgs")
class RobotMode:
    mode: uint32 = 0
    mode_request_id: uint64 = 0
    performing_action: str = ""


@message("rmf_fleet_msgs")
class Location:
    t: Time = empty(Time)
    x: float32 = 0.0
    y: float32 = 0.0
    yaw: float32 = 0.0
    obey_approach_speed_limit: bool = False
    approach_speed_limit: float32 = 0.0
    level_name: str = ""
    index: uint64 = 0


@message("rmf_fleet_msgs")
class RobotState:
    name: str = ""
    model: str = ""
    task_id: str = ""
    seq: uint64 = 0
    mode: RobotMode = empty(RobotMode)
    battery_percent: float32 = 0.0
    location: Location = empty(Location)
    path: sequence[Location] = empty(list)


@message("rmf_fleet_msgs")
class FleetState:
    name: str = ""
    robots: sequence[RobotState] = empty(list)


@message("rmf_fleet_msgs")
class PathRequest:
    fleet_name: str = ""
    robot_name: str = ""
    path: sequence[Location] = empty(list)
    task_id: str = ""


@message("rmf_fleet_msgs")
class ModeParameter:
    name: str = ""
    value: str = ""


@message("rmf_fleet_msgs")
class ModeRequest:
    fleet_name: str = ""
    robot_name: str = ""
    mode: RobotMode = empty(RobotMode)
    task_id: str = ""
    parameters: sequence[ModeParameter] = empty(list)


@message("rmf_door_msgs")
class DoorMode:
    value: uint32 = 0


@message("rmf_door_msgs")
class DoorState:
    door_time: Time = empty(Time)
    door_name: str = ""
    current_mode: DoorMode = empty(DoorMode)


@message("rmf_door_msgs")
class DoorRequest:
    request_time: Time = empty(Time)
    requester_id: str = ""
    door_name: str = ""
    requested_mode: DoorMode = empty(DoorMode)


@message("rmf_lift_msgs")
class LiftState:
    lift_time: Time = empty(Time)
    lift_name: str = ""
    available_floors: sequence[str] = empty(list)
    current_floor: str = ""
    destination_floor: str = ""
    door_state: uint8 = 0
    motion_state: uint8 = 0
    available_modes: sequence[uint8] = empty(list)
    current_mode: uint8 = 0
    session_id: str = ""


@message("rmf_lift_msgs")
class LiftRequest:
    lift_name: str = ""
    request_time: Time = empty(Time)
    session_id: str = ""
    request_type: uint8 = 0
    destination_floor: str = ""
    door_state: uint8 = 0
