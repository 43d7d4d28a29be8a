//! Generates route graphs from a few numbers: a warehouse or a town grid of any size.
//!
//! The same arguments give the same bytes. Robots can drive on a generated graph without end: every
//! edge can be reached from every other, and headings are continuous. Traffic keeps to the right.

mod street_layout;
mod write;

use street_layout::{Directions, Street, StreetLayout};

/// The largest number of edges that is generated: what the reader is designed for.
pub const MAX_EDGES: u64 = 250_000;

/// The largest extent in millimetres: the reader's largest coordinate.
const MAX_EXTENT: i64 = 8_000_000;

/// A warehouse: pick aisles between racks, one-way in alternating directions, with two-way cross
/// aisles and a ring road around them.
///
/// Aisles run north, cross aisles east. Edges in pick aisles may also be driven in reverse gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Warehouse {
    /// The number of pick aisles side by side; at least 1.
    pub aisles: u32,
    /// The number of rows of racks from south to north, with a cross aisle between each two; at
    /// least 1.
    pub rows: u32,
    /// The number of stops along an aisle in each row; at least 1.
    pub bays: u32,
}

/// A town grid: streets to the north and to the east, with an intersection wherever two of them
/// cross.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// The number of streets that run north; at least 2.
    pub columns: u32,
    /// The number of streets that run east; at least 2.
    pub rows: u32,
    /// The distance between streets in metres; 10 to 1000.
    pub spacing: u32,
    /// Whether the streets inside the ring road are one-way, in alternating directions, instead of
    /// two-way.
    pub one_way: bool,
}

/// The error of generating a graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GenerateError {
    /// An argument is out of range.
    #[error("--{argument} is {value}: it must be {least} to {most}")]
    OutOfRange {
        /// The argument's name.
        argument: &'static str,
        /// The given value.
        value: u32,
        /// The least allowed value.
        least: u32,
        /// The largest allowed value.
        most: u32,
    },
    /// The graph would have more than [`MAX_EDGES`].
    #[error(
        "the graph would have some {edges} edges, at most {MAX_EDGES} are possible: choose smaller numbers"
    )]
    TooManyEdges {
        /// The estimated number of edges.
        edges: u64,
    },
    /// The graph would extend beyond the largest coordinate.
    #[error(
        "the graph would be {metres} m wide or high, at most {} m are possible: choose smaller numbers",
        MAX_EXTENT / 1000
    )]
    TooWide {
        /// The larger of width and height in metres.
        metres: i64,
    },
}

impl Warehouse {
    /// Generates the text of a route graph file.
    ///
    /// # Errors
    /// If a number is out of range, or the graph would be too large.
    pub fn generate(&self) -> Result<String, GenerateError> {
        self.text(false)
    }

    /// Does what [`generate`](Self::generate) does, and adds chargers in bays beside the ring road:
    /// for each row of racks one for every three bays on either side. Robots drive through a
    /// charging bay, past nobody.
    ///
    /// # Errors
    /// As [`generate`](Self::generate).
    pub fn generate_with_chargers(&self) -> Result<String, GenerateError> {
        self.text(true)
    }

    fn text(&self, has_chargers: bool) -> Result<String, GenerateError> {
        in_range("aisles", self.aisles, 1, 10_000)?;
        in_range("rows", self.rows, 1, 10_000)?;
        in_range("bays", self.bays, 1, 1000)?;
        let Self { aisles, rows, bays } = *self;
        let chargers = if has_chargers { " --chargers" } else { "" };
        let command = format!(
            "regatta graph generate warehouse --aisles {aisles} --rows {rows} --bays {bays}{chargers}"
        );
        let edges = |n: u32| u64::from(n);
        check_edge_count(
            edges(aisles) * edges(rows) * (edges(bays) + 7) + 10 * (edges(aisles) + edges(rows)),
        )?;
        to_yaml(&command, &self.layout(has_chargers))
    }

    fn layout(&self, has_chargers: bool) -> StreetLayout {
        const AISLE_PITCH: i64 = 6000;
        const BAY_LENGTH: i64 = 2700;
        let intersection_radius = 2200;
        let ring =
            Street { at: 0, directions: Directions::Both, speed: 2000, reverse: None, stops: 1 };
        let aisle = |number| Street {
            at: AISLE_PITCH * i64::from(number),
            directions: if number % 2 == 1 {
                Directions::Ascending
            } else {
                Directions::Descending
            },
            speed: 1000,
            reverse: Some(300),
            stops: self.bays,
        };
        let block = i64::from(self.bays) * BAY_LENGTH + 2 * intersection_radius;
        let cross_aisle = |number| Street { at: block * i64::from(number), speed: 1500, ..ring };
        let columns =
            ring_around(self.aisles + 2, AISLE_PITCH, Street { stops: self.bays, ..ring }, aisle);
        let rows = ring_around(self.rows + 1, block, ring, cross_aisle);
        StreetLayout {
            columns,
            rows,
            carriageway_gap: 1600,
            intersection_radius,
            turn_speed: 800,
            has_chargers,
        }
    }
}

impl Grid {
    /// Generates the text of a route graph file.
    ///
    /// # Errors
    /// If a number is out of range, or the graph would be too large.
    pub fn generate(&self) -> Result<String, GenerateError> {
        in_range("columns", self.columns, 2, 10_000)?;
        in_range("rows", self.rows, 2, 10_000)?;
        in_range("spacing", self.spacing, 10, 1000)?;
        let one_way = if self.one_way { " --one-way" } else { "" };
        let Self { columns, rows, spacing, .. } = *self;
        let command = format!(
            "regatta graph generate grid --columns {columns} --rows {rows} --spacing {spacing}{one_way}"
        );
        check_edge_count(u64::from(columns) * u64::from(rows) * 18)?;
        to_yaml(&command, &self.layout())
    }

    fn layout(&self) -> StreetLayout {
        let pitch = i64::from(self.spacing) * 1000;
        let street =
            Street { at: 0, directions: Directions::Both, speed: 2000, reverse: None, stops: 1 };
        let inner = |number: u32| {
            let alternating =
                if number % 2 == 1 { Directions::Ascending } else { Directions::Descending };
            let directions = if self.one_way { alternating } else { Directions::Both };
            Street { at: pitch * i64::from(number), directions, speed: 1500, ..street }
        };
        let mut columns = ring_around(self.columns, pitch, street, inner);
        let mut rows = ring_around(self.rows, pitch, street, inner);
        if self.columns == 2 && self.rows == 2 {
            // A two-way ring without inner streets has no place to turn: its two directions would
            // be separate graphs.
            (rows[0].directions, columns[1].directions) =
                (Directions::Ascending, Directions::Ascending);
            (rows[1].directions, columns[0].directions) =
                (Directions::Descending, Directions::Descending);
        }
        let has_chargers = false;
        StreetLayout {
            columns,
            rows,
            carriageway_gap: 2000,
            intersection_radius: 3500,
            turn_speed: 1000,
            has_chargers,
        }
    }
}

/// Returns streets at multiples of `pitch`: the first and the last like `ring`, the others from
/// `inner` by number.
fn ring_around(
    streets: u32,
    pitch: i64,
    ring: Street,
    inner: impl Fn(u32) -> Street,
) -> Vec<Street> {
    let last = streets - 1;
    let street = |number| match number {
        0 => ring,
        _ if number == last => Street { at: pitch * i64::from(last), ..ring },
        _ => inner(number),
    };
    (0..streets).map(street).collect()
}

fn to_yaml(command: &str, layout: &StreetLayout) -> Result<String, GenerateError> {
    let extent =
        layout.columns.iter().chain(&layout.rows).map(|street| street.at).max().unwrap_or(0);
    if extent + layout.intersection_radius > MAX_EXTENT {
        return Err(GenerateError::TooWide { metres: extent / 1000 });
    }
    Ok(write::yaml(command, &layout.build()))
}

fn in_range(
    argument: &'static str,
    value: u32,
    least: u32,
    most: u32,
) -> Result<(), GenerateError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(GenerateError::OutOfRange { argument, value, least, most })
}

fn check_edge_count(edges: u64) -> Result<(), GenerateError> {
    if edges <= MAX_EDGES { Ok(()) } else { Err(GenerateError::TooManyEdges { edges }) }
}
