//! The baselines: established spatial indexes, each rebuilt and queried in every frame. They find
//! the pairs that may touch; parry2d tests whether their rectangles do for all three.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use parry2d::bounding_volume::Aabb;
use parry2d::math::{Pose, Vector};
use parry2d::partitioning::{Bvh, BvhBuildStrategy, BvhWorkspace};
use parry2d::query::details::intersection_test_cuboid_cuboid;
use parry2d::shape::Cuboid;
use regatta_plugin::frame::Columns;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::fleet::{LENGTH, WIDTH};

/// A robot of the first type.
#[derive(Clone, Copy)]
struct Body {
    pose: Pose,
    low: [f32; 2],
    high: [f32; 2],
}

fn bodies(columns: &Columns) -> Vec<Body> {
    let body = |((x, y), theta): ((&f32, &f32), &f32)| {
        let (sin, cos) = theta.sin_cos();
        let (cos_abs, sin_abs) = (0.5 * cos.abs(), 0.5 * sin.abs());
        let half = [LENGTH * cos_abs + WIDTH * sin_abs, LENGTH * sin_abs + WIDTH * cos_abs];
        let (low, high) = ([x - half[0], y - half[1]], [x + half[0], y + half[1]]);
        Body { pose: Pose::new(Vector::new(*x, *y), *theta), low, high }
    };
    columns.x.iter().zip(columns.y).zip(columns.theta).map(body).collect()
}

fn touch(a: &Body, b: &Body) -> bool {
    let cuboid = Cuboid::new(Vector::new(0.5 * LENGTH, 0.5 * WIDTH));
    intersection_test_cuboid_cuboid(&a.pose.inv_mul(&b.pose), &cuboid, &cuboid)
}

/// Counts the touching pairs with an R*-tree of all boxes, bulk-loaded and queried for each robot.
pub fn rstar(columns: Columns) -> usize {
    let bodies = bodies(&columns);
    let leaf = |(robot, body): (usize, &Body)| {
        GeomWithData::new(Rectangle::from_corners(body.low, body.high), robot)
    };
    let tree = RTree::bulk_load(bodies.iter().enumerate().map(leaf).collect());
    let touching = |(robot, body): (usize, &Body)| {
        let near = tree.locate_in_envelope_intersecting(&AABB::from_corners(body.low, body.high));
        near.filter(|other| other.data > robot && touch(body, &bodies[other.data])).count()
    };
    bodies.iter().enumerate().map(touching).sum()
}

/// Counts the touching pairs with parry2d's tree of bounding volumes, which reports the overlapping
/// pairs itself.
pub fn parry(columns: Columns) -> usize {
    let bodies = bodies(&columns);
    let aabb = |body: &Body| Aabb::new(Vector::from(body.low), Vector::from(body.high));
    let leaves: Vec<_> = bodies.iter().map(aabb).collect();
    let mut touching = 0;
    Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves).traverse_bvtt_single_tree::<false>(
        &mut BvhWorkspace::default(),
        &mut |one, other| {
            touching += usize::from(touch(&bodies[one as usize], &bodies[other as usize]));
        },
    );
    touching
}

/// Counts the touching pairs with a k-d tree of the robots' positions, queried for those within two
/// radii.
pub fn kiddo(columns: Columns) -> usize {
    let bodies = bodies(&columns);
    let points: Vec<_> = columns.x.iter().zip(columns.y).map(|(x, y)| [*x, *y]).collect();
    let tree: ImmutableKdTree<f32, 2> = ImmutableKdTree::new_from_slice(&points).expect("a tree");
    let reach = LENGTH * LENGTH + WIDTH * WIDTH;
    let touching = |robot: usize| {
        let near =
            tree.query(&points[robot]).within::<SquaredEuclidean<f32>>(reach).unsorted().execute();
        let others = near.iter().map(|found| found.item as usize);
        others.filter(|other| *other > robot && touch(&bodies[robot], &bodies[*other])).count()
    };
    (0..points.len()).map(touching).sum()
}
