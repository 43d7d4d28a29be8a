//! Reads the tree of a YAML text.

use std::collections::BTreeMap;

use regatta_base::yaml::{self, Node};

use super::sections::Part;
use super::{Content, Scope};
use crate::model::finding::Subject;
use crate::model::keys::{
    BACKGROUND_KEYS, DOOR_KEYS, EDGE_KEYS, Field, LIFT_KEYS, NODE_KEYS, STATION_KEYS, ZONE_KEYS,
    find,
};
use crate::model::value::{Value, shorten};
use crate::model::values::Values;
use crate::read::file::SyntaxError;

/// The reader of a part of a text.
pub(super) struct Reader<'text> {
    content: Content<'text>,
    /// The byte offset of the part in the file.
    start: usize,
    /// The keys of the root map so far.
    seen: Vec<RootKey>,
}

/// A key of the root map.
#[derive(Clone, Copy, PartialEq, Eq)]
enum RootKey {
    List(Scope),
    AngleUnit,
    Handles,
}

/// The names of the root keys, normalized as by [`find`].
const ROOT_KEYS: [(&str, RootKey); 10] = [
    ("edges", RootKey::List(Scope::Edge)),
    ("vertices", RootKey::List(Scope::Node)),
    ("nodes", RootKey::List(Scope::Node)),
    ("stations", RootKey::List(Scope::Station)),
    ("zones", RootKey::List(Scope::Zone)),
    ("doors", RootKey::List(Scope::Door)),
    ("lifts", RootKey::List(Scope::Lift)),
    ("background", RootKey::List(Scope::Background)),
    ("angleunit", RootKey::AngleUnit),
    ("handles", RootKey::Handles),
];

/// A key of a map, with its place.
struct Key {
    /// The byte offset in the file.
    at: u32,
    name: String,
}

impl<'text> Reader<'text> {
    /// Makes a reader that adds to `content`.
    pub fn new(content: Content<'text>) -> Self {
        Self { content, start: 0, seen: Vec::new() }
    }

    /// Reads a part of the root map.
    pub fn read(mut self, part: Part<'text>) -> Result<Content<'text>, SyntaxError> {
        self.start = part.start;
        let line = self.content.report.line(part.start as u32) as usize;
        let node = yaml::parse(part.text)
            .map_err(|error| SyntaxError::new(line - 1 + error.line, error.reason))?;
        match (part.key, node.content) {
            (Some(name), content) => {
                let key = Key { at: part.start as u32, name: name.to_owned() };
                self.root_entry(key, Node { content, ..node });
            }
            (None, yaml::Content::Map(pairs)) => {
                for (key, value) in pairs {
                    let key = self.key(key);
                    self.root_entry(key, value);
                }
            }
            (None, other) => {
                let found = Value::from(other);
                let message =
                    format!("expected a map with Edges and Vertices, found {}", found.describe());
                return Err(SyntaxError::new(line, message));
            }
        }
        Ok(self.content)
    }

    fn at(&self, node: &Node<'_>) -> u32 {
        (self.start + node.offset) as u32
    }

    fn key(&self, node: Node<'_>) -> Key {
        let at = self.at(&node);
        let name = match Value::from(node.content) {
            Value::Text(text) => text.into_owned(),
            other => other.describe().into_owned(),
        };
        Key { at, name }
    }

    fn file_error(&mut self, at: u32, message: impl Into<String>) {
        self.content.report.file_error(at, message);
    }

    /// Reads a key of the root map.
    fn root_entry(&mut self, key: Key, value: Node<'text>) {
        let Some(root_key) = find(&ROOT_KEYS, &key.name) else {
            self.content.count_unknown_key(Scope::File, &key.name, key.at, 1);
            return;
        };
        if self.seen.contains(&root_key) {
            let name = shorten(&key.name);
            self.file_error(key.at, format!("`{name}` is given twice: merge both into one"));
        }
        self.seen.push(root_key);
        match root_key {
            RootKey::List(scope) => {
                for (number, item) in (1..).zip(self.list(&key, value)) {
                    self.item(scope, number, item);
                }
            }
            RootKey::AngleUnit => self.set_angle_unit(&key, &value.content.into()),
            RootKey::Handles => self.set_handles(&key, &value.content.into()),
        }
    }

    fn set_angle_unit(&mut self, key: &Key, value: &Value<'_>) {
        self.content.graph.is_angle_unit_known = true;
        match value.lowercase().as_str() {
            "deg" | "degree" | "degrees" => self.content.graph.degrees = true,
            "rad" | "radian" | "radians" => self.content.graph.degrees = false,
            _ => {
                let (name, value) = (shorten(&key.name), value.describe());
                self.file_error(key.at, format!("`{name}` is {value}: use rad or deg"));
            }
        }
    }

    fn set_handles(&mut self, key: &Key, value: &Value<'_>) {
        if let Ok(handles) = value.lowercase().parse() {
            self.content.graph.handles = Some(handles);
            return;
        }
        let (name, value) = (shorten(&key.name), value.describe());
        self.file_error(key.at, format!("`{name}` is {value}: use b_at_origin or f_at_origin"));
    }

    /// Returns the items of the list that is the value of a key.
    fn list(&mut self, key: &Key, value: Node<'text>) -> Vec<Node<'text>> {
        match value.content {
            yaml::Content::List(items) => return items,
            yaml::Content::Null => {}
            other => {
                let (name, found) = (shorten(&key.name), Value::from(other));
                let message = format!("`{name}` must be a list, not {}", found.describe());
                self.file_error(key.at, message);
            }
        }
        Vec::new()
    }

    /// Reads an item of a list of the root map.
    fn item(&mut self, scope: Scope, number: usize, item: Node<'text>) {
        let at = self.at(&item);
        let pairs = match item.content {
            yaml::Content::Map(pairs) => pairs,
            other => {
                let (name, subject) = match scope {
                    Scope::Edge => ("edge", Subject::Edge(None)),
                    Scope::Station => ("station", Subject::File),
                    Scope::Zone => ("zone", Subject::File),
                    Scope::Door => ("door", Subject::File),
                    Scope::Lift => ("lift", Subject::File),
                    Scope::Background => ("background line", Subject::File),
                    Scope::Node | Scope::File => ("node", Subject::Node(None)),
                };
                let found = Value::from(other);
                let message = format!(
                    "{name} number {number} of the list must be a map, not {}",
                    found.describe()
                );
                self.content.report.error(at, subject, message);
                return;
            }
        };
        let mut values = Values::default();
        for (key, value) in pairs {
            let key = self.key(key);
            values.at.get_or_insert(key.at);
            self.entry(scope, &mut values, key, value);
        }
        values.at.get_or_insert(at);
        let Content { graph, report, .. } = &mut self.content;
        match scope {
            Scope::Edge => graph.edges.push(values.edge(report)),
            Scope::Station => graph.stations.extend(values.station(report)),
            Scope::Zone => graph.zones.extend(values.zone(report)),
            Scope::Door => graph.doors.extend(values.door(report)),
            Scope::Lift => graph.lifts.extend(values.lift(report)),
            Scope::Background => graph.background.extend(values.background_line(report)),
            Scope::Node | Scope::File => graph.nodes.push(values.node(report)),
        }
    }

    /// Reads a key of an item.
    fn entry(&mut self, scope: Scope, values: &mut Values<'text>, key: Key, value: Node<'text>) {
        let keys: &[_] = match scope {
            Scope::Edge => &EDGE_KEYS,
            Scope::Station => &STATION_KEYS,
            Scope::Zone => &ZONE_KEYS,
            Scope::Door => &DOOR_KEYS,
            Scope::Lift => &LIFT_KEYS,
            Scope::Background => &BACKGROUND_KEYS,
            Scope::Node | Scope::File => &NODE_KEYS,
        };
        let Some(field) = find(keys, &key.name) else {
            self.content.count_unknown_key(scope, &key.name, key.at, 1);
            return;
        };
        match field {
            Field::ControlPoints | Field::Nodes => {
                for item in self.list(&key, value) {
                    self.add_numbers(item, &mut values.numbers);
                }
                values.set(field, key.name, Value::Other("a list"));
            }
            Field::Edges => {
                for item in self.list(&key, value) {
                    self.add_numbers(item, &mut values.edges);
                }
                values.set(field, key.name, Value::Other("a list"));
            }
            Field::Properties => {
                self.add_properties(value, &mut values.properties);
                values.set(field, key.name, Value::Other("a map"));
            }
            Field::Kept => add_property(&key.name, &value.content.into(), &mut values.properties),
            Field::BodyHeading => {
                let value = value.content.into();
                // The key is also kept as a property, because edges may be unable to follow it.
                add_property(&key.name, &value, &mut values.properties);
                values.set(field, key.name, value);
            }
            _ => values.set(field, key.name, value.content.into()),
        }
    }

    /// Adds a number, or the numbers of nested lists.
    fn add_numbers(&mut self, node: Node<'text>, numbers: &mut Vec<f64>) {
        let at = self.at(&node);
        if let yaml::Content::List(items) = node.content {
            for item in items {
                self.add_numbers(item, numbers);
            }
            return;
        }
        let value = Value::from(node.content);
        match value.number().filter(|number| number.is_finite()) {
            Some(number) => numbers.push(number),
            None => self.file_error(
                at,
                format!("a number of a list is {}: give a finite number", value.describe()),
            ),
        }
    }

    fn add_properties(&self, map: Node<'text>, properties: &mut Properties) {
        if let yaml::Content::Map(pairs) = map.content {
            for (key, value) in pairs {
                add_property(&self.key(key).name, &value.content.into(), properties);
            }
        }
    }
}

type Properties = BTreeMap<Box<str>, Box<str>>;

/// Adds a property, unless its value is null.
fn add_property(key: &str, value: &Value<'_>, properties: &mut Properties) {
    if let Some(text) = value.text() {
        properties.insert(key.into(), text.into());
    }
}
