//! Contacts: pairs of robots whose footprints overlap. A uniform grid finds the pairs that are
//! near, and the separating axes of rectangles and circles decide.

use std::collections::BTreeMap;

use crate::findings::{Finding, Findings, Kind};

/// The overlap below which footprints count as apart, in metres.
pub(crate) const CONTACT_TOLERANCE: f32 = 0.001;

/// A footprint at its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Body {
    pub robot: u32,
    pub x: f32,
    pub y: f32,
    pub theta: f32,
    /// Half of the length and of the width in metres; of a circle, twice the radius.
    pub half: [f32; 2],
    pub is_circle: bool,
    /// The radius of the circle about it, in metres.
    radius: f32,
}

impl Body {
    /// A robot at x, y and theta; `half` is half of its length and width.
    pub fn new(robot: u32, [x, y, theta]: [f32; 3], half: [f32; 2], is_circle: bool) -> Self {
        let radius = if is_circle { half[0] } else { half[0].hypot(half[1]) };
        Self { robot, x, y, theta, half, is_circle, radius }
    }
}

/// Finds near pairs.
#[derive(Debug, Default)]
pub(crate) struct Grid {
    starts: Vec<u32>,
    cells: Vec<u32>,
    order: Vec<u32>,
}

impl Grid {
    /// Calls `each` with the overlapping pairs, and by how much they overlap in metres. The lower
    /// index comes first.
    pub fn overlaps(&mut self, bodies: &[Body], mut each: impl FnMut(usize, usize, f32)) {
        let Some(columns) = self.sort(bodies) else { return };
        let rows = (self.starts.len() - 1) / columns;
        let place = |cell: usize| self.starts[cell] as usize;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)))
        {
            let cell = row * columns + column;
            let (end, is_last) = (place(cell + 1), column + 1 == columns);
            // This cell and the next one of its row lie side by side in memory, as do the three of
            // the next row.
            let beside = if is_last { end } else { place(cell + 2) };
            for at in place(cell)..end {
                let first = self.order[at] as usize;
                let mut try_all = |from: usize, to: usize| {
                    for second in &self.order[from..to] {
                        let (a, b) = (first.min(*second as usize), first.max(*second as usize));
                        let depth = overlap(&bodies[a], &bodies[b]);
                        if depth > CONTACT_TOLERANCE {
                            each(a, b, depth);
                        }
                    }
                };
                try_all(at + 1, beside);
                if row + 1 < rows {
                    let next = cell + columns;
                    let from = if column > 0 { next - 1 } else { next };
                    let to = if is_last { next } else { next + 1 };
                    try_all(place(from), place(to + 1));
                }
            }
        }
    }

    /// Sorts bodies into cells that are as wide as the largest one, and returns the number of
    /// columns.
    fn sort(&mut self, bodies: &[Body]) -> Option<usize> {
        let first = bodies.first()?;
        let (mut low, mut high, mut radius) = ([first.x, first.y], [first.x, first.y], 0.0_f32);
        for body in bodies {
            low = [low[0].min(body.x), low[1].min(body.y)];
            high = [high[0].max(body.x), high[1].max(body.y)];
            radius = radius.max(body.radius);
        }
        let mut width = (2.0 * radius).max(0.01) * 1.0001;
        let size = |width: f32| [0, 1].map(|i| ((high[i] - low[i]) / width) as usize + 1);
        while size(width)[0].saturating_mul(size(width)[1]) > 4 * bodies.len() + 64 {
            width *= 1.5;
        }
        let [columns, rows] = size(width);
        let cell = |body: &Body| {
            let column = (((body.x - low[0]) / width) as usize).min(columns - 1);
            let row = (((body.y - low[1]) / width) as usize).min(rows - 1);
            (row * columns + column) as u32
        };
        self.cells.clear();
        self.cells.extend(bodies.iter().map(cell));
        self.starts.clear();
        self.starts.resize(columns * rows + 1, 0);
        self.cells.iter().for_each(|cell| self.starts[*cell as usize] += 1);
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

/// By how much two footprints overlap, in metres: how far one must move for them to part. Zero or
/// less if they don't.
pub(crate) fn overlap(a: &Body, b: &Body) -> f32 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let reach = a.radius + b.radius;
    let square = dx * dx + dy * dy;
    if square >= reach * reach {
        return 0.0;
    }
    match (a.is_circle, b.is_circle) {
        (true, true) => reach - square.sqrt(),
        (false, true) => circle_overlap(a, b.half[0], [dx, dy]),
        (true, false) => circle_overlap(b, a.half[0], [-dx, -dy]),
        (false, false) => rectangle_overlap(a, b, [dx, dy]),
    }
}

fn circle_overlap(rectangle: &Body, radius: f32, [dx, dy]: [f32; 2]) -> f32 {
    let (sin, cos) = rectangle.theta.sin_cos();
    // How far the centre is beyond each pair of sides.
    let beyond = [
        (dx * cos + dy * sin).abs() - rectangle.half[0],
        (dy * cos - dx * sin).abs() - rectangle.half[1],
    ];
    if beyond[0] > 0.0 && beyond[1] > 0.0 {
        return radius - beyond[0].hypot(beyond[1]);
    }
    radius - beyond[0].max(beyond[1])
}

fn rectangle_overlap(a: &Body, b: &Body, [dx, dy]: [f32; 2]) -> f32 {
    let ((asin, acos), (bsin, bcos)) = (a.theta.sin_cos(), b.theta.sin_cos());
    // The cosine and sine of the angle between them.
    let (cos, sin) = ((acos * bcos + asin * bsin).abs(), (acos * bsin - asin * bcos).abs());
    let along = |x: f32, y: f32| (dx * x + dy * y).abs();
    let ([al, aw], [bl, bw]) = (a.half, b.half);
    let depths = [
        al + bl * cos + bw * sin - along(acos, asin),
        aw + bl * sin + bw * cos - along(-asin, acos),
        bl + al * cos + aw * sin - along(bcos, bsin),
        bw + al * sin + aw * cos - along(-bsin, bcos),
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
    /// Takes the bodies of a frame; `seconds` have passed since the frame before. `edge` is the id
    /// of a robot's edge.
    pub fn take(
        &mut self,
        bodies: &[Body],
        [frame, tick]: [u64; 2],
        [time, seconds]: [f64; 2],
        edge: impl Fn(u32) -> Option<u32>,
    ) {
        let Self { grid, pairs } = self;
        grid.overlaps(bodies, |a, b, depth| {
            let (a, b) = (bodies[a], bodies[b]);
            let contact = pairs.entry((a.robot, b.robot)).or_insert_with(|| Contact {
                first: Finding {
                    robots: vec![a.robot, b.robot],
                    edge: edge(a.robot),
                    place: Some([0.5 * (a.x + b.x), 0.5 * (a.y + b.y)]),
                    limit: Some(f64::from(CONTACT_TOLERANCE)),
                    ..Finding::at(tick, time)
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
