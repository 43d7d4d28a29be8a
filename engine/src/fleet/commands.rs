//! Commands: each is read and checked as a whole, then carried out or refused.

use regatta_layout::{EdgeIndex, Gear, Leg, NodeIndex};
use regatta_motion::leg_of;
use regatta_plugin::command::{Authority, CommandKind, CommandRecord};
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::NO_ROBOT;

use super::facilities::Request;
use super::spawn::check_connected;
use super::{EventBuffer, Fleet, Placement, Plans, Route, RouteSource};

/// A checked command, ready to be carried out.
pub(super) enum Action {
    /// Drive these legs from the end of the current one; the first `released` of them now, the last
    /// of those (without any, the current leg) up to `limit` metres.
    Drive {
        row: usize,
        legs: Vec<Leg>,
        released: usize,
        limit: f64,
    },
    /// Release the first `released` legs of the route, the last of them up to `limit` metres.
    Release {
        row: usize,
        released: usize,
        limit: f64,
    },
    /// Nothing: the fleet is already as the command requests.
    Nothing,
    Cancel {
        row: usize,
    },
    Hold {
        row: usize,
    },
    Resume {
        row: usize,
    },
    Break {
        robot: u32,
    },
    Repair {
        robot: u32,
    },
    Remove {
        robot: u32,
    },
    Close {
        edge: EdgeIndex,
    },
    Open {
        edge: EdgeIndex,
    },
    Request {
        robot: u32,
        request: Request,
    },
    Spawn {
        placement: Placement,
        robot_type: u16,
    },
}

/// The reason why a command is refused, and the id that caused it.
pub(super) struct Rejection {
    pub reason: Refusal,
    pub id: u32,
}

/// Returns a function that makes a reason a rejection because of an id.
pub(super) fn because_of(id: u32) -> impl Fn(Refusal) -> Rejection {
    move |reason| Rejection { reason, id }
}

impl Fleet {
    /// Carries out a sample of commands of a sender that may give all of them, as
    /// [`apply_of`](Self::apply_of) does.
    pub fn apply(&mut self, records: &[CommandRecord], events: &mut EventBuffer) {
        self.apply_of(Authority::Full, records, events);
    }

    /// Carries out a sample of commands, one after the other, as far as its sender has the
    /// authority. Each is answered by an event, `Accepted` or `Refused`; a refused command changes
    /// nothing.
    ///
    /// If a command ends the base of a robot with limited acceleration nearer than it can brake,
    /// the robot brakes harder: it never leaves its released base. A loop's base ends with its lap,
    /// a random walk's with its leg.
    pub fn apply_of(
        &mut self,
        authority: Authority,
        records: &[CommandRecord],
        events: &mut EventBuffer,
    ) {
        let mut rest = records;
        while let [command, after @ ..] = rest {
            let legs =
                after.iter().take_while(|record| record.kind == CommandKind::Leg as u32).count();
            let consumed = if is_route(command) { legs.min(command.legs as usize) } else { 0 };
            let allowed = check_authority(command, authority);
            match allowed.and_then(|()| self.prepare(command, &after[..consumed])) {
                Ok(action) => self.carry_out(command, action, events),
                Err(rejection) => refuse(command, &rejection, events),
            }
            // Legs without a command are one mistake and get one answer.
            let skipped = if command.kind == CommandKind::Leg as u32 { legs } else { consumed };
            rest = &after[skipped..];
        }
    }

    fn prepare(
        &self,
        command: &CommandRecord,
        legs: &[CommandRecord],
    ) -> Result<Action, Rejection> {
        let robot = command.robot;
        let row = self.row(robot).map_err(because_of(robot));
        match kind(command) {
            Some(CommandKind::Assign) => self.prepare_route(command, row?, legs, Vec::new()),
            Some(CommandKind::Extend) => {
                let row = row?;
                let base = self.motion.plans.base(self.columns.route[row]).to_vec();
                self.prepare_route(command, row, legs, base)
            }
            Some(CommandKind::Release) => self.prepare_release(command, row?),
            Some(CommandKind::Cancel) => Ok(Action::Cancel { row: row? }),
            Some(CommandKind::Hold) => Ok(Action::Hold { row: row? }),
            Some(CommandKind::Resume) => Ok(Action::Resume { row: row? }),
            Some(CommandKind::Break) => row.map(|_| Action::Break { robot }),
            Some(CommandKind::Repair) => row.map(|_| Action::Repair { robot }),
            Some(CommandKind::Remove) => row.map(|_| Action::Remove { robot }),
            Some(CommandKind::CloseEdge) => Ok(Action::Close { edge: self.edge(command.id)? }),
            Some(CommandKind::OpenEdge) => Ok(Action::Open { edge: self.edge(command.id)? }),
            Some(
                kind @ (CommandKind::RequestDoor
                | CommandKind::ReleaseDoor
                | CommandKind::CallLift
                | CommandKind::ReleaseLift),
            ) => self.prepare_request(command, kind),
            Some(CommandKind::SpawnAtNode | CommandKind::SpawnOnEdge) => {
                self.prepare_spawn(command)
            }
            Some(CommandKind::Leg) | None => {
                Err(Rejection { reason: Refusal::MalformedCommand, id: command.id })
            }
        }
    }

    /// Prepares a route of `base`, the base that the robot keeps, followed by the legs of the
    /// command.
    fn prepare_route(
        &self,
        command: &CommandRecord,
        row: usize,
        records: &[CommandRecord],
        base: Vec<Leg>,
    ) -> Result<Action, Rejection> {
        let id = command.robot;
        if records.len() < command.legs as usize {
            return Err(Rejection { reason: Refusal::MalformedCommand, id });
        }
        let released = records.iter().take_while(|record| record.released != 0).count();
        if records.is_empty() || records[released..].iter().any(|record| record.released != 0) {
            return Err(Rejection { reason: Refusal::MalformedRoute, id });
        }
        let mut node =
            base.last().map_or_else(|| self.node_ahead(row), |&leg| self.graph.leg_end(leg));
        let limit = match (released, base.is_empty()) {
            (0, true) => self.limit_on_leg(row),
            (0, false) => self.motion.plans.limit(self.columns.route[row]),
            _ => f64::INFINITY,
        };
        let released = base.len() + released;
        let mut legs = base;
        for record in records {
            let leg = self.leg(record, node).map_err(because_of(record.id))?;
            node = self.graph.leg_end(leg);
            legs.push(leg);
        }
        Ok(Action::Drive { row, legs, released, limit })
    }

    /// Returns the leg of a record, which must leave a node.
    fn leg(&self, record: &CommandRecord, node: NodeIndex) -> Result<Leg, Refusal> {
        let graph = &self.graph;
        let gear = if record.reverse == 0 { Gear::Forward } else { Gear::Reverse };
        let leg = Leg { edge: graph.edge_by_id(record.id).ok_or(Refusal::UnknownEdge)?, gear };
        check_connected(graph, node, &[leg])?;
        if self.motion.legs.is_closed(leg.edge) { Err(Refusal::EdgeClosed) } else { Ok(leg) }
    }

    pub(super) fn edge(&self, id: u32) -> Result<EdgeIndex, Rejection> {
        self.graph.edge_by_id(id).ok_or(Rejection { reason: Refusal::UnknownEdge, id })
    }

    /// Prepares a request of a door or a lift.
    fn prepare_request(
        &self,
        command: &CommandRecord,
        kind: CommandKind,
    ) -> Result<Action, Rejection> {
        let CommandRecord { robot, id, .. } = *command;
        if robot != NO_ROBOT {
            self.row(robot).map_err(because_of(robot))?;
        }
        let door = || self.door_across(self.edge(id)?).map_err(because_of(id));
        let lift = || self.lift_with(id).map_err(because_of(id));
        let request = match kind {
            CommandKind::RequestDoor => Request::Door(door()?),
            CommandKind::ReleaseDoor => Request::ReleaseDoor(door()?),
            CommandKind::ReleaseLift => Request::ReleaseLift(lift()?.0),
            _ => {
                let (lift, level) = lift()?;
                Request::Lift(lift, level)
            }
        };
        Ok(Action::Request { robot, request })
    }

    fn prepare_spawn(&self, command: &CommandRecord) -> Result<Action, Rejection> {
        let graph = &self.graph;
        let placement = if command.kind == CommandKind::SpawnAtNode as u32 {
            let node = graph.node_by_id(command.id).ok_or(Refusal::UnknownNode);
            Placement::Node(node.map_err(because_of(command.id))?)
        } else {
            Placement::Edge(self.edge(command.id)?, command.s)
        };
        let reason = match u16::try_from(command.robot_type) {
            Ok(robot_type) => match self.check_spawn(placement, robot_type) {
                Ok(_) => return Ok(Action::Spawn { placement, robot_type }),
                Err(reason) => reason,
            },
            Err(_) => Refusal::UnknownRobotType,
        };
        let is_type = reason == Refusal::UnknownRobotType;
        Err(Rejection { reason, id: if is_type { command.robot_type } else { command.id } })
    }

    fn carry_out(&mut self, command: &CommandRecord, action: Action, events: &mut EventBuffer) {
        if let Action::Spawn { placement, robot_type } = action {
            match self.spawn(placement, robot_type, RouteSource::None, command.token, events) {
                Ok(robot) => accept(command, robot, events),
                Err(reason) => refuse(command, &Rejection { reason, id: command.id }, events),
            }
            return;
        }
        if let Action::Request { robot, request } = action {
            match self.request_facility(robot, request) {
                true => accept(command, robot, events),
                false => {
                    let reason = Refusal::LiftInUse;
                    refuse(command, &Rejection { reason, id: command.id }, events);
                }
            }
            return;
        }
        accept(command, command.robot, events);
        match action {
            Action::Drive { row, legs, released, limit } => {
                self.drive(row, legs, released, limit, events)
            }
            Action::Release { row, released, limit } => self.release(row, released, limit, events),
            Action::Cancel { row } => self.cancel(row, events),
            Action::Hold { row } => self.hold(row, events),
            Action::Resume { row } => self.resume(row, events),
            Action::Break { robot } => self.break_down(robot, events),
            Action::Repair { robot } => {
                self.repair(robot, events);
                self.change_battery(robot, events);
            }
            Action::Close { edge } => self.close_edge(edge, events),
            Action::Open { edge } => self.open_edge(edge, events),
            Action::Remove { robot } => self.remove_row(robot, command.token, events),
            Action::Nothing | Action::Spawn { .. } | Action::Request { .. } => {}
        }
    }

    fn drive(
        &mut self,
        row: usize,
        legs: Vec<Leg>,
        released: usize,
        limit: f64,
        events: &mut EventBuffer,
    ) {
        self.set_commanded_route(row, legs, released, limit);
        if !self.is_stopped(row) {
            self.motion.start_driving(&mut self.columns.all_rows(), row, events);
        }
    }

    fn cancel(&mut self, row: usize, events: &mut EventBuffer) {
        if self.is(row, RobotState::Idle) {
            return;
        }
        if self.columns.route[row] != Route::PARKED {
            match self.limit_on_leg(row) {
                f64::INFINITY => self.set_route(row, |_| Route::FINISH),
                limit => self.set_commanded_route(row, Vec::new(), 0, limit),
            }
        }
        if !self.is_stopped(row) {
            self.motion.start_driving(&mut self.columns.all_rows(), row, events);
        }
    }

    fn hold(&mut self, row: usize, events: &mut EventBuffer) {
        if let Some(impairment) = self.impairments.get_mut(&(row as u32)) {
            impairment.is_held = true;
            return;
        }
        if self.is(row, RobotState::Held) {
            return;
        }
        self.keep_idle(row);
        self.motion.hold(&mut self.columns.all_rows(), row, events);
    }

    fn resume(&mut self, row: usize, events: &mut EventBuffer) {
        if let Some(impairment) = self.impairments.get_mut(&(row as u32)) {
            if std::mem::replace(&mut impairment.is_held, false) {
                events.push_kind(EventKind::Resumed, row as u32, 0);
            }
            return;
        }
        if !self.is(row, RobotState::Held) {
            return;
        }
        events.push_kind(EventKind::Resumed, row as u32, 0);
        self.go_on(row, events);
    }

    /// Gives a robot another route and updates the end of its base and the speed from which it can
    /// brake on it.
    pub(super) fn set_route(&mut self, row: usize, route: impl FnOnce(&mut Plans) -> Route) {
        self.motion.plans.discard(self.columns.route[row]);
        self.columns.route[row] = route(&mut self.motion.plans);
        self.motion.update_base(&mut self.columns.all_rows(), row);
    }

    pub(super) fn is(&self, row: usize, state: RobotState) -> bool {
        self.columns.state[row] == state as u8
    }

    /// Returns the node that a robot's leg leads to, or the node that it stands on.
    pub(super) fn node_ahead(&self, row: usize) -> NodeIndex {
        let (piece, edge) = (self.columns.piece.get(row), self.columns.edge[row]);
        self.motion.legs.node_ahead(leg_of(piece, edge), piece)
    }
}

/// Checks that the sender of a command may give it.
fn check_authority(command: &CommandRecord, authority: Authority) -> Result<(), Rejection> {
    match authority {
        Authority::WithoutMovement if kind(command).is_some_and(CommandKind::moves) => {
            Err(Rejection { reason: Refusal::NotOwner, id: command.robot })
        }
        Authority::Full | Authority::WithoutMovement => Ok(()),
    }
}

/// Whether a command is followed by legs.
fn is_route(command: &CommandRecord) -> bool {
    matches!(kind(command), Some(CommandKind::Assign | CommandKind::Extend))
}

fn kind(command: &CommandRecord) -> Option<CommandKind> {
    CommandKind::from_number(command.kind)
}

fn accept(command: &CommandRecord, robot: u32, events: &mut EventBuffer) {
    events.push_record(EventRecord {
        token: command.token,
        kind: EventKind::Accepted as u32,
        robot,
        ..EventRecord::default()
    });
}

fn refuse(command: &CommandRecord, rejection: &Rejection, events: &mut EventBuffer) {
    events.push_record(EventRecord {
        token: command.token,
        kind: EventKind::Refused as u32,
        robot: command.robot,
        id: rejection.id,
        detail: rejection.reason as u32,
    });
}
