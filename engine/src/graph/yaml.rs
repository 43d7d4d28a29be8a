//! Reads the YAML of a route graph file, in both spellings of the format. Only the structure is checked here;
//! `validate` checks the numbers.
//!
//! The YAML library returns plain keys as slices of the text, so the address of a key gives its line, in block style
//! and in flow style.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::de::{Error, IgnoredAny, MapAccess, SeqAccess};

use super::finding::{Report, Subject};
use super::item::{EDGE_KEYS, Field, NODE_KEYS, RawEdge, RawNode, Values, find};
use super::spline::Handles;
use super::value::{ReadValue, Scalar, Value, impl_deserialize_seed, shorten};

/// The largest number of keys and items, those repeated by aliases included. It protects against alias bombs.
pub(super) const MAX_ENTRIES: usize = 3_000_000;

/// The largest number of different unknown keys that are reported.
const MAX_UNKNOWN_KEYS: usize = 100;

/// The content of a file: fields are `None` where a value is missing or of the wrong type, which has been reported.
#[derive(Debug, Default)]
pub(super) struct RawGraph {
    pub nodes: Vec<RawNode>,
    pub edges: Vec<RawEdge>,
    pub handles: Option<Handles>,
    pub degrees: bool,
}

/// Reads a YAML text.
///
/// # Errors
/// If the text isn't YAML, or isn't one map. Errors inside the map are reported to `report` instead.
pub(super) fn read<'text>(text: &'text str, report: &mut Report<'text>) -> Result<RawGraph, serde_yaml::Error> {
    let mut reader = Reader {
        text,
        report,
        at: 0,
        entries: 0,
        unknown: BTreeMap::new(),
        graph: RawGraph::default(),
        seen: [false; 4],
    };
    let deserializer = serde_yaml::Deserializer::from_str(text);
    let root = super::value::read_value(Root(&mut reader), deserializer)?;
    if root != Value::Read {
        return Err(Error::custom(format!("expected a map with Edges and Vertices, found {}", root.describe())));
    }
    reader.report_unknown_keys();
    Ok(reader.graph)
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
    seen: [bool; 4],
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
}

/// A key of the root map.
#[derive(Clone, Copy, PartialEq, Eq)]
enum RootKey {
    Edges,
    Vertices,
    AngleUnit,
    Handles,
}

/// The names of the root keys, normalized as by [`find`].
const ROOT_KEYS: [(&str, RootKey); 5] = [
    ("edges", RootKey::Edges),
    ("vertices", RootKey::Vertices),
    ("nodes", RootKey::Vertices),
    ("angleunit", RootKey::AngleUnit),
    ("handles", RootKey::Handles),
];

impl<'text> Reader<'_, 'text> {
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
        let keys: &[_] = if scope == Scope::Edge { &EDGE_KEYS } else { &NODE_KEYS };
        let mut values = Values::default();
        while let Some(key) = map.next_key_seed(Scalar)? {
            let key = reader.enter_key(&key)?;
            values.at.get_or_insert(reader.at);
            match find(keys, &key) {
                Some(Field::Unused) => drop(map.next_value::<IgnoredAny>()?),
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
            _ => reader.graph.nodes.push(values.node(reader.report)),
        }
        Ok(Value::Read)
    }
}
