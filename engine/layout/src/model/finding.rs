//! Findings: the errors and warnings of a route graph file, each with its place and its remedy.

use std::fmt;
use std::sync::Arc;

use super::value::with_short_numbers;

/// The largest number of listed findings of one severity. Further findings are only counted.
pub const MAX_LISTED: usize = 10_000;

/// The severity of a finding, displayed as `error` or `warning`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, strum::Display)]
#[strum(serialize_all = "lowercase")]
pub enum Severity {
    /// The graph can't be driven.
    Error,
    /// The graph can be driven, but perhaps not as intended.
    Warning,
}

/// The kind of a finding, for callers that treat some kinds differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FindingKind {
    /// No special treatment.
    General,
    /// Robots with a rotation speed turn at nodes: irrelevant if all robots have one.
    TurnsAtNodes,
    /// Speeds, edges, or who drives on them are others than the file says, or it doesn't say them:
    /// results rest on it.
    Assumption,
    /// The file has a key, a property or another name, between backticks in the message, that isn't
    /// used.
    Unused,
}

/// The part of the file that a finding is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Subject {
    /// The file as a whole.
    File,
    /// The node with this id; `None` if it has no valid id.
    Node(Option<u32>),
    /// The edge with this id; `None` if it has no valid id.
    Edge(Option<u32>),
}

/// An error or a warning about a route graph file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The severity.
    pub severity: Severity,
    /// The kind.
    pub kind: FindingKind,
    /// The file's name, as given by the caller.
    pub file: String,
    /// The line in the file, from 1.
    pub line: u32,
    /// The part of the file that the finding is about.
    pub subject: Subject,
    /// The problem and its remedy.
    pub message: String,
}

/// All findings about one file and a second one that belongs to it, in the order of their lines.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Findings {
    list: Vec<Finding>,
    errors: usize,
    warnings: usize,
}

/// Collects the findings about one file and looks up their lines.
pub(crate) struct Report<'text> {
    file: String,
    lines: LineIndex<'text>,
    /// A second file, such as the one with the other table.
    other: Option<Arc<OtherFile>>,
    found: Findings,
}

impl Subject {
    /// Returns `file`, `node` or `edge`.
    pub fn kind(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Node(_) => "node",
            Self::Edge(_) => "edge",
        }
    }

    /// Returns the id of the node or edge, if it has a valid one.
    pub fn id(self) -> Option<u32> {
        match self {
            Self::File => None,
            Self::Node(id) | Self::Edge(id) => id,
        }
    }
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.id() {
            Some(id) => write!(f, "{} {id}", self.kind()),
            None => f.write_str(self.kind()),
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: {}: ", self.file, self.line, self.severity)?;
        if self.subject != Subject::File {
            write!(f, "{}: ", self.subject)?;
        }
        f.write_str(&self.message)
    }
}

impl Findings {
    /// Returns the findings by line: at most [`MAX_LISTED`] errors and as many warnings.
    pub fn as_slice(&self) -> &[Finding] {
        &self.list
    }

    /// Returns the number of errors, listed or not.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// Returns the number of warnings, listed or not.
    pub fn warnings(&self) -> usize {
        self.warnings
    }

    /// Returns the findings without those of a kind.
    #[must_use]
    pub fn without(mut self, kind: FindingKind) -> Self {
        for severity in self.list.extract_if(.., |finding| finding.kind == kind).map(severity_of) {
            match severity {
                Severity::Error => self.errors -= 1,
                Severity::Warning => self.warnings -= 1,
            }
        }
        self
    }

    /// Returns the first error by line.
    pub fn first_error(&self) -> Option<&Finding> {
        self.list.iter().find(|finding| finding.severity == Severity::Error)
    }
}

fn severity_of(finding: Finding) -> Severity {
    finding.severity
}

impl<'text> Report<'text> {
    pub fn new(file: &str, text: &'text str) -> Self {
        let lines = LineIndex::new(text);
        Self { file: file.to_owned(), lines, other: None, found: Findings::default() }
    }

    /// Adds a second file. Returns the number by which places in it exceed their byte offsets.
    pub fn add_file(&mut self, name: String, text: &str) -> u32 {
        let base = self.lines.text.len() as u32 + 1;
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let line_ends = ends.map(|(at, _)| at as u32).collect();
        self.other = Some(Arc::new(OtherFile { name, base, line_ends }));
        base
    }

    /// Returns a report about the same file, without findings.
    pub fn empty(&self) -> Self {
        let (file, lines, other) = (self.file.clone(), self.lines.clone(), self.other.clone());
        Self { file, lines, other, found: Findings::default() }
    }

    /// Adds the findings of another report about the same file.
    pub fn append(&mut self, other: Self) {
        let Findings { list, errors, warnings } = other.found;
        let [mut errors_left, mut warnings_left] = [self.found.errors, self.found.warnings]
            .map(|listed| MAX_LISTED.saturating_sub(listed));
        for finding in list {
            let left = match finding.severity {
                Severity::Error => &mut errors_left,
                Severity::Warning => &mut warnings_left,
            };
            if *left > 0 {
                *left -= 1;
                self.found.list.push(finding);
            }
        }
        self.found.errors += errors;
        self.found.warnings += warnings;
    }

    pub fn error(&mut self, at: u32, subject: Subject, message: impl Into<String>) {
        self.add(Severity::Error, at, subject, message);
    }

    pub fn warning(&mut self, at: u32, subject: Subject, message: impl Into<String>) {
        self.add(Severity::Warning, at, subject, message);
    }

    pub fn add(
        &mut self,
        severity: Severity,
        at: u32,
        subject: Subject,
        message: impl Into<String>,
    ) {
        self.add_kind(FindingKind::General, severity, at, subject, message.into());
    }

    pub fn add_kind(
        &mut self,
        kind: FindingKind,
        severity: Severity,
        at: u32,
        subject: Subject,
        message: String,
    ) {
        let count = match severity {
            Severity::Error => &mut self.found.errors,
            Severity::Warning => &mut self.found.warnings,
        };
        *count += 1;
        if *count <= MAX_LISTED {
            let (file, line) = match self.other.as_ref().filter(|other| at >= other.base) {
                Some(other) => (other.name.clone(), other.line(at)),
                None => (self.file.clone(), self.lines.line(at)),
            };
            let message = with_short_numbers(message);
            self.found.list.push(Finding { severity, kind, file, line, subject, message });
        }
    }

    /// Adds an error about the file as a whole.
    pub fn file_error(&mut self, at: u32, message: impl Into<String>) {
        self.error(at, Subject::File, message);
    }

    /// Adds a warning about the file as a whole.
    pub fn file_warning(&mut self, at: u32, message: impl Into<String>) {
        self.warning(at, Subject::File, message);
    }

    /// Adds a warning about the file as a whole that results rest on.
    pub fn assumption(&mut self, at: u32, message: impl Into<String>) {
        let kind = FindingKind::Assumption;
        self.add_kind(kind, Severity::Warning, at, Subject::File, message.into());
    }

    /// Returns the line, from 1, of a byte offset.
    pub fn line(&self, at: u32) -> u32 {
        self.lines.line(at)
    }

    pub fn has_errors(&self) -> bool {
        self.found.errors > 0
    }

    /// Returns the findings by line, those in a second file last; those of one line in the order in
    /// which they were found.
    pub fn into_findings(mut self) -> Findings {
        self.found.list.sort_by_key(|finding| (finding.file != self.file, finding.line));
        self.found
    }
}

/// A second file that findings may be about.
struct OtherFile {
    name: String,
    /// The place of its first byte.
    base: u32,
    /// The byte offsets of its line ends.
    line_ends: Vec<u32>,
}

impl OtherFile {
    /// Returns the line, from 1, of a place.
    fn line(&self, at: u32) -> u32 {
        1 + self.line_ends.partition_point(|end| *end < at - self.base) as u32
    }
}

/// The number of bytes between two checkpoints. A look-up counts the line ends in at most one
/// stride.
const STRIDE: usize = 512;

/// The line numbers of a text. Clones are cheap.
#[derive(Clone)]
pub(crate) struct LineIndex<'text> {
    text: &'text [u8],
    /// `checkpoints[i]` is the number of line ends before byte `i * STRIDE`.
    checkpoints: Arc<[u32]>,
}

impl<'text> LineIndex<'text> {
    pub fn new(text: &'text str) -> Self {
        let text = text.as_bytes();
        let mut before = 0;
        let checkpoints = text
            .chunks(STRIDE)
            .map(|chunk| {
                let here = before;
                before += line_ends(chunk);
                here
            })
            .collect();
        Self { text, checkpoints }
    }

    /// Returns the line, from 1, of a byte offset; that of the last byte if the offset is beyond
    /// the end.
    pub fn line(&self, offset: u32) -> u32 {
        let offset = (offset as usize).min(self.text.len());
        let Some(&before) = self.checkpoints.get(offset / STRIDE).or(self.checkpoints.last())
        else {
            return 1;
        };
        let from = (offset / STRIDE).min(self.checkpoints.len() - 1) * STRIDE;
        1 + before + line_ends(&self.text[from..offset])
    }
}

fn line_ends(bytes: &[u8]) -> u32 {
    bytes.iter().map(|&byte| u32::from(byte == b'\n')).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_found() {
        let text: String = (1..=3000).map(|line| format!("{line}\n")).collect();
        let index = LineIndex::new(&text);
        for line in 1..=3000u32 {
            let offset = text.find(&format!("\n{line}\n")).map_or(0, |at| at + 1);
            assert_eq!(index.line(offset as u32), line);
        }
        assert_eq!(index.line(u32::MAX), 3001);
        assert_eq!(LineIndex::new("").line(0), 1);
        assert_eq!(LineIndex::new("").line(7), 1);
    }

    #[test]
    fn the_end_of_a_text_of_whole_strides_is_found() {
        let text = "\n".repeat(2 * STRIDE);
        assert_eq!(LineIndex::new(&text).line(2 * STRIDE as u32), 2 * STRIDE as u32 + 1);
    }
}
