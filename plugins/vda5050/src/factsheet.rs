//! The factsheet of a robot type.

use regatta_plugin::world::RobotTypeRecord;

use crate::client::Intervals;
use crate::message::{
    Factsheet, PhysicalParameters, ProtocolFeatures, ProtocolLimits, Timing, TypeSpecification,
    Version,
};
use crate::vehicle::Catalogue;

/// The height that vehicles are said to have, in metres: robot types have none.
const HEIGHT: f64 = 1.0;
/// Stands for no limit: schemas have no infinity.
const NO_LIMIT: f64 = 1e6;

/// Returns the factsheet of a robot type, without its header.
pub fn factsheet(
    robot_type: &RobotTypeRecord,
    catalogue: &Catalogue,
    intervals: Intervals,
    version: Version,
) -> Factsheet {
    let timing = Timing {
        minimum_order_interval: 0.0,
        minimum_state_interval: 0.0,
        default_state_interval: Some(intervals.state),
        visualization_interval: Some(intervals.visualization).filter(|every| *every > 0.0),
    };
    Factsheet {
        type_specification: TypeSpecification {
            series_name: robot_type.name().to_owned(),
            series_description: Some("a simulated robot of Regatta".to_owned()),
            mobile_robot_kinematics: "DIFF".to_owned(),
            mobile_robot_class: "CARRIER".to_owned(),
            maximum_load_mass: 1000.0,
            localization_types: vec!["NATURAL".to_owned()],
            navigation_types: vec!["VIRTUAL_LINE_GUIDED".to_owned()],
        },
        physical_parameters: physical_parameters(robot_type),
        protocol_limits: ProtocolLimits { timing, ..ProtocolLimits::default() },
        protocol_features: ProtocolFeatures {
            mobile_robot_actions: catalogue.supported(version),
            ..ProtocolFeatures::default()
        },
        ..Factsheet::default()
    }
}

fn physical_parameters(robot_type: &RobotTypeRecord) -> PhysicalParameters {
    let acceleration = limited(robot_type.max_acceleration);
    PhysicalParameters {
        minimum_speed: 0.0,
        maximum_speed: limited(robot_type.max_speed),
        maximum_angular_speed: Some(limited(robot_type.max_rotation_speed)),
        maximum_acceleration: acceleration,
        maximum_deceleration: acceleration,
        minimum_height: HEIGHT,
        maximum_height: HEIGHT,
        width: limited(robot_type.width),
        length: limited(robot_type.length),
    }
}

fn limited(value: f32) -> f64 {
    (f64::from(value).clamp(0.0, NO_LIMIT) * 1e6).round() / 1e6
}
