//! Reads what the YAML library hands out.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess};

use super::sections::Part;
use super::{Content, Scope};
use crate::model::finding::Subject;
use crate::model::raw::{EDGE_KEYS, Field, NODE_KEYS, STATION_KEYS, Values, find};
use crate::model::value::{ReadValue, Scalar, Value, impl_deserialize_seed, read_value, shorten};
use crate::read::file::{MAX_ENTRIES, SyntaxError};

/// The reader of a text, or of a part of it.
pub(super) struct Reader<'text> {
    /// The whole text.
    text: &'text str,
    content: Content<'text>,
    /// The byte offset of the last key whose position is known.
    at: u32,
    /// The number of keys and items so far.
    entries: usize,
    /// Whether each [`RootKey`] has been seen.
    seen: [bool; 5],
}

/// A key of the root map.
#[derive(Clone, Copy, PartialEq, Eq)]
enum RootKey {
    Edges,
    Vertices,
    Stations,
    AngleUnit,
    Handles,
}

/// The names of the root keys, normalized as by [`find`].
const ROOT_KEYS: [(&str, RootKey); 6] = [
    ("edges", RootKey::Edges),
    ("vertices", RootKey::Vertices),
    ("nodes", RootKey::Vertices),
    ("stations", RootKey::Stations),
    ("angleunit", RootKey::AngleUnit),
    ("handles", RootKey::Handles),
];

impl<'text> Reader<'text> {
    /// Makes a reader of a part of `text`.
    pub fn new(text: &'text str, content: Content<'text>) -> Self {
        Self { text, content, at: 0, entries: 0, seen: [false; 5] }
    }

    /// Reads a part of the root map.
    pub fn read(mut self, part: Part<'text>) -> Result<Content<'text>, SyntaxError> {
        let (Part::Entry(text) | Part::Items { items: text, .. }) = part;
        self.at = text.as_ptr().addr().saturating_sub(self.text.as_ptr().addr()) as u32;
        let result = match part {
            Part::Entry(entry) => self.read_map(entry),
            Part::Items { key, items } => self.read_items(key, items),
        };
        match result {
            Ok(()) => Ok(self.content),
            Err(error) => Err(self.syntax_error(text, &error)),
        }
    }

    fn read_map(&mut self, text: &'text str) -> Result<(), serde_yaml::Error> {
        let root = read_value(Root(&mut *self), serde_yaml::Deserializer::from_str(text))?;
        match root {
            Value::Read => Ok(()),
            other => Err(Error::custom(format!(
                "expected a map with Edges and Vertices, found {}",
                other.describe()
            ))),
        }
    }

    fn read_items(&mut self, key: &'text str, items: &'text str) -> Result<(), serde_yaml::Error> {
        let deserializer = serde_yaml::Deserializer::from_str(items);
        let list = match find(&ROOT_KEYS, key) {
            Some(RootKey::Edges) => List { reader: &mut *self, scope: Scope::Edge },
            Some(RootKey::Vertices) => List { reader: &mut *self, scope: Scope::Node },
            Some(RootKey::Stations) => List { reader: &mut *self, scope: Scope::Station },
            Some(RootKey::AngleUnit | RootKey::Handles) | None => {
                self.count_unknown_key(Scope::File, key);
                return Ok(());
            }
        };
        read_value(list, deserializer).map(drop)
    }

    fn count_unknown_key(&mut self, scope: Scope, key: &str) {
        self.content.count_unknown_key(scope, key, self.at, 1);
    }

    /// Returns an error of the YAML library with its line in the file; `part` is the text that was
    /// read.
    fn syntax_error(&self, part: &str, error: &serde_yaml::Error) -> SyntaxError {
        let start = part.as_ptr().addr().saturating_sub(self.text.as_ptr().addr());
        let before = self.content.report.line(start as u32) as usize;
        let Some(location) = error.location() else {
            return SyntaxError { line: before, message: error.to_string() };
        };
        let line = before - 1 + location.line();
        let message = error.to_string();
        let position = format!(" at line {} column {}", location.line(), location.column());
        let message = message
            .strip_suffix(&position)
            .map(|message| format!("{message}, column {}", location.column()));
        SyntaxError { line, message: message.unwrap_or_else(|| error.to_string()) }
    }

    /// Counts a key and records its position. Returns the key as text.
    fn enter_key<E: Error>(&mut self, key: &Value<'text>) -> Result<String, E> {
        self.count()?;
        if let Value::Text(Cow::Borrowed(slice)) = key {
            let offset = slice.as_ptr().addr().wrapping_sub(self.text.as_ptr().addr());
            if offset < self.text.len() {
                self.at = offset as u32;
            }
        }
        Ok(match key {
            Value::Text(text) => text.as_ref().to_owned(),
            other => other.describe().into_owned(),
        })
    }

    fn count<E: Error>(&mut self) -> Result<(), E> {
        self.entries += 1;
        if self.entries > MAX_ENTRIES {
            return Err(E::custom(format!(
                "more than {MAX_ENTRIES} entries, aliases included: split the graph"
            )));
        }
        Ok(())
    }

    fn file_error(&mut self, message: impl Into<String>) {
        self.content.report.error(self.at, Subject::File, message);
    }

    fn set_angle_unit(&mut self, key: &str, value: &Value<'_>) {
        match value.lowercase().as_str() {
            "deg" | "degree" | "degrees" => self.content.graph.degrees = true,
            "rad" | "radian" | "radians" => self.content.graph.degrees = false,
            _ => self.file_error(format!(
                "`{}` is {}: use rad or deg",
                shorten(key),
                value.describe()
            )),
        }
    }

    fn set_handles(&mut self, key: &str, value: &Value<'_>) {
        match value.lowercase().parse() {
            Ok(handles) => self.content.graph.handles = Some(handles),
            Err(_) => self.file_error(format!(
                "`{}` is {}: use b_at_origin or f_at_origin",
                shorten(key),
                value.describe()
            )),
        }
    }

    fn check_list(&mut self, key: &str, value: &Value<'_>) {
        if !matches!(value, Value::Read | Value::Null) {
            self.file_error(format!("`{}` must be a list, not {}", shorten(key), value.describe()));
        }
    }
}

/// The reader of the root map.
struct Root<'a, 'text>(&'a mut Reader<'text>);

impl<'text> ReadValue<'text> for Root<'_, 'text> {
    fn map<A: MapAccess<'text>>(self, mut map: A) -> Result<Value<'text>, A::Error> {
        let reader = self.0;
        while let Some(key) = map.next_key_seed(Scalar)? {
            let key = reader.enter_key(&key)?;
            let Some(root_key) = find(&ROOT_KEYS, &key) else {
                reader.count_unknown_key(Scope::File, &key);
                map.next_value::<IgnoredAny>()?;
                continue;
            };
            if std::mem::replace(&mut reader.seen[root_key as usize], true) {
                reader
                    .file_error(format!("`{}` is given twice: merge both into one", shorten(&key)));
            }
            match root_key {
                RootKey::Edges => {
                    let list =
                        map.next_value_seed(List { reader: &mut *reader, scope: Scope::Edge })?;
                    reader.check_list(&key, &list);
                }
                RootKey::Vertices => {
                    let list =
                        map.next_value_seed(List { reader: &mut *reader, scope: Scope::Node })?;
                    reader.check_list(&key, &list);
                }
                RootKey::Stations => {
                    let list =
                        map.next_value_seed(List { reader: &mut *reader, scope: Scope::Station })?;
                    reader.check_list(&key, &list);
                }
                RootKey::AngleUnit => reader.set_angle_unit(&key, &map.next_value_seed(Scalar)?),
                RootKey::Handles => reader.set_handles(&key, &map.next_value_seed(Scalar)?),
            }
        }
        Ok(Value::Read)
    }
}

/// The reader of the list of nodes or edges.
struct List<'a, 'text> {
    reader: &'a mut Reader<'text>,
    scope: Scope,
}

impl<'text> ReadValue<'text> for List<'_, 'text> {
    fn list<A: SeqAccess<'text>>(self, mut list: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, scope } = self;
        for number in 1.. {
            reader.count()?;
            let Some(item) = list.next_element_seed(Item { reader: &mut *reader, scope })? else {
                break;
            };
            if item != Value::Read {
                let (name, subject) = match scope {
                    Scope::Edge => ("edge", Subject::Edge(None)),
                    Scope::Station => ("station", Subject::File),
                    _ => ("node", Subject::Node(None)),
                };
                let message = format!(
                    "{name} number {number} of the list must be a map, not {}",
                    item.describe()
                );
                reader.content.report.error(reader.at, subject, message);
            }
        }
        Ok(Value::Read)
    }
}

/// The reader of one node or edge.
struct Item<'a, 'text> {
    reader: &'a mut Reader<'text>,
    scope: Scope,
}

impl_deserialize_seed!(List<'_, 'text>);
impl_deserialize_seed!(Item<'_, 'text>);

impl<'text> ReadValue<'text> for Item<'_, 'text> {
    fn map<A: MapAccess<'text>>(self, mut map: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, scope } = self;
        let keys: &[_] = match scope {
            Scope::Edge => &EDGE_KEYS,
            Scope::Station => &STATION_KEYS,
            Scope::Node | Scope::File => &NODE_KEYS,
        };
        let mut values = Values::default();
        while let Some(key) = map.next_key_seed(Scalar)? {
            let key = reader.enter_key(&key)?;
            values.at.get_or_insert(reader.at);
            match find(keys, &key) {
                Some(Field::Kept) => {
                    if let Some(text) = map.next_value_seed(Scalar)?.text() {
                        values.properties.insert(key.into(), text.into());
                    }
                }
                Some(field @ Field::BodyHeading) => {
                    let value = map.next_value_seed(Scalar)?;
                    // Kept as well: edges may not be able to follow it.
                    if let Some(text) = value.text() {
                        values.properties.insert(key.as_str().into(), text.into());
                    }
                    values.set(field, key, value);
                }
                Some(field @ (Field::ControlPoints | Field::Nodes)) => {
                    let numbers = Numbers { reader: &mut *reader, numbers: &mut values.numbers };
                    let list = map.next_value_seed(numbers)?;
                    reader.check_list(&key, &list);
                    values.set(field, key, list);
                }
                Some(field @ Field::Properties) => {
                    let properties =
                        Properties { reader: &mut *reader, properties: &mut values.properties };
                    let found = map.next_value_seed(properties)?;
                    values.set(field, key, found);
                }
                Some(field) => values.set(field, key, map.next_value_seed(Scalar)?),
                None => {
                    reader.count_unknown_key(scope, &key);
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        values.at.get_or_insert(reader.at);
        match scope {
            Scope::Edge => reader.content.graph.edges.push(values.edge(&mut reader.content.report)),
            Scope::Station => {
                reader.content.graph.stations.extend(values.station(&mut reader.content.report))
            }
            Scope::Node | Scope::File => {
                reader.content.graph.nodes.push(values.node(&mut reader.content.report))
            }
        }
        Ok(Value::Read)
    }
}

/// The reader of a list of numbers, or of lists of them.
struct Numbers<'a, 'text> {
    reader: &'a mut Reader<'text>,
    numbers: &'a mut Vec<f64>,
}

impl_deserialize_seed!(Numbers<'_, 'text>);

impl<'text> ReadValue<'text> for Numbers<'_, 'text> {
    fn list<A: SeqAccess<'text>>(self, mut list: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, numbers } = self;
        loop {
            reader.count()?;
            let inner = Numbers { reader: &mut *reader, numbers: &mut *numbers };
            let Some(value) = list.next_element_seed(inner)? else { break };
            match value.number().filter(|number| number.is_finite()) {
                Some(number) => numbers.push(number),
                None if value == Value::Read => {}
                None => reader.file_error(format!(
                    "a number of a list is {}: give a finite number",
                    value.describe()
                )),
            }
        }
        Ok(Value::Read)
    }
}

/// The reader of a map of texts.
struct Properties<'a, 'text> {
    reader: &'a mut Reader<'text>,
    properties: &'a mut BTreeMap<Box<str>, Box<str>>,
}

impl_deserialize_seed!(Properties<'_, 'text>);

impl<'text> ReadValue<'text> for Properties<'_, 'text> {
    fn map<A: MapAccess<'text>>(self, mut map: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, properties } = self;
        while let Some(key) = map.next_key_seed(Scalar)? {
            let key = reader.enter_key(&key)?;
            if let Some(text) = map.next_value_seed(Scalar)?.text() {
                properties.insert(key.into(), text.into());
            }
        }
        Ok(Value::Read)
    }
}
