//! The outcome of a job, and the figures that a study takes from it.

mod example;
mod stall;

use std::collections::BTreeMap;

use regatta_meter::Figures;
use regatta_meter::meter::Effort;
use serde::{Deserialize, Serialize};

use crate::job::JobId;
use crate::statistics::{percentile, warm_up};

pub use example::{Example, examples};
pub use stall::{LastState, Stall, StallKind, stalls};

/// The result file of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The job.
    pub job: JobId,
    /// The engine's digest of all frames, 32 hexadecimal digits: equal wherever the job runs.
    pub digest: String,
    /// The meter's figures of the fleet.
    pub figures: Figures,
    /// The numbers of the validator's findings by kind; kinds without findings are left out.
    pub findings: BTreeMap<String, u64>,
    /// The first of them of each kind; none in a result of an earlier version.
    #[serde(default)]
    pub examples: BTreeMap<String, Example>,
    /// The times in which robots with orders made no progress.
    pub stalls: Vec<Stall>,
    /// The edges where robots waited.
    pub edges: Vec<EdgeOutcome>,
    /// The duration of the run on the machine where it ran, in seconds.
    pub wall_secs: f64,
}

/// An edge of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EdgeOutcome {
    /// The id in the layout.
    pub edge: u32,
    /// Robot seconds in which robots stood there and waited to drive on.
    pub waiting_secs: f64,
    /// Robot seconds in which robots waited, wherever they stood, because they or the robots before
    /// them were kept out of it.
    pub caused_secs: f64,
    /// Robots that entered it, an hour.
    pub entered_per_hour: f64,
}

impl EdgeOutcome {
    /// Returns an edge where no robot was.
    pub fn new(edge: u32) -> Self {
        Self { edge, waiting_secs: 0.0, caused_secs: 0.0, entered_per_hour: 0.0 }
    }
}

/// The figures of an observer by edges.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EdgeFigures<T> {
    /// The figures of each edge.
    pub edges: Vec<T>,
}

/// The traffic of an edge.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EdgeTraffic {
    /// The id in the layout.
    pub edge: u32,
    /// Robot seconds of waiting there.
    pub waiting_secs: f64,
    /// Robots that entered it, an hour.
    pub entered_per_hour: f64,
}

/// The waiting that an edge has caused.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EdgeQueues {
    /// The id in the layout.
    pub edge: u32,
    /// Robot seconds of waiting for it.
    pub caused_secs: f64,
}

/// Returns the edges on which robots were, or that they were kept out of, from the figures of the
/// observers.
pub fn edges(
    traffic: EdgeFigures<EdgeTraffic>,
    queues: EdgeFigures<EdgeQueues>,
) -> Vec<EdgeOutcome> {
    let caused: BTreeMap<u32, f64> =
        queues.edges.into_iter().map(|edge| (edge.edge, edge.caused_secs)).collect();
    let mut edges = Vec::new();
    for EdgeTraffic { edge, waiting_secs, entered_per_hour } in traffic.edges {
        let caused_secs = caused.get(&edge).copied().unwrap_or_default();
        if waiting_secs > 0.0 || caused_secs > 0.0 || entered_per_hour > 0.0 {
            edges.push(EdgeOutcome { edge, waiting_secs, caused_secs, entered_per_hour });
        }
    }
    edges
}

/// The figures of a run after its warm-up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// The engine's digest.
    pub digest: String,
    /// Simulated seconds that were cut off at the beginning (MSER-5).
    pub warm_up_secs: f64,
    /// Simulated seconds after that.
    pub secs: f64,
    /// Finished orders an hour.
    pub orders_per_hour: f64,
    /// Finished stops an hour.
    pub stops_per_hour: f64,
    /// The mean time from an order's creation to its end, in seconds; of orders that were finished
    /// after the warm-up.
    pub service_mean_secs: Option<f64>,
    /// The median of it.
    pub service_p50_secs: Option<f64>,
    /// The 99th percentile of it.
    pub service_p99_secs: Option<f64>,
    /// The part of the robots' time with an order, from 0 to 1.
    pub utilisation: f64,
    /// The part of the robots' time in which they stood and waited for room, from 0 to 1.
    pub waiting: f64,
    /// The part of the way that was driven without a load, from 0 to 1; `None` if no robot had one.
    pub empty: Option<f64>,
    /// Contacts that the validator found.
    pub contacts: u64,
    /// Times in which robots with orders made no progress.
    pub stalls: Vec<Stall>,
    /// Orders that waited for a long time, for a robot or with one.
    pub unserved: u64,
    /// The validator's other findings, by kind.
    pub other_findings: BTreeMap<String, u64>,
    /// The first finding of each kind.
    pub examples: BTreeMap<String, Example>,
    /// Orders that were finished in the whole run, the warm-up included.
    pub finished_orders: u64,
    /// Orders that the manager gave up.
    pub failed_orders: u64,
    /// Orders that weren't over at the end.
    pub open_orders: u64,
    /// The duration of the run, in seconds.
    pub wall_secs: f64,
}

/// The most periods of a run: those of a week, of a second each.
const MOST_PERIODS: f64 = 604_800.0;
/// The validator's name for a contact.
pub(crate) const CONTACT: &str = "contact";
/// Its name for an order that waited for a long time.
const UNSERVED: &str = "unserved";
/// Its names for findings that are counted as stalls.
const STALLS: [&str; 3] = ["standstill", "livelock", "stuck"];

impl Measured {
    /// Whether robots with orders made no progress for a long time, so that the figures aren't
    /// those of traffic.
    pub fn is_stalled(&self) -> bool {
        !self.stalls.is_empty()
    }
}

impl Outcome {
    /// The number of the validator's findings of a kind.
    fn count(&self, kind: &str) -> u64 {
        self.findings.get(kind).copied().unwrap_or(0)
    }

    /// Whether the periods of the figures can be added up: a result may come from anywhere.
    pub fn is_plausible(&self) -> bool {
        let periods = self.figures.secs / self.figures.period_secs;
        self.figures.period_secs > 0.0 && (0.0..=MOST_PERIODS).contains(&periods)
    }

    /// Returns the figures after the warm-up, whose end the series of finished orders determines.
    pub fn measured(&self) -> Measured {
        let Figures { secs, period_secs, effort, finished, failed, open, .. } = &self.figures;
        // A period that isn't over would look like a slow one.
        let periods = (secs / period_secs).floor() as usize;
        let mut series = vec![0.0; periods];
        for order in finished {
            // The orders of an instant between two periods belong to the first one, as in the
            // meter.
            let period = ((order.at_secs / period_secs).ceil() as usize).saturating_sub(1);
            if let Some(count) = series.get_mut(period) {
                *count += 1.0;
            }
        }
        let cut = warm_up(&series);
        let warm_up_secs = cut as f64 * period_secs;
        let end_secs = periods as f64 * period_secs;
        let (mut service, mut stops) = (Vec::new(), 0.0);
        for order in finished {
            if order.at_secs > warm_up_secs && order.at_secs <= end_secs {
                service.push(order.service_secs);
                stops += f64::from(order.stops);
            }
        }
        let orders = service.len() as f64;
        let hours = (end_secs - warm_up_secs) / 3600.0;
        let effort = sum(effort.get(cut..periods.min(effort.len())).unwrap_or_default());
        let (contacts, unserved) = (self.count(CONTACT), self.count(UNSERVED));
        let mut other_findings = self.findings.clone();
        other_findings.retain(|kind, _| {
            kind != CONTACT && kind != UNSERVED && !STALLS.contains(&kind.as_str())
        });
        let metres = effort.loaded_metres + effort.empty_metres;
        Measured {
            digest: self.digest.clone(),
            warm_up_secs,
            secs: end_secs - warm_up_secs,
            orders_per_hour: ratio(orders, hours),
            stops_per_hour: ratio(stops, hours),
            service_mean_secs: (orders > 0.0).then(|| service.iter().sum::<f64>() / orders),
            service_p50_secs: percentile(&service, 50),
            service_p99_secs: percentile(&service, 99),
            utilisation: ratio(effort.ordered_secs, effort.robot_secs),
            waiting: ratio(effort.waiting_secs, effort.robot_secs),
            empty: (effort.loaded_metres > 0.0).then(|| effort.empty_metres / metres),
            contacts,
            stalls: self.stalls.clone(),
            unserved,
            other_findings,
            examples: self.examples.clone(),
            finished_orders: finished.len() as u64,
            failed_orders: *failed,
            open_orders: *open,
            wall_secs: self.wall_secs,
        }
    }
}

/// Returns a time as minutes and seconds.
fn clock(secs: f64) -> String {
    let secs = secs.round().max(0.0) as u64;
    format!("{}:{:02} min", secs / 60, secs % 60)
}

fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

fn sum(periods: &[Effort]) -> Effort {
    periods.iter().fold(Effort::default(), |sum, effort| Effort {
        robot_secs: sum.robot_secs + effort.robot_secs,
        ordered_secs: sum.ordered_secs + effort.ordered_secs,
        waiting_secs: sum.waiting_secs + effort.waiting_secs,
        loaded_metres: sum.loaded_metres + effort.loaded_metres,
        empty_metres: sum.empty_metres + effort.empty_metres,
    })
}

#[cfg(test)]
mod tests {
    use regatta_meter::orders::Finished;

    use super::*;

    /// An outcome whose first 200 s carry nothing and whose other 800 s finish an order every 2 s.
    fn outcome() -> Outcome {
        let finished = (101..=500).map(|index| Finished {
            at_secs: f64::from(index) * 2.0,
            service_secs: f64::from(index % 100),
            stops: 2,
        });
        let effort = Effort {
            robot_secs: 40.0,
            ordered_secs: 30.0,
            waiting_secs: 10.0,
            loaded_metres: 6.0,
            empty_metres: 2.0,
        };
        let figures = Figures {
            secs: 1000.0,
            period_secs: 10.0,
            effort: vec![effort; 100],
            finished: finished.collect(),
            ..Figures::default()
        };
        let findings = BTreeMap::from([("contact".to_owned(), 2), ("idle".to_owned(), 1)]);
        let job = serde_json::from_str("\"00\"").expect("an id");
        Outcome {
            job,
            digest: "d".to_owned(),
            figures,
            findings,
            examples: BTreeMap::new(),
            stalls: Vec::new(),
            edges: Vec::new(),
            wall_secs: 1.5,
        }
    }

    #[test]
    fn figures_begin_after_the_warm_up() {
        let measured = outcome().measured();
        assert_eq!((measured.warm_up_secs, measured.secs), (200.0, 800.0));
        assert_eq!((measured.orders_per_hour, measured.stops_per_hour), (1800.0, 3600.0));
        assert_eq!(
            (measured.service_p50_secs, measured.service_p99_secs),
            (Some(49.0), Some(98.0))
        );
        assert_eq!(
            (measured.utilisation, measured.waiting, measured.empty),
            (0.75, 0.25, Some(0.25))
        );
        assert_eq!(measured.contacts, 2);
        assert_eq!(measured.other_findings, BTreeMap::from([("idle".to_owned(), 1)]));
    }

    #[test]
    fn a_run_without_orders_has_figures() {
        let figures = Figures { secs: 4.0, period_secs: 10.0, ..Figures::default() };
        let measured = Outcome { figures, ..outcome() }.measured();
        assert_eq!(
            (measured.orders_per_hour, measured.service_p50_secs, measured.empty),
            (0.0, None, None)
        );
    }
}
