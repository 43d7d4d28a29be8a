//! The summary that is printed at the end of a run.

use std::fmt::Write;

use crate::detector::Detector;
use crate::totals::Score;

/// Number of rows in each list.
const ROWS: usize = 10;

/// Formats the totals of a run that ended at `now_nanos`, and its worst pairs, robots and edges.
/// `edges` are ids by index.
pub(crate) fn summarize(detector: &Detector, edges: &[u32], now_nanos: u64) -> String {
    // Contacts that have not ended have lasted until now.
    let mut totals = detector.totals().clone();
    detector.contacts().iter().for_each(|contact| totals.lasted(contact, now_nanos));
    let all = totals.all();
    let mut text = format!(
        "after {:.1} s: {}{} contacts ({} touch now), {} warnings ({} now)\n",
        now_nanos as f64 * 1e-9,
        // The totals are lower bounds if not all pairs of some frame were examined.
        if totals.is_capped() { "at least " } else { "" },
        all.contacts,
        detector.touching(),
        all.warnings,
        detector.contacts().len() - detector.touching()
    );
    let pair = |((a, b), score): ((u32, u32), Score)| (format!("robots {a} and {b}"), score);
    let robot = |(robot, score): (u32, Score)| (format!("robot {robot}"), score);
    let edge = |(edge, score): (u32, Score)| match edges.get(edge as usize) {
        Some(id) => (format!("edge {id}"), score),
        None => ("on no edge".to_owned(), score),
    };
    list(&mut text, "worst pairs", totals.worst_pairs(ROWS).into_iter().map(pair));
    list(&mut text, "worst robots", totals.worst_robots(ROWS).into_iter().map(robot));
    list(&mut text, "worst edges", totals.worst_edges(ROWS).into_iter().map(edge));
    text
}

fn list(text: &mut String, title: &str, rows: impl Iterator<Item = (String, Score)>) {
    let mut rows = rows.peekable();
    if rows.peek().is_none() {
        return;
    }
    // Writing to a string can't fail.
    let _ = writeln!(
        text,
        "\n{title:<26}{:>10}{:>12}{:>10}{:>12}",
        "contacts", "touching", "warnings", "possible"
    );
    for (name, score) in rows {
        let [touching, possible] =
            [score.touching_nanos, score.possible_nanos].map(|nanos| nanos as f64 * 1e-9);
        let Score { contacts, warnings, .. } = score;
        let _ = writeln!(
            text,
            "{name:<26}{contacts:>10}{touching:>10.2} s{warnings:>10}{possible:>10.2} s"
        );
    }
}
