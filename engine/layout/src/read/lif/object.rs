//! An object of a JSON text whose values are taken out one by one, and the notes of the readers.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde_json::Value;
use serde_json::value::RawValue;

use crate::model::finding::{FindingKind, Report, Severity, Subject};
use crate::model::tags::Tags;
use crate::read::file::{Ignored, offset_of};

/// The state that the readers of a file share.
pub(super) struct Context<'r, 'text> {
    pub text: &'text str,
    pub report: &'r mut Report<'text>,
    pub ignored: Ignored,
    /// The edge that is being read, in words, for messages.
    pub edge: Option<String>,
    /// By message.
    notes: BTreeMap<Cow<'static, str>, Note>,
}

/// A list or an object that isn't parsed yet.
pub(super) type Raw<'text> = &'text RawValue;

/// A warning that is reported once.
struct Note {
    kind: FindingKind,
    /// The byte offset of the first occurrence.
    at: u32,
    /// The number of occurrences.
    count: usize,
    /// The edge of the first occurrence, in words.
    edge: Option<String>,
}

impl Note {
    /// Returns the first place and the number of occurrences, if there is anything to tell.
    fn occurrences(&self) -> String {
        match (self.count, &self.edge) {
            (1, None) => String::new(),
            (1, Some(edge)) => format!(" ({edge})"),
            (count, None) => format!(" ({count} times)"),
            (count, Some(edge)) => format!(" ({count} times, first at {edge})"),
        }
    }
}

impl<'r, 'text> Context<'r, 'text> {
    pub fn new(text: &'text str, report: &'r mut Report<'text>) -> Self {
        Self { text, report, ignored: Ignored::default(), edge: None, notes: BTreeMap::new() }
    }

    /// Returns the byte offset of a part of the text.
    pub fn at(&self, raw: Raw<'text>) -> u32 {
        offset_of(self.text, raw.get()).unwrap_or_default() as u32
    }

    pub fn error(&mut self, at: u32, message: impl Into<String>) {
        let edge = self.edge.iter().map(|edge| format!(" ({edge})")).collect::<String>();
        self.report.file_error(at, format!("{}{edge}", message.into()));
    }

    pub fn warning(&mut self, at: u32, message: impl Into<String>) {
        self.report.file_warning(at, message);
    }

    /// Adds a warning, which is reported once with its number of occurrences.
    pub fn note(&mut self, at: u32, message: impl Into<Cow<'static, str>>) {
        self.add_note(FindingKind::General, at, message.into());
    }

    /// Adds a warning that results rest on, which is reported once with its number of occurrences.
    pub fn assume(&mut self, at: u32, message: impl Into<Cow<'static, str>>) {
        self.add_note(FindingKind::Assumption, at, message.into());
    }

    fn add_note(&mut self, kind: FindingKind, at: u32, message: Cow<'static, str>) {
        let new = || Note { kind, at, count: 0, edge: self.edge.clone() };
        self.notes.entry(message).or_insert_with(new).count += 1;
    }

    /// Reports all notes and ignored keys.
    pub fn finish(self) {
        for (message, note) in self.notes {
            let message = format!("{message}{}", note.occurrences());
            self.report.add_kind(note.kind, Severity::Warning, note.at, Subject::File, message);
        }
        self.ignored.report(self.report);
    }
}

/// An object of the text. Keys that aren't taken are kept by [`Object::keep_rest`], or counted as
/// ignored.
pub(super) struct Object<'text> {
    pub at: u32,
    /// Such as "a node", for messages.
    pub kind: &'static str,
    fields: BTreeMap<String, Raw<'text>>,
}

impl<'text> Object<'text> {
    /// Parses an object; anything else is an error.
    pub fn parse(
        raw: Raw<'text>,
        kind: &'static str,
        context: &mut Context<'_, 'text>,
    ) -> Option<Self> {
        let at = context.at(raw);
        match serde_json::from_str(raw.get()) {
            Ok(fields) => Some(Self { at, kind, fields }),
            Err(_) => {
                context.error(at, format!("{kind} is expected here, in braces"));
                None
            }
        }
    }

    /// Takes a value out; `None` if the key is missing or its value is null.
    pub fn take(&mut self, key: &str) -> Option<Raw<'text>> {
        self.fields.remove(key).filter(|raw| raw.get() != "null")
    }

    /// Returns a text without taking it out, as [`take_text`](Self::take_text) does.
    pub fn name(&self, key: &str) -> Option<String> {
        self.fields.get(key).and_then(|raw| plain(raw)).filter(|text| !text.is_empty())
    }

    /// Takes a text out; numbers and booleans are texts too.
    pub fn take_text(&mut self, key: &str, context: &mut Context<'_, 'text>) -> Option<String> {
        let raw = self.take(key)?;
        let text = plain(raw);
        if text.is_none() {
            self.unexpected(key, "a text", raw, context);
        }
        text.filter(|text| !text.is_empty())
    }

    /// Takes a finite number out, even if it is written as text.
    pub fn take_number(&mut self, key: &str, context: &mut Context<'_, 'text>) -> Option<f64> {
        let raw = self.take(key)?;
        let number = number(raw, context);
        if number.is_none() {
            self.unexpected(key, "a number", raw, context);
        }
        number
    }

    /// Takes the elements of a list out; none if the key is missing.
    pub fn take_list(&mut self, key: &str, context: &mut Context<'_, 'text>) -> Vec<Raw<'text>> {
        let Some(raw) = self.take(key) else { return Vec::new() };
        serde_json::from_str(raw.get()).unwrap_or_else(|_| {
            self.unexpected(key, "a list", raw, context);
            Vec::new()
        })
    }

    /// Takes an object out.
    pub fn take_object(
        &mut self,
        key: &str,
        kind: &'static str,
        context: &mut Context<'_, 'text>,
    ) -> Option<Object<'text>> {
        Object::parse(self.take(key)?, kind, context)
    }

    /// Takes a value of any kind out as a property; lists and objects as JSON without white space.
    pub fn take_json(&mut self, key: &str) -> Option<String> {
        let raw = self.take(key)?;
        plain(raw).or_else(|| Some(serde_json::from_str::<Value>(raw.get()).ok()?.to_string()))
    }

    /// Keeps the values of keys as properties; lists and objects as JSON.
    pub fn keep_json(&mut self, keys: &[&str], tags: &mut Tags) {
        for key in keys {
            if let Some(json) = self.take_json(key).filter(|json| json != "[]" && json != "{}") {
                tags.set(key, &json);
            }
        }
    }

    /// Keeps the plain values of all other keys as properties, and counts the rest as ignored.
    pub fn keep_rest(
        self,
        properties: &mut BTreeMap<Box<str>, Box<str>>,
        context: &mut Context<'_, 'text>,
    ) {
        for (key, raw) in self.fields {
            match plain(raw) {
                Some(text) if text.is_empty() => {}
                Some(text) => drop(properties.insert(key.into(), text.into())),
                None if raw.get() == "null" => {}
                None => context.ignored.add_key(context.at(raw), &key, self.kind),
            }
        }
    }

    /// Takes a key out if it has the value that our own writer always gives it.
    pub fn drop_own(&mut self, key: &str, value: &str) {
        if self.fields.get(key).and_then(|raw| plain(raw)).as_deref() == Some(value) {
            self.fields.remove(key);
        }
    }

    /// Counts all other keys as ignored, unless their values are empty.
    pub fn ignore_rest(self, context: &mut Context<'_, 'text>) {
        for (key, raw) in self.fields {
            if !["null", "\"\"", "[]", "{}"].contains(&raw.get()) {
                context.ignored.add_key(context.at(raw), &key, self.kind);
            }
        }
    }

    fn unexpected(
        &self,
        key: &str,
        expected: &str,
        raw: Raw<'text>,
        context: &mut Context<'_, 'text>,
    ) {
        let message = format!("`{key}` of {} isn't {expected}: not used", self.kind);
        context.note(context.at(raw), message);
    }
}

/// Returns the number of a value, even if it is written as text.
pub(super) fn number<'text>(raw: Raw<'text>, context: &mut Context<'_, 'text>) -> Option<f64> {
    let is_text = raw.get().starts_with('"');
    let number: f64 = plain(raw)?.trim().parse().ok().filter(|number: &f64| number.is_finite())?;
    if is_text {
        context.note(context.at(raw), "a number is written as a text, in quotes: read as a number");
    }
    Some(number)
}

/// Returns a text, number or boolean as a text.
pub(super) fn plain(raw: Raw<'_>) -> Option<String> {
    match serde_json::from_str(raw.get()).ok()? {
        Value::String(text) => Some(text),
        Value::Number(_) | Value::Bool(_) => Some(raw.get().to_owned()),
        _ => None,
    }
}
