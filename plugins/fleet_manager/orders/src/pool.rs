//! The pool of all open orders: the one place where their states change.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::assign::{Assigner, Candidate};
use super::figures::{Counts, Figures};
use super::order::{
    Change, HistoryEntry, NewOrder, Order, OrderEvent, OrderId, OrderName, State, Stop, Unroutable,
};
use super::places::Places;
use super::stations::{Service, Stations};
use super::storages::{Lack, Storages};
use super::threads::Threads;
use super::threads::{ABSENT, Reply, Request, Update, Vehicle, WithdrawError};

mod assignment;
mod requests;
mod sources;
mod storing;

pub use assignment::Assignments;
pub use sources::LoadStops;
use sources::Source;
pub(super) use sources::{Known, Restored};
use storing::Unplaced;

/// The next step of a robot after a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Next {
    /// It drives to this stop of the same order.
    Stop(Stop),
    /// The order is finished, and the robot is free.
    Done,
}

/// The order that a robot has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held {
    /// The order.
    pub id: OrderId,
    /// Whether the robot has handled a stop of it, so that it stays with the robot.
    pub is_bound: bool,
}

/// All open orders, and the sources of new ones.
///
/// It is deterministic: the same calls make the same orders, assignments and events, except for
/// those of requests over the web API.
#[derive(Default)]
pub struct OrderPool {
    places: Arc<Places>,
    assigner: Box<dyn Assigner>,
    open: BTreeMap<OrderId, Order>,
    names: BTreeMap<OrderName, OrderId>,
    by_robot: FxHashMap<u32, Held>,
    waiting: BTreeSet<OrderId>,
    new_waiting: Vec<OrderId>,
    /// The open orders that only one robot may get, by robot.
    intended: BTreeSet<(u32, OrderId)>,
    /// Orders whose earliest start is to come, by its bits: times are not negative, and so these
    /// sort like numbers.
    early: BTreeSet<(u64, OrderId)>,
    /// Orders of files that are to come, the last one first.
    timetable: Vec<(f64, NewOrder)>,
    sources: Vec<Source>,
    /// The number of robots of each type; empty as long as nobody has told it.
    fleet: Vec<usize>,
    stations: Stations,
    storages: Storages,
    /// The orders that wait for places, and the storage that had none when they were last tried.
    unplaced: BTreeMap<Unplaced, Option<Lack>>,
    /// The source of each open order that a generator made, as an index.
    made_by: BTreeMap<OrderId, usize>,
    next_id: u64,
    next_reassignment_secs: f64,
    opened_secs: Option<f64>,
    counts: Counts,
    events: Vec<OrderEvent>,
    pub(super) threads: Option<Threads>,
    changed: BTreeSet<OrderId>,
    closed: Vec<Arc<Order>>,
    vehicles: BTreeMap<u32, Vehicle>,
    changed_vehicles: BTreeSet<u32>,
    replies: Vec<Reply<()>>,
    next_figures_secs: f64,
}

/// The simulated time, in seconds, between figures for the web API.
const FIGURES_PERIOD_SECS: f64 = 1.0;

impl std::fmt::Debug for OrderPool {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        let (open, robots) = (self.open.len(), self.by_robot.len());
        formatter
            .debug_struct("OrderPool")
            .field("open", &open)
            .field("robots", &robots)
            .finish_non_exhaustive()
    }
}

impl OrderPool {
    /// Makes an empty pool in memory, with the default assigner.
    pub fn new(places: Arc<Places>) -> Self {
        Self { places, next_id: 1, ..Self::default() }
    }

    /// Uses another assigner.
    pub fn set_assigner(&mut self, assigner: impl Assigner + 'static) {
        self.assigner = Box::new(assigner);
    }

    /// The places that orders name.
    pub fn places(&self) -> &Arc<Places> {
        &self.places
    }

    /// Returns an open order.
    pub fn order(&self, id: OrderId) -> Option<&Order> {
        self.open.get(&id)
    }

    /// All open orders, in ascending order of their numbers.
    pub fn open_orders(&self) -> impl Iterator<Item = &Order> {
        self.open.values()
    }

    /// The orders that wait for a robot, in ascending order of their numbers.
    pub fn waiting_orders(&self) -> impl Iterator<Item = &Order> {
        self.waiting.iter().filter_map(|id| self.open.get(id))
    }

    /// Returns an order if it waits for a robot.
    pub fn waiting_order(&self, id: OrderId) -> Option<&Order> {
        self.waiting.contains(&id).then(|| self.open.get(&id))?
    }

    /// Takes the orders that have begun to wait for a robot since the last call, in ascending order
    /// of their numbers. Some may not wait any more.
    pub fn take_new_waiting(&mut self) -> Vec<OrderId> {
        let mut orders = std::mem::take(&mut self.new_waiting);
        orders.sort_unstable();
        orders.dedup();
        orders
    }

    fn wait(&mut self, id: OrderId) {
        self.waiting.insert(id);
        self.new_waiting.push(id);
    }

    /// Returns the order that a robot has.
    pub fn order_of(&self, robot: u32) -> Option<OrderId> {
        self.held(robot).map(|held| held.id)
    }

    /// Returns the order that a robot has, and whether it stays with it. This takes less time than
    /// to look at the order.
    pub fn held(&self, robot: u32) -> Option<Held> {
        self.by_robot.get(&robot).copied()
    }

    /// Returns the stop that a robot drives to, or is at.
    pub fn current_stop(&self, robot: u32) -> Option<Stop> {
        let order = self.order(self.order_of(robot)?)?;
        order.content.stops.get(order.handled_stops).copied()
    }

    /// Whether a robot's order stays with it, because it has handled a stop of it.
    pub fn is_bound(&self, robot: u32) -> bool {
        self.held(robot).is_some_and(|held| held.is_bound)
    }

    /// Notes that a robot waits in the queue before its current stop.
    pub fn queued(&mut self, robot: u32, now_secs: f64) {
        if let Some(id) = self.order_in(robot, State::Travelling(robot))
            && let Some(order) = self.open.get(&id)
        {
            let stop = order.handled_stops as u32;
            self.note(id, now_secs, Change::Queued { robot, stop });
        }
    }

    /// Notes that a robot is at its current stop. Returns its service there; `None` if it wasn't
    /// driving to a stop.
    pub fn arrived(&mut self, robot: u32, now_secs: f64) -> Option<Service> {
        let id = self.order_in(robot, State::Travelling(robot))?;
        let order = self.open.get_mut(&id)?;
        let service = self.stations.serve(order.content.stops.get(order.handled_stops)?, now_secs);
        order.state = State::Handling(robot);
        let (stop, waited_secs) = (order.handled_stops as u32, now_secs - order.ready_secs());
        if stop == 0 {
            self.counts.waiting_secs.push(waited_secs as f32);
        }
        let wait_secs = service.begin_secs - now_secs;
        self.note(id, now_secs, Change::Arrived { robot, stop, wait_secs });
        Some(service)
    }

    /// Records that a robot has handled its current stop. Returns the next step; `None` if it
    /// wasn't at a stop.
    pub fn handled(&mut self, robot: u32, now_secs: f64) -> Option<Next> {
        let id = self.order_in(robot, State::Handling(robot))?;
        let order = self.open.get_mut(&id)?;
        let stop = order.handled_stops as u32;
        order.handled_stops += 1;
        order.state = State::Travelling(robot);
        let next = order.content.stops.get(order.handled_stops).copied();
        self.by_robot.insert(robot, Held { id, is_bound: true });
        self.counts.stops += 1;
        self.storages.handled(id, stop as usize);
        self.note(id, now_secs, Change::Handled { robot, stop });
        if next.is_none() {
            self.close(id, State::Finished(robot), now_secs, Change::Finished { robot });
        }
        Some(next.map_or(Next::Done, Next::Stop))
    }

    /// Notes that a robot can't carry its order out. Returns the order, which is over.
    pub fn failed(&mut self, robot: u32, now_secs: f64, reason: &str) -> Option<OrderId> {
        let id = self.order_of(robot)?;
        let change = Change::Failed { robot: Some(robot), reason: reason.to_owned() };
        self.close(id, State::Failed, now_secs, change);
        Some(id)
    }

    /// Takes a robot's order from it; the order waits for another one.
    ///
    /// # Errors
    /// [`WithdrawError`] if the robot has no order, or has handled a stop of it.
    pub fn withdraw(&mut self, robot: u32, now_secs: f64) -> Result<OrderId, WithdrawError> {
        let id = self.order_of(robot).ok_or(WithdrawError::Unknown)?;
        let order = self.open.get_mut(&id).ok_or(WithdrawError::Unknown)?;
        if order.is_bound() {
            return Err(WithdrawError::Begun);
        }
        order.state = State::Waiting;
        self.by_robot.remove(&robot);
        self.wait(id);
        self.note(id, now_secs, Change::Withdrawn { robot });
        Ok(id)
    }

    /// Records that no robot can reach the stops of an order, which has no robot. Returns whether
    /// it was waiting.
    pub fn unroutable(&mut self, id: OrderId, now_secs: f64, reason: Unroutable) -> bool {
        let is_waiting = self.waiting.remove(&id);
        if let Some(order) = self.open.get_mut(&id).filter(|_| is_waiting) {
            order.state = State::Unroutable;
            order.reason = reason.to_string();
            if let Some(source) = self.source_of(id) {
                source.unroutable += 1;
            }
            self.note(id, now_secs, Change::Unroutable { reason, lack: None });
        }
        is_waiting
    }

    /// Notes that the stops of an unroutable order can be reached again. Returns whether it was
    /// unroutable.
    pub fn reopen(&mut self, id: OrderId, now_secs: f64) -> bool {
        let Some(order) = self.open.get_mut(&id).filter(|order| order.state == State::Unroutable)
        else {
            return false;
        };
        order.state = State::Waiting;
        order.reason.clear();
        self.wait(id);
        if let Some(source) = self.source_of(id) {
            source.unroutable -= 1;
        }
        self.note(id, now_secs, Change::Reopened);
        true
    }

    /// Returns all events since the last call, in their order.
    pub fn events(&mut self) -> std::vec::Drain<'_, OrderEvent> {
        self.events.drain(..)
    }

    /// Returns the figures since the first tick of this pool.
    pub fn figures(&self, now_secs: f64) -> Figures {
        let secs = now_secs - self.opened_secs.unwrap_or(now_secs);
        self.counts.figures(self.open.values(), secs, now_secs)
    }

    /// Lets the current rate of orders count from now on: the warm-up of the run has ended.
    pub fn begin_rate(&mut self, now_secs: f64) {
        self.counts.rate_since_secs = now_secs;
    }

    /// The number of stops that robots have handled.
    pub fn handled_stops(&self) -> usize {
        self.counts.stops
    }

    /// Notes the state of a robot for the web API. Its order is filled in.
    pub fn show_vehicle(&mut self, mut vehicle: Vehicle) {
        let order = self.order_of(vehicle.robot).and_then(|id| self.order(id));
        vehicle.transport_order = order.map(|order| order.content.name.clone());
        let is_new = !self.vehicles.contains_key(&vehicle.robot);
        if is_new && vehicle.state == ABSENT {
            return;
        }
        if self.vehicles.get(&vehicle.robot) != Some(&vehicle) {
            self.changed_vehicles.insert(vehicle.robot);
            self.vehicles.insert(vehicle.robot, vehicle);
        }
    }

    /// Passes the changes of a tick to the store and the web API, without waiting for them.
    pub fn publish(&mut self, now_secs: f64) {
        let changed = std::mem::take(&mut self.changed);
        let closed = std::mem::take(&mut self.closed);
        let vehicles = std::mem::take(&mut self.changed_vehicles);
        let done = std::mem::take(&mut self.replies);
        let is_figures_time = self.is_served() && now_secs >= self.next_figures_secs;
        let figures = is_figures_time.then(|| self.figures(now_secs));
        let Some(threads) = &mut self.threads else { return };
        if is_figures_time {
            self.next_figures_secs = now_secs + FIGURES_PERIOD_SECS;
        }
        let open = changed.iter().filter_map(|id| self.open.get(id).cloned().map(Arc::new));
        let vehicles =
            vehicles.iter().filter_map(|robot| self.vehicles.get(robot).cloned()).collect();
        let orders = closed.into_iter().chain(open).collect();
        threads.publish(Update { now_secs, orders, vehicles, figures, done });
    }

    /// Whether there is a web API.
    pub fn is_served(&self) -> bool {
        self.threads.as_ref().is_some_and(Threads::wants_figures)
    }

    /// The address of the web API, with the actual port.
    pub fn http_address(&self) -> Option<std::net::SocketAddr> {
        self.threads.as_ref()?.address()
    }

    /// Waits until all published changes are in the store, and returns whether they are: not if the
    /// disk is full, or takes seconds. A process that is killed loses the changes that aren't in the
    /// store, so a manager settles them before it tells others of them.
    pub fn settle(&self) -> bool {
        self.threads.as_ref().is_none_or(Threads::settle)
    }

    /// Returns the order that a robot has, if it is in a state.
    fn order_in(&self, robot: u32, state: State) -> Option<OrderId> {
        self.order_of(robot).filter(|id| self.order(*id).is_some_and(|order| order.state == state))
    }

    /// Writes a change into the history of an open order and into the events.
    fn note(&mut self, id: OrderId, secs: f64, change: Change) {
        if let Some(order) = self.open.get_mut(&id) {
            order.history.push(HistoryEntry { secs, change: change.clone() });
        }
        self.changed.insert(id);
        self.events.push(OrderEvent { secs, id, change });
    }

    /// Closes an order.
    fn close(&mut self, id: OrderId, state: State, now_secs: f64, change: Change) {
        let Some(order) = self.open.get_mut(&id) else { return };
        if let Some(robot) = order.state.robot() {
            self.by_robot.remove(&robot);
        }
        let was_unroutable = order.state == State::Unroutable;
        order.state = state;
        if let Change::Failed { reason, .. } | Change::Cancelled { reason, .. } = &change {
            order.reason.clone_from(reason);
        }
        self.note(id, now_secs, change);
        let Some(order) = self.open.remove(&id) else { return };
        self.waiting.remove(&id);
        self.early.remove(&(order.content.earliest_secs.to_bits(), id));
        self.names.remove(&order.content.name);
        if let Some(source) = self.source_of(id) {
            source.open -= 1;
            source.unroutable -= usize::from(was_unroutable);
            self.made_by.remove(&id);
        }
        if let Some(robot) = order.content.intended_robot {
            self.intended.remove(&(robot, id));
        }
        self.release_places(&order);
        self.changed.remove(&id);
        self.counts.closed(&order, now_secs);
        if self.threads.is_some() {
            self.closed.push(Arc::new(order));
        }
    }
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod type_tests;
