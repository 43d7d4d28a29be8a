//! Contacts: pairs of robots whose footprints overlap. A uniform grid finds the pairs that are
//! near, and separating axes decide.

use std::collections::BTreeMap;

use glam::Vec2;
use regatta_plugin::world::Level;

use crate::findings::{Finding, Findings, Kind};
use crate::orders::Now;

/// The overlap below which footprints count as apart, in metres.
pub(crate) const CONTACT_TOLERANCE: f32 = 0.001;

/// A footprint with its pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    pub robot: u32,
    pub position: Vec2,
    pub theta: f32,
    /// Half of the length and of the width in metres; of a circle, twice the radius.
    pub half: Vec2,
    pub is_circle: bool,
    /// The floor that it is on.
    pub level: Level,
    /// The radius of the circle around it, in metres.
    radius: f32,
}

impl Body {
    /// Creates the body of a robot with half of its length and width.
    pub fn new(robot: u32, position: Vec2, theta: f32, half: Vec2, is_circle: bool) -> Self {
        let radius = if is_circle { half.x } else { half.x.hypot(half.y) };
        Self { robot, position, theta, half, is_circle, level: Level::ANY, radius }
    }

    /// Returns the body of another robot of the same type.
    pub fn of(&self, robot: u32, position: Vec2, theta: f32, level: Level) -> Self {
        Self { robot, position, theta, level, ..*self }
    }
}

/// A uniform grid, which finds near pairs.
#[derive(Debug, Default)]
pub(crate) struct Grid {
    starts: Vec<u32>,
    cells: Vec<u32>,
    order: Vec<u32>,
}

impl Grid {
    /// Calls `each` with the overlapping pairs, and the depth of their overlap in metres. The lower
    /// index comes first.
    pub fn overlaps(&mut self, bodies: &[Body], mut each: impl FnMut(usize, usize, f32)) {
        let Some(columns) = self.sort(bodies) else { return };
        let rows = (self.starts.len() - 1) / columns;
        // Most cells are empty, so the bodies are walked, in the order of their cells.
        for (at, first) in self.order.iter().enumerate() {
            let first = *first as usize;
            let cell = self.cells[first] as usize;
            let (row, column) = (cell / columns, cell % columns);
            let is_last = column + 1 == columns;
            // This cell and the next one of its row lie side by side in memory, as do the three of
            // the next row.
            let row_end = self.start(if is_last { cell + 1 } else { cell + 2 });
            let mut below = 0..0;
            if row + 1 < rows {
                let next = cell + columns;
                let from = if column > 0 { next - 1 } else { next };
                let to = if is_last { next } else { next + 1 };
                below = self.start(from)..self.start(to + 1);
            }
            let near = [&self.order[at + 1..row_end], &self.order[below]];
            for second in near.into_iter().flatten() {
                let (a, b) = (first.min(*second as usize), first.max(*second as usize));
                let depth = overlap(&bodies[a], &bodies[b]);
                if depth > CONTACT_TOLERANCE {
                    each(a, b, depth);
                }
            }
        }
    }

    fn start(&self, cell: usize) -> usize {
        self.starts[cell] as usize
    }

    /// Sorts bodies into cells that are as wide as the largest one, and returns the number of
    /// columns.
    fn sort(&mut self, bodies: &[Body]) -> Option<usize> {
        let first = bodies.first()?;
        let (mut low, mut high, mut radius) = (first.position, first.position, 0.0_f32);
        for body in bodies {
            low = low.min(body.position);
            high = high.max(body.position);
            radius = radius.max(body.radius);
        }
        let mut width = (2.0 * radius).max(0.01) * 1.0001;
        let [columns, rows] = loop {
            let [columns, rows] = ((high - low) / width).to_array().map(|cells| cells as usize + 1);
            if columns.saturating_mul(rows) <= 4 * bodies.len() + 64 {
                break [columns, rows];
            }
            width *= 1.5;
        };
        self.cells.clear();
        self.cells.extend(bodies.iter().map(|body| {
            let [column, row] = ((body.position - low) / width).to_array();
            let (column, row) = ((column as usize).min(columns - 1), (row as usize).min(rows - 1));
            (row * columns + column) as u32
        }));
        self.starts.clear();
        self.starts.resize(columns * rows + 1, 0);
        for cell in &self.cells {
            self.starts[*cell as usize] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        self.order.resize(bodies.len(), 0);
        for (index, cell) in self.cells.iter().enumerate().rev() {
            let start = &mut self.starts[*cell as usize];
            *start -= 1;
            self.order[*start as usize] = index as u32;
        }
        Some(columns)
    }
}

/// Returns the depth of the overlap of two footprints in metres: the least distance by which one
/// must move to separate them; zero or less if they don't overlap.
pub(crate) fn overlap(a: &Body, b: &Body) -> f32 {
    let offset = b.position - a.position;
    let reach = a.radius + b.radius;
    let square = offset.length_squared();
    if square >= reach * reach {
        return 0.0;
    }
    match (a.is_circle, b.is_circle) {
        (true, true) => reach - square.sqrt(),
        (false, true) => circle_overlap(a, b.half.x, offset),
        (true, false) => circle_overlap(b, a.half.x, -offset),
        (false, false) => rectangle_overlap(a, b, offset),
    }
}

fn circle_overlap(rectangle: &Body, radius: f32, offset: Vec2) -> f32 {
    let heading = Vec2::from_angle(rectangle.theta);
    // The distance of the centre beyond each pair of sides.
    let beyond = Vec2::new(heading.dot(offset), heading.perp_dot(offset)).abs() - rectangle.half;
    if beyond.x > 0.0 && beyond.y > 0.0 {
        return radius - beyond.x.hypot(beyond.y);
    }
    radius - beyond.max_element()
}

fn rectangle_overlap(a: &Body, b: &Body, offset: Vec2) -> f32 {
    let (heading_a, heading_b) = (Vec2::from_angle(a.theta), Vec2::from_angle(b.theta));
    let (cos, sin) = (heading_a.dot(heading_b).abs(), heading_a.perp_dot(heading_b).abs());
    let depths = [
        a.half.x + b.half.x * cos + b.half.y * sin - heading_a.dot(offset).abs(),
        a.half.y + b.half.x * sin + b.half.y * cos - heading_a.perp_dot(offset).abs(),
        b.half.x + a.half.x * cos + a.half.y * sin - heading_b.dot(offset).abs(),
        b.half.y + a.half.x * sin + a.half.y * cos - heading_b.perp_dot(offset).abs(),
    ];
    depths.into_iter().fold(f32::INFINITY, f32::min)
}

/// A pair that touches, or has touched.
#[derive(Clone, Debug)]
struct Contact {
    first: Finding,
    /// The number of the last frame in which it touched.
    last_frame: u64,
    seconds: f64,
    deepest: f32,
}

/// All pairs that have touched. A pair counts once, however often it touches.
#[derive(Debug, Default)]
pub(crate) struct Contacts {
    grid: Grid,
    pairs: BTreeMap<(u32, u32), Contact>,
}

impl Contacts {
    /// Takes the bodies of a frame with this number, `seconds` after the frame before. `edge`
    /// returns the id of a robot's edge.
    pub fn take(
        &mut self,
        bodies: &[Body],
        frame: u64,
        now: Now,
        seconds: f64,
        edge: impl Fn(u32) -> Option<u32>,
    ) {
        let Self { grid, pairs } = self;
        grid.overlaps(bodies, |a, b, depth| {
            let (a, b) = (bodies[a], bodies[b]);
            if !a.level.may_meet(b.level) {
                return;
            }
            let contact = pairs.entry((a.robot, b.robot)).or_insert_with(|| Contact {
                first: Finding {
                    robots: vec![a.robot, b.robot],
                    edge: edge(a.robot),
                    place: Some((0.5 * (a.position + b.position)).into()),
                    limit: Some(f64::from(CONTACT_TOLERANCE)),
                    ..Finding::at(now.tick, now.seconds)
                },
                last_frame: u64::MAX,
                seconds: 0.0,
                deepest: 0.0,
            });
            if contact.last_frame != u64::MAX && contact.last_frame + 1 == frame {
                contact.seconds += seconds;
            }
            contact.last_frame = frame;
            contact.deepest = contact.deepest.max(depth);
        });
    }

    /// Adds all pairs to the findings, in the order in which they began to touch.
    pub fn finish(&mut self, findings: &mut Findings) {
        let mut contacts: Vec<_> = std::mem::take(&mut self.pairs).into_values().collect();
        contacts.sort_by_key(|contact| contact.first.tick);
        for contact in contacts {
            findings.add(Kind::Contact, || Finding {
                value: Some(f64::from(contact.deepest)),
                duration_secs: Some(contact.seconds),
                ..contact.first
            });
        }
    }

    pub fn len(&self) -> u64 {
        self.pairs.len() as u64
    }
}

#[cfg(test)]
mod tests;
