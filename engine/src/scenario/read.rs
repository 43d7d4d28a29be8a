//! Reads scenarios from files and texts.

use std::io::Read;
use std::path::Path;

use super::yaml::ScenarioFile;
use super::{MAX_FILE_BYTES, Overrides, Scenario, ScenarioError, resolve};
use crate::graph::{self, Findings, GraphError, ReadOptions, RouteGraph};

impl Scenario {
    /// Reads a scenario and its graph.
    ///
    /// # Errors
    /// If either can't be read or is invalid; the message names the file, the entry and what to do.
    pub fn read(path: &Path, overrides: &Overrides) -> Result<Self, ScenarioError> {
        let text = read_text(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, path, overrides, |graph, options| graph::read(&folder.join(graph), options))
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
        let yaml_error = |source| ScenarioError::Yaml { path: path.into(), source };
        let file: ScenarioFile = serde_yaml::from_str(text).map_err(yaml_error)?;
        let (graph, findings) = read_graph(&file.graph, &ReadOptions { handles: overrides.handles })?;
        let warnings = findings.as_slice().iter().map(ToString::to_string).collect();
        resolve::resolve(file, path, graph, warnings, overrides)
    }
}

fn read_text(path: &Path) -> Result<String, ScenarioError> {
    let read_error = |source| ScenarioError::Read { path: path.into(), source };
    // Limited while reading, because the size of a pipe or a device isn't known in advance.
    let file = std::fs::File::open(path).map_err(read_error)?;
    let mut text = String::new();
    file.take(MAX_FILE_BYTES + 1).read_to_string(&mut text).map_err(read_error)?;
    if text.len() as u64 > MAX_FILE_BYTES {
        return Err(ScenarioError::TooLarge { path: path.into() });
    }
    Ok(text)
}
