//! The battery of a robot type in a scenario file.

use std::fmt;
use std::ops::RangeInclusive;

use serde::{Deserialize, Deserializer, de};

use super::Battery;

/// The range of capacities in watt-hours.
const CAPACITIES: RangeInclusive<f32> = 0.001..=1e6;
/// The range of powers in watts.
const POWERS: RangeInclusive<f32> = 0.0..=1e6;
/// The range of charges in per cent.
const CHARGES: RangeInclusive<f32> = 0.0..=100.0;

/// The battery of a robot type.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BatteryEntry {
    /// Watt-hours.
    pub capacity: f32,
    /// Watts that a robot takes while it moves.
    pub drain_moving: f32,
    /// Watts that it takes while it stands.
    pub drain_standing: f32,
    /// Watts by which its charge grows at a charger.
    pub charge_rate: f32,
    /// Its charge at the start; full by default.
    #[serde(default = "full")]
    pub charge: ChargeEntry,
}

fn full() -> ChargeEntry {
    ChargeEntry([100.0; 2])
}

/// A charge in per cent: a number, or a map of `min` and `max`, between which it is at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChargeEntry(pub [f32; 2]);

impl<'de> Deserialize<'de> for ChargeEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ChargeVisitor)
    }
}

struct ChargeVisitor;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ChargeRange {
    min: f32,
    max: f32,
}

impl<'de> de::Visitor<'de> for ChargeVisitor {
    type Value = ChargeEntry;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("per cent, or a map with the keys min and max")
    }

    fn visit_u64<E>(self, percent: u64) -> Result<ChargeEntry, E> {
        Ok(ChargeEntry([percent as f32; 2]))
    }

    fn visit_f64<E>(self, percent: f64) -> Result<ChargeEntry, E> {
        Ok(ChargeEntry([percent as f32; 2]))
    }

    fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<ChargeEntry, A::Error> {
        let ChargeRange { min, max } =
            ChargeRange::deserialize(de::value::MapAccessDeserializer::new(map))?;
        Ok(ChargeEntry([min, max]))
    }
}

/// Checks the values of a battery.
///
/// # Errors
/// If one is out of range; the message names it.
pub(super) fn battery(entry: BatteryEntry) -> Result<Battery, String> {
    let BatteryEntry {
        capacity,
        drain_moving,
        drain_standing,
        charge_rate,
        charge: ChargeEntry([min, max]),
    } = entry;
    let values = [
        ("capacity", "Wh", capacity, CAPACITIES),
        ("drain_moving", "W", drain_moving, POWERS),
        ("drain_standing", "W", drain_standing, POWERS),
        ("charge_rate", "W", charge_rate, POWERS),
        ("charge", "per cent", min, CHARGES),
        ("charge", "per cent", max, CHARGES),
    ];
    if let Some((name, unit, value, range)) =
        values.into_iter().find(|(_, _, value, range)| !range.contains(value))
    {
        return Err(format!(
            "battery, {name} is {value}; give {} to {} {unit}",
            range.start(),
            range.end()
        ));
    }
    if min > max {
        return Err(format!(
            "battery, charge is from {min} to {max} per cent; exchange min and max"
        ));
    }
    Ok(Battery { capacity, drain_moving, drain_standing, charge_rate, charge: [min, max] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(charge: &str) -> Result<Battery, String> {
        let text = format!(
            "{{capacity: 90, drain_moving: 60, drain_standing: 12.5, charge_rate: 600{charge}}}"
        );
        serde_yaml::from_str(&text).map_err(|error| error.to_string()).and_then(battery)
    }

    #[test]
    fn a_battery_is_full_or_has_the_charge_that_the_scenario_gives_it() {
        for (text, charge) in [
            ("", [100.0; 2]),
            (", charge: 40", [40.0; 2]),
            (", charge: 12.5", [12.5; 2]),
            (", charge: {min: 20, max: 80}", [20.0, 80.0]),
        ] {
            let battery = read(text).expect(text);
            assert_eq!(
                (battery.capacity, battery.drain_standing, battery.charge),
                (90.0, 12.5, charge)
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
        let flat = BatteryEntry {
            capacity: 0.0,
            drain_moving: 1.0,
            drain_standing: 1.0,
            charge_rate: 1.0,
            charge: full(),
        };
        assert!(battery(flat).expect_err("no capacity").contains("capacity is 0; give"));
    }
}
