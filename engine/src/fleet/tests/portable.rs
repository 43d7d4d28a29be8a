//! The lanes of machines without SSE2, on every machine. Small enough for Miri.

use regatta_layout::NodeIndex;
use regatta_motion::{Isa, SupportedIsa};

use super::support::*;
use crate::fleet::{Fleet, Placement, RouteSource};

#[test]
fn portable_lanes_give_the_bits_of_the_reference() {
    let graph = town(4, 6.0);
    let scalar = SupportedIsa::detect(Isa::Scalar).expect("every machine runs the scalar kernel");
    for acceleration in [0.7, f32::INFINITY] {
        let types = vec![robot_type(f32::INFINITY, f32::INFINITY), robot_type(1.0, acceleration)];
        let [mut reference, mut portable] = [scalar, SupportedIsa::PORTABLE].map(|isa| {
            let mut fleet = fleet(&graph, config(types.clone()));
            fleet.motion.isa = isa;
            spawn_walks(&mut fleet);
            fleet
        });
        for _ in 0..2000 {
            let [one, other] =
                [&mut reference, &mut portable].map(|fleet| step(fleet, &mut events()));
            assert_eq!(bits(&one), bits(&other));
        }
    }
}

fn spawn_walks(fleet: &mut Fleet) {
    for robot in 0..100 {
        let (place, robot_type) = (Placement::Node(NodeIndex(robot % 16)), robot as u16 % 2);
        fleet.spawn(place, robot_type, RouteSource::Random, 0, &mut events()).expect("a node");
    }
}
