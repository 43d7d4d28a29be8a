//! One node or edge of a file: which keys it may have, and what their values must be.

use super::finding::{Report, Subject};
use super::value::{Value, shorten};

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
    /// Lengths of the handles in metres, where they are given.
    pub forward: Option<f64>,
    pub backward: Option<f64>,
    pub velocity_forward: Option<f64>,
    /// 0 if it isn't given.
    pub velocity_backwards: Option<f64>,
}

/// The course of an edge as written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RawCurve {
    Linear,
    Spline,
}

/// Keys of a node or an edge.
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
    /// Part of the format, of no use here.
    Unused,
}

pub(super) const FIELDS: usize = Field::Unused as usize;

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

/// Looks a key up without regard to case, `_`, `-` and spaces.
pub(super) fn find<T: Copy>(keys: &[(&str, T)], key: &str) -> Option<T> {
    let letters = || key.bytes().filter(|byte| !b"_- ".contains(byte)).map(|byte| byte.to_ascii_lowercase());
    keys.iter().find(|(name, _)| letters().eq(name.bytes())).map(|&(_, found)| found)
}

/// The values of one node or edge by key.
#[derive(Default)]
pub(super) struct Values<'text> {
    /// Byte offset of the first key.
    pub at: Option<u32>,
    values: [Option<Value<'text>>; FIELDS],
    /// Keys that came again.
    twice: Vec<String>,
}

impl<'text> Values<'text> {
    pub fn set(&mut self, field: Field, key: String, value: Value<'text>) {
        if self.values[field as usize].replace(value).is_some() && self.twice.len() < FIELDS {
            self.twice.push(key);
        }
    }

    /// The node; reports what is wrong with it.
    pub fn node(self, report: &mut Report<'_>) -> RawNode {
        let (fields, id) = Fields::new(self, report, Subject::Node);
        fields.node(id)
    }

    /// The edge; reports what is wrong with it.
    pub fn edge(self, report: &mut Report<'_>) -> RawEdge {
        let (fields, id) = Fields::new(self, report, Subject::Edge);
        fields.edge(id)
    }
}

/// Values with the means to complain about them.
struct Fields<'r, 'text, 'file> {
    at: u32,
    values: [Option<Value<'text>>; FIELDS],
    report: &'r mut Report<'file>,
    subject: Subject,
}

impl<'r, 'text, 'file> Fields<'r, 'text, 'file> {
    fn new(
        values: Values<'text>,
        report: &'r mut Report<'file>,
        subject: fn(Option<u32>) -> Subject,
    ) -> (Self, Option<u32>) {
        let Values { at, values, twice } = values;
        let mut fields = Self { at: at.unwrap_or(0), values, report, subject: subject(None) };
        let id = fields.id(Field::Id, "Id");
        fields.subject = subject(id);
        for key in twice {
            fields.error(format!("`{}` is given twice: remove one", shorten(&key)));
        }
        (fields, id)
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
        let needed = curve == Some(RawCurve::Spline);
        RawEdge {
            at: self.at,
            id,
            origin: self.id(Field::Origin, "Origin_ID"),
            destination: self.id(Field::Destination, "Destination_ID"),
            curve,
            forward: self.handle(Field::ParamF, "ParamF", needed),
            backward: self.handle(Field::ParamB, "ParamB", needed),
            velocity_forward: self.number(Field::VelocityForward, "VelocityForward"),
            velocity_backwards: match self.value(Field::VelocityBackwards) {
                None | Some(Value::Nothing) => Some(0.0),
                Some(_) => self.number(Field::VelocityBackwards, "VelocityBackwards"),
            },
        }
    }

    /// Looked at whatever the curve is, so that all that is wrong is told at once.
    fn handle(&mut self, field: Field, name: &str, needed: bool) -> Option<f64> {
        match self.value(field) {
            None | Some(Value::Nothing) if !needed => None,
            _ => self.number(field, name),
        }
    }

    fn curve(&mut self) -> Option<RawCurve> {
        let name = match self.value(Field::CurveType) {
            Some(Value::Text(text)) => text.trim().to_ascii_lowercase(),
            _ => String::new(),
        };
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
