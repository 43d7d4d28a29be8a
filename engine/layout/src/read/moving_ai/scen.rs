//! Scenarios of the MovingAI benchmarks: pairs of a start and a goal, and their conversion to a
//! scenario of Regatta.

use std::collections::VecDeque;
use std::fmt::Write as _;

use regatta_base::graph::{Leg, NodeIndex};

use crate::model::route_graph::RouteGraph;

/// A pair of a start and a goal.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenEntry {
    /// The file name of the map.
    pub map: String,
    /// The columns and rows of the map; `None` in files without a version.
    pub size: Option<[u32; 2]>,
    /// The column and the row of the start, from 0 at the top left.
    pub start: [u32; 2],
    /// The column and the row of the goal.
    pub goal: [u32; 2],
    /// The length of the shortest path with diagonal steps, in cells.
    pub length: f64,
}

/// The error of reading a scenario.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct ScenError {
    /// The line, from 1.
    pub line: usize,
    /// The problem.
    pub message: String,
}

/// The text of a scenario file for Regatta.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScenarioText {
    /// The YAML.
    pub text: String,
    /// The entries that have no robot, each with the reason.
    pub skipped: Vec<String>,
}

/// Reads the text of a `.scen` file.
///
/// # Errors
/// If a line isn't an entry, or there are none.
pub fn scen(text: &str) -> Result<Vec<ScenEntry>, ScenError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = (1..).zip(text.lines().map(str::trim)).filter(|(_, line)| !line.is_empty());
    let entries = lines.filter(|(_, line)| !line.starts_with("version"));
    let entries: Vec<_> =
        entries.map(|(line, text)| entry(line, text)).collect::<Result<_, _>>()?;
    if entries.is_empty() {
        return Err(ScenError {
            line: 1,
            message: "the scenario has no pair of a start and a goal".to_owned(),
        });
    }
    Ok(entries)
}

/// Reads a line: bucket, map, width and height (absent in files without a version), start, goal,
/// length. Names of maps may contain spaces if tabs separate the columns.
fn entry(line: usize, text: &str) -> Result<ScenEntry, ScenError> {
    let columns: Vec<&str> = if text.contains('\t') {
        text.split('\t').map(str::trim).collect()
    } else {
        text.split_whitespace().collect()
    };
    parse_columns(&columns).ok_or_else(|| ScenError {
        line,
        message: "expected bucket, map, width, height, start column and row, goal column and row, \
                  length"
            .to_owned(),
    })
}

fn parse_columns(columns: &[&str]) -> Option<ScenEntry> {
    let (map, size, [x, y, goal_x, goal_y, length]) = match *columns {
        [_, map, width, height, x, y, goal_x, goal_y, length] => {
            (map, Some(pair(width, height)?), [x, y, goal_x, goal_y, length])
        }
        [_, map, x, y, goal_x, goal_y, length] => (map, None, [x, y, goal_x, goal_y, length]),
        _ => return None,
    };
    let length = length.parse().ok().filter(|length: &f64| length.is_finite())?;
    let (start, goal) = (pair(x, y)?, pair(goal_x, goal_y)?);
    Some(ScenEntry { map: map.to_owned(), size, start, goal, length })
}

fn pair(x: &str, y: &str) -> Option<[u32; 2]> {
    Some([x.parse().ok()?, y.parse().ok()?])
}

/// Makes a scenario of the first `robots` entries. Each robot drives a path with the fewest edges
/// from its start to its goal, once. `graph` is the map of the entries, as read from a file with
/// `width` columns. `graph_file` is the path of this file in the scenario. Entries with unreachable
/// goals are skipped.
pub fn scenario_yaml(
    entries: &[ScenEntry],
    graph_file: &str,
    graph: &RouteGraph,
    width: u32,
    robots: usize,
) -> ScenarioText {
    // A JSON string is also a YAML string, whatever characters it contains.
    let quoted = serde_json::Value::from(graph_file);
    let mut scenario =
        ScenarioText { text: format!("graph: {quoted}\nrobots:\n"), skipped: Vec::new() };
    let mut search = Search::new(graph);
    for (number, entry) in (1..).zip(entries.iter().take(robots)) {
        match route(entry, graph, width, &mut search) {
            Ok(robot) => scenario.text.push_str(&robot),
            Err(reason) => scenario.skipped.push(format!("entry {number}: {reason}")),
        }
    }
    if scenario.skipped.len() >= entries.len().min(robots) {
        scenario.text = format!("graph: {quoted}\nrobots: []\n");
    }
    scenario
}

/// Returns the YAML of one robot.
fn route(
    entry: &ScenEntry,
    graph: &RouteGraph,
    width: u32,
    search: &mut Search<'_>,
) -> Result<String, String> {
    if let Some(size) = entry.size.filter(|size| size[0] != width) {
        return Err(format!("it is for a map of {} columns, this one has {width}", size[0]));
    }
    let start = node(graph, width, entry.start)
        .ok_or_else(|| format!("its start, {}", not_free(entry.start)))?;
    let goal = node(graph, width, entry.goal)
        .ok_or_else(|| format!("its goal, {}", not_free(entry.goal)))?;
    if start == goal {
        return Ok(format!("- node: {}\n", graph.node(start).id));
    }
    let legs = search.path(start, goal).ok_or("no path leads from its start to its goal")?;
    let mut text = String::from("- route: [");
    for (index, leg) in legs.iter().enumerate() {
        let separator = if index == 0 { "" } else { ", " };
        let _infallible = write!(text, "{separator}{}", graph.edge(leg.edge).id);
    }
    text.push_str("]\n  repeat: once\n");
    Ok(text)
}

/// Returns the node of a free cell.
fn node(graph: &RouteGraph, width: u32, [column, row]: [u32; 2]) -> Option<NodeIndex> {
    let id = row.checked_mul(width)?.checked_add(column)?;
    graph.node_by_id(id).filter(|_| column < width)
}

fn not_free([column, row]: [u32; 2]) -> String {
    format!("column {column} of row {row}, isn't a free cell")
}

/// Breadth-first search, with memory that is kept from one search to the next.
struct Search<'graph> {
    graph: &'graph RouteGraph,
    /// The leg by which a node was reached, and the number of the search that reached it.
    reached: Vec<(Option<Leg>, u32)>,
    searches: u32,
}

impl<'graph> Search<'graph> {
    fn new(graph: &'graph RouteGraph) -> Self {
        Self { graph, reached: vec![(None, 0); graph.nodes().len()], searches: 0 }
    }

    /// Returns the legs of a path with the fewest edges, forwards only.
    fn path(&mut self, start: NodeIndex, goal: NodeIndex) -> Option<Vec<Leg>> {
        self.searches += 1;
        let mut queue = VecDeque::from([start]);
        self.reached[start.0 as usize] = (None, self.searches);
        while let Some(node) = queue.pop_front() {
            if node == goal {
                return Some(self.legs_to(goal));
            }
            for &leg in self.graph.departures(node) {
                let next = self.graph.leg_end(leg);
                let reached = &mut self.reached[next.0 as usize];
                if reached.1 != self.searches && leg.gear == crate::Gear::Forward {
                    *reached = (Some(leg), self.searches);
                    queue.push_back(next);
                }
            }
        }
        None
    }

    fn legs_to(&self, mut node: NodeIndex) -> Vec<Leg> {
        let mut legs = Vec::new();
        while let Some(leg) = self.reached[node.0 as usize].0 {
            legs.push(leg);
            node = self.graph.leg_start(leg);
        }
        legs.reverse();
        legs
    }
}
