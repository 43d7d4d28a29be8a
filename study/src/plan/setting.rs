//! Settings: the properties in which variants differ.

use std::fmt;
use std::str::FromStr;

use serde_json::Value;

/// Defines [`Setting`] with the names of its variants.
macro_rules! settings {
    ($($(#[doc = $doc:literal])* $variant:ident = $name:literal,)*) => {
        /// A property in which variants differ.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Setting {
            $($(#[doc = $doc])* $variant,)*
        }

        impl Setting {
            /// All settings.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The name in files and on the command line.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

settings! {
    /// The layout: a path, relative to the current folder.
    Layout = "layout",
    /// The robot type of all robots: the name of one of the scenario's.
    Type = "type",
    /// The largest speed of all robot types, in metres per second.
    MaxSpeed = "max_speed",
    /// The largest acceleration of all robot types, in metres per second squared.
    MaxAcceleration = "max_acceleration",
    /// The part of the edges' speed limits that is driven: a factor.
    SpeedFactor = "speed_factor",
    /// The load of transport orders, as in a scenario.
    Load = "load",
    /// The dwell time at stops of all generators: seconds, or `{min, max}`.
    Dwell = "dwell",
    /// Edges that are closed: a list of ids, names or nodes as `FROM..TO`.
    Closed = "closed",
    /// Breakdowns of a robot per hour; they take the scenario's time to repair, or five minutes.
    BreakdownsPerHour = "breakdowns_per_hour",
    /// The planner of the fleet manager.
    Planner = "planner",
    /// The manager: a command line, or `fleet-manager`.
    Manager = "manager",
}

impl Setting {
    /// Returns the setting with a name.
    pub fn with_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|setting| setting.name() == name)
    }
}

/// A setting and the values that are tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The setting.
    pub setting: Setting,
    /// Its values; at least one.
    pub values: Vec<Value>,
}

/// The error of parsing an [`Axis`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ParseAxisError {
    /// There is no such setting.
    #[error("unknown setting '{0}': the settings are {names}", names = names())]
    Unknown(String),
    /// There are no values.
    #[error("invalid setting '{0}': give NAME=VALUE,VALUE, such as max_speed=1,1.5")]
    NoValues(String),
}

fn names() -> String {
    let names: Vec<_> = Setting::ALL.iter().map(|setting| setting.name()).collect();
    names.join(", ")
}

impl Axis {
    /// Makes an axis of a setting's name and its values.
    ///
    /// # Errors
    /// [`ParseAxisError`] if there is no such setting, or no value.
    pub fn new(name: &str, values: Vec<Value>) -> Result<Self, ParseAxisError> {
        let setting =
            Setting::with_name(name).ok_or_else(|| ParseAxisError::Unknown(name.to_owned()))?;
        if values.is_empty() {
            return Err(ParseAxisError::NoValues(name.to_owned()));
        }
        Ok(Self { setting, values })
    }
}

impl FromStr for Axis {
    type Err = ParseAxisError;

    /// Parses `NAME=VALUE,VALUE`. Values are JSON, or else texts; a comma within brackets doesn't
    /// end a value.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (name, list) =
            text.split_once('=').ok_or_else(|| ParseAxisError::NoValues(text.to_owned()))?;
        let texts = split(list).into_iter().filter(|value| !value.is_empty());
        let values =
            texts.map(|text| serde_json::from_str(text).unwrap_or_else(|_| Value::from(text)));
        Self::new(name.trim(), values.collect())
    }
}

/// Splits a text at commas that are in no brackets and no quotation marks.
fn split(text: &str) -> Vec<&str> {
    let (mut depth, mut quoted) = (0, false);
    let parts = text.split(move |letter| {
        match letter {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            _ => {}
        }
        letter == ',' && depth == 0 && !quoted
    });
    parts.map(str::trim).collect()
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn values_are_json_or_texts() {
        let axis = |text: &str| text.parse::<Axis>().map(|axis| axis.values);
        assert_eq!(axis("max_speed=1,1.5"), Ok(vec![json!(1), json!(1.5)]));
        assert_eq!(axis("planner=lanes, pibt"), Ok(vec![json!("lanes"), json!("pibt")]));
        assert_eq!(axis("closed=[],[3,4]"), Ok(vec![json!([]), json!([3, 4])]));
        assert_eq!(axis("dwell={\"min\":1,\"max\":2}"), Ok(vec![json!({"min": 1, "max": 2})]));
        assert_eq!(axis("colour=red"), Err(ParseAxisError::Unknown("colour".to_owned())));
        assert!(axis("planner=").is_err() && axis("planner").is_err());
        let message = axis("colour=red").expect_err("unknown").to_string();
        assert!(message.contains("max_speed") && message.contains("'colour'"), "{message}");
    }
}
