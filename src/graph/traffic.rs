//! `--traffic` of `regatta graph check` and `regatta graph draw`: what a layout allows robots.

use std::collections::BTreeSet;

use clap::Args;
use regatta_layout::traffic::{
    Certainty, Certificate, Remark, RobotType, RobotTypeError, Topic, Turning,
};
use regatta_layout::{EdgeIndex, NodeIndex, ReadOptions, RouteGraph};
use regatta_scenario::Scenario;
use serde_json::{Value, json};

use crate::failure::Failure;

/// The largest number of lines about one topic; JSON has all.
const MOST_LINES: usize = 12;

/// The options of a certificate of traffic.
#[derive(Args, Debug)]
pub struct TrafficArgs {
    /// Also show what the layout allows robots: single tracks, dead ends, rings, stations in the
    /// way
    #[arg(long)]
    traffic: bool,
    /// Length of robots; if not given, those of each type of a scenario, or that of the robots that
    /// `regatta run` puts on a layout
    #[arg(long, value_name = "METRES", requires = "traffic")]
    length: Option<f64>,
    /// Width of robots; if not given, that of the same robots
    #[arg(long, value_name = "METRES", requires = "traffic")]
    width: Option<f64>,
    /// Robots never turn on the spot
    #[arg(long, requires = "traffic")]
    no_turns: bool,
}

impl TrafficArgs {
    /// Returns the robots that a certificate of a layout is wanted for, if one is. `options` are
    /// those with which it was read.
    ///
    /// # Errors
    /// Returns an error if a size is out of range.
    pub fn robot_on(
        &self,
        graph: &RouteGraph,
        options: &ReadOptions,
    ) -> Result<Option<RobotType>, Failure> {
        if !self.traffic {
            return Ok(None);
        }
        Ok(Some(self.robot_like(RobotType::of_layout(graph, options))?))
    }

    /// The same for the layout of a scenario: each of its types in use, the largest first. If a
    /// size is given, there is one type, with the other size of the largest.
    ///
    /// # Errors
    /// Returns an error if a size is out of range.
    pub fn robots_of(&self, scenario: &Scenario) -> Result<Vec<NamedRobot>, Failure> {
        if !self.traffic {
            return Ok(Vec::new());
        }
        let mut robots = robots_in_use(scenario)?;
        if self.has_size() {
            robots.truncate(1);
        }
        for NamedRobot { robot, name } in &mut robots {
            *robot = self.robot_like(*robot)?;
            if self.has_size() {
                *name = None;
            }
        }
        Ok(robots)
    }

    /// Whether a size is given.
    fn has_size(&self) -> bool {
        self.length.is_some() || self.width.is_some()
    }

    fn robot_like(&self, default: RobotType) -> Result<RobotType, RobotTypeError> {
        let turning = if self.no_turns { Turning::Never } else { default.turning() };
        if !self.has_size() {
            return Ok(default.with_turning(turning));
        }
        let (length, width) =
            (self.length.unwrap_or(default.length()), self.width.unwrap_or(default.width()));
        RobotType::new(length, width, turning)
    }
}

/// The robots that a certificate is about.
pub struct NamedRobot {
    pub robot: RobotType,
    /// Their type in words, if it is one of a scenario.
    name: Option<String>,
}

impl From<RobotType> for NamedRobot {
    fn from(robot: RobotType) -> Self {
        Self { robot, name: None }
    }
}

/// Returns the types of a scenario's robots, that with the largest footprint first.
///
/// # Errors
/// Returns an error if one is too large or too small for a certificate.
fn robots_in_use(scenario: &Scenario) -> Result<Vec<NamedRobot>, RobotTypeError> {
    let in_use: BTreeSet<u16> = scenario.groups.iter().map(|group| group.robot_type).collect();
    let mut robots = Vec::new();
    for kind in in_use.iter().filter_map(|&index| scenario.robot_types.get(index as usize)) {
        let name = Some(format!("type `{}`", kind.name));
        robots.push(NamedRobot { robot: kind.in_traffic()?, name });
    }
    if robots.is_empty() {
        robots.push(RobotType::default().into());
    }
    robots.sort_by(|a, b| b.robot.area().total_cmp(&a.robot.area()));
    Ok(robots)
}

/// The certificates of a layout for one type of robots.
pub struct Traffic {
    robot: NamedRobot,
    safe_robots: Option<u32>,
    remarks: Vec<(Remark, Names)>,
}

/// The nodes and edges of a remark.
struct Names {
    nodes: Vec<Value>,
    edges: Vec<u32>,
}

impl Traffic {
    /// Examines a layout.
    pub fn new(graph: &RouteGraph, robot: NamedRobot) -> Self {
        let certificate = Certificate::new(graph, &robot.robot);
        let remarks = certificate.remarks(graph).into_iter();
        let remarks = remarks.map(|remark| {
            let names = Names {
                nodes: remark.nodes.iter().map(|&node| node_name(graph, node)).collect(),
                edges: remark.edges.iter().map(|&edge| edge_id(graph, edge)).collect(),
            };
            (remark, names)
        });
        let safe_robots = certificate.safe_robots();
        Self { robot, safe_robots, remarks: remarks.collect() }
    }

    /// Returns a line about the robots, and one for each remark, the first ones of each topic.
    pub fn lines(&self) -> Vec<String> {
        let NamedRobot { robot, name } = &self.robot;
        let turns = match robot.turning() {
            Turning::OnTheSpot => "that turn on the spot",
            Turning::Never => "that never turn on the spot",
        };
        let name = name.as_ref().map_or_else(String::new, |name| format!("{name}; "));
        let mut lines = vec![format!(
            "traffic of {} {turns} ({name}--length, --width, --no-turns):",
            robot.in_words()
        )];
        for remarks in self.remarks.chunk_by(|a, b| a.0.topic == b.0.topic) {
            let shown = remarks.iter().take(MOST_LINES);
            lines.extend(shown.map(|(remark, _)| line(remark)));
            if let Some(more @ 1..) = remarks.len().checked_sub(MOST_LINES) {
                let topic = topic_name(remarks[0].0.topic);
                lines.push(format!("  {topic}: {more} more; --json lists all"));
            }
        }
        lines
    }

    /// Returns the robots and all remarks.
    pub fn json(&self) -> Value {
        let remarks: Vec<Value> =
            self.remarks.iter().map(|(remark, names)| remark_json(remark, names)).collect();
        json!({
            "robot": self.robot.robot,
            "robot_type": self.robot.name,
            "safe_robots": self.safe_robots,
            "remarks": remarks,
        })
    }
}

fn line(remark: &Remark) -> String {
    format!("  {}: {}", topic_name(remark.topic), remark.message)
}

fn topic_name(topic: Topic) -> String {
    topic.name().replace('-', " ")
}

fn remark_json(remark: &Remark, names: &Names) -> Value {
    json!({
        "topic": remark.topic.name(),
        "message": remark.message,
        "nodes": names.nodes,
        "edges": names.edges,
        "robots": remark.robots.map(|count| count.robots),
        "exact": remark.robots.map(|count| count.certainty == Certainty::Exact),
        "metres": remark.metres,
    })
}

fn node_name(graph: &RouteGraph, node: NodeIndex) -> Value {
    let node = graph.node(node);
    json!({"id": node.id, "name": node.name()})
}

fn edge_id(graph: &RouteGraph, edge: EdgeIndex) -> u32 {
    graph.edge(edge).id
}
