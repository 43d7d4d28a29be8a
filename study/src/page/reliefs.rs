//! The reliefs on the page: those that were tried, and what they bring.

use super::Block;
use crate::answer::Answer;
use crate::plan::robots_in_words;
use crate::relief::{Measure, Relief, Reliefs, Verdict};
use crate::statistics::Interval;

/// The most other candidates that are named.
const NAMED: usize = 5;

/// Returns the blocks of the reliefs; none if none were asked for.
pub(super) fn reliefs(answer: &Answer, of: &str) -> Vec<Block> {
    let Some(reliefs) = &answer.chosen.reliefs else { return Vec::new() };
    let heading = format!("{of}What would help, with {}", robots_in_words(reliefs.robots));
    let mut blocks = vec![Block::Heading(2, heading), Block::Text(finding(reliefs))];
    if !reliefs.tried.is_empty() {
        let gain = format!("{}, in place of {}", reliefs.figure, figure(reliefs, reliefs.base));
        let head = ["", "change", "time that it is about", "robots", &gain, "seeds"];
        let mut rows = vec![head.map(str::to_owned).to_vec()];
        for (relief, rank) in reliefs.tried.iter().zip(1..) {
            rows.push(row(reliefs, relief, rank));
        }
        blocks.push(Block::Table(rows));
    }
    blocks.extend(others(reliefs));
    blocks
}

/// Returns the best relief as a finding for the head of the page, or that none helps, if any was
/// tried.
pub(super) fn headline(answer: &Answer, of: &str) -> Option<Block> {
    let reliefs = answer.chosen.reliefs.as_ref()?;
    let Some(best) = reliefs.best() else {
        let none = (!reliefs.tried.is_empty()).then(|| finding(reliefs));
        return none.map(|none| Block::Finding(format!("{of}{none}")));
    };
    let gain = gain_in_words(reliefs, &best.gain?);
    Some(Block::Finding(format!("{of}The most helpful change: {}: {gain}.", best.candidate.words)))
}

/// Returns the finding in a sentence.
fn finding(reliefs: &Reliefs) -> String {
    let count = reliefs.tried.len();
    let Some(best) = reliefs.best() else {
        return match count {
            0 => "Nothing was tried: no part of the time suggests a change.".to_owned(),
            1 => "The one change that was tried doesn't help.".to_owned(),
            _ => format!("None of the {count} changes that were tried helps."),
        };
    };
    let words = &best.candidate.words;
    let gain = best.gain.map(|gain| gain_in_words(reliefs, &gain)).unwrap_or_default();
    let rank = match count {
        1 => "It is the only change that was tried".to_owned(),
        _ => format!("It is the best of the {count} changes that were tried"),
    };
    format!("**{words}**: {gain}. {rank}.")
}

fn row(reliefs: &Reliefs, relief: &Relief, rank: usize) -> Vec<String> {
    let Relief { candidate, gain, verdict, has_left, failure } = relief;
    let gain_text = gain.map(|gain| gain_in_words(reliefs, &gain)).unwrap_or_default();
    let brings = match (verdict, failure) {
        (_, Some(failure)) => format!("not known: a run failed: {failure}"),
        (Verdict::NotKnown, None) => "not known: no run has a figure".to_owned(),
        (Verdict::Stalls, None) => "none: robots made no progress, or a day had no end".to_owned(),
        (Verdict::WithinChance, None) if gain_text == "no difference" => gain_text,
        (Verdict::WithinChance, None) => format!("{gain_text}, within chance"),
        (Verdict::Harms, None) => format!("{gain_text}: worse"),
        (Verdict::Helps, None) => gain_text,
    };
    let seeds = gain.map_or(0, |gain| gain.values);
    vec![
        rank.to_string(),
        candidate.words.clone(),
        candidate.about.to_owned(),
        format!("{:.2}", candidate.robots),
        brings,
        format!("{seeds}{}", if *has_left { ", left" } else { "" }),
    ]
}

/// Returns a gain as the change of the figure.
fn gain_in_words(reliefs: &Reliefs, gain: &Interval) -> String {
    let (unit, factor) = reliefs.measure.unit();
    if gain.mean == 0.0 && gain.half_width == Some(0.0) {
        return "no difference".to_owned();
    }
    let change = reliefs.measure.sign() * gain.mean * factor;
    let places = if change.abs() < 10.0 { 1 } else { 0 };
    let half = gain.half_width.map(|half| format!(" ± {:.places$}", half * factor));
    let part = match reliefs.measure {
        Measure::Target(_) if factor != 1.0 => String::new(),
        _ if reliefs.base == 0.0 => String::new(),
        _ => {
            let percent = 100.0 * reliefs.measure.sign() * gain.mean / reliefs.base;
            format!(" ({percent:+.1} %)")
        }
    };
    format!("{change:+.places$}{} {unit}{part}", half.unwrap_or_default())
}

/// Returns a value of the figure with its unit.
fn figure(reliefs: &Reliefs, value: f64) -> String {
    match reliefs.measure {
        Measure::Throughput => format!("{value:.0}"),
        Measure::Service => format!("{value:.0} s"),
        Measure::Target(target) => {
            target.in_words(&Interval { mean: value, half_width: None, values: 1 })
        }
    }
}

/// Names other candidates.
fn others(reliefs: &Reliefs) -> Option<Block> {
    let names: Vec<&str> =
        reliefs.others.iter().take(NAMED).map(|candidate| &*candidate.words).collect();
    if names.is_empty() {
        return None;
    }
    let more = match reliefs.others.len().saturating_sub(NAMED) {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    Some(Block::Text(format!(
        "Not tried, as `--reliefs` asks for {}: {}{more}.",
        reliefs.tried.len(),
        names.join("; ")
    )))
}
