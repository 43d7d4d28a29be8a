//! Grid maps and scenarios of the MovingAI benchmarks, and grid maps of the League of Robot
//! Runners.
//!
//! The centre of each free cell becomes a node, and an edge leads to each free cell beside, above
//! and below it. The id of a node is `row × width + column`, counted from the top left corner as in
//! the benchmarks. The bottom left corner of the map is at (0, 0).

mod scen;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;

use glam::DVec2;

use crate::model::finding::Report;
use crate::model::options::{Millimetres, ReadOptions};
use crate::model::tags::Role;
use crate::read::file::{Ignored, Source, SyntaxError};
use crate::read::layout::{Layout, LayoutEdge, LayoutNode};

pub use scen::{ScenEntry, ScenError, ScenarioText, scen, scenario_yaml};

/// The largest number of rows and of columns.
const MAX_SIDE: usize = 1 << 16;

/// The largest number of free cells: each takes about 3 kB while the map is read.
const MAX_FREE: usize = 2_100_000;

/// The side of a cell in millimetres, unless the options give one.
const DEFAULT_CELL: Millimetres = Millimetres(1000);

/// The steps to the neighbours of a cell, in columns and rows, each with the heading of a robot
/// that drives there.
const STEPS: [([isize; 2], f64); 4] = {
    use std::f64::consts::{FRAC_PI_2, PI};
    [([1, 0], 0.0), ([0, -1], FRAC_PI_2), ([-1, 0], PI), ([0, 1], -FRAC_PI_2)]
};

/// Returns the number of columns of a map file; `None` if it isn't one.
pub fn columns(file: &std::path::Path) -> Option<u32> {
    let text = crate::read::file::read_file(file).ok()?;
    let width = text.lines().take(16).find_map(|line| line.trim().strip_prefix("width"))?;
    width.trim().parse().ok()
}

/// Reads a map.
///
/// # Errors
/// If the text has no header of a map, or more cells than can be read.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    if source.text.trim_start().starts_with("version") {
        let message = "this is a scenario of the MovingAI benchmarks: give the map that it names \
                       (.map); `regatta run` takes the scenario, too";
        return Err(SyntaxError::new(1, message));
    }
    let header = Header::read(source.text)?;
    let grid = Grid::read(header, source.text, report)?;
    let cell = f64::from(options.cell_size.unwrap_or(DEFAULT_CELL).0) / 1000.0;
    if grid.free.is_empty() {
        report
            .file_error(0, "the map has no free cell: free cells are written `.`, `G`, `S` or `E`");
    }
    Ok(Layout { nodes: nodes(&grid, cell), edges: edges(&grid), ..Layout::default() })
}

/// The lines before the cells.
#[derive(Clone, Copy, Debug)]
struct Header {
    width: usize,
    height: usize,
    /// The byte offset of the first row.
    cells_at: usize,
    /// The line of the first row, from 1.
    line: usize,
}

impl Header {
    fn read(text: &str) -> Result<Self, SyntaxError> {
        let (mut width, mut height) = (None, None);
        let mut at = 0;
        for (line, content) in (1..).zip(text.split_inclusive('\n')) {
            at += content.len();
            let mut words = content.split_whitespace();
            let (key, value) = (words.next().unwrap_or_default(), words.next());
            match key {
                "width" => width = Some(side(line, key, value)?),
                "height" => height = Some(side(line, key, value)?),
                "map" => {
                    let Some((width, height)) = width.zip(height) else {
                        let message = "`height` and `width` must precede `map`";
                        return Err(SyntaxError::new(line, message));
                    };
                    return Ok(Self { width, height, cells_at: at, line: line + 1 });
                }
                "type" | "" => {}
                _ => {
                    let message = "not a map of the MovingAI benchmarks: `type octile`, `height`, \
                                   `width` and `map` precede the cells";
                    return Err(SyntaxError::new(line, message));
                }
            }
        }
        Err(SyntaxError::new(1, "the line `map`, after which the cells follow, is missing"))
    }
}

fn side(line: usize, key: &str, value: Option<&str>) -> Result<usize, SyntaxError> {
    let side =
        value.and_then(|value| value.parse().ok()).filter(|side| (1..=MAX_SIDE).contains(side));
    side.ok_or_else(|| {
        SyntaxError::new(line, format!("`{key}` must be a whole number from 1 to {MAX_SIDE}"))
    })
}

/// The cells of a map.
#[derive(Debug, Default)]
struct Grid {
    width: usize,
    height: usize,
    /// `row × width + column` of each free cell, ascending, with its byte offset.
    free: Vec<(usize, u32)>,
    /// The cells of these letters, ascending: `S`, where robots pick, and `E`, where they drop, in
    /// maps of the League of Robot Runners.
    pick: BTreeSet<usize>,
    drop: BTreeSet<usize>,
    /// Whether a cell is free, row by row. Cells that are missing in the text are absent, as there
    /// may be many.
    is_free: Vec<bool>,
    /// By row: the index of its first cell in `is_free`.
    starts: Vec<usize>,
}

impl Grid {
    fn read(header: Header, text: &str, report: &mut Report<'_>) -> Result<Self, SyntaxError> {
        let Header { width, height, cells_at, .. } = header;
        let mut grid = Self { width, height, ..Self::default() };
        let mut ignored = Ignored::default();
        let mut at = cells_at;
        let mut rows = 0;
        let mut rest = text.get(cells_at..).unwrap_or_default().split_inclusive('\n');
        for content in rest.by_ref().take(height) {
            grid.read_row(content.trim_end_matches(['\n', '\r']), at, &mut ignored);
            at += content.len();
            rows += 1;
            if grid.free.len() > MAX_FREE {
                let message = format!("the map has more than {MAX_FREE} free cells: split it");
                return Err(SyntaxError::new(header.line + rows, message));
            }
        }
        if rows < height {
            let message =
                format!("the map has {rows} rows of {height}: the others count as blocked");
            report.file_warning(at as u32, message);
        }
        if rest.any(|content| !content.trim().is_empty()) {
            report.file_warning(
                at as u32,
                format!("text after the {height} rows of the map: not used"),
            );
        }
        ignored.report(report);
        Ok(grid)
    }

    /// Reads a row that starts at a byte offset. Missing cells are blocked.
    fn read_row(&mut self, row: &str, at: usize, ignored: &mut Ignored) {
        let (start, first) = (self.is_free.len(), self.starts.len() * self.width);
        for (column, (offset, cell)) in row.char_indices().take(self.width).enumerate() {
            let is_free = is_free(cell, at + offset, ignored);
            if is_free {
                self.free.push((first + column, (at + offset) as u32));
                match cell {
                    'S' => drop(self.pick.insert(first + column)),
                    'E' => drop(self.drop.insert(first + column)),
                    _ => {}
                }
            }
            self.is_free.push(is_free);
        }
        self.starts.push(start);
        if self.is_free.len() < start + self.width {
            ignored.add(
                at as u32,
                "a row that is shorter than the map, whose missing cells count as blocked",
            );
        } else if row.trim_end().chars().nth(self.width).is_some() {
            ignored.add(at as u32, "cells beyond the width of the map");
        }
    }

    /// Returns the role of a cell. In other maps, which have no `E`, `S` is a swamp.
    fn role(&self, cell: usize) -> Role {
        if self.drop.contains(&cell) {
            Role::Drop
        } else if self.pick.contains(&cell) && !self.drop.is_empty() {
            Role::Pick
        } else {
            Role::None
        }
    }

    /// Returns a free cell's free neighbour.
    fn neighbour(&self, cell: usize, [columns, rows]: [isize; 2]) -> Option<usize> {
        let column = (cell % self.width)
            .checked_add_signed(columns)
            .filter(|&column| column < self.width)?;
        let row = (cell / self.width).checked_add_signed(rows)?;
        let end = self.starts.get(row + 1).copied().unwrap_or(self.is_free.len());
        let index = self.starts.get(row)? + column;
        (index < end && self.is_free[index]).then_some(row * self.width + column)
    }
}

/// Returns whether robots can stand on a cell.
fn is_free(cell: char, at: usize, ignored: &mut Ignored) -> bool {
    match cell {
        '.' | 'G' | 'S' | 'E' => true,
        '@' | 'O' | 'T' | 'W' => false,
        other => {
            ignored.add(
                at as u32,
                format!("cell `{}`, which counts as blocked", other.escape_debug()),
            );
            false
        }
    }
}

fn nodes(grid: &Grid, cell_size: f64) -> Vec<LayoutNode> {
    let mut nodes = Vec::with_capacity(grid.free.len());
    for &(cell, at) in &grid.free {
        let (column, row) = (cell % grid.width, grid.height - 1 - cell / grid.width);
        let heading = STEPS
            .iter()
            .find(|(step, _)| grid.neighbour(cell, *step).is_some())
            .map_or(0.0, |step| step.1);
        nodes.push(LayoutNode {
            at,
            id: cell.to_string(),
            position: Some(DVec2::new(column as f64 + 0.5, row as f64 + 0.5) * cell_size),
            heading: Some(heading),
            role: grid.role(cell),
            ..LayoutNode::default()
        });
    }
    nodes
}

/// Returns the edges from each free cell, with ids from 1.
fn edges(grid: &Grid) -> Vec<LayoutEdge> {
    // The exact capacity: the edges of the largest maps take much memory.
    let mut edges = Vec::with_capacity(neighbours(grid).count());
    for (id, (from, to, at)) in (1u32..).zip(neighbours(grid)) {
        edges.push(LayoutEdge {
            at,
            id: id.to_string(),
            origin: from.to_string(),
            destination: to.to_string(),
            ..LayoutEdge::default()
        });
    }
    edges
}

/// Returns each free cell with each of its free neighbours, and the byte offset of the first.
fn neighbours(grid: &Grid) -> impl Iterator<Item = (usize, usize, u32)> {
    grid.free.iter().flat_map(move |&(cell, at)| {
        STEPS.iter().filter_map(move |(step, _)| Some((cell, grid.neighbour(cell, *step)?, at)))
    })
}
