//! A spatial index of a frame's robots: strips of the plane that run from west to east.
//!
//! The bounding box of all that counts of a robot is entered in every strip that it reaches into. A
//! strip is several times as high as the mean box, so that a box is entered in 1.2 strips on
//! average, however small and large boxes are mixed and however far apart they are. `sweep.rs` then
//! finds the boxes of a strip that overlap.
//!
//! Robots come by id, which says nothing about their positions. They are written into strips in
//! that order, with all that the checks need of them; from there on nothing is fetched from distant
//! memory, and a strip stays in the cache while it is processed. Strips that are far apart share a
//! bucket, so that the plane can be of any size.

use std::ops::ControlFlow;

use crate::bounds::Bounds;
use crate::chunk::Chunk;
use crate::frame_context::FrameContext;
use crate::grid::{KeyPacking, Scale};
use crate::strip::Strip;
use crate::sweep::{Candidates, Limits, SortAndSweep};

/// Intended number of robots in a bucket.
const ROBOTS_PER_BUCKET: usize = 512;
/// Largest number of buckets.
const MAX_BUCKETS: usize = 2048;

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
        self.strips.iter_mut().for_each(Strip::clear);
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
