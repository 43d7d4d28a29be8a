//! `rmf_fleet_msgs`, `rmf_door_msgs`, `rmf_lift_msgs` of Open-RMF.

use super::geometry::Time;

super::messages! {
    rmf_fleet_msgs struct RobotMode {
        mode: u32,
        mode_request_id: u64,
        performing_action: String,
    }

    /// A place on a level: metres, radians.
    rmf_fleet_msgs struct Location {
        t: Time,
        x: f32,
        y: f32,
        yaw: f32,
        obey_approach_speed_limit: bool,
        approach_speed_limit: f32,
        level_name: String,
        index: u64,
    }

    rmf_fleet_msgs struct RobotState {
        name: String,
        model: String,
        task_id: String,
        seq: u64,
        mode: RobotMode,
        battery_percent: f32,
        location: Location,
        path: Vec<Location>,
    }

    rmf_fleet_msgs struct FleetState {
        name: String,
        robots: Vec<RobotState>,
    }

    rmf_fleet_msgs struct PathRequest {
        fleet_name: String,
        robot_name: String,
        path: Vec<Location>,
        task_id: String,
    }

    rmf_fleet_msgs struct ModeParameter {
        name: String,
        value: String,
    }

    rmf_fleet_msgs struct ModeRequest {
        fleet_name: String,
        robot_name: String,
        mode: RobotMode,
        task_id: String,
        parameters: Vec<ModeParameter>,
    }

    rmf_door_msgs struct DoorMode {
        value: u32,
    }

    rmf_door_msgs struct DoorState {
        door_time: Time,
        door_name: String,
        current_mode: DoorMode,
    }

    rmf_door_msgs struct DoorRequest {
        request_time: Time,
        requester_id: String,
        door_name: String,
        requested_mode: DoorMode,
    }

    rmf_lift_msgs struct LiftState {
        lift_time: Time,
        lift_name: String,
        available_floors: Vec<String>,
        current_floor: String,
        destination_floor: String,
        door_state: u8,
        motion_state: u8,
        available_modes: Vec<u8>,
        current_mode: u8,
        session_id: String,
    }

    rmf_lift_msgs struct LiftRequest {
        lift_name: String,
        request_time: Time,
        session_id: String,
        request_type: u8,
        destination_floor: String,
        door_state: u8,
    }
}

/// Values of [`RobotMode`].
pub mod robot_mode {
    pub const IDLE: u32 = 0;
    pub const CHARGING: u32 = 1;
    pub const MOVING: u32 = 2;
    pub const PAUSED: u32 = 3;
    pub const WAITING: u32 = 4;
    pub const EMERGENCY: u32 = 5;
}

/// Values of [`DoorMode`].
pub mod door_mode {
    pub const CLOSED: u32 = 0;
    pub const MOVING: u32 = 1;
    pub const OPEN: u32 = 2;
}

/// Fields of [`LiftState`] and [`LiftRequest`].
pub mod lift {
    pub const DOOR_CLOSED: u8 = 0;
    pub const DOOR_MOVING: u8 = 1;
    pub const DOOR_OPEN: u8 = 2;
    pub const STOPPED: u8 = 0;
    pub const UP: u8 = 1;
    pub const DOWN: u8 = 2;
    pub const MODE_AGV: u8 = 2;
    pub const END_SESSION: u8 = 0;
}
