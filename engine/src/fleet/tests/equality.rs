//! A tick gives the same bits for every instruction set and any number of threads.

use std::sync::Arc;

use regatta_layout::{EdgeIndex, Gear, NodeIndex, RouteGraph};
use regatta_motion::Isa;
use regatta_plugin::command::{CommandKind, CommandRecord};
use regatta_plugin::event::{EventRecord, Refusal};
use regatta_plugin::frame::{ColumnsMut, Line};
use regatta_scenario::Repeat;

use super::support::*;
use crate::fleet::{EventBuffer, Fleet, FleetConfig, Placement, RouteSource};

/// Returns a fleet of robots with every kind of route: walks, loops in both gears, commands,
/// limits, parked and removed robots.
fn mixed(graph: &Arc<RouteGraph>, robots: u32, limited: bool, isa: Isa, threads: usize) -> Fleet {
    let limit = if limited { 0.9 } else { f32::INFINITY };
    let types = vec![
        robot_type(f32::INFINITY, f32::INFINITY),
        robot_type(1.1, limit),
        robot_type(3.0, limit / 3.0),
    ];
    let mut fleet = fleet(graph, FleetConfig { isa, threads, ..config(types) });
    let nodes = graph.nodes().len() as u32;
    let back = (0..).zip(graph.edges()).find(|(_, edge)| edge.reverse_speed.is_some());
    let (back, edge) = back.expect("an edge for both gears");
    for robot in 0..robots {
        let robot_type = (robot % 3) as u16;
        let spawn = |fleet: &mut Fleet, place, source| {
            fleet.spawn(place, robot_type, source, 0, &mut events())
        };
        let spawned = match robot % 7 {
            0..4 => {
                spawn(&mut fleet, Placement::Node(NodeIndex(robot % nodes)), RouteSource::Random)
            }
            4 => {
                let lap = [forward(back), reverse(back)];
                spawn(
                    &mut fleet,
                    Placement::Node(edge.origin),
                    RouteSource::Listed(lap.into(), Repeat::Loop),
                )
            }
            5 => spawn(
                &mut fleet,
                Placement::Edge(EdgeIndex(robot % back.max(1)), 0.4),
                RouteSource::Random,
            ),
            _ => spawn(&mut fleet, Placement::Node(NodeIndex(robot % nodes)), RouteSource::None),
        };
        assert_eq!(spawned, Ok(robot));
    }
    fleet
}

/// Returns commands that depend on the tick and the fleet alone.
fn commands(graph: &RouteGraph, fleet: &Fleet, robots: u32, tick: u32) -> Vec<CommandRecord> {
    let robot = tick.wrapping_mul(2_654_435_761) % robots;
    let command =
        |kind: CommandKind| CommandRecord { kind: kind as u32, robot, ..CommandRecord::default() };
    let leg = graph.departures(NodeIndex(tick % graph.nodes().len() as u32))[0];
    let reverse = u32::from(leg.gear == Gear::Reverse);
    let record = CommandRecord {
        id: graph.edge(leg.edge).id,
        reverse,
        released: 1,
        ..command(CommandKind::Leg)
    };
    match tick % 11 {
        0 => vec![command(CommandKind::Hold)],
        1 => vec![CommandRecord {
            robot: (tick - 1).wrapping_mul(2_654_435_761) % robots,
            ..command(CommandKind::Resume)
        }],
        2 => vec![CommandRecord { legs: 1, ..command(CommandKind::Assign) }, record],
        3 => vec![CommandRecord { legs: 1, ..command(CommandKind::Extend) }, record],
        4 => vec![command(CommandKind::Cancel)],
        5 => vec![command(CommandKind::Remove)],
        6 => vec![CommandRecord { id: 100, ..command(CommandKind::SpawnAtNode) }],
        7 => planned(graph, fleet, robot),
        8 => released(graph, fleet, (tick - 1).wrapping_mul(2_654_435_761) % robots, 0.37),
        10 => released(graph, fleet, (tick - 3).wrapping_mul(2_654_435_761) % robots, 2.3),
        _ => vec![],
    }
}

/// Returns the command of a route that is all horizon.
fn planned(graph: &RouteGraph, fleet: &Fleet, robot: u32) -> Vec<CommandRecord> {
    if !fleet.contains(robot) {
        return vec![];
    }
    let leg = graph.departures(fleet.node_ahead(robot as usize))[0];
    let record = |kind: CommandKind| CommandRecord {
        kind: kind as u32,
        robot,
        legs: 1,
        ..CommandRecord::default()
    };
    let reverse = u32::from(leg.gear == Gear::Reverse);
    vec![
        record(CommandKind::Assign),
        CommandRecord { id: graph.edge(leg.edge).id, reverse, ..record(CommandKind::Leg) },
    ]
}

/// Returns the release of some metres of the leg where a robot's base ends, or after it.
fn released(graph: &RouteGraph, fleet: &Fleet, robot: u32, s: f32) -> Vec<CommandRecord> {
    let Some(ahead) = fleet.ahead(robot) else { return vec![] };
    let Some(leg) = ahead.horizon.first() else { return vec![] };
    let (id, reverse) = (graph.edge(leg.edge).id, u32::from(leg.gear == Gear::Reverse));
    vec![CommandRecord {
        kind: CommandKind::Release as u32,
        robot,
        id,
        reverse,
        s,
        ..CommandRecord::default()
    }]
}

/// Steps a fleet and returns every frame and every event.
fn drive(graph: &RouteGraph, mut fleet: Fleet, ticks: u32) -> (Vec<Vec<Line>>, Vec<EventRecord>) {
    let robots = fleet.robots() as u32;
    let mut all = EventBuffer::new(1 << 20);
    let frames = (0..ticks).map(|tick| {
        fleet.apply(&commands(graph, &fleet, robots, tick), &mut all);
        step(&mut fleet, &mut all).lines
    });
    (frames.collect(), all.records().to_vec())
}

fn assert_same(robots: u32, limited: bool, ticks: u32, variants: &[(Isa, usize)]) {
    let graph = town(5, 6.0);
    let (frames, events) = drive(&graph, mixed(&graph, robots, limited, Isa::Scalar, 1), ticks);
    assert!(!events.is_empty());
    let refused_release = |event: &EventRecord| event.detail == Refusal::NotAhead as u32;
    assert!(!events.iter().any(refused_release), "the test releases what is ahead");
    for &(isa, threads) in variants {
        let (others, other_events) =
            drive(&graph, mixed(&graph, robots, limited, isa, threads), ticks);
        for (tick, (frame, other)) in frames.iter().zip(&others).enumerate() {
            let (frame, other): (&[u8], &[u8]) =
                (bytemuck::cast_slice(frame), bytemuck::cast_slice(other));
            assert!(frame == other, "{isa}, {threads} threads, tick {tick}");
        }
        assert_eq!(events, other_events, "{isa}, {threads} threads");
    }
}

fn supported() -> impl Iterator<Item = Isa> {
    Isa::ALL.into_iter().filter(|isa| isa.is_supported())
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let variants: Vec<_> = supported().map(|isa| (isa, 1)).collect();
    for robots in [1, 15, 63, 129] {
        assert_same(robots, false, 3000, &variants);
        assert_same(robots, true, 3000, &variants);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for limited in [false, true] {
        let variants =
            [(Isa::detect(), 1), (Isa::detect(), 2), (Isa::detect(), 3), (Isa::Scalar, 2)];
        assert_same(5 * 1024 + 77, limited, 400, &variants);
    }
}

#[test]
fn large_frames_are_written_with_the_same_bits() {
    let variants: Vec<_> = supported().map(|isa| (isa, 1)).collect();
    for limited in [false, true] {
        assert_same((1 << 17) + 5, limited, 7, &variants);
    }
}

/// Half of such a fleet doesn't look ahead, and its part of a frame isn't prefetched. The first
/// release, in tick 8, adds the columns of limits, with which no fleet looks ahead.
#[test]
fn looking_a_block_ahead_gives_the_same_bits() {
    assert_same((1 << 15) + 5, false, 8, &[(Isa::detect(), 1), (Isa::detect(), 2)]);
}

#[test]
fn every_line_of_a_frame_is_written() {
    let graph = town(3, 6.0);
    for isa in supported() {
        let mut fleet = mixed(&graph, 70, true, isa, 1);
        let unwritten = Line([-7e7; 16]);
        assert!(
            step(&mut fleet, &mut events()).lines.iter().all(|line| *line != unwritten),
            "{isa}"
        );
        assert!(poses(&mut fleet).lines.iter().all(|line| *line != unwritten), "{isa}");
    }
}

#[test]
fn steps_without_frames_move_robots_too() {
    let graph = town(3, 6.0);
    let [mut published, mut unpublished] =
        [(); 2].map(|()| mixed(&graph, 70, true, Isa::detect(), 1));
    for _ in 0..300 {
        step(&mut published, &mut events());
        unpublished.step(None, &mut events());
    }
    assert_eq!(bits(&poses(&mut published)), bits(&poses(&mut unpublished)));
}

#[test]
fn another_seed_gives_other_random_walks() {
    let graph = town(4, 6.0);
    let new = |seed| {
        let types = vec![robot_type(f32::INFINITY, f32::INFINITY)];
        let mut fleet = fleet(&graph, FleetConfig { seed, ..config(types) });
        fleet
            .spawn(Placement::Node(NodeIndex(0)), 0, RouteSource::Random, 0, &mut events())
            .expect("a node");
        (0..2000).for_each(|_| fleet.step(None, &mut events()));
        bits(&poses(&mut fleet)).to_vec()
    };
    assert_eq!(new(1), new(1));
    assert_ne!(new(1), new(2));
}

#[test]
#[should_panic(expected = "start on cache lines")]
fn columns_off_the_cache_lines_are_refused() {
    let mut fleet = mixed(&town(3, 6.0), 1, false, Isa::Scalar, 1);
    let mut lines = [Line([0.0; 16]); 8];
    let words: &mut [f32] = bytemuck::cast_slice_mut(&mut lines);
    let [x, y, theta, speed, s, edge, state] = words[1..113].as_chunks_mut::<16>().0 else {
        unreachable!()
    };
    let (edge, state) = (bytemuck::cast_slice_mut(edge), bytemuck::cast_slice_mut(state));
    fleet.write(ColumnsMut { x, y, theta, speed, s, edge, state });
}
