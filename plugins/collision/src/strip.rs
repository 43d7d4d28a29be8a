//! A strip of the plane with the robots in it.

use std::slice::from_ref;

use glam::Vec2;

use crate::body::{Body, Footprint};
use crate::prediction::Segment;
use crate::swept_path::{SweptPath, segments_of};

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
