//! Reads a [`RouteGraph`] from a file or a text, or reports everything that is wrong with it.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use super::finding::{Findings, Report, Subject};
use super::format::ros_map::{self, BackgroundError};
use super::format::{self, Format, Source, SyntaxError};
use super::route_graph::RouteGraph;
use super::spline::Handles;
use super::yaml::RawGraph;
use super::{fix, lint, validate, yaml};

/// The size of the largest file that is read, in bytes.
pub const MAX_FILE_BYTES: u64 = 256 << 20;

/// The largest depth of nested brackets.
const MAX_DEPTH: usize = 100;

/// Settings of the caller that override those in the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The handle convention; `None` for that of the file, which is [`Handles::BAtOrigin`] if the
    /// file has none.
    pub handles: Option<Handles>,
    /// The format; `None` to tell it by the content.
    pub format: Option<Format>,
    /// The only level (floor) or layout to read, by name; `None` for all.
    pub level: Option<String>,
    /// The vehicle type whose speeds and headings are read, by id; `None` for the first of the
    /// file.
    pub vehicle_type: Option<String>,
    /// The layers of a drawing whose lines are edges; empty for all. The others are background.
    pub layers: Vec<String>,
    /// The unit of a drawing, such as `mm`; `None` for what the drawing says, else metres.
    pub units: Option<LengthUnit>,
    /// The width in metres for which a roadmap is made of a map without a graph; `None` for no
    /// roadmap.
    pub skeleton: Option<Millimetres>,
    /// The length of the side of a grid map's cells; `None` for 1 m.
    pub cell_size: Option<Millimetres>,
    /// A map of the ROS map server whose outlines are drawn behind the layout.
    pub background: Option<PathBuf>,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// Millimetres.
    Millimetre,
    /// Centimetres.
    Centimetre,
    /// Metres.
    Metre,
    /// Inches of 25.4 mm.
    Inch,
    /// Feet of 304.8 mm.
    Foot,
}

impl LengthUnit {
    /// All units.
    pub const ALL: [Self; 5] =
        [Self::Millimetre, Self::Centimetre, Self::Metre, Self::Inch, Self::Foot];

    /// Returns the symbol used on the command line and in scenarios.
    pub fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }

    /// Returns the metres of one unit.
    pub fn metres(self) -> f64 {
        match self {
            Self::Millimetre => 0.001,
            Self::Centimetre => 0.01,
            Self::Metre => 1.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }
}

/// The error of parsing a [`LengthUnit`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is not a unit: use mm, cm, m, in or ft", .0.escape_debug())]
pub struct ParseUnitError(String);

impl std::str::FromStr for LengthUnit {
    type Err = ParseUnitError;

    /// Parses a symbol, ignoring case.
    fn from_str(text: &str) -> Result<Self, ParseUnitError> {
        let is = |unit: &Self| unit.name().eq_ignore_ascii_case(text.trim());
        Self::ALL.into_iter().find(is).ok_or_else(|| ParseUnitError(text.trim().to_owned()))
    }
}

/// A length in whole millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Millimetres(pub u32);

impl Millimetres {
    /// Returns the length in metres.
    pub fn metres(self) -> f64 {
        f64::from(self.0) / 1000.0
    }
}

/// The error of parsing [`Millimetres`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is not a length: give metres from 0.001 to 1000", .0.escape_debug())]
pub struct ParseLengthError(String);

impl std::str::FromStr for Millimetres {
    type Err = ParseLengthError;

    /// Parses metres.
    fn from_str(text: &str) -> Result<Self, ParseLengthError> {
        let metres =
            text.trim().parse::<f64>().ok().filter(|metres| (0.001..=1000.0).contains(metres));
        metres
            .map(|metres| Self((metres * 1000.0).round() as u32))
            .ok_or_else(|| ParseLengthError(text.trim().to_owned()))
    }
}

impl std::fmt::Display for Millimetres {
    /// Writes metres.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.metres())
    }
}

impl ReadOptions {
    /// Reports the options that a format doesn't use.
    fn report_unused(&self, format: Format, report: &mut Report<'_>) {
        let given = [
            ("--handles", self.handles.is_some(), &[Format::Regatta][..]),
            ("--vehicle-type", self.vehicle_type.is_some(), &[Format::Lif]),
            ("--layer", !self.layers.is_empty(), &[Format::Dxf]),
            ("--units", self.units.is_some(), &[Format::Dxf, Format::Csv]),
            ("--skeleton", self.skeleton.is_some(), &[Format::RosMap]),
            ("--cell-size", self.cell_size.is_some(), &[Format::MovingAi]),
            ("--level", self.level.is_some(), &LEVEL_FORMATS),
        ];
        for (name, _, formats) in given
            .into_iter()
            .filter(|(_, is_given, formats)| *is_given && !formats.contains(&format))
        {
            let users = formats.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
            report.warning(
                0,
                Subject::File,
                format!("`{name}` is not used for {format}, but for {users}"),
            );
        }
    }
}

/// The formats that have levels, or say that theirs can't be chosen.
const LEVEL_FORMATS: [Format; 6] = [
    Format::Lif,
    Format::OpenRmf,
    Format::OpenRmfBuilding,
    Format::Nav2,
    Format::OpenTcs,
    Format::Csv,
];

/// The error of reading a route graph. It is displayed as one line; [`GraphError::findings`] has
/// all details.
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
    /// The file has more than [`MAX_FILE_BYTES`], or more lists and maps than any graph needs.
    #[error(
        "{file}: too large: at most {limit} can be read; split the graph or remove what isn't needed"
    )]
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
    String::from_utf8(bytes)
        .map_err(|error| not_text(name, error.as_bytes(), error.utf8_error().valid_up_to()))
}

fn too_large(name: &str) -> GraphError {
    GraphError::TooLarge { file: name.to_owned(), limit: format!("{} MiB", MAX_FILE_BYTES >> 20) }
}

/// Validates the text of a route graph file; `name` is the file's name in messages. Returns the
/// graph with its warnings.
///
/// # Errors
/// The errors of [`read`], except those of opening a file.
pub fn parse(
    text: &str,
    name: &str,
    options: &ReadOptions,
) -> Result<(RouteGraph, Findings), GraphError> {
    let (raw, report) = parse_raw(text, name, options)?;
    finish(raw, options, report)
}

/// As [`parse`], after mending what has one obvious answer. Also returns what was mended, one line
/// each.
///
/// # Errors
/// As [`parse`], for what can't be mended.
pub fn parse_fixed(
    text: &str,
    name: &str,
    options: &ReadOptions,
) -> Result<(RouteGraph, Findings, Vec<String>), GraphError> {
    let (mut raw, report) = parse_raw(text, name, options)?;
    let fixes = fix::fix(&mut raw);
    let (graph, findings) = finish(raw, options, report)?;
    Ok((graph, findings, fixes))
}

/// Reads a text up to its validation.
fn parse_raw<'text>(
    text: &'text str,
    name: &'text str,
    options: &ReadOptions,
) -> Result<(RawGraph, Report<'text>), GraphError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    reject_hostile(text, name)?;
    let format = options.format.unwrap_or_else(|| Format::detect(text));
    // Only our own reader reads large files part by part.
    let parts = if format == Format::Regatta { yaml::parts_of_large(text) } else { None };
    if format.is_yaml() {
        reject_deep_nesting(text, name)?;
        if parts.is_none() {
            reject_many_entries(text, name)?;
        }
    }
    let mut report = Report::new(name, text);
    options.report_unused(format, &mut report);
    let raw = match format {
        Format::Regatta => {
            yaml::read(text, parts, &mut report).map_err(|error| syntax(name, error))?
        }
        foreign => {
            let path = Path::new(name);
            let folder = path.parent().unwrap_or(Path::new(""));
            let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
            let layout = format::read(foreign, Source { text, folder, stem }, options, &mut report);
            layout
                .map_err(|error| syntax(name, with_other_format(error, text, options)))?
                .into_raw(&mut report)
        }
    };
    Ok((raw, report))
}

/// Adds the format of the content to an error, if the caller has named another.
fn with_other_format(error: SyntaxError, text: &str, options: &ReadOptions) -> SyntaxError {
    let found = Format::detect(text);
    let Some(named) = options.format.filter(|named| *named != found) else { return error };
    let message = format!(
        "{}; the content looks like {found}, not {named}: leave the format out",
        error.message
    );
    SyntaxError { message, ..error }
}

/// Validates what a reader has read.
fn finish(
    mut raw: RawGraph,
    options: &ReadOptions,
    mut report: Report<'_>,
) -> Result<(RouteGraph, Findings), GraphError> {
    if let Some(map) = &options.background {
        raw.background.extend(ros_map::background(map)?);
    }
    let handles = options.handles.or(raw.handles).unwrap_or_default();
    match validate::validate(&raw, handles, &mut report) {
        Some(graph) if !report.has_errors() => {
            lint::lint(&graph, &raw, handles, &mut report);
            Ok((graph, report.into_findings()))
        }
        _ => Err(GraphError::Invalid(report.into_findings())),
    }
}

/// Rejects texts that can't be a route graph.
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
    Ok(())
}

/// Rejects texts for which the YAML reader would take much memory.
fn reject_many_entries(text: &str, name: &str) -> Result<(), GraphError> {
    // Each value of a map or list follows one of these bytes: an upper bound without parsing.
    let entries = text.bytes().filter(|byte| b":,-[{*".contains(byte)).count();
    if entries > 2 * yaml::MAX_ENTRIES {
        return Err(GraphError::TooLarge {
            file: name.to_owned(),
            limit: format!("{} entries", yaml::MAX_ENTRIES),
        });
    }
    Ok(())
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
            return Err(GraphError::Syntax {
                file: name.to_owned(),
                line: line_at(text.as_bytes(), at),
                message,
            });
        }
    }
    Ok(())
}

fn not_text(name: &str, bytes: &[u8], at: usize) -> GraphError {
    let reason = match bytes {
        _ if bytes.starts_with(b"AutoCAD Binary DXF") => {
            "it is a binary drawing, save it as DXF in ASCII"
        }
        _ if bytes.starts_with(b"AC10") => "it is a drawing in DWG, save it as DXF in ASCII",
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "it looks like UTF-16, save it as UTF-8",
        _ if bytes[at..].first() == Some(&0) => "it contains a zero byte",
        _ => "it contains bytes that are not valid UTF-8",
    };
    GraphError::NotText { file: name.to_owned(), line: line_at(bytes, at), reason }
}

fn line_at(bytes: &[u8], at: usize) -> usize {
    1 + bytes[..at].iter().filter(|&&byte| byte == b'\n').count()
}

fn syntax(name: &str, SyntaxError { line, message }: SyntaxError) -> GraphError {
    GraphError::Syntax { file: name.to_owned(), line, message }
}
