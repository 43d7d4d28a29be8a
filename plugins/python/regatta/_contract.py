"""The contract: everything that crosses a process boundary, as plain data.

The structures mirror those of the Rust crate ``regatta-plugin``, which documents their fields. ``layout.json`` beside
this file is generated from that crate. It holds the sizes and offsets that the tests compare these structures with, and
the quality of service with which :mod:`regatta._node` opens services.
"""

import ctypes
import json
from pathlib import Path
from typing import Annotated, Any, ClassVar, TypeVar, get_args, get_type_hints

import numpy as np

LAYOUT: dict[str, Any] = json.loads(Path(__file__).with_name("layout.json").read_text(encoding="utf-8"))
"""The contract as data."""

CONTRACT_VERSION: int = LAYOUT["contract_version"]
"""The version of the contract. Two processes communicate only if their versions are equal."""

NO_EDGE: int = LAYOUT["no_edge"]
"""The value of the column ``edge`` for a robot that is on no edge."""

NO_ROBOT: int = LAYOUT["no_robot"]
"""The ``robot`` of a record of the order log that belongs to no robot."""

BYTES_PER_LINE = 64
WORDS_PER_LINE = 16

u32 = Annotated[int, ctypes.c_uint32]
u64 = Annotated[int, ctypes.c_uint64]
f32 = Annotated[float, ctypes.c_float]
f64 = Annotated[float, ctypes.c_double]


class Record(ctypes.Structure):
    """Plain data whose type has the same name in Rust, with the prefix ``regatta_``."""

    _fields_: ClassVar[Any]

    @classmethod
    def type_name(cls) -> str:
        """Returns the name by which iceoryx2 compares types."""
        return f"regatta_{cls.__name__}"

    def __repr__(self) -> str:
        names = [name for name, *_ in self._fields_ if name != "reserved"]
        return f"{type(self).__name__}({', '.join(f'{name}={getattr(self, name)!r}' for name in names)})"


class Sequenced(Record):
    """A header that numbers the samples of a run."""

    @property
    def run_id(self) -> int:
        """The run that the sample belongs to."""
        raise NotImplementedError

    @property
    def sequence(self) -> int:
        """The number of the sample within its run, counted by the publisher from 1."""
        raise NotImplementedError


R = TypeVar("R", bound=type[Record])


def dtype(cls: type[Record]) -> np.dtype[np.void]:
    """Returns the numpy type of a record, with text as one value rather than as an array of characters."""
    names, formats, offsets = [], [], []
    for name, field in (np.dtype(cls).fields or {}).items():
        scalar = field[0]
        names.append(name)
        formats.append(np.dtype(f"S{scalar.itemsize}") if scalar.base.kind == "S" else scalar)
        offsets.append(field[1])
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": ctypes.sizeof(cls)})


def record(cls: R) -> R:
    """Lays out the annotated fields of a class, in the order of their annotations."""
    hints = get_type_hints(cls, include_extras=True)
    cls._fields_ = [(name, get_args(hints[name])[1]) for name in cls.__annotations__]
    return cls


@record
class Line(Record):
    """One cache line: sixteen 4-byte values."""

    words: Annotated[Any, ctypes.c_float * WORDS_PER_LINE]


@record
class FrameHeader(Sequenced):
    """The header of a frame."""

    run_id: u64
    tick: u64
    sequence: u64
    sim_time_nanos: u64
    wall_time_nanos: u64
    late_ticks: u64
    world_revision: u64
    tick_cost_nanos: u64
    tick_period_nanos: u64
    speed: f32
    robots: u32
    stride_lines: u32
    clock: u32
    lockstep: u32
    repeated: u32
    jumps: u64


@record
class WorldHeader(Sequenced):
    """The header of a world."""

    run_id: u64
    revision: u64
    origin: Annotated[Any, ctypes.c_double * 2]
    nodes: u32
    edges: u32
    curves: u32
    robot_types: u32
    text_bytes: u32
    zones: u32
    zone_members: u32
    other_names: u32
    doors: u32
    lifts: u32
    lift_levels: u32
    facility_members: u32
    stations: u32
    station_nodes: u32
    background_lines: u32
    background_points: u32

    @property
    def sequence(self) -> int:
        """The revision, which counts the worlds of a run from 1."""
        return self.revision


@record
class ZoneRecord(Record):
    """A group of nodes and edges with a rule for the robots in them."""

    name: u32
    rule: u32
    capacity: u32
    first_member: u32
    nodes: u32
    edges: u32


@record
class OtherNameRecord(Record):
    """A name of a node besides its own."""

    name: u32
    node: u32


@record
class StationRecord(Record):
    """A place that robots serve from nodes."""

    name: u32
    level: u32
    x: f32
    y: f32
    role: u32
    first_node: u32
    nodes: u32


@record
class BackgroundLineRecord(Record):
    """A wall, the outline of a floor or a rack."""

    level: u32
    first_point: u32
    points: u32


@record
class DoorRecord(Record):
    """A door across edges."""

    name: u32
    first_edge: u32
    edges: u32
    opening_secs: f32
    closing_secs: f32
    line: Annotated[Any, (ctypes.c_float * 2) * 2]


@record
class LiftRecord(Record):
    """A lift: a cabin that carries robots from level to level."""

    name: u32
    first_level: u32
    levels: u32
    first_ride: u32
    rides: u32
    capacity: u32
    level_secs: f32
    opening_secs: f32
    closing_secs: f32
    centre: Annotated[Any, ctypes.c_float * 2]
    size: Annotated[Any, ctypes.c_float * 2]
    yaw: f32


@record
class LiftLevelRecord(Record):
    """A level that a lift serves."""

    name: u32
    first_node: u32
    nodes: u32


@record
class NodeRecord(Record):
    """A node of the route graph."""

    id: u32
    x: f32
    y: f32
    theta: f32
    name: u32
    level: u32
    zone: u32
    role: u32


@record
class EdgeRecord(Record):
    """An edge of the route graph: one or more cubic Bézier curves."""

    id: u32
    origin: u32
    destination: u32
    length: f32
    first_curve: u32
    curves: u32
    speed: f32
    reverse_speed: f32
    name: u32
    level: u32
    zone: u32
    orientation: u32
    orientation_angle: f32
    reserved: Annotated[Any, ctypes.c_uint32 * 3]


@record
class CurveRecord(Record):
    """A cubic Bézier curve."""

    control_points: Annotated[Any, ctypes.c_float * 2 * 4]


@record
class RobotTypeRecord(Record):
    """A robot type."""

    name: Annotated[bytes, ctypes.c_char * 36]
    shape: u32
    length: f32
    width: f32
    max_speed: f32
    max_acceleration: f32
    max_rotation_speed: f32
    max_rotation_acceleration: f32
    battery_capacity: f32
    drain_moving: f32
    drain_standing: f32
    charge_rate: f32


@record
class ColumnHeader(Sequenced):
    """The header of a column."""

    run_id: u64
    tick: u64
    sequence: u64
    robots: u32
    cost_micros: u32


@record
class CommandHeader(Record):
    """The header of commands: their sender."""

    sender: u64


@record
class CommandRecord(Record):
    """One command, or one leg of the route of the command before it."""

    token: u64
    kind: u32
    robot: u32
    legs: u32
    id: u32
    reverse: u32
    released: u32
    robot_type: u32
    s: f32


@record
class CommandLogHeader(Sequenced):
    """The header of the commands that took effect in one tick."""

    run_id: u64
    tick: u64
    sequence: u64


@record
class EventHeader(Sequenced):
    """The header of the events of one tick. ``dropped`` counts those that were left out because there were too many."""

    run_id: u64
    tick: u64
    dropped: u64
    sequence: u64


@record
class EventRecord(Record):
    """One event."""

    token: u64
    kind: u32
    robot: u32
    id: u32
    detail: u32


@record
class OrderHeader(Sequenced):
    """The header of the order log's records of one tick. ``dropped`` counts those that were left out because there were too
    many."""

    run_id: u64
    tick: u64
    dropped: u64
    sequence: u64


@record
class OrderRecord(Record):
    """Something that happened to an order."""

    order: u64
    kind: u32
    robot: u32
    stop: u32
    node: u32
    action: u32
    dwell_secs: f32
    detail: u32
    due_secs: f32


@record
class TrafficHeader(Sequenced):
    """The header of the traffic on edges, with the lengths of its periods in simulated seconds."""

    run_id: u64
    tick: u64
    sim_time_nanos: u64
    world_revision: u64
    sequence: u64
    period_secs: Annotated[Any, ctypes.c_float * 3]
    edges: u32
    has_contacts: u32
    has_routes: u32


@record
class EdgeTraffic(Record):
    """The figures of an edge in a period."""

    occupancy: f32
    entered_per_hour: f32
    relative_speed: f32
    waiting_secs: f32
    contact_secs: f32
    released: f32
    planned: f32


@record
class HistoryHeader(Sequenced):
    """The header of the history of a run so far: of its figures over time, and of its hot spots."""

    run_id: u64
    tick: u64
    sim_time_nanos: u64
    began_nanos: u64
    sequence: u64


@record
class FleetSample(Record):
    """The figures of a fleet at a time."""

    secs: f64
    activities: Annotated[Any, ctypes.c_uint32 * 13]
    touching: u32
    throughput: f32
    mean_speed: f32


@record
class HotSpot(Record):
    """A place where robots lose time."""

    contact_secs: f64
    standing_secs: f64
    seen: Annotated[Any, ctypes.c_double * 2]
    x: f32
    y: f32
    edges: Annotated[Any, ctypes.c_uint32 * 4]
    trend: u32
    reserved: u32


@record
class ContactHeader(Sequenced):
    """The header of the contacts of one frame, with totals."""

    run_id: u64
    tick: u64
    sim_time_nanos: u64
    touching_ever: u64
    possible_ever: u64
    frames_skipped: u64
    sequence: u64
    touching: u32
    possible: u32
    capped: u32
    reserved: u32


@record
class ContactRecord(Record):
    """A pair of robots that touch, or may."""

    since_tick: u64
    since_nanos: u64
    robots: Annotated[Any, ctypes.c_uint32 * 2]
    level: u32
    edge: u32
    x: f32
    y: f32
    relative_speed: f32
    reserved: u32


@record
class ContactEventHeader(Sequenced):
    """The header of the contacts that began or ended in one tick."""

    run_id: u64
    tick: u64
    sequence: u64


@record
class ContactEvent(Record):
    """A pair that reached a level, or left it."""

    tick: u64
    sim_time_nanos: u64
    robots: Annotated[Any, ctypes.c_uint32 * 2]
    level: u32
    change: u32
    edge: u32
    x: f32
    y: f32
    relative_speed: f32


@record
class ControlRequest(Record):
    """A request to the engine."""

    count: u64
    kind: u32
    speed: f32


@record
class ControlResponse(Record):
    """The answer to a request: whether it was carried out, and the status after it."""

    run_id: u64
    tick: u64
    sim_time_nanos: u64
    late_ticks: u64
    tick_cost_p50_nanos: u64
    tick_cost_p99_nanos: u64
    resident_bytes: u64
    wall_time_nanos: u64
    robots_by_state: Annotated[Any, ctypes.c_uint32 * 8]
    robots: u32
    pid: u32
    clock: u32
    speed: f32
    real_time_factor: f32
    accepted: u32
    reason: Annotated[bytes, ctypes.c_char * 128]
    owner: Annotated[bytes, ctypes.c_char * 96]


@record
class RouteRequest(Record):
    """A request for the route of a robot."""

    robot: u32
    reserved: u32


@record
class RouteResponse(Record):
    """The remaining route of a robot: its first legs as indices of edges, with bit 31 set in reverse gear."""

    run_id: u64
    tick: u64
    robot: u32
    found: u32
    legs: u32
    released: u32
    released_metres: f32
    reserved: u32
    listed: Annotated[Any, ctypes.c_uint32 * 256]


@record
class ManagerRequest(Record):
    """A request to the fleet manager."""

    kind: u32
    robot: u32
    node: u32
    reserved: u32


@record
class ManagerResponse(Record):
    """The fleet manager's answer."""

    order: u64
    answer: u32
    robot: u32


@record
class ClosureHeader(Sequenced):
    """The header of the closed edges."""

    run_id: u64
    tick: u64
    sequence: u64


@record
class ClosedEdge(Record):
    """An edge that no robot may enter."""

    edge: u32


@record
class FacilityHeader(Sequenced):
    """The header of the states of doors and lifts."""

    run_id: u64
    tick: u64
    sequence: u64


@record
class FacilityState(Record):
    """The state of a door or a lift."""

    since_tick: u64
    ticks: u32
    kind: u32
    index: u32
    door: u32
    level: u32
    next_level: u32
    called_level: u32
    robot: u32
    requests: u32
    reserved: u32


@record
class WorkHeader(Sequenced):
    """The header of the figures of the fleet's work."""

    run_id: u64
    tick: u64
    sequence: u64


@record
class WorkFigures(Record):
    """The figures of the fleet's work so far, from the fleet manager."""

    secs: f64
    finished: u64
    open: u64
    failed: u64
    orders_per_hour: f32
    service_p50_secs: f32
    service_p99_secs: f32
    waiting: f32
    busy: u32
    robots: u32


@record
class RecordingHeader(Sequenced):
    """The description of a recording that is replayed. Times are nanoseconds on the recording's clock, which is
    ``ahead_nanos`` ahead of the simulated time of the run's frames."""

    run_id: u64
    sequence: u64
    start_nanos: u64
    end_nanos: u64
    ahead_nanos: u64
    searched_nanos: u64
    left_out: u64
    file: Annotated[bytes, ctypes.c_char * 128]
    note: Annotated[bytes, ctypes.c_char * 128]


@record
class RecordingMark(Record):
    """An incident in a recording."""

    time_nanos: u64
    kind: u32
    robot: u32
    count: u32
    reserved: u32


@record
class Done(Record):
    """The report of a reader, in lockstep, that it has finished a tick."""

    run_id: u64
    tick: u64
    name: Annotated[bytes, ctypes.c_char * 64]
