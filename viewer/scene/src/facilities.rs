//! Doors and lifts on the plan: the leaves of doors, and the outlines of cabins, in the colours of
//! their states.

use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::facility::{DoorState, FacilityKind, FacilityState};
use regatta_plugin::world::{DoorRecord, LiftRecord};

use super::is_on_level;
use super::palette::Rgb;

/// A bar on the ground.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Bar {
    /// Its ends, in metres east and north of the world's origin.
    pub ends: [Vec2; 2],
    /// A [`BarColour`].
    pub colour: u32,
}

/// The colour of a bar; facilities.wgsl has the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum BarColour {
    /// Closed.
    Closed = 0,
    /// In motion.
    Moving = 1,
    /// Open.
    Open = 2,
    /// A shaft whose cabin is elsewhere.
    Away = 3,
    /// A wall, in the theme's colour of walls.
    Wall = 4,
    /// A line from a station to a node of it, in the theme's colour of nodes.
    Link = 5,
    /// A line of a rack, in the theme's colour of racks.
    Rack = 6,
}

/// The colours of doors and cabins by [`BarColour`], those of facilities.wgsl.
pub const BAR_COLOURS: [Rgb; 4] = [Rgb(0xd8_232e), Rgb(0xf3_bc27), Rgb(0x30_b361), Rgb(0x7c_8189)];

/// The part of a door's half that is seen when it is open.
const JAMB: f32 = 0.15;
/// The side in metres of a cabin whose size isn't known.
const UNKNOWN_CABIN: f32 = 1.6;

/// Returns the bars of all doors and lifts of a level (`None` for all levels) at a tick. `states`
/// are in the order of the world; facilities without one aren't drawn.
pub fn bars(
    world: &World<'_>,
    states: &[FacilityState],
    tick: u64,
    level: Option<&str>,
) -> Vec<Bar> {
    let mut bars = Vec::new();
    for state in states {
        let index = state.index as usize;
        match state.kind() {
            Some(FacilityKind::Door) => {
                let door = world.doors().get(index).filter(|door| is_there(world, door, level));
                bars.extend(door.into_iter().flat_map(|door| leaves(door, state, tick)));
            }
            Some(FacilityKind::Lift) => {
                let lift = world.lifts().get(index);
                bars.extend(lift.into_iter().flat_map(|lift| cabin(world, lift, state, level)));
            }
            None => {}
        }
    }
    bars
}

/// Whether a door is on a level: that of its first edge.
fn is_there(world: &World<'_>, door: &DoorRecord, level: Option<&str>) -> bool {
    let edge = world.door_edges(door).first();
    let edge = edge.and_then(|edge| world.edges().get(*edge as usize));
    edge.is_some_and(|edge| is_on_level(world, edge.level, level))
}

/// Returns the two leaves of a door, which slide towards its ends.
fn leaves(door: &DoorRecord, state: &FacilityState, tick: u64) -> [Bar; 2] {
    let [start, end] = door.line.map(Vec2::from_array);
    let half = (end - start) / 2.0;
    let shut = (1.0 - state.openness(tick)).max(JAMB);
    let colour = colour(state.door()) as u32;
    [
        Bar { ends: [start, start + half * shut], colour },
        Bar { ends: [end, end - half * shut], colour },
    ]
}

/// Returns the sides of a cabin, on each level that it serves.
fn cabin(
    world: &World<'_>,
    lift: &LiftRecord,
    state: &FacilityState,
    level: Option<&str>,
) -> Vec<Bar> {
    let levels = world.lift_levels(lift).iter();
    let mut shown = (0..).zip(levels).filter(|(_, record)| is_on_level(world, record.name, level));
    let Some((first, _)) = shown.next() else { return Vec::new() };
    let is_here = level.is_none() || first == state.level || first == state.next_level;
    let colour = match (is_here, state.is_moving()) {
        (false, _) => BarColour::Away,
        (true, true) => BarColour::Moving,
        (true, false) => colour(state.door()),
    };
    let corners = corners(lift);
    let sides = (0..4).map(|side| [corners[side], corners[(side + 1) % 4]]);
    sides.map(|ends| Bar { ends, colour: colour as u32 }).collect()
}

/// The name of a door or a lift, and its place in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Named<'a> {
    /// The name.
    pub name: &'a str,
    /// The middle of the door, or the centre of the cabin.
    pub place: Vec2,
}

/// Returns the names and places of the doors and lifts of a level (`None` for all levels).
pub fn named<'a>(world: &World<'a>, level: Option<&str>) -> Vec<Named<'a>> {
    let doors = world.doors().iter().filter(|door| is_there(world, door, level));
    let doors = doors.map(|door| {
        let [start, end] = door.line.map(Vec2::from_array);
        Named { name: world.text(door.name), place: start.midpoint(end) }
    });
    let lifts = world.lifts().iter().filter(|lift| serves(world, lift, level));
    let lifts = lifts
        .map(|lift| Named { name: world.text(lift.name), place: Vec2::from_array(lift.centre) });
    doors.chain(lifts).collect()
}

/// Whether a lift serves a level.
fn serves(world: &World<'_>, lift: &LiftRecord, level: Option<&str>) -> bool {
    let mut levels = world.lift_levels(lift).iter();
    levels.any(|record| is_on_level(world, record.name, level))
}

fn corners(lift: &LiftRecord) -> [Vec2; 4] {
    let size = Vec2::from_array(lift.size);
    let size = if size.min_element() > 0.0 { size } else { Vec2::splat(UNKNOWN_CABIN) };
    let turn = Vec2::from_angle(lift.yaw);
    [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(x, y)| Vec2::from_array(lift.centre) + turn.rotate(size / 2.0 * Vec2::new(x, y)))
}

fn colour(door: DoorState) -> BarColour {
    match door {
        DoorState::Closed => BarColour::Closed,
        DoorState::Opening | DoorState::Closing => BarColour::Moving,
        DoorState::Open => BarColour::Open,
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{EdgeRecord, WorldData};

    use super::*;

    fn world() -> WorldData {
        let mut world = WorldData::default();
        let levels = ["L1", "L2"].map(|name| world.texts.add(name));
        world.edges = vec![EdgeRecord { level: levels[0], ..EdgeRecord::default() }];
        let line = [[0.0, -1.0], [0.0, 1.0]];
        world.add_door(DoorRecord { line, ..DoorRecord::default() }, [0]);
        let lift = LiftRecord { size: [2.0, 2.0], centre: [5.0, 0.0], ..LiftRecord::default() };
        world.add_lift(lift, [(levels[0], vec![0]), (levels[1], vec![1])], []);
        world
    }

    fn shown(states: &[FacilityState], tick: u64, level: Option<&str>) -> Vec<Bar> {
        bars(&world().view(1, 1), states, tick, level)
    }

    #[test]
    fn the_leaves_of_a_door_slide_apart() {
        let opening = FacilityState {
            door: DoorState::Opening as u32,
            since_tick: 100,
            ticks: 10,
            ..FacilityState::default()
        };
        let at = |tick| shown(&[opening], tick, Some("L1"))[0].ends[1].y;
        assert_eq!([100, 105].map(at), [0.0, -0.5]);
        assert!(at(110) < -0.8, "the jamb is still seen");
        assert!(shown(&[opening], 100, Some("L2")).is_empty(), "it is on the other level");
    }

    #[test]
    fn doors_and_lifts_are_named_on_their_levels() {
        let mut data = world();
        let [door, lift] = ["gate", "north"].map(|name| data.texts.add(name));
        (data.doors[0].name, data.lifts[0].name) = (door, lift);
        let names = |level| {
            let world = data.view(1, 1);
            named(&world, level).into_iter().map(|named| named.name.to_owned()).collect::<Vec<_>>()
        };
        assert_eq!(names(None), ["gate", "north"]);
        assert_eq!(names(Some("L2")), ["north"]);
        assert_eq!(named(&data.view(1, 1), None)[1].place, Vec2::new(5.0, 0.0));
    }

    #[test]
    fn a_cabin_has_the_colour_of_its_level() {
        let lift = FacilityState {
            kind: FacilityKind::Lift as u32,
            door: DoorState::Open as u32,
            ..FacilityState::default()
        };
        let colour = |state, level| shown(&[state], 0, level)[0].colour;
        assert_eq!(colour(lift, Some("L1")), BarColour::Open as u32);
        assert_eq!(colour(lift, Some("L2")), BarColour::Away as u32);
        let moving = FacilityState { next_level: 1, door: 0, ..lift };
        assert_eq!(colour(moving, Some("L2")), BarColour::Moving as u32);
        assert_eq!(shown(&[lift], 0, None).len(), 4, "the sides of the cabin, once");
        assert!(shown(&[lift], 0, Some("L3")).is_empty());
    }
}
