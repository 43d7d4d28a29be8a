//! A graph as a file describes it, before it is validated: nodes, edges and stations, their keys,
//! and the types of their values.

use std::collections::BTreeMap;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::Rotation;

use super::finding::{Report, Subject};
use super::spline::Handles;
use super::tags::{Orientation, Role, Tags};
use super::value::{Value, shorten};

/// The content of a file: fields are `None` where a value is missing or of the wrong type, which
/// has been reported.
#[derive(Debug, Default)]
pub(crate) struct RawGraph {
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

/// A node as written in the file: its numbers are finite, but not yet range-checked.
#[derive(Debug)]
pub(crate) struct RawNode {
    /// The byte offset of its first key.
    pub at: u32,
    pub id: Option<u32>,
    pub x: Option<f64>,
    pub y: Option<f64>,
    pub theta: Option<f64>,
    /// Whether the file gives `theta`.
    pub has_heading: bool,
    /// The heading of robots there, if it isn't that of the curve; in the unit of the file.
    pub body_heading: Option<f64>,
    pub role: Role,
    pub tags: Option<Box<Tags>>,
}

impl RawNode {
    /// Returns the subject of a finding about the node, and its message, which begins with the name
    /// if there is one.
    pub fn finding(&self, message: impl Into<String>) -> (Subject, String) {
        finding(Subject::Node(self.id), self.tags.as_deref(), message.into())
    }
}

impl RawEdge {
    /// Returns the subject of a finding about the edge, and its message, which begins with the name
    /// if there is one.
    pub fn finding(&self, message: impl Into<String>) -> (Subject, String) {
        finding(Subject::Edge(self.id), self.tags.as_deref(), message.into())
    }
}

fn finding(subject: Subject, tags: Option<&Tags>, message: String) -> (Subject, String) {
    match tags.and_then(|tags| tags.name.as_deref()) {
        None => (subject, message),
        Some(name) => (subject, format!("`{}`: {message}", shorten(name))),
    }
}

/// An edge as written in the file: its numbers are finite, but not yet range-checked.
#[derive(Clone, Debug)]
pub(crate) struct RawEdge {
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
    pub speed: Option<f64>,
    /// 0 if not given.
    pub reverse_speed: Option<f64>,
    /// Angles are in the unit of the file.
    pub orientation: Orientation,
    /// At the origin and at the destination.
    pub rotation: [Rotation; 2],
    pub tags: Option<Box<Tags>>,
}

/// The shape of an edge.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum RawCurve {
    Linear,
    Spline,
    /// At least one, end to end.
    Cubics(Vec<CubicBezier>),
}

/// A station as written in the file.
#[derive(Debug)]
pub(crate) struct RawStation {
    /// The byte offset of its first key.
    pub at: u32,
    pub name: String,
    pub role: Role,
    /// Ids of nodes.
    pub nodes: Vec<u32>,
    pub position: Option<DVec2>,
    pub properties: BTreeMap<Box<str>, Box<str>>,
}

/// The keys of nodes and edges.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Field {
    Id,
    X,
    Y,
    Theta,
    /// The heading of robots, where `Theta` is that of curves.
    BodyHeading,
    Origin,
    Destination,
    CurveType,
    ParamF,
    ParamB,
    VelocityForward,
    VelocityBackwards,
    Name,
    Level,
    Zone,
    Role,
    /// The heading of robots on the map, wherever on the edge they are.
    Heading,
    /// The angle of robots to the tangent of the edge.
    HeadingOffset,
    RotationAtOrigin,
    RotationAtDestination,
    /// A list of points.
    ControlPoints,
    /// A list of ids of nodes.
    Nodes,
    /// A map of texts.
    Properties,
    /// A key that is part of the format and kept as a property.
    Kept,
}

/// The number of fields with a value.
const FIELDS: usize = Field::Kept as usize;

/// The keys of a node, normalized as by [`find`].
pub(crate) const NODE_KEYS: [(&str, Field); 13] = [
    ("id", Field::Id),
    ("x", Field::X),
    ("y", Field::Y),
    ("theta", Field::Theta),
    ("name", Field::Name),
    ("label", Field::Name),
    ("level", Field::Level),
    ("zone", Field::Zone),
    ("role", Field::Role),
    ("properties", Field::Properties),
    ("frameid", Field::Kept),
    ("thetaholomonic", Field::BodyHeading),
    ("thetaholonomic", Field::BodyHeading),
];

/// The keys of an edge, normalized as by [`find`].
pub(crate) const EDGE_KEYS: [(&str, Field); 19] = [
    ("id", Field::Id),
    ("originid", Field::Origin),
    ("destinationid", Field::Destination),
    ("curvetype", Field::CurveType),
    ("paramf", Field::ParamF),
    ("paramb", Field::ParamB),
    ("velocityforward", Field::VelocityForward),
    ("velocitybackwards", Field::VelocityBackwards),
    ("velocitybackward", Field::VelocityBackwards),
    ("name", Field::Name),
    ("label", Field::Name),
    ("level", Field::Level),
    ("zone", Field::Zone),
    ("heading", Field::Heading),
    ("headingoffset", Field::HeadingOffset),
    ("rotationatorigin", Field::RotationAtOrigin),
    ("rotationatdestination", Field::RotationAtDestination),
    ("controlpoints", Field::ControlPoints),
    ("properties", Field::Properties),
];

/// The keys of a station.
pub(crate) const STATION_KEYS: [(&str, Field); 7] = [
    ("name", Field::Name),
    ("label", Field::Name),
    ("role", Field::Role),
    ("nodes", Field::Nodes),
    ("x", Field::X),
    ("y", Field::Y),
    ("properties", Field::Properties),
];

/// Looks up a key, ignoring case, `_`, `-` and spaces.
pub(crate) fn find<T: Copy>(keys: &[(&str, T)], key: &str) -> Option<T> {
    let letters =
        || key.bytes().filter(|byte| !b"_- ".contains(byte)).map(|byte| byte.to_ascii_lowercase());
    keys.iter().find(|(name, _)| letters().eq(name.bytes())).map(|&(_, found)| found)
}

/// The values of one node, edge or station, by field.
#[derive(Default)]
pub(crate) struct Values<'text> {
    /// The byte offset of the first key.
    pub at: Option<u32>,
    values: [Option<Value<'text>>; FIELDS],
    /// The keys that are given more than once.
    duplicates: Vec<String>,
    /// The numbers of the list of points or of nodes.
    pub numbers: Vec<f64>,
    pub properties: BTreeMap<Box<str>, Box<str>>,
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

    /// Converts the values to a station and reports errors; `None` if it has no name.
    pub fn station(self, report: &mut Report<'_>) -> Option<RawStation> {
        Converter::without_id(self, report, Subject::File).station()
    }
}

/// Converts values, reporting errors with the place and the subject.
struct Converter<'r, 'text, 'file> {
    at: u32,
    values: [Option<Value<'text>>; FIELDS],
    numbers: Vec<f64>,
    properties: BTreeMap<Box<str>, Box<str>>,
    report: &'r mut Report<'file>,
    subject: Subject,
}

impl<'r, 'text, 'file> Converter<'r, 'text, 'file> {
    fn without_id(values: Values<'text>, report: &'r mut Report<'file>, subject: Subject) -> Self {
        let Values { at, values, duplicates, numbers, properties } = values;
        let mut converter =
            Self { at: at.unwrap_or(0), values, numbers, properties, report, subject };
        for key in duplicates {
            converter.error(format!("`{}` is given twice: remove one", shorten(&key)));
        }
        converter
    }

    fn new(
        mut values: Values<'text>,
        report: &'r mut Report<'file>,
        subject: fn(Option<u32>) -> Subject,
    ) -> (Self, Option<u32>) {
        let duplicates = std::mem::take(&mut values.duplicates);
        let mut converter = Self::without_id(values, report, subject(None));
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
            has_heading: true,
            body_heading: self.given_number(Field::BodyHeading, "ThetaHolonomic"),
            role: self.role(),
            tags: self.tags().boxed(),
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
            speed: self.number(Field::VelocityForward, "VelocityForward"),
            reverse_speed: match self.value(Field::VelocityBackwards) {
                None | Some(Value::Null) => Some(0.0),
                Some(_) => self.number(Field::VelocityBackwards, "VelocityBackwards"),
            },
            orientation: self.orientation(),
            rotation: [
                self.rotation(Field::RotationAtOrigin),
                self.rotation(Field::RotationAtDestination),
            ],
            tags: self.tags().boxed(),
        }
    }

    fn station(mut self) -> Option<RawStation> {
        let name = self.text(Field::Name);
        if name.is_none() {
            self.error("a station has no Name: give one");
        }
        let position = match (self.value(Field::X), self.value(Field::Y)) {
            (None, None) => None,
            _ => self
                .number(Field::X, "X")
                .zip(self.number(Field::Y, "Y"))
                .map(|(x, y)| DVec2::new(x, y)),
        };
        let nodes: Vec<u32> = self.numbers.iter().map(|&number| number as u32).collect();
        if nodes.iter().zip(&self.numbers).any(|(&id, &number)| f64::from(id) != number) {
            self.error(format!("Nodes must list ids: whole numbers from 0 to {}", u32::MAX));
        }
        let role = self.role();
        Some(RawStation {
            at: self.at,
            name: name?.into(),
            role,
            nodes,
            position,
            properties: std::mem::take(&mut self.properties),
        })
    }

    fn role(&mut self) -> Role {
        let Some(text) = self.text(Field::Role) else { return Role::None };
        text.parse().unwrap_or_else(|error: super::tags::ParseRoleError| {
            self.error(format!("Role is {error}"));
            Role::None
        })
    }

    fn rotation(&mut self, field: Field) -> Rotation {
        let Some(text) = self.text(field) else { return Rotation::Shorter };
        text.parse().unwrap_or_else(|error: regatta_base::graph::ParseRotationError| {
            self.error(format!("a rotation is {error}"));
            Rotation::Shorter
        })
    }

    fn tags(&mut self) -> Tags {
        Tags {
            name: self.text(Field::Name),
            level: self.text(Field::Level),
            zone: self.text(Field::Zone),
            properties: std::mem::take(&mut self.properties),
        }
    }

    /// Returns a text or number as text; `None` if it isn't given or empty.
    fn text(&mut self, field: Field) -> Option<Box<str>> {
        let text = self.value(field)?.text()?;
        (!text.is_empty()).then(|| text.into())
    }

    /// Reads the heading of robots along the edge.
    fn orientation(&mut self) -> Orientation {
        let is_given = |value: Option<&Value<'_>>| value.is_some_and(|value| *value != Value::Null);
        match (is_given(self.value(Field::Heading)), is_given(self.value(Field::HeadingOffset))) {
            (false, false) => Orientation::Tangential,
            (true, false) => {
                Orientation::Fixed(self.number(Field::Heading, "Heading").unwrap_or_default())
            }
            (false, true) => Orientation::Offset(
                self.number(Field::HeadingOffset, "HeadingOffset").unwrap_or_default(),
            ),
            (true, true) => {
                self.error("has both Heading and HeadingOffset: remove one");
                Orientation::Tangential
            }
        }
    }

    /// Converts a handle length. Straight edges are checked too, so that all errors are reported at
    /// once.
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
            "bezier" => self.cubics().map(RawCurve::Cubics),
            _ => {
                let message = match self.value(Field::CurveType) {
                    None => "has no CurveType: give Spline, Linear or Bezier".to_owned(),
                    Some(other) => {
                        format!("CurveType is {}: use Spline, Linear or Bezier", other.describe())
                    }
                };
                self.error(message);
                None
            }
        }
    }

    /// Returns the cubics of a list of control points: the end of each is the start of the next.
    fn cubics(&mut self) -> Option<Vec<CubicBezier>> {
        let points: Vec<_> =
            self.numbers.chunks_exact(2).map(|pair| DVec2::new(pair[0], pair[1])).collect();
        if points.len() < 4 || points.len() % 3 != 1 || !self.numbers.len().is_multiple_of(2) {
            let message = format!(
                "ControlPoints has {} numbers: a Bezier needs 4 points [x, y], or 3 more for each further cubic",
                self.numbers.len()
            );
            self.error(message);
            return None;
        }
        let starts = (0..points.len() - 1).step_by(3);
        Some(
            starts
                .map(|at| CubicBezier { control_points: [0, 1, 2, 3].map(|i| points[at + i]) })
                .collect(),
        )
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

    /// As [`Self::number`]; `None` without an error if the key has no value.
    fn given_number(&mut self, field: Field, name: &str) -> Option<f64> {
        match self.value(field) {
            None | Some(Value::Null) => None,
            Some(_) => self.number(field, name),
        }
    }

    fn id(&mut self, field: Field, name: &str) -> Option<u32> {
        let message = match self.value(field) {
            None => format!("has no {name}: give one"),
            Some(value) => match value.number() {
                Some(number)
                    if number.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&number) =>
                {
                    return Some(number as u32);
                }
                _ => format!(
                    "{name} is {}: it must be a whole number from 0 to {}",
                    value.describe(),
                    u32::MAX
                ),
            },
        };
        self.error(message);
        None
    }

    fn error(&mut self, message: impl Into<String>) {
        self.report.error(self.at, self.subject, message);
    }
}
