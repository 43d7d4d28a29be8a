//! Reads scenarios from files and texts.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use serde::de::IgnoredAny;

use super::explain::explain;
use super::yaml::ScenarioFile;
use super::{MAX_FILE_BYTES, Overrides, Scenario, ScenarioError, resolve};
use crate::graph::{self, Findings, GraphError, ReadOptions, RouteGraph};

impl Scenario {
    /// Reads a scenario and its graph.
    ///
    /// # Errors
    /// If either can't be read or is invalid; the message names the file, the entry and what to do.
    pub fn read(path: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let file = std::fs::File::open(path).map_err(|source| ScenarioError::Read { path: path.into(), source })?;
        Self::read_from(file, path, overrides)
    }

    /// Reads a scenario from anything that can be read, and its graph from a file. `name` is the path that messages name,
    /// and that other paths are relative to.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn read_from(reader: impl Read, name: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        Self::from_text(&read_text(reader, name)?, name, overrides)
    }

    /// Reads a scenario from its text, and its graph from a file. `name` is as in [`Scenario::read_from`].
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn from_text(text: &str, name: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let folder = name.parent().unwrap_or(Path::new(""));
        Self::parse(text, name, overrides, |graph, options| graph::read(&folder.join(graph), options))
    }

    /// Reads a built-in scenario from texts; `graph_text` replaces the graph file that the scenario names.
    ///
    /// # Errors
    /// As [`Scenario::read`].
    pub fn from_texts(text: &str, graph_text: &str, name: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        Self::parse(text, name, overrides, |graph, options| {
            graph::parse(graph_text, &graph.display().to_string(), options)
        })
    }

    fn parse(
        text: &str,
        path: &Path,
        overrides: &Overrides,
        read_graph: impl FnOnce(&Path, &ReadOptions) -> Result<(RouteGraph, Findings), GraphError>,
    ) -> Result<Self, ScenarioError> {
        let yaml_error = |source| ScenarioError::Yaml { path: path.into(), problem: explain(&source), source };
        let file: ScenarioFile = serde_yaml::from_str(text).map_err(yaml_error)?;
        let (graph, findings) = read_graph(&file.graph, &ReadOptions { handles: overrides.handles })?;
        let warnings = findings.as_slice().iter().map(ToString::to_string).collect();
        resolve::resolve(file, path, graph, warnings, overrides)
    }
}

/// Whether a text is a scenario, valid or not, rather than a route graph: only scenarios have the key `graph`.
pub fn is_scenario(text: &str) -> bool {
    serde_yaml::from_str::<BTreeMap<String, IgnoredAny>>(text).is_ok_and(|keys| keys.contains_key("graph"))
}

fn read_text(reader: impl Read, path: &Path) -> Result<String, ScenarioError> {
    let mut text = String::new();
    // Limited while reading, because the size of a pipe or a device isn't known in advance.
    let read = reader.take(MAX_FILE_BYTES + 1).read_to_string(&mut text);
    read.map_err(|source| ScenarioError::Read { path: path.into(), source })?;
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(ScenarioError::TooLarge { path: path.into() });
    }
    Ok(text)
}
