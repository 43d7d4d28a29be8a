//! Tables of nodes and edges, in one file or in two beside each other. See `docs/formats/csv.md`.

mod columns;
mod points;
mod rows;
pub(crate) mod sibling;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use ::csv::{ReaderBuilder, StringRecord, Trim};
use glam::DVec2;
use regatta_base::Decimal;
use regatta_base::bezier::CubicBezier;

use self::columns::Columns;
use self::points::Points;
use self::rows::{EdgeRow, Row, is_grouped};
use self::sibling::{EDGE_WORDS, NODE_WORDS, sibling_files};
use crate::model::finding::Report;
use crate::model::options::ReadOptions;
use crate::model::value::shorten;
use crate::read::encoding::SourceText;
use crate::read::file::{Ignored, MAX_ENTRIES, MAX_NAME, Source, SyntaxError, read_file};
use crate::read::layout::{Layout, LayoutEdge, LayoutNode, Shape};

/// The largest number of columns of a table.
const MAX_COLUMNS: usize = 200;

/// The largest number of columns that a warning names.
const MAX_EXAMPLES: usize = 5;

/// The largest number of warnings with different texts.
const MAX_WARNINGS: usize = 100;

/// Reads a table of nodes and a table of edges.
///
/// # Errors
/// If the text has no header of a table, or one of the two tables is missing.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    let scale = options.units.map_or(1.0, crate::model::options::LengthUnit::metres);
    let mut reader = Reader {
        report,
        ignored: Ignored::default(),
        warnings: BTreeMap::new(),
        points: Points::default(),
        other: None,
        scale,
        nodes: Vec::new(),
        edges: Vec::new(),
        has_nodes: false,
        has_edges: false,
        has_doubtful_angles: false,
    };
    reader.file(source.text)?;
    if !reader.has_nodes || !reader.has_edges {
        reader.sibling(source)?;
    }
    reader.report_warnings();
    reader.find_ends_by_name();
    reader.select_level(options.level.as_deref())?;
    reader.layout()
}

struct Reader<'r, 'text> {
    report: &'r mut Report<'text>,
    ignored: Ignored,
    /// By message: the place of its first occurrence, and the number of occurrences.
    warnings: BTreeMap<String, (u32, usize)>,
    /// Numbers with points in the file that is read, if it has decimal commas.
    points: Points,
    /// The second file while it is read.
    other: Option<Other>,
    /// The metres of one unit, for columns without a unit.
    scale: f64,
    nodes: Vec<LayoutNode>,
    edges: Vec<EdgeRow>,
    /// Whether the table of nodes, and that of edges, have rows, also with errors.
    has_nodes: bool,
    has_edges: bool,
    /// Whether a node has a heading without a unit.
    has_doubtful_angles: bool,
}

/// The second file, with the other table.
struct Other {
    name: String,
    /// The number by which its places exceed byte offsets.
    base: u32,
}

/// The place of a row.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// The byte offset.
    at: u32,
    line: u64,
}

impl Place {
    /// Returns the place of a row, which begins at `position` or after the empty lines and comments
    /// there.
    fn of_row(text: &str, position: &::csv::Position) -> Self {
        let (mut at, mut line) = (position.byte() as usize, position.line());
        for content in text.get(at..).unwrap_or_default().split_inclusive('\n') {
            if !content.starts_with(['\n', '\r', '#']) {
                break;
            }
            at += content.len();
            line += 1;
        }
        Self { at: at as u32, line }
    }
}

impl Reader<'_, '_> {
    /// Warns of numbers whose points may separate thousands: where commas aren't separators, all
    /// numbers with a point have groups of three digits.
    fn warn_of_thousands<'a>(&mut self, cells: impl Iterator<Item = &'a str>) {
        let mut numbers = cells.filter(|cell| cell.contains('.') && cell.parse::<f64>().is_ok());
        let Some(first) = numbers.next().filter(|cell| is_grouped(cell)) else { return };
        if numbers.all(is_grouped) {
            let message = format!(
                "`{0}` is read as {1}, as are all numbers with a point: if it separates thousands, \
                 write {2}",
                shorten(first),
                first.parse::<f64>().unwrap_or_default(),
                first.replace('.', "")
            );
            self.warning(Place { at: 0, line: 1 }, &message);
        }
    }

    fn file(&mut self, text: &str) -> Result<(), SyntaxError> {
        let separator = separator(text);
        let cells = text.split([char::from(separator), '\n', '\r']);
        let has_decimal_comma = separator != b','
            && cells.clone().any(|cell| Decimal::has_comma(cell.trim().trim_matches('"')));
        if separator != b',' && !has_decimal_comma {
            self.warn_of_thousands(cells.map(|cell| cell.trim().trim_matches('"')));
        }
        let mut rows = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .delimiter(separator)
            .trim(Trim::All)
            .from_reader(text.as_bytes());
        let mut record = StringRecord::new();
        let mut columns: Option<Columns> = None;
        for count in 0.. {
            let has_row = rows
                .read_record(&mut record)
                .map_err(|error| self.syntax(1, &error.to_string()))?;
            if !has_row {
                break;
            }
            let place = record
                .position()
                .map_or(Place { at: 0, line: 1 }, |position| Place::of_row(text, position));
            if count > MAX_ENTRIES || record.len() > MAX_COLUMNS {
                let limit = format!(
                    "more than {MAX_ENTRIES} rows or {MAX_COLUMNS} columns: split the table"
                );
                return Err(self.syntax(place.line, &limit));
            }
            let is_separator =
                columns.is_none() && record.get(0).is_some_and(|cell| cell.starts_with("sep="));
            if is_separator || record.iter().all(str::is_empty) {
                continue;
            }
            if let Some(header) =
                may_be_header(&record).then(|| Columns::of_header(record.iter())).flatten()
            {
                if let Some(column) = header.list.iter().find(|column| column.name.len() > MAX_NAME)
                {
                    let name = shorten(&column.name);
                    let message = format!(
                        "the name of the column `{name}` is longer than {MAX_NAME} bytes: shorten \
                         it"
                    );
                    return Err(self.syntax(place.line, &message));
                }
                self.warn_of_guesses(&header, place);
                self.warn_of_properties(&header, place);
                columns = Some(header);
                continue;
            }
            let Some(columns) = &columns else {
                let message = "the first row isn't a header: name the columns of nodes `id,x,y` \
                               or of edges `from,to`";
                return Err(self.syntax(place.line, message));
            };
            self.row(Row { columns, cells: &record, place, has_decimal_comma });
        }
        std::mem::take(&mut self.points).report(self.report);
        Ok(())
    }

    /// Tells what columns with German names are taken for.
    fn warn_of_guesses(&mut self, header: &Columns, place: Place) {
        let guessed = header.list.iter().filter_map(|column| {
            Some(format!("`{}` as `{}`", shorten(&column.name), column.translated?))
        });
        let guessed: Vec<String> = guessed.collect();
        if !guessed.is_empty() {
            let message = format!("columns are read by their German names: {}", guessed.join(", "));
            self.warning(place, &message);
        }
    }

    /// Warns of columns that aren't understood.
    fn warn_of_properties(&mut self, header: &Columns, place: Place) {
        let names: Vec<String> =
            header.properties().map(|(_, column)| format!("`{}`", shorten(&column.name))).collect();
        let (shown, others) = names.split_at(names.len().min(MAX_EXAMPLES));
        let more = match others.len() {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let what = if header.is_edges { "edges" } else { "nodes" };
        if !shown.is_empty() {
            let message = format!(
                "unknown columns of {what} are kept as properties: {}{more}",
                shown.join(", ")
            );
            self.warning(place, &message);
        }
    }

    fn row(&mut self, row: Row<'_>) {
        if row.cells.len() > row.columns.list.len() {
            self.ignored.add(self.at(row.place), "cells without a column name");
        }
        if row.columns.is_edges {
            self.has_edges = true;
            let edge = row.edge(self);
            self.edges.extend(edge);
        } else {
            self.has_nodes = true;
            let node = row.node(self);
            self.nodes.extend(node);
        }
    }

    /// Reads the file with the other table.
    fn sibling(&mut self, source: Source<'_>) -> Result<(), SyntaxError> {
        let (missing, words, others) = match (self.has_nodes, self.has_edges) {
            (false, false) => {
                return Err(self.syntax(1, "the tables have no rows: add nodes and edges"));
            }
            (false, _) => ("nodes", EDGE_WORDS.as_slice(), NODE_WORDS.as_slice()),
            (true, _) => ("edges", NODE_WORDS.as_slice(), EDGE_WORDS.as_slice()),
        };
        let file = sibling_files(source, words, others).into_iter().find(|file| file.is_file());
        let Some(file) = file else {
            let message = format!(
                "there is no table of {missing}: add it below an empty line, or name the two \
                 files like `map-nodes.csv` and `map-edges.csv` in one folder"
            );
            return self.missing(&message);
        };
        let text = read_file(&file).map_err(|error| self.syntax(1, &error.to_string()))?;
        let (name, doubt) = (file.display().to_string(), SourceText::from(&text).doubt());
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        self.other = Some(Other { base: self.report.add_file(name.clone(), text), name });
        if let Some((line, message)) = doubt {
            let before = text.split_inclusive('\n').take(line - 1).map(str::len).sum::<usize>();
            self.warning(Place { at: before as u32, line: line as u64 }, message);
        }
        let result = self.file(text);
        self.other = None;
        result
    }

    /// Tells that a table is missing, beside the errors in the rows of the other one.
    fn missing(&mut self, message: &str) -> Result<(), SyntaxError> {
        if !self.report.has_errors() {
            return Err(self.syntax(1, message));
        }
        self.report.file_error(0, message);
        Ok(())
    }

    fn select_level(&mut self, level: Option<&str>) -> Result<(), SyntaxError> {
        let Some(level) = level else { return Ok(()) };
        let (kept, others): (Vec<_>, Vec<_>) = std::mem::take(&mut self.nodes)
            .into_iter()
            .partition(|node| node.tags.level.as_deref() == Some(level));
        if kept.is_empty() {
            return Err(self.syntax(
                1,
                &format!("no node has the level `{}`: see the column `level`", shorten(level)),
            ));
        }
        self.nodes = kept;
        let others: BTreeSet<_> = others.iter().map(|node| node.id.as_str()).collect();
        self.edges.retain(|edge| {
            !others.contains(edge.from.as_str()) && !others.contains(edge.to.as_str())
        });
        Ok(())
    }

    /// Gives edges the ids of ends that they have by name. A name that several nodes have, or that
    /// is an id, names no node.
    fn find_ends_by_name(&mut self) {
        let ids: BTreeSet<&str> = self.nodes.iter().map(|node| node.id.as_str()).collect();
        let mut by_name: BTreeMap<&str, Option<&str>> = BTreeMap::new();
        for node in &self.nodes {
            if let Some(name) = node.tags.name.as_deref().filter(|name| !ids.contains(name)) {
                let is_first = !by_name.contains_key(name);
                by_name.insert(name, is_first.then_some(node.id.as_str()));
            }
        }
        for end in self.edges.iter_mut().flat_map(|edge| [&mut edge.from, &mut edge.to]) {
            if let Some(Some(id)) = by_name.get(end.as_str()) {
                *end = (*id).to_owned();
            }
        }
    }

    fn layout(self) -> Result<Layout, SyntaxError> {
        let is_empty = self.nodes.is_empty() || self.edges.is_empty();
        if is_empty && !self.report.has_errors() {
            let missing = if self.nodes.is_empty() { "nodes" } else { "edges" };
            let message = format!("the table of {missing} has no rows that can be used");
            return Err(self.syntax(1, &message));
        }
        // Most tables have few curves.
        let has_curves = self.edges.iter().any(|row| !row.control_points.is_empty());
        let located = if has_curves { self.nodes.as_slice() } else { &[] };
        let positions: BTreeMap<_, _> =
            located.iter().filter_map(|node| Some((node.id.as_str(), node.position?))).collect();
        let mut free = free_ids(&self.edges);
        let edges =
            self.edges.into_iter().flat_map(|row| edges(row, &positions, &mut free)).collect();
        self.ignored.report(self.report);
        let has_doubtful_angles = self.has_doubtful_angles;
        Ok(Layout { edges, nodes: self.nodes, has_doubtful_angles, ..Layout::default() })
    }

    fn error(&mut self, place: Place, message: &str) {
        let at = self.at(place);
        self.report.file_error(at, message);
    }

    /// Adds a warning, which is reported once with its number of occurrences.
    fn warning(&mut self, place: Place, message: &str) {
        if let Some((_, count)) = self.warnings.get_mut(message) {
            *count += 1;
        } else if self.warnings.len() < MAX_WARNINGS {
            self.warnings.insert(message.to_owned(), (self.at(place), 1));
        }
    }

    fn report_warnings(&mut self) {
        for (message, (at, count)) in std::mem::take(&mut self.warnings) {
            let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
            self.report.file_warning(at, message + &times);
        }
    }

    /// Returns the place of a row for findings, which may be in the second file.
    fn at(&self, place: Place) -> u32 {
        place.at + self.other.as_ref().map_or(0, |other| other.base)
    }

    fn syntax(&self, line: u64, message: &str) -> SyntaxError {
        match &self.other {
            Some(other) => SyntaxError::new(1, format!("{}:{line}: {message}", other.name)),
            None => SyntaxError::new(line as usize, message),
        }
    }
}

/// Returns the separator that Excel's first line `sep=;` names.
pub(crate) fn named_separator(line: &str) -> Option<u8> {
    match line.trim().trim_matches('"').strip_prefix("sep=")?.as_bytes() {
        &[separator] => Some(separator),
        [] => Some(b'\t'),
        _ => None,
    }
}

/// Returns the separator that the first line names, or the most frequent one there.
fn separator(text: &str) -> u8 {
    let first = text
        .lines()
        .find(|line| !line.trim().is_empty() && !line.starts_with('#'))
        .unwrap_or_default();
    if let Some(separator) = named_separator(first) {
        return separator;
    }
    // If several are equally frequent, the last one is chosen.
    [b'\t', b';', b',']
        .into_iter()
        .max_by_key(|separator| first.bytes().filter(|byte| byte == separator).count())
        .unwrap_or(b',')
}

/// Whether a row can be a header. A header names at least the two ends of an edge, or x and y.
fn may_be_header(cells: &StringRecord) -> bool {
    cells.iter().filter(|cell| cell.contains(char::is_alphabetic)).nth(1).is_some()
}

/// Returns the first free id for edges in the opposite direction: the number after the largest, or
/// `None` if ids aren't numbers.
fn free_ids(rows: &[EdgeRow]) -> Option<u32> {
    let mut largest = 0;
    for row in rows {
        largest = row.edge.id.parse::<u32>().ok()?.max(largest);
    }
    largest.checked_add(1)
}

/// Returns the edge of a row, and the one in the opposite direction if it is bidirectional.
fn edges(
    row: EdgeRow,
    positions: &BTreeMap<&str, DVec2>,
    free: &mut Option<u32>,
) -> impl Iterator<Item = LayoutEdge> + use<> {
    let ends = positions.get(row.from.as_str()).zip(positions.get(row.to.as_str()));
    let cubic = ends.and_then(|(from, to)| cubic(*from, &row.control_points, *to));
    let shape = cubic.map_or(Shape::Straight, |cubic| Shape::Cubics(vec![cubic]));
    let back = row.is_bidirectional.then(|| {
        let id = free.map_or_else(|| format!("{} back", row.edge.id), |free| free.to_string());
        *free = free.and_then(|free| free.checked_add(1));
        LayoutEdge {
            at: row.edge.at,
            id,
            origin: row.to.clone(),
            destination: row.from.clone(),
            shape: shape.reversed(),
            speed: row.edge.speed,
            reverse_speed: row.edge.reverse_speed,
            tags: row.edge.tags.clone(),
            ..LayoutEdge::default()
        }
    });
    let edge = LayoutEdge { origin: row.from, destination: row.to, shape, ..row.edge };
    std::iter::once(edge).chain(back)
}

/// Returns the cubic curve with two inner control points, or the quadratic curve with one.
fn cubic(from: DVec2, control_points: &[DVec2], to: DVec2) -> Option<CubicBezier> {
    match *control_points {
        [a] => Some(CubicBezier {
            control_points: [from, from.lerp(a, 2.0 / 3.0), to.lerp(a, 2.0 / 3.0), to],
        }),
        [a, b] => Some(CubicBezier { control_points: [from, a, b, to] }),
        _ => None,
    }
}
