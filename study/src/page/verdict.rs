//! The first sentences of the page: the answer.

use regatta_base::grouped;

use super::Block;
use super::least::of_least;
use crate::answer::{Answer, KneeAnswer, NoRoom, PointAnswer, RunAnswer, VariantAnswer};
use crate::outcome::{Stall, StallKind};
use crate::plan::robots_in_words;
use crate::statistics::Interval;
use crate::words::{Kind, NOT_KNOWN, in_words};
use crate::workers::NOT_ALL_PLACED;

/// The part of the knee's throughput below which more robots carry clearly less.
const FEWER: f64 = 0.8;
/// The largest number of numbers of robots that a sentence lists.
const MOST_LISTED: usize = 4;

/// The beginning of an answer without a number of robots.
const UNKNOWN: &str = "the number of robots that the plant holds isn't known";

/// The answer for a variant, in one sentence or two. The first is whole: it stands alone on the
/// terminal.
pub(super) fn verdict(answer: &Answer, variant: &VariantAnswer) -> String {
    let name = prefix(variant);
    match (&variant.least, &variant.knee) {
        (Some(least), _) => format!("{name}{}", of_least(variant, least)),
        (None, Some(knee)) => format!("{name}{}", of_knee(answer, variant, knee)),
        (None, None) => {
            format!("{name}{}", without_knee(variant, minutes(answer)))
        }
    }
}

/// The validator's name for orders that no robot can carry out.
const UNROUTABLE: &str = "unroutable";

/// The name of a variant as the beginning of a sentence; empty if there are no others.
pub(super) fn prefix(variant: &VariantAnswer) -> String {
    if variant.name.is_empty() { String::new() } else { format!("{}: ", variant.name) }
}

fn without_knee(variant: &VariantAnswer, minutes: f64) -> String {
    if let Some(reason) = variant.failure() {
        return format!("no run has succeeded: {reason}.");
    }
    match least_stalled(variant) {
        Some(point) => format!(
            "{UNKNOWN}. {}{} No number of robots that was tried is an answer.",
            without_orders(variant, point.robots),
            without_count(point, minutes)
        ),
        None => without_figures(variant, minutes),
    }
}

/// Tells of runs that didn't stall and have no figures: nothing was finished after the warm-up.
fn without_figures(variant: &VariantAnswer, minutes: f64) -> String {
    let finished: u64 = variant.points.iter().map(|point| point.finished_orders).sum();
    let unserved: u64 = variant.points.iter().map(|point| point.unserved).sum();
    if finished > 0 {
        let reason = match variant.other_findings.is_empty() && unserved == 0 {
            true => "No finding shows what stopped the robots: look at a recording (--record).",
            false => "The findings below show what stopped the robots.",
        };
        return format!(
            "{UNKNOWN}: {finished} orders were finished at the beginning of the runs, and none \
             later. {reason}"
        );
    }
    match variant.other_findings.get(UNROUTABLE) {
        Some(orders) => format!(
            "nothing was carried: no order was finished in {minutes:.0} minutes, and no robot can \
             carry out {orders} of them, as the findings below tell."
        ),
        None if !variant.is_managed_by_regatta && !variant.is_bound => format!(
            "nothing was carried: by the order log, which the manager has to write, no order was \
             finished in {minutes:.0} minutes. If one takes longer, give a longer --duration."
        ),
        None => format!(
            "nothing was carried: no order was finished in {minutes:.0} minutes. If one takes \
             longer, give a longer --duration."
        ),
    }
}

/// Tells why the numbers of robots below one that stalled are no answer: they carry nothing after
/// the warm-up.
fn without_orders(variant: &VariantAnswer, stalled: u32) -> String {
    let fewer = variant.points.iter().filter(|point| point.robots < stalled);
    let told = fewer.map(|point| {
        let robots = robots_in_words(point.robots);
        match point.finished_orders {
            0 => format!("{robots} finished no order. "),
            1 => format!(
                "{robots} finished 1 order in {} runs, too few for a figure. ",
                point.runs.len()
            ),
            orders => format!(
                "{robots} finished {orders} orders in {} runs, too few for a figure. ",
                point.runs.len()
            ),
        }
    });
    told.collect()
}

/// Returns the reason why a number of robots has finished too few orders for an answer.
fn too_few_orders(point: &PointAnswer) -> Option<String> {
    point.has_too_few_orders().then(|| {
        format!(
            "{} finished {:.1} orders in a run, too few for a figure. Give a longer --duration.",
            robots_in_words(point.robots),
            point.orders_of_run(),
        )
    })
}

/// The minutes of a run.
fn minutes(answer: &Answer) -> f64 {
    answer.method.secs as f64 / 60.0
}

fn of_knee(answer: &Answer, variant: &VariantAnswer, knee: &KneeAnswer) -> String {
    let count = robots_in_words(knee.robots);
    let carries = if knee.robots == 1 { "carries" } else { "carry" };
    if let Some(reason) = unknown(variant, knee) {
        return format!("{UNKNOWN}: {reason}");
    }
    let throughput = format!("{carries} {} orders an hour", with_interval(&knee.orders_per_hour));
    let mut text = match knee.is_open {
        true => of_open_end(variant, &count, &throughput, knee),
        false => format!("the plant holds {count}, which {throughput}."),
    };
    text.extend(missing_types(variant));
    text.extend(larger(answer, variant, knee));
    text.extend(without_progress(variant, knee, minutes(answer)));
    text.extend(half(variant, knee));
    text
}

/// Tells the types that the answer's fleet has no robot of, if there are orders that no robot can
/// carry out.
fn missing_types(variant: &VariantAnswer) -> Option<String> {
    variant.other_findings.get(UNROUTABLE)?;
    let missing = variant.robot_types.iter().filter(|fleet_type| fleet_type.robots == Some(0));
    let missing: Vec<String> =
        missing.filter_map(|fleet_type| Some(format!("`{}`", fleet_type.name.as_ref()?))).collect();
    (!missing.is_empty()).then(|| {
        format!(
            " This fleet has no robot of {}: orders for that type aren't carried. Give more --robots.",
            missing.join(" and ")
        )
    })
}

/// Returns the reason why the throughput of the knee isn't known, if it isn't.
fn unknown(variant: &VariantAnswer, knee: &KneeAnswer) -> Option<String> {
    let KneeAnswer { robots, orders_per_hour, .. } = knee;
    let point = variant.points.iter().find(|point| point.robots == *robots);
    if let Some(reason) = point.and_then(too_few_orders) {
        return Some(reason);
    }
    if orders_per_hour.is_known() {
        return None;
    }
    let count = robots_in_words(*robots);
    let carries = if *robots == 1 { "carries" } else { "carry" };
    let seeds = match orders_per_hour.values {
        1 => "one seed".to_owned(),
        seeds => format!("{seeds} seeds"),
    };
    let some = orders_an_hour(orders_per_hour, Kind::Bounded);
    let without_room = variant.no_room.iter().find(|no_room| no_room.robots == *robots);
    Some(match without_room {
        Some(NoRoom { reason, .. }) => format!(
            "{count} {carries} {some} orders an hour with {seeds}; with others, not all found a \
             place: {reason}."
        ),
        None => format!(
            "{count} {carries} {some} orders an hour, which is no more precise with {seeds}. Give \
             a longer --duration or more --seeds."
        ),
    })
}

/// Tells what larger numbers than that of the knee bring, as far as their runs count.
fn larger(answer: &Answer, variant: &VariantAnswer, knee: &KneeAnswer) -> Option<String> {
    let end = knee.stalls_from.unwrap_or(u32::MAX);
    let larger =
        variant.points.iter().filter(|point| (knee.robots + 1..end).contains(&point.robots));
    let larger: Vec<&PointAnswer> = larger.collect();
    let mut fewer = larger.iter().filter(|point| carries_fewer(point, knee));
    let first = fewer.clone().next();
    // One that is less beyond chance says more.
    if let Some(fewer) = fewer.find(|point| is_less(point, knee)).or(first) {
        return with_fewer_orders(fewer, knee);
    }
    let numbers: Vec<u32> = larger.iter().map(|point| point.robots).collect();
    let tried = numbers_in_words(&numbers)?;
    let part = answer.method.knee * 100.0;
    Some(format!(
        " With {tried}, each further robot brings on average less than {part:.0} % of {}.",
        alone(variant)
    ))
}

/// Tells that a number of robots carries less than that of the knee, or may do so.
fn with_fewer_orders(point: &PointAnswer, knee: &KneeAnswer) -> Option<String> {
    let count = robots_in_words(point.robots);
    let orders = point.orders_per_hour?;
    let waiting = 100.0 * point.waiting.map_or(0.0, |interval| interval.mean);
    let waits = format!("robots wait {waiting:.0} % of their time");
    let some = orders_in_words(point)?;
    Some(match (orders.is_known() || orders.mean == 0.0) && !has_too_few(point) {
        true if is_less(point, knee) => {
            format!(" With {count}, it is less: {some} orders an hour; {waits}.")
        }
        true => format!(
            " With {count}, {some} orders an hour were measured: fewer on average, which may be \
             chance; {waits}."
        ),
        false => format!(" With {count}, the orders an hour are {some}; {waits}."),
    })
}

/// Returns ascending numbers in words, as alternatives; `None` if there are none.
fn numbers_in_words(numbers: &[u32]) -> Option<String> {
    let (last, others) = numbers.split_last()?;
    let others: Vec<String> = others.iter().map(u32::to_string).collect();
    Some(match others.len() {
        0 => last.to_string(),
        1..MOST_LISTED => format!("{} or {last}", others.join(", ")),
        count => format!("{} to {last} ({} numbers were tried)", others[0], count + 1),
    })
}

/// The throughput that further robots are compared with: that of one, or of each of the fewest
/// that were tried.
fn alone(variant: &VariantAnswer) -> String {
    match variant.points.first().map(|point| point.robots) {
        None | Some(1) => "what one brings alone".to_owned(),
        Some(robots) => format!("what each of {robots} brings"),
    }
}

/// Tells the least number of robots whose runs don't all count, and what that leaves unknown.
fn without_progress(variant: &VariantAnswer, knee: &KneeAnswer, minutes: f64) -> Option<String> {
    let from = knee.stalls_from?;
    let index = variant.points.iter().position(|point| point.robots == from)?;
    let (tried, rest) = variant.points.split_at(index);
    let verdict = match rest.len() {
        1 => "This number isn't an answer",
        _ => "Neither this number nor a larger one that was tried is an answer",
    };
    let without_figures = variant.failed.iter().map(|(robots, _)| *robots);
    let without_figures =
        without_figures.chain(variant.no_room.iter().map(|no_room| no_room.robots));
    let tried = tried.iter().map(|point| point.robots).chain(without_figures);
    let before = tried.filter(|robots| *robots < from).max().unwrap_or(knee.robots);
    let between = between(before, from).map_or_else(String::new, |between| format!("; {between}"));
    Some(format!(" {} {verdict}{between}.", without_count(&rest[0], minutes)))
}

/// Tells the numbers between two that weren't tried; `None` if there are none.
fn between(before: u32, after: u32) -> Option<String> {
    match after - before {
        ..=1 => None,
        2 => Some(format!("{} wasn't tried", before + 1)),
        _ => Some(format!("no number from {} to {} was tried", before + 1, after - 1)),
    }
}

/// Tells how many runs of a number of robots don't count, and what happened in the first of them.
fn without_count(point: &PointAnswer, minutes: f64) -> String {
    let stalled: Vec<&RunAnswer> = point.stalled().collect();
    let (do_not, in_it) = match stalled.len() {
        1 => ("doesn't", "in it"),
        _ => ("don't", "in the first of them"),
    };
    let first = stalled.first().map_or_else(String::new, |run| {
        let orders = match run.finished_orders {
            0 => "no order was".to_owned(),
            1 => "1 order was".to_owned(),
            orders => format!("{orders} orders were"),
        };
        let happened = what_happened(&run.stalls, point.robots);
        format!(": {in_it}, {happened}, and {orders} finished in {minutes:.0} min")
    });
    format!(
        "With {}, {} of {} runs {do_not} count{first}.",
        robots_in_words(point.robots),
        stalled.len(),
        point.runs.len()
    )
}

/// Tells the worst of the stalls of a run, in a few words.
fn what_happened(stalls: &[Stall], robots: u32) -> String {
    let Some(first) = stalls.first() else { return String::new() };
    let span = first.span();
    match (first.kind, stalls.len()) {
        (StallKind::Standstill, _) => format!("all robots with orders stood {span}"),
        (StallKind::Livelock, _) => format!("robots drove {span} without any arrival"),
        (StallKind::Stuck, 1) => {
            format!("one of {robots} stood with an order {span} while others drove")
        }
        (StallKind::Stuck, _) => {
            format!("some of {robots} stood with an order, the first {span}, while others drove")
        }
    }
}

/// Tells the number up to which further robots bring much, if it is another than that of the knee.
fn half(variant: &VariantAnswer, knee: &KneeAnswer) -> Option<String> {
    // Below the first number that was tried nothing is known.
    let is_first = variant.points.first().is_none_or(|point| point.robots >= knee.half);
    let is_known = !is_first && known_orders(variant, knee.half).is_some();
    (is_known && knee.half < knee.robots).then(|| {
        format!(
            " Up to {}, each further one brings on average at least half of {}.",
            knee.half,
            alone(variant)
        )
    })
}

/// Returns the table of the numbers that a planner uses: up to which each further robot still
/// brings much of what the first one brings, and which carries the most. `of` names the variant, if
/// there are several.
pub(super) fn numbers(variant: &VariantAnswer, of: &str) -> Option<Block> {
    let knee = variant.knee.as_ref().filter(|knee| unknown(variant, knee).is_none())?;
    let KneeAnswer { most_of, half, most, .. } = knee;
    let least = variant.points.first()?.robots;
    let mut rows = vec![vec![format!("{of}robots"), "orders an hour".to_owned(), String::new()]];
    for (robots, part) in [(*most_of, 90), (*half, 50)] {
        // Below the first number that was tried nothing is known.
        if robots > least || robots == 1 {
            let rule = format!(
                "up to this number, each further robot brings on average at least {part} % of {}",
                alone(variant)
            );
            rows.extend(number(variant, robots, rule));
        }
    }
    rows.extend(number(
        variant,
        *most,
        "the number that carries the most, of those that were tried".to_owned(),
    ));
    (rows.len() > 1).then_some(Block::Table(rows))
}

/// The row of a number of robots whose throughput is known.
fn number(variant: &VariantAnswer, robots: u32, rule: String) -> Option<Vec<String>> {
    let orders = known_orders(variant, robots)?;
    Some(vec![robots.to_string(), with_interval(&orders), rule])
}

/// Returns the throughput of a number of robots, if it is known.
fn known_orders(variant: &VariantAnswer, robots: u32) -> Option<Interval> {
    let point = variant.points.iter().find(|point| point.robots == robots)?;
    point.orders_per_hour.filter(Interval::is_known)
}

/// Whether more robots than those of the knee carry clearly less.
fn carries_fewer(point: &PointAnswer, knee: &KneeAnswer) -> bool {
    let orders = point.orders_per_hour.map_or(0.0, |interval| interval.mean);
    point.robots > knee.robots && orders < FEWER * knee.orders_per_hour.mean
}

/// Whether a number of robots carries less than that of the knee beyond chance: all of its interval
/// is below all of that of the knee.
fn is_less(point: &PointAnswer, knee: &KneeAnswer) -> bool {
    let Some(orders) = &point.orders_per_hour else { return false };
    let [half_width, of_knee] = [orders, &knee.orders_per_hour]
        .map(|interval| interval.half_width.unwrap_or(f64::INFINITY));
    orders.mean + half_width < knee.orders_per_hour.mean - of_knee
}

/// The answer if the largest number of robots carries the most.
fn of_open_end(
    variant: &VariantAnswer,
    count: &str,
    throughput: &str,
    knee: &KneeAnswer,
) -> String {
    let robots = knee.robots;
    let orders = with_interval(&knee.orders_per_hour);
    let without_room = variant.no_room.iter().find(|no_room| no_room.robots > robots);
    let failed = variant.failed.iter().find(|(more, _)| *more > robots);
    match (without_room, failed) {
        (Some(NoRoom { robots: more, reason, .. }), None) => {
            let reason = format!("With {}, {NOT_ALL_PLACED}: {reason}", robots_in_words(*more));
            limited(count, throughput, &reason, between(robots, *more))
        }
        (_, Some((more, reason))) => {
            let reason = format!("With {}, a run failed: {reason}", robots_in_words(*more));
            limited(count, throughput, &reason, between(robots, *more))
        }
        _ if variant.points.len() == 1 && variant.failed.is_empty() => {
            format!("{count} {throughput}. No other number of robots was tried.")
        }
        _ if variant.points.len() == 1 => {
            format!("{count} {throughput}. All runs with other numbers of robots failed.")
        }
        _ => format!(
            "the plant holds at least {count}, the largest number tried and the one that carries the \
             most: {orders} orders an hour."
        ),
    }
}

/// The answer if a larger number can't be tried. `untried` tells the numbers between the two.
fn limited(count: &str, throughput: &str, reason: &str, untried: Option<String>) -> String {
    match untried {
        None => format!("the plant holds {count}, which {throughput}. {reason}."),
        Some(untried) => {
            format!("the plant holds at least {count}, which {throughput}. {reason}; {untried}.")
        }
    }
}

/// The least number of robots that stalled in a run.
fn least_stalled(variant: &VariantAnswer) -> Option<&PointAnswer> {
    variant.points.iter().find(|point| point.stalled().next().is_some())
}

/// Returns the throughput of a number of robots with half of its interval, or says that it isn't
/// known; `None` if there is none.
pub(super) fn orders_in_words(point: &PointAnswer) -> Option<String> {
    let interval = point.orders_per_hour?;
    if has_too_few(point) {
        return Some(NOT_KNOWN.to_owned());
    }
    let value = with_interval(&interval);
    // A single run doesn't tell how far others are from it.
    Some(match interval.half_width {
        Some(_) => value,
        None => format!("{NOT_KNOWN} ({value})"),
    })
}

/// Whether a number of robots finished too few orders for a figure, or all of them in the warm-ups,
/// so that its throughput isn't known.
pub(super) fn has_too_few(point: &PointAnswer) -> bool {
    let is_zero = point.orders_per_hour.is_some_and(|orders| orders.mean == 0.0);
    point.finished_orders > 0 && (is_zero || point.has_too_few_orders())
}

/// Returns a throughput with half of its interval, if it is known.
fn with_interval(interval: &Interval) -> String {
    orders_an_hour(interval, Kind::Estimate)
}

fn orders_an_hour(interval: &Interval, kind: Kind) -> String {
    let decimals = if interval.mean < 100.0 { 1 } else { 0 };
    in_words(interval, kind, "", |value| grouped(value, decimals))
}

#[cfg(test)]
mod tests;
