//! Readers of layouts: our own files, and those of other systems.
//!
//! A reader of another format turns the text of a file into a [`layout::Layout`] with the file's
//! own ids. It reports unknown content once per kind. Then [`read()`] validates the layout like our
//! own files.

mod csv;
mod detect;
mod dxf;
pub(crate) mod encoding;
pub(crate) mod file;
pub(crate) mod layout;
pub(crate) mod lif;
pub mod moving_ai;
pub(crate) mod nav2;
mod open_rmf;
pub(crate) mod open_tcs;
mod regatta;
mod ros_map;

use std::path::{Path, PathBuf};

use regatta_base::yaml;

pub use self::detect::is_unread;
use self::encoding::{Doubt, SourceText};
use self::file::{
    GraphError, MAX_ENTRIES, MAX_FILE_BYTES, Source, SyntaxError, line_at, read_file, too_large,
};
use self::layout::Layout;
use crate::check::{fix, lint, units, validate};
use crate::model::finding::{Findings, Report, Subject};
use crate::model::format::Format;
use crate::model::options::ReadOptions;
use crate::model::raw::RawGraph;
use crate::model::route_graph::RouteGraph;
use crate::model::tags::BackgroundLine;

impl ReadOptions {
    /// Reports the options that a format doesn't use.
    fn report_unused(&self, format: Format, report: &mut Report<'_>) {
        let given = [
            ("--handles", self.handles.is_some(), &[Format::Regatta][..]),
            ("--vehicle-type", self.vehicle_type.is_some(), &[Format::Lif]),
            ("--layer", !self.layers.is_empty(), &[Format::Dxf]),
            ("--units", self.units.is_some(), &UNIT_FORMATS),
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

/// The formats whose readers handle the option `level`. Some report that levels can't be chosen.
const LEVEL_FORMATS: [Format; 6] = [
    Format::Lif,
    Format::OpenRmf,
    Format::OpenRmfBuilding,
    Format::Nav2,
    Format::OpenTcs,
    Format::Csv,
];

/// The formats whose lengths are in metres.
const METRIC_FORMATS: [Format; 4] = [Format::Regatta, Format::Lif, Format::OpenRmf, Format::Nav2];

/// The formats whose unit of length can be given: these, and those whose readers handle it.
const UNIT_FORMATS: [Format; 6] =
    [Format::Dxf, Format::Csv, Format::Regatta, Format::Lif, Format::OpenRmf, Format::Nav2];

/// Reads and validates a route graph file. Returns the graph with its warnings.
///
/// # Errors
/// If the file can't be read, isn't a route graph, or has errors.
pub fn read(path: &Path, options: &ReadOptions) -> Result<(RouteGraph, Findings), GraphError> {
    parse(&read_file(path)?, &path.display().to_string(), options)
}

/// Validates the text of a route graph file; `name` is the file's name in messages. Returns the
/// graph with its warnings.
///
/// # Errors
/// The errors of [`read`], except those of opening a file.
pub fn parse<'text>(
    text: impl Into<SourceText<'text>>,
    name: &'text str,
    options: &ReadOptions,
) -> Result<(RouteGraph, Findings), GraphError> {
    let (raw, report) = parse_raw(text.into(), name, options)?;
    finish(raw, options, report)
}

/// As [`parse`], after repairing errors that have one obvious correction. Also returns the repairs,
/// one line each.
///
/// # Errors
/// As [`parse`], for errors that can't be repaired.
pub fn parse_fixed<'text>(
    text: impl Into<SourceText<'text>>,
    name: &'text str,
    options: &ReadOptions,
) -> Result<(RouteGraph, Findings, Vec<String>), GraphError> {
    let (mut raw, report) = parse_raw(text.into(), name, options)?;
    let fixes = fix::fix(&mut raw);
    let (graph, findings) = finish(raw, options, report)?;
    Ok((graph, findings, fixes))
}

/// Reads a text up to its validation.
fn parse_raw<'text>(
    SourceText { text, doubt }: SourceText<'text>,
    name: &'text str,
    options: &ReadOptions,
) -> Result<(RawGraph, Report<'text>), GraphError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    reject_hostile(text, name)?;
    detect::reject_unread(text).map_err(|error| syntax(name, error))?;
    let format = options.format.unwrap_or_else(|| Format::detect(text));
    // Only the reader of our own format reads large files part by part.
    let parts = if format == Format::Regatta { regatta::parts_of_large(text) } else { None };
    if format.is_yaml() {
        yaml::check_limits(text).map_err(|error| syntax(name, error.into()))?;
        if parts.is_none() {
            reject_many_entries(text, name)?;
        }
    }
    let mut report = Report::new(name, text);
    if let Some(Doubt { at, message }) = doubt {
        report.file_warning(*at, message.as_str());
    }
    options.report_unused(format, &mut report);
    let mut raw = match format {
        Format::Regatta => {
            regatta::read(text, parts, &mut report).map_err(|error| syntax(name, error))?
        }
        foreign => {
            let path = Path::new(name);
            let folder = path.parent().unwrap_or(Path::new(""));
            let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
            let layout = read_layout(foreign, Source { text, folder, stem }, options, &mut report);
            layout
                .map_err(|error| syntax(name, with_other_format(error, text, options)))?
                .into_raw(&mut report)
        }
    };
    match options.units {
        Some(unit) if METRIC_FORMATS.contains(&format) => raw.scale(unit.metres()),
        None if UNIT_FORMATS.contains(&format) && !units::check(&raw, &mut report) => {
            return Err(GraphError::Invalid(report.into_findings()));
        }
        _ => {}
    }
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

/// Validates the graph that a reader has made.
fn finish(
    mut raw: RawGraph,
    options: &ReadOptions,
    mut report: Report<'_>,
) -> Result<(RouteGraph, Findings), GraphError> {
    if let Some(map) = &options.background {
        let outlines = ros_map::background(map)?.into_iter();
        raw.background.extend(outlines.map(BackgroundLine::from));
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
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(too_large(name));
    }
    if let Some(at) = text.bytes().position(|byte| byte == 0) {
        return Err(GraphError::NotText {
            file: name.to_owned(),
            line: line_at(text.as_bytes(), at),
            reason: "it contains a zero byte; check that this is a route graph file",
        });
    }
    if text.lines().all(|line| line.trim_start().is_empty() || line.trim_start().starts_with('#')) {
        return Err(GraphError::Empty { file: name.to_owned() });
    }
    Ok(())
}

/// Rejects texts for which the YAML reader would take much memory.
fn reject_many_entries(text: &str, name: &str) -> Result<(), GraphError> {
    // Each value of a map or list follows one of these bytes: an upper bound without parsing.
    let entries = text.bytes().filter(|byte| b":,-[{*".contains(byte)).count();
    if entries > 2 * MAX_ENTRIES {
        return Err(GraphError::TooLarge {
            file: name.to_owned(),
            limit: format!("{MAX_ENTRIES} entries"),
        });
    }
    Ok(())
}

fn syntax(name: &str, SyntaxError { line, message }: SyntaxError) -> GraphError {
    GraphError::Syntax { file: name.to_owned(), line, message }
}

/// Reads a layout of another format. [`Format::Regatta`] has none of these readers.
///
/// # Errors
/// If the text isn't of that format. Errors in its content are reported to `report` instead.
pub(crate) fn read_layout<'text>(
    format: Format,
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    match format {
        Format::Lif => lif::read(source, options, report),
        Format::OpenRmf => open_rmf::read(source, options, report),
        Format::OpenRmfBuilding => open_rmf::building::read(source, options, report),
        Format::Nav2 => nav2::read(source, options, report),
        Format::OpenTcs => open_tcs::read(source, options, report),
        Format::MovingAi => moving_ai::read(source, options, report),
        Format::Dxf => dxf::read(source, options, report),
        Format::Csv => csv::read(source, options, report),
        Format::RosMap => ros_map::read(source, options, report),
        Format::Regatta => Err(SyntaxError {
            line: 1,
            message: "our own format has a reader of its own".to_owned(),
        }),
    }
}

/// Returns the other files that a layout needs: the picture of a ROS map, or the second of two
/// tables.
pub fn companions(path: &Path) -> Vec<PathBuf> {
    csv::sibling::sibling(path).into_iter().chain(ros_map::picture(path)).collect()
}
