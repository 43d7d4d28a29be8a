//! YAML with the line of every value, for errors that say where something is wrong.

use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};

/// The error of a line of a text.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error("line {line}: {reason}")]
pub struct InputError {
    /// The line, from 1.
    pub line: usize,
    /// The problem, and what to do.
    pub reason: String,
}

/// A value of a YAML text.
#[derive(Clone, Copy)]
pub(super) struct Value<'text>(&'text MarkedYaml<'text>);

/// Parses the one document of a text, and reads it.
pub(super) fn read<T>(
    text: &str,
    read: impl FnOnce(Value) -> Result<T, InputError>,
) -> Result<T, InputError> {
    let documents = MarkedYaml::load_from_str(text).map_err(|error| InputError {
        line: error.marker().line(),
        reason: error.info().to_owned(),
    })?;
    match &documents[..] {
        [document] => read(Value(document)),
        other => Err(InputError {
            line: 1,
            reason: format!("there are {} documents instead of one", other.len()),
        }),
    }
}

impl<'text> Value<'text> {
    /// Returns the error of this value.
    pub(super) fn error(self, reason: impl Into<String>) -> InputError {
        InputError { line: self.0.span.start.line(), reason: reason.into() }
    }

    fn scalar(self) -> Option<&'text Scalar<'text>> {
        match &self.0.data {
            YamlData::Value(scalar) => Some(scalar),
            _ => None,
        }
    }

    pub(super) fn is_mapping(self) -> bool {
        matches!(self.0.data, YamlData::Mapping(_))
    }

    /// The text of a scalar: of a number, too, because names may look like numbers.
    pub(super) fn text(self) -> Result<String, InputError> {
        match self.scalar() {
            Some(Scalar::String(text)) => Ok(text.to_string()),
            Some(Scalar::Integer(number)) => Ok(number.to_string()),
            _ => Err(self.error("expected a text")),
        }
    }

    pub(super) fn number(self) -> Result<f64, InputError> {
        match self.scalar() {
            Some(Scalar::Integer(number)) => Ok(*number as f64),
            Some(Scalar::FloatingPoint(number)) if number.is_finite() => Ok(number.into_inner()),
            _ => Err(self.error("expected a number")),
        }
    }

    /// A finite number that is at least 0.
    pub(super) fn positive(self) -> Result<f64, InputError> {
        match self.number()? {
            number if number >= 0.0 => Ok(number),
            number => Err(self.error(format!("{number} is below 0"))),
        }
    }

    /// An integer from 0 to `max`.
    pub(super) fn integer(self, max: u64) -> Result<u64, InputError> {
        match self.scalar() {
            Some(Scalar::Integer(number)) => {
                u64::try_from(*number).ok().filter(|number| *number <= max)
            }
            _ => None,
        }
        .ok_or_else(|| self.error(format!("expected an integer from 0 to {max}")))
    }

    pub(super) fn list(self) -> Result<Vec<Self>, InputError> {
        match &self.0.data {
            YamlData::Sequence(values) => Ok(values.iter().map(Self).collect()),
            _ => Err(self.error("expected a list")),
        }
    }

    /// The pairs of a mapping with texts as keys.
    pub(super) fn pairs(self) -> Result<Vec<(String, Self)>, InputError> {
        let YamlData::Mapping(pairs) = &self.0.data else {
            return Err(self.error("expected `key: value` pairs"));
        };
        pairs.iter().map(|(key, value)| Ok((Self(key).text()?, Self(value)))).collect()
    }

    /// The fields of a mapping that has no other keys than these.
    pub(super) fn fields(self, names: &[&str]) -> Result<Fields<'text>, InputError> {
        let pairs = self.pairs()?;
        if let Some((key, value)) = pairs.iter().find(|(key, _)| !names.contains(&key.as_str())) {
            return Err(
                value.error(format!("unknown field `{key}`; there are {}", names.join(", ")))
            );
        }
        Ok(Fields { mapping: self, pairs })
    }
}

/// The fields of a mapping.
pub(super) struct Fields<'text> {
    mapping: Value<'text>,
    pairs: Vec<(String, Value<'text>)>,
}

impl<'text> Fields<'text> {
    pub(super) fn get(&self, name: &str) -> Option<Value<'text>> {
        self.pairs.iter().find(|(key, _)| key == name).map(|(_, value)| *value)
    }

    pub(super) fn required(&self, name: &str) -> Result<Value<'text>, InputError> {
        self.get(name).ok_or_else(|| self.mapping.error(format!("`{name}` is missing")))
    }

    /// Reads a field if it is there.
    pub(super) fn optional<T>(
        &self,
        name: &str,
        read: impl FnOnce(Value<'text>) -> Result<T, InputError>,
    ) -> Result<Option<T>, InputError> {
        self.get(name).map(read).transpose()
    }
}
