//! The time of orders and robots, by what it is spent on.

use std::collections::BTreeMap;

use regatta_meter::Figures;
use regatta_meter::meter::Effort;
use regatta_meter::orders::Finished;
use regatta_meter::time::PARTS;

use super::Outcome;
use super::backlog::{HOUR_SECS, created_secs};

/// The part of an order's time in which a storage has no place for it.
pub const STORAGE: &str = "waiting for a storage place";
/// The parts of an order's time from its creation to its end, which add up to it, by their names in
/// `study.json`; the page has the words of activities.
pub const ORDER_PARTS: [&str; PARTS] = [
    "waiting for a robot",
    "way empty",
    "way loaded",
    "waiting in traffic",
    "waiting at a station",
    "handling",
    "out of service",
    STORAGE,
];
/// The part of a robot's time in which it charges, or drives to a charger.
pub const CHARGING: &str = "charging";
/// The parts of a robot's time, which add up to it, by their names in `study.json`.
pub const ROBOT_PARTS: [&str; 9] = [
    "way empty",
    "way loaded",
    "waiting in traffic",
    "waiting at a station",
    "handling",
    CHARGING,
    "parked",
    "out of service",
    "idle",
];

/// The time of some orders.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OrderTime {
    /// The number of orders.
    pub orders: f64,
    /// The sums of [`ORDER_PARTS`], in seconds.
    pub parts_secs: [f64; ORDER_PARTS.len()],
}

impl OrderTime {
    fn add(&mut self, order: &Finished, tick_secs: f64) {
        self.orders += 1.0;
        for (sum, ticks) in self.parts_secs.iter_mut().zip(<[u64; PARTS]>::from(order.parts)) {
            *sum += ticks as f64 * tick_secs;
        }
    }

    /// Returns the mean parts of an order, in seconds; `None` without orders.
    pub fn means(&self) -> Option<[f64; ORDER_PARTS.len()]> {
        (self.orders > 0.0).then(|| self.parts_secs.map(|secs| secs / self.orders))
    }
}

/// The groups of orders whose times are added up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grouping {
    /// By the first stop.
    Station,
    /// By the first and the last stop.
    Relation,
    /// By the hour of creation, from the beginning of the run on.
    Hour,
}

/// A group of orders: the ids of nodes, or an hour.
pub type Group = Vec<u32>;

impl Grouping {
    fn of(self, order: &Finished, tick_secs: f64) -> Group {
        match self {
            Self::Station => vec![order.ends[0]],
            Self::Relation => order.ends.to_vec(),
            Self::Hour => vec![(created_secs(order, tick_secs) / HOUR_SECS) as u32],
        }
    }
}

/// Adds up the time of the orders of some runs by group.
pub fn by_group(outcomes: &[Outcome], grouping: Grouping) -> BTreeMap<Group, OrderTime> {
    let mut groups: BTreeMap<Group, OrderTime> = BTreeMap::new();
    for Figures { finished, tick_secs, .. } in outcomes.iter().map(|outcome| &outcome.figures) {
        for order in finished {
            groups.entry(grouping.of(order, *tick_secs)).or_default().add(order, *tick_secs);
        }
    }
    groups
}

/// Returns the mean parts of an order's time; `None` without orders, or if the result is of a
/// version that didn't measure them.
pub fn of_orders<'a>(
    orders: impl IntoIterator<Item = &'a Finished>,
    tick_secs: f64,
) -> Option<[f64; ORDER_PARTS.len()]> {
    let mut time = OrderTime::default();
    for order in orders {
        time.add(order, tick_secs);
    }
    time.means().filter(|_| tick_secs > 0.0)
}

/// Returns the parts of the robots' time, each from 0 to 1; `None` without robots.
pub fn of_robots(effort: &Effort) -> Option<[f64; ROBOT_PARTS.len()]> {
    let parts = [
        effort.empty_secs,
        effort.loaded_secs,
        effort.waiting_secs,
        effort.station_secs,
        effort.handling_secs,
        effort.charging_secs,
        effort.parked_secs,
        effort.down_secs,
        effort.idle_secs,
    ];
    (effort.robot_secs > 0.0).then(|| parts.map(|secs| secs / effort.robot_secs))
}
