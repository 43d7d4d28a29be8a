//! Requests of paths, modes, doors and lifts.

use regatta_plugin::Commands;
use regatta_plugin::order::NO_ROBOT;
use ros2_client::Subscription;

use super::Tasks;
use crate::desk::Fleet;
use crate::link::{Link, LinkError, taken};
use crate::map::Map;
use crate::message::geometry::Pose;
use crate::message::open_rmf::{
    DoorRequest, LiftRequest, Location, ModeRequest, PathRequest, door_mode, lift, robot_mode,
};
use crate::options::robot_number;

/// The topics.
pub(crate) struct Requests {
    paths: Subscription<PathRequest>,
    modes: Subscription<ModeRequest>,
    doors: Subscription<DoorRequest>,
    lifts: Subscription<LiftRequest>,
    tasks: Tasks,
    fleet_name: String,
}

impl Requests {
    pub fn open(link: &mut Link, tasks: Tasks, fleet_name: String) -> Result<Self, LinkError> {
        Ok(Self {
            paths: link.input("/robot_path_requests")?,
            modes: link.input("/robot_mode_requests")?,
            doors: link.input("/door_requests")?,
            lifts: link.input("/lift_requests")?,
            tasks,
            fleet_name,
        })
    }

    /// Takes what has come. Requests of other fleets are not for this one.
    pub fn serve(&mut self, fleet: &mut Fleet<'_>) {
        for request in taken(&self.paths) {
            if request.fleet_name == self.fleet_name {
                let outcome = self.take_path(&request, fleet);
                log(fleet, "path", &request.robot_name, outcome);
            }
        }
        for request in taken(&self.modes) {
            if request.fleet_name == self.fleet_name {
                let outcome = self.take_mode(&request, fleet);
                log(fleet, "mode", &request.robot_name, outcome);
            }
        }
        for request in taken(&self.doors) {
            if let Some(door) = fleet.map.doors.iter().find(|it| it.name == request.door_name) {
                let edge = door.edge;
                let outcome = take_door(request.requested_mode.value, edge, fleet);
                log(fleet, "request of door", &request.door_name, outcome);
            }
        }
        for request in taken(&self.lifts) {
            let outcome = take_lift(&request, fleet);
            log(fleet, "request of lift", &request.lift_name, outcome);
        }
    }

    /// Sends a robot to the end of a path: the ways between its places are the fleet's own.
    fn take_path(&self, request: &PathRequest, fleet: &mut Fleet<'_>) -> Result<(), String> {
        let robot = find(&request.robot_name, fleet)?;
        let place = match request.path.last() {
            Some(last) => destination(last, fleet.map)?,
            // An empty path means to stop.
            None => return cancel(robot, fleet),
        };
        fleet.steering.send(robot, place).map_err(|error| error.to_string())?;
        self.tasks.set(robot, &request.task_id, None);
        Ok(())
    }

    fn take_mode(&self, request: &ModeRequest, fleet: &mut Fleet<'_>) -> Result<(), String> {
        let robot = find(&request.robot_name, fleet)?;
        let command = match request.mode.mode {
            robot_mode::PAUSED => Commands::hold,
            robot_mode::MOVING => Commands::resume,
            other => {
                let (paused, moving) = (robot_mode::PAUSED, robot_mode::MOVING);
                return Err(format!("mode {other} can't be set; {paused} and {moving} can"));
            }
        };
        let given = fleet.steering.give(robot, |commands| command(commands, robot));
        given.map_err(|error| error.to_string())?;
        self.tasks.set(robot, &request.task_id, Some(request.mode.mode_request_id));
        Ok(())
    }
}

fn cancel(robot: u32, fleet: &mut Fleet<'_>) -> Result<(), String> {
    fleet.steering.cancel(robot).map_err(|error| error.to_string())
}

fn find(name: &str, fleet: &Fleet<'_>) -> Result<u32, String> {
    let robot = robot_number(name).filter(|robot| fleet.snapshot.robot(*robot).is_some());
    robot.ok_or_else(|| "there is no such robot".to_owned())
}

fn destination(location: &Location, map: &Map) -> Result<u32, String> {
    let pose = Pose::on_ground(location.x.into(), location.y.into(), location.yaw.into());
    let place = map.near(&pose, Some(&location.level_name));
    place.map(|place| place.node).map_err(|error| error.to_string())
}

fn take_door(mode: u32, edge: u32, fleet: &mut Fleet<'_>) -> Result<(), String> {
    let given = fleet.steering.give(NO_ROBOT, |commands| match mode {
        door_mode::OPEN => commands.request_door(NO_ROBOT, edge),
        _ => commands.release_door(NO_ROBOT, edge),
    });
    given.map(|_| ()).map_err(|error| error.to_string())
}

fn take_lift(request: &LiftRequest, fleet: &mut Fleet<'_>) -> Result<(), String> {
    let Some(known) = fleet.map.lifts.iter().find(|it| it.name == request.lift_name) else {
        return Ok(());
    };
    let is_end = request.request_type == lift::END_SESSION;
    let wanted = |level: &&crate::map::LiftLevel| level.name == request.destination_floor;
    let level = known.levels.iter().find(wanted);
    // The end of a session names no level.
    let level = level.or_else(|| known.levels.first().filter(|_| is_end));
    let node = level.map(|level| level.node);
    let node = node.ok_or_else(|| format!("it has no level '{}'", request.destination_floor))?;
    let given = fleet.steering.give(NO_ROBOT, |commands| match is_end {
        true => commands.release_lift(NO_ROBOT, node),
        false => commands.call_lift(NO_ROBOT, node),
    });
    given.map(|_| ()).map_err(|error| error.to_string())
}

fn log(fleet: &mut Fleet<'_>, what: &str, whose: &str, outcome: Result<(), String>) {
    if let Err(reason) = outcome {
        fleet.steering.log(&format!("{what} of {whose}"), &reason);
    }
}
