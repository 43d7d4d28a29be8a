//! The services, and the wishes that their calls and changes of parameters come to.

use serde::Deserialize;
use serde_json::{Value, json};

/// The word for as fast as possible.
const MAX: &str = "max";
/// The most ticks of a step.
const MOST_TICKS: u64 = 1_000_000;

/// A service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    Pause,
    Resume,
    Step,
    Speed,
}

/// A wish of a client of the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Wish {
    Pause,
    Resume,
    /// Ticks.
    Step(u64),
    /// Simulated seconds per wall second; infinity for as fast as possible.
    Speed(f32),
    /// The number of robots.
    Robots(u32),
}

/// The error of arguments that mean nothing.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ArgumentError {
    #[error("the arguments are invalid: {0}")]
    Json(#[from] serde_json::Error),
    #[error("give a number of ticks from 1 to {MOST_TICKS}")]
    Ticks,
    #[error("give a speed above 0, or \"{MAX}\" for as fast as possible")]
    Speed,
}

#[derive(Deserialize)]
struct StepArguments {
    #[serde(default = "one")]
    ticks: u64,
}

fn one() -> u64 {
    1
}

#[derive(Deserialize)]
struct SpeedArguments {
    speed: Value,
}

impl Service {
    pub const ALL: [Self; 4] = [Self::Pause, Self::Resume, Self::Step, Self::Speed];

    /// Its number in the protocol.
    pub fn id(self) -> u32 {
        self as u32 + 1
    }

    pub fn of_id(id: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|service| service.id() == id)
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Pause => "/pause",
            Self::Resume => "/resume",
            Self::Step => "/step",
            Self::Speed => "/speed",
        }
    }

    /// The name of its type.
    pub fn kind(self) -> &'static str {
        match self {
            Self::Pause => "regatta.Pause",
            Self::Resume => "regatta.Resume",
            Self::Step => "regatta.Step",
            Self::Speed => "regatta.Speed",
        }
    }

    /// The JSON schema of its arguments.
    pub fn arguments(self) -> Value {
        let properties = match self {
            Self::Pause | Self::Resume => json!({}),
            Self::Step => json!({"ticks": {"type": "integer", "minimum": 1, "default": 1}}),
            Self::Speed => json!({"speed": {"type": "number", "description": SPEED}}),
        };
        json!({"type": "object", "properties": properties})
    }

    /// The JSON schema of the answers of all services.
    pub fn answer() -> Value {
        json!({"type": "object", "properties": {
            "success": {"type": "boolean"},
            "message": {"type": "string"},
            "tick": {"type": "integer"},
            "paused": {"type": "boolean"},
            "speed": {"type": "number"},
        }})
    }

    /// Reads the arguments of a call. Nothing at all means no arguments.
    pub fn wish(self, payload: &[u8]) -> Result<Wish, ArgumentError> {
        let payload = if payload.is_empty() { &b"{}"[..] } else { payload };
        let value: Value = serde_json::from_slice(payload)?;
        Ok(match self {
            Self::Pause => Wish::Pause,
            Self::Resume => Wish::Resume,
            Self::Step => match serde_json::from_value(value)? {
                StepArguments { ticks: ticks @ 1..=MOST_TICKS } => Wish::Step(ticks),
                StepArguments { .. } => return Err(ArgumentError::Ticks),
            },
            Self::Speed => {
                let SpeedArguments { speed } = serde_json::from_value(value)?;
                Wish::Speed(speed_of(&speed).ok_or(ArgumentError::Speed)?)
            }
        })
    }
}

const SPEED: &str = "Simulated seconds per second, or the word max for as fast as possible";

/// Reads a speed: a number above 0, or a word.
pub(crate) fn speed_of(value: &Value) -> Option<f32> {
    match value {
        Value::String(word) if word == MAX => Some(f32::INFINITY),
        Value::String(text) => finite(text.parse().ok()?),
        value => finite(value.as_f64()?),
    }
}

fn finite(speed: f64) -> Option<f32> {
    Some(speed as f32).filter(|speed| speed.is_finite() && *speed > 0.0)
}

/// Returns a speed as JSON, which knows no infinity.
pub(crate) fn speed_value(speed: f32) -> Value {
    // By its shortest text, so that 0.1 stays 0.1.
    let number = speed.to_string().parse::<f64>().ok().and_then(serde_json::Number::from_f64);
    number.map_or_else(|| MAX.into(), Value::Number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_read() {
        for (service, payload, wish) in [
            (Service::Pause, "", Wish::Pause),
            (Service::Resume, "{}", Wish::Resume),
            (Service::Step, "{}", Wish::Step(1)),
            (Service::Step, r#"{"ticks": 25}"#, Wish::Step(25)),
            (Service::Speed, r#"{"speed": 0.5}"#, Wish::Speed(0.5)),
            (Service::Speed, r#"{"speed": "max"}"#, Wish::Speed(f32::INFINITY)),
        ] {
            assert_eq!(service.wish(payload.as_bytes()).expect("valid"), wish);
        }
        for (service, payload) in [
            (Service::Pause, "{"),
            (Service::Step, r#"{"ticks": 0}"#),
            (Service::Step, r#"{"ticks": -1}"#),
            (Service::Step, r#"{"ticks": 1000001}"#),
            (Service::Speed, "{}"),
            (Service::Speed, r#"{"speed": 0}"#),
            (Service::Speed, r#"{"speed": 1e300}"#),
            (Service::Speed, r#"{"speed": "fast"}"#),
        ] {
            assert!(service.wish(payload.as_bytes()).is_err(), "{payload}");
        }
    }

    #[test]
    fn speeds_are_numbers_or_the_word_max() {
        assert_eq!(speed_value(0.1).to_string(), "0.1");
        assert_eq!(speed_value(f32::INFINITY), "max");
        assert_eq!(speed_of(&speed_value(f32::INFINITY)), Some(f32::INFINITY));
    }
}
