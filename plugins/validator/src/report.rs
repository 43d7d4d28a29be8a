//! The report: as lines, JSON and Markdown.

use std::fmt::{self, Write as _};

use regatta_plugin::Frame;
use serde::Serialize;

use crate::findings::{Finding, Findings, Kind};

/// The report of a judgement.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// Runs of producers.
    pub runs: u64,
    /// Frames that were judged.
    pub frames: u64,
    /// Ticks without a frame between them, which are judged by the frames around.
    pub ticks_between: u64,
    /// Frames that the producer published and the judge didn't get.
    pub frames_missed: u64,
    /// Samples of the order log that the judge didn't get.
    pub order_samples_missed: u64,
    /// Simulated seconds of the last run.
    pub seconds: f64,
    /// The largest number of robots.
    pub robots: u64,
    /// Orders in the order log.
    pub orders: u64,
    /// The findings of each kind.
    pub kinds: Vec<KindReport>,
}

/// The findings of one kind.
#[derive(Clone, Debug, Serialize)]
pub struct KindReport {
    /// The kind.
    pub kind: Kind,
    /// The unit of values and limits; empty if there is none.
    pub unit: &'static str,
    /// The number of findings.
    pub count: u64,
    /// The first of them.
    pub examples: Vec<Finding>,
}

impl Report {
    pub(crate) fn take_frame(&mut self, frame: &Frame<'_>, ticks: u64) {
        self.frames += 1;
        self.ticks_between += ticks.saturating_sub(1);
        self.frames_missed += frame.missed();
        self.robots = self.robots.max(frame.len() as u64);
    }

    pub(crate) fn set_findings(&mut self, findings: &Findings) {
        self.kinds = Kind::all()
            .map(|kind| KindReport {
                kind,
                unit: kind.unit(),
                count: findings.count(kind),
                examples: findings.examples(kind).to_vec(),
            })
            .collect();
    }

    /// The number of findings of a kind.
    pub fn count(&self, kind: Kind) -> u64 {
        self.kinds.iter().find(|report| report.kind == kind).map_or(0, |report| report.count)
    }

    /// The number of findings of all kinds but these.
    pub fn count_without(&self, allowed: &[Kind]) -> u64 {
        let counted = self.kinds.iter().filter(|report| !allowed.contains(&report.kind));
        counted.map(|report| report.count).sum()
    }

    /// The kinds that have findings.
    pub fn found(&self) -> impl Iterator<Item = &KindReport> {
        self.kinds.iter().filter(|report| report.count > 0)
    }

    /// Describes the validated data in one line.
    fn subject(&self) -> String {
        let Self { frames, robots, orders, seconds, .. } = self;
        let mut line = format!(
            "{} of {} in {seconds:.2} s, {}",
            plural(*frames, "frame"),
            plural(*robots, "robot"),
            plural(*orders, "order")
        );
        for (count, noun, rest) in [
            (self.ticks_between, "tick", "between frames"),
            (self.frames_missed, "frame", "missed"),
            (self.order_samples_missed, "sample", "of the order log missed"),
        ] {
            if count > 0 {
                let _ = write!(line, ", {} {rest}", plural(count, noun));
            }
        }
        line
    }

    /// Returns the report as JSON, with a newline at its end.
    pub fn to_json(&self) -> String {
        // JSON can hold numbers, texts and lists, so this doesn't fail.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// Returns the report as Markdown.
    pub fn to_markdown(&self) -> String {
        let mut text = format!(
            "# Validation\n\n{}.\n\n| kind | findings | first |\n|---|---|---|\n",
            self.subject()
        );
        for report in &self.kinds {
            let _ = writeln!(text, "| {} | {} | {} |", report.kind, report.count, report.first());
        }
        for report in self.found() {
            let _ = write!(text, "\n## {}\n\n", report.kind);
            for finding in &report.examples {
                let _ = writeln!(text, "- {}", describe(finding, report.unit));
            }
            let more = report.count - report.examples.len() as u64;
            if more > 0 {
                let _ = writeln!(text, "- and {more} more");
            }
        }
        text
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let total = self.count_without(&[]);
        let findings = if total == 0 { "no findings".to_owned() } else { plural(total, "finding") };
        writeln!(f, "validator: {findings} in {}", self.subject())?;
        for report in self.found() {
            let KindReport { kind, count, .. } = report;
            writeln!(f, "  {kind:<18} {count:>8}  first: {}", report.first())?;
        }
        Ok(())
    }
}

impl KindReport {
    /// Describes the first finding in one line.
    fn first(&self) -> String {
        self.examples.first().map(|finding| describe(finding, self.unit)).unwrap_or_default()
    }
}

/// Describes a finding in one line.
fn describe(finding: &Finding, unit: &str) -> String {
    let mut line = format!("tick {} ({:.2} s)", finding.tick, finding.time_secs);
    if let Some(order) = finding.order {
        let _ = write!(line, ", order {order}");
    }
    match finding.robots[..] {
        [] => {}
        [robot] => {
            let _ = write!(line, ", robot {robot}");
        }
        _ => {
            let robots: Vec<_> = finding.robots.iter().map(u32::to_string).collect();
            let _ = write!(line, ", robots {}", robots.join(" and "));
        }
    }
    if let Some(edge) = finding.edge {
        let _ = write!(line, ", edge {edge}");
    }
    if let Some([x, y]) = finding.place {
        let _ = write!(line, ", at ({x:.2}, {y:.2}) m");
    }
    if let Some(value) = finding.value {
        let _ = write!(line, ": {value:.3} {unit}");
    }
    if let Some(limit) = finding.limit {
        let _ = write!(line, " (limit {limit:.3} {unit})");
    }
    if let Some(seconds) = finding.duration_secs {
        let _ = write!(line, ", for {seconds:.2} s");
    }
    if !finding.note.is_empty() {
        let _ = write!(line, ": {}", finding.note);
    }
    line
}

/// Returns a number with a noun: `1 finding`, `2 findings`.
pub(crate) fn plural(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_each_is_told_in_the_singular() {
        let report =
            Report { frames: 1, robots: 1, orders: 1, ticks_between: 1, ..Report::default() };
        let expected = "1 frame of 1 robot in 0.00 s, 1 order, 1 tick between frames";
        assert_eq!(report.subject(), expected);
        let expected = "2 frames of 3 robots in 0.00 s, 0 orders";
        assert_eq!(Report { frames: 2, robots: 3, ..Report::default() }.subject(), expected);
        assert_eq!(plural(1, "finding"), "1 finding");
    }
}
