//! The background of a generated warehouse: its floor, and the racks between its aisles.

use super::street_layout::StreetLayout;

/// The depth of two racks back to back.
const DEPTH: i64 = 2400;
/// The distance from the outermost streets to the end of the floor, which leaves room for chargers.
const BORDER: i64 = 4000;
/// The most points of lines inside racks, so that readers get the background of large graphs.
const MAX_INNER_POINTS: u64 = 150_000;

/// A line through two points or more, in millimetres.
pub type Line = Vec<(i64, i64)>;

/// Two racks back to back.
struct Rack {
    west: i64,
    south: i64,
    north: i64,
}

/// Returns the outlines of the floor and of the racks, and the lines between the bays.
pub fn background(layout: &StreetLayout, bays: u32) -> Vec<Line> {
    let racks = racks(layout);
    let inner = (racks.len() as u64) * (2 * u64::from(bays) + 1);
    let mut lines = vec![floor(layout)];
    lines.extend(racks.iter().map(Rack::outline));
    if inner <= MAX_INNER_POINTS {
        lines.extend(racks.iter().map(|rack| rack.bays(bays)));
    }
    lines
}

/// Returns the racks between neighbouring streets.
fn racks(layout: &StreetLayout) -> Vec<Rack> {
    let radius = layout.intersection_radius;
    let rows = layout.rows.windows(2).map(|rows| (rows[0].at + radius, rows[1].at - radius));
    let racks = rows.flat_map(|(south, north)| {
        let columns = layout.columns.windows(2);
        columns.map(move |columns| {
            let west = (columns[0].at + columns[1].at - DEPTH) / 2;
            Rack { west, south, north }
        })
    });
    racks.collect()
}

fn floor(layout: &StreetLayout) -> Line {
    let [width, height] = [&layout.columns, &layout.rows]
        .map(|streets| streets.iter().map(|street| street.at).max().unwrap_or(0));
    rectangle((-BORDER, -BORDER), (width + BORDER, height + BORDER))
}

fn rectangle((west, south): (i64, i64), (east, north): (i64, i64)) -> Line {
    vec![(west, south), (east, south), (east, north), (west, north), (west, south)]
}

impl Rack {
    fn outline(&self) -> Line {
        rectangle((self.west, self.south), (self.west + DEPTH, self.north))
    }

    /// Returns a line through all uprights, and back along the middle.
    fn bays(&self, bays: u32) -> Line {
        let (east, middle) = (self.west + DEPTH, self.west + DEPTH / 2);
        let (count, length) = (i64::from(bays), self.north - self.south);
        let mut line: Line = (1..count)
            .flat_map(|bay| {
                let y = self.south + length * bay / count;
                let (from, to) = if bay % 2 == 1 { (self.west, east) } else { (east, self.west) };
                [(from, y), (to, y)]
            })
            .collect();
        line.extend(line.last().map(|&(x, _)| (x, self.north)));
        line.extend([(middle, self.north), (middle, self.south)]);
        line
    }
}
