//! Requests for routes, and their command.
//!
//! A producer answers a few requests between two ticks, so robots with new commands come first,
//! then those that may collide. The plugin doesn't wait: until the answer arrives, a robot may take
//! any way. In lockstep, the answers to the requests of a tick arrive before the next one.

use std::collections::VecDeque;
use std::time::Instant;

use regatta_plugin::command::CommandKind;
use regatta_plugin::contact::{ContactLevel, ContactRecord};
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::{
    CommandLogReader, Frame, OpenError, Participant, PendingRoute, ReadError, RouteClient,
    RouteError, services,
};

use crate::routes::Routes;

/// The largest number of robots that wait for a request after a command.
const MAX_WAITING: usize = 4096;
/// The largest number of pairs and of other robots that are looked at for a frame.
const MAX_LOOKED_AT: usize = 1024;

/// The requests that have no answer yet, and the robots that are asked for next.
pub(crate) struct RouteRequests {
    client: RouteClient,
    commands: CommandLogReader,
    pending: Vec<Request>,
    /// Robots with commands since the last request.
    commanded: VecDeque<u32>,
    /// The robot from which to look for others.
    next: usize,
}

/// A request that has no answer yet.
struct Request {
    robot: u32,
    route: PendingRoute,
    sent: Instant,
    /// Answers from before this tick don't count: a command came later.
    not_before: u64,
}

impl RouteRequests {
    pub(crate) fn open_on(fleet: &Participant) -> Result<Self, OpenError> {
        Ok(Self {
            client: RouteClient::open_on(fleet)?,
            commands: CommandLogReader::open_on(fleet)?,
            pending: Vec::new(),
            commanded: VecDeque::new(),
            next: 0,
        })
    }

    /// Drops the requests to the producer of the run before.
    pub(crate) fn begin_run(&mut self) {
        self.pending.clear();
        self.commanded.clear();
    }

    /// Passes the commands and answers that have come to `routes`.
    pub(crate) fn receive(&mut self, routes: &mut Routes) -> Result<(), ReadError> {
        let Self { client, commands, pending, commanded, .. } = self;
        commands.take(|tick| {
            if tick.missed > 0 {
                routes.clear();
            }
            for command in tick.records.iter().filter(|command| changes_route(command.kind)) {
                routes.mark_stale(command.robot, tick.header.tick);
                for request in pending.iter_mut().filter(|request| request.robot == command.robot) {
                    request.not_before = tick.header.tick;
                }
                if commanded.len() < MAX_WAITING {
                    commanded.push_back(command.robot);
                }
            }
            Ok::<_, ReadError>(())
        })?;
        pending.retain(|request| match client.answer(&request.route) {
            Ok(None) => request.sent.elapsed() < RouteClient::TIMEOUT,
            Ok(Some(answer)) => {
                if answer.tick >= request.not_before {
                    routes.learn(&answer);
                }
                false
            }
            Err(_) => false,
        });
        Ok(())
    }

    /// Asks for the routes that are wanted most: those of robots with commands, of pairs that may
    /// collide, and of others in turn.
    pub(crate) fn ask(&mut self, routes: &Routes, frame: &Frame<'_>, contacts: &[ContactRecord]) {
        while self.has_room() {
            let Some(robot) = self.commanded.pop_front() else { break };
            if is_wanted(robot, routes, frame) && self.send(robot).is_err() {
                return;
            }
        }
        let possible =
            contacts.iter().filter(|contact| contact.level == ContactLevel::Possible as u32);
        let near = possible.take(MAX_LOOKED_AT).flat_map(|contact| contact.robots);
        let robots = frame.len();
        let first = if self.next < robots { self.next } else { 0 };
        let others = (first..robots).chain(0..first).take(MAX_LOOKED_AT).map(|robot| robot as u32);
        for (robot, in_turn) in
            near.map(|robot| (robot, false)).chain(others.map(|robot| (robot, true)))
        {
            if !self.has_room() || is_wanted(robot, routes, frame) && self.send(robot).is_err() {
                return;
            }
            if in_turn {
                self.next = robot as usize + 1;
            }
        }
    }

    fn has_room(&self) -> bool {
        self.pending.len() < services::MAX_OPEN_ROUTES
    }

    /// Sends a request, unless there is one for this robot.
    fn send(&mut self, robot: u32) -> Result<(), RouteError> {
        if !self.pending.iter().any(|request| request.robot == robot) {
            let route = self.client.ask(robot)?;
            self.pending.push(Request { robot, route, sent: Instant::now(), not_before: 0 });
        }
        Ok(())
    }
}

/// Whether a robot drives and its route is wanted.
fn is_wanted(robot: u32, routes: &Routes, frame: &Frame<'_>) -> bool {
    let (row, columns) = (robot as usize, frame.columns());
    let (Some(&edge), Some(&state)) = (columns.edge.get(row), columns.state.get(row)) else {
        return false;
    };
    let state = RobotState::from_number(state);
    let drives = state.is_stopped() || matches!(state, RobotState::Driving | RobotState::Turning);
    edge != NO_EDGE && drives && routes.is_wanted(robot)
}

/// Whether a command of a kind may change a robot's route.
fn changes_route(kind: u32) -> bool {
    use CommandKind::{Assign, Cancel, Extend, Release, Remove};
    [Assign, Extend, Release, Cancel, Remove].iter().any(|own| *own as u32 == kind)
}
