//! The services of `simulation_interfaces` (2.1), `std_srvs`.

use super::geometry::{Accel, Header, Pose, PoseStamped, Twist, Vector3};

super::messages! {
    /// A request without fields: it has a byte.
    rosidl struct Empty {
        structure_needs_at_least_one_member: u8,
    }

    std_srvs struct SetBoolRequest {
        data: bool,
    }

    std_srvs struct SetBoolResponse {
        success: bool,
        message: String,
    }

    simulation_interfaces struct Result {
        result: u8,
        error_message: String,
    }

    simulation_interfaces struct EntityCategory {
        category: u8,
    }

    simulation_interfaces struct TagsFilter {
        tags: Vec<String>,
        filter_mode: u8,
    }

    simulation_interfaces struct Bounds {
        r#type: u8,
        points: Vec<Vector3>,
    }

    simulation_interfaces struct EntityFilters {
        filter: String,
        categories: Vec<EntityCategory>,
        tags: TagsFilter,
        bounds: Bounds,
    }

    simulation_interfaces struct EntityState {
        header: Header,
        pose: Pose,
        twist: Twist,
        acceleration: Accel,
    }

    simulation_interfaces struct Resource {
        uri: String,
        resource_string: String,
    }

    simulation_interfaces struct SimulationState {
        state: u8,
    }

    simulation_interfaces struct SimulatorFeatures {
        features: Vec<u16>,
        spawn_formats: Vec<String>,
        custom_info: String,
    }

    simulation_interfaces struct GetEntitiesRequest {
        filters: EntityFilters,
    }

    simulation_interfaces struct GetEntitiesResponse {
        result: Result,
        entities: Vec<String>,
    }

    simulation_interfaces struct EntityRequest {
        entity: String,
    }

    simulation_interfaces struct GetEntityStateResponse {
        result: Result,
        state: EntityState,
    }

    simulation_interfaces struct SpawnEntityRequest {
        name: String,
        allow_renaming: bool,
        entity_resource: Resource,
        entity_namespace: String,
        initial_pose: PoseStamped,
    }

    simulation_interfaces struct SpawnEntityResponse {
        result: Result,
        entity_name: String,
    }

    simulation_interfaces struct StepSimulationRequest {
        steps: u64,
    }

    /// The response of services that only succeed or fail.
    simulation_interfaces struct ResultResponse {
        result: Result,
    }

    simulation_interfaces struct SetSimulationStateRequest {
        state: SimulationState,
    }

    simulation_interfaces struct GetSimulationStateResponse {
        state: SimulationState,
        result: Result,
    }

    simulation_interfaces struct GetSimulatorFeaturesResponse {
        features: SimulatorFeatures,
    }
}

/// Codes of a [`Result`].
pub mod code {
    pub const FEATURE_UNSUPPORTED: u8 = 0;
    pub const OK: u8 = 1;
    pub const NOT_FOUND: u8 = 2;
    pub const OPERATION_FAILED: u8 = 4;
    /// Of `SetSimulationState`.
    pub const ALREADY_IN_TARGET_STATE: u8 = 101;
    /// Of `SetSimulationState`.
    pub const INCORRECT_TRANSITION: u8 = 103;
    /// Of `SpawnEntity`.
    pub const NAME_INVALID: u8 = 102;
    /// Of `SpawnEntity`.
    pub const UNSUPPORTED_FORMAT: u8 = 103;
    /// Of `SpawnEntity`.
    pub const INVALID_POSE: u8 = 109;
}

/// States of a [`SimulationState`].
pub mod state {
    pub const STOPPED: u8 = 0;
    pub const PLAYING: u8 = 1;
    pub const PAUSED: u8 = 2;
    pub const QUITTING: u8 = 3;
    pub const NO_WORLD: u8 = 4;
}

/// Features of [`SimulatorFeatures`].
pub mod feature {
    pub const SPAWNING: u16 = 0;
    pub const DELETING: u16 = 1;
    pub const ENTITY_BOUNDS_BOX: u16 = 6;
    pub const ENTITY_CATEGORIES: u16 = 8;
    pub const ENTITY_STATE_GETTING: u16 = 10;
    pub const SIMULATION_STATE_GETTING: u16 = 24;
    pub const SIMULATION_STATE_SETTING: u16 = 25;
    pub const SIMULATION_STATE_PAUSE: u16 = 26;
    pub const STEP_SIMULATION_SINGLE: u16 = 31;
    pub const STEP_SIMULATION_MULTIPLE: u16 = 32;
}

impl Result {
    /// Success.
    pub fn ok() -> Self {
        Self { result: code::OK, error_message: String::new() }
    }

    /// A failure, by its code.
    pub fn failed(result: u8, reason: impl ToString) -> Self {
        Self { result, error_message: reason.to_string() }
    }
}
