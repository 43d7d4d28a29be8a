//! The values of nodes, edges, stations, zones, doors, lifts and background lines in our own
//! format, and their types.

use std::collections::BTreeMap;
use std::num::NonZeroU32;
use std::str::FromStr;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::Ends;
use regatta_base::name::UnknownName;

use super::facilities::Cabin;
use super::finding::{Report, Subject};
use super::keys::{FIELDS, Field};
use super::raw::{RawCurve, RawDoor, RawDoorTimes, RawEdge, RawLift, RawNode, RawStation, RawZone};
use super::tags::{BackgroundLine, Orientation, Tags};
use super::value::{Value, shorten};
use super::zones::ZoneRule;

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
    /// The numbers of the list of edges.
    pub edges: Vec<f64>,
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
        Converter::with_id(self, report, Subject::Node).node()
    }

    /// Converts the values to an edge and reports errors.
    pub fn edge(self, report: &mut Report<'_>) -> RawEdge {
        Converter::with_id(self, report, Subject::Edge).edge()
    }

    /// Converts the values to a station and reports errors; `None` if it has no name.
    pub fn station(self, report: &mut Report<'_>) -> Option<RawStation> {
        Converter::new(self, report, Subject::File).station()
    }

    /// Converts the values to a zone and reports errors; `None` if it has no name or no rule.
    pub fn zone(self, report: &mut Report<'_>) -> Option<RawZone> {
        Converter::new(self, report, Subject::File).zone()
    }

    /// Converts the values to a door and reports errors; `None` if it has no name.
    pub fn door(self, report: &mut Report<'_>) -> Option<RawDoor> {
        Converter::new(self, report, Subject::File).door()
    }

    /// Converts the values to a lift and reports errors; `None` if it has no name. Angles are in
    /// the unit of the file.
    pub fn lift(self, report: &mut Report<'_>) -> Option<RawLift> {
        Converter::new(self, report, Subject::File).lift()
    }

    /// Converts the values to a line of the background and reports errors; `None` if it isn't a
    /// line.
    pub fn background_line(self, report: &mut Report<'_>) -> Option<BackgroundLine> {
        Converter::new(self, report, Subject::File).background_line()
    }
}

/// Converts values, reporting errors with the place and the subject.
struct Converter<'r, 'text, 'file> {
    values: Values<'text>,
    report: &'r mut Report<'file>,
    subject: Subject,
}

impl<'r, 'text, 'file> Converter<'r, 'text, 'file> {
    fn new(values: Values<'text>, report: &'r mut Report<'file>, subject: Subject) -> Self {
        Self { values, report, subject }
    }

    /// Reads the id first, so that other errors can name it.
    fn with_id(
        values: Values<'text>,
        report: &'r mut Report<'file>,
        subject: fn(Option<u32>) -> Subject,
    ) -> Self {
        let mut converter = Self::new(values, report, subject(None));
        converter.subject = subject(converter.id(Field::Id, "Id"));
        converter
    }

    /// Reports the keys that are given more than once. Returns the byte offset of the first key.
    fn start(&mut self) -> u32 {
        for key in std::mem::take(&mut self.values.duplicates) {
            self.error(format!("`{}` is given twice: remove one", shorten(&key)));
        }
        self.at()
    }

    fn at(&self) -> u32 {
        self.values.at.unwrap_or(0)
    }

    fn node(mut self) -> RawNode {
        RawNode {
            at: self.start(),
            id: self.subject.id(),
            x: self.number(Field::X, "X"),
            y: self.number(Field::Y, "Y"),
            theta: self.number(Field::Theta, "Theta"),
            has_heading: true,
            body_heading: self.optional_number(Field::BodyHeading, "ThetaHolonomic"),
            role: self.named(Field::Role, "Role"),
            tags: self.tags().boxed(),
        }
    }

    fn edge(mut self) -> RawEdge {
        let at = self.start();
        let curve = self.curve();
        let needs_handles = curve == Some(RawCurve::Spline);
        RawEdge {
            at,
            id: self.subject.id(),
            origin: self.id(Field::Origin, "Origin_ID"),
            destination: self.id(Field::Destination, "Destination_ID"),
            curve,
            forward: self.handle(Field::ParamF, "ParamF", needs_handles),
            backward: self.handle(Field::ParamB, "ParamB", needs_handles),
            speed: self.number(Field::VelocityForward, "VelocityForward"),
            reverse_speed: if self.is_given(Field::VelocityBackwards) {
                self.number(Field::VelocityBackwards, "VelocityBackwards")
            } else {
                Some(0.0)
            },
            orientation: self.orientation(),
            rotation: Ends {
                origin: self.named(Field::RotationAtOrigin, "RotationAtOrigin"),
                destination: self.named(Field::RotationAtDestination, "RotationAtDestination"),
            },
            tags: self.tags().boxed(),
        }
    }

    fn station(mut self) -> Option<RawStation> {
        let at = self.start();
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
        let numbers = std::mem::take(&mut self.values.numbers);
        let nodes = self.ids("Nodes", &numbers);
        let role = self.named(Field::Role, "Role");
        let properties = self.values.properties;
        Some(RawStation { at, name: name?.into(), role, nodes, position, properties })
    }

    fn zone(mut self) -> Option<RawZone> {
        let at = self.start();
        let name = self.text(Field::Name);
        if name.is_none() {
            self.error("a zone has no Name: give one");
        }
        let rule = self.zone_rule();
        let (nodes, edges) =
            (std::mem::take(&mut self.values.numbers), std::mem::take(&mut self.values.edges));
        let (nodes, edges) = (self.ids("Nodes", &nodes), self.ids("Edges", &edges));
        Some(RawZone { at, name: name?.into(), rule: rule?, nodes, edges })
    }

    fn door(mut self) -> Option<RawDoor> {
        let at = self.start();
        let name = self.name("a door");
        let edges = std::mem::take(&mut self.values.edges);
        let edges = self.ids("Edges", &edges);
        let line = self.line();
        Some(RawDoor { at, name: name?, edges, line, times: self.door_times() })
    }

    /// Reads the ends of a door.
    fn line(&mut self) -> Option<[DVec2; 2]> {
        self.value(Field::ControlPoints)?;
        let numbers = std::mem::take(&mut self.values.numbers);
        let &[x0, y0, x1, y1] = numbers.as_slice() else {
            self.error("Line must have two points: give [[x, y], [x, y]]");
            return None;
        };
        Some([DVec2::new(x0, y0), DVec2::new(x1, y1)])
    }

    fn background_line(mut self) -> Option<BackgroundLine> {
        self.start();
        let numbers = std::mem::take(&mut self.values.numbers);
        if numbers.len() < 4 || !numbers.len().is_multiple_of(2) {
            self.error(format!(
                "the Line of the background has {} numbers: give two points [x, y] or more",
                numbers.len()
            ));
            return None;
        }
        let points = numbers.chunks_exact(2).map(DVec2::from_slice).collect();
        Some(BackgroundLine { points, level: self.text(Field::Level) })
    }

    fn door_times(&mut self) -> RawDoorTimes {
        RawDoorTimes {
            opening: self.optional_number(Field::OpeningSeconds, "OpeningSeconds"),
            closing: self.optional_number(Field::ClosingSeconds, "ClosingSeconds"),
        }
    }

    fn lift(mut self) -> Option<RawLift> {
        let at = self.start();
        let name = self.name("a lift");
        let nodes = std::mem::take(&mut self.values.numbers);
        Some(RawLift {
            at,
            name: name?,
            nodes: self.ids("Nodes", &nodes),
            cabin: self.cabin(),
            door_times: self.door_times(),
            level_secs: self.optional_number(Field::SecondsPerLevel, "SecondsPerLevel"),
            capacity: if self.is_given(Field::Capacity) { self.capacity() } else { None },
            home: self.text(Field::Home).map(String::from),
        })
    }

    /// Reads the footprint of a cabin.
    fn cabin(&mut self) -> Option<Cabin> {
        let keys =
            [(Field::X, "X"), (Field::Y, "Y"), (Field::Width, "Width"), (Field::Depth, "Depth")];
        if !keys.iter().any(|(field, _)| self.is_given(*field)) {
            return None;
        }
        let [x, y, width, depth] = keys.map(|(field, key)| self.number(field, key));
        Some(Cabin {
            centre: DVec2::new(x?, y?),
            size: DVec2::new(width?, depth?),
            yaw: self.optional_number(Field::Theta, "Theta").unwrap_or_default(),
        })
    }

    /// Reads the name of a door or a lift.
    fn name(&mut self, owner: &str) -> Option<String> {
        let name = self.text(Field::Name);
        if name.is_none() {
            self.error(format!("{owner} has no Name: give one"));
        }
        name.map(String::from)
    }

    fn capacity(&mut self) -> Option<u32> {
        let expected = "a whole number of robots, at least 1";
        self.required(Field::Capacity, "Capacity", expected, |number| {
            let capacity = number as u32;
            (capacity > 0 && f64::from(capacity) == number).then_some(capacity)
        })
    }

    fn zone_rule(&mut self) -> Option<ZoneRule> {
        if self.is_given(Field::Capacity) {
            return self.capacity().and_then(NonZeroU32::new).map(ZoneRule::Capacity);
        }
        let rule = match self.value(Field::Rule).map(Value::lowercase).as_deref() {
            Some("exclusive") => Some(ZoneRule::EXCLUSIVE),
            Some("same_direction") => Some(ZoneRule::SameDirection),
            _ => None,
        };
        if rule.is_none() {
            self.error("a zone has no rule: give a Capacity, or Rule: exclusive or same_direction");
        }
        rule
    }

    /// Converts a list of numbers to ids.
    fn ids(&mut self, key: &str, numbers: &[f64]) -> Vec<u32> {
        let ids: Vec<u32> = numbers.iter().map(|&number| number as u32).collect();
        if ids.iter().zip(numbers).any(|(&id, &number)| f64::from(id) != number) {
            self.error(format!("{key} must list ids: whole numbers from 0 to {}", u32::MAX));
        }
        ids
    }

    /// Reads the name of an enum value; the default if there is none or the name is unknown.
    fn named<T: Default + FromStr<Err = UnknownName>>(&mut self, field: Field, key: &str) -> T {
        let Some(text) = self.text(field) else { return T::default() };
        text.parse().unwrap_or_else(|error| {
            self.error(format!("{key}: {error}"));
            T::default()
        })
    }

    fn tags(&mut self) -> Tags {
        Tags {
            name: self.text(Field::Name),
            level: self.text(Field::Level),
            zone: self.text(Field::Zone),
            properties: std::mem::take(&mut self.values.properties),
        }
    }

    /// Returns a text or number as text; `None` if it isn't given or empty.
    fn text(&mut self, field: Field) -> Option<Box<str>> {
        let text = self.value(field)?.text()?;
        (!text.is_empty()).then(|| text.into())
    }

    /// Reads the heading of robots along the edge.
    fn orientation(&mut self) -> Orientation {
        match (self.is_given(Field::Heading), self.is_given(Field::HeadingOffset)) {
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

    /// Reads a handle length. Handles of straight edges are checked too, so that all errors are
    /// reported at once.
    fn handle(&mut self, field: Field, name: &str, is_required: bool) -> Option<f64> {
        if is_required { self.number(field, name) } else { self.optional_number(field, name) }
    }

    fn curve(&mut self) -> Option<RawCurve> {
        let name = self.value(Field::CurveType).map(Value::lowercase).unwrap_or_default();
        match name.as_str() {
            "linear" => Some(RawCurve::Linear),
            "spline" => Some(RawCurve::Spline),
            "bezier" => self.cubics().map(RawCurve::Cubics),
            _ => {
                self.error(match self.value(Field::CurveType) {
                    None => "has no CurveType: give Spline, Linear or Bezier".to_owned(),
                    Some(other) => {
                        format!("CurveType is {}: use Spline, Linear or Bezier", other.describe())
                    }
                });
                None
            }
        }
    }

    /// Returns the cubics of a list of control points: the end of each is the start of the next.
    fn cubics(&mut self) -> Option<Vec<CubicBezier>> {
        let numbers = std::mem::take(&mut self.values.numbers);
        if numbers.len() < 8 || numbers.len() % 6 != 2 {
            self.error(format!(
                "ControlPoints has {} numbers: a Bezier needs 4 points [x, y], or 3 more for each \
                 further cubic",
                numbers.len()
            ));
            return None;
        }
        let points: Vec<_> = numbers.chunks_exact(2).map(DVec2::from_slice).collect();
        let cubics = points.windows(4).step_by(3);
        Some(cubics.map(|p| CubicBezier { control_points: [p[0], p[1], p[2], p[3]] }).collect())
    }

    fn value(&self, field: Field) -> Option<&Value<'_>> {
        self.values.values[field as usize].as_ref()
    }

    /// Whether the key has a value.
    fn is_given(&self, field: Field) -> bool {
        self.value(field).is_some_and(|value| *value != Value::Null)
    }

    fn number(&mut self, field: Field, name: &str) -> Option<f64> {
        self.required(field, name, "a finite number", |number| number.is_finite().then_some(number))
    }

    /// As [`Self::number`]; `None` without an error if the key has no value.
    fn optional_number(&mut self, field: Field, name: &str) -> Option<f64> {
        if self.is_given(field) { self.number(field, name) } else { None }
    }

    fn id(&mut self, field: Field, name: &str) -> Option<u32> {
        self.required(field, name, "a whole number from 0 to 4294967295", |number| {
            let id = number as u32;
            (f64::from(id) == number).then_some(id)
        })
    }

    /// Converts a number; `None` with an error if it is missing or can't be converted.
    fn required<T>(
        &mut self,
        field: Field,
        name: &str,
        expected: &str,
        convert: impl FnOnce(f64) -> Option<T>,
    ) -> Option<T> {
        let message = match self.value(field) {
            None => format!("has no {name}: give one"),
            Some(value) => match value.number().and_then(convert) {
                Some(converted) => return Some(converted),
                None => format!("{name} is {}: it must be {expected}", value.describe()),
            },
        };
        self.error(message);
        None
    }

    fn error(&mut self, message: impl Into<String>) {
        self.report.error(self.at(), self.subject, message);
    }
}
