//! The rival: a well-kept spatial index, `rstar`, doing the broad phase alone.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Radius of the circle about a robot of 0.9 m × 0.6 m.
const RADIUS: f32 = 0.541;

/// How many pairs of robots have boxes that overlap: a tree of all boxes, filled in bulk and asked for each robot.
pub fn near_pairs(x: &[f32], y: &[f32]) -> usize {
    let box_of = |robot: usize| ([x[robot] - RADIUS, y[robot] - RADIUS], [x[robot] + RADIUS, y[robot] + RADIUS]);
    let boxes = (0..x.len()).map(|robot| {
        let (low, high) = box_of(robot);
        GeomWithData::new(Rectangle::from_corners(low, high), robot)
    });
    let tree = RTree::bulk_load(boxes.collect());
    let near = |robot: usize| {
        let (low, high) = box_of(robot);
        tree.locate_in_envelope_intersecting(&AABB::from_corners(low, high)).filter(|other| other.data > robot).count()
    };
    (0..x.len()).map(near).sum()
}
