//! Orders: read whole, checked whole, then carried out or refused.

use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::frame::RobotState;
use regatta_plugin::order::{OrderKind, OrderRecord};

use super::spawn::check_connected;
use super::{Events, Fleet, Placement, Route, RouteSource};
use crate::graph::{Gear, Leg, NodeIndex};
use crate::motion::leg_of;

/// What an order that can be carried out comes to.
enum Action {
    /// Drive these legs from the end of the current one; the first `released` now.
    Drive {
        row: usize,
        legs: Vec<Leg>,
        released: usize,
    },
    Cancel {
        row: usize,
    },
    Hold {
        row: usize,
    },
    Resume {
        row: usize,
    },
    Remove {
        robot: u32,
    },
    Spawn {
        placement: Placement,
        kind: u16,
    },
}

/// Why an order is refused, and the id that is to blame.
struct Denial {
    why: Refusal,
    id: u32,
}

impl Fleet {
    /// Carries out a sample of orders, one after the other. Each is answered by an event, `Accepted` or `Refused`; a
    /// refused one changes nothing.
    ///
    /// An order that takes road away from a robot with limited acceleration, nearer than it can brake, makes it brake
    /// harder: it never leaves its released base. A loop's base ends with its lap, a random walk's with its leg.
    pub fn apply(&mut self, records: &[OrderRecord], events: &mut Events) {
        let mut rest = records;
        while let [order, after @ ..] = rest {
            let legs = after.iter().take_while(|record| record.kind == OrderKind::Leg as u32).count();
            let taken = if is_route(order) { legs.min(order.legs as usize) } else { 0 };
            match self.prepare(order, &after[..taken]) {
                Ok(action) => self.carry_out(order, action, events),
                Err(denial) => refuse(order, &denial, events),
            }
            // Legs without an order are one mistake, not many.
            let skipped = if order.kind == OrderKind::Leg as u32 { legs } else { taken };
            rest = &after[skipped..];
        }
    }

    fn prepare(&self, order: &OrderRecord, legs: &[OrderRecord]) -> Result<Action, Denial> {
        let about = |id| move |why| Denial { why, id };
        let robot = order.robot;
        let row = || self.row(robot).map_err(about(robot));
        match kind(order) {
            Some(OrderKind::Assign) => self.prepare_route(order, row()?, legs, Vec::new()),
            Some(OrderKind::Extend) => {
                let row = row()?;
                self.prepare_route(order, row, legs, self.motion.plans.base(self.columns.route[row]).to_vec())
            }
            Some(OrderKind::Cancel) => Ok(Action::Cancel { row: row()? }),
            Some(OrderKind::Hold) => Ok(Action::Hold { row: row()? }),
            Some(OrderKind::Resume) => Ok(Action::Resume { row: row()? }),
            Some(OrderKind::Remove) => row().map(|_| Action::Remove { robot }),
            Some(OrderKind::SpawnAtNode | OrderKind::SpawnOnEdge) => self.prepare_spawn(order),
            Some(OrderKind::Leg) | None => Err(about(order.id)(Refusal::MalformedOrder)),
        }
    }

    /// A route of `base`, which the robot has already, and the legs of the order.
    fn prepare_route(
        &self,
        order: &OrderRecord,
        row: usize,
        records: &[OrderRecord],
        base: Vec<Leg>,
    ) -> Result<Action, Denial> {
        let about_robot = |why| Denial { why, id: order.robot };
        if records.len() < order.legs as usize {
            return Err(about_robot(Refusal::MalformedOrder));
        }
        let released = records.iter().take_while(|record| record.released != 0).count();
        if records.is_empty() || records[released..].iter().any(|record| record.released != 0) {
            return Err(about_robot(Refusal::MalformedRoute));
        }
        let mut node = base.last().map_or_else(|| self.node_ahead(row), |&leg| self.motion.roads.graph().leg_end(leg));
        let released = base.len() + released;
        let mut legs = base;
        for record in records {
            let leg = self.leg(record, node).map_err(|why| Denial { why, id: record.id })?;
            node = self.motion.roads.graph().leg_end(leg);
            legs.push(leg);
        }
        Ok(Action::Drive { row, legs, released })
    }

    /// A leg that leaves a node.
    fn leg(&self, record: &OrderRecord, node: NodeIndex) -> Result<Leg, Refusal> {
        let graph = self.motion.roads.graph();
        let gear = if record.reverse == 0 { Gear::Forward } else { Gear::Reverse };
        let leg = Leg { edge: graph.edge_by_id(record.id).ok_or(Refusal::UnknownEdge)?, gear };
        check_connected(graph, node, &[leg])?;
        Ok(leg)
    }

    fn prepare_spawn(&self, order: &OrderRecord) -> Result<Action, Denial> {
        let graph = self.motion.roads.graph();
        let about = |id| move |why| Denial { why, id };
        let placement = if order.kind == OrderKind::SpawnAtNode as u32 {
            graph.node_by_id(order.id).map(Placement::Node).ok_or(Refusal::UnknownNode)
        } else {
            graph.edge_by_id(order.id).map(|edge| Placement::Edge(edge, order.s)).ok_or(Refusal::UnknownEdge)
        };
        let placement = placement.map_err(about(order.id))?;
        let kind = u16::try_from(order.robot_type).map_err(|_| about(order.robot_type)(Refusal::UnknownRobotType))?;
        self.check_spawn(placement, kind).map_err(|why| {
            let id = if why == Refusal::UnknownRobotType { order.robot_type } else { order.id };
            Denial { why, id }
        })?;
        Ok(Action::Spawn { placement, kind })
    }

    fn carry_out(&mut self, order: &OrderRecord, action: Action, events: &mut Events) {
        let accepted = |robot| EventRecord {
            token: order.token,
            kind: EventKind::Accepted as u32,
            robot,
            ..EventRecord::default()
        };
        if let Action::Spawn { placement, kind } = action {
            match self.spawn(placement, kind, RouteSource::None, order.token, events) {
                Ok(robot) => events.push_record(accepted(robot)),
                Err(why) => refuse(order, &Denial { why, id: order.id }, events),
            }
            return;
        }
        events.push_record(accepted(order.robot));
        match action {
            Action::Drive { row, legs, released } => self.drive(row, legs, released, events),
            Action::Cancel { row } => self.cancel(row, events),
            Action::Hold { row } => self.hold(row, events),
            Action::Resume { row } => self.resume(row, events),
            Action::Remove { robot } => self.take_out(robot, order.token, events),
            Action::Spawn { .. } => {}
        }
    }

    fn drive(&mut self, row: usize, legs: Vec<Leg>, released: usize, events: &mut Events) {
        self.set_route(row, |plans| plans.order(legs, released));
        if !self.is(row, RobotState::Held) {
            self.motion.set_off(&mut self.columns.all_rows(), row, events);
        }
    }

    fn cancel(&mut self, row: usize, events: &mut Events) {
        if self.is(row, RobotState::Idle) {
            return;
        }
        if self.columns.route[row] != Route::PARKED {
            self.set_route(row, |_| Route::FINISH);
        }
        if !self.is(row, RobotState::Held) {
            self.motion.set_off(&mut self.columns.all_rows(), row, events);
        }
    }

    fn hold(&mut self, row: usize, events: &mut Events) {
        match self.columns.state[row] {
            state if state == RobotState::Held as u8 => return,
            // It has nothing to go on with when the hold ends.
            state if state == RobotState::Idle as u8 => self.set_route(row, |_| Route::PARKED),
            _ => {}
        }
        self.motion.hold(&mut self.columns.all_rows(), row, events);
    }

    fn resume(&mut self, row: usize, events: &mut Events) {
        if !self.is(row, RobotState::Held) {
            return;
        }
        events.push(EventKind::Resumed, row as u32, 0);
        if self.columns.route[row] == Route::PARKED {
            self.columns.state[row] = RobotState::Idle as u8;
        } else {
            self.motion.set_off(&mut self.columns.all_rows(), row, events);
        }
    }

    /// Gives a robot another route, and what lies ahead of it another speed.
    fn set_route(&mut self, row: usize, route: impl FnOnce(&mut super::Plans) -> Route) {
        self.motion.plans.release(self.columns.route[row]);
        self.columns.route[row] = route(&mut self.motion.plans);
        self.motion.look_ahead(&mut self.columns.all_rows(), row);
    }

    fn is(&self, row: usize, state: RobotState) -> bool {
        self.columns.state[row] == state as u8
    }

    /// The node that a robot comes to on its leg, or stands on.
    fn node_ahead(&self, row: usize) -> NodeIndex {
        let (piece, edge) = (self.columns.piece[row], self.columns.edge[row]);
        self.motion.roads.node_ahead(leg_of(piece, edge), piece)
    }
}

/// Whether legs belong to the order.
fn is_route(order: &OrderRecord) -> bool {
    matches!(kind(order), Some(OrderKind::Assign | OrderKind::Extend))
}

fn kind(order: &OrderRecord) -> Option<OrderKind> {
    use OrderKind::{Assign, Cancel, Extend, Hold, Leg, Remove, Resume, SpawnAtNode, SpawnOnEdge};
    [Leg, Assign, Extend, Cancel, Hold, Resume, SpawnAtNode, SpawnOnEdge, Remove]
        .into_iter()
        .find(|&kind| kind as u32 == order.kind)
}

fn refuse(order: &OrderRecord, denial: &Denial, events: &mut Events) {
    events.push_record(EventRecord {
        token: order.token,
        kind: EventKind::Refused as u32,
        robot: order.robot,
        id: denial.id,
        detail: denial.why as u32,
    });
}
