//! From a file or a text to a [`RouteGraph`], or to everything that is wrong with it.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::finding::{Findings, Report};
use super::spline::Handles;
use super::{RouteGraph, survey, validate, yaml};

/// The largest file that is read, in bytes: some 300,000 edges. YAML takes up to 50 times its size in memory while it
/// is read.
pub const MAX_FILE_BYTES: u64 = 64 << 20;

/// The most brackets that may be open at once.
const MAX_DEPTH: usize = 100;

/// What the caller wants read otherwise than the file says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Which handle length goes with which end; `None`: what the file says, or else [`Handles::BAtOrigin`].
    pub handles: Option<Handles>,
}

/// Why a route graph can't be had. Prints as one line; [`GraphError::findings`] has all there is to say.
#[derive(Debug, thiserror::Error)]
pub enum GraphError {
    /// The file can't be opened or read.
    #[error("{}: can't be read: {source}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A folder where a file was wanted.
    #[error("{}: is a folder: name a route graph file inside it", file.display())]
    Folder {
        /// The folder.
        file: PathBuf,
    },
    /// More than [`MAX_FILE_BYTES`], or more lists and maps than any graph needs.
    #[error("{file}: is too large: {limit} at most; split the graph or leave out what isn't needed")]
    TooLarge {
        /// The file's name.
        file: String,
        /// The limit that it exceeds.
        limit: String,
    },
    /// Nothing but white space and comments.
    #[error("{file}: is empty: a route graph has Edges and Vertices")]
    Empty {
        /// The file's name.
        file: String,
    },
    /// Bytes that aren't UTF-8 text.
    #[error("{file}:{line}: isn't UTF-8 text: {reason}; is it a route graph file?")]
    NotText {
        /// The file's name.
        file: String,
        /// Where the text ends, from 1.
        line: usize,
        /// What is there instead.
        reason: &'static str,
    },
    /// Text that isn't YAML, or not the YAML of a route graph.
    #[error("{file}:{line}: isn't a route graph: {message}")]
    Syntax {
        /// The file's name.
        file: String,
        /// Line, from 1.
        line: usize,
        /// What the YAML reader said.
        message: String,
    },
    /// A route graph with errors: at least one of the findings is one.
    #[error("{}", summary(.0))]
    Invalid(Findings),
}

impl GraphError {
    /// All findings, errors and warnings, by line; none if it didn't come to reading a graph.
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

/// Reads and validates a route graph file: the graph with its warnings.
///
/// # Errors
/// If the file can't be read, isn't a route graph, or is one with errors.
pub fn read(path: &Path, options: &ReadOptions) -> Result<(RouteGraph, Findings), GraphError> {
    let name = path.display().to_string();
    let bytes = read_bytes(path).map_err(|source| GraphError::Unreadable { file: path.to_owned(), source })?;
    let bytes = match bytes {
        Content::Folder => return Err(GraphError::Folder { file: path.to_owned() }),
        Content::TooLarge => {
            return Err(GraphError::TooLarge { file: name, limit: format!("{} MiB", MAX_FILE_BYTES >> 20) });
        }
        Content::Bytes(bytes) => bytes,
    };
    let text = std::str::from_utf8(&bytes).map_err(|error| not_text(&name, &bytes, error.valid_up_to()))?;
    parse(text, &name, options)
}

/// Validates the text of a route graph file; `name` stands for the file in messages.
///
/// # Errors
/// As [`read`], except for those of opening a file.
pub fn parse(text: &str, name: &str, options: &ReadOptions) -> Result<(RouteGraph, Findings), GraphError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    refuse_hostile(text, name)?;
    let mut report = Report::new(name, text);
    let raw = yaml::read(text, &mut report).map_err(|error| syntax(name, &error))?;
    let graph = validate::validate(&raw, options, &mut report);
    match graph {
        Some(graph) if !report.has_errors() => {
            survey::survey(&graph, &raw, options, &mut report);
            Ok((graph, report.into_findings()))
        }
        _ => Err(GraphError::Invalid(report.into_findings())),
    }
}

enum Content {
    Bytes(Vec<u8>),
    Folder,
    TooLarge,
}

fn read_bytes(path: &Path) -> io::Result<Content> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if metadata.is_dir() {
        return Ok(Content::Folder);
    }
    if metadata.len() > MAX_FILE_BYTES {
        return Ok(Content::TooLarge);
    }
    let mut bytes = Vec::new();
    // A pipe has no length, and a file may grow.
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(if bytes.len() as u64 > MAX_FILE_BYTES { Content::TooLarge } else { Content::Bytes(bytes) })
}

/// Refuses what isn't worth handing to the YAML reader, or would make it slow or large.
fn refuse_hostile(text: &str, name: &str) -> Result<(), GraphError> {
    let file = || name.to_owned();
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(GraphError::TooLarge { file: file(), limit: format!("{} MiB", MAX_FILE_BYTES >> 20) });
    }
    if let Some(at) = text.bytes().position(|byte| byte == 0) {
        return Err(not_text(name, text.as_bytes(), at));
    }
    if text.lines().all(|line| line.trim_start().is_empty() || line.trim_start().starts_with('#')) {
        return Err(GraphError::Empty { file: file() });
    }
    // Each value of a map or list follows one of these: an upper bound without parsing.
    let entries = text.bytes().filter(|byte| b":,-[{*".contains(byte)).count();
    if entries > 2 * yaml::MAX_ENTRIES {
        return Err(GraphError::TooLarge { file: file(), limit: format!("{} entries", yaml::MAX_ENTRIES) });
    }
    refuse_deep(text, name)
}

/// Time to read nested brackets grows with the square of their depth.
fn refuse_deep(text: &str, name: &str) -> Result<(), GraphError> {
    let mut depth = 0usize;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'[' | b'{' => depth += 1,
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => continue,
        }
        if depth > MAX_DEPTH {
            let message = format!("more than {MAX_DEPTH} brackets are open here");
            return Err(GraphError::Syntax { file: name.to_owned(), line: line_at(text.as_bytes(), at), message });
        }
    }
    Ok(())
}

fn not_text(name: &str, bytes: &[u8], at: usize) -> GraphError {
    let reason = match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "it looks like UTF-16, save it as UTF-8",
        _ if bytes[at..].first() == Some(&0) => "it holds a zero byte",
        _ => "it holds other bytes",
    };
    GraphError::NotText { file: name.to_owned(), line: line_at(bytes, at), reason }
}

fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at].iter().filter(|&&byte| byte == b'\n').count()
}

fn syntax(name: &str, error: &serde_yaml::Error) -> GraphError {
    let line = error.location().map_or(1, |location| location.line());
    GraphError::Syntax { file: name.to_owned(), line, message: error.to_string() }
}
