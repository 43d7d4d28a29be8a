//! The first sentences of the page: the answer, and what restricts it.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::Block;
use super::least::of_least;
use crate::answer::{Answer, KneeAnswer, PointAnswer, VariantAnswer};
use crate::outcome::CONTACT;
use crate::plan::robots_in_words;
use crate::statistics::Interval;

/// The least orders of a busy robot in a run for a throughput: with fewer, those that are under
/// way at the beginning and at the end count too much.
const LEAST_ORDERS: f64 = 3.0;
/// The part of the knee's throughput below which more robots carry clearly less.
const FEWER: f64 = 0.8;
/// The part of the time with an order from which on robots are busy.
const BUSY: f64 = 0.8;
/// The largest number of stalls of a variant that are told; `study.json` has all.
const MOST_STALLS: usize = 4;

/// The answer for a variant, in one sentence or two.
pub(super) fn verdict(answer: &Answer, variant: &VariantAnswer) -> String {
    let name = prefix(variant);
    match (&variant.least, &variant.knee) {
        (Some(least), _) => format!("{name}{}", of_least(variant, least)),
        (None, Some(knee)) => format!("{name}{}", of_knee(answer, variant, knee)),
        (None, None) => {
            format!("{name}{}", without_knee(variant, answer.method.secs as f64 / 60.0))
        }
    }
}

/// The name of a variant as the beginning of a sentence; empty if there are no others.
fn prefix(variant: &VariantAnswer) -> String {
    if variant.name.is_empty() { String::new() } else { format!("{}: ", variant.name) }
}

fn without_knee(variant: &VariantAnswer, minutes: f64) -> String {
    if let Some(reason) = variant.failure() {
        return format!("no run has succeeded: {reason}.");
    }
    match least_stalled(variant) {
        Some(robots) => format!(
            "not known: robots stopped making progress already with {}, so that no number of \
             robots that was tried is an answer.",
            robots_in_words(robots)
        ),
        None => match variant.points.iter().map(|point| point.finished_orders).sum::<u64>() {
            0 => format!(
                "nothing was carried: no order was finished in {minutes:.0} minutes. If one takes \
                 longer, give a longer --duration."
            ),
            orders => format!(
                "not known: {orders} orders were finished at the beginning of the runs, and none \
                 later. The findings below tell what stopped the robots."
            ),
        },
    }
}

/// Returns the reason why a number of robots has finished too few orders for an answer: robots
/// that were busy all the time, and have finished less than some orders each.
fn too_few_orders(point: &PointAnswer) -> Option<String> {
    let orders = point.finished_orders as f64 / point.runs.len() as f64;
    let is_busy = point.utilisation.is_some_and(|part| part.mean > BUSY);
    let is_few = orders < LEAST_ORDERS * f64::from(point.robots);
    (is_busy && is_few).then(|| {
        format!(
            "{} finished {orders:.1} orders in a run, too few for a figure. Give a longer \
             --duration.",
            robots_in_words(point.robots)
        )
    })
}

fn of_knee(answer: &Answer, variant: &VariantAnswer, knee: &KneeAnswer) -> String {
    let KneeAnswer { robots, orders_per_hour, half, is_open, stalls_from, .. } = knee;
    let point = variant.points.iter().find(|point| point.robots == *robots);
    if let Some(reason) = point.and_then(too_few_orders) {
        return format!("not known: {reason}");
    }
    let count = robots_in_words(*robots);
    let carries = if *robots == 1 { "carries" } else { "carry" };
    if !is_known(orders_per_hour) {
        let seeds = match orders_per_hour.values {
            1 => "one seed".to_owned(),
            seeds => format!("{seeds} seeds"),
        };
        let some = with_interval(orders_per_hour);
        let without_room = variant.no_room.iter().find(|(without, _)| without == robots);
        return match without_room {
            Some((_, reason)) => format!(
                "not known: {count} {carries} {some} orders an hour with {seeds}; with \
                 others, there is no room for {count}: {reason}."
            ),
            None => format!(
                "not known: {count} {carries} {some} orders an hour, which is no more precise \
                 with {seeds}. Give a longer --duration or more --seeds."
            ),
        };
    }
    let throughput = format!("{carries} {} orders an hour", with_interval(orders_per_hour));
    if let Some(stalls_from) = stalls_from {
        let stalls_from = robots_in_words(*stalls_from);
        return format!(
            "{count}, which {throughput}. With {stalls_from}, robots stop making progress: no \
             larger fleet is an answer."
        );
    }
    if *is_open {
        return of_open_end(variant, &count, &throughput, *robots);
    }
    if let Some(fewer) = variant.points.iter().find(|point| carries_fewer(point, knee)) {
        let more = robots_in_words(fewer.robots);
        let orders = fewer.orders_per_hour.map_or(0.0, |interval| interval.mean);
        return format!(
            "{count}, which {throughput}. More carry less, as they are in each other's way: with \
             {more}, {orders:.0} orders an hour."
        );
    }
    let part = answer.method.knee * 100.0;
    // Below the first number that was tried nothing is known.
    let is_half_known = half < robots && variant.points.first().is_some_and(|p| p.robots < *half);
    let half = match is_half_known {
        true => format!(" Up to {half}, each more brings at least half of that."),
        false => String::new(),
    };
    format!(
        "{count}, which {throughput}. More bring less than {part:.0} % each of what one brings \
         alone.{half}"
    )
}

/// Returns the table of the numbers that a planner uses: up to which each further robot still
/// brings much of what the first one brings, and which carries the most.
pub(super) fn numbers(variant: &VariantAnswer) -> Option<Block> {
    let KneeAnswer { most_of, half, most, .. } = variant.knee.as_ref()?;
    let least = variant.points.first()?.robots;
    let mut rows = vec![["robots", "orders an hour", ""].map(str::to_owned).to_vec()];
    for (robots, part) in [(*most_of, 90), (*half, 50)] {
        // Below the first number that was tried nothing is known.
        if robots > least || robots == 1 {
            let rule = format!(
                "up to this number, each further robot brings at least {part} % of what the first \
                 brings"
            );
            rows.push(number(variant, robots, rule));
        }
    }
    rows.push(number(variant, *most, "the most of all numbers that were tried".to_owned()));
    Some(Block::Table(rows))
}

fn number(variant: &VariantAnswer, robots: u32, rule: String) -> Vec<String> {
    let point = variant.points.iter().find(|point| point.robots == robots);
    let orders = point.and_then(|point| point.orders_per_hour);
    vec![robots.to_string(), orders.map_or_else(String::new, |o| orders_in_words(&o)), rule]
}

/// Whether more robots than those of the knee carry clearly less.
fn carries_fewer(point: &PointAnswer, knee: &KneeAnswer) -> bool {
    let orders = point.orders_per_hour.map_or(0.0, |interval| interval.mean);
    point.robots > knee.robots && orders < FEWER * knee.orders_per_hour.mean
}

/// The answer if the largest number of robots carries the most.
fn of_open_end(variant: &VariantAnswer, count: &str, throughput: &str, robots: u32) -> String {
    let without_answer = variant.no_room.iter().chain(&variant.failed);
    match without_answer.filter(|(more, _)| *more > robots).min_by_key(|(more, _)| *more) {
        Some((more, reason)) => {
            let more = robots_in_words(*more);
            format!("{count}, which {throughput}. With {more}, runs fail: {reason}.")
        }
        None if variant.points.len() == 1 => {
            format!("{count} {throughput}. No other number of robots was tried.")
        }
        None => format!(
            "at least {count}: no larger number was tried, and of those that were, {count} \
             {throughput}, the most."
        ),
    }
}

/// Whether half of an interval's width is less than its value.
fn is_known(interval: &Interval) -> bool {
    interval.half_width.is_some_and(|half_width| half_width < interval.mean)
}

/// The least number of robots that stalled in a run.
fn least_stalled(variant: &VariantAnswer) -> Option<u32> {
    let stalled = variant.points.iter().find(|point| point.stalled().next().is_some());
    stalled.map(|point| point.robots)
}

/// The restrictions of the answer: stations that took no part, runs that stalled, and orders that
/// waited for long.
pub(super) fn caveats(answer: &Answer) -> Vec<String> {
    let mut caveats = Vec::new();
    for variant in &answer.variants {
        let name = prefix(variant);
        for part in &variant.left_out {
            caveats.push(format!("{name}**Left out**: {part}."));
        }
        if let Some(reason) = &variant.other_stops {
            caveats.push(format!("{name}**Other stops**: {reason}."));
        }
        caveats.extend(failures(variant).map(|failures| format!("{name}{failures}")));
        caveats.extend(backlog(variant).map(|backlog| format!("{name}{backlog}")));
        caveats.extend(enough(variant).map(|enough| format!("{name}{enough}")));
        caveats.extend(stalls(variant).map(|stalls| format!("{name}{stalls}")));
        // Fleets that are too small for the targets were run on purpose.
        if variant.unserved > 0 && variant.least.is_none() {
            caveats.push(format!(
                "{name}**Late orders**: {} orders waited for over 20 minutes, or weren't finished \
                 in that time.",
                variant.unserved
            ));
        }
    }
    caveats
}

/// Tells the runs that failed, those of the fewest robots first.
fn failures(variant: &VariantAnswer) -> Option<String> {
    let (robots, reason) = variant.failed.first()?;
    let robots = robots_in_words(*robots);
    Some(format!(
        "**Failed runs**: with {robots}, a run failed: {reason}. The answer is without such runs."
    ))
}

/// Tells that orders come faster than robots carry them.
fn backlog(variant: &VariantAnswer) -> Option<String> {
    let point = variant.points.last()?;
    let open = point.open_orders?.mean;
    if variant.is_load_endless || open <= 2.0 * f64::from(point.robots) + 10.0 {
        return None;
    }
    let robots = robots_in_words(point.robots);
    Some(format!(
        "**Backlog**: with {robots}, {open:.0} orders were open at the end of a run: orders come \
         faster than they are carried."
    ))
}

/// Tells that the robots of the knee carry all orders that come, so that more can't carry more.
fn enough(variant: &VariantAnswer) -> Option<String> {
    let knee = variant.knee.as_ref()?;
    let point = variant.points.iter().find(|point| point.robots == knee.robots)?;
    let is_idle = point.utilisation.is_some_and(|part| part.mean < BUSY);
    if variant.is_load_endless || !is_idle {
        return None;
    }
    Some(format!(
        "**The load is the limit**: {} had an order {:.0} % of the time. The answer is what came, \
         not what they can carry.",
        robots_in_words(point.robots),
        point.utilisation?.mean * 100.0
    ))
}

/// Tells the stalls of a variant, those of the fewest robots first.
fn stalls(variant: &VariantAnswer) -> Option<String> {
    let runs: usize = variant.points.iter().map(|point| point.runs.len()).sum();
    let stalled: usize = variant.points.iter().map(|point| point.stalled().count()).sum();
    if stalled == 0 {
        return None;
    }
    let mut text = format!(
        "**No progress** in {stalled} of {runs} runs, which don't count for the answer; robots are \
         named by their ids."
    );
    let mut told = 0;
    for point in &variant.points {
        for run in point.stalled().take(MOST_STALLS - told) {
            let Some(stall) = run.stalls.first() else { continue };
            let robots = robots_in_words(point.robots);
            // Writing to a `String` never fails.
            let _ = write!(text, " With {robots}, seed {}: {stall}.", run.seed);
            told += 1;
        }
    }
    match stalled - told {
        0 => Some(text),
        more => Some(format!("{text} And in {more} more runs: `study.json` has all.")),
    }
}

/// Whether the validator found contacts, or anything else beside stalls and unserved orders.
pub(super) fn has_findings(answer: &Answer) -> bool {
    answer.variants.iter().any(|variant| variant.contacts > 0 || !variant.other_findings.is_empty())
}

/// The contacts and other findings of the validator.
pub(super) fn safety(answer: &Answer) -> String {
    let contacts: u64 = answer.variants.iter().map(|variant| variant.contacts).sum();
    let points = answer.variants.iter().flat_map(|variant| &variant.points);
    let runs: usize = points.map(|point| point.runs.len()).sum();
    let mut others: BTreeMap<&str, u64> = BTreeMap::new();
    for (kind, count) in answer.variants.iter().flat_map(|variant| &variant.other_findings) {
        *others.entry(kind).or_default() += count;
    }
    let others: Vec<String> = others
        .iter()
        .map(|(kind, count)| format!("{kind} {count}{}", first_finding(answer, kind)))
        .collect();
    let others = match others.is_empty() {
        true => "no other findings".to_owned(),
        false => format!("**other findings**: {}", others.join("; ")),
    };
    match contacts {
        0 => format!(
            "No robot touched another in {runs} runs, as an independent validator judged them; \
             {others}."
        ),
        count => format!(
            "**Robots touched each other {count} times** in {runs} runs{}; {others}.",
            first_finding(answer, CONTACT)
        ),
    }
}

/// Tells the first finding of a kind: run, robots and time, in parentheses. Empty if no run has an
/// example.
fn first_finding(answer: &Answer, kind: &str) -> String {
    for variant in &answer.variants {
        for point in &variant.points {
            for run in &point.runs {
                if let Some(example) = run.examples.get(kind) {
                    let (name, robots) = (prefix(variant), robots_in_words(point.robots));
                    return format!(" (first: {name}{robots}, seed {}: {example})", run.seed);
                }
            }
        }
    }
    String::new()
}

/// Returns a mean with half of its interval, or says that it isn't known.
pub(super) fn orders_in_words(interval: &Interval) -> String {
    let value = with_interval(interval);
    // A fleet that carries nothing in every run carries nothing.
    if is_known(interval) || interval.relative() == Some(0.0) {
        value
    } else {
        format!("not known ({value})")
    }
}

/// Returns a mean with half of its interval.
fn with_interval(interval: &Interval) -> String {
    let Interval { mean, half_width, .. } = interval;
    let decimals = if *mean < 100.0 { 1 } else { 0 };
    match half_width {
        Some(half_width) => format!("{mean:.decimals$} ± {half_width:.decimals$}"),
        None => format!("{mean:.decimals$}"),
    }
}
