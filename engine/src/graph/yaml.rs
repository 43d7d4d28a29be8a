//! The YAML of a route graph file, in both spellings, as far as it makes sense; nothing is judged here but the
//! shape: `validate` looks at the numbers.
//!
//! yaml_serde hands out plain keys as slices of the text, so a key's address tells its line, in block and in flow
//! style alike.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::de::{Error, MapAccess, SeqAccess};

use super::finding::{Report, Subject};
use super::spline::Handles;
use super::value::{Expect, Scalar, Value, expect_seed, shorten};

/// Keys and items read before aliases count as an attack; also the most that a file without aliases can hold.
pub(super) const MAX_ENTRIES: usize = 3_000_000;

/// Unknown keys that are told apart.
const MAX_UNKNOWN_KEYS: usize = 100;

/// A file's content: `None` where something is missing or of the wrong shape, which has been reported.
#[derive(Debug, Default)]
pub(super) struct RawGraph {
    pub nodes: Vec<RawNode>,
    pub edges: Vec<RawEdge>,
    pub handles: Option<Handles>,
    pub degrees: bool,
}

/// A node as written: numbers are finite, but of any size.
#[derive(Debug)]
pub(super) struct RawNode {
    /// Byte offset of its first key.
    pub at: u32,
    pub id: Option<u32>,
    pub x: Option<f64>,
    pub y: Option<f64>,
    pub theta: Option<f64>,
}

/// An edge as written: numbers are finite, but of any size.
#[derive(Debug)]
pub(super) struct RawEdge {
    /// Byte offset of its first key.
    pub at: u32,
    pub id: Option<u32>,
    pub origin: Option<u32>,
    pub destination: Option<u32>,
    pub curve: Option<RawCurve>,
    pub velocity_forward: Option<f64>,
    /// 0 if it isn't given.
    pub velocity_backwards: Option<f64>,
}

/// The course of an edge as written.
#[derive(Debug)]
pub(super) enum RawCurve {
    Linear,
    Spline { forward: f64, backward: f64 },
}

/// Reads a YAML text.
///
/// # Errors
/// If it isn't YAML, or not one map. What is wrong inside is reported instead.
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
        return Err(Error::custom(format!("expected a map with Edges and Vertices, this is {}", root.describe())));
    }
    reader.report_unknown_keys();
    Ok(reader.graph)
}

struct Reader<'r, 'text> {
    text: &'text str,
    report: &'r mut Report<'text>,
    /// Byte offset of the last key whose place is known.
    at: u32,
    entries: usize,
    unknown: BTreeMap<(Scope, String), UnknownKey>,
    graph: RawGraph,
    /// Which root keys have been met.
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

/// Keys of a node or an edge.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Field {
    Id,
    X,
    Y,
    Theta,
    Origin,
    Destination,
    CurveType,
    ParamF,
    ParamB,
    VelocityForward,
    VelocityBackwards,
    /// Part of the format, of no use here.
    Unused,
}

const FIELDS: usize = Field::Unused as usize;

/// Root keys: the place in [`Reader::seen`] is the same for two names of one thing.
const ROOT_KEYS: [(&str, usize); 5] = [("edges", 0), ("vertices", 1), ("nodes", 1), ("angleunit", 2), ("handles", 3)];

const NODE_KEYS: [(&str, Field); 8] = [
    ("id", Field::Id),
    ("x", Field::X),
    ("y", Field::Y),
    ("theta", Field::Theta),
    ("frameid", Field::Unused),
    ("label", Field::Unused),
    ("thetaholomonic", Field::Unused),
    ("thetaholonomic", Field::Unused),
];

const EDGE_KEYS: [(&str, Field); 9] = [
    ("id", Field::Id),
    ("originid", Field::Origin),
    ("destinationid", Field::Destination),
    ("curvetype", Field::CurveType),
    ("paramf", Field::ParamF),
    ("paramb", Field::ParamB),
    ("velocityforward", Field::VelocityForward),
    ("velocitybackwards", Field::VelocityBackwards),
    ("velocitybackward", Field::VelocityBackwards),
];

/// Looks a key up without regard to case, `_`, `-` and spaces.
fn find<T: Copy>(keys: &[(&str, T)], key: &str) -> Option<T> {
    let letters = || key.bytes().filter(|byte| !b"_- ".contains(byte)).map(|byte| byte.to_ascii_lowercase());
    keys.iter().find(|(name, _)| letters().eq(name.bytes())).map(|&(_, found)| found)
}

impl<'text> Reader<'_, 'text> {
    /// Notes where a key stands and takes it into account.
    fn enter<E: Error>(&mut self, key: &Value<'text>) -> Result<String, E> {
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

    fn unknown_key(&mut self, scope: Scope, key: &str) {
        let key = (scope, shorten(key));
        if let Some(known) = self.unknown.get_mut(&key) {
            known.count += 1;
        } else if self.unknown.len() < MAX_UNKNOWN_KEYS {
            self.unknown.insert(key, UnknownKey { at: self.at, count: 1 });
        }
    }

    fn report_unknown_keys(&mut self) {
        for ((scope, key), UnknownKey { at, count }) in std::mem::take(&mut self.unknown) {
            let of = match scope {
                Scope::File => "the file",
                Scope::Node => "a node",
                Scope::Edge => "an edge",
            };
            let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
            let message = format!("`{key}` is not a key of {of}: ignored{times}; correct it if it is misspelt");
            self.report.warning(at, Subject::File, message);
        }
    }

    fn setting(&mut self, key: &str, value: &Value<'_>, which: usize) {
        let text = if let Value::Text(text) = value { text.trim() } else { "" };
        let lower = text.to_ascii_lowercase();
        match (which, lower.as_str()) {
            (2, "deg" | "degree" | "degrees") => self.graph.degrees = true,
            (2, "rad" | "radian" | "radians") => self.graph.degrees = false,
            (2, _) => self.file_error(format!("`{}` is {}: use rad or deg", shorten(key), value.describe())),
            _ => match lower.parse() {
                Ok(handles) => self.graph.handles = Some(handles),
                Err(_) => self.file_error(format!(
                    "`{}` is {}: use b_at_origin or f_at_origin",
                    shorten(key),
                    value.describe()
                )),
            },
        }
    }
}

/// The map that is the whole file.
struct Root<'a, 'r, 'text>(&'a mut Reader<'r, 'text>);

impl<'text> Expect<'text> for Root<'_, '_, 'text> {
    fn map<A: MapAccess<'text>>(self, mut map: A) -> Result<Value<'text>, A::Error> {
        let reader = self.0;
        while let Some(key) = map.next_key_seed(Scalar)? {
            let key = reader.enter(&key)?;
            let Some(which) = find(&ROOT_KEYS, &key) else {
                reader.unknown_key(Scope::File, &key);
                map.next_value::<serde::de::IgnoredAny>()?;
                continue;
            };
            if std::mem::replace(&mut reader.seen[which], true) {
                reader.file_error(format!("`{}` is given twice: put all into one", shorten(&key)));
            }
            let scope = [Scope::Edge, Scope::Node].get(which).copied();
            let value = match scope {
                Some(scope) => map.next_value_seed(List { reader: &mut *reader, scope })?,
                None => map.next_value_seed(Scalar)?,
            };
            match (scope, &value) {
                (Some(_), Value::Read | Value::Nothing) => {}
                (Some(_), other) => {
                    reader.file_error(format!("`{}` must be a list, not {}", shorten(&key), other.describe()))
                }
                (None, value) => reader.setting(&key, value, which),
            }
        }
        Ok(Value::Read)
    }
}

/// The list of nodes or of edges.
struct List<'a, 'r, 'text> {
    reader: &'a mut Reader<'r, 'text>,
    scope: Scope,
}

impl<'text> Expect<'text> for List<'_, '_, 'text> {
    fn list<A: SeqAccess<'text>>(self, mut list: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, scope } = self;
        for number in 1.. {
            reader.count()?;
            let Some(item) = list.next_element_seed(Item { reader: &mut *reader, scope })? else { break };
            if item != Value::Read {
                let (kind, subject) = match scope {
                    Scope::Edge => ("edge", Subject::Edge(None)),
                    _ => ("node", Subject::Node(None)),
                };
                let message = format!("{kind} number {number} of the list must be a map, not {}", item.describe());
                reader.report.error(reader.at, subject, message);
            }
        }
        Ok(Value::Read)
    }
}

/// One node or edge.
struct Item<'a, 'r, 'text> {
    reader: &'a mut Reader<'r, 'text>,
    scope: Scope,
}

expect_seed!(List<'_, '_, 'text>);
expect_seed!(Item<'_, '_, 'text>);

impl<'text> Expect<'text> for Item<'_, '_, 'text> {
    fn map<A: MapAccess<'text>>(self, mut map: A) -> Result<Value<'text>, A::Error> {
        let Self { reader, scope } = self;
        let mut at = None;
        let mut values = [const { None }; FIELDS];
        let mut twice = Vec::new();
        while let Some(key) = map.next_key_seed(Scalar)? {
            let key = reader.enter(&key)?;
            at.get_or_insert(reader.at);
            let keys: &[_] = if scope == Scope::Edge { &EDGE_KEYS } else { &NODE_KEYS };
            let field = find(keys, &key);
            if field.is_none() {
                reader.unknown_key(scope, &key);
            }
            let Some(field) = field.filter(|&field| field != Field::Unused) else {
                map.next_value::<serde::de::IgnoredAny>()?;
                continue;
            };
            if values[field as usize].replace(map.next_value_seed(Scalar)?).is_some() && twice.len() < FIELDS {
                twice.push(key);
            }
        }
        Fields { at: at.unwrap_or(reader.at), values, report: &mut *reader.report, subject: Subject::File }.finish(
            scope,
            &twice,
            &mut reader.graph,
        );
        Ok(Value::Read)
    }
}

/// The values of one node or edge, with the means to complain about them.
struct Fields<'a, 'text> {
    at: u32,
    values: [Option<Value<'text>>; FIELDS],
    report: &'a mut Report<'text>,
    subject: Subject,
}

impl Fields<'_, '_> {
    fn finish(mut self, scope: Scope, twice: &[String], graph: &mut RawGraph) {
        let edge = scope == Scope::Edge;
        self.subject = if edge { Subject::Edge(None) } else { Subject::Node(None) };
        let id = self.id(Field::Id, "Id");
        self.subject = if edge { Subject::Edge(id) } else { Subject::Node(id) };
        for key in twice {
            self.error(format!("`{}` is given twice: remove one", shorten(key)));
        }
        if edge {
            graph.edges.push(self.edge(id));
        } else {
            graph.nodes.push(self.node(id));
        }
    }

    fn node(mut self, id: Option<u32>) -> RawNode {
        RawNode {
            at: self.at,
            id,
            x: self.number(Field::X, "X"),
            y: self.number(Field::Y, "Y"),
            theta: self.number(Field::Theta, "Theta"),
        }
    }

    fn edge(mut self, id: Option<u32>) -> RawEdge {
        RawEdge {
            at: self.at,
            id,
            origin: self.id(Field::Origin, "Origin_ID"),
            destination: self.id(Field::Destination, "Destination_ID"),
            curve: self.curve(),
            velocity_forward: self.number(Field::VelocityForward, "VelocityForward"),
            velocity_backwards: match self.value(Field::VelocityBackwards) {
                None | Some(Value::Nothing) => Some(0.0),
                Some(_) => self.number(Field::VelocityBackwards, "VelocityBackwards"),
            },
        }
    }

    fn curve(&mut self) -> Option<RawCurve> {
        let name = match self.value(Field::CurveType) {
            Some(Value::Text(text)) => text.trim().to_ascii_lowercase(),
            _ => String::new(),
        };
        match name.as_str() {
            "linear" => Some(RawCurve::Linear),
            "spline" => {
                let (forward, backward) = (self.number(Field::ParamF, "ParamF"), self.number(Field::ParamB, "ParamB"));
                Some(RawCurve::Spline { forward: forward?, backward: backward? })
            }
            _ => {
                let message = match self.value(Field::CurveType) {
                    None => "has no CurveType: give Spline or Linear".to_owned(),
                    Some(other) => format!("CurveType is {}: use Spline or Linear", other.describe()),
                };
                self.error(message);
                None
            }
        }
    }

    fn value(&self, field: Field) -> Option<&Value<'_>> {
        self.values[field as usize].as_ref()
    }

    fn number(&mut self, field: Field, name: &str) -> Option<f64> {
        let message = match self.value(field) {
            None => format!("has no {name}: give one"),
            Some(value) => match value.number() {
                Some(number) if number.is_finite() => return Some(number),
                _ => format!("{name} is {}: it must be a finite number", value.describe()),
            },
        };
        self.error(message);
        None
    }

    fn id(&mut self, field: Field, name: &str) -> Option<u32> {
        let message = match self.value(field) {
            None => format!("has no {name}: give one"),
            Some(value) => match value.number() {
                Some(number) if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) => {
                    return Some(number as u32);
                }
                _ => format!("{name} is {}: it must be a whole number from 0 to {}", value.describe(), u32::MAX),
            },
        };
        self.error(message);
        None
    }

    fn error(&mut self, message: String) {
        self.report.error(self.at, self.subject, message);
    }
}
