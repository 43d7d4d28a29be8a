//! Where orders come from: files, generators, and the store after a restart.

use super::{Change, Generator, HistoryEntry, NewOrder, Order, State, TaskBook, TaskId};
use crate::tasks::draft::DraftError;
use crate::tasks::file::TimedDraft;
use crate::tasks::load::Load;
use crate::tasks::order::{NameError, OrderName};
use crate::tasks::yaml::InputError;

/// The names that a store knows already, and in which of its runs we are.
#[derive(Clone, Debug, Default)]
pub(in crate::tasks) struct Known {
    pub(in crate::tasks) names: std::collections::BTreeSet<String>,
    pub(in crate::tasks) run: u64,
}

/// How many orders that can't be carried out an endless load replaces by others, for each robot.
const MOST_LOST: usize = 10;

impl TaskBook {
    /// Adds the orders of a file. Those without a name get one of their line.
    ///
    /// # Errors
    /// [`InputError`] if an order is wrong, or two have the same name.
    pub fn add_orders(&mut self, orders: &[TimedDraft]) -> Result<(), InputError> {
        self.add_new_orders(orders, &Known::default())
    }

    /// Adds the orders of a file that the store doesn't know.
    pub(in crate::tasks) fn add_new_orders(
        &mut self,
        orders: &[TimedDraft],
        known: &Known,
    ) -> Result<(), InputError> {
        let mut names = std::collections::BTreeSet::new();
        for TimedDraft { line, secs, draft } in orders {
            let error = |reason: String| InputError { line: *line, reason };
            let order =
                self.file_order(*line, draft).map_err(|reason| error(reason.to_string()))?;
            if !names.insert(order.name.clone()) {
                return Err(error(format!("there are two orders `{}`", order.name)));
            }
            if !known.names.contains(order.name.as_str()) {
                self.timetable.push((*secs, order));
            }
        }
        // Stable: orders of the same time stay in the order of the file.
        self.timetable.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.timetable.reverse();
        Ok(())
    }

    fn file_order(
        &self,
        line: usize,
        draft: &crate::tasks::OrderDraft,
    ) -> Result<NewOrder, DraftError> {
        let mut draft = draft.clone();
        let name = draft.name.take().unwrap_or_else(|| format!("line-{line}"));
        let name = OrderName::parse(&name).map_err(|error: NameError| DraftError::Name(error))?;
        draft.check(&self.places, || name)
    }

    /// Adds the generators of a load.
    pub fn add_load(&mut self, load: &Load) {
        self.continue_load(load, &Known::default());
    }

    /// Adds the generators of a load, which continue after the orders that the store knows.
    pub(in crate::tasks) fn continue_load(&mut self, load: &Load, known: &Known) {
        for (settings, number) in load.generators.iter().zip(1..) {
            let mut generator = Generator::new(settings.clone(), load.seed, number, known.run);
            let numbers = known.names.iter().filter_map(|name| generator.number_of(name));
            let made = numbers.max().unwrap_or(0);
            generator.skip(made);
            self.generators.push(generator);
        }
    }

    /// Makes all orders whose time has come. `robots` is the number of robots that may get orders:
    /// endless loads have as many open ones.
    pub fn generate_until(&mut self, now_secs: f64, robots: usize) {
        self.opened_secs.get_or_insert(now_secs);
        let mut arrivals = Vec::new();
        while self.timetable.last().is_some_and(|(secs, _)| *secs <= now_secs) {
            arrivals.extend(self.timetable.pop().map(|(secs, order)| (secs, None, order)));
        }
        for (index, generator) in self.generators.iter_mut().enumerate() {
            // Orders that can't be carried out now don't keep robots busy; but they must not become
            // ever more.
            let is_lost = |task| {
                self.open.get(task).is_some_and(|order: &Order| order.state == State::Unroutable)
            };
            let made = || self.made_by.iter().filter(|(_, maker)| **maker == index);
            let lost = made().filter(|(task, _)| is_lost(*task)).count();
            let mut open = made().count() - lost.min(MOST_LOST * robots);
            while let Some((secs, order)) = generator.next(now_secs, robots, open) {
                arrivals.push((secs, Some(index), order));
                open += 1;
            }
        }
        arrivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (secs, maker, order) in arrivals {
            let task = self.create(secs, now_secs, order);
            self.made_by.extend(maker.zip(task).map(|(maker, task)| (task, maker)));
        }
        self.start_early(now_secs);
    }

    /// Lets orders wait for a robot whose earliest start has come.
    fn start_early(&mut self, now_secs: f64) {
        while let Some(&(bits, task)) =
            self.early.first().filter(|(bits, _)| f64::from_bits(*bits) <= now_secs)
        {
            self.early.remove(&(bits, task));
            if let Some(order) = self.open.get_mut(&task) {
                order.state = State::Waiting;
                self.waiting.insert(task);
                self.changed.insert(task);
            }
        }
    }

    /// Opens a new order. Returns `None` if there is an open one with its name.
    pub(super) fn create(
        &mut self,
        created_secs: f64,
        now_secs: f64,
        content: NewOrder,
    ) -> Option<TaskId> {
        if self.names.contains_key(&content.name) {
            return None;
        }
        let task = TaskId(self.next_id);
        self.next_id += 1;
        let created =
            Change::Created { priority: content.priority, stops: content.stops.len() as u32 };
        let stops = content.stops.clone();
        let order = Order {
            id: task,
            content,
            created_secs,
            state: State::Waiting,
            next_stop: 0,
            reason: String::new(),
            history: Vec::new(),
        };
        self.admit(order, now_secs);
        self.note(task, created_secs, created);
        self.events.extend(stops.iter().zip(0..).map(|(stop, index)| super::TaskEvent {
            secs: now_secs,
            task,
            change: Change::Stop {
                stop: index,
                node: stop.node,
                action: stop.action,
                dwell_secs: stop.dwell_secs,
            },
        }));
        Some(task)
    }

    /// Puts an order without a robot among the open ones: it waits, or is too early.
    fn admit(&mut self, mut order: Order, now_secs: f64) {
        let task = order.id;
        if order.content.earliest_secs > now_secs {
            order.state = State::Created;
            self.early.insert((order.content.earliest_secs.to_bits(), task));
        } else {
            order.state = State::Waiting;
            self.waiting.insert(task);
        }
        self.intended.extend(order.content.intended_robot.map(|robot| (robot, task)));
        self.names.insert(order.content.name.clone(), task);
        self.open.insert(task, order);
    }

    /// Continues with the open orders of a store: those that a robot has begun stay with it, and
    /// all others wait.
    pub(in crate::tasks) fn restore(&mut self, orders: Vec<Order>, next_id: u64, now_secs: f64) {
        self.next_id = self.next_id.max(next_id);
        for mut order in orders {
            let task = order.id;
            match order
                .state
                .robot()
                .filter(|robot| order.is_bound() && !self.by_robot.contains_key(robot))
            {
                Some(robot) => {
                    order.state = State::Travelling(robot);
                    self.by_robot.insert(robot, task);
                    self.intended.extend(order.content.intended_robot.map(|robot| (robot, task)));
                    self.names.insert(order.content.name.clone(), task);
                    self.open.insert(task, order);
                }
                None => self.restore_waiting(order, now_secs),
            }
            self.changed.insert(task);
        }
    }

    fn restore_waiting(&mut self, mut order: Order, now_secs: f64) {
        let task = order.id;
        let robot = order.state.robot();
        if order.history.is_empty() {
            let stops = order.content.stops.len() as u32;
            let change = Change::Created { priority: order.content.priority, stops };
            order.history.push(HistoryEntry { secs: order.created_secs, change });
        }
        order.next_stop = 0;
        order.reason.clear();
        self.admit(order, now_secs);
        if let Some(robot) = robot {
            self.note(task, now_secs, Change::Withdrawn { robot });
        }
    }
}
