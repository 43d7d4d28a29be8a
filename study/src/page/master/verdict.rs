//! The answer of a study of a master in words.

use super::vehicles_in_words;
use crate::master::{Fault, MasterAnswer, MasterPoint, Stuck, Verdict};

/// The bases from which on the 99th percentile isn't the longest time.
const ENOUGH: u64 = 100;
/// The faults that the answer names.
const NAMED: usize = 2;

/// Returns the answer.
pub(super) fn verdict(answer: &MasterAnswer) -> String {
    let fails = answer.fails.and_then(|fails| Some((fails, answer.point(Some(fails))?)));
    match (answer.copes, fails) {
        (Some(copes), Some((fails, point))) => format!(
            "The master copes with **{}** on this layout; {}, {}.",
            vehicles_in_words(copes),
            from(answer, fails),
            worst(point),
        ),
        (Some(copes), None) => format!(
            "The master copes with **{}** on this layout, {}.",
            vehicles_in_words(copes),
            limit(answer)
        ),
        (None, Some((fails, point))) => format!(
            "The master **doesn't cope** with {} on this layout, the least that was tried: {}.",
            vehicles_in_words(fails),
            worst(point),
        ),
        (None, None) => format!("**Not known**: {}.", reason(answer)),
    }
}

/// The worst faults of a point.
fn worst(point: &MasterPoint) -> String {
    faults_in_words(&point.faults[..point.faults.len().min(NAMED)])
}

/// The numbers that the faults are about: all from the first one on, unless it copes with a larger
/// one.
fn from(answer: &MasterAnswer, fails: u32) -> String {
    let mut larger = answer.points.iter().filter(|point| point.vehicles > fails);
    match larger.all(|point| point.verdict == Verdict::Fails) {
        true => format!("from {fails} on"),
        false => format!("with {fails}"),
    }
}

/// The reason why no larger number is in the answer.
fn limit(answer: &MasterAnswer) -> String {
    let unknown =
        answer.points.iter().find_map(|point| Some((point.vehicles, point.failure.as_ref()?)));
    match unknown {
        Some((vehicles, failure)) => {
            let failure = failure.trim_end_matches('.');
            format!("and nothing is known about larger numbers: with {vehicles}, {failure}")
        }
        None => "the most that were tried".to_owned(),
    }
}

fn reason(answer: &MasterAnswer) -> String {
    let failure = answer.points.iter().find_map(|point| point.failure.clone());
    let failure = failure.unwrap_or_else(|| "no run has ended".to_owned());
    failure.trim_end_matches('.').to_owned()
}

/// Returns faults in words, as parts of a sentence.
pub(super) fn faults_in_words(faults: &[Fault]) -> String {
    let words: Vec<String> = faults.iter().map(in_words).collect();
    words.join("; ")
}

fn in_words(fault: &Fault) -> String {
    match fault {
        Fault::Contacts { count, first } => {
            let first =
                first.as_ref().map_or_else(String::new, |first| format!(" (first {first})"));
            format!("vehicles touch {}{first}", times(*count))
        }
        Fault::HeadOn { count, first } => {
            format!("the master lets orders meet head-on {} ({first})", times(*count))
        }
        Fault::LateBases { p99_secs, node, late: [there, all] } => {
            let most = if there == all {
                String::new()
            } else {
                format!(" and others ({there} of {all} late ones there)")
            };
            format!("bases come {p99_secs:.1} s late at node `{node}`{most}")
        }
        Fault::Stuck { count, longest: Stuck { vehicle, node, next_node, secs } } => {
            let next = next_node.as_ref().map_or_else(String::new, |next| format!(" to `{next}`"));
            let who = if *count == 1 {
                "a vehicle stands".to_owned()
            } else {
                format!("{count} vehicles stand")
            };
            format!(
                "{who} at the end without a base (vehicle {vehicle} for {secs:.0} s at `{node}`, \
                 on its way{next})"
            )
        }
        Fault::NeverOrdered { count } => {
            format!(
                "{} never got an order, though there was one for each",
                vehicles_in_words(u32::try_from(*count).unwrap_or(u32::MAX))
            )
        }
    }
}

fn times(count: u64) -> String {
    if count == 1 { "once".to_owned() } else { format!("{count} times") }
}

/// Returns the restrictions of the answer.
pub(super) fn caveats(answer: &MasterAnswer) -> Vec<String> {
    let mut caveats = Vec::new();
    if answer.is_interrupted {
        caveats.push(
            "**Interrupted**: the study was stopped early; this is what was measured until then."
                .to_owned(),
        );
    }
    if answer.points.iter().any(|point| !point.runs.is_empty()) {
        let runs = match answer.repeats {
            1 => "one run".to_owned(),
            repeats => format!("{repeats} runs"),
        };
        caveats.push(format!(
            "**In real time**: figures are times of this machine, broker and network, of {runs} of {} \
             s each for a number of vehicles.",
            answer.secs
        ));
    }
    let bases: u64 = answer.points.iter().map(bases).sum();
    if bases == 0 && answer.copes.is_some() {
        caveats.push(
            "**No bases**: the master released all of each order at once, so that no vehicle asked \
             for a base, and the time that it takes for one isn't known."
                .to_owned(),
        );
    }
    caveats.extend(few_bases(answer));
    let without =
        |point: &&MasterPoint| !point.runs.is_empty() && point.sum(|run| run.finished_orders) == 0;
    if let Some(point) = answer.points.iter().find(without) {
        caveats.push(format!(
            "**No transports**: with {}, none was finished in {} s, so that nothing is known about \
             throughput there; give a longer `--duration`, and let the master send the actions \
             `pick` and `drop`.",
            vehicles_in_words(point.vehicles),
            answer.secs
        ));
    }
    let by_master =
        answer.points.iter().flat_map(|point| &point.runs).flat_map(|run| &run.breaches);
    let errors: u64 = by_master
        .filter(|breach| breach.side == "master" && breach.severity == "error")
        .map(|breach| breach.count)
        .sum();
    if errors > 0 {
        caveats.push(format!(
            "**Breaches of the standard**: the master broke VDA 5050 {}; they are listed below.",
            times(errors)
        ));
    }
    caveats.extend(answer.left_out.iter().map(|part| format!("**Left out**: {part}.")));
    caveats
}

/// Tells that the percentiles of the answer are those of few times.
fn few_bases(answer: &MasterAnswer) -> Option<String> {
    let point = answer.point(answer.copes)?;
    let bases = point.sum(|run| run.response.map_or(0, |times| times.count as u64));
    (1..ENOUGH).contains(&bases).then(|| {
        format!(
            "**Few bases**: with {}, the master's own times are those of {bases} bases, so that 99 \
             of 100 means all of them; a longer `--duration` gives more.",
            vehicles_in_words(point.vehicles)
        )
    })
}

fn bases(point: &MasterPoint) -> u64 {
    point.sum(|run| run.bases.map_or(0, |times| times.count as u64) + run.late)
}
