//! Reads the YAML of a route graph file, in both spellings of the format. Only the structure is
//! checked here; `validate` checks the numbers.

mod reader;
mod sections;

use std::collections::BTreeMap;

use rayon::prelude::*;

use self::reader::Reader;
pub(crate) use self::sections::Part;
use crate::model::finding::Report;
use crate::model::raw::RawGraph;
use crate::model::value::shorten;
use crate::read::file::SyntaxError;

/// Files of at least this size in bytes are read part by part if possible.
const LARGE: usize = 1 << 20;

/// The largest number of different unknown keys that are reported.
const MAX_UNKNOWN_KEYS: usize = 100;

/// Reads a YAML text, or its parts.
///
/// # Errors
/// If the text isn't YAML, or isn't one map. Errors inside the map are reported to `report`
/// instead.
pub(crate) fn read<'text>(
    text: &'text str,
    parts: Option<Vec<Part<'text>>>,
    report: &mut Report<'text>,
) -> Result<RawGraph, SyntaxError> {
    let mut content = match parts {
        None => Content::read(report, Part::whole(text))?,
        Some(parts) => {
            let parts: Vec<_> =
                parts.into_par_iter().map(|part| Content::read(report, part)).collect();
            let mut content = Content::new(report);
            for part in parts {
                content.append(part?);
            }
            content
        }
    };
    content.report_unknown_keys();
    report.append(content.report);
    Ok(content.graph)
}

/// Returns the parts of a large text; `None` if it has to be read as a whole. In parts, a text of
/// any length takes little more memory than the graph itself.
pub(crate) fn parts_of_large(text: &str) -> Option<Vec<Part<'_>>> {
    (text.len() >= LARGE).then(|| sections::parts(text)).flatten()
}

/// The content of a text, or of a part of it.
struct Content<'text> {
    graph: RawGraph,
    unknown: BTreeMap<(Scope, String), UnknownKey>,
    report: Report<'text>,
}

struct UnknownKey {
    at: u32,
    count: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Scope {
    File,
    Node,
    Edge,
    Station,
    Zone,
    Door,
    Lift,
    Background,
}

impl<'text> Content<'text> {
    /// Makes empty content. `report` is the report about the file.
    fn new(report: &Report<'text>) -> Self {
        Self { graph: RawGraph::default(), unknown: BTreeMap::new(), report: report.empty() }
    }

    /// Reads a part of a file's text.
    fn read(report: &Report<'text>, part: Part<'text>) -> Result<Self, SyntaxError> {
        Reader::new(Self::new(report)).read(part)
    }

    /// Adds the content of a later part. Each key of the root map is in one of them.
    fn append(&mut self, mut later: Self) {
        self.graph.nodes.append(&mut later.graph.nodes);
        self.graph.edges.append(&mut later.graph.edges);
        self.graph.stations.append(&mut later.graph.stations);
        self.graph.zones.append(&mut later.graph.zones);
        self.graph.doors.append(&mut later.graph.doors);
        self.graph.lifts.append(&mut later.graph.lifts);
        self.graph.background.append(&mut later.graph.background);
        self.graph.handles = self.graph.handles.or(later.graph.handles);
        self.graph.degrees |= later.graph.degrees;
        self.graph.is_angle_unit_known |= later.graph.is_angle_unit_known;
        for ((scope, key), UnknownKey { at, count }) in later.unknown {
            self.count_unknown_key(scope, &key, at, count);
        }
        self.report.append(later.report);
    }

    fn count_unknown_key(&mut self, scope: Scope, key: &str, at: u32, count: usize) {
        let key = (scope, shorten(key));
        if let Some(unknown) = self.unknown.get_mut(&key) {
            unknown.count += count;
        } else if self.unknown.len() < MAX_UNKNOWN_KEYS {
            self.unknown.insert(key, UnknownKey { at, count });
        }
    }

    fn report_unknown_keys(&mut self) {
        for ((scope, key), UnknownKey { at, count }) in std::mem::take(&mut self.unknown) {
            let owner = match scope {
                Scope::File => "the file",
                Scope::Node => "a node",
                Scope::Edge => "an edge",
                Scope::Station => "a station",
                Scope::Zone => "a zone",
                Scope::Door => "a door",
                Scope::Lift => "a lift",
                Scope::Background => "a line of the background",
            };
            let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
            // `1,5` in braces is the value 1 and the key 5.
            let remedy = if key.bytes().all(|byte| byte.is_ascii_digit()) {
                "write fractions with a point, such as 1.5"
            } else {
                "correct it if it is misspelt"
            };
            let message = format!("`{key}` is not a key of {owner}: ignored{times}; {remedy}");
            self.report.file_warning(at, message);
        }
    }
}
