//! Findings in lines of text, the most important first.

use super::finding::{Finding, FindingKind, Findings, Severity, Subject};
use super::value::plural;

/// The most names in a line of things that aren't used.
const MOST_NAMES: usize = 4;

/// The detail in which findings are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Detail {
    /// The most important findings have a line each, and the others share a line, as do all things
    /// that aren't used.
    Grouped {
        /// The largest number of findings with a line.
        most: usize,
    },
    /// Each finding has a line.
    Each,
}

/// The importance of a finding, the most important first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Importance {
    /// The graph can't be driven.
    Error,
    /// A node, an edge, or an assumption: robots' ways, or results, are others.
    Result,
    /// The rest of the file.
    Other,
    /// Things of the file that aren't used.
    Unused,
}

impl Importance {
    fn of(finding: &Finding) -> Self {
        match (finding.severity, finding.kind, finding.subject) {
            (Severity::Error, ..) => Self::Error,
            (_, FindingKind::Unused, _) => Self::Unused,
            (_, FindingKind::TurnsAtNodes, _) => Self::Other,
            (_, FindingKind::Assumption, _) | (.., Subject::Node(_) | Subject::Edge(_)) => {
                Self::Result
            }
            (_, FindingKind::General, Subject::File) => Self::Other,
        }
    }
}

impl Findings {
    /// Returns the listed findings, the most important first: errors, then what changes robots'
    /// ways or results, then others, then things that aren't used. Those of the same importance
    /// are in the order of their lines.
    pub fn by_importance(&self) -> Vec<&Finding> {
        let mut findings: Vec<_> = self.as_slice().iter().collect();
        findings.sort_by_key(|finding| Importance::of(finding));
        findings
    }

    /// Returns lines of text, those of the most important findings first; the last line is that of
    /// the things that aren't used.
    pub fn told(&self, detail: Detail) -> Vec<String> {
        let findings = self.by_importance();
        let Detail::Grouped { most } = detail else {
            return findings.into_iter().map(Finding::to_string).collect();
        };
        let (unused, others): (Vec<_>, Vec<_>) =
            findings.into_iter().partition(|finding| finding.kind == FindingKind::Unused);
        let (told, untold) = others.split_at(most.min(others.len()));
        let mut lines: Vec<String> = told.iter().map(ToString::to_string).collect();
        if let Some(first) = untold.first() {
            let warnings = plural(untold.len(), "more warning");
            lines.push(format!("{}: {warnings}: `regatta graph check` lists them", first.file));
        }
        lines.extend(unused_line(&unused));
        lines
    }
}

/// Formats one line for all things that aren't used; a single one is told as it is.
fn unused_line(findings: &[&Finding]) -> Option<String> {
    let (first, others) = findings.split_first()?;
    if others.is_empty() {
        return Some(first.to_string());
    }
    let mut names: Vec<&str> = Vec::new();
    for name in findings.iter().filter_map(|finding| quoted(&finding.message)) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.truncate(MOST_NAMES);
    // Keys of different elements may have one name.
    let rest = if names.len() < findings.len() { ", …" } else { "" };
    Some(format!(
        "{}: {} keys not used: {}{rest}; -v names each",
        first.file,
        findings.len(),
        names.join(", ")
    ))
}

/// Returns the name that a message has between backticks.
fn quoted(message: &str) -> Option<&str> {
    message.split('`').nth(1).map(str::trim)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::finding::Report;

    fn findings() -> Findings {
        let mut report = Report::new("a.yaml", "1\n2\n3\n4\n5\n6\n7\n");
        for (at, key) in ["a", "b", "a", "c", "d", "e"].into_iter().enumerate() {
            let kind = FindingKind::Unused;
            let message = format!("key `{key}` of element {at}: not used");
            report.add_kind(kind, Severity::Warning, 0, Subject::File, message);
        }
        report.file_warning(2, "the heading changes");
        report.assumption(8, "2 edges have no speed limit");
        report.warning(6, Subject::Edge(Some(7)), "its curve has a gap of 11.4 m");
        report.into_findings()
    }

    #[test]
    fn what_changes_results_is_told_first_and_unused_keys_in_one_last_line() {
        let lines = findings().told(Detail::Grouped { most: 20 });
        assert_eq!(
            lines,
            [
                "a.yaml:4: warning: edge 7: its curve has a gap of 11.4 m",
                "a.yaml:5: warning: 2 edges have no speed limit",
                "a.yaml:2: warning: the heading changes",
                "a.yaml: 6 keys not used: a, b, c, d, …; -v names each",
            ]
        );
    }

    #[test]
    fn a_list_that_names_fewer_keys_than_there_are_ends_with_dots() {
        let told = |keys: &[&str]| {
            let mut report = Report::new("a.xml", "1\n");
            for (at, key) in keys.iter().enumerate() {
                let message = format!("key `{key}` of element {at}: not used");
                report.add_kind(FindingKind::Unused, Severity::Warning, 0, Subject::File, message);
            }
            report.into_findings().told(Detail::Grouped { most: 20 })
        };
        assert_eq!(
            told(&["name", "layer", "x", "y", "layer"]),
            ["a.xml: 5 keys not used: name, layer, x, y, …; -v names each"]
        );
        assert_eq!(told(&["name", "x"]), ["a.xml: 2 keys not used: name, x; -v names each"]);
    }

    #[test]
    fn the_least_important_findings_share_a_line() {
        let lines = findings().told(Detail::Grouped { most: 1 });
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[1], "a.yaml: 2 more warnings: `regatta graph check` lists them");
    }

    #[test]
    fn each_unused_key_has_a_line_if_that_is_wanted() {
        let lines = findings().told(Detail::Each);
        assert_eq!(lines.len(), 9);
        assert_eq!(lines[3], "a.yaml:1: warning: key `a` of element 0: not used");
    }
}
