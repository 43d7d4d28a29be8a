//! Reads scenarios from files and texts.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use regatta_base::yaml::{self, check_limits};
use regatta_layout::read::moving_ai;
use regatta_layout::{
    self as layout, FileText, FindingKind, Findings, Format, GraphError, LengthUnit, Millimetres,
    ReadOptions, RouteGraph, SourceText,
};
use serde::de::{DeserializeOwned, IgnoredAny};

use super::default_scenario::{default_scenario, limits};
use super::explain::{GRAPH_KEYS, SCENARIO_KEYS, explain, is_misspelt};
use super::yaml::{LayoutEntry, ScenarioFile};
use super::{MAX_FILE_BYTES, Overrides, Scenario, ScenarioError, Source, Warnings, resolve};

/// The largest number of assumptions of a layout that are told.
const MAX_ASSUMPTIONS: usize = 6;

impl Scenario {
    /// Reads a scenario and its graph.
    ///
    /// # Errors
    /// If either can't be read or is invalid; the message names the file, the entry and what to do.
    pub fn read(path: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let text = match layout::read_file(path) {
            Err(GraphError::Unreadable { file, source }) => {
                return Err(ScenarioError::Read { path: file, source });
            }
            text => text?,
        };
        Self::from_text(&text, path, overrides)
    }

    /// Reads a scenario from anything that can be read, and its graph from a file. `name` is the
    /// path that messages name, and that other paths are relative to.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn read_from(
        reader: impl Read,
        name: &Path,
        overrides: &Overrides,
    ) -> Result<Self, ScenarioError> {
        Self::from_text(&read_text(reader, name)?, name, overrides)
    }

    /// Reads a scenario from its text, and its graph from a file. `name` is as in
    /// [`Scenario::read_from`].
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn from_text<'text>(
        text: impl Into<SourceText<'text>>,
        name: &Path,
        overrides: &Overrides,
    ) -> Result<Self, ScenarioError> {
        let source = text.into();
        let text = source.as_str();
        if !is_benchmark(text) && is_layout(text) {
            return Self::of_layout(source, name, overrides);
        }
        let mut scenario = Self::of_scenario(text, name, overrides)?;
        if let Some((line, message)) = source.doubt() {
            scenario
                .warnings
                .of_scenario
                .push(format!("{}:{line}: warning: {message}", name.display()));
        }
        Ok(scenario)
    }

    /// Reads a scenario of our own or of the benchmarks.
    fn of_scenario(text: &str, name: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let folder = name.parent().unwrap_or(Path::new(""));
        if is_benchmark(text) {
            return Self::of_benchmark(text, name, folder, overrides);
        }
        if text.len() as u64 > MAX_FILE_BYTES {
            return Err(ScenarioError::TooLarge { path: name.into() });
        }
        if has_no_key(text) {
            return Err(ScenarioError::Neither { path: name.into() });
        }
        Self::parse(text, name, overrides, |graph, options| {
            layout::read(&folder.join(graph), options)
        })
    }

    /// Reads a built-in scenario from texts; `graph_text` replaces the graph file that the scenario
    /// names.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn from_texts(
        text: &str,
        graph_text: &str,
        name: &Path,
        overrides: &Overrides,
    ) -> Result<Self, ScenarioError> {
        Self::parse(text, name, overrides, |graph, options| {
            layout::parse(graph_text, &graph.display().to_string(), options)
        })
    }

    /// Reads a scenario of the MovingAI benchmarks and the map that it names.
    fn of_benchmark(
        text: &str,
        name: &Path,
        folder: &Path,
        overrides: &Overrides,
    ) -> Result<Self, ScenarioError> {
        let source = Source { path: name.into(), text: text.into() };
        let entries =
            moving_ai::scen(text).map_err(|error| source.invalid("entries", error.to_string()))?;
        let Some(first) = entries.first() else {
            return Err(source.invalid("entries", "there are none".to_owned()));
        };
        // Benchmarks name maps by paths of their own; they lie beside the scenario.
        let map = Path::new(&first.map)
            .file_name()
            .map_or_else(|| folder.join(&first.map), |map| folder.join(map));
        let (graph, findings) = layout::read(&map, &overrides.layout)?;
        let columns = first
            .size
            .map(|[columns, _]| columns)
            .or_else(|| moving_ai::columns(&map))
            .ok_or_else(|| source.invalid("entries", "no map size".to_owned()))?;
        let scenario =
            moving_ai::scenario_yaml(&entries, &first.map, &graph, columns, entries.len());
        let mut parsed =
            Self::parse(&scenario.text, name, overrides, |_, _| Ok((graph, findings)))?;
        let skipped = scenario
            .skipped
            .into_iter()
            .map(|entry| format!("{}: warning: {entry}: left out", name.display()));
        parsed.warnings.of_scenario.extend(skipped);
        Ok(parsed)
    }

    /// Makes a scenario up for a layout.
    fn of_layout(
        text: SourceText<'_>,
        name: &Path,
        overrides: &Overrides,
    ) -> Result<Self, ScenarioError> {
        let (graph, findings) =
            layout::parse(text, &name.display().to_string(), &overrides.layout)?;
        let file = name.file_name().unwrap_or_default().to_string_lossy();
        let text = default_scenario(&graph, &file, &overrides.layout);
        let limits = limits(&graph);
        let mut scenario = Self::parse(&text, name, overrides, |_, _| Ok((graph, findings)))?;
        let of_fleet =
            limits.into_iter().map(|limit| format!("{}: warning: {limit}", name.display()));
        scenario.warnings.of_scenario.splice(..0, of_fleet);
        Ok(Self { is_default: true, ..scenario })
    }

    fn parse(
        text: &str,
        path: &Path,
        overrides: &Overrides,
        read_graph: impl FnOnce(&Path, &ReadOptions) -> Result<(RouteGraph, Findings), GraphError>,
    ) -> Result<Self, ScenarioError> {
        let source = Source { path: path.into(), text: text.into() };
        let file: ScenarioFile = source.sections()?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let options = layout_options(&file.layout, &overrides.layout, folder)
            .map_err(|message| source.invalid("layout", message))?;
        let (graph, findings) = read_graph(&file.graph, &options)?;
        let scenario = resolve::resolve(file, source, graph, overrides)?;
        let all_turn = scenario.robot_types.iter().all(|kind| kind.max_rotation_speed > 0.0);
        let assumptions = assumptions_of_layout(&findings);
        // If all robots can turn on the spot, warnings of turns at nodes don't matter.
        let of_layout =
            if all_turn { findings.without(FindingKind::TurnsAtNodes) } else { findings };
        let warnings = Warnings { of_layout, ..scenario.warnings };
        Ok(Scenario { warnings, assumptions, ..scenario })
    }
}

/// Returns the first assumptions of reading the layout, and the number of the others.
fn assumptions_of_layout(findings: &Findings) -> Vec<String> {
    let mut found =
        findings.as_slice().iter().filter(|finding| finding.kind == FindingKind::Assumption);
    let mut told: Vec<String> =
        found.by_ref().take(MAX_ASSUMPTIONS).map(|finding| finding.message.clone()).collect();
    match found.count() {
        0 => {}
        more => told.push(format!("{more} more, which `regatta graph check` lists")),
    }
    told
}

/// Returns the options of reading the layout of a scenario. Those of the command line override
/// those of the scenario.
fn layout_options(
    entry: &LayoutEntry,
    overrides: &ReadOptions,
    folder: &Path,
) -> Result<ReadOptions, String> {
    let format = entry
        .format
        .as_deref()
        .map(str::parse::<Format>)
        .transpose()
        .map_err(|error| error.to_string())?;
    let units = entry
        .units
        .as_deref()
        .map(str::parse::<LengthUnit>)
        .transpose()
        .map_err(|error| error.to_string())?;
    let skeleton = length("skeleton", entry.skeleton)?;
    let cell_size = length("cell_size", entry.cell_size)?;
    let overrides = overrides.clone();
    Ok(ReadOptions {
        handles: overrides.handles,
        format: overrides.format.or(format),
        level: overrides.level.or_else(|| entry.level.clone()),
        layers: if overrides.layers.is_empty() { entry.layers.clone() } else { overrides.layers },
        units: overrides.units.or(units),
        skeleton: overrides.skeleton.or(skeleton),
        vehicle_type: overrides.vehicle_type.or_else(|| entry.vehicle_type.clone()),
        cell_size: overrides.cell_size.or(cell_size),
        background: overrides
            .background
            .or_else(|| entry.background.as_ref().map(|map| folder.join(map))),
    })
}

fn length(name: &str, metres: Option<f64>) -> Result<Option<Millimetres>, String> {
    let length = metres.map(|metres| metres.to_string().parse()).transpose();
    length.map_err(|error| format!("{name}: {error}"))
}

/// Whether a text is a scenario of the MovingAI benchmarks.
fn is_benchmark(text: &str) -> bool {
    let first = text.trim_start_matches('\u{feff}').lines().find(|line| !line.trim().is_empty());
    first.is_some_and(|line| line.trim_start().starts_with("version "))
        && moving_ai::scen(text).is_ok()
}

/// Whether a text is a layout of some format rather than a scenario.
fn is_layout(text: &str) -> bool {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if Format::detect(text) != Format::Regatta || layout::read::is_unread(text) {
        return true;
    }
    let mut has_graph_key = false;
    for line in text.lines() {
        let Some(key) = first_key(line) else { continue };
        // A scenario may have `nodes`, too, but only a scenario has `graph`.
        if key == "graph" && !line.starts_with(' ') {
            return false;
        }
        has_graph_key |= is_key_of(&GRAPH_KEYS, key);
    }
    has_graph_key
}

fn is_key_of(keys: &[&str], key: &str) -> bool {
    keys.iter().any(|name| name.eq_ignore_ascii_case(key))
}

/// Returns the key that a line of YAML begins with.
fn first_key(line: &str) -> Option<&str> {
    let (key, _) = line.split_once(':')?;
    Some(key.trim_matches(|letter| "\"'{ ".contains(letter)))
}

/// Whether a text is a scenario, valid or not, rather than a route graph: only scenarios have the
/// key `graph`.
pub fn is_scenario(text: &str) -> bool {
    text.len() as u64 <= MAX_FILE_BYTES
        && check_limits(text).is_ok()
        && serde_yaml::from_str::<BTreeMap<String, IgnoredAny>>(text)
            .is_ok_and(|keys| keys.contains_key("graph"))
}

/// Reads any document in YAML, or in JSON, which is YAML: a scenario as it was written, for
/// example, to change it.
///
/// # Errors
/// [`ScenarioError::Yaml`] with the line and the entry. `path` is the file that messages name.
pub fn document<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, ScenarioError> {
    check_limits(text).map_err(|yaml::Error { line, reason }| ScenarioError::Invalid {
        path: path.into(),
        place: format!("line {line}"),
        message: reason,
    })?;
    serde_yaml::from_str(text).map_err(|source| ScenarioError::Yaml {
        path: path.into(),
        problem: explain(&source),
        source,
    })
}

/// Whether a text is empty, or a map without any key of a scenario or a graph, not even a misspelt
/// one.
fn has_no_key(text: &str) -> bool {
    if check_limits(text).is_err() {
        return false;
    }
    let keys = match serde_yaml::from_str::<Option<BTreeMap<String, IgnoredAny>>>(text) {
        Ok(keys) => keys.unwrap_or_default(),
        Err(_) => return false,
    };
    !keys.keys().any(|key| {
        is_key_of(&SCENARIO_KEYS, key)
            || is_key_of(&GRAPH_KEYS, key)
            || is_misspelt(key, &SCENARIO_KEYS)
    })
}

/// Reads a text, which may be a layout: these are larger than scenarios.
fn read_text(reader: impl Read, path: &Path) -> Result<FileText, ScenarioError> {
    Ok(match layout::read_stream(reader, &path.display().to_string()) {
        Err(GraphError::Unreadable { source, .. }) => {
            return Err(ScenarioError::Read { path: path.into(), source });
        }
        text => text?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scenario_with_nodes_of_its_own_is_no_layout() {
        for text in [
            "graph: a.yaml\nnodes: {1: {role: pick}}\n",
            "nodes:\n  1: {role: pick}\ngraph: a.yaml\n",
        ] {
            assert!(!is_layout(text), "{text}");
        }
        for text in
            ["Vertices: []\nEdges: []\n", "nodes:\n- {id: 1, x: 0, y: 0, label: 'graph: a'}\n"]
        {
            assert!(is_layout(text), "{text}");
        }
    }
}
