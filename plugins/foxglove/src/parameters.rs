//! The parameters: the state of the clock and the size of the fleet, which clients may change.

use regatta_plugin::frame::{ClockState, FrameHeader};
use serde_json::{Value, json};

use crate::protocol::Parameter;
use crate::service::{Wish, speed_of, speed_value};

const PAUSED: &str = "paused";
const SPEED: &str = "speed";
const ROBOTS: &str = "robots";

/// The values of the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Parameters {
    pub is_paused: bool,
    /// Simulated seconds per wall second; infinity for as fast as possible.
    pub speed: f32,
    pub robots: u32,
}

/// The error of a change of a parameter.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ParameterError {
    #[error("there is no parameter '{0}'; there are {PAUSED}, {SPEED} and {ROBOTS}")]
    Name(String),
    #[error("'{PAUSED}' is true or false")]
    Paused,
    #[error("'{SPEED}' is a number above 0, or \"max\" for as fast as possible")]
    Speed,
    #[error("'{ROBOTS}' is a number of robots, from 0")]
    Robots,
}

impl Parameters {
    /// The names of all.
    pub const NAMES: [&str; 3] = [PAUSED, SPEED, ROBOTS];

    pub fn of(header: &FrameHeader) -> Self {
        Self {
            is_paused: header.clock != ClockState::Running as u32,
            speed: header.speed,
            robots: header.robots,
        }
    }

    /// Returns the parameters that are in the list, in the form of the protocol; all if it is
    /// empty.
    pub fn named(&self, names: &[impl AsRef<str>]) -> Vec<Value> {
        let all = [
            json!({"name": PAUSED, "value": self.is_paused}),
            json!({"name": SPEED, "value": speed_value(self.speed), "type": "float64"}),
            json!({"name": ROBOTS, "value": self.robots, "type": "float64"}),
        ];
        let all = Self::NAMES.into_iter().zip(all);
        let named = all.filter(|(name, _)| {
            names.is_empty() || names.iter().any(|wanted| wanted.as_ref() == *name)
        });
        named.map(|(_, parameter)| parameter).collect()
    }
}

/// Reads a change of a parameter.
pub(crate) fn wish(parameter: &Parameter) -> Result<Wish, ParameterError> {
    let value = &parameter.value;
    match parameter.name.as_str() {
        PAUSED => match value.as_bool().ok_or(ParameterError::Paused)? {
            true => Ok(Wish::Pause),
            false => Ok(Wish::Resume),
        },
        SPEED => speed_of(value).map(Wish::Speed).ok_or(ParameterError::Speed),
        ROBOTS => {
            // Some clients have no integers.
            let count = value.as_f64().filter(|count| count.fract() == 0.0 && *count >= 0.0);
            let count = count.filter(|count| *count <= f64::from(u32::MAX));
            count.map(|count| Wish::Robots(count as u32)).ok_or(ParameterError::Robots)
        }
        name => Err(ParameterError::Name(name.chars().take(40).collect())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, value: Value) -> Result<Wish, ParameterError> {
        wish(&Parameter { name: name.to_owned(), value })
    }

    #[test]
    fn changes_are_read() {
        assert_eq!(of("paused", json!(true)).expect("valid"), Wish::Pause);
        assert_eq!(of("paused", json!(false)).expect("valid"), Wish::Resume);
        assert_eq!(of("speed", json!(2)).expect("valid"), Wish::Speed(2.0));
        assert_eq!(of("speed", json!("max")).expect("valid"), Wish::Speed(f32::INFINITY));
        assert_eq!(of("robots", json!(30.0)).expect("valid"), Wish::Robots(30));
        for (name, value) in [
            ("paused", json!(1)),
            ("paused", Value::Null),
            ("speed", json!(-1)),
            ("robots", json!(1.5)),
            ("robots", json!(-1)),
            ("robots", json!(1e12)),
            ("fleet", json!("x")),
        ] {
            assert!(of(name, value.clone()).is_err(), "{name} {value}");
        }
    }

    #[test]
    fn values_are_found_by_name() {
        let parameters = Parameters { is_paused: false, speed: f32::INFINITY, robots: 7 };
        assert_eq!(parameters.named(&Parameters::NAMES).len(), 3);
        let speed = parameters.named(&["speed", "nothing"]);
        assert_eq!(speed, [json!({"name": "speed", "value": "max", "type": "float64"})]);
    }
}
