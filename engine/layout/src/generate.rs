//! Generates route graphs from a few numbers: a warehouse or a town grid of any size.
//!
//! The same arguments give the same bytes. Robots can drive on a generated graph without end: every
//! edge can be reached from every other, and headings are continuous. Traffic keeps to the right.

mod racks;
mod street_layout;
mod write;

use street_layout::{Directions, Street, StreetLayout};

/// The largest number of edges of a generated graph, for which readers are designed.
pub const MAX_EDGES: u64 = 250_000;

/// The largest extent in millimetres: the reader's largest coordinate.
const MAX_EXTENT: i64 = 8_000_000;

/// A warehouse: pick aisles between racks, one-way in alternating directions, with two-way cross
/// aisles and a ring road around them. The racks and the floor are its background.
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
        "the graph would have some {edges} edges, at most {MAX_EDGES} are possible: choose smaller \
         numbers"
    )]
    TooManyEdges {
        /// The estimated number of edges.
        edges: u64,
    },
    /// The graph would extend beyond the largest coordinate.
    #[error(
        "the graph would be {metres} m wide or high, at most {} m are possible: choose smaller \
         numbers",
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
    ///
    /// ```
    /// use regatta_layout::generate::Warehouse;
    /// use regatta_layout::{ReadOptions, parse};
    ///
    /// let text = Warehouse { aisles: 4, rows: 2, bays: 6 }.generate().expect("small numbers");
    /// let (graph, findings) = parse(&text, "warehouse.yaml", &ReadOptions::default())?;
    /// assert_eq!(findings.warnings(), 0);
    /// assert!(graph.edges().len() > 4 * 2 * 6);
    /// # Ok::<(), regatta_layout::GraphError>(())
    /// ```
    pub fn generate(&self) -> Result<String, GenerateError> {
        self.text(false)
    }

    /// As [`generate`](Self::generate), with chargers in bays beside the ring road. Each row of
    /// racks has one charger for every three bays on either side. Robots drive through a charging
    /// bay without passing another robot.
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
            "regatta graph generate warehouse --aisles {aisles} --rows {rows} --bays {bays}\
             {chargers}"
        );
        let [aisles, rows, bays] = [aisles, rows, bays].map(u64::from);
        check_edge_count(aisles * rows * (bays + 7) + 10 * (aisles + rows))?;
        let layout = self.layout(has_chargers);
        let background = racks::background(&layout, self.bays);
        to_yaml(&command, &layout, &background)
    }

    fn layout(&self, has_chargers: bool) -> StreetLayout {
        const AISLE_PITCH: i64 = 6000;
        const BAY_LENGTH: i64 = 2700;
        let intersection_radius = 2200;
        let ring =
            Street { at: 0, directions: Directions::Both, speed: 2000, reverse: None, stops: 1 };
        let block = i64::from(self.bays) * BAY_LENGTH + 2 * intersection_radius;
        let mut columns =
            streets(self.aisles + 2, AISLE_PITCH, Street { stops: self.bays, ..ring });
        for (number, aisle) in inner(&mut columns) {
            aisle.directions = Directions::alternating(number);
            (aisle.speed, aisle.reverse) = (1000, Some(300));
        }
        let mut rows = streets(self.rows + 1, block, ring);
        for (_, cross_aisle) in inner(&mut rows) {
            cross_aisle.speed = 1500;
        }
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
            "regatta graph generate grid --columns {columns} --rows {rows} --spacing {spacing}\
             {one_way}"
        );
        check_edge_count(u64::from(columns) * u64::from(rows) * 18)?;
        to_yaml(&command, &self.layout(), &[])
    }

    fn layout(&self) -> StreetLayout {
        let pitch = i64::from(self.spacing) * 1000;
        let street =
            Street { at: 0, directions: Directions::Both, speed: 2000, reverse: None, stops: 1 };
        let mut columns = streets(self.columns, pitch, street);
        let mut rows = streets(self.rows, pitch, street);
        for (number, street) in inner(&mut columns).chain(inner(&mut rows)) {
            street.speed = 1500;
            if self.one_way {
                street.directions = Directions::alternating(number);
            }
        }
        if self.columns == 2 && self.rows == 2 {
            // Robots can't turn in a two-way ring without inner streets: its two directions would
            // be separate graphs.
            (rows[0].directions, columns[1].directions) =
                (Directions::Ascending, Directions::Ascending);
            (rows[1].directions, columns[0].directions) =
                (Directions::Descending, Directions::Descending);
        }
        StreetLayout {
            columns,
            rows,
            carriageway_gap: 2000,
            intersection_radius: 3500,
            turn_speed: 1000,
            has_chargers: false,
        }
    }
}

/// Returns equal streets at multiples of `pitch`.
fn streets(count: u32, pitch: i64, street: Street) -> Vec<Street> {
    (0..count).map(|number| Street { at: pitch * i64::from(number), ..street }).collect()
}

/// Returns the streets inside the ring road with their numbers: all but the first and the last.
fn inner(streets: &mut [Street]) -> impl Iterator<Item = (usize, &mut Street)> {
    let last = streets.len() - 1;
    streets[..last].iter_mut().enumerate().skip(1)
}

fn to_yaml(
    command: &str,
    layout: &StreetLayout,
    background: &[racks::Line],
) -> Result<String, GenerateError> {
    let extent =
        layout.columns.iter().chain(&layout.rows).map(|street| street.at).max().unwrap_or(0);
    if extent + layout.intersection_radius > MAX_EXTENT {
        return Err(GenerateError::TooWide { metres: extent / 1000 });
    }
    Ok(write::yaml(command, &layout.build(), background))
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
