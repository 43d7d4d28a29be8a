//! `regatta graph check`: lists everything that is wrong with a route graph, or with a scenario and
//! its route graph. A scenario is begun in this process, so that it meets all that a run does.

use std::path::Path;
use std::process::ExitCode;

use regatta_base::yaml;
use regatta_layout::{Detail, FileText, Finding, Findings, GraphError};
use regatta_orders::{Load, Places};
use regatta_plugin::{Frame, Plugin, World};
use regatta_run::Run;
use regatta_scenario::{Overrides, Scenario, ScenarioError, Warnings, is_scenario};
use serde_json::{Value, json};

use super::FileArgs;
use super::traffic::{Traffic, TrafficArgs};
use crate::failure::Failure;
use crate::output::{show, with_plural};
use crate::progress::Progress;
use crate::run::LOAD;
use crate::scenario::{is_verbose, viewer_args};

/// The result of a check.
struct Checked {
    /// `route graph` or `scenario`.
    kind: &'static str,
    /// The contents if it is valid: `21 edges, 8 nodes`.
    content: Option<String>,
    findings: Findings,
    /// Errors and warnings about the scenario itself.
    scenario_error: Option<ScenarioError>,
    scenario_warnings: Vec<String>,
    /// The error of beginning a run of the scenario.
    start_error: Option<String>,
    /// The traffic that the layout allows, by robot type, if that was asked for.
    traffic: Vec<Traffic>,
}

pub fn run(file: &FileArgs, json: bool, traffic: &TrafficArgs) -> Result<ExitCode, Failure> {
    let progress = Progress::start(format!("checking {}", file.name()), 0);
    let text = file.text()?;
    let checked = match regatta_layout::parse(&text, &file.name(), &file.options()) {
        Ok((graph, findings)) => {
            let content = format!(
                "{}, {}",
                with_plural(graph.edges().len(), "edge"),
                with_plural(graph.nodes().len(), "node")
            );
            let robot = traffic.robot_on(&graph, &file.options())?;
            let traffic = robot.map(|robot| Traffic::new(&graph, robot.into()));
            let traffic = traffic.into_iter().collect();
            Checked { traffic, ..Checked::route_graph(Some(content), findings) }
        }
        Err(_) if is_scenario(&text) => check_scenario(&text, file, traffic)?,
        Err(GraphError::Invalid(findings)) => Checked::route_graph(None, findings),
        Err(error) => return Err(error.into()),
    };
    drop(progress);
    let name = file.name();
    match json {
        true => println!("{:#}", checked.json(&name)),
        false => show(checked.text(&name)),
    }
    Ok(if checked.errors() == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn check_scenario(
    text: &FileText,
    file: &FileArgs,
    traffic: &TrafficArgs,
) -> Result<Checked, Failure> {
    let overrides = Overrides { layout: file.options(), ..Overrides::default() };
    let checked = Checked { kind: "scenario", ..Checked::route_graph(None, Findings::default()) };
    let read = Scenario::from_text(text, Path::new(&file.name()), &overrides)
        .and_then(|scenario| viewer_args(&scenario).map(|_| scenario));
    match read {
        Ok(scenario) => {
            let robots = with_plural(scenario.robots() as usize, "robot");
            let edges = with_plural(scenario.graph.edges().len(), "edge");
            let content = Some(format!("{robots} on {edges}"));
            let robots = traffic.robots_of(&scenario)?.into_iter();
            let traffic = robots.map(|robot| Traffic::new(&scenario.graph, robot)).collect();
            let Warnings { of_scenario, of_layout } = scenario.warnings.clone();
            let start_error = start_error(scenario, file);
            let content = content.filter(|_| start_error.is_none());
            Ok(Checked {
                content,
                findings: of_layout,
                scenario_warnings: of_scenario,
                start_error,
                traffic,
                ..checked
            })
        }
        Err(ScenarioError::Graph(GraphError::Invalid(findings))) => {
            Ok(Checked { findings, ..checked })
        }
        Err(error @ (ScenarioError::Yaml { .. } | ScenarioError::Invalid { .. })) => {
            Ok(Checked { scenario_error: Some(error), ..checked })
        }
        Err(error) => Err(error.into()),
    }
}

/// Begins a run of the scenario of a file, and returns the error of that, if any.
fn start_error(scenario: Scenario, file: &FileArgs) -> Option<String> {
    let (name, folder) = (file.name(), file.folder());
    let text = scenario.source.has(LOAD).then(|| scenario.source.text().to_owned());
    let mut load = LoadReader { text, folder, error: None };
    let begun = Run::new(scenario).with(&mut load).for_ticks(0);
    let load_error = load.error.map(|error| format!("{name}:{}: {}", error.line, error.reason));
    load_error.or_else(|| begun.err().map(|error| format!("{name}: {error}")))
}

/// Reads a load as the fleet manager does, by the places of the world.
struct LoadReader<'a> {
    text: Option<String>,
    /// The folder of the scenario, with the files of orders; none of standard input.
    folder: Option<&'a Path>,
    error: Option<yaml::Error>,
}

impl Plugin for LoadReader<'_> {
    fn on_world(&mut self, world: &World<'_>) -> regatta_plugin::Result {
        if let Some(text) = &self.text {
            self.error = Load::parse_beside(self.folder, text, &Places::of(world)).err();
        }
        Ok(())
    }

    fn on_frame(&mut self, _frame: &Frame<'_>) -> regatta_plugin::Result {
        Ok(())
    }
}

/// The detail in which findings are listed: with `-v`, things that aren't used have a line each.
fn detail() -> Detail {
    if is_verbose() { Detail::Each } else { Detail::Grouped { most: usize::MAX } }
}

impl Checked {
    fn route_graph(content: Option<String>, findings: Findings) -> Self {
        Self {
            kind: "route graph",
            content,
            findings,
            scenario_error: None,
            scenario_warnings: Vec::new(),
            start_error: None,
            traffic: Vec::new(),
        }
    }

    fn errors(&self) -> usize {
        self.findings.errors()
            + usize::from(self.scenario_error.is_some() || self.start_error.is_some())
    }

    fn warnings(&self) -> usize {
        self.findings.warnings() + self.scenario_warnings.len()
    }

    /// Formats the findings, the most important first, and a summary line.
    fn text(&self, file: &str) -> String {
        let mut lines: Vec<String> =
            self.scenario_error.iter().map(ScenarioError::to_string).collect();
        lines.extend(self.start_error.iter().cloned());
        lines.extend(self.scenario_warnings.iter().cloned());
        lines.extend(self.findings.told(detail()));
        let listed = self.findings.as_slice().len();
        let unlisted = self.findings.errors() + self.findings.warnings() - listed;
        if unlisted > 0 {
            lines.push(format!("({unlisted} more findings are not listed)"));
        }
        let summary = match (&self.content, self.kind) {
            (Some(content), "scenario") => format!("a scenario that can be run: {content}"),
            (None, "scenario") => "a scenario that can't be run".to_owned(),
            (Some(content), _) => format!("can be driven: {content}"),
            (None, _) => "can't be driven".to_owned(),
        };
        let errors = with_plural(self.errors(), "error");
        let warnings = with_plural(self.warnings(), "warning");
        lines.push(format!("{file}: {summary}; {errors}, {warnings}"));
        lines.extend(self.traffic.iter().flat_map(Traffic::lines));
        lines.join("\n") + "\n"
    }

    fn json(&self, file: &str) -> Value {
        let mut findings: Vec<_> = self.findings.as_slice().iter().map(finding_json).collect();
        if let Some(error) = &self.scenario_error {
            findings.push(json!({"severity": "error", "message": error.to_string()}));
        }
        if let Some(error) = &self.start_error {
            findings.push(json!({"severity": "error", "message": error}));
        }
        for warning in &self.scenario_warnings {
            findings.push(json!({"severity": "warning", "message": warning}));
        }
        let mut checked = json!({
            "file": file,
            "kind": self.kind,
            "valid": self.errors() == 0,
            "errors": self.errors(),
            "warnings": self.warnings(),
            "findings": findings,
        });
        if let Some((largest, others)) = self.traffic.split_first() {
            checked["traffic"] = largest.json();
            if !others.is_empty() {
                checked["traffic_of_other_types"] = others.iter().map(Traffic::json).collect();
            }
        }
        checked
    }
}

fn finding_json(finding: &Finding) -> Value {
    json!({
        "severity": finding.severity.to_string(),
        "file": finding.file,
        "line": finding.line,
        "subject": finding.subject.kind(),
        "id": finding.subject.id(),
        "message": finding.message,
    })
}
