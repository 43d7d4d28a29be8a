//! The text of a file, the code that readers share, and the errors of reading.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use regatta_base::file::{self, RefusedFile};
use regatta_base::yaml;
pub(crate) use regatta_base::yaml::MAX_ENTRIES;

use super::encoding::{FileText, NotText, decode};
use crate::model::finding::{FindingKind, Findings, Report, Severity, Subject};
use crate::model::value::shorten;

/// The size of the largest file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 256 << 20;

/// The largest number of bytes of a name that many nodes and edges share, or that is part of their
/// ids, such as the name of a level, a block or a column. Without a limit, a small file could take
/// all memory.
pub(crate) const MAX_NAME: usize = 100;

/// The largest number of kinds that are counted separately.
const MAX_IGNORED_KINDS: usize = 100;

/// The text of a file, with the folder and the name for finding related files.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'text> {
    pub text: &'text str,
    /// The folder that paths in the file are relative to.
    pub folder: &'text Path,
    /// The name of the file without folder and ending.
    pub stem: &'text str,
}

/// Returns the byte offset of a part of a text; `None` for another text.
pub(crate) fn offset_of(text: &str, part: &str) -> Option<usize> {
    let offset = part.as_ptr().addr().checked_sub(text.as_ptr().addr())?;
    (offset < text.len()).then_some(offset)
}

/// The error of reading a text that isn't of the expected format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SyntaxError {
    /// The line, from 1.
    pub line: usize,
    pub message: String,
}

impl SyntaxError {
    pub fn new(line: usize, message: impl Into<String>) -> Self {
        Self { line, message: message.into() }
    }
}

impl From<serde_json::Error> for SyntaxError {
    fn from(error: serde_json::Error) -> Self {
        Self::new(error.line().max(1), error.to_string())
    }
}

impl From<yaml::Error> for SyntaxError {
    fn from(error: yaml::Error) -> Self {
        Self::new(error.line, error.reason)
    }
}

/// The error of reading a route graph. It is displayed as one line. [`GraphError::findings`]
/// returns all details.
#[derive(Debug, thiserror::Error)]
pub enum GraphError {
    /// The file can't be opened or read.
    #[error("{}: can't be read: {source}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The path is a folder.
    #[error("{}: this is a folder: give a file inside it", file.display())]
    Folder {
        /// The folder.
        file: PathBuf,
    },
    /// The file has more than [`MAX_FILE_BYTES`], or too many lists and maps.
    #[error(
        "{file}: too large: at most {limit} can be read; split the graph or remove what isn't \
         needed"
    )]
    TooLarge {
        /// The file's name.
        file: String,
        /// The exceeded limit.
        limit: String,
    },
    /// The file has only white space and comments.
    #[error("{file}: the file is empty: a route graph has Edges and Vertices")]
    Empty {
        /// The file's name.
        file: String,
    },
    /// The file isn't text.
    #[error("{file}:{line}: not a text: {reason}")]
    NotText {
        /// The file's name.
        file: String,
        /// The line of the first invalid byte, from 1.
        line: usize,
        /// The reason, and what to do.
        reason: &'static str,
    },
    /// The text isn't YAML, or not the YAML of a route graph.
    #[error("{file}:{line}: not a route graph: {message}")]
    Syntax {
        /// The file's name.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The YAML reader's message.
        message: String,
    },
    /// The map for the background can't be read.
    #[error(transparent)]
    Background(#[from] BackgroundError),
    /// The route graph has errors: at least one of the findings is an error.
    #[error("{}", summary(.0))]
    Invalid(Findings),
}

impl GraphError {
    /// Returns all findings, errors and warnings, by line; `None` if the file couldn't be read as a
    /// graph at all.
    pub fn findings(&self) -> Option<&Findings> {
        match self {
            Self::Invalid(findings) => Some(findings),
            _ => None,
        }
    }
}

fn summary(findings: &Findings) -> String {
    let first = findings.first_error().map(ToString::to_string).unwrap_or_default();
    match findings.errors() {
        0 | 1 => first,
        2 => format!("{first} (and 1 more error)"),
        errors => format!("{first} (and {} more errors)", errors - 1),
    }
}

/// The error of reading a map for the background of a layout.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}: {message}")]
pub struct BackgroundError {
    /// The file.
    pub file: String,
    /// The problem and its remedy.
    pub message: String,
}

/// Reads the text of a file for [`parse`](crate::parse).
///
/// # Errors
/// If the file can't be read, is too large, or isn't text.
pub fn read_file(path: &Path) -> Result<FileText, GraphError> {
    let name = path.display().to_string();
    match file::open(path, MAX_FILE_BYTES) {
        Ok(file) => read_stream(file, &name),
        Err(source) => Err(match RefusedFile::of(&source) {
            Some(RefusedFile::Folder) => GraphError::Folder { file: path.to_owned() },
            Some(RefusedFile::TooLarge { .. }) => too_large(&name),
            _ => GraphError::Unreadable { file: path.to_owned(), source },
        }),
    }
}

/// Reads the text of a stream for [`parse`](crate::parse); `name` is its name in messages.
///
/// # Errors
/// As [`read_file`].
pub fn read_stream(stream: impl Read, name: &str) -> Result<FileText, GraphError> {
    let mut bytes = Vec::new();
    // The limit is checked here too, because a pipe has no length and a file may grow.
    let read = stream.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|source| GraphError::Unreadable { file: name.into(), source })?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(too_large(name));
    }
    decode(bytes).map_err(|NotText { line, reason }| GraphError::NotText {
        file: name.to_owned(),
        line,
        reason,
    })
}

pub(crate) fn too_large(name: &str) -> GraphError {
    GraphError::TooLarge { file: name.to_owned(), limit: format!("{} MiB", MAX_FILE_BYTES >> 20) }
}

/// The kinds of content that a reader ignores.
#[derive(Debug, Default)]
pub(crate) struct Ignored {
    /// The things by their kind in words.
    kinds: BTreeMap<String, Count>,
}

/// The things of a kind that a reader ignores.
#[derive(Debug)]
struct Count {
    /// The byte offset of the first one.
    at: u32,
    things: usize,
    kind: FindingKind,
}

impl Ignored {
    /// Counts a thing of a kind, such as "entity in paper space".
    pub fn add(&mut self, at: u32, things: impl Into<String>) {
        self.count(at, things.into(), FindingKind::General);
    }

    /// Counts a thing that has a name between backticks and changes nothing, such as "property
    /// `foo` of a node".
    pub fn add_named(&mut self, at: u32, things: impl Into<String>) {
        self.count(at, things.into(), FindingKind::Unused);
    }

    /// Counts a key of an owner, such as "a node".
    pub fn add_key(&mut self, at: u32, key: &str, owner: &str) {
        self.add_named(at, format!("key `{}` of {owner}", shorten(key)));
    }

    fn count(&mut self, at: u32, things: String, kind: FindingKind) {
        if let Some(count) = self.kinds.get_mut(&things) {
            count.things += 1;
        } else if self.kinds.len() < MAX_IGNORED_KINDS {
            self.kinds.insert(things, Count { at, things: 1, kind });
        }
    }

    /// Reports a warning for each kind.
    pub fn report(self, report: &mut Report<'_>) {
        for (name, Count { at, things, kind }) in self.kinds {
            let times = if things == 1 { String::new() } else { format!(" ({things} times)") };
            let message = format!("{name}: not used{times}");
            report.add_kind(kind, Severity::Warning, at, Subject::File, message);
        }
    }
}

pub(crate) fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at].iter().filter(|&&byte| byte == b'\n').count()
}
