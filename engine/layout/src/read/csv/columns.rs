//! The columns of a table, by the names in its header.

use std::f64::consts::PI;

/// The meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    Id,
    X,
    Y,
    Theta,
    Name,
    Level,
    Zone,
    Role,
    From,
    To,
    Speed,
    ReverseSpeed,
    /// Whether there is a second edge in the opposite direction.
    Bidirectional,
    /// Control points of a curve.
    X1,
    Y1,
    X2,
    Y2,
    /// A property.
    Other,
}

/// The names of columns in lower case, without spaces, underscores and hyphens.
const NAMES: [(Field, &[&str]); 17] = [
    (
        Field::Id,
        &[
            "id", "node", "vertex", "point", "edge", "lane", "path", "nodeid", "vertexid",
            "pointid", "edgeid", "laneid", "pathid",
        ],
    ),
    (Field::X, &["x", "xposition", "positionx", "posx", "xpos"]),
    (Field::Y, &["y", "yposition", "positiony", "posy", "ypos"]),
    (Field::Theta, &["theta", "heading", "yaw", "orientation"]),
    (Field::Name, &["name", "label"]),
    (Field::Level, &["level", "floor"]),
    (Field::Zone, &["zone", "block", "mutex"]),
    (Field::Role, &["role"]),
    (Field::From, &["from", "origin", "start", "source"]),
    (Field::To, &["to", "destination", "end", "target"]),
    (
        Field::Speed,
        &[
            "speed",
            "velocity",
            "maxspeed",
            "maxvelocity",
            "vmax",
            "speedlimit",
            "velocityforward",
            "forwardspeed",
        ],
    ),
    (
        Field::ReverseSpeed,
        &[
            "reversespeed",
            "reversevelocity",
            "maxreversespeed",
            "maxreversevelocity",
            "backwardspeed",
            "velocitybackward",
            "velocitybackwards",
        ],
    ),
    (Field::Bidirectional, &["bidirectional", "twoway"]),
    (Field::X1, &["x1"]),
    (Field::Y1, &["y1"]),
    (Field::X2, &["x2"]),
    (Field::Y2, &["y2"]),
];

/// German names of columns, as those above; the first of those is what they are taken for.
const GERMAN_NAMES: [(Field, &str, &[&str]); 12] = [
    (Field::Id, "id", &["knoten", "punkt", "kante", "strecke", "nr", "nummer", "knotennr"]),
    (Field::X, "x", &["xkoordinate", "xwert", "rechtswert"]),
    (Field::Y, "y", &["ykoordinate", "ywert", "hochwert"]),
    (Field::Theta, "theta", &["winkel", "ausrichtung"]),
    (Field::Name, "name", &["bezeichnung"]),
    (Field::Level, "level", &["ebene", "etage", "geschoss", "stockwerk"]),
    (Field::Role, "role", &["rolle"]),
    (Field::From, "from", &["von", "anfang", "quelle"]),
    (Field::To, "to", &["nach", "bis", "ziel", "ende"]),
    (
        Field::Speed,
        "speed",
        &[
            "geschwindigkeit",
            "höchstgeschwindigkeit",
            "hoechstgeschwindigkeit",
            "maxgeschwindigkeit",
            "tempo",
        ],
    ),
    (
        Field::ReverseSpeed,
        "reverse speed",
        &["rückwärtsgeschwindigkeit", "rueckwaertsgeschwindigkeit"],
    ),
    (
        Field::Bidirectional,
        "bidirectional",
        &["bidirektional", "beiderichtungen", "gegenverkehr", "beidseitig"],
    ),
];

/// The endings of the names of the ends of an edge.
const END_SUFFIXES: [&str; 8] =
    ["nodeid", "vertexid", "pointid", "node", "vertex", "id", "knoten", "punkt"];

/// A column.
#[derive(Debug)]
pub(super) struct Column {
    pub field: Field,
    /// The name in the header.
    pub name: String,
    /// The unit, if the header gives one.
    pub unit: Option<Unit>,
    /// The English name of a column with a German one.
    pub translated: Option<&'static str>,
}

/// The columns of a table of nodes or edges.
#[derive(Debug)]
pub(super) struct Columns {
    pub list: Vec<Column>,
    pub is_edges: bool,
}

impl Columns {
    /// Returns the columns if a row is the header of a table.
    pub fn of_header<'row>(cells: impl Iterator<Item = &'row str>) -> Option<Self> {
        let mut columns = Self { list: cells.map(Column::new).collect(), is_edges: false };
        columns.is_edges = columns.have(&[Field::From, Field::To]);
        let is_header = columns.is_edges || columns.have(&[Field::Id, Field::X, Field::Y]);
        is_header.then_some(columns)
    }

    /// Returns the columns that are kept as properties.
    pub fn properties(&self) -> impl Iterator<Item = (usize, &Column)> {
        self.list.iter().enumerate().filter(|(_, column)| self.is_property(column.field))
    }

    fn is_property(&self, field: Field) -> bool {
        match field {
            Field::Other => true,
            Field::Id | Field::Theta | Field::Name | Field::Level | Field::Zone => false,
            // Edges have no positions and roles. Nodes have none of the other fields.
            Field::X | Field::Y | Field::Role => self.is_edges,
            _ => !self.is_edges,
        }
    }

    fn have(&self, fields: &[Field]) -> bool {
        fields.iter().all(|field| self.list.iter().any(|column| column.field == *field))
    }
}

impl Column {
    fn new(name: &str) -> Self {
        let (plain, unit) = split_unit(name.trim());
        let letters = plain.chars().filter(|letter| !" _-".contains(*letter));
        let key: String = letters.flat_map(char::to_lowercase).collect();
        let start =
            END_SUFFIXES.into_iter().find_map(|suffix| key.strip_suffix(suffix)).unwrap_or("");
        let found = NAMES.iter().find(|(field, names)| {
            names.contains(&key.as_str())
                || (matches!(field, Field::From | Field::To) && names.contains(&start))
        });
        let german = GERMAN_NAMES.iter().find(|(field, _, names)| {
            names.contains(&key.as_str())
                || (matches!(field, Field::From | Field::To) && names.contains(&start))
        });
        let german = german.filter(|_| found.is_none());
        let field = found.map(|(field, _)| *field).or(german.map(|(field, ..)| *field));
        Self {
            field: field.unwrap_or(Field::Other),
            name: name.trim().to_owned(),
            unit,
            translated: german.map(|(_, english, _)| *english),
        }
    }
}

/// A unit of a column, as a fraction of metres, metres per second or radians: so the decimal
/// numbers of a file become the nearest ones, and 5.4 km/h is 1.5 m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    times: f64,
    per: f64,
}

impl Unit {
    /// Returns a number of the unit in metres, metres per second or radians.
    pub fn convert(self, number: f64) -> f64 {
        number * self.times / self.per
    }
}

/// Splits a unit in brackets from the end of a name, as in `x [mm]`.
fn split_unit(name: &str) -> (&str, Option<Unit>) {
    let inner = name.strip_suffix([']', ')']).and_then(|start| start.rsplit_once(['[', '(']));
    let Some((plain, unit)) = inner else { return (name, None) };
    let (times, per) = match unit.trim().to_ascii_lowercase().as_str() {
        "mm" | "mm/s" => (1.0, 1000.0),
        "cm" | "cm/s" => (1.0, 100.0),
        "m" | "m/s" | "rad" => (1.0, 1.0),
        "km" => (1000.0, 1.0),
        "in" | "inch" => (254.0, 10_000.0),
        "ft" | "ft/s" => (3048.0, 10_000.0),
        "yd" => (9144.0, 10_000.0),
        "km/h" => (1000.0, 3600.0),
        "deg" | "°" => (PI, 180.0),
        _ => return (name, None),
    };
    (plain, Some(Unit { times, per }))
}
