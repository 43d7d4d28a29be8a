//! A block of a frame's robots, by columns, so that the compiler vectorizes the work on them.

use glam::Vec2;

use crate::body::{Body, Footprint};
use crate::bounds::Bounds;
use crate::grid::Scale;
use crate::heading::heading;
use crate::leg_table::LegTable;
use crate::prediction::{Motion, Predictor, Segment};
use crate::strip_index::PackedRobot;
use crate::swept_path::{SweptPath, only_straight_on, segments_of};

/// A block of a frame's robots, by columns. Elements from `len` on are left over from earlier
/// blocks.
#[derive(Debug)]
pub(crate) struct Chunk {
    pub len: usize,
    pub id: Column<u32>,
    pub robot_type: Column<u32>,
    pub x: Column<f32>,
    pub y: Column<f32>,
    pub theta: Column<f32>,
    pub speed: Column<f32>,
    half_length: Column<f32>,
    half_width: Column<f32>,
    cos: Column<f32>,
    sin: Column<f32>,
    west: Column<f32>,
    south: Column<f32>,
    east: Column<f32>,
    north: Column<f32>,
    robots: Column<PackedRobot>,
    /// The robots' swept paths, in the same order; empty without a horizon. Behind them are those
    /// of the other ways that a robot may take.
    swept_paths: Vec<SweptPath>,
    /// Trajectory segments of all swept paths.
    segments: Vec<Segment>,
    /// Robots of the swept paths from the number of robots on.
    other_ways: Vec<u16>,
    predictor: Predictor,
    pending: OtherWays,
}

/// The other ways that robots may take, until the first ways of all robots are complete.
#[derive(Debug, Default)]
struct OtherWays {
    segments: Vec<Segment>,
    /// The robot of each way, and the end of the way's segments.
    ends: Vec<(u16, usize)>,
}

pub(crate) type Column<T> = [T; Chunk::ROBOTS];

impl Default for Chunk {
    fn default() -> Self {
        let column = [0.0; Self::ROBOTS];
        Self {
            len: 0,
            id: [0; Self::ROBOTS],
            robot_type: [0; Self::ROBOTS],
            x: column,
            y: column,
            theta: column,
            speed: column,
            half_length: column,
            half_width: column,
            cos: column,
            sin: column,
            west: column,
            south: column,
            east: column,
            north: column,
            robots: [PackedRobot::default(); Self::ROBOTS],
            swept_paths: Vec::new(),
            segments: Vec::new(),
            other_ways: Vec::new(),
            predictor: Predictor::default(),
            pending: OtherWays::default(),
        }
    }
}

impl Chunk {
    /// The largest number of robots: as many as fit into the first-level cache.
    pub(crate) const ROBOTS: usize = 256;

    /// Computes headings, and the bounds of what robots cover now plus `padding` metres. Elements
    /// beyond the last robot are computed too, so that the compiler knows the number of iterations.
    pub(crate) fn finish(&mut self, footprints: &[Footprint], padding: f32) {
        self.set_sizes(footprints);
        for ((theta, cos), sin) in self.theta.iter().zip(&mut self.cos).zip(&mut self.sin) {
            (*cos, *sin) = heading(*theta).into();
        }
        for number in 0..Self::ROBOTS {
            self.set_bounds(number, Bounds::of(&self.body(number), padding));
        }
        self.pack();
        self.segments.clear();
        self.swept_paths.clear();
        self.other_ways.clear();
    }

    fn set_bounds(&mut self, number: usize, bounds: Bounds) {
        (self.west[number], self.east[number]) = (bounds.west(), bounds.east());
        (self.south[number], self.north[number]) = (bounds.south(), bounds.north());
    }

    /// Fills in the sizes of the footprints by robot type.
    fn set_sizes(&mut self, footprints: &[Footprint]) {
        if let [only] = footprints {
            self.half_length.fill(only.half_length);
            self.half_width.fill(only.half_width);
            return;
        }
        for number in 0..Self::ROBOTS {
            // Elements beyond the last robot may have types of an earlier world.
            let footprint =
                footprints.get(self.robot_type[number] as usize).unwrap_or(&Footprint::UNKNOWN);
            (self.half_length[number], self.half_width[number]) =
                (footprint.half_length, footprint.half_width);
        }
    }

    /// Assembles robots from their columns, each value straight into its field: building a robot
    /// elsewhere and copying it would stall on store forwarding.
    fn pack(&mut self) {
        for number in 0..Self::ROBOTS {
            let robot = &mut self.robots[number];
            robot.position = Vec2::new(self.x[number], self.y[number]);
            robot.heading = Vec2::new(self.cos[number], self.sin[number]);
            robot.speed = self.speed[number];
            (robot.id, robot.robot_type) = (self.id[number], self.robot_type[number]);
        }
    }

    /// Predicts the trajectories of all robots until the horizon, in seconds. `motion` returns a
    /// robot's motion, given its number and its id.
    pub(crate) fn predict<'frame>(
        &mut self,
        table: &LegTable,
        horizon: f32,
        motion: impl Fn(usize, &Self) -> Motion<'frame>,
    ) {
        let mut predictor = std::mem::take(&mut self.predictor);
        let mut others = std::mem::take(&mut self.pending);
        for number in 0..self.len {
            let (first, body, mut end) = (self.segments.len(), self.body(number), None);
            let motion = motion(number, self);
            predictor.predict((&body, &motion), (table, horizon), &mut self.segments, |segments| {
                match end {
                    None => end = Some(segments.len()),
                    Some(end) => others.add(number, segments.drain(end..)),
                }
            });
            let swept_path = self.add_way(&body, first, self.bounds(number));
            self.set_bounds(number, swept_path.bounds);
        }
        let mut from = 0;
        for (number, to) in others.ends.drain(..) {
            let first = self.segments.len();
            self.segments.extend_from_slice(&others.segments[from..to]);
            // The first way has the box of the present.
            self.add_way(&self.body(number.into()), first, Bounds::NOTHING);
            self.other_ways.push(number);
            from = to;
        }
        others.segments.clear();
        (self.predictor, self.pending) = (predictor, others);
    }

    /// Adds the swept path of the segments from `first` on.
    fn add_way(&mut self, body: &Body, first: usize, now: Bounds) -> SweptPath {
        let swept_path = SweptPath::new(body, &self.segments, first, now);
        self.swept_paths.push(swept_path);
        if only_straight_on(body, &self.segments[first..]).is_some() {
            // The swept path already describes a single straight segment.
            self.segments.truncate(first);
        }
        swept_path
    }

    fn body(&self, number: usize) -> Body {
        Body {
            position: Vec2::new(self.x[number], self.y[number]),
            heading: Vec2::new(self.cos[number], self.sin[number]),
            half_length: self.half_length[number],
            half_width: self.half_width[number],
        }
    }

    pub(crate) fn robots(&self) -> &[PackedRobot] {
        &self.robots[..self.len]
    }

    /// Returns the swept path of a robot with its segments; `None` without a horizon.
    pub(crate) fn swept_path(&self, number: usize) -> Option<(&SweptPath, &[Segment])> {
        let swept_path = self.swept_paths.get(number)?;
        Some((swept_path, segments_of(number, &self.swept_paths, &self.segments)))
    }

    /// Returns the other ways that robots may take: the robot's number, and that of the swept path.
    pub(crate) fn other_ways(&self) -> impl Iterator<Item = (usize, usize)> {
        self.other_ways.iter().map(|number| usize::from(*number)).zip(self.len..)
    }

    /// Returns the bounding box of all that counts of a robot on its first way.
    pub(crate) fn bounds(&self, number: usize) -> Bounds {
        Bounds::new(
            Vec2::new(self.west[number], self.south[number]),
            Vec2::new(self.east[number], self.north[number]),
        )
    }

    /// Returns the bounding box of all that counts of all robots.
    pub(crate) fn all_bounds(&self) -> Bounds {
        let [west, south] = [&self.west, &self.south].map(|column| least(&column[..self.len]));
        let [east, north] = [&self.east, &self.north].map(|column| most(&column[..self.len]));
        let first_ways = Bounds::new(Vec2::new(west, south), Vec2::new(east, north));
        let others = self.swept_paths.get(self.len..).unwrap_or_default();
        others.iter().fold(first_ways, |all, other| all.join(other.bounds))
    }

    /// Returns the strips of the southern and of the northern sides; arbitrary numbers beyond the
    /// last robot.
    pub(crate) fn strips(&self, scale: Scale) -> [Column<i32>; 2] {
        [self.south, self.north].map(|column| column.map(|y| scale.strip(y)))
    }
}

impl OtherWays {
    fn add(&mut self, robot: usize, segments: impl Iterator<Item = Segment>) {
        self.segments.extend(segments);
        self.ends.push((robot as u16, self.segments.len()));
    }
}

fn least(values: &[f32]) -> f32 {
    extreme(values, f32::MAX, |a, b| if a < b { a } else { b })
}

fn most(values: &[f32]) -> f32 {
    extreme(values, -f32::MAX, |a, b| if a > b { a } else { b })
}

/// Returns the minimum or maximum of the values, whichever `pick` prefers, four at once.
fn extreme(values: &[f32], start: f32, pick: impl Fn(f32, f32) -> f32) -> f32 {
    let (fours, rest) = values.as_chunks::<4>();
    let mut found = [start; 4];
    for four in fours {
        found = [0, 1, 2, 3].map(|lane| pick(four[lane], found[lane]));
    }
    found.iter().chain(rest).fold(start, |one, other| pick(*other, one))
}
