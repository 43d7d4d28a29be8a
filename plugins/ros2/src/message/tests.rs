//! Messages against samples of ROS 2 itself and of Cyclone DDS.

use std::process::Command;

use ros2_client::dds::rustdds::RepresentationIdentifier;
use ros2_client::dds::rustdds::serialization::{
    deserialize_from_cdr_with_rep_id, to_writer_with_rep_id,
};
use serde_json::{Value, json};

use super::Typed;
use super::display::*;
use super::geometry::*;
use super::navigation::*;
use super::open_rmf::*;
use super::simulation::*;

const CDR: RepresentationIdentifier = RepresentationIdentifier::CDR_LE;
/// Bytes of the header before the fields of a sample.
const HEADER: usize = 4;

/// Decodes a message; the fields as JSON, and its bytes when it is encoded again.
type Decode = fn(&[u8]) -> Option<(Value, Vec<u8>)>;

fn decode<M: Typed>(bytes: &[u8]) -> Option<(Value, Vec<u8>)> {
    let (message, _) = deserialize_from_cdr_with_rep_id::<M>(bytes, CDR).ok()?;
    let mut encoded = Vec::new();
    to_writer_with_rep_id(&mut encoded, &message, CDR).expect("encoded");
    Some((serde_json::to_value(&message).expect("JSON"), encoded))
}

/// Returns the code for a type by its name in ROS.
fn decoder(name: &str) -> Option<Decode> {
    Some(match name {
        "builtin_interfaces/Time" => decode::<Time>,
        "builtin_interfaces/Duration" => decode::<Duration>,
        "rcl_interfaces/Log" => decode::<Log>,
        "rosgraph_msgs/Clock" => decode::<Clock>,
        "std_msgs/Header" => decode::<Header>,
        "std_msgs/Float64" => decode::<Float64>,
        "std_msgs/ColorRGBA" => decode::<ColorRGBA>,
        "geometry_msgs/PoseStamped" => decode::<PoseStamped>,
        "geometry_msgs/PoseArray" => decode::<PoseArray>,
        "geometry_msgs/Twist" => decode::<Twist>,
        "geometry_msgs/Accel" => decode::<Accel>,
        "geometry_msgs/TransformStamped" => decode::<TransformStamped>,
        "tf2_msgs/TFMessage" => decode::<TFMessage>,
        "nav_msgs/Odometry" => decode::<Odometry>,
        "nav_msgs/OccupancyGrid" => decode::<OccupancyGrid>,
        "visualization_msgs/MarkerArray" => decode::<MarkerArray>,
        "diagnostic_msgs/DiagnosticArray" => decode::<DiagnosticArray>,
        "simulation_interfaces/GetSimulatorFeatures_Request" => decode::<Empty>,
        "simulation_interfaces/GetSimulatorFeatures_Response" => {
            decode::<GetSimulatorFeaturesResponse>
        }
        "simulation_interfaces/GetEntities_Request" => decode::<GetEntitiesRequest>,
        "simulation_interfaces/GetEntities_Response" => decode::<GetEntitiesResponse>,
        "simulation_interfaces/GetEntityState_Request" => decode::<EntityRequest>,
        "simulation_interfaces/GetEntityState_Response" => decode::<GetEntityStateResponse>,
        "simulation_interfaces/SpawnEntity_Request" => decode::<SpawnEntityRequest>,
        "simulation_interfaces/SpawnEntity_Response" => decode::<SpawnEntityResponse>,
        "simulation_interfaces/DeleteEntity_Request" => decode::<EntityRequest>,
        "simulation_interfaces/DeleteEntity_Response" => decode::<ResultResponse>,
        "simulation_interfaces/GetSimulationState_Request" => decode::<Empty>,
        "simulation_interfaces/GetSimulationState_Response" => decode::<GetSimulationStateResponse>,
        "simulation_interfaces/SetSimulationState_Request" => decode::<SetSimulationStateRequest>,
        "simulation_interfaces/SetSimulationState_Response" => decode::<ResultResponse>,
        "simulation_interfaces/StepSimulation_Request" => decode::<StepSimulationRequest>,
        "simulation_interfaces/StepSimulation_Response" => decode::<ResultResponse>,
        "nav2_msgs/NavigateToPose_Goal" => decode::<NavigateToPoseGoal>,
        "rmf_fleet_msgs/FleetState" => decode::<FleetState>,
        "rmf_fleet_msgs/PathRequest" => decode::<PathRequest>,
        "rmf_fleet_msgs/ModeRequest" => decode::<ModeRequest>,
        "rmf_door_msgs/DoorState" => decode::<DoorState>,
        "rmf_door_msgs/DoorRequest" => decode::<DoorRequest>,
        "rmf_lift_msgs/LiftState" => decode::<LiftState>,
        "rmf_lift_msgs/LiftRequest" => decode::<LiftRequest>,
        _ => return None,
    })
}

/// The types with a decoder of their own.
const TYPES: usize = 41;

/// Returns the samples that `layouts.py` prints: type, bytes, fields; none without Python and ROS.
fn samples() -> Vec<(String, Vec<u8>, Value)> {
    let Some(python) = std::env::var_os("REGATTA_ROS2_PYTHON") else {
        println!("skipped: REGATTA_ROS2_PYTHON names no Python with rclpy (see requirements.txt)");
        return Vec::new();
    };
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/layouts.py");
    let mut command = Command::new(python);
    command.arg(script).env("PYTHONDONTWRITEBYTECODE", "1");
    let output = command.output().expect("Python starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let samples = text.lines().map(|line| {
        let mut words = line.splitn(3, ' ');
        let mut word = || words.next().expect("three words");
        let (name, hex, fields) = (word().to_owned(), word(), word());
        let bytes = (0..hex.len()).step_by(2);
        let bytes = bytes.map(|at| u8::from_str_radix(&hex[at..at + 2], 16).expect("hex"));
        (name, bytes.skip(HEADER).collect(), serde_json::from_str(fields).expect("JSON"))
    });
    samples.collect()
}

/// Turns the rows of covariances into one list.
fn flat(value: Value) -> Value {
    match value {
        Value::Object(fields) => {
            let fields = fields.into_iter().map(|(name, value)| match value {
                Value::Array(rows) if name == "covariance" => {
                    let numbers = rows.iter().flat_map(|row| row.as_array().expect("a row"));
                    (name, json!(numbers.collect::<Vec<_>>()))
                }
                value => (name, flat(value)),
            });
            fields.collect()
        }
        Value::Array(values) => values.into_iter().map(flat).collect(),
        other => other,
    }
}

#[test]
fn messages_have_the_fields_of_their_definitions() {
    let samples = samples();
    let mut compared = 0;
    for (name, bytes, fields) in &samples {
        let Some(decode) = decoder(name) else { continue };
        let (found, encoded) = decode(bytes).unwrap_or_else(|| panic!("{name} isn't decoded"));
        assert_eq!(flat(found), *fields, "{name}");
        // The bytes between fields are any, and samples may be padded to four bytes.
        let (again, _) = decode(&encoded).expect("decoded");
        assert_eq!(flat(again), *fields, "{name}");
        let padding = bytes.len() - encoded.len();
        assert!(padding < 4, "{name}: {padding} bytes are missing");
        compared += 1;
    }
    // Some types are in both packages.
    assert!(samples.is_empty() || compared >= TYPES, "{compared} types");
}

#[test]
fn malformed_messages_are_no_messages() {
    let goal = PoseStamped { header: Header::new(&Time::default(), "map"), ..Default::default() };
    let mut bytes = Vec::new();
    to_writer_with_rep_id(&mut bytes, &goal, CDR).expect("encoded");
    let decoders = [
        "geometry_msgs/PoseStamped",
        "simulation_interfaces/GetEntities_Request",
        "simulation_interfaces/SpawnEntity_Request",
        "nav2_msgs/NavigateToPose_Goal",
        "rmf_fleet_msgs/PathRequest",
        "rmf_fleet_msgs/ModeRequest",
        "rmf_door_msgs/DoorRequest",
        "rmf_lift_msgs/LiftRequest",
    ];
    for decode in decoders.map(|name| decoder(name).expect("a decoder")) {
        for length in 0..bytes.len() {
            decode(&bytes[..length]);
            for value in [0, 1, 0x7f, 0x80, 0xff] {
                let mut changed = bytes.clone();
                changed[length..].fill(value);
                decode(&changed);
            }
        }
    }
    assert!(
        decode::<PoseStamped>(&bytes).is_some() && decode::<PoseStamped>(&bytes[..40]).is_none()
    );
    // A list of four billion elements in eight bytes takes no memory.
    assert!(decode::<PathRequest>(&[0xff; 24]).is_none());
}
