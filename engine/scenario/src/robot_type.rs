//! Robot types and their batteries, and the ranges of their values.

use std::collections::BTreeSet;
use std::fmt;
use std::ops::RangeInclusive;

use regatta_layout::traffic;
use serde::{Deserialize, Deserializer, de};

use super::yaml::RobotTypeEntry;

/// The range of a robot's largest speed in metres per second.
const SPEEDS: RangeInclusive<f32> = 0.001..=1000.0;
/// The range of a robot's largest acceleration in metres per second squared. With less, a robot
/// would need minutes to get going, and the engine would look thousands of edges ahead for places
/// to brake at.
const ACCELERATIONS: RangeInclusive<f32> = 0.001..=1e6;
/// The range of a limit of rotation, in radians per second or radians per second squared.
const ROTATIONS: RangeInclusive<f32> = 0.001..=1000.0;
/// The range of capacities in watt-hours.
const CAPACITIES: RangeInclusive<f32> = 0.001..=1e6;
/// The range of powers in watts.
const POWERS: RangeInclusive<f32> = 0.0..=1e6;
/// The range of charges in per cent.
const CHARGES: RangeInclusive<f32> = 0.0..=100.0;

/// A type of robot, with everything that its robots have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotType {
    /// Name, for display.
    pub name: String,
    /// Footprint.
    pub shape: Shape,
    /// Metres along the heading; of a circle, its diameter.
    pub length: f32,
    /// Metres across it.
    pub width: f32,
    /// Metres per second, > 0; infinity if only edges limit the speed.
    pub max_speed: f32,
    /// Metres per second squared, > 0; infinity if the speed changes at once.
    pub max_acceleration: f32,
    /// Radians per second, ≥ 0; 0 if it can't turn on the spot.
    pub max_rotation_speed: f32,
    /// Radians per second squared, > 0; infinity if the rotation speed changes at once.
    pub max_rotation_acceleration: f32,
    /// `None` if it never needs charging.
    pub battery: Option<Battery>,
}

/// The footprint of a robot type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// A rectangle of `length` × `width`.
    #[default]
    Rectangle,
    /// A circle of diameter `length`.
    Circle,
}

/// The battery of a robot type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Battery {
    /// Watt-hours, > 0.
    pub capacity: f32,
    /// Watts that a robot takes while it drives or turns, ≥ 0.
    pub drain_moving: f32,
    /// Watts that it takes while it stands, ≥ 0.
    pub drain_standing: f32,
    /// Watts by which its charge grows while it stands idle at a charger, ≥ 0.
    pub charge_rate: f32,
    /// The charge at the start; full by default.
    #[serde(default = "full", deserialize_with = "charge")]
    pub charge: ChargeRange,
}

/// The charge of a battery in per cent, at random between two values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChargeRange {
    /// The least, from 0.
    pub min: f32,
    /// The most, to 100.
    pub max: f32,
}

fn full() -> ChargeRange {
    ChargeRange { min: 100.0, max: 100.0 }
}

/// Reads a charge: a number, or a map of `min` and `max`.
fn charge<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ChargeRange, D::Error> {
    deserializer.deserialize_any(ChargeVisitor)
}

struct ChargeVisitor;

impl<'de> de::Visitor<'de> for ChargeVisitor {
    type Value = ChargeRange;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("per cent, or a map with the keys min and max")
    }

    fn visit_u64<E>(self, percent: u64) -> Result<ChargeRange, E> {
        Ok(ChargeRange { min: percent as f32, max: percent as f32 })
    }

    fn visit_f64<E>(self, percent: f64) -> Result<ChargeRange, E> {
        Ok(ChargeRange { min: percent as f32, max: percent as f32 })
    }

    fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<ChargeRange, A::Error> {
        ChargeRange::deserialize(de::value::MapAccessDeserializer::new(map))
    }
}

/// Checks the values of robot types. Without any, there is one default type.
///
/// # Errors
/// If a value is out of range or missing, or if a name is used twice; the message names the type.
pub(super) fn robot_types(entries: Vec<RobotTypeEntry>) -> Result<Vec<RobotType>, String> {
    let mut robot_types = Vec::with_capacity(entries.len());
    for entry in entries {
        let name = entry.name.clone();
        robot_types.push(robot_type(entry).map_err(|message| format!("{name}: {message}"))?);
    }
    let names: BTreeSet<_> = robot_types.iter().map(|robot_type| &robot_type.name).collect();
    if names.len() < robot_types.len() || robot_types.len() > usize::from(u16::MAX) {
        return Err(format!("give each robot type a unique name, and list at most {}", u16::MAX));
    }
    if robot_types.is_empty() {
        robot_types.push(default_robot_type());
    }
    Ok(robot_types)
}

/// Returns the robot type of scenarios that list none.
fn default_robot_type() -> RobotType {
    let default = traffic::RobotType::default();
    RobotType {
        name: "amr".into(),
        shape: Shape::Rectangle,
        length: default.length() as f32,
        width: default.width() as f32,
        max_speed: f32::INFINITY,
        max_acceleration: f32::INFINITY,
        max_rotation_speed: 0.0,
        max_rotation_acceleration: f32::INFINITY,
        battery: None,
    }
}

fn robot_type(entry: RobotTypeEntry) -> Result<RobotType, String> {
    let max_speed = limit("max_speed", "m/s", entry.max_speed, SPEEDS)?;
    let max_acceleration =
        limit("max_acceleration", "m/s²", entry.max_acceleration, ACCELERATIONS)?;
    let max_rotation_speed = match entry.max_rotation_speed {
        None => 0.0,
        Some(value) => in_range("max_rotation_speed", "rad/s", value, ROTATIONS)?,
    };
    let rotation_acceleration = entry.max_rotation_acceleration;
    let max_rotation_acceleration =
        limit("max_rotation_acceleration", "rad/s²", rotation_acceleration, ROTATIONS)?;
    let length = entry.length;
    let width = match (entry.shape, entry.width) {
        (Shape::Rectangle, Some(width)) => width,
        (Shape::Rectangle, None) => {
            return Err("width is missing (only a circle has none)".to_owned());
        }
        (Shape::Circle, Some(width)) if width != length => {
            return Err("the length of a circle is its diameter; leave width out".to_owned());
        }
        (Shape::Circle, _) => length,
    };
    certificate_type(entry.shape, [length, width], max_rotation_speed)
        .map_err(|error| error.to_string())?;
    if let Some(battery) = &entry.battery {
        battery.check()?;
    }
    Ok(RobotType {
        name: entry.name,
        shape: entry.shape,
        length,
        width,
        max_speed,
        max_acceleration,
        max_rotation_speed,
        max_rotation_acceleration,
        battery: entry.battery,
    })
}

/// Returns the type as certificates of traffic describe it, which have the range of sizes. The
/// sizes are the length and the width in metres.
fn certificate_type(
    shape: Shape,
    sizes: [f32; 2],
    max_rotation_speed: f32,
) -> Result<traffic::RobotType, traffic::RobotTypeError> {
    let turns = max_rotation_speed > 0.0;
    let turning = if turns { traffic::Turning::OnTheSpot } else { traffic::Turning::Never };
    let [length, width] = sizes.map(micrometres);
    match shape {
        Shape::Rectangle => traffic::RobotType::new(length, width, turning),
        Shape::Circle => traffic::RobotType::round(length, turning),
    }
}

/// Rounds metres to micrometres: 0.9 in single precision is 0.9 then.
fn micrometres(metres: f32) -> f64 {
    (f64::from(metres) * 1e6).round() / 1e6
}

impl RobotType {
    /// Returns the type for a certificate of traffic.
    ///
    /// # Errors
    /// If a side is out of range, which no type of a scenario is.
    pub fn in_traffic(&self) -> Result<traffic::RobotType, traffic::RobotTypeError> {
        certificate_type(self.shape, [self.length, self.width], self.max_rotation_speed)
    }
}

/// Returns a limit, infinite if there is none.
fn limit(
    name: &str,
    unit: &str,
    value: Option<f32>,
    range: RangeInclusive<f32>,
) -> Result<f32, String> {
    value.map_or(Ok(f32::INFINITY), |value| in_range(name, unit, value, range))
}

fn in_range(name: &str, unit: &str, value: f32, range: RangeInclusive<f32>) -> Result<f32, String> {
    if range.contains(&value) {
        return Ok(value);
    }
    Err(format!("{name} is {value}; give {} to {} {unit}", range.start(), range.end()))
}

impl Battery {
    /// Checks the ranges of the values.
    fn check(&self) -> Result<(), String> {
        let ChargeRange { min, max } = self.charge;
        for (name, unit, value, range) in [
            ("battery, capacity", "Wh", self.capacity, CAPACITIES),
            ("battery, drain_moving", "W", self.drain_moving, POWERS),
            ("battery, drain_standing", "W", self.drain_standing, POWERS),
            ("battery, charge_rate", "W", self.charge_rate, POWERS),
            ("battery, charge", "per cent", min, CHARGES),
            ("battery, charge", "per cent", max, CHARGES),
        ] {
            in_range(name, unit, value, range)?;
        }
        if min > max {
            return Err(format!(
                "battery, charge is from {min} to {max} per cent; exchange min and max"
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(charge: &str) -> Result<Battery, String> {
        let text = format!(
            "{{capacity: 90, drain_moving: 60, drain_standing: 12.5, charge_rate: 600{charge}}}"
        );
        let battery: Battery = serde_yaml::from_str(&text).map_err(|error| error.to_string())?;
        battery.check().map(|()| battery)
    }

    #[test]
    fn a_battery_is_full_or_has_the_charge_that_the_scenario_gives_it() {
        for (text, min, max) in [
            ("", 100.0, 100.0),
            (", charge: 40", 40.0, 40.0),
            (", charge: 12.5", 12.5, 12.5),
            (", charge: {min: 20, max: 80}", 20.0, 80.0),
        ] {
            let battery = read(text).expect(text);
            assert_eq!(
                (battery.capacity, battery.drain_standing, battery.charge),
                (90.0, 12.5, ChargeRange { min, max })
            );
        }
    }

    #[test]
    fn a_charge_that_can_not_be_is_refused_with_its_name() {
        for (text, message) in [
            (", charge: 101", "battery, charge is 101"),
            (", charge: {min: 80, max: 20}", "exchange"),
            (", charge: .nan", "battery, charge is NaN"),
            (", charge: {min: 80}", "max"),
            (", charge: full", "per cent"),
            (", health: 80", "health"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(message), "{text}: {error}");
        }
        let flat = Battery {
            capacity: 0.0,
            drain_moving: 1.0,
            drain_standing: 1.0,
            charge_rate: 1.0,
            charge: full(),
        };
        assert!(flat.check().expect_err("no capacity").contains("capacity is 0; give"));
    }

    #[test]
    fn a_circle_is_round_in_traffic() {
        let entry = "{name: disc, shape: circle, length: 0.9, max_rotation_speed: 1}";
        let entry = serde_yaml::from_str(entry).expect("an entry");
        let robot = robot_type(entry).expect("a type").in_traffic().expect("a size");
        let round = traffic::RobotType::round(0.9, traffic::Turning::OnTheSpot);
        assert_eq!(robot, round.expect("a size"));
        assert_eq!(robot.in_words(), "round robots of 0.9 m");
        assert!((robot.area() - 0.6362).abs() < 1e-4 && robot.diameter() == 0.9);
    }
}
