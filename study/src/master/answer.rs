//! The answer of a study of a master.

use std::collections::BTreeMap;

use serde::Serialize;

use super::sweep::first_failure;
use super::{MasterPlan, MasterRun, Stuck, Wait};
use crate::statistics::Interval;

/// The least number of bases that tell about a master whose vehicles finish no transport.
const LEAST_BASES: usize = 10;

/// The judgement of a number of vehicles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The master copes: no run has a fault.
    Copes,
    /// A run has a fault.
    Fails,
    /// A run has given no answer.
    Unknown,
}

/// A reason why a master doesn't cope with a number of vehicles.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// Vehicles touched so many times.
    Contacts {
        /// Their number.
        count: u64,
        /// The first one.
        first: Option<String>,
    },
    /// Bases of two vehicles had the same way in opposite directions.
    HeadOn {
        /// Their number.
        count: u64,
        /// The first one.
        first: String,
    },
    /// Bases came late, though the master was free to send them.
    LateBases {
        /// The 99th percentile of the time, in seconds: the mean over the runs in which it is
        /// late.
        p99_secs: f64,
        /// The node with the most late bases.
        node: String,
        /// Late bases there, and everywhere.
        late: [u64; 2],
    },
    /// Vehicles stood at the end, and didn't get a base.
    Stuck {
        /// Their number.
        count: usize,
        /// The one that stood for the longest time.
        longest: Stuck,
    },
    /// Vehicles never got an order, though there was one for each.
    NeverOrdered {
        /// Their number.
        count: u64,
    },
}

/// A number of vehicles and its runs.
#[derive(Clone, Debug, Serialize)]
pub struct MasterPoint {
    /// The number of vehicles.
    pub vehicles: u32,
    /// The judgement.
    pub verdict: Verdict,
    /// The reasons, the worst first.
    pub faults: Vec<Fault>,
    /// The runs that gave figures.
    pub runs: Vec<MasterRun>,
    /// The reason why a run gave none.
    pub failure: Option<String>,
}

/// The answer of a study of a master.
#[derive(Clone, Debug, Serialize)]
pub struct MasterAnswer {
    /// The name of the plant.
    pub title: String,
    /// The version of the program.
    pub program: String,
    /// The master, in words.
    pub master: String,
    /// The way in which it got transport orders, in words.
    pub orders: String,
    /// The numbers of vehicles that were asked for.
    pub asked: String,
    /// The number of runs of each.
    pub repeats: u64,
    /// The time of a run, in seconds.
    pub secs: u64,
    /// Seconds after which a base is late.
    pub late_secs: f64,
    /// The stations and nodes that are cut off from the other roads, in words: they take no part.
    pub left_out: Vec<String>,
    /// Whether the user ended the study before its end.
    pub is_interrupted: bool,
    /// The largest number of vehicles that the master copes with, and with all below it.
    pub copes: Option<u32>,
    /// The least number with which it fails.
    pub fails: Option<u32>,
    /// The points, by ascending vehicles.
    pub points: Vec<MasterPoint>,
}

impl MasterPoint {
    /// Judges the runs of a number of vehicles. With `has_order_for_each`, each vehicle should get
    /// an order.
    pub fn new(
        vehicles: u32,
        runs: Vec<MasterRun>,
        failure: Option<String>,
        late_secs: f64,
        has_order_for_each: bool,
    ) -> Self {
        let faults = faults(&runs, late_secs, has_order_for_each);
        let failure = failure.or_else(|| nothing_measured(&runs).filter(|_| faults.is_empty()));
        let verdict = match (&failure, faults.is_empty()) {
            (_, false) => Verdict::Fails,
            (Some(_), true) => Verdict::Unknown,
            (None, true) => Verdict::Copes,
        };
        Self { vehicles, verdict, faults, runs, failure }
    }

    /// Returns a figure of all runs that have it, as a mean with its interval.
    pub fn interval(&self, figure: impl Fn(&MasterRun) -> Option<f64>) -> Option<Interval> {
        Interval::of(&self.runs.iter().filter_map(figure).collect::<Vec<_>>())
    }

    /// Returns the sum of a number over all runs.
    pub fn sum(&self, number: impl Fn(&MasterRun) -> u64) -> u64 {
        self.runs.iter().map(number).sum()
    }

    /// Returns the waiting of all runs by node, that with the most late bases and the longest
    /// standing first.
    pub fn places(&self) -> Vec<(String, Wait)> {
        let mut sums: BTreeMap<&str, Wait> = BTreeMap::new();
        for (node, wait) in self.runs.iter().flat_map(|run| &run.places) {
            let sum = sums.entry(node).or_default();
            sum.standing_secs += wait.standing_secs;
            sum.bases += wait.bases;
            sum.late += wait.late;
            sum.longest_secs = sum.longest_secs.max(wait.longest_secs);
        }
        let mut places: Vec<_> =
            sums.into_iter().map(|(node, wait)| (node.to_owned(), wait)).collect();
        places.sort_by(|(_, one), (_, other)| {
            let late = other.late.cmp(&one.late);
            late.then(other.standing_secs.total_cmp(&one.standing_secs))
        });
        places
    }
}

/// Returns the reason why runs give no answer in which too little was measured.
fn nothing_measured(runs: &[MasterRun]) -> Option<String> {
    let transports: u64 = runs.iter().map(|run| run.finished_orders).sum();
    let bases: usize = runs.iter().filter_map(|run| Some(run.response?.count)).sum();
    let secs: f64 = runs.iter().map(|run| run.secs).sum();
    (!runs.is_empty() && transports == 0 && bases < LEAST_BASES).then(|| {
        format!(
            "in {secs:.0} s, no vehicle finished a pick and a drop, and only {bases} bases were \
             asked for that the master was free to send: give a longer --duration, and let the \
             master send the actions `pick` and `drop`"
        )
    })
}

/// Returns the faults in any of some runs, the worst first.
fn faults(runs: &[MasterRun], late_secs: f64, has_order_for_each: bool) -> Vec<Fault> {
    let mut faults = Vec::new();
    let contacts: u64 = runs.iter().map(|run| run.contacts).sum();
    if contacts > 0 {
        let first = runs.iter().find_map(|run| run.first_contact.clone());
        faults.push(Fault::Contacts { count: contacts, first });
    }
    let head_on: Vec<_> = runs.iter().filter_map(MasterRun::head_on).collect();
    if let Some(first) = head_on.first() {
        let count = head_on.iter().map(|breach| breach.count).sum();
        faults.push(Fault::HeadOn { count, first: first.example.clone() });
    }
    faults.extend(late_bases(runs, late_secs));
    let stuck = runs.iter().max_by_key(|run| run.stuck.len());
    if let Some((count, longest)) =
        stuck.and_then(|run| Some((run.stuck.len(), run.stuck.first()?)))
    {
        faults.push(Fault::Stuck { count, longest: longest.clone() });
    }
    let never_ordered = runs.iter().map(|run| run.never_ordered).max().unwrap_or(0);
    if never_ordered > 0 && has_order_for_each {
        faults.push(Fault::NeverOrdered { count: never_ordered });
    }
    faults
}

fn late_bases(runs: &[MasterRun], late_secs: f64) -> Option<Fault> {
    let p99s = runs.iter().filter_map(|run| Some(run.response?.p99_secs));
    let p99s: Vec<f64> = p99s.filter(|p99| *p99 > late_secs).collect();
    let p99_secs = Interval::of(&p99s)?.mean;
    let mut by_node: BTreeMap<&str, u64> = BTreeMap::new();
    for (node, wait) in runs.iter().flat_map(|run| &run.places) {
        *by_node.entry(node).or_default() += wait.late;
    }
    let all = by_node.values().sum();
    let (node, most) = by_node.into_iter().rev().max_by_key(|(_, late)| *late)?;
    Some(Fault::LateBases { p99_secs, node: node.to_owned(), late: [most, all] })
}

impl MasterAnswer {
    /// Puts the points together.
    pub fn new(plan: &MasterPlan, points: Vec<MasterPoint>, is_interrupted: bool) -> Self {
        let known: BTreeMap<u32, Verdict> =
            points.iter().map(|point| (point.vehicles, point.verdict)).collect();
        let fails = first_failure(&known);
        let below = points.iter().take_while(|point| point.verdict == Verdict::Copes);
        Self {
            title: plan.title.clone(),
            program: plan.program.clone(),
            master: plan.master.clone(),
            orders: plan.orders.clone(),
            asked: plan.vehicles.to_string(),
            repeats: plan.repeats,
            secs: plan.time.secs,
            late_secs: plan.late_secs,
            left_out: plan.variant.left_out.clone(),
            is_interrupted,
            copes: below.last().map(|point| point.vehicles),
            fails,
            points,
        }
    }

    /// Returns the point of a number of vehicles.
    pub fn point(&self, vehicles: Option<u32>) -> Option<&MasterPoint> {
        self.points.iter().find(|point| Some(point.vehicles) == vehicles)
    }

    /// Whether the answer is known, and no vehicle touched another one.
    pub fn is_good(&self) -> bool {
        let contacts: u64 = self.points.iter().map(|point| point.sum(|run| run.contacts)).sum();
        self.copes.is_some() && contacts == 0 && !self.is_interrupted
    }
}
