//! The robots that lose time in a frame, and their places.

use regatta_plugin::contact::{ContactLevel, ContactRecord};
use regatta_plugin::frame::{Frame, RobotState};

/// The speed below which a robot stands, in metres per second.
const STANDING: f32 = 0.05;
/// States are looked through in blocks of this size: most blocks have no robot that stops.
const BLOCK: usize = 64;

/// A robot that loses time in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    pub robot: u32,
    /// Metres east and north.
    pub place: [f32; 2],
    pub edge: u32,
    pub is_contact: bool,
}

/// Returns the losses of the robots that touch others, and then of those that stand and can't drive
/// on. `touching` has the [losses of contacts](touching). No robot is counted twice.
pub fn losses(frame: &Frame<'_>, touching: &[Loss]) -> impl Iterator<Item = Loss> {
    let (speeds, mut in_contact) = (frame.speed(), touching.iter().peekable());
    let standing = stopped(frame.state()).filter(move |robot| {
        // Both lists ascend.
        while in_contact.next_if(|loss| (loss.robot as usize) < *robot).is_some() {}
        let touches = in_contact.peek().is_some_and(|loss| loss.robot as usize == *robot);
        speeds[*robot].abs() < STANDING && !touches
    });
    let losses = standing.map(|robot| Loss {
        robot: robot as u32,
        place: [frame.x()[robot], frame.y()[robot]],
        edge: frame.edge()[robot],
        is_contact: false,
    });
    touching.iter().copied().chain(losses)
}

/// Returns the losses of the robots that touch others, by their numbers: each at the place of its
/// first pair.
pub fn touching(frame: &Frame<'_>, pairs: &[ContactRecord]) -> Vec<Loss> {
    let touching = pairs.iter().filter(|pair| pair.level == ContactLevel::Touching as u32);
    let mut all: Vec<Loss> = touching
        .flat_map(|pair| pair.robots.map(|robot| (robot, [pair.x, pair.y])))
        .filter_map(|(robot, place)| {
            let edge = *frame.edge().get(robot as usize)?;
            Some(Loss { robot, place, edge, is_contact: true })
        })
        .collect();
    all.sort_by_key(|loss| loss.robot);
    all.dedup_by_key(|loss| loss.robot);
    all
}

/// The numbers of the robots that want to drive on but can't, ascending.
fn stopped(states: &[u8]) -> impl Iterator<Item = usize> {
    let blocks = states.chunks(BLOCK).enumerate();
    // Without a branch per state, so that the compiler compares many at once.
    let with_stops = blocks
        .filter(|(_, block)| block.iter().fold(0, |any, state| any | u8::from(stops(*state))) != 0);
    with_stops.flat_map(|(number, block)| {
        let robots = block.iter().enumerate().filter(|(_, state)| stops(**state));
        robots.map(move |(row, _)| number * BLOCK + row)
    })
}

/// Whether a robot in a state wants to drive on but can't.
fn stops(state: u8) -> bool {
    (state == RobotState::Waiting as u8)
        | (state == RobotState::Faulted as u8)
        | (state == RobotState::Stalled as u8)
        | (state == RobotState::Broken as u8)
}
