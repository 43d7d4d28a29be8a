//! Lanes that the machine at hand would not choose.

use super::*;
use crate::fleet::testing::*;
use crate::fleet::{Fleet, Placement, RouteSource};
use crate::graph::NodeIndex;

/// The first two stages.
fn move_on(fleet: &mut Fleet, accelerate: fn(&mut Rows, Pace, &mut Lists), advance: fn(&mut Rows, Pace, &mut Listed)) {
    let (motion, mut rows) = fleet.parts();
    let mut lists = Lists::new();
    if rows.limits.is_some() {
        accelerate(&mut rows, motion.pace, &mut lists);
    } else {
        advance(&mut rows, motion.pace, &mut lists.arrived);
    }
    lists.near.rows().for_each(|row| motion.hand_over_limited(&mut rows, row, &mut events()));
    lists.arrived.rows().for_each(|row| motion.hand_over(&mut rows, row, &mut events()));
}

/// The lanes of machines without SSE2, here too.
#[test]
fn portable_lanes_give_the_bits_of_the_reference() {
    let graph = town(4, 6.0);
    for acceleration in [0.7, f32::INFINITY] {
        let types = vec![robot_type(f32::INFINITY, f32::INFINITY), robot_type(1.0, acceleration)];
        let [mut plain, mut lanes] = [(); 2].map(|()| fleet(&graph, config(types.clone())));
        for robot in 0..100 {
            let (place, kind) = (Placement::Node(NodeIndex(robot % 16)), robot as u16 % 2);
            for fleet in [&mut plain, &mut lanes] {
                fleet.spawn(place, kind, RouteSource::Random, 0, &mut events()).expect("a node");
            }
        }
        for _ in 0..2000 {
            move_on(&mut plain, scalar::accelerate, scalar::advance);
            move_on(&mut lanes, portable::accelerate, portable::advance);
            let [mut one, mut other] = [Frame::of(&plain), Frame::of(&lanes)];
            let (motion, rows) = plain.parts();
            scalar::write(&rows, motion.roads.pieces(), one.columns_mut());
            let (motion, rows) = lanes.parts();
            portable::write::<false>(&rows, motion.roads.pieces(), other.columns_mut());
            assert_eq!(bits(&one), bits(&other));
        }
    }
}
