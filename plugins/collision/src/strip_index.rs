//! A spatial index of a frame's robots: strips of the plane that run from west to east.
//!
//! The bounding box of all that counts of a robot is entered in every strip that it reaches into. A
//! strip is several times as high as the mean box, so that a box is entered in 1.2 strips on
//! average, however small and large boxes are mixed and however far apart they are. `sweep.rs` then
//! finds the boxes of a strip that overlap.
//!
//! Robots come in the order of their ids, which is unrelated to their positions. They are written
//! into strips in that order, with all data for the checks. After that, nothing is fetched from
//! distant memory, and a strip stays in the cache while it is processed. Strips that are far apart
//! share a bucket, so that the plane can be of any size.

use std::ops::ControlFlow;
use std::slice::from_ref;

use glam::Vec2;

use crate::body::{Body, Footprint};
use crate::bounds::Bounds;
use crate::chunk::Chunk;
use crate::frame_context::FrameContext;
use crate::grid::{KeyPacking, Scale};
use crate::prediction::Segment;
use crate::sweep::{Candidates, Limits, SortAndSweep};
use crate::swept_path::{SweptPath, segments_of};

/// Intended number of robots in a bucket.
const ROBOTS_PER_BUCKET: usize = 512;
/// Largest number of buckets.
const MAX_BUCKETS: usize = 2048;

/// A robot in a strip: half a cache line, because most of a frame's time goes into moving these.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(crate) struct PackedRobot {
    /// Position east and north, in metres.
    pub position: Vec2,
    /// Unit vector along the heading.
    pub heading: Vec2,
    /// Speed, in metres per second.
    pub speed: f32,
    /// Index of its type into the footprints.
    pub robot_type: u32,
    /// Id of the robot.
    pub id: u32,
    /// Twice the strip's number, plus one if it is the southernmost strip that the robot's box
    /// reaches into.
    strip_tag: i32,
}

impl PackedRobot {
    #[inline]
    pub(crate) fn body(&self, footprints: &[Footprint]) -> Body {
        let Footprint { half_length, half_width } = footprints[self.robot_type as usize];
        Body { position: self.position, heading: self.heading, half_length, half_width }
    }

    #[inline]
    pub(crate) fn strip(&self) -> i32 {
        self.strip_tag >> 1
    }

    /// Whether the strip in which a pair was found is the first one that both robots reach into. If
    /// it is not, or if the robots are in different strips that share a bucket, the pair is found
    /// again elsewhere.
    #[inline]
    pub(crate) fn is_first_with(&self, other: &Self) -> bool {
        (self.strip() == other.strip()) & ((self.strip_tag | other.strip_tag) & 1 != 0)
    }
}

/// Robots whose boxes reach into a strip, or into another strip that shares its bucket.
#[derive(Debug, Default)]
pub(crate) struct Strip {
    pub robots: Vec<PackedRobot>,
    /// The robots' swept paths, in the same order; empty without a horizon.
    pub swept_paths: Vec<SweptPath>,
    /// Trajectory segments of all swept paths.
    segments: Vec<Segment>,
}

impl Strip {
    pub(crate) fn clear(&mut self) {
        self.robots.clear();
        self.swept_paths.clear();
        self.segments.clear();
    }

    /// Adds a robot to the strip of this number. `is_first` if no strip farther south holds the
    /// robot.
    #[inline]
    pub(crate) fn enter(
        &mut self,
        robot: &PackedRobot,
        swept_path: Option<(&SweptPath, &[Segment])>,
        strip: i32,
        is_first: bool,
    ) {
        self.robots.push(*robot);
        if let Some(robot) = self.robots.last_mut() {
            robot.strip_tag = strip << 1 | i32::from(is_first);
        }
        if let Some((swept_path, segments)) = swept_path {
            self.swept_paths
                .push(SweptPath { first_segment: self.segments.len() as u32, ..*swept_path });
            self.segments.extend_from_slice(segments);
        }
    }

    #[inline]
    pub(crate) fn robot(&self, slot: u32) -> &PackedRobot {
        &self.robots[slot as usize]
    }

    /// Returns the swept path of a robot. There is one only with a horizon.
    #[inline]
    pub(crate) fn swept_path(&self, slot: u32) -> &SweptPath {
        &self.swept_paths[slot as usize]
    }

    /// Returns the trajectory of a robot, or `straight_on` if the robot drives straight on and has
    /// no segments.
    pub(crate) fn segments<'all>(
        &'all self,
        slot: u32,
        straight_on: &'all Segment,
    ) -> &'all [Segment] {
        let segments = segments_of(slot as usize, &self.swept_paths, &self.segments);
        if segments.is_empty() { from_ref(straight_on) } else { segments }
    }
}

/// Robots by strip. Kept from frame to frame to reuse its memory.
#[derive(Debug, Default)]
pub(crate) struct StripIndex {
    scale: Scale,
    packing: KeyPacking,
    /// Buckets by the lowest bits of the strip's number.
    strips: Vec<Strip>,
    chunk: Chunk,
    sort_and_sweep: SortAndSweep,
}

impl StripIndex {
    /// Replaces the contents by a frame's robots. Returns the number of robots that are present but
    /// left out, because their pose or their type's footprint is invalid.
    pub(crate) fn fill(&mut self, context: &FrameContext) -> usize {
        let robots = context.columns.x.len();
        context.sample(&mut self.chunk);
        let chunk = &self.chunk;
        self.scale = Scale::new((0..chunk.len).map(|number| chunk.bounds(number)));
        let buckets = (robots / ROBOTS_PER_BUCKET).next_power_of_two().min(MAX_BUCKETS);
        self.strips.resize_with(buckets, Strip::default);
        for strip in &mut self.strips {
            strip.clear();
        }
        let (mut invalid_robots, mut all) = (0, Bounds::NOTHING);
        for first in (0..robots).step_by(Chunk::ROBOTS) {
            invalid_robots +=
                context.fill(first..(first + Chunk::ROBOTS).min(robots), &mut self.chunk);
            all = all.join(self.chunk.all_bounds());
            self.enter();
        }
        self.packing = KeyPacking::new(self.scale, all, self.strips.len());
        invalid_robots
    }

    /// Enters a chunk of robots into their strips.
    fn enter(&mut self) {
        let Self { scale, strips, chunk, .. } = self;
        let mask = strips.len() as i32 - 1;
        let [first, last] = chunk.strips(*scale);
        for (number, robot) in chunk.robots().iter().enumerate() {
            let (first, last, swept_path) = (first[number], last[number], chunk.swept_path(number));
            for strip in first..last + 1 {
                strips[(strip & mask) as usize].enter(robot, swept_path, strip, strip == first);
            }
        }
        for (number, way) in chunk.other_ways() {
            let Some((swept_path, segments)) = chunk.swept_path(way) else { continue };
            let [first, last] =
                [swept_path.bounds.south(), swept_path.bounds.north()].map(|y| scale.strip(y));
            for strip in first..last + 1 {
                let way = Some((swept_path, segments));
                strips[(strip & mask) as usize].enter(
                    &chunk.robots()[number],
                    way,
                    strip,
                    strip == first,
                );
            }
        }
    }

    /// Passes all pairs of overlapping boxes to `check`. Stops when the limits of the whole frame
    /// are exceeded or when `check` breaks; the limits per robot only leave pairs out.
    pub(crate) fn sweep(
        &mut self,
        context: &FrameContext,
        limits: Limits,
        mut check: impl FnMut(&Strip, Candidates) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (footprints, padding, mut left) =
            (context.world.footprints(), context.padding(), limits);
        for strip in &self.strips {
            self.sort_and_sweep
                .sort(&self.packing, strip, |robot| Bounds::of(&robot.body(footprints), padding));
            self.sort_and_sweep.sweep(&mut left, |candidates| check(strip, candidates))?;
        }
        ControlFlow::Continue(())
    }

    /// Returns one location of each robot by id: the number of a bucket, and the robot's slot in
    /// it. Visits all robots.
    pub(crate) fn locations(&self) -> Vec<Option<(u32, u32)>> {
        let mut locations = Vec::new();
        for (bucket, strip) in (0..).zip(&self.strips) {
            for (slot, robot) in (0..).zip(&strip.robots) {
                let id = robot.id as usize;
                if id >= locations.len() {
                    locations.resize(id + 1, None);
                }
                locations[id] = Some((bucket, slot));
            }
        }
        locations
    }

    pub(crate) fn bucket(&self, number: u32) -> &Strip {
        &self.strips[number as usize]
    }
}
