//! Maps of the ROS map server: YAML, and a picture of free, occupied and unknown space.
//!
//! A map has no graph. The outlines of its occupied space become the background. If the options
//! give the width of a robot, the middle of the free space becomes a roadmap.

mod chains;
mod grid;
mod outline;
mod points;
mod roadmap;
mod skeleton;
#[cfg(test)]
mod tests;
mod throats;

use std::path::{Path, PathBuf};

use glam::DVec2;
use regatta_base::file;

use crate::model::finding::Report;
use crate::model::format::Format;
use crate::model::options::ReadOptions;
use crate::read::file::{BackgroundError, Ignored, Source, SyntaxError};
use crate::read::layout::{Layout, LayoutEdge, LayoutNode};
use grid::{Grid, MapFile};
use roadmap::Roadmap;

/// The largest size of a map's YAML in bytes.
const MAX_YAML_BYTES: u64 = 1 << 20;

/// Reads a map, and makes a roadmap of it if the options have the width of a robot.
///
/// # Errors
/// If the text isn't that of a map.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    let mut ignored = Ignored::default();
    let map = MapFile::read(source.text, &mut ignored)?;
    ignored.report(report);
    let Some(width) = options.skeleton else {
        let message = "a map of ROS has no graph: `--skeleton WIDTH` makes one in the middle of \
                       the free space for a robot of this width in metres, and `--background \
                       FILE` draws the map behind another layout";
        report.file_error(0, message);
        return Ok(Layout::default());
    };
    let grid = match Grid::read(&map, source.folder) {
        Ok(grid) => grid,
        Err(message) => {
            report.file_error(0, message);
            return Ok(Layout::default());
        }
    };
    if grid.has_few_free_cells() {
        report
            .file_warning(0, "less than 1 % of the map is free: check `negate` and the thresholds");
    }
    let roadmap = Roadmap::new(&grid, f64::from(width.0) / 1000.0);
    report_roadmap(&roadmap, &grid, width.0, report);
    let background = outlines(&grid).unwrap_or_else(|message| {
        report.file_warning(0, message);
        Vec::new()
    });
    Ok(layout(&roadmap, &grid, background))
}

/// Reads the outlines of the occupied space of a map, in metres: closed lines whose last point is
/// their first.
///
/// # Errors
/// If the map or its picture can't be read.
pub fn background(yaml_path: &Path) -> Result<Vec<Vec<DVec2>>, BackgroundError> {
    read_outlines(yaml_path)
        .map_err(|message| BackgroundError { file: yaml_path.display().to_string(), message })
}

fn read_outlines(yaml_path: &Path) -> Result<Vec<Vec<DVec2>>, String> {
    let text = file::read_text(yaml_path, MAX_YAML_BYTES).map_err(unreadable)?;
    let map = MapFile::read(&text, &mut Ignored::default()).map_err(|error| error.message)?;
    outlines(&Grid::read(&map, yaml_path.parent().unwrap_or(Path::new("")))?)
}

fn unreadable(reason: std::io::Error) -> String {
    format!("this map for the background can't be read: {reason}; give the YAML file of a ROS map")
}

/// Returns the picture of a map, if the file is a map.
pub(crate) fn picture(path: &Path) -> Option<PathBuf> {
    let text = file::read_text(path, MAX_YAML_BYTES).ok()?;
    let map = (Format::detect(&text) == Format::RosMap)
        .then(|| MapFile::read(&text, &mut Ignored::default()).ok());
    Some(map.flatten()?.image(path.parent().unwrap_or(Path::new(""))))
}

/// Returns outlines in metres.
fn outlines(grid: &Grid) -> Result<Vec<Vec<DVec2>>, String> {
    let lines = outline::outlines(grid).ok_or_else(|| {
        let most = outline::MAX_POINTS;
        format!(
            "the outlines of the occupied space have more than {most} corners: they aren't drawn; \
             clean the map up"
        )
    })?;
    let mut outlines = Vec::new();
    for line in lines {
        let points = line.into_iter().map(|[x, y]| DVec2::new(x.into(), y.into()));
        outlines.push(points.map(|point| grid.metres(point)).collect());
    }
    Ok(outlines)
}

fn report_roadmap(roadmap: &Roadmap, grid: &Grid, width: u32, report: &mut Report<'_>) {
    let areas = areas_without_road(&roadmap.points, grid);
    match (roadmap.edges.is_empty(), areas) {
        (true, None) => {
            let message = format!(
                "a robot of {width} mm can't drive anywhere on this map: check `resolution` and \
                 the width"
            );
            report.file_error(0, message);
        }
        (true, Some(areas)) => report.file_error(
            0,
            format!("no road was found for a robot of {width} mm: {areas}; check `resolution`"),
        ),
        (false, Some(areas)) => report.file_warning(0, areas),
        (false, None) => {}
    }
    if roadmap.dropped > 0 {
        let (dropped, length) = (roadmap.dropped, roadmap.dropped_length);
        let message = format!(
            "{dropped} parts of the free space, with {length:.1} m of roads in all, aren't \
             connected to the rest and are left out: each is shorter than five times the robot's \
             width"
        );
        report.file_warning(0, message);
    }
    if !roadmap.edges.is_empty() {
        report_throats(roadmap, grid, width, report);
    }
}

/// Tells that passages may have no road though the robot fits through them, as cells are large.
fn report_throats(roadmap: &Roadmap, grid: &Grid, width: u32, report: &mut Report<'_>) {
    let robot_cells = f64::from(width) / 1000.0 / grid.resolution;
    if roadmap.apart.is_none() && !throats::is_coarse(robot_cells) {
        return;
    }
    let least = throats::sure_width(robot_cells) * grid.resolution;
    let apart = roadmap.apart.map(|nodes| nodes.map(|node| grid.metres(node)));
    let apart = apart.map_or_else(String::new, |[one, other]| {
        format!(
            ", and the roads at ({:.1} m, {:.1} m) and ({:.1} m, {:.1} m) aren't connected, though \
             such a robot fits through between them",
            one.x, one.y, other.x, other.y
        )
    });
    report.assumption(
        0,
        format!(
            "passages of less than {least:.2} m may have no road, for robots of {width} mm on \
             cells of {} m{apart}: give a map of a finer `resolution`, or a smaller `--skeleton \
             WIDTH`, which takes robots closer to walls",
            grid.resolution
        ),
    );
}

/// Returns the free areas whose skeleton is a point, in words.
fn areas_without_road(points: &[DVec2], grid: &Grid) -> Option<String> {
    let first = grid.metres(*points.first()?);
    let (areas, are) = match points.len() {
        1 => ("1 free area".to_owned(), "is"),
        count => (format!("{count} free areas"), "are"),
    };
    Some(format!(
        "{areas} ({:.1} m, {:.1} m) {are} about as long as wide, so that a road along the middle \
         shrinks to a point there: draw roads by hand, with this map as `--background`",
        first.x, first.y
    ))
}

/// Makes two edges of each road, one for each direction.
fn layout(roadmap: &Roadmap, grid: &Grid, background: Vec<Vec<DVec2>>) -> Layout {
    let nodes = (1..).zip(&roadmap.nodes).map(|(id, &position): (usize, _)| LayoutNode {
        id: id.to_string(),
        position: Some(grid.metres(position)),
        ..LayoutNode::default()
    });
    let directions = roadmap.edges.iter().flat_map(|&[from, to]| [[from, to], [to, from]]);
    let edges = (1..).zip(directions).map(|(id, [from, to]): (usize, _)| LayoutEdge {
        id: id.to_string(),
        origin: (from + 1).to_string(),
        destination: (to + 1).to_string(),
        ..LayoutEdge::default()
    });
    let background = background.into_iter().map(Into::into).collect();
    Layout { nodes: nodes.collect(), edges: edges.collect(), background, ..Layout::default() }
}
