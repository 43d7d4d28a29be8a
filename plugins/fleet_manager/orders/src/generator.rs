//! Generators of orders. Their orders depend on the seed, the time and, for endless loads, on which
//! orders are feasible, not on the number of calls.

use regatta_base::random::Random;

use super::dwell::Dwell;
use super::load::{Arrival, Batch, GeneratorSettings, Shift, Stops, Transport};
use super::order::{Action, NewOrder, OrderName, Stop};

/// The random draws of an order, by purpose.
const ARRIVAL: u64 = 0;
const FROM: u64 = 1;
const TO: u64 = 2;
const PICK_DWELL: u64 = 3;
const DROP_DWELL: u64 = 4;
const VIA: u64 = 5;
const FLOW: u64 = 6;
const BATCH: u64 = 7;
/// The first of the draws that replace an infeasible order.
const REPLACEMENT: u64 = 8;

/// The largest number of orders that an endless load draws in one call in place of infeasible ones.
const MOST_REPLACEMENTS: u64 = 20;

/// Whether a robot can carry a new order out now.
pub type IsFeasible<'a> = &'a dyn Fn(&NewOrder) -> bool;

/// A generator and its progress.
#[derive(Clone, Debug)]
pub(super) struct Generator {
    settings: GeneratorSettings,
    random: Random,
    /// The number of orders that it has made.
    made: u64,
    /// The number of infeasible orders drawn in a row instead of the next one.
    replaced: u64,
    /// The next arrival: in seconds, or for a rate on a time axis on which one order comes per unit
    /// on average.
    next_arrival: f64,
    /// The orders of the next arrival that aren't made yet.
    left: u64,
    /// The number in the names of a store's runs.
    run: u64,
}

impl Generator {
    /// Makes a generator. `number` distinguishes the generators of a load.
    pub(super) fn new(settings: GeneratorSettings, seed: u64, number: u64, run: u64) -> Self {
        let random = Random::new(seed).part(number);
        let mut generator =
            Self { settings, random, made: 0, replaced: 0, next_arrival: 0.0, left: 0, run };
        generator.draw_arrival();
        generator
    }

    /// Makes a generator that keeps as many orders open as there are robots, each with one of some
    /// nodes as its stop.
    pub(super) fn endless(among: Vec<u32>, seed: u64) -> Self {
        let settings = GeneratorSettings {
            name: String::from("endless"),
            arrival: Arrival::Endless(None),
            batch: Batch::default(),
            stops: Stops::One(among),
            priority: 0,
            dwell: Dwell::default(),
            deadline_secs: None,
            robot_types: Vec::new(),
        };
        Self::new(settings, seed, 1, 0)
    }

    /// Returns a generator of the same kind of orders, with other random numbers; the same one for
    /// the number 0.
    pub(super) fn with_other_orders(&self, number: u64) -> Self {
        let random = if number == 0 { self.random } else { self.random.part(u64::MAX - number) };
        Self { random, ..self.clone() }
    }

    /// Returns the time and the next order that comes up to `now_secs`. An endless generator needs
    /// the number of robots, and of its orders that are open; it makes feasible orders only, or
    /// none for now.
    pub(super) fn next(
        &mut self,
        now_secs: f64,
        robots: usize,
        open: usize,
        is_feasible: IsFeasible<'_>,
    ) -> Option<(f64, NewOrder)> {
        let number = self.made + 1;
        let (secs, order) = match &self.settings.arrival {
            Arrival::Poisson(shifts) => {
                let secs = time_of(self.next_arrival, shifts).filter(|secs| *secs <= now_secs)?;
                (secs, self.order(self.random.part(number), secs))
            }
            Arrival::Gaps(_) if self.next_arrival <= now_secs => {
                let secs = self.next_arrival;
                (secs, self.order(self.random.part(number), secs))
            }
            Arrival::Gaps(_) => return None,
            Arrival::Endless(orders) if open < orders.unwrap_or(robots) => {
                (now_secs, self.draw_feasible(now_secs, is_feasible)?)
            }
            Arrival::Endless(_) => return None,
        };
        self.replaced = 0;
        self.go_on();
        Some((secs, order))
    }

    /// Counts an order as made.
    fn go_on(&mut self) {
        self.made += 1;
        self.left -= 1;
        if self.left == 0 {
            self.draw_arrival();
        }
    }

    /// Draws the time of the next arrival, and the number of its orders.
    fn draw_arrival(&mut self) {
        let random = self.random.part(self.made + 1);
        self.left = self.settings.batch.orders(random, BATCH);
        self.next_arrival += match &self.settings.arrival {
            Arrival::Gaps(gaps) => gaps.secs(random, ARRIVAL),
            _ => self.settings.batch.mean() * random.exponential(ARRIVAL),
        };
    }

    /// Draws the next order until it is feasible. Closed roads may leave few orders that are: the
    /// next call draws on.
    fn draw_feasible(&mut self, secs: f64, is_feasible: IsFeasible<'_>) -> Option<NewOrder> {
        for _ in 0..=MOST_REPLACEMENTS {
            let random = self.random.part(self.made + 1);
            let order = match self.replaced {
                0 => self.order(random, secs),
                replaced => self.order(random.part(REPLACEMENT + replaced), secs),
            };
            if is_feasible(&order) {
                return Some(order);
            }
            self.replaced += 1;
        }
        None
    }

    /// The nodes of all stops, and those at which orders end.
    pub(super) fn stops(&self) -> (Vec<u32>, Vec<u32>) {
        self.settings.stops.nodes()
    }

    /// The robot types that may get its orders; any may if empty.
    pub(super) fn robot_types(&self) -> &[u32] {
        &self.settings.robot_types
    }

    /// Returns the number of an order of this generator, of this run.
    pub(super) fn number_of(&self, name: &str) -> Option<u64> {
        let prefix = OrderName::generated(&self.settings.name, 0, self.run);
        name.strip_prefix(prefix.as_str().trim_end_matches('0'))?.parse().ok()
    }

    /// Continues after the orders that it has made before, of which there are `made`.
    pub(super) fn skip(&mut self, made: u64) {
        while self.made < made {
            self.go_on();
        }
    }

    /// Returns the next order by its random numbers alone.
    fn order(&self, random: Random, secs: f64) -> NewOrder {
        let stops = match &self.settings.stops {
            Stops::One(among) => {
                let node = among[random.below(FROM, among.len())];
                vec![self.stop(node, Action::None, random, PICK_DWELL)]
            }
            Stops::Transport(transport) => self.transport(transport, random),
        };
        NewOrder {
            name: OrderName::generated(&self.settings.name, self.made + 1, self.run),
            stops,
            priority: self.settings.priority,
            earliest_secs: secs,
            intended_robot: None,
            robot_types: self.settings.robot_types.clone(),
            deadline_secs: self.settings.deadline_secs.map(|deadline| secs + deadline),
        }
    }

    /// Returns a pick, the stops between, and a drop.
    fn transport(&self, transport: &Transport, random: Random) -> Vec<Stop> {
        let flow = transport.flow(random, FLOW);
        let first = flow.from[random.below(FROM, flow.from.len())];
        let mut stops = vec![self.stop(first, Action::Pick, random, PICK_DWELL)];
        for (group, number) in transport.via.iter().zip(0..) {
            let random = random.part(VIA).part(number);
            let node = group[random.below(FROM, group.len())];
            stops.push(self.stop(node, Action::None, random, PICK_DWELL));
        }
        let last = other(first, &flow.to, random);
        stops.push(self.stop(last, Action::Drop, random, DROP_DWELL));
        stops
    }

    fn stop(&self, node: u32, action: Action, random: Random, draw: u64) -> Stop {
        Stop { node, action, dwell_secs: self.settings.dwell.secs(node, action, random, draw) }
    }
}

/// Returns a random node of a group, but not `node` unless there is no other.
fn other(node: u32, group: &[u32], random: Random) -> u32 {
    let chosen = random.below(TO, group.len());
    let others = (0..group.len()).map(|offset| group[(chosen + offset) % group.len()]);
    others.into_iter().find(|candidate| *candidate != node).unwrap_or(node)
}

/// Returns the time at which the profile, which repeats, has generated this number of orders on
/// average; `None` if it generates none.
fn time_of(units: f64, shifts: &[Shift]) -> Option<f64> {
    let [Shift { until_secs: f64::INFINITY, per_hour }] = shifts else {
        return time_in_profile(units, shifts);
    };
    (*per_hour > 0.0).then(|| units * 3600.0 / per_hour)
}

fn time_in_profile(units: f64, shifts: &[Shift]) -> Option<f64> {
    let length = shifts.last()?.until_secs;
    let mut parts = Vec::with_capacity(shifts.len());
    let mut begin = 0.0;
    for shift in shifts {
        let amount = (shift.until_secs - begin) * shift.per_hour / 3600.0;
        parts.push((begin, amount, shift.per_hour));
        begin = shift.until_secs;
    }
    let cycle: f64 = parts.iter().map(|(_, amount, _)| amount).sum();
    if cycle <= 0.0 {
        return None;
    }
    let cycles = (units / cycle).floor();
    let mut rest = units - cycles * cycle;
    for (begin, amount, per_hour) in parts {
        if rest < amount {
            return Some(cycles * length + begin + rest * 3600.0 / per_hour);
        }
        rest -= amount;
    }
    // Rounding has left nothing for the last shift.
    Some((cycles + 1.0) * length)
}

#[cfg(test)]
mod tests;
