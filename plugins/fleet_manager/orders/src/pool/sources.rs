//! The sources of orders: files, generators, and the store after a restart.

use std::collections::BTreeSet;

use regatta_base::yaml;

use super::storing::at_first_places;
use super::{Change, Held, HistoryEntry, NewOrder, Order, OrderId, OrderPool, State};
use crate::file::TimedDraft;
use crate::generator::{Generator, IsFeasible};
use crate::load::Load;
use crate::stations::Stations;
use crate::timetable::check_orders;

/// The largest number of unroutable orders that an endless load replaces, for each robot.
const MOST_LOST: usize = 10;

/// The names that a store knows already, and the number of the present run.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    pub(crate) names: BTreeSet<String>,
    pub(crate) run: u64,
}

/// The content of a store for a run.
#[derive(Debug)]
pub(crate) struct Restored {
    /// All open orders, in the order in which they came.
    pub(crate) orders: Vec<Order>,
    pub(crate) next_id: u64,
    pub(crate) known: Known,
    /// Open orders whose nodes the world doesn't have; they stay in the store.
    pub(crate) unplaced: usize,
}

/// The nodes of the stops of a load.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadStops {
    /// All of them.
    pub all: BTreeSet<u32>,
    /// Those at which orders end.
    pub last: BTreeSet<u32>,
}

/// A generator, and its open orders.
#[derive(Debug)]
pub(super) struct Source {
    generator: Generator,
    /// The number of its open orders.
    pub(super) open: usize,
    /// The number of those that no robot can carry out.
    pub(super) unroutable: usize,
}

impl OrderPool {
    /// Adds the orders of a file. Those without a name get one of their line.
    ///
    /// # Errors
    /// [`yaml::Error`] if an order is wrong, or two have the same name.
    pub fn add_orders(&mut self, orders: &[TimedDraft]) -> Result<(), yaml::Error> {
        self.add_new_orders(orders, &Known::default())
    }

    /// Adds the orders of a file that the store doesn't know.
    pub(crate) fn add_new_orders(
        &mut self,
        orders: &[TimedDraft],
        known: &Known,
    ) -> Result<(), yaml::Error> {
        self.schedule(check_orders(orders, &self.places)?, known);
        Ok(())
    }

    /// Adds orders with their times, except those that the store knows.
    fn schedule(&mut self, mut orders: Vec<(f64, NewOrder)>, known: &Known) {
        orders.retain(|(_, order)| !known.names.contains(order.name.as_str()));
        self.timetable.extend(orders);
        // Stable: orders of the same time stay in the order of the file.
        self.timetable.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.timetable.reverse();
    }

    /// Adds the generators of a load.
    pub fn add_load(&mut self, load: &Load) {
        self.set_storages(load);
        self.continue_load(load, &Known::default());
    }

    /// Adds the generators of a load, which continue after the orders that the store knows.
    pub(crate) fn continue_load(&mut self, load: &Load, known: &Known) {
        for (settings, number) in load.generators.iter().zip(1..) {
            let mut generator = Generator::new(settings.clone(), load.seed, number, known.run);
            let numbers = known.names.iter().filter_map(|name| generator.number_of(name));
            let made = numbers.max().unwrap_or(0);
            generator.skip(made);
            self.sources.push(Source { generator, open: 0, unroutable: 0 });
        }
        self.stations = Stations::new(&load.stations, load.seed);
        for timetable in &load.timetables {
            self.schedule(timetable.orders(load.seed), known);
        }
    }

    /// Returns a pool with the same generators, without a store and without clients. Rehearsals
    /// with other numbers than 0 have other orders of the same kinds. If there is no generator, each
    /// robot has an order at any time: to the stops of the known orders, or else to the nodes with
    /// a role to pick or drop, or else to any nodes.
    #[must_use]
    pub fn for_rehearsal(&self, number: u64) -> Self {
        let mut pool = Self::new(self.places.clone());
        pool.stations = self.stations.unused();
        pool.storages = self.storages.unused();
        for source in &self.sources {
            let generator = source.generator.with_other_orders(number);
            pool.sources.push(Source { generator, open: 0, unroutable: 0 });
        }
        if pool.sources.is_empty() {
            let generator = Generator::endless(self.likely_stops(), number);
            pool.sources.push(Source { generator, open: 0, unroutable: 0 });
        }
        pool
    }

    /// The nodes of stations with a queue before them, and the nodes of each queue, the nearest
    /// first.
    pub fn queues(&self) -> impl Iterator<Item = (u32, &[u32])> {
        self.stations.queues()
    }

    /// The nodes where the generators and the scheduled orders have stops, and where orders end.
    pub fn load_stops(&self) -> LoadStops {
        let mut stops = LoadStops::default();
        for source in &self.sources {
            let (all, last) = source.generator.stops();
            stops.all.extend(all);
            stops.last.extend(last);
        }
        for (_, order) in &self.timetable {
            stops.all.extend(order.stops.iter().map(|stop| stop.node));
            stops.last.extend(order.stops.last().map(|stop| stop.node));
        }
        LoadStops { all: self.at_nodes(stops.all), last: self.at_nodes(stops.last) }
    }

    /// Returns nodes with all places of a storage in its stead.
    fn at_nodes(&self, nodes: BTreeSet<u32>) -> BTreeSet<u32> {
        nodes.into_iter().flat_map(|node| self.places.nodes_at(node)).collect()
    }

    fn likely_stops(&self) -> Vec<u32> {
        let open = self.open.values().map(|order| &order.content);
        let known = open.chain(self.timetable.iter().map(|(_, order)| order));
        let stops: BTreeSet<u32> =
            known.flat_map(|order| &order.stops).map(|stop| stop.node).collect();
        if !stops.is_empty() {
            return self.at_nodes(stops).into_iter().collect();
        }
        let transports = self.places.nodes(|place| place.role.is_pick() || place.role.is_drop());
        if transports.is_empty() { self.places.nodes(|_| true) } else { transports }
    }

    /// Whether a load is for some robot types: then [`set_fleet`](Self::set_fleet) is needed.
    pub fn has_loads_for_types(&self) -> bool {
        self.sources.iter().any(|source| !source.generator.robot_types().is_empty())
    }

    /// Notes the number of robots of each type, by the index of the world's robot types: endless
    /// loads for some types have as many open orders as there are robots of them.
    pub fn set_fleet(&mut self, robots_by_type: Vec<usize>) {
        self.fleet = robots_by_type;
    }

    /// Makes all orders whose time has come. `robots` is the number of robots that may get orders:
    /// endless loads have as many open ones.
    pub fn generate_until(&mut self, now_secs: f64, robots: usize) {
        self.generate_feasible_until(now_secs, robots, &|_| true);
    }

    /// Makes all orders whose time has come, as [`generate_until`](Self::generate_until), but of
    /// endless loads only those that a robot can carry out now: they keep robots busy, and have
    /// no orders that wait for roads to be opened. Orders of files and of loads with a rate come
    /// in any case.
    pub fn generate_feasible_until(
        &mut self,
        now_secs: f64,
        robots: usize,
        is_feasible: IsFeasible<'_>,
    ) {
        self.opened_secs.get_or_insert(now_secs);
        let mut arrivals = Vec::new();
        while self.timetable.last().is_some_and(|(secs, _)| *secs <= now_secs) {
            arrivals.extend(self.timetable.pop().map(|(secs, order)| (secs, None, order)));
        }
        for (index, source) in self.sources.iter_mut().enumerate() {
            let Source { generator, open, unroutable } = source;
            let robots = robots_of(&self.fleet, generator.robot_types()).unwrap_or(robots);
            // Unroutable orders don't keep robots busy, but their number is bounded.
            let mut open = *open - (*unroutable).min(MOST_LOST * robots);
            let places = &self.places;
            while let Some((secs, order)) = generator
                .next(now_secs, robots, open, &|order| is_feasible(&at_first_places(order, places)))
            {
                arrivals.push((secs, Some(index), order));
                open += 1;
            }
        }
        arrivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (secs, maker, order) in arrivals {
            let id = self.create(secs, now_secs, order);
            if let (Some(maker), Some(id)) = (maker, id) {
                self.made_by.insert(id, maker);
                self.sources[maker].open += 1;
            }
        }
        self.start_early(now_secs);
        self.place_orders(now_secs);
    }

    /// The source of an open order that a generator made.
    pub(super) fn source_of(&mut self, id: OrderId) -> Option<&mut Source> {
        self.sources.get_mut(*self.made_by.get(&id)?)
    }

    /// Lets orders wait for a robot whose earliest start has come.
    fn start_early(&mut self, now_secs: f64) {
        while let Some(&(bits, id)) =
            self.early.first().filter(|(bits, _)| f64::from_bits(*bits) <= now_secs)
        {
            self.early.remove(&(bits, id));
            if let Some(mut order) = self.open.remove(&id) {
                self.make_ready(&mut order);
                self.open.insert(id, order);
                self.changed.insert(id);
            }
        }
    }

    /// Opens a new order. Returns `None` if there is an open one with its name.
    pub(super) fn create(
        &mut self,
        created_secs: f64,
        now_secs: f64,
        content: NewOrder,
    ) -> Option<OrderId> {
        if self.names.contains_key(&content.name) {
            return None;
        }
        let id = OrderId(self.next_id);
        self.next_id += 1;
        let created = Change::Created {
            priority: content.priority,
            stops: content.stops.len() as u32,
            due_secs: content.deadline_secs.map(|deadline| deadline - now_secs),
        };
        let has_places = !self.needs_place(&content);
        self.admit(Order::new(id, content, created_secs), now_secs);
        self.note(id, created_secs, created);
        if has_places {
            self.tell_stops(id, now_secs);
        }
        Some(id)
    }

    /// Puts an order without a robot among the open ones: it waits, or is too early.
    fn admit(&mut self, mut order: Order, now_secs: f64) {
        let id = order.id;
        if order.content.earliest_secs > now_secs {
            order.state = State::Created;
            self.early.insert((order.content.earliest_secs.to_bits(), id));
        } else {
            self.make_ready(&mut order);
        }
        self.intended.extend(order.content.intended_robot.map(|robot| (robot, id)));
        self.names.insert(order.content.name.clone(), id);
        self.open.insert(id, order);
    }

    /// Continues with the open orders of a store. An order that a robot has begun stays with it.
    /// All other orders wait.
    pub(crate) fn restore(&mut self, orders: Vec<Order>, next_id: u64, now_secs: f64) {
        self.next_id = self.next_id.max(next_id);
        for mut order in orders {
            let id = order.id;
            match order
                .state
                .robot()
                .filter(|robot| order.is_bound() && !self.by_robot.contains_key(robot))
            {
                Some(robot) => {
                    order.state = State::Travelling(robot);
                    self.by_robot.insert(robot, Held { id, is_bound: true });
                    self.intended.extend(order.content.intended_robot.map(|robot| (robot, id)));
                    self.names.insert(order.content.name.clone(), id);
                    self.open.insert(id, order);
                }
                None => self.restore_waiting(order, now_secs),
            }
            self.changed.insert(id);
        }
    }

    fn restore_waiting(&mut self, mut order: Order, now_secs: f64) {
        let id = order.id;
        let robot = order.state.robot();
        if order.history.is_empty() {
            let stops = order.content.stops.len() as u32;
            let priority = order.content.priority;
            let change = Change::Created { priority, stops, due_secs: None };
            order.history.push(HistoryEntry { secs: order.created_secs, change });
        }
        order.handled_stops = 0;
        order.reason.clear();
        self.admit(order, now_secs);
        if let Some(robot) = robot {
            self.note(id, now_secs, Change::Withdrawn { robot });
        }
    }
}

/// Returns the number of robots of some types; `None` for orders that any robot may get, or if the
/// fleet isn't known.
fn robots_of(fleet: &[usize], types: &[u32]) -> Option<usize> {
    if fleet.is_empty() || types.is_empty() {
        return None;
    }
    Some(types.iter().filter_map(|index| fleet.get(*index as usize)).sum())
}
