//! The report of a judge: findings by rule, as text, JSON and JUnit XML.

use core::fmt::{self, Write as _};
use std::collections::BTreeMap;

use regatta_base::svg::escape;
use serde::Serialize;

use super::Judge;
use super::finding::Finding;
use super::rule::{RULES, Rule, RuleRow, Severity};

/// The findings of a judge.
#[derive(Clone, Debug)]
pub struct Report {
    examples: usize,
    counts: BTreeMap<Rule, u64>,
    findings: Vec<Finding>,
    summary: Summary,
}

/// The messages of a report.
#[derive(Clone, Copy, Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
struct Summary {
    messages: u64,
    messages_delivered_again: u64,
    vehicles: usize,
    other_messages: u64,
    messages_left_out: u64,
    vehicles_without_size: usize,
    unread_lines: u64,
}

/// The severity from which on a report fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strictness {
    /// Errors.
    Errors,
    /// Warnings, too.
    Warnings,
}

impl Strictness {
    fn fails(self, severity: Severity) -> bool {
        self == Self::Warnings || severity == Severity::Error
    }
}

impl Report {
    /// Creates a report that keeps so many findings of each rule, and counts the others.
    pub fn new(examples: usize) -> Self {
        Self {
            examples,
            counts: BTreeMap::new(),
            findings: Vec::new(),
            summary: Summary::default(),
        }
    }

    /// Adds a finding. Returns it if it is kept.
    pub fn add(&mut self, finding: Finding) -> Option<&Finding> {
        let count = self.counts.entry(finding.rule).or_default();
        *count += 1;
        if *count > self.examples as u64 {
            return None;
        }
        self.findings.push(finding);
        self.findings.last()
    }

    /// Takes the numbers of messages, of vehicles, and of lines that belong to no message, at the
    /// end.
    pub fn conclude(&mut self, judge: &Judge, unread_lines: u64) {
        let tally = judge.tally();
        self.summary = Summary {
            messages: tally.judged,
            messages_delivered_again: tally.repeated,
            vehicles: judge.vehicles(),
            other_messages: tally.others,
            messages_left_out: tally.left_out,
            vehicles_without_size: judge.vehicles_without_size(),
            unread_lines,
        };
    }

    /// The number of findings of a severity.
    pub fn count(&self, severity: Severity) -> u64 {
        let counts = self.counts.iter().filter(|(rule, _)| rule.row().severity == severity);
        counts.map(|(_, count)| count).sum()
    }

    /// The rules that were broken, with the number of findings of each and the first one.
    pub fn rules(&self) -> impl Iterator<Item = (&'static RuleRow, u64, Option<&Finding>)> {
        self.counts.iter().map(|(rule, count)| {
            let mut findings = self.findings.iter();
            (rule.row(), *count, findings.find(|finding| finding.rule == *rule))
        })
    }

    /// Whether there are findings for which a report fails.
    pub fn fails(&self, strictness: Strictness) -> bool {
        self.counts.keys().any(|rule| strictness.fails(rule.row().severity))
    }

    /// The report as JSON.
    pub fn json(&self) -> String {
        let rules = self.counts.iter().map(|(rule, count)| JsonRule::new(rule.row(), *count));
        let report = JsonReport {
            summary: self.summary,
            errors: self.count(Severity::Error),
            warnings: self.count(Severity::Warning),
            rules: rules.collect(),
            findings: &self.findings,
        };
        // Plain structs are written to memory without an error.
        serde_json::to_string_pretty(&report).unwrap_or_default()
    }

    /// The report as JUnit XML: a test case for each rule.
    pub fn junit(&self, strictness: Strictness) -> String {
        let failing = self.counts.keys().filter(|rule| strictness.fails(rule.row().severity));
        let (tests, failures) = (RULES.len(), failing.count());
        let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n");
        // Writing to a string never fails.
        let _ = writeln!(
            xml,
            "  <testsuite name=\"VDA 5050\" tests=\"{tests}\" failures=\"{failures}\">"
        );
        for row in RULES {
            let _ = self.write_case(row, strictness, &mut xml);
        }
        xml.push_str("  </testsuite>\n</testsuites>\n");
        xml
    }

    fn write_case(&self, row: &RuleRow, strictness: Strictness, xml: &mut String) -> fmt::Result {
        let side: &str = row.side.into();
        let name = row.rule.id();
        write!(xml, "    <testcase classname=\"vda5050.{side}\" name=\"{name}\"")?;
        let Some(count) = self.counts.get(&row.rule) else { return xml.write_str("/>\n") };
        let examples = self.findings.iter().filter(|finding| finding.rule == row.rule);
        let text: Vec<_> = examples.map(|finding| xml_text(&finding.to_string())).collect();
        let text = text.join("\n");
        let message = xml_text(&format!("{count} times: {}", row.requirement));
        match strictness.fails(row.severity) {
            true => write!(xml, ">\n      <failure message=\"{message}\">{text}</failure>\n")?,
            false => write!(xml, ">\n      <system-out>{message}\n{text}</system-out>\n")?,
        }
        xml.write_str("    </testcase>\n")
    }
}

/// A text in XML, without the characters that XML can't have.
fn xml_text(text: &str) -> String {
    escape(text.chars().filter(is_possible).collect::<String>()).into_owned()
}

fn is_possible(character: &char) -> bool {
    !character.is_control() && !matches!(character, '\u{fffe}' | '\u{ffff}')
}

#[derive(Serialize)]
struct JsonReport<'a> {
    #[serde(flatten)]
    summary: Summary,
    errors: u64,
    warnings: u64,
    rules: Vec<JsonRule>,
    findings: &'a [Finding],
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct JsonRule {
    rule: &'static str,
    severity: &'static str,
    count: u64,
    requirement: &'static str,
    clause_2: &'static str,
    clause_3: &'static str,
}

impl JsonRule {
    fn new(row: &RuleRow, count: u64) -> Self {
        Self {
            rule: row.rule.id(),
            severity: row.severity.into(),
            count,
            requirement: row.requirement,
            clause_2: row.clause_2,
            clause_3: row.clause_3,
        }
    }
}

/// The summary of a report.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (rule, count) in &self.counts {
            let row = rule.row();
            let severity: &str = row.severity.into();
            writeln!(f, "{count:>8} {severity:<7} {}: {}", rule.id(), row.requirement)?;
        }
        let Summary { messages, vehicles, .. } = self.summary;
        let (errors, warnings) = (self.count(Severity::Error), self.count(Severity::Warning));
        writeln!(
            f,
            "messages {messages}, vehicles {vehicles}, errors {errors}, \
            warnings {warnings}"
        )?;
        let again = self.summary.messages_delivered_again;
        if again > 0 {
            writeln!(f, "no breach: {again} messages were delivered again, unchanged")?;
        }
        self.write_limits(f)
    }
}

impl Report {
    /// Tells what wasn't judged.
    fn write_limits(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Summary {
            other_messages, messages_left_out, vehicles_without_size, unread_lines, ..
        } = self.summary;
        if other_messages > 0 {
            writeln!(f, "not judged: {other_messages} messages of other topics")?;
        }
        if unread_lines > 0 {
            writeln!(f, "not judged: {unread_lines} lines that belong to no message")?;
        }
        if messages_left_out > 0 {
            writeln!(f, "not judged: {messages_left_out} messages of too many vehicles")?;
        }
        if vehicles_without_size > 0 {
            writeln!(
                f,
                "not judged: contacts of {vehicles_without_size} vehicles without a factsheet"
            )?;
        }
        Ok(())
    }
}
