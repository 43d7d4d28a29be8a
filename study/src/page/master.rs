//! The page of a study of a master.

mod verdict;

use std::collections::BTreeMap;

use super::chart::{Chart, ChartPoint, Series, chart};
use super::heat_map::heat_map;
use super::{Block, Picture};
use crate::bottleneck::bottlenecks;
use crate::master::{Breach, MasterAnswer, MasterPoint, MasterRun, Verdict, Wait};
use crate::outcome::EdgeOutcome;
use crate::plan::Variant;
use crate::statistics::Interval;
use crate::words::{Kind, in_words};

use self::verdict::{caveats, faults_in_words, verdict};

/// Returns a number of vehicles in words: `1 vehicle`, `5 vehicles`.
pub fn vehicles_in_words(vehicles: u32) -> String {
    format!("{vehicles} vehicle{}", if vehicles == 1 { "" } else { "s" })
}

/// The number of places in the table.
const PLACES: usize = 10;
/// The text in place of a missing figure.
const NONE: &str = "–";

/// Returns the title of the page.
pub fn master_title(answer: &MasterAnswer) -> String {
    format!("How many vehicles does the master cope with on {}?", answer.title)
}

/// Returns the blocks of the page. `variant` is the layout with its vehicles.
pub fn master_content(answer: &MasterAnswer, variant: &Variant) -> Vec<Block> {
    let mut blocks = vec![Block::Heading(1, master_title(answer)), Block::Answer(verdict(answer))];
    blocks.extend(caveats(answer).into_iter().map(Block::Caveat));
    if answer.points.iter().all(|point| point.runs.is_empty()) {
        return blocks;
    }
    blocks.push(table(answer));
    blocks.extend(fault_list(answer));
    blocks.extend(charts(answer));
    blocks.extend(shown_point(answer).map(|point| slow_places(answer, point)).unwrap_or_default());
    blocks.extend(shown_point(answer).map(|point| waiting(point, variant)).unwrap_or_default());
    blocks.extend(breaches(answer));
    blocks.push(Block::Heading(2, "Method".to_owned()));
    blocks.extend(method(answer, variant).into_iter().map(Block::Text));
    blocks
}

fn picture(name: &'static str, caption: &str, svg: &str) -> Block {
    Block::Picture(Picture { name, caption: caption.to_owned(), svg: svg.to_owned() })
}

/// The point whose places are shown: the first that fails, or else the largest that has runs.
fn shown_point(answer: &MasterAnswer) -> Option<&MasterPoint> {
    let largest = answer.points.iter().rev().find(|point| !point.runs.is_empty());
    answer.point(answer.fails).filter(|point| !point.runs.is_empty()).or(largest)
}

/// The charts of the figures that there are.
fn charts(answer: &MasterAnswer) -> Vec<Block> {
    let base = vec![
        series("p50", answer, |run| Some(run.response?.p50_secs)),
        series("p99", answer, |run| Some(run.response?.p99_secs)),
    ];
    let throughput = vec![series("", answer, |run| Some(run.orders_per_hour))];
    let service = vec![
        series("p50", answer, |run| Some(run.service.as_ref()?.p50_secs)),
        series("p99", answer, |run| Some(run.service.as_ref()?.p99_secs)),
    ];
    let base_caption = "Time from the state that asks for a base to the base, where the master was \
                        free to send it";
    let service_caption = "Time of transport orders, from the hand-over to the drop";
    let charts = [
        ("response", base_caption, "seconds", base),
        ("throughput", "Finished transports", "transports an hour", throughput),
        ("service", service_caption, "seconds", service),
    ];
    let mut blocks = Vec::new();
    for (name, caption, y, series) in charts {
        if series.iter().any(|line| !line.points.is_empty()) {
            let knee = answer.copes.map(f64::from);
            let svg = chart(&Chart { x: "vehicles", y, series, knee, most: None });
            blocks.push(picture(name, caption, &svg));
        }
    }
    blocks
}

type Figure = fn(&MasterRun) -> Option<f64>;

fn series(name: &str, answer: &MasterAnswer, figure: Figure) -> Series {
    let mut points = Vec::new();
    for point in &answer.points {
        if let Some(Interval { mean, half_width, .. }) = point.interval(figure) {
            let half_width = half_width.unwrap_or(0.0);
            let robots = f64::from(point.vehicles);
            points.push(ChartPoint { robots, mean, half_width, is_stalled: false });
        }
    }
    Series { name: name.to_owned(), points }
}

const COLUMNS: [&str; 13] = [
    "vehicles",
    "copes",
    "transports an hour",
    "order p50",
    "p99",
    "base p50",
    "p99",
    "bases",
    "late",
    "waiting",
    "idle p50",
    "contacts",
    "runs",
];

fn table(answer: &MasterAnswer) -> Block {
    let mut rows = vec![COLUMNS.map(str::to_owned).to_vec()];
    rows.extend(answer.points.iter().map(|point| row(answer, point)));
    Block::Table(rows)
}

fn row(answer: &MasterAnswer, point: &MasterPoint) -> Vec<String> {
    let vehicles = point.vehicles.to_string();
    let copes = match point.verdict {
        Verdict::Copes => "yes",
        Verdict::Fails => "no",
        Verdict::Unknown => "not known",
    };
    let secs = |figure: Figure| text(point.interval(figure), Kind::Estimate, " s", 1);
    let own = |figure: Figure| text(point.interval(figure), Kind::Estimate, " s", 2);
    vec![
        if answer.copes == Some(point.vehicles) { format!("**{vehicles}**") } else { vehicles },
        copes.to_owned(),
        text(point.interval(|run| Some(run.orders_per_hour)), Kind::Estimate, "", 0),
        secs(|run| Some(run.service.as_ref()?.p50_secs)),
        secs(|run| Some(run.service.as_ref()?.p99_secs)),
        own(|run| Some(run.response?.p50_secs)),
        own(|run| Some(run.response?.p99_secs)),
        point.sum(|run| run.response.map_or(0, |times| times.count as u64)).to_string(),
        point.sum(|run| run.late).to_string(),
        text(point.interval(|run| Some(run.waiting)), Kind::Share, " %", 0),
        secs(|run| Some(run.idle?.p50_secs)),
        point.sum(|run| run.contacts).to_string(),
        point.runs.len().to_string(),
    ]
}

/// A mean of the runs of a point with its interval, in a unit.
fn text(interval: Option<Interval>, kind: Kind, unit: &str, decimals: usize) -> String {
    let Some(interval) = interval else { return NONE.to_owned() };
    let factor = if kind == Kind::Share { 100.0 } else { 1.0 };
    in_words(&interval, kind, unit, |value| format!("{:.decimals$}", value * factor))
}

/// The reasons of all points that fail, one paragraph each.
fn fault_list(answer: &MasterAnswer) -> Vec<Block> {
    let mut blocks = Vec::new();
    for point in &answer.points {
        let who = vehicles_in_words(point.vehicles);
        if !point.faults.is_empty() {
            blocks.push(Block::Text(format!("With {who}: {}.", faults_in_words(&point.faults))));
        }
        if let Some(failure) = &point.failure {
            blocks.push(Block::Text(format!("With {who}, nothing is known: {failure}.")));
        }
    }
    blocks
}

/// The table of the places where bases came late.
fn slow_places(answer: &MasterAnswer, point: &MasterPoint) -> Vec<Block> {
    let heading = format!("Where bases come late, with {}", vehicles_in_words(point.vehicles));
    let mut blocks = vec![Block::Heading(2, heading)];
    let places = point.places();
    let late: Vec<&(String, Wait)> = places.iter().filter(|(_, wait)| wait.late > 0).collect();
    if late.is_empty() {
        blocks.push(Block::Text(format!(
            "Nowhere: no base that the master was free to send came later than {} s.",
            answer.late_secs
        )));
        return blocks;
    }
    let head = ["node", "bases", "late", "longest", "vehicles stood for a base"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (node, wait) in late.into_iter().take(PLACES) {
        rows.push(vec![
            node.clone(),
            wait.bases.to_string(),
            wait.late.to_string(),
            format!("{:.1} s", wait.longest_secs),
            format!("{:.0} s", wait.standing_secs),
        ]);
    }
    blocks.push(Block::Table(rows));
    blocks
}

/// The map and the table of the places that vehicles waited for.
fn waiting(point: &MasterPoint, variant: &Variant) -> Vec<Block> {
    let who = vehicles_in_words(point.vehicles);
    let mut blocks = vec![Block::Heading(2, format!("Waiting, with {who}"))];
    let secs: f64 = point.runs.iter().map(|run| run.secs).sum();
    let edges = edges(point);
    let share = point.interval(|run| Some(run.waiting)).map_or(0.0, |interval| interval.mean);
    let robots = share * f64::from(point.vehicles);
    let found = bottlenecks(variant, &edges, robots, secs.ceil().max(1.0) as u64);
    if found.is_empty() {
        let text = match robots >= 0.005 {
            true => format!(
                "{robots:.2} vehicles stood at the end of their base on average; their orders \
                 didn't say where to."
            ),
            false => "Nowhere: no vehicle stood and waited for a base.".to_owned(),
        };
        blocks.push(Block::Text(text));
        return blocks;
    }
    let map = heat_map(&variant.graph, &edges, &found, secs.ceil().max(1.0) as u64);
    let caption = format!(
        "The places where vehicles stand at the end of their base, with {who}. Each number marks a \
         place that they wait for."
    );
    blocks.push(picture("waiting", &caption, &map));
    let head = ["", "place", "vehicles waiting for it", "of all waiting"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (place, rank) in found.iter().zip(1..) {
        rows.push(vec![
            rank.to_string(),
            place.place(),
            format!("{:.2}", place.robots_waiting),
            format!("{:.1} %", place.share * 100.0),
        ]);
    }
    blocks.push(Block::Table(rows));
    blocks
}

/// The waiting of all runs by edge.
fn edges(point: &MasterPoint) -> Vec<EdgeOutcome> {
    let mut sums: BTreeMap<u32, EdgeOutcome> = BTreeMap::new();
    for (edge, [stood, kept_out]) in point.runs.iter().flat_map(|run| &run.edges) {
        let sum = sums.entry(*edge).or_insert_with(|| EdgeOutcome::new(*edge));
        sum.waiting_secs += stood;
        sum.caused_secs += kept_out;
    }
    sums.into_values().collect()
}

/// The table of breaches of the standard, and the errors that vehicles told.
fn breaches(answer: &MasterAnswer) -> Vec<Block> {
    let mut sums: BTreeMap<&str, Breach> = BTreeMap::new();
    let mut errors: BTreeMap<&str, u64> = BTreeMap::new();
    for run in answer.points.iter().flat_map(|point| &point.runs) {
        for breach in &run.breaches {
            match sums.get_mut(&*breach.rule) {
                Some(sum) => sum.count += breach.count,
                None => {
                    sums.insert(&breach.rule, breach.clone());
                }
            }
        }
        for (kind, count) in &run.errors {
            *errors.entry(kind).or_default() += count;
        }
    }
    let mut blocks = vec![Block::Heading(2, "The standard".to_owned())];
    if sums.is_empty() {
        blocks.push(Block::Text("No breach of VDA 5050 was seen, by either side.".to_owned()));
    } else {
        let head = ["by", "severity", "rule", "times", "requirement", "the first one"];
        let mut rows = vec![head.map(str::to_owned).to_vec()];
        let mut sums: Vec<Breach> = sums.into_values().collect();
        sums.sort_by(|one, other| {
            (&one.side, &one.severity, &one.rule).cmp(&(&other.side, &other.severity, &other.rule))
        });
        for breach in sums {
            let Breach { rule, requirement, side, severity, clause, count, example } = breach;
            let requirement = format!("{requirement} ({clause})");
            rows.push(vec![side, severity, rule, count.to_string(), requirement, example]);
        }
        blocks.push(Block::Table(rows));
    }
    if !errors.is_empty() {
        let list = errors.iter().map(|(kind, count)| format!("{count} `{kind}`"));
        let list = list.collect::<Vec<_>>().join(", ");
        blocks.push(Block::Text(format!("Errors that vehicles reported to the master: {list}.")));
    }
    blocks
}

fn method(answer: &MasterAnswer, variant: &Variant) -> Vec<String> {
    let MasterAnswer { program, master, orders, repeats, secs, late_secs, .. } = answer;
    let (nodes, edges) = (variant.graph.nodes().len(), variant.graph.edges().len());
    vec![
        format!(
            "Regatta {program}. The roads have {nodes} nodes and {edges} edges. Master: {master}. \
             Transport orders: {orders}."
        ),
        format!(
            "**Real time**: a master is a program that works in real time. Each run takes {secs} s \
             from the master's first order on, and its figures contain times of this machine, of \
             the broker and of the network; they don't repeat bit by bit, as those of other \
             studies do. Each number of vehicles has {} of them, with other transport orders; \
             intervals are Student's at 95 % over them.",
            if *repeats == 1 { "one".to_owned() } else { repeats.to_string() }
        ),
        "**A base** is asked for by the first state with `newBaseRequest`, or that shows the last \
         released node as reached and its actions as done. It comes with the next update that \
         releases more. The time between counts as the master's own if none of the released nodes \
         was in the base of another vehicle, or was its last node, since the state; a base that \
         hasn't come at the end counts with its time so far. A master that keeps more room apart \
         than nodes, such as blocks and single tracks, holds vehicles back at nodes that look \
         free: then late bases stand at these places, and at no others."
            .to_owned(),
        format!(
            "**The master copes** with a number of vehicles if in each of its runs the 99th \
             percentile of the master's own time is at most {late_secs} s, no vehicles touch, no \
             bases have the same way in opposite directions, no vehicle stands at the end for \
             longer than a minute (in short runs half of the run) without a base, each vehicle \
             gets an order if there is one for each. A range of numbers is doubled \
             until the master fails; then the distance to the largest number below is halved."
        ),
        "**A transport** is counted when a vehicle has finished an action `drop` after an action \
         `pick`. It belongs to the oldest transport order from and to the same stations that was \
         handed over; its time begins then. The throughput is without the warm-up (MSER-5 on the \
         transports of each ten seconds)."
            .to_owned(),
        "Contacts are found by the validator in the poses of the vehicles, breaches of the \
         standard by `regatta vda5050 check` in the messages."
            .to_owned(),
    ]
}

#[cfg(test)]
mod tests;
