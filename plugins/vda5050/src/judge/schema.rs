//! The official schemas of the standard, by which each message is judged first.

use std::sync::LazyLock;

use boon::{Compiler, ErrorKind, SchemaIndex, Schemas, ValidationError};
use serde_json::Value;

use super::finding::{Notes, quoted};
use super::range;
use super::rule::Rule;
use super::seen::Subject;
use crate::message::{Topic, Version};

/// The official schemas, by folder and topic.
macro_rules! schemas {
    ($($folder:literal: $($name:literal)*;)*) => {
        [$($(($folder, $name, include_str!(concat!(
            "../../tests/schemas/", $folder, "/", $name, ".schema"
        )))),*),*]
    };
}

const TEXTS: [(&str, &str, &str); 19] = schemas! {
    "2.0.0": "order" "instantActions" "state" "visualization" "connection";
    "2.1.0": "order" "instantActions" "state" "visualization" "connection" "factsheet";
    "3.0.0": "order" "instantActions" "state" "visualization" "connection" "factsheet"
        "zoneSet" "responses";
};

/// The compiled schemas.
pub(super) struct Book {
    schemas: Schemas,
    indices: Vec<(&'static str, &'static str, SchemaIndex)>,
}

impl core::fmt::Debug for Book {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Book").finish_non_exhaustive()
    }
}

/// The schemas, compiled once.
static BOOK: LazyLock<Book> = LazyLock::new(Book::new);

impl Book {
    /// All schemas.
    pub fn shared() -> &'static Self {
        &BOOK
    }

    /// Compiles all schemas. A test keeps them free of errors.
    fn new() -> Self {
        let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
        let mut indices = Vec::new();
        for (folder, name, text) in TEXTS {
            let url = format!("https://vda5050.example/{folder}/{name}");
            let Ok(content) = serde_json::from_str(text) else { continue };
            if compiler.add_resource(&url, content).is_ok()
                && let Ok(index) = compiler.compile(&url, &mut schemas)
            {
                indices.push((folder, name, index));
            }
        }
        Self { schemas, indices }
    }

    /// The schema of a topic in a version. Schemas of 2.0 that contradict its text give way to
    /// those of 2.1: that of instant actions asks for `actionName`, and factsheets have none.
    fn index(&self, subject: Subject, version: Version) -> Option<SchemaIndex> {
        let folder = match (subject, version) {
            (Subject::Read(Topic::InstantActions | Topic::Factsheet), Version::V2_0) => "2.1.0",
            _ => version.number(),
        };
        let mut found =
            self.indices.iter().filter(|row| (row.0, row.1) == (folder, subject.name()));
        found.next().map(|row| row.2)
    }

    /// Adds what a message has against the schema and the ranges of its version.
    pub fn judge(&self, content: &Value, notes: &mut Notes<'_>) {
        let Some(index) = self.index(notes.subject, notes.version) else { return };
        if let Err(error) = self.schemas.validate(content, index) {
            add_all(&error, notes);
        }
        range::judge(content, notes);
    }
}

/// Adds the innermost errors.
fn add_all(error: &ValidationError<'_, '_>, notes: &mut Notes<'_>) {
    if error.causes.is_empty() && !contradicts_text(error, notes.version) {
        add(error, notes);
    }
    for cause in &error.causes {
        add_all(cause, notes);
    }
}

/// Whether a schema contradicts the text of its version: that of 2.0 wants a heading in the
/// positions of `nodeStates`, which is optional, and that of factsheets of 2.x wants a list of
/// blocking types to be one of them.
fn contradicts_text(error: &ValidationError<'_, '_>, version: Version) -> bool {
    let place = error.instance_location.to_string();
    match &error.kind {
        ErrorKind::Required { want } => {
            version == Version::V2_0 && *want == ["theta"] && place.ends_with("/nodePosition")
        }
        ErrorKind::Enum { .. } => version != Version::V3_0 && place.ends_with("/blockingTypes"),
        _ => false,
    }
}

fn add(error: &ValidationError<'_, '_>, notes: &mut Notes<'_>) {
    let location = error.instance_location.to_string();
    let place = if location.is_empty() { "the message".to_owned() } else { quoted(&location) };
    let (rule, text) = match &error.kind {
        ErrorKind::Required { want } => {
            (Rule::MissingField, format!("{place} has no field {}", want.join(", ")))
        }
        ErrorKind::Type { got, want } => {
            let wanted: Vec<_> = want.iter().map(|kind| kind.to_string()).collect();
            (Rule::FieldType, format!("{place} is of type {got}, not {}", wanted.join(" or ")))
        }
        ErrorKind::Enum { want } => {
            let values: Vec<_> = want.iter().map(Value::to_string).collect();
            (Rule::UnknownValue, format!("{place} is none of {}", values.join(", ")))
        }
        ErrorKind::Minimum { got, want } => {
            return range::add(&location, got, &format!("at least {want}"), notes);
        }
        ErrorKind::Maximum { got, want } => {
            return range::add(&location, got, &format!("at most {want}"), notes);
        }
        kind => (Rule::Schema, format!("{place} isn't valid: {kind}")),
    };
    notes.add(rule, text);
}

#[cfg(test)]
mod tests;
