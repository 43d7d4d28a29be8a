//! The doors and lifts of a running fleet: `regatta status` shows them, `regatta send door` and
//! `regatta send lift` request them.

use std::time::{Duration, Instant};

use regatta_kit::{DispatchError, Dispatcher};
use regatta_plugin::facility::{FacilityKind, FacilityState};
use regatta_plugin::order::NO_ROBOT;
use regatta_plugin::world::LiftRecord;
use regatta_plugin::{FacilityReader, FleetName, Participant, World};
use serde_json::{Value, json};

use crate::failure::Failure;

/// The time within which a producer gives a reader that joins its world and the states.
const JOIN_TIMEOUT: Duration = Duration::from_millis(500);
/// The interval at which they are polled.
const POLL: Duration = Duration::from_millis(5);

/// A door or a lift, with its state.
pub struct Facility {
    kind: FacilityKind,
    name: String,
    /// Its state in words.
    state: String,
    /// The robot for which it is requested.
    robot: Option<u32>,
}

/// Returns the doors and lifts of a fleet; none if it has none, or no world.
pub fn facilities(fleet: &FleetName) -> Result<Vec<Facility>, Failure> {
    let name = format!("status-{}", std::process::id());
    let dispatcher = Dispatcher::join(fleet, &name, JOIN_TIMEOUT)?;
    let has_any = dispatcher.world(|world| !world.doors().is_empty() || !world.lifts().is_empty());
    match has_any {
        Ok(true) => {}
        Ok(false) | Err(DispatchError::NoWorld(_)) => return Ok(Vec::new()),
        Err(error) => return Err(error.into()),
    }
    let participant = Participant::join(fleet, &format!("{name}-states"))?;
    let mut reader = FacilityReader::open_on(&participant)?;
    let start = Instant::now();
    while !reader.take()? && start.elapsed() < JOIN_TIMEOUT {
        std::thread::sleep(POLL);
    }
    Ok(dispatcher.world(|world| {
        let states = reader.states(world.run_id()).iter();
        states.filter_map(|state| Facility::new(world, state)).collect()
    })?)
}

impl Facility {
    fn new(world: &World<'_>, state: &FacilityState) -> Option<Self> {
        let (kind, index) = (state.kind()?, state.index as usize);
        let (name, words) = match kind {
            FacilityKind::Door => (world.doors().get(index)?.name, state.words(|_| "")),
            FacilityKind::Lift => {
                let lift = world.lifts().get(index)?;
                (lift.name, state.words(|level| level_name(world, lift, level)))
            }
        };
        Some(Self {
            kind,
            name: world.text(name).to_owned(),
            state: words,
            robot: (state.robot != NO_ROBOT).then_some(state.robot),
        })
    }

    /// Formats it in one line.
    pub fn line(&self) -> String {
        let kind = self.kind_name();
        let robot = self.robot.map_or_else(String::new, |robot| format!("  for robot {robot}"));
        format!("{kind:4}  {}  {}{robot}", self.name, self.state)
    }

    pub fn json(&self) -> Value {
        json!({
            "kind": self.kind_name(),
            "name": self.name,
            "state": self.state,
            "robot": self.robot,
        })
    }

    fn kind_name(&self) -> &'static str {
        match self.kind {
            FacilityKind::Door => "door",
            FacilityKind::Lift => "lift",
        }
    }
}

fn level_name<'world>(world: &World<'world>, lift: &LiftRecord, level: u32) -> &'world str {
    let level = world.lift_levels(lift).get(level as usize);
    level.map_or("", |level| world.text(level.name))
}

/// Returns the id of an edge through a door, by the door's name.
pub fn door_edge(world: &World<'_>, name: &str) -> Result<u32, Failure> {
    let door = world.doors().iter().find(|door| world.text(door.name) == name);
    let edge = door.and_then(|door| world.door_edges(door).first());
    let edge = edge.and_then(|edge| world.edges().get(*edge as usize));
    edge.map(|edge| edge.id).ok_or_else(|| {
        let names = world.doors().iter().map(|door| world.text(door.name));
        unknown("door", name, names.collect()).into()
    })
}

/// Returns the id of a node in the cabin of a lift, by the names of the lift and of the level.
pub fn lift_node(world: &World<'_>, name: &str, level: &str) -> Result<u32, Failure> {
    let Some(lift) = world.lifts().iter().find(|lift| world.text(lift.name) == name) else {
        let names = world.lifts().iter().map(|lift| world.text(lift.name));
        return Err(unknown("lift", name, names.collect()).into());
    };
    let levels = world.lift_levels(lift);
    let found = levels.iter().find(|other| world.text(other.name) == level);
    let node = found.and_then(|level| world.level_nodes(level).first());
    let node = node.and_then(|node| world.nodes().get(*node as usize));
    node.map(|node| node.id).ok_or_else(|| {
        let names = levels.iter().map(|level| world.text(level.name));
        unknown("level of that lift", level, names.collect()).into()
    })
}

fn unknown(kind: &str, name: &str, known: Vec<&str>) -> String {
    match known.is_empty() {
        true => format!("no {kind} is called '{name}'; there are none"),
        false => format!("no {kind} is called '{name}'; there are {}", known.join(", ")),
    }
}
