//! The figures of a run of a master.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::outcome::Service;
use crate::statistics::{percentile, warm_up};

/// The length of the periods in which finished transports are counted, in seconds.
const PERIOD_SECS: f64 = 10.0;
/// The longest standing that counts as traffic, in seconds; in short runs, half of the run.
const STUCK_SECS: f64 = 60.0;

/// The traffic on the broker in a run. Times are seconds from the master's first order on.
#[derive(Clone, Debug, Default)]
pub struct RawFigures {
    /// The length of the run.
    pub secs: f64,
    /// The messages with orders and updates.
    pub orders: u64,
    /// The vehicles that never got an order.
    pub never_ordered: u64,
    /// The bases that vehicles asked for.
    pub bases: Vec<Base>,
    /// The transports from a pick to a drop, in the order of their ends.
    pub transports: Vec<Transport>,
    /// The transport orders that were handed over, and not finished.
    pub open_orders: u64,
    /// Seconds from the end of a vehicle's order to its next one.
    pub idle_secs: Vec<f64>,
    /// The errors that vehicles told, by type.
    pub errors: BTreeMap<String, u64>,
    /// The breaches of the standard.
    pub breaches: Vec<Breach>,
    /// Contacts of vehicles.
    pub contacts: u64,
    /// The first of them, in words.
    pub first_contact: Option<String>,
}

/// A base that a vehicle asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Base {
    /// The serial number of the vehicle.
    pub vehicle: String,
    /// The last node of the base that it had.
    pub node: String,
    /// The node that it wanted to drive to.
    pub next_node: Option<String>,
    /// The edges before and after the node, by their ids in the layout.
    pub edges: [Option<u32>; 2],
    /// Seconds until the base came, or until the end of the run.
    pub secs: f64,
    /// Seconds of them in which the vehicle stood.
    pub standing_secs: f64,
    /// Whether all of its nodes were free all the time, so that the time is the master's own.
    pub is_of_master: bool,
    /// Whether it hasn't come.
    pub is_missing: bool,
}

/// A transport that was carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transport {
    /// The time of the drop.
    pub at_secs: f64,
    /// Seconds from the hand-over of its transport order; `None` if the master made it up.
    pub service_secs: Option<f64>,
}

/// The breaches of a rule of the standard.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Breach {
    /// The id of the rule.
    pub rule: String,
    /// The requirement, in words.
    pub requirement: String,
    /// The side: `master` or `vehicle`.
    pub side: String,
    /// `error` or `warning`.
    pub severity: String,
    /// The clause of the standard.
    pub clause: String,
    /// Their number.
    pub count: u64,
    /// The first one.
    pub example: String,
}

/// The rule about bases that meet head-on.
const HEAD_ON: &str = "head-on";

/// Statistics of some times, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Times {
    /// The number of times.
    pub count: usize,
    /// The 50th percentile.
    pub p50_secs: f64,
    /// The 99th percentile.
    pub p99_secs: f64,
}

/// A place where vehicles stood and waited for their next base.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Wait {
    /// Seconds of standing, of all vehicles together.
    pub standing_secs: f64,
    /// Bases that vehicles asked for there, and that the master was free to send.
    pub bases: u64,
    /// Those of them that were late.
    pub late: u64,
    /// The longest time of them, in seconds.
    pub longest_secs: f64,
}

/// A vehicle that stood at the end of the run, and waited for its next base.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stuck {
    /// Its serial number.
    pub vehicle: String,
    /// The node where it stood.
    pub node: String,
    /// The node that it wanted to drive to.
    pub next_node: Option<String>,
    /// The time for which it stood, in seconds.
    pub secs: f64,
}

/// The figures of a run, without its warm-up where that matters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MasterRun {
    /// The number of vehicles.
    pub vehicles: u32,
    /// The number of the run among those of the same number of vehicles, from 1; also its seed.
    pub repeat: u64,
    /// The length of the run, in seconds.
    pub secs: f64,
    /// Seconds at its beginning that the throughput is without.
    pub warm_up_secs: f64,
    /// Finished transports an hour, after the warm-up.
    pub orders_per_hour: f64,
    /// Finished transports of the whole run.
    pub finished_orders: u64,
    /// Transport orders that were handed over, and not finished.
    pub open_orders: u64,
    /// Times from the hand-over of transport orders to their ends.
    pub service: Option<Service>,
    /// Messages with orders and updates.
    pub order_messages: u64,
    /// Times from the state that asks for a base to the base, where the master was free to send it.
    pub response: Option<Times>,
    /// The same times of all bases that came, those included that waited for other vehicles.
    pub bases: Option<Times>,
    /// Bases that the master was free to send, and that were late or haven't come.
    pub late: u64,
    /// The part of the vehicles' time in which they stood and waited for a base.
    pub waiting: f64,
    /// The waiting by the last node of the base.
    pub places: BTreeMap<String, Wait>,
    /// Seconds of standing by the edge, by id, that vehicles stood on, and by the one that they
    /// were kept out of.
    pub edges: BTreeMap<u32, [f64; 2]>,
    /// Times from the end of a vehicle's order to its next one.
    pub idle: Option<Times>,
    /// Vehicles that stood at the end, and didn't get a base for long.
    pub stuck: Vec<Stuck>,
    /// Vehicles that never got an order.
    pub never_ordered: u64,
    /// Errors that vehicles told, by type.
    pub errors: BTreeMap<String, u64>,
    /// Breaches of the standard.
    pub breaches: Vec<Breach>,
    /// Contacts of vehicles.
    pub contacts: u64,
    /// The first of them, in words.
    pub first_contact: Option<String>,
}

impl Times {
    fn of(secs: &[f64]) -> Option<Self> {
        let (p50_secs, p99_secs) = (percentile(secs, 50)?, percentile(secs, 99)?);
        Some(Self { count: secs.len(), p50_secs, p99_secs })
    }
}

impl MasterRun {
    /// Returns the figures of a run of so many vehicles. Bases of the master's own time are late
    /// after `late_secs`.
    pub fn new(vehicles: u32, repeat: u64, raw: RawFigures, late_secs: f64) -> Self {
        let of_master =
            |base: &&Base| base.is_of_master && (!base.is_missing || base.secs > late_secs);
        let own: Vec<f64> = raw.bases.iter().filter(of_master).map(|base| base.secs).collect();
        let came = raw.bases.iter().filter(|base| !base.is_missing).map(|base| base.secs);
        let standing: f64 = raw.bases.iter().map(|base| base.standing_secs).sum();
        let warm_up_secs = warm_up_of(&raw);
        let after = raw.transports.iter().filter(|transport| transport.at_secs > warm_up_secs);
        let hours = (raw.secs - warm_up_secs) / 3600.0;
        let service = after.clone().filter_map(|transport| transport.service_secs);
        Self {
            vehicles,
            repeat,
            secs: raw.secs,
            warm_up_secs,
            orders_per_hour: after.clone().count() as f64 / hours.max(f64::MIN_POSITIVE),
            finished_orders: raw.transports.len() as u64,
            open_orders: raw.open_orders,
            service: Service::of(&service.collect::<Vec<_>>()),
            order_messages: raw.orders,
            response: Times::of(&own),
            bases: Times::of(&came.collect::<Vec<_>>()),
            late: own.iter().filter(|secs| **secs > late_secs).count() as u64,
            waiting: standing / (raw.secs * f64::from(vehicles)).max(f64::MIN_POSITIVE),
            places: places(&raw.bases, late_secs),
            edges: edges(&raw.bases),
            idle: Times::of(&raw.idle_secs),
            stuck: stuck(&raw),
            never_ordered: raw.never_ordered,
            errors: raw.errors,
            breaches: raw.breaches,
            contacts: raw.contacts,
            first_contact: raw.first_contact,
        }
    }

    /// The bases that met head-on.
    pub fn head_on(&self) -> Option<&Breach> {
        self.breaches.iter().find(|breach| breach.rule == HEAD_ON)
    }
}

/// The time at the beginning that throughput is without (MSER-5).
fn warm_up_of(raw: &RawFigures) -> f64 {
    let mut series = vec![0.0; (raw.secs / PERIOD_SECS) as usize];
    for transport in &raw.transports {
        if let Some(count) = series.get_mut((transport.at_secs / PERIOD_SECS) as usize) {
            *count += 1.0;
        }
    }
    warm_up(&series) as f64 * PERIOD_SECS
}

fn places(bases: &[Base], late_secs: f64) -> BTreeMap<String, Wait> {
    let mut places: BTreeMap<String, Wait> = BTreeMap::new();
    for base in bases {
        let place = places.entry(base.node.clone()).or_default();
        place.standing_secs += base.standing_secs;
        if base.is_of_master {
            place.bases += 1;
            place.late += u64::from(base.secs > late_secs);
            place.longest_secs = place.longest_secs.max(base.secs);
        }
    }
    places
}

fn edges(bases: &[Base]) -> BTreeMap<u32, [f64; 2]> {
    let mut edges: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
    for base in bases {
        for (side, edge) in base.edges.iter().enumerate() {
            if let Some(edge) = edge {
                edges.entry(*edge).or_default()[side] += base.standing_secs;
            }
        }
    }
    edges
}

fn stuck(raw: &RawFigures) -> Vec<Stuck> {
    let least = STUCK_SECS.min(raw.secs / 2.0);
    let missing = raw.bases.iter().filter(|base| base.is_missing && base.standing_secs > least);
    let mut stuck: Vec<Stuck> = missing
        .map(|base| Stuck {
            vehicle: base.vehicle.clone(),
            node: base.node.clone(),
            next_node: base.next_node.clone(),
            secs: base.standing_secs,
        })
        .collect();
    stuck.sort_by(|one, other| other.secs.total_cmp(&one.secs));
    stuck
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base(node: &str, secs: f64, is_of_master: bool) -> Base {
        Base {
            vehicle: "0".to_owned(),
            node: node.to_owned(),
            next_node: None,
            edges: [Some(1), None],
            secs,
            standing_secs: secs,
            is_of_master,
            is_missing: false,
        }
    }

    #[test]
    fn only_the_masters_own_time_is_late() {
        let missing = Base { is_missing: true, ..base("C", 70.0, true) };
        let short = Base { is_missing: true, ..base("C", 0.5, true) };
        let bases = vec![
            base("A", 0.1, true),
            base("B", 3.0, true),
            base("B", 50.0, false),
            missing,
            short,
        ];
        let raw = RawFigures { secs: 100.0, bases, ..RawFigures::default() };
        let run = MasterRun::new(2, 1, raw, 1.0);
        assert_eq!(run.response.map(|times| (times.count, times.p99_secs)), Some((3, 70.0)));
        assert_eq!((run.late, run.bases.map(|times| times.count)), (2, Some(3)));
        assert_eq!((run.places["B"].bases, run.places["B"].late), (1, 1));
        assert_eq!(run.stuck.iter().map(|stuck| stuck.secs).collect::<Vec<_>>(), [70.0]);
        assert!((run.waiting - 123.6 / 200.0).abs() < 1e-9, "{}", run.waiting);
    }

    #[test]
    fn throughput_is_that_after_the_warm_up() {
        let transports = (50..200).map(|secs| Transport {
            at_secs: f64::from(secs),
            service_secs: Some(f64::from(secs)),
        });
        let transports = transports.collect();
        let raw = RawFigures { secs: 200.0, transports, ..RawFigures::default() };
        let run = MasterRun::new(1, 1, raw, 1.0);
        assert_eq!((run.warm_up_secs, run.finished_orders), (50.0, 150));
        assert!((run.orders_per_hour - 3600.0).abs() < 30.0, "{}", run.orders_per_hour);
    }
}
