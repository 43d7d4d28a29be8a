//! Writes messages as a version spells them.

use std::io;

use serde_json::Serializer;
use serde_json::ser::Formatter;

use super::Message;
use super::header::{Topic, Version};
use super::names::{PARAMETERS, Renamed, VALUES, fields};

/// Writes a message as JSON of a version. The message should be [adapted](Message::adapt) to it.
///
/// Numbers that aren't finite are written as `null`, which no schema accepts.
pub fn encode<M: Message>(message: &M, version: Version) -> Vec<u8> {
    let mut json = Vec::with_capacity(1024);
    let written = match version {
        Version::V3_0 => message.serialize(&mut Serializer::new(&mut json)),
        Version::V2_0 | Version::V2_1 => {
            let names = OldNames::of(M::TOPIC);
            message.serialize(&mut Serializer::with_formatter(&mut json, names))
        }
    };
    // Plain structs with texts as keys are written to memory without an error.
    if written.is_err() {
        json.clear();
    }
    json
}

/// Replaces the names of 3.0 by those of 2.x while they are written.
struct OldNames {
    fields: &'static [Renamed],
    /// The part of an object that is being written.
    part: Part,
    /// The field whose value follows, if it has values with other names.
    field: Option<&'static str>,
    /// The number of arrays around what is being written.
    arrays: u32,
    /// That number within parameters of actions, which keep their names.
    parameters: Option<u32>,
}

/// A part of an object.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Key,
    Value,
}

impl OldNames {
    fn of(topic: Topic) -> Self {
        let fields = fields(topic);
        Self { fields, part: Part::Value, field: None, arrays: 0, parameters: None }
    }

    /// Returns the old name of a field, and notes the field.
    fn key<'text>(&mut self, name: &'text str) -> &'text str {
        if self.parameters.is_some() {
            return name;
        }
        if name == PARAMETERS {
            self.parameters = Some(self.arrays + 1);
        }
        self.field = VALUES.iter().map(|value| value.field).find(|field| *field == name);
        let renamed = self.fields.iter().find(|field| field.new == name);
        renamed.map_or(name, |field| field.old)
    }

    /// Returns the old name of a value of the field.
    fn value<'text>(&mut self, text: &'text str) -> &'text str {
        let Some(field) = self.field.take() else { return text };
        let renamed = VALUES.iter().find(|value| value.field == field && value.new == text);
        renamed.map_or(text, |value| value.old)
    }
}

impl Formatter for OldNames {
    fn begin_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.arrays += 1;
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        if self.parameters == Some(self.arrays) {
            self.parameters = None;
        }
        self.arrays -= 1;
        writer.write_all(b"]")
    }

    fn begin_object_key<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.part = Part::Key;
        if first { Ok(()) } else { writer.write_all(b",") }
    }

    fn end_object_key<W: ?Sized + io::Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.part = Part::Value;
        Ok(())
    }

    fn write_string_fragment<W: ?Sized + io::Write>(
        &mut self,
        writer: &mut W,
        fragment: &str,
    ) -> io::Result<()> {
        let text = match self.part {
            Part::Key => self.key(fragment),
            Part::Value => self.value(fragment),
        };
        writer.write_all(text.as_bytes())
    }
}
