//! The restrictions of an answer: what took no part, runs that failed or don't count, orders that
//! were late, and what the validator found.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::verdict::prefix;
use crate::answer::{Answer, BUSY, PointAnswer, StorageLack, VariantAnswer};
use crate::outcome::{CHARGING, CONTACT};
use crate::plan::robots_in_words;
use crate::sweep::Trend;

/// The largest number of stalls of a variant that are told; `study.json` has all.
const MOST_STALLS: usize = 4;
/// The largest number of numbers of robots whose late orders are told.
const MOST_NUMBERS: usize = 4;

/// The orders that may be open at the end of a run: some, and some of each robot.
const MANY_OPEN: f64 = 10.0;
const MANY_OPEN_PER_ROBOT: f64 = 2.0;
/// The part of the orders that come in a run that may have just come at its end.
const FEW_OPEN: f64 = 0.1;
/// The part of the time from which on charging keeps robots from orders.
const MUCH_CHARGING: f64 = 0.1;

/// The restrictions of the answer: stations that took no part, runs that stalled, and orders that
/// waited for long.
pub(super) fn caveats(answer: &Answer) -> Vec<String> {
    let mut caveats = Vec::new();
    for variant in &answer.variants {
        let name = prefix(variant);
        if !variant.assumptions.is_empty() {
            let assumed = variant.assumptions.join("; ");
            caveats.push(format!("{name}**Assumed about the layout**: {assumed}."));
        }
        for part in &variant.left_out {
            caveats.push(format!("{name}**Left out**: {part}."));
        }
        if let Some(reason) = &variant.other_stops {
            caveats.push(format!("{name}**Other stops**: {reason}."));
        }
        caveats.extend(failures(variant).map(|failures| format!("{name}{failures}")));
        caveats.extend(backlog(variant).map(|backlog| format!("{name}{backlog}")));
        caveats.extend(storages(variant).into_iter().map(|storage| format!("{name}{storage}")));
        caveats.extend(enough(variant).map(|enough| format!("{name}{enough}")));
        caveats.extend(stalls(variant).map(|stalls| format!("{name}{stalls}")));
        caveats.extend(late_orders(variant).map(|late| format!("{name}{late}")));
    }
    caveats
}

/// Tells the runs that failed, those of the fewest robots first.
fn failures(variant: &VariantAnswer) -> Option<String> {
    let (_, reason) = variant.failed.first()?;
    let robots: Vec<String> =
        variant.failed.iter().take(MOST_NUMBERS).map(|(robots, _)| robots.to_string()).collect();
    let (robots, noun) = match (&robots[..], variant.failed.len()) {
        ([only], _) => (only.clone(), if only == "1" { "robot" } else { "robots" }),
        (_, failed) if failed > robots.len() => (robots.join(", ") + " and more", "robots"),
        _ => (robots.join(", "), "robots"),
    };
    Some(format!(
        "**Failed runs**: with {robots} {noun}, runs failed, the first one because: {reason}. The \
         answer leaves such runs out."
    ))
}

/// Tells the orders that were late in the runs that count, by number of robots.
fn late_orders(variant: &VariantAnswer) -> Option<String> {
    // Fleets that are too small for the targets were run on purpose.
    let chosen = variant.least.as_ref().map(|least| least.robots);
    let told =
        variant.points.iter().filter(|point| chosen.is_none_or(|it| it == Some(point.robots)));
    let late = told.map(|point| (point.robots, late_in_runs_that_count(point)));
    let late: Vec<(u32, u64)> = late.filter(|(_, orders)| *orders > 0).collect();
    let told = late.iter().take(MOST_NUMBERS).map(|(robots, orders)| {
        let noun = if *orders == 1 { "order" } else { "orders" };
        format!("with {}, {orders} {noun}", robots_in_words(*robots))
    });
    let more = match late.len().saturating_sub(MOST_NUMBERS) {
        0 => "",
        _ => "; more with other numbers (`study.json`)",
    };
    let told: Vec<String> = told.collect();
    (!told.is_empty()).then(|| {
        format!(
            "**Late orders** waited for over 20 minutes, or weren't finished in that time: \
             {}{more}.",
            told.join("; ")
        )
    })
}

fn late_in_runs_that_count(point: &PointAnswer) -> u64 {
    let runs = point.runs.iter().filter(|run| run.stalls.is_empty());
    runs.map(|run| run.unserved).sum()
}

/// Tells that many orders are open at the end of a run, or ever more, and why.
fn backlog(variant: &VariantAnswer) -> Option<String> {
    let point = variant.points.last()?;
    let open = point.open_orders?.mean;
    let many = MANY_OPEN + MANY_OPEN_PER_ROBOT * f64::from(point.robots);
    let is_behind = matches!(point.backlog, Trend::Saturated | Trend::Growing(_));
    if variant.is_load_endless || (open <= many && !is_behind) {
        return None;
    }
    let robots = robots_in_words(point.robots);
    let mut reasons = Vec::new();
    match point.backlog {
        _ if point.stuck_orders.are_most_of(open) => {}
        Trend::Growing(_) => {
            reasons.push("they came faster than the robots carried them".to_owned())
        }
        Trend::Saturated => {
            reasons.push("they came as fast as the robots carried them, or faster".to_owned());
        }
        Trend::Steady | Trend::Unclear => reasons.push(
            "a longer --duration tells whether they came faster than the robots carried them, or \
             just before the end"
                .to_owned(),
        ),
    }
    reasons.extend(point.stuck_orders.in_words().map(|stuck| format!("of them, {stuck}")));
    let reason = reasons.join("; ");
    let open = match open.round() {
        1.0 => "1 order was".to_owned(),
        open => format!("{open:.0} orders were"),
    };
    Some(format!(
        "**Backlog**: with {robots}, {open} open at the end of a run on average: {reason}."
    ))
}

/// Tells the storages for which orders waited at the end of runs with the most robots.
fn storages(variant: &VariantAnswer) -> Vec<String> {
    let Some(point) = variant.points.last() else { return Vec::new() };
    let robots = robots_in_words(point.robots);
    let told = point.storages.iter().map(|storage| {
        let StorageLack { name, runs, orders, is_full, .. } = storage;
        let (state, thing) = if *is_full { ("full", "a free place") } else { ("empty", "a load") };
        let orders = match orders.round() {
            1.0 => "1 order".to_owned(),
            orders => format!("{orders:.0} orders"),
        };
        format!(
            "**Storage {state}**: with {robots}, {orders} waited for {thing} in the storage of \
             {name} at the end of {runs} of {} runs.",
            point.runs.len(),
        )
    });
    told.collect()
}

/// Tells why the robots of the knee carry no more: the load, if they carry all orders that come; or
/// why they are often without an order though orders wait.
fn enough(variant: &VariantAnswer) -> Option<String> {
    let knee = variant.knee.as_ref()?;
    let point = variant.points.iter().find(|point| point.robots == knee.robots)?;
    let busy = point.utilisation?.mean;
    if variant.is_load_endless {
        return None;
    }
    let is_busy = busy >= BUSY;
    let (robots, busy) = (robots_in_words(point.robots), busy * 100.0);
    if carries_all(point, if is_busy { 0.0 } else { FEW_OPEN }) {
        return Some(format!(
            "**The load is the limit**: {robots} had an order {busy:.0} % of the time. The answer \
             is the load that came, not what they can carry."
        ));
    }
    if is_busy {
        return None;
    }
    let open = point.open_orders.map_or(0.0, |open| open.mean);
    let mut parts = point.robot_time.iter();
    let charging = parts.find(|part| part.name == CHARGING).map_or(0.0, |part| part.value.mean);
    Some(match charging >= MUCH_CHARGING {
        true => format!(
            "**Charging is the limit**: {robots} had an order {busy:.0} % of the time and charged \
             {:.0} % of it, and {open:.0} orders were open at the end of a run on average.",
            charging * 100.0
        ),
        false => format!(
            "**Orders waited**: {robots} had an order only {busy:.0} % of the time, although \
             orders waited; {open:.0} were open at the end of a run on average. 'What robots spend \
             their time on' shows the rest of it."
        ),
    })
}

/// Whether a number of robots carries nearly all orders that come: no more are open at the end than
/// the robots carry then and a part of all that have just come, and none waited for long.
fn carries_all(point: &PointAnswer, just_come: f64) -> bool {
    let runs = point.runs.len() as f64;
    let open = point.open_orders.map_or(0.0, |open| open.mean);
    let carried = point.utilisation.map_or(0.0, |busy| busy.mean) * f64::from(point.robots);
    let came = (point.finished_orders + point.failed_orders) as f64 / runs + open;
    point.unserved == 0 && open <= carried + just_come * came
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

/// The contacts and other findings of the validator, and the manager under which they came about.
pub(super) fn safety(answer: &Answer) -> String {
    let contacts: u64 = answer.variants.iter().map(|variant| variant.contacts).sum();
    let runs = runs_of(answer, |variant| !variant.is_bound);
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
    let managed = match answer.variants.iter().any(|variant| variant.is_managed_by_regatta) {
        true => {
            " Regatta's fleet manager steered the robots: with another one, they may carry more."
        }
        false => "",
    };
    let bound = match runs_of(answer, |variant| variant.is_bound) {
        0 => String::new(),
        runs => {
            format!(" The {runs} runs of the bound aren't judged: robots pass through each other.")
        }
    };
    match contacts {
        0 => format!(
            "No robot touched another in {runs} runs, as an independent validator judged them; \
             {others}.{bound}{managed}"
        ),
        count => format!(
            "**Robots touched each other {count} times** in {runs} runs{}; \
             {others}.{bound}{managed}",
            first_finding(answer, CONTACT)
        ),
    }
}

/// Returns the number of runs of some variants.
fn runs_of(answer: &Answer, is_wanted: impl Fn(&VariantAnswer) -> bool) -> usize {
    let variants = answer.variants.iter().filter(|variant| is_wanted(variant));
    variants.flat_map(|variant| &variant.points).map(|point| point.runs.len()).sum()
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
