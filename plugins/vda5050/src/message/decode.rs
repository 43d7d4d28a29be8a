//! Reads messages of any version.

use serde_json::{Map, Value};

use super::Message;
use super::names::{PARAMETERS, Renamed, VALUES, fields};

/// The error of a message that can't be read.
#[derive(Debug, thiserror::Error)]
#[error("the {topic} message is not valid: {reason}")]
pub struct DecodeError {
    topic: &'static str,
    reason: String,
    /// The message as far as it is JSON.
    content: Value,
}

impl DecodeError {
    /// The reason alone.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// A field of the message that is a text or a number, as text.
    pub fn field(&self, name: &str) -> Option<String> {
        match self.content.get(name)? {
            Value::String(text) => Some(text.clone()),
            Value::Number(number) => Some(number.to_string()),
            _ => None,
        }
    }
}

/// Reads a message of any version, with the names of any version. Fields that aren't known are
/// ignored, as the standard wants it.
///
/// # Errors
/// [`DecodeError`] if it isn't JSON, or a field is missing or of another type.
pub fn decode<M: Message>(json: &[u8]) -> Result<M, DecodeError> {
    let topic = M::TOPIC.name();
    let mut content: Value = serde_json::from_slice(json).map_err(|error| DecodeError {
        topic,
        reason: error.to_string(),
        content: Value::Null,
    })?;
    rename(&mut content, fields(M::TOPIC));
    M::deserialize(&content).map_err(|error| DecodeError {
        topic,
        reason: error.to_string(),
        content,
    })
}

/// Replaces the names of 2.x by those of 3.0.
fn rename(value: &mut Value, fields: &[Renamed]) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| rename(item, fields)),
        Value::Object(object) => {
            // The names in the parameters of actions belong to the sender.
            for (_, item) in object.iter_mut().filter(|(name, _)| *name != PARAMETERS) {
                rename(item, fields);
            }
            rename_fields(object, fields);
            rename_values(object);
        }
        _ => {}
    }
}

fn rename_fields(object: &mut Map<String, Value>, fields: &[Renamed]) {
    for field in fields {
        if !object.contains_key(field.new)
            && let Some(value) = object.remove(field.old)
        {
            object.insert(field.new.to_owned(), value);
        }
    }
}

fn rename_values(object: &mut Map<String, Value>) {
    for value in VALUES {
        if let Some(Value::String(text)) = object.get_mut(value.field)
            && text == value.old
        {
            value.new.clone_into(text);
        }
    }
}
