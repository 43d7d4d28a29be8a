//! States of robots, doors and lifts, once a second and whenever a door or a lift changes.

use std::time::{Duration, Instant};

use regatta_plugin::activity::Activity;
use regatta_plugin::facility::{DoorState as Door, FacilityState};
use regatta_plugin::{ColumnReader, FacilityReader, Participant, Result, World, column, tell};

use super::Tasks;
use crate::link::{Keep, Link, LinkError, Output};
use crate::map::Map;
use crate::message::geometry::Time;
use crate::message::open_rmf::{
    DoorMode, DoorState, FleetState, LiftState, Location, RobotMode, RobotState, door_mode, lift,
    robot_mode,
};
use crate::options::robot_name;
use crate::snapshot::{Robot, Snapshot};

/// The time between two states.
const EVERY: Duration = Duration::from_secs(1);
/// Robots of one message: 75 kB or so.
const ROBOTS: usize = 500;

/// The topics.
pub(crate) struct States {
    fleet: Output<FleetState>,
    doors: Output<DoorState>,
    lifts: Output<LiftState>,
    tasks: Tasks,
    ports: Option<Ports>,
    map: Map,
    names: Vec<String>,
    /// The names of the levels of edges.
    levels: Vec<String>,
    fleet_name: String,
    published: Option<Instant>,
    number: u64,
    is_cut: bool,
}

/// The ports of the fleet.
struct Ports {
    facilities: FacilityReader,
    activities: ColumnReader,
    batteries: ColumnReader,
    types: ColumnReader,
}

impl States {
    pub fn open(link: &mut Link, tasks: Tasks, fleet_name: String) -> Result<Self, LinkError> {
        Ok(Self {
            fleet: link.output("/fleet_states", Keep::Nothing, ROBOTS * 150)?,
            doors: link.output("/door_states", Keep::Nothing, 100)?,
            lifts: link.output("/lift_states", Keep::Nothing, 300)?,
            tasks,
            ports: None,
            map: Map::default(),
            names: Vec::new(),
            levels: Vec::new(),
            fleet_name,
            published: None,
            number: 0,
            is_cut: false,
        })
    }

    pub fn join(&mut self, fleet: &Participant) -> Result {
        self.ports = Some(Ports {
            facilities: FacilityReader::open_on(fleet)?,
            activities: ColumnReader::open_on(fleet, column::ACTIVITY.name())?,
            batteries: ColumnReader::open_on(fleet, column::BATTERY.name())?,
            types: ColumnReader::open_on(fleet, column::TYPE.name())?,
        });
        Ok(())
    }

    pub fn take_world(&mut self, world: &World<'_>) {
        self.map = Map::of(world);
        self.names = self.map.robot_types.clone();
        let level = |node: u32| world.nodes().get(node as usize).map_or(0, |node| node.level);
        let levels = world.edges().iter().map(|edge| match edge.level {
            0 => world.text(level(edge.origin)).to_owned(),
            own => world.text(own).to_owned(),
        });
        self.levels = levels.collect();
    }

    /// Publishes what has changed, and everything once a second.
    pub fn publish(&mut self, snapshot: &Snapshot) -> Result {
        let Some(mut ports) = self.ports.take() else { return Ok(()) };
        let outcome = self.publish_by(snapshot, &mut ports);
        self.ports = Some(ports);
        outcome
    }

    fn publish_by(&mut self, snapshot: &Snapshot, ports: &mut Ports) -> Result {
        let is_due = self.published.is_none_or(|published| published.elapsed() >= EVERY);
        if ports.facilities.take()? || is_due {
            self.publish_facilities(snapshot, &ports.facilities);
        }
        if !is_due {
            return Ok(());
        }
        self.published = Some(Instant::now());
        self.number += 1;
        let known = Known::take(ports)?;
        let cut = snapshot.robots.len() > ROBOTS;
        if cut && !std::mem::replace(&mut self.is_cut, true) {
            tell!("ros2: DDS loses larger messages: /fleet_states has the first {ROBOTS} robots");
        }
        let robots = snapshot.robots.iter().take(ROBOTS);
        let robots = robots.map(|robot| self.state(robot, snapshot, &known)).collect();
        self.fleet.publish(FleetState { name: self.fleet_name.clone(), robots });
        Ok(())
    }

    fn state(&self, robot: &Robot, snapshot: &Snapshot, known: &Known) -> RobotState {
        let row = robot.id as usize;
        let task = self.tasks.of(robot.id);
        let published = known.activities.get(row).and_then(|it| Activity::from_value(*it));
        let activity = Activity::of(robot.state, published).unwrap_or_default();
        let kind = known.types.get(row).map_or(0, |kind| *kind as usize);
        RobotState {
            name: robot_name(robot.id),
            model: self.names.get(kind).cloned().unwrap_or_default(),
            task_id: task.id,
            seq: self.number,
            mode: RobotMode {
                mode: mode(activity),
                mode_request_id: task.mode_request,
                performing_action: String::new(),
            },
            battery_percent: known.batteries.get(row).copied().unwrap_or(100.0),
            location: Location {
                t: snapshot.stamp(),
                x: robot.x as f32,
                y: robot.y as f32,
                yaw: robot.theta as f32,
                level_name: self.levels.get(robot.edge as usize).cloned().unwrap_or_default(),
                ..Location::default()
            },
            path: Vec::new(),
        }
    }

    fn publish_facilities(&mut self, snapshot: &Snapshot, reader: &FacilityReader) {
        let stamp = snapshot.stamp();
        for state in reader.doors(snapshot.run_id) {
            let Some(door) = self.map.doors.get(state.index as usize) else { continue };
            self.doors.publish(DoorState {
                door_time: stamp.clone(),
                door_name: door.name.clone(),
                current_mode: DoorMode { value: door_value(state.door()) },
            });
        }
        for state in reader.lifts(snapshot.run_id) {
            if let Some(state) = self.lift_state(state, &stamp) {
                self.lifts.publish(state);
            }
        }
    }

    fn lift_state(&self, state: &FacilityState, stamp: &Time) -> Option<LiftState> {
        let known = self.map.lifts.get(state.index as usize)?;
        let name = |level: u32| known.levels.get(level as usize).map(|level| level.name.clone());
        let motion_state = match state.next_level.cmp(&state.level) {
            std::cmp::Ordering::Less => lift::DOWN,
            std::cmp::Ordering::Equal => lift::STOPPED,
            std::cmp::Ordering::Greater => lift::UP,
        };
        let is_requested = state.requests > 0;
        Some(LiftState {
            lift_time: stamp.clone(),
            lift_name: known.name.clone(),
            available_floors: known.levels.iter().map(|level| level.name.clone()).collect(),
            current_floor: name(state.level).unwrap_or_default(),
            destination_floor: name(state.called_level).unwrap_or_default(),
            door_state: match state.door() {
                Door::Closed => lift::DOOR_CLOSED,
                Door::Opening | Door::Closing => lift::DOOR_MOVING,
                Door::Open => lift::DOOR_OPEN,
            },
            motion_state,
            available_modes: vec![lift::MODE_AGV],
            current_mode: lift::MODE_AGV,
            session_id: if is_requested { self.fleet_name.clone() } else { String::new() },
        })
    }
}

/// The columns that states have values of; empty if nobody publishes them.
#[derive(Default)]
struct Known {
    activities: Vec<f32>,
    batteries: Vec<f32>,
    types: Vec<f32>,
}

impl Known {
    fn take(ports: &mut Ports) -> Result<Self> {
        Ok(Self {
            activities: values(&mut ports.activities)?,
            batteries: values(&mut ports.batteries)?,
            types: values(&mut ports.types)?,
        })
    }
}

fn values(reader: &mut ColumnReader) -> Result<Vec<f32>> {
    reader.latest()?;
    Ok(reader.current()?.map_or_else(Vec::new, |column| column.values.to_vec()))
}

fn door_value(door: Door) -> u32 {
    match door {
        Door::Closed => door_mode::CLOSED,
        Door::Opening | Door::Closing => door_mode::MOVING,
        Door::Open => door_mode::OPEN,
    }
}

fn mode(activity: Activity) -> u32 {
    use Activity::*;
    match activity {
        Idle | Handling | Queued => robot_mode::IDLE,
        Charging => robot_mode::CHARGING,
        Fetching | Carrying | Moving | Rotating => robot_mode::MOVING,
        Held => robot_mode::PAUSED,
        Waiting | Stalled => robot_mode::WAITING,
        Broken | Faulted => robot_mode::EMERGENCY,
    }
}
