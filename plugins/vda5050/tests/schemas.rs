//! Each message is valid by the official schema of its version.

use std::path::Path;

use boon::{Compiler, Schemas};
use proptest::prelude::*;
use regatta_vda5050::message::*;

/// The schema of a topic in a version. 2.0 has none for the factsheet: that of 2.1 is meant.
fn schema(topic: Topic, version: Version) -> std::path::PathBuf {
    let folder = match (topic, version) {
        (Topic::Factsheet, Version::V2_0) => Version::V2_1.number(),
        _ => version.number(),
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/schemas").join(folder);
    folder.join(format!("{}.schema", topic.name()))
}

/// Checks a message in a version.
fn check<M: Message + Clone>(message: &M, version: Version) -> Result<(), String> {
    let mut message = message.clone();
    message.adapt(version);
    let json = encode(&message, version);
    let value = serde_json::from_slice(&json).map_err(|error| error.to_string())?;
    let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
    compiler.enable_format_assertions();
    let path = schema(M::TOPIC, version);
    let schema = compiler
        .compile(&path.display().to_string(), &mut schemas)
        .map_err(|error| error.to_string())?;
    schemas.validate(&value, schema).map_err(|error| format!("{version} {error:#}\n{value}"))
}

fn header() -> Header {
    Header {
        header_id: 4,
        timestamp: timestamp(std::time::SystemTime::UNIX_EPOCH),
        version: "2.0.0".to_owned(),
        manufacturer: "regatta".to_owned(),
        serial_number: "0001".to_owned(),
    }
}

fn trajectory(points: usize) -> Trajectory {
    let points = (0..points).map(|x| ControlPoint { x: x as f64, y: 0.5, weight: None });
    Trajectory { degree: None, knot_vector: None, control_points: points.collect() }
}

fn action_state(status: ActionStatus) -> ActionState {
    ActionState {
        action_id: "a".to_owned(),
        action_type: Some("pick".to_owned()),
        action_descriptor: Some("one".to_owned()),
        action_status: status,
        action_result: Some("done".to_owned()),
    }
}

fn error(level: ErrorLevel) -> Error {
    Error {
        error_type: "VALIDATION_FAILURE".to_owned(),
        error_references: vec![Reference::new("orderId", "o")],
        error_description: Some("text".to_owned()),
        error_hint: Some("hint".to_owned()),
        error_level: level,
    }
}

fn action(blocking_type: BlockingType) -> Action {
    let parameter = ActionParameter { key: "k".into(), value: serde_json::json!([1, "x"]) };
    Action {
        action_type: "pick".to_owned(),
        action_id: "a".to_owned(),
        action_descriptor: Some("one".to_owned()),
        blocking_type,
        action_parameters: vec![parameter],
        retriable: Some(true),
    }
}

prop_compose! {
    fn states()(
        status in prop::sample::select(vec![
            ActionStatus::Waiting, ActionStatus::Initializing, ActionStatus::Running,
            ActionStatus::Paused, ActionStatus::Retriable, ActionStatus::Finished,
            ActionStatus::Failed,
        ]),
        level in prop::sample::select(vec![
            ErrorLevel::Warning, ErrorLevel::Urgent, ErrorLevel::Critical, ErrorLevel::Fatal,
        ]),
        mode in prop::sample::select(vec![
            OperatingMode::Startup, OperatingMode::Automatic, OperatingMode::SemiAutomatic,
            OperatingMode::Intervened, OperatingMode::Manual, OperatingMode::Service,
            OperatingMode::TeachIn,
        ]),
        stop in prop::sample::select(vec![
            EmergencyStop::AutoAcknowledged, EmergencyStop::Manual, EmergencyStop::None,
        ]),
        points in 2..5_usize,
        full in any::<bool>(),
        x in -1e6..1e6_f64,
    ) -> State {
        let position = NodePosition { x, map_id: "m".to_owned(), ..NodePosition::default() };
        let node = NodeState { node_position: full.then_some(position), ..NodeState::default() };
        let edge = EdgeState { trajectory: full.then(|| trajectory(points)), ..Default::default() };
        State {
            header: header(),
            node_states: vec![node],
            edge_states: vec![edge],
            mobile_robot_position: full.then(|| Position { x, ..Position::default() }),
            velocity: full.then_some(Velocity { vx: Some(x), ..Velocity::default() }),
            loads: full.then(|| vec![Load::default()]),
            paused: Some(full),
            action_states: vec![action_state(status)],
            instant_action_states: full.then(|| vec![action_state(status)]),
            operating_mode: mode,
            errors: vec![error(level)],
            information: full.then(|| vec![Info {
                info_type: "t".to_owned(),
                info_references: vec![Reference::new("orderId", "o")],
                info_descriptor: Some("text".to_owned()),
                info_level: InfoLevel::Debug,
            }]),
            safety_state: SafetyState { active_emergency_stop: stop, field_violation: full },
            zone_set_id: full.then(|| "z".to_owned()),
            ..State::default()
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn states_are_valid(state in states()) {
        for version in Version::ALL {
            prop_assert_eq!(check(&state, version), Ok(()));
        }
    }
}

#[test]
fn orders_are_valid() {
    let types = [BlockingType::None, BlockingType::Soft, BlockingType::Single, BlockingType::Hard];
    let deviations = [
        AllowedDeviation::Radius(0.5),
        AllowedDeviation::Ellipse(Ellipse { a: 2.0, b: 1.0, theta: 0.5 }),
    ];
    for (blocking, deviation) in types.into_iter().zip(deviations.into_iter().cycle()) {
        let position = NodePosition {
            theta: Some(1.0),
            allowed_deviation: Some(deviation),
            map_id: "m".to_owned(),
            ..NodePosition::default()
        };
        let node = |sequence_id| Node {
            node_id: "n".to_owned(),
            sequence_id,
            released: true,
            node_position: Some(position.clone()),
            actions: vec![action(blocking)],
            ..Node::default()
        };
        let corridor = Corridor {
            left_width: 1.0,
            right_width: 1.0,
            corridor_reference_point: Some(CorridorReference::KinematicCenter),
            release_required: Some(true),
            release_loss_behavior: Some(LossBehavior::Stop),
        };
        let edge = Edge {
            edge_id: "e".to_owned(),
            sequence_id: 1,
            maximum_speed: Some(1.0),
            orientation_type: Some(OrientationType::Global),
            trajectory: Some(trajectory(3)),
            corridor: Some(corridor),
            actions: vec![action(blocking)],
            ..Edge::default()
        };
        let order = Order {
            header: header(),
            nodes: vec![node(0), node(2)],
            edges: vec![edge],
            ..Order::default()
        };
        for version in Version::ALL {
            assert_eq!(check(&order, version), Ok(()));
        }
    }
}

#[test]
fn small_messages_are_valid() {
    for version in Version::ALL {
        for connection_state in [
            ConnectionState::Online,
            ConnectionState::Offline,
            ConnectionState::Hibernating,
            ConnectionState::ConnectionBroken,
        ] {
            let connection = Connection { header: header(), connection_state };
            assert_eq!(check(&connection, version), Ok(()));
        }
        let position = Some(Position::default());
        let seen = Visualization {
            header: header(),
            mobile_robot_position: position,
            ..Visualization::default()
        };
        assert_eq!(check(&seen, version), Ok(()));
    }
    // The schema of 2.0 asks for `actionName`, against the text of 2.0: actions have `actionType`.
    let actions = InstantActions { header: header(), actions: vec![action(BlockingType::None)] };
    for version in [Version::V2_1, Version::V3_0] {
        assert_eq!(check(&actions, version), Ok(()));
    }
}

#[test]
fn a_factsheet_is_valid() {
    let supported = SupportedAction {
        action_type: "pick".to_owned(),
        action_scopes: vec![ActionScope::Node, ActionScope::Edge, ActionScope::Zone],
        blocking_types: Some(vec![BlockingType::None, BlockingType::Single]),
        pause_allowed: Some(true),
        cancel_allowed: Some(false),
    };
    let kind = TypeSpecification {
        mobile_robot_kinematics: "DIFF".to_owned(),
        mobile_robot_class: "CARRIER".to_owned(),
        localization_types: vec!["NATURAL".to_owned()],
        navigation_types: vec!["VIRTUAL_LINE_GUIDED".to_owned()],
        ..TypeSpecification::default()
    };
    let features =
        ProtocolFeatures { mobile_robot_actions: vec![supported], ..ProtocolFeatures::default() };
    let factsheet = Factsheet {
        header: header(),
        type_specification: kind,
        protocol_features: features,
        ..Factsheet::default()
    };
    for version in Version::ALL {
        assert_eq!(check(&factsheet, version), Ok(()));
    }
}
