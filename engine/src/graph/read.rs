//! Reads a [`RouteGraph`] from a file or a text, or reports everything that is wrong with it.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::finding::{Findings, Report};
use super::route_graph::RouteGraph;
use super::spline::Handles;
use super::{lint, validate, yaml};

/// The size of the largest file that is read, in bytes: some 300,000 edges. Reading YAML takes up to 50 times the size
/// of the file in memory.
pub const MAX_FILE_BYTES: u64 = 64 << 20;

/// The largest depth of nested brackets.
const MAX_DEPTH: usize = 100;

/// Settings of the caller that override those in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The handle convention; `None` for that of the file, which is [`Handles::BAtOrigin`] if the file has none.
    pub handles: Option<Handles>,
}

/// The error of reading a route graph. It is displayed as one line; [`GraphError::findings`] has all details.
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
    #[error("{}: this is a folder: give a route graph file inside it", file.display())]
    Folder {
        /// The folder.
        file: PathBuf,
    },
    /// The file has more than [`MAX_FILE_BYTES`], or more lists and maps than any graph needs.
    #[error("{file}: too large: at most {limit} can be read; split the graph or remove what isn't needed")]
    TooLarge {
        /// The file's name.
        file: String,
        /// The exceeded limit.
        limit: String,
    },
    /// The file has nothing but white space and comments.
    #[error("{file}: the file is empty: a route graph has Edges and Vertices")]
    Empty {
        /// The file's name.
        file: String,
    },
    /// The file isn't UTF-8 text.
    #[error("{file}:{line}: not UTF-8 text: {reason}; check that this is a route graph file")]
    NotText {
        /// The file's name.
        file: String,
        /// The line of the first invalid byte, from 1.
        line: usize,
        /// The findings.
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
    /// The route graph has errors: at least one of the findings is an error.
    #[error("{}", summary(.0))]
    Invalid(Findings),
}

impl GraphError {
    /// Returns all findings, errors and warnings, by line; `None` if the file couldn't be read as a graph at all.
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

/// Reads and validates a route graph file. Returns the graph with its warnings.
///
/// # Errors
/// If the file can't be read, isn't a route graph, or has errors.
pub fn read(path: &Path, options: &ReadOptions) -> Result<(RouteGraph, Findings), GraphError> {
    parse(&read_file(path)?, &path.display().to_string(), options)
}

/// Reads the text of a file for [`parse`].
///
/// # Errors
/// If the file can't be read, is too large, or isn't text.
pub fn read_file(path: &Path) -> Result<String, GraphError> {
    let unreadable = |source| GraphError::Unreadable { file: path.to_owned(), source };
    let file = File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(GraphError::Folder { file: path.to_owned() });
    }
    let name = path.display().to_string();
    if metadata.len() > MAX_FILE_BYTES { Err(too_large(&name)) } else { read_stream(file, &name) }
}

/// Reads the text of a stream for [`parse`]; `name` is its name in messages.
///
/// # Errors
/// As [`read_file`].
pub fn read_stream(stream: impl Read, name: &str) -> Result<String, GraphError> {
    let mut bytes = Vec::new();
    // Limited here too: a pipe has no length, and a file may grow.
    let read = stream.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|source| GraphError::Unreadable { file: name.into(), source })?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(too_large(name));
    }
    String::from_utf8(bytes).map_err(|error| not_text(name, error.as_bytes(), error.utf8_error().valid_up_to()))
}

fn too_large(name: &str) -> GraphError {
    GraphError::TooLarge { file: name.to_owned(), limit: format!("{} MiB", MAX_FILE_BYTES >> 20) }
}

/// Validates the text of a route graph file; `name` is the file's name in messages. Returns the graph with its
/// warnings.
///
/// # Errors
/// The errors of [`read`], except those of opening a file.
pub fn parse(text: &str, name: &str, options: &ReadOptions) -> Result<(RouteGraph, Findings), GraphError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    reject_hostile(text, name)?;
    let mut report = Report::new(name, text);
    let raw = yaml::read(text, &mut report).map_err(|error| syntax(name, &error))?;
    let handles = options.handles.or(raw.handles).unwrap_or_default();
    match validate::validate(&raw, handles, &mut report) {
        Some(graph) if !report.has_errors() => {
            lint::lint(&graph, &raw, handles, &mut report);
            Ok((graph, report.into_findings()))
        }
        _ => Err(GraphError::Invalid(report.into_findings())),
    }
}

/// Rejects texts that can't be a route graph, or that would make the YAML reader slow or take much memory.
fn reject_hostile(text: &str, name: &str) -> Result<(), GraphError> {
    let file = || name.to_owned();
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(too_large(name));
    }
    if let Some(at) = text.bytes().position(|byte| byte == 0) {
        return Err(not_text(name, text.as_bytes(), at));
    }
    if text.lines().all(|line| line.trim_start().is_empty() || line.trim_start().starts_with('#')) {
        return Err(GraphError::Empty { file: file() });
    }
    // Each value of a map or list follows one of these bytes: an upper bound without parsing.
    let entries = text.bytes().filter(|byte| b":,-[{*".contains(byte)).count();
    if entries > 2 * yaml::MAX_ENTRIES {
        return Err(GraphError::TooLarge { file: file(), limit: format!("{} entries", yaml::MAX_ENTRIES) });
    }
    reject_deep_nesting(text, name)
}

/// Rejects deeply nested brackets: the time to read them grows with the square of the depth.
fn reject_deep_nesting(text: &str, name: &str) -> Result<(), GraphError> {
    let mut depth = 0usize;
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'[' | b'{' => depth += 1,
            b']' | b'}' => depth = depth.saturating_sub(1),
            _ => continue,
        }
        if depth > MAX_DEPTH {
            let message = format!("more than {MAX_DEPTH} nested brackets");
            return Err(GraphError::Syntax { file: name.to_owned(), line: line_at(text.as_bytes(), at), message });
        }
    }
    Ok(())
}

fn not_text(name: &str, bytes: &[u8], at: usize) -> GraphError {
    let reason = match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "it looks like UTF-16, save it as UTF-8",
        _ if bytes[at..].first() == Some(&0) => "it contains a zero byte",
        _ => "it contains bytes that are not valid UTF-8",
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
