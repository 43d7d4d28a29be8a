//! A day by its hours, and its backlog: a sentence, plots and a table.

use super::content::NONE;
use super::timeline::{Line, Timeline, clock, timeline};
use super::{Block, Picture};
use crate::answer::{Answer, BacklogAnswer, HourAnswer, PeaksAnswer, Spread};
use crate::plan::{DayClock, robots_in_words};
use crate::words::{Kind, in_words};

const HOUR_SECS: f64 = 3600.0;
/// The largest half of an interval that whole seconds don't show.
const LEAST_SPREAD_SECS: f64 = 0.5;

/// Returns what the answer says about the hours of the day and its backlog.
pub(super) fn finding(answer: &Answer, of: &str) -> Option<Block> {
    let peaks = answer.chosen.peaks.as_ref()?;
    let mut texts = vec![format!(
        "{of}With {}, in the mean hour {}",
        robots_in_words(peaks.robots),
        mean_hour(peaks)
    )];
    let worst = peaks.worst_hour.and_then(|index| peaks.hours.get(index));
    texts.extend(worst.map(|hour| format!("in the worst, {}", worst_hour(peaks, hour))));
    Some(Block::Finding(format!("{}. {}", texts.join("; "), backlog(peaks))))
}

fn mean_hour(peaks: &PeaksAnswer) -> String {
    let hour = &peaks.mean_hour;
    let p50 = hour.service_p50_secs.map_or_else(|| NONE.to_owned(), |p50| secs(&p50));
    let p99 = hour.service_p99_secs.map_or_else(|| NONE.to_owned(), |p99| secs(&p99));
    format!("{:.1} orders come (p50 service {p50}, p99 {p99})", hour.released.interval.mean)
}

fn worst_hour(peaks: &PeaksAnswer, hour: &HourAnswer) -> String {
    let p50 = hour.service_p50_secs.map_or_else(|| NONE.to_owned(), |p50| secs(&p50));
    let p99 = hour.service_p99_secs.map_or_else(|| NONE.to_owned(), |p99| secs(&p99));
    format!(
        "{}, {} come and {} are carried (p50 service {p50}, p99 {p99})",
        name(peaks.clock, hour.hour),
        count(&hour.released),
        count(&hour.carried)
    )
}

fn orders_in_words(orders: &Spread) -> String {
    let orders = count(orders);
    if orders == "1" { "1 order is".to_owned() } else { format!("{orders} orders are") }
}

/// Tells the largest backlog and the times until it is cleared.
fn backlog(peaks: &PeaksAnswer) -> String {
    let BacklogAnswer { largest, .. } = &peaks.backlog;
    let BacklogAnswer { cleared_after_largest_secs: peak, cleared_after_last_secs: last, .. } =
        &peaks.backlog;
    let mut text = format!(
        "At most {} open at once{}",
        orders_in_words(largest),
        if largest.least < largest.most {
            format!(" ({} to {} over the seeds)", largest.least, largest.most)
        } else {
            String::new()
        }
    );
    text += &match peak {
        Some(peak) if peak.most == 0.0 => ", never more than there are robots".to_owned(),
        Some(peak) => format!(
            "; {} later, no more than there are robots{}",
            minutes(peak),
            of_runs(peak, peaks.runs)
        ),
        None => "; in no run did they become as few as there are robots".to_owned(),
    };
    text + &match last {
        Some(last) => format!(
            "; {} after the last order has come, none is open{}.",
            minutes(last),
            of_runs(last, peaks.runs)
        ),
        None => "; in each run, orders are open at its end.".to_owned(),
    }
}

/// Tells that not all runs have a figure.
fn of_runs(spread: &Spread, runs: usize) -> String {
    match spread.interval.values {
        values if values == runs => String::new(),
        values => format!(" (in {values} of {runs} runs; in the others, not before their end)"),
    }
}

/// Returns the part of the page about the hours of the day.
pub(super) fn peaks(answer: &Answer, of: &str) -> Vec<Block> {
    let Some(peaks) = &answer.chosen.peaks else { return Vec::new() };
    let mut blocks = vec![Block::Heading(2, format!("{of}Hours of the day"))];
    blocks.extend(pictures(peaks, of));
    blocks.push(table(peaks));
    blocks.push(Block::Text(definitions(peaks)));
    blocks
}

/// The plots of the backlog and of the orders by hour.
fn pictures(peaks: &PeaksAnswer, of: &str) -> [Block; 2] {
    let robots = robots_in_words(peaks.robots);
    let begin_hours = peaks.clock.map_or(0.0, |clock| clock.begin_secs / HOUR_SECS);
    let x = match peaks.clock {
        Some(DayClock { is_utc: true, .. }) => "time of day (UTC)",
        Some(_) => "time of day",
        None => "hours and minutes from the beginning",
    };
    let minutes = peaks.backlog.period_secs / 60.0;
    let open = format!("the most orders open at once in each {minutes:.0} min");
    let open_line = Line { name: "open", values: peaks.backlog.open.clone() };
    let backlog = Timeline {
        x,
        y: "open orders",
        begin_hours,
        period_hours: peaks.backlog.period_secs / HOUR_SECS,
        lines: vec![open_line],
    };
    let by_hour =
        Timeline { x, y: "orders in an hour", begin_hours, period_hours: 1.0, lines: lines(peaks) };
    let band = "line: mean over the seeds; band: from the least to the largest";
    let caption = format!("{of}Backlog over the day with {robots}: {open} ({band})");
    let hours = format!("{of}Orders by hour with {robots} ({band})");
    [
        Picture { name: "backlog", caption, svg: timeline(&backlog) },
        Picture { name: "hours", caption: hours, svg: timeline(&by_hour) },
    ]
    .map(Block::Picture)
}

fn lines(peaks: &PeaksAnswer) -> Vec<Line> {
    let mut lines = vec![
        line("come", peaks, |hour| hour.released),
        line("carried", peaks, |hour| hour.carried),
    ];
    if has_deadlines(peaks) {
        lines.push(line("due", peaks, |hour| hour.due));
    }
    lines
}

fn line(name: &'static str, peaks: &PeaksAnswer, figure: fn(&HourAnswer) -> Spread) -> Line {
    Line { name, values: peaks.hours.iter().map(figure).collect() }
}

fn has_deadlines(peaks: &PeaksAnswer) -> bool {
    peaks.hours.iter().any(|hour| hour.due.most > 0.0)
}

fn table(peaks: &PeaksAnswer) -> Block {
    let head = ["hour", "orders come", "due", "carried", "service p50", "p99"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (hour, index) in peaks.hours.iter().zip(0..) {
        let mark = if peaks.worst_hour == Some(index) { "**" } else { "" };
        rows.push(vec![
            format!("{mark}{}{mark}", name(peaks.clock, hour.hour)),
            count(&hour.released),
            if has_deadlines(peaks) { count(&hour.due) } else { NONE.to_owned() },
            count(&hour.carried),
            hour.service_p50_secs.map_or_else(|| NONE.to_owned(), |p50| secs(&p50)),
            hour.service_p99_secs.map_or_else(|| NONE.to_owned(), |p99| secs(&p99)),
        ]);
    }
    Block::Table(rows)
}

fn definitions(peaks: &PeaksAnswer) -> String {
    let given_up = match peaks.given_up {
        0 => String::new(),
        orders => format!(
            " {orders} orders of all runs, which were given up or cancelled, are in no figure."
        ),
    };
    format!(
        "From the order log of each run. Come: orders released in the hour. Due: orders with a \
         deadline in it. Carried: orders finished in it. Service: from release to end, of the \
         orders that came in the hour; of those that are open at the end of the run, so far. The \
         mean hour: all orders over the {} hours from that of the first to that of the last order. \
         The worst hour, in bold, has the longest p99 on average over the seeds. Open: released \
         and not finished. Figures are means over {} runs with 95 % intervals.{given_up}",
        count(&peaks.mean_hour.hours),
        peaks.runs
    )
}

/// The name of an hour: from when to when, or its number.
fn name(day: Option<DayClock>, hour: usize) -> String {
    let begin = day.map_or(0.0, |day| day.begin_secs / HOUR_SECS) + hour as f64;
    let zone = if day.is_some_and(|day| day.is_utc) { " UTC" } else { "" };
    let of_run = if day.is_some() { "" } else { " of the run" };
    format!("{} to {}{zone}{of_run}", clock(begin), clock(begin + 1.0))
}

/// A count over the seeds, with its interval.
fn count(spread: &Spread) -> String {
    let decimals = if spread.least == spread.most { 0 } else { 1 };
    let interval = spread.interval.without_spread_up_to(0.0);
    in_words(&interval, Kind::Bounded, "", |count| format!("{count:.decimals$}"))
}

fn secs(spread: &Spread) -> String {
    let interval = spread.interval.without_spread_up_to(LEAST_SPREAD_SECS);
    in_words(&interval, Kind::Estimate, " s", |secs| format!("{secs:.0}"))
}

fn minutes(spread: &Spread) -> String {
    let [mean, least, most] =
        [spread.interval.mean, spread.least, spread.most].map(|secs| secs / 60.0);
    match most - least < 0.05 {
        true => format!("{mean:.1} min"),
        false => format!("{mean:.1} min ({least:.1} to {most:.1})"),
    }
}
