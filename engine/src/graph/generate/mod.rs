//! Route graphs from a few numbers: a warehouse and a town grid, of any size, that can be driven for ever.
//!
//! The same arguments give the same bytes. Traffic keeps to the right; from every lane every other can be
//! reached; every heading is continuous.

mod roads;
mod write;

use roads::{Plan, Street, Ways};

/// Edges that are generated at most: what the reader is made for.
pub const MAX_EDGES: u64 = 250_000;

/// The largest extent in millimetres: the reader's largest coordinate.
const MAX_EXTENT: i64 = 8_000_000;

/// Pick aisles between racks, driven one way in turn, with two-way cross aisles and a ring road round it all.
///
/// Aisles run north, cross aisles east. Edges in pick aisles may also be driven in reverse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Warehouse {
    /// Pick aisles side by side; at least 1.
    pub aisles: u32,
    /// Rows of racks from south to north, with a cross aisle between each two; at least 1.
    pub rows: u32,
    /// Places to stop along an aisle in each row; at least 1.
    pub bays: u32,
}

/// Streets to the north and to the east that cross each other everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Streets that run north; at least 2.
    pub columns: u32,
    /// Streets that run east; at least 2.
    pub rows: u32,
    /// Metres between streets; 10 to 1000.
    pub spacing: u32,
    /// Streets inside the ring are one-way, in turn; else they have a lane each way.
    pub one_way: bool,
}

/// Why a graph can't be generated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GenerateError {
    /// A number is outside of its range.
    #[error("--{argument} is {value}: it must be {least} to {most}")]
    OutOfRange {
        /// The argument's name.
        argument: &'static str,
        /// What was given.
        value: u32,
        /// Least allowed.
        least: u32,
        /// Most allowed.
        most: u32,
    },
    /// The graph would have more than [`MAX_EDGES`].
    #[error("that would be some {edges} edges, {MAX_EDGES} at most: ask for less")]
    TooManyEdges {
        /// An estimate.
        edges: u64,
    },
    /// The graph would reach beyond the largest coordinate.
    #[error("that would be {metres} m wide or high, {} m at most: ask for less", MAX_EXTENT / 1000)]
    TooWide {
        /// Metres in the longer direction.
        metres: i64,
    },
}

impl Warehouse {
    /// The text of a route graph file.
    ///
    /// # Errors
    /// If a number is out of range or the graph would be too large.
    pub fn generate(&self) -> Result<String, GenerateError> {
        in_range("aisles", self.aisles, 1, 10_000)?;
        in_range("rows", self.rows, 1, 10_000)?;
        in_range("bays", self.bays, 1, 1000)?;
        let Self { aisles, rows, bays } = *self;
        let title = format!("regatta graph generate warehouse --aisles {aisles} --rows {rows} --bays {bays}");
        let edges = |n: u32| u64::from(n);
        refuse_many(edges(aisles) * edges(rows) * (edges(bays) + 7) + 10 * (edges(aisles) + edges(rows)))?;
        finish(&title, &self.plan())
    }

    fn plan(&self) -> Plan {
        const PITCH: i64 = 6000;
        const BAY: i64 = 2700;
        let crossing = 2200;
        let ring = Street { at: 0, ways: Ways::Both, speed: 2000, reverse: None, stops: 1 };
        let aisle = |number| Street {
            at: PITCH * i64::from(number),
            ways: if number % 2 == 1 { Ways::Up } else { Ways::Down },
            speed: 1000,
            reverse: Some(300),
            stops: self.bays,
        };
        let block = i64::from(self.bays) * BAY + 2 * crossing;
        let cross_aisle = |number| Street { at: block * i64::from(number), speed: 1500, ..ring };
        let columns = ring_around(self.aisles + 2, PITCH, Street { stops: self.bays, ..ring }, aisle);
        let rows = ring_around(self.rows + 1, block, ring, cross_aisle);
        Plan { columns, rows, lane_gap: 1600, crossing, turn_speed: 800 }
    }
}

impl Grid {
    /// The text of a route graph file.
    ///
    /// # Errors
    /// If a number is out of range or the graph would be too large.
    pub fn generate(&self) -> Result<String, GenerateError> {
        in_range("columns", self.columns, 2, 10_000)?;
        in_range("rows", self.rows, 2, 10_000)?;
        in_range("spacing", self.spacing, 10, 1000)?;
        let one_way = if self.one_way { " --one-way" } else { "" };
        let Self { columns, rows, spacing, .. } = *self;
        let title =
            format!("regatta graph generate grid --columns {columns} --rows {rows} --spacing {spacing}{one_way}");
        refuse_many(u64::from(columns) * u64::from(rows) * 18)?;
        finish(&title, &self.plan())
    }

    fn plan(&self) -> Plan {
        let pitch = i64::from(self.spacing) * 1000;
        let street = Street { at: 0, ways: Ways::Both, speed: 2000, reverse: None, stops: 1 };
        let inner = |number: u32| {
            let in_turn = if number % 2 == 1 { Ways::Up } else { Ways::Down };
            let ways = if self.one_way { in_turn } else { Ways::Both };
            Street { at: pitch * i64::from(number), ways, speed: 1500, ..street }
        };
        let mut columns = ring_around(self.columns, pitch, street, inner);
        let mut rows = ring_around(self.rows, pitch, street, inner);
        if self.columns == 2 && self.rows == 2 {
            // Nowhere to turn round: the lanes of a two-way ring would be two graphs.
            (rows[0].ways, columns[1].ways) = (Ways::Up, Ways::Up);
            (rows[1].ways, columns[0].ways) = (Ways::Down, Ways::Down);
        }
        Plan { columns, rows, lane_gap: 2000, crossing: 3500, turn_speed: 1000 }
    }
}

/// Streets at multiples of `pitch`: the first and the last as `ring`, the others by their number.
fn ring_around(streets: u32, pitch: i64, ring: Street, inner: impl Fn(u32) -> Street) -> Vec<Street> {
    let last = streets - 1;
    let street = |number| match number {
        0 => ring,
        _ if number == last => Street { at: pitch * i64::from(last), ..ring },
        _ => inner(number),
    };
    (0..streets).map(street).collect()
}

fn finish(title: &str, plan: &Plan) -> Result<String, GenerateError> {
    let extent = plan.columns.iter().chain(&plan.rows).map(|street| street.at).max().unwrap_or(0);
    if extent + plan.crossing > MAX_EXTENT {
        return Err(GenerateError::TooWide { metres: extent / 1000 });
    }
    Ok(write::yaml(title, &plan.build()))
}

fn in_range(argument: &'static str, value: u32, least: u32, most: u32) -> Result<(), GenerateError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(GenerateError::OutOfRange { argument, value, least, most })
}

fn refuse_many(edges: u64) -> Result<(), GenerateError> {
    if edges <= MAX_EDGES { Ok(()) } else { Err(GenerateError::TooManyEdges { edges }) }
}
