//! A node or an edge of a file: its keys, and the types of their values.

use super::finding::{Report, Subject};
use super::value::{Value, shorten};

/// A node as written in the file: its numbers are finite, but not yet range-checked.
#[derive(Debug)]
pub(super) struct RawNode {
    /// The byte offset of its first key.
    pub at: u32,
    pub id: Option<u32>,
    pub x: Option<f64>,
    pub y: Option<f64>,
    pub theta: Option<f64>,
}

/// An edge as written in the file: its numbers are finite, but not yet range-checked.
#[derive(Debug)]
pub(super) struct RawEdge {
    /// The byte offset of its first key.
    pub at: u32,
    pub id: Option<u32>,
    pub origin: Option<u32>,
    pub destination: Option<u32>,
    pub curve: Option<RawCurve>,
    /// `ParamF` in metres, if given.
    pub forward: Option<f64>,
    /// `ParamB` in metres, if given.
    pub backward: Option<f64>,
    pub velocity_forward: Option<f64>,
    /// 0 if not given.
    pub velocity_backwards: Option<f64>,
}

/// The curve type of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RawCurve {
    Linear,
    Spline,
}

/// The keys of nodes and edges.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Field {
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
    /// A key that is part of the format but isn't used.
    Unused,
}

/// The number of fields with a value.
const FIELDS: usize = Field::Unused as usize;

/// The keys of a node, normalized as by [`find`].
pub(super) const NODE_KEYS: [(&str, Field); 8] = [
    ("id", Field::Id),
    ("x", Field::X),
    ("y", Field::Y),
    ("theta", Field::Theta),
    ("frameid", Field::Unused),
    ("label", Field::Unused),
    ("thetaholomonic", Field::Unused),
    ("thetaholonomic", Field::Unused),
];

/// The keys of an edge, normalized as by [`find`].
pub(super) const EDGE_KEYS: [(&str, Field); 9] = [
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

/// Looks up a key, ignoring case, `_`, `-` and spaces.
pub(super) fn find<T: Copy>(keys: &[(&str, T)], key: &str) -> Option<T> {
    let letters = || key.bytes().filter(|byte| !b"_- ".contains(byte)).map(|byte| byte.to_ascii_lowercase());
    keys.iter().find(|(name, _)| letters().eq(name.bytes())).map(|&(_, found)| found)
}

/// The values of one node or edge, by field.
#[derive(Default)]
pub(super) struct Values<'text> {
    /// The byte offset of the first key.
    pub at: Option<u32>,
    values: [Option<Value<'text>>; FIELDS],
    /// The keys that are given more than once.
    duplicates: Vec<String>,
}

impl<'text> Values<'text> {
    pub fn set(&mut self, field: Field, key: String, value: Value<'text>) {
        if self.values[field as usize].replace(value).is_some() && self.duplicates.len() < FIELDS {
            self.duplicates.push(key);
        }
    }

    /// Converts the values to a node and reports errors.
    pub fn node(self, report: &mut Report<'_>) -> RawNode {
        let (converter, id) = Converter::new(self, report, Subject::Node);
        converter.node(id)
    }

    /// Converts the values to an edge and reports errors.
    pub fn edge(self, report: &mut Report<'_>) -> RawEdge {
        let (converter, id) = Converter::new(self, report, Subject::Edge);
        converter.edge(id)
    }
}

/// Converts values, reporting errors with the place and the subject.
struct Converter<'r, 'text, 'file> {
    at: u32,
    values: [Option<Value<'text>>; FIELDS],
    report: &'r mut Report<'file>,
    subject: Subject,
}

impl<'r, 'text, 'file> Converter<'r, 'text, 'file> {
    fn new(
        values: Values<'text>,
        report: &'r mut Report<'file>,
        subject: fn(Option<u32>) -> Subject,
    ) -> (Self, Option<u32>) {
        let Values { at, values, duplicates } = values;
        let mut converter = Self { at: at.unwrap_or(0), values, report, subject: subject(None) };
        let id = converter.id(Field::Id, "Id");
        converter.subject = subject(id);
        for key in duplicates {
            converter.error(format!("`{}` is given twice: remove one", shorten(&key)));
        }
        (converter, id)
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
        let curve = self.curve();
        let required = curve == Some(RawCurve::Spline);
        RawEdge {
            at: self.at,
            id,
            origin: self.id(Field::Origin, "Origin_ID"),
            destination: self.id(Field::Destination, "Destination_ID"),
            curve,
            forward: self.handle(Field::ParamF, "ParamF", required),
            backward: self.handle(Field::ParamB, "ParamB", required),
            velocity_forward: self.number(Field::VelocityForward, "VelocityForward"),
            velocity_backwards: match self.value(Field::VelocityBackwards) {
                None | Some(Value::Null) => Some(0.0),
                Some(_) => self.number(Field::VelocityBackwards, "VelocityBackwards"),
            },
        }
    }

    /// Converts a handle length. Straight edges are checked too, so that all errors are reported at once.
    fn handle(&mut self, field: Field, name: &str, required: bool) -> Option<f64> {
        match self.value(field) {
            None | Some(Value::Null) if !required => None,
            _ => self.number(field, name),
        }
    }

    fn curve(&mut self) -> Option<RawCurve> {
        let name = self.value(Field::CurveType).map(Value::lowercase).unwrap_or_default();
        match name.as_str() {
            "linear" => Some(RawCurve::Linear),
            "spline" => Some(RawCurve::Spline),
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
