//! Reads the YAML of a route graph file, in both spellings of the format. Only the structure is checked here;
//! `validate` checks the numbers.
//!
//! The YAML library returns plain keys as slices of the text, so the address of a key gives its line, in block style
//! and in flow style.

mod sections;

use std::borrow::Cow;
use std::collections::BTreeMap;

use glam::DVec2;
use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess};

use self::sections::Part;
use super::finding::{Report, Subject};
use super::format::SyntaxError;
use super::item::{EDGE_KEYS, Field, NODE_KEYS, RawEdge, RawNode, RawStation, STATION_KEYS, Values, find};
use super::spline::Handles;
use super::value::{ReadValue, Scalar, Value, impl_deserialize_seed, shorten};

/// The largest number of keys and items, those repeated by aliases included. It protects against alias bombs.
pub(super) const MAX_ENTRIES: usize = 3_000_000;

/// The size in bytes from which a file is read part by part if that is possible.
const LARGE: usize = 1 << 20;

/// The largest number of different unknown keys that are reported.
const MAX_UNKNOWN_KEYS: usize = 100;

/// The content of a file: fields are `None` where a value is missing or of the wrong type, which has been reported.
#[derive(Debug, Default)]
pub(super) struct RawGraph {
    pub nodes: Vec<RawNode>,
    pub edges: Vec<RawEdge>,
    pub stations: Vec<RawStation>,
    /// Lines that are drawn behind the graph, in metres.
    pub background: Vec<Vec<DVec2>>,
    pub handles: Option<Handles>,
    pub degrees: bool,
    /// Whether it was made from a layout of another format.
    pub is_imported: bool,
}

/// Reads a YAML text.
///
/// # Errors
/// If the text isn't YAML, or isn't one map. Errors inside the map are reported to `report` instead.
pub(super) fn read<'text>(text: &'text str, report: &mut Report<'text>) -> Result<RawGraph, SyntaxError> {
    let mut reader = Reader {
        text,
        report,
        at: 0,
        entries: 0,
        unknown: BTreeMap::new(),
        graph: RawGraph::default(),
        seen: [false; 5],
    };
    match parts_of_large(text) {
        Some(parts) => parts.into_iter().try_for_each(|part| reader.read_part(part))?,
        None => reader.read_whole(text).map_err(|error| reader.syntax_error(text, &error))?,
    }
    reader.report_unknown_keys();
    Ok(reader.graph)
}

/// Returns the parts of a large text; `None` if it is to be read as a whole.
fn parts_of_large(text: &str) -> Option<Vec<Part<'_>>> {
    (text.len() >= LARGE).then(|| sections::parts(text)).flatten()
}

/// Whether reading a text takes no more memory than the graph itself.
pub(super) fn is_read_in_parts(text: &str) -> bool {
    parts_of_large(text).is_some()
}

struct Reader<'r, 'text> {
    text: &'text str,
    report: &'r mut Report<'text>,
    /// The byte offset of the last key whose position is known.
    at: u32,
    /// The number of keys and items so far.
    entries: usize,
    unknown: BTreeMap<(Scope, String), UnknownKey>,
    graph: RawGraph,
    /// Whether each [`RootKey`] has been seen.
    seen: [bool; 5],
}

struct UnknownKey {
    at: u32,
    count: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Scope {
    File,
    Node,
    Edge,
    Station,
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

impl<'text> Reader<'_, 'text> {
    fn read_whole(&mut self, text: &'text str) -> Result<(), serde_yaml::Error> {
        let root = super::value::read_value(Root(&mut *self), serde_yaml::Deserializer::from_str(text))?;
        match root {
            Value::Read => Ok(()),
            other => Err(Error::custom(format!("expected a map with Edges and Vertices, found {}", other.describe()))),
        }
    }

    /// Reads a part of the root map. What counts keys starts anew: parts have a limited size.
    fn read_part(&mut self, part: Part<'text>) -> Result<(), SyntaxError> {
        self.entries = 0;
        let (Part::Entry(text) | Part::Items { items: text, .. }) = part;
        let result = match part {
            Part::Entry(entry) => self.read_whole(entry),
            Part::Items { key, items } => self.read_items(key, items),
        };
        result.map_err(|error| self.syntax_error(text, &error))
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
        super::value::read_value(list, deserializer).map(drop)
    }

    /// Returns an error of the YAML library with its line in the file; `part` is the text that was read.
    fn syntax_error(&self, part: &str, error: &serde_yaml::Error) -> SyntaxError {
        let start = part.as_ptr().addr().saturating_sub(self.text.as_ptr().addr());
        let before = self.report.line(start as u32) as usize;
        let Some(location) = error.location() else { return SyntaxError { line: before, message: error.to_string() } };
        let line = before - 1 + location.line();
        let message = error.to_string();
        let position = format!(" at line {} column {}", location.line(), location.column());
        let message = message.strip_suffix(&position).map(|message| format!("{message}, column {}", location.column()));
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
            return Err(E::custom(format!("more than {MAX_ENTRIES} entries, aliases included: split the graph")));
        }
        Ok(())
    }

    fn file_error(&mut self, message: impl Into<String>) {
        self.report.error(self.at, Subject::File, message);
    }

    fn count_unknown_key(&mut self, scope: Scope, key: &str) {
        let key = (scope, shorten(key));
        if let Some(unknown) = self.unknown.get_mut(&key) {
            unknown.count += 1;
        } else if self.unknown.len() < MAX_UNKNOWN_KEYS {
            self.unknown.insert(key, UnknownKey { at: self.at, count: 1 });
        }
    }

    fn report_unknown_keys(&mut self) {
        for ((scope, key), UnknownKey { at, count }) in std::mem::take(&mut self.unknown) {
            let owner = match scope {
                Scope::File => "the file",
                Scope::Node => "a node",
                Scope::Edge => "an edge",
                Scope::Station => "a station",
            };
            let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
            let message = format!("`{key}` is not a key of {owner}: ignored{times}; correct it if it is misspelt");
            self.report.warning(at, Subject::File, message);
        }
    }

    fn set_angle_unit(&mut self, key: &str, value: &Value<'_>) {
        match value.lowercase().as_str() {
            "deg" | "degree" | "degrees" => self.graph.degrees = true,
            "rad" | "radian" | "radians" => self.graph.degrees = false,
            _ => self.file_error(format!("`{}` is {}: use rad or deg", shorten(key), value.describe())),
        }
    }

    fn set_handles(&mut self, key: &str, value: &Value<'_>) {
        match value.lowercase().parse() {
            Ok(handles) => self.graph.handles = Some(handles),
            Err(_) => {
                self.file_error(format!("`{}` is {}: use b_at_origin or f_at_origin", shorten(key), value.describe()))
            }
        }
    }

    fn check_list(&mut self, key: &str, value: &Value<'_>) {
        if !matches!(value, Value::Read | Value::Null) {
            self.file_error(format!("`{}` must be a list, not {}", shorten(key), value.describe()));
        }
    }
}

/// The reader of the root map.
struct Root<'a, 'r, 'text>(&'a mut Reader<'r, 'text>);

impl<'text> ReadValue<'text> for Root<'_, '_, 'text> {
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
                reader.file_error(format!("`{}` is given twice: merge both into one", shorten(&key)));
            }
            match root_key {
                RootKey::Edges => {
                    let list = map.next_value_seed(List { reader: &mut *reader, scope: Scope::Edge })?;
                    reader.check_list(&key, &list);
                }
                RootKey::Vertices => {
                    let list = map.next_value_seed(List { reader: &mut *reader, scope: Scope::Node })?;
                    reader.check_list(&key, &list);
                }
                RootKey::Stations => {
                    let list = map.next_value_seed(List { reader: &mut *reader, scope: Scope::Station })?;
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
struct List<'a, 'r, 'text> {
    reader: &'a mut Reader<'r, 'text>,
    scope: Scope,
}

impl<'text> ReadValue<'text> for List<'_, '_, 'text> {
    fn list<A: SeqAccess<'text>>(self, mut list: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, scope } = self;
        for number in 1.. {
            reader.count()?;
            let Some(item) = list.next_element_seed(Item { reader: &mut *reader, scope })? else { break };
            if item != Value::Read {
                let (name, subject) = match scope {
                    Scope::Edge => ("edge", Subject::Edge(None)),
                    Scope::Station => ("station", Subject::File),
                    _ => ("node", Subject::Node(None)),
                };
                let message = format!("{name} number {number} of the list must be a map, not {}", item.describe());
                reader.report.error(reader.at, subject, message);
            }
        }
        Ok(Value::Read)
    }
}

/// The reader of one node or edge.
struct Item<'a, 'r, 'text> {
    reader: &'a mut Reader<'r, 'text>,
    scope: Scope,
}

impl_deserialize_seed!(List<'_, '_, 'text>);
impl_deserialize_seed!(Item<'_, '_, 'text>);

impl<'text> ReadValue<'text> for Item<'_, '_, 'text> {
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
                Some(field @ (Field::ControlPoints | Field::Nodes)) => {
                    let numbers = Numbers { reader: &mut *reader, numbers: &mut values.numbers };
                    let list = map.next_value_seed(numbers)?;
                    reader.check_list(&key, &list);
                    values.set(field, key, list);
                }
                Some(field @ Field::Properties) => {
                    let properties = Properties { reader: &mut *reader, properties: &mut values.properties };
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
            Scope::Edge => reader.graph.edges.push(values.edge(reader.report)),
            Scope::Station => reader.graph.stations.extend(values.station(reader.report)),
            Scope::Node | Scope::File => reader.graph.nodes.push(values.node(reader.report)),
        }
        Ok(Value::Read)
    }
}

/// The reader of a list of numbers, or of lists of them.
struct Numbers<'a, 'r, 'text> {
    reader: &'a mut Reader<'r, 'text>,
    numbers: &'a mut Vec<f64>,
}

impl_deserialize_seed!(Numbers<'_, '_, 'text>);

impl<'text> ReadValue<'text> for Numbers<'_, '_, 'text> {
    fn list<A: SeqAccess<'text>>(self, mut list: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, numbers } = self;
        loop {
            reader.count()?;
            let inner = Numbers { reader: &mut *reader, numbers: &mut *numbers };
            let Some(value) = list.next_element_seed(inner)? else { break };
            match value.number().filter(|number| number.is_finite()) {
                Some(number) => numbers.push(number),
                None if value == Value::Read => {}
                None => reader.file_error(format!("a number of a list is {}: give a finite number", value.describe())),
            }
        }
        Ok(Value::Read)
    }
}

/// The reader of a map of texts.
struct Properties<'a, 'r, 'text> {
    reader: &'a mut Reader<'r, 'text>,
    properties: &'a mut BTreeMap<Box<str>, Box<str>>,
}

impl_deserialize_seed!(Properties<'_, '_, 'text>);

impl<'text> ReadValue<'text> for Properties<'_, '_, 'text> {
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
