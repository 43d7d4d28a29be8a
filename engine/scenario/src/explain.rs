//! Errors of the YAML of a scenario, in words that name its entries instead of the program's types,
//! and suggestions for misspelt names.
//!
//! The code that serde derives finds the problem, and describes it for programmers. The provided
//! methods of the trait `serde::de::Error` fix these texts, so they can be parsed safely. Messages
//! from elsewhere, such as those about invalid YAML, stay as they are.

use std::fmt;

/// A problem of a scenario file: its place, the problem, and the remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct YamlProblem {
    /// The line, from 1, if it is known.
    line: Option<usize>,
    /// The entry, such as `robots, entry 2, count`; empty for the file as a whole.
    place: String,
    /// The problem and what to do about it.
    message: String,
}

impl fmt::Display for YamlProblem {
    /// Writes the part of a message after the name of the file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if !self.place.is_empty() {
            write!(f, ": {}", self.place)?;
        }
        write!(f, ": {}", self.message)
    }
}

/// Explains an error of the YAML reader.
pub(super) fn explain(error: &serde_yaml::Error) -> YamlProblem {
    let text = error.to_string();
    let location = error.location();
    let position =
        location.as_ref().map(|at| format!(" at line {} column {}", at.line(), at.column()));
    let text = position.as_ref().and_then(|position| text.strip_suffix(position)).unwrap_or(&text);
    let (path, message) =
        text.split_once(": ").filter(|(path, _)| is_path(path)).unwrap_or(("", text));
    YamlProblem {
        line: location.map(|at| at.line()),
        place: place(path),
        message: translate(path, message),
    }
}

/// Whether a text is a path of the YAML reader, such as `robots[0].count`.
fn is_path(text: &str) -> bool {
    text.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_.[]".contains(&byte))
}

/// Returns `robots, entry 1, count` for `robots[0].count`.
fn place(path: &str) -> String {
    let steps = path.split(['.', '[']).filter(|step| !step.is_empty());
    let steps = steps.map(|step| {
        match step.strip_suffix(']').and_then(|index| index.parse::<usize>().ok()) {
            Some(index) => format!("entry {}", index + 1),
            None => step.to_owned(),
        }
    });
    steps.collect::<Vec<_>>().join(", ")
}

/// The keys of a route graph. They show that the file isn't a scenario.
pub(super) const GRAPH_KEYS: [&str; 5] = ["Handles", "Edges", "Vertices", "Nodes", "AngleUnit"];

/// The keys of a scenario.
pub(super) const SCENARIO_KEYS: [&str; 17] = [
    "graph",
    "layout",
    "rate",
    "publish_rate",
    "seed",
    "warm_up",
    "nodes",
    "doors",
    "lifts",
    "robot_types",
    "robots",
    "disturbances",
    "load",
    "plugins",
    "viewer",
    "lights",
    "cameras",
];

fn translate(path: &str, message: &str) -> String {
    if let Some(rest) = message.strip_prefix("unknown field ") {
        let names = quoted(rest);
        let (key, keys) = names.split_first().unwrap_or((&"", &[]));
        if path.is_empty() && GRAPH_KEYS.iter().any(|name| name.eq_ignore_ascii_case(key)) {
            return format!(
                "this is a route graph, not a scenario ('{key}' is not a key of a scenario): \
                 `regatta graph check` checks it, and a scenario names it as `graph: FILE`"
            );
        }
        return format!(
            "unknown key '{key}'{}; possible keys: {}",
            did_you_mean(key, keys.to_vec()),
            keys.join(", ")
        );
    }
    if let Some(rest) = message.strip_prefix("unknown variant ") {
        let names = quoted(rest);
        let (value, values) = names.split_first().unwrap_or((&"", &[]));
        let suggestion = did_you_mean(value, values.to_vec());
        return format!(
            "unknown value '{value}'{suggestion}; possible values: {}",
            values.join(", ")
        );
    }
    if let Some(rest) = message.strip_prefix("missing field ") {
        return format!("{} is missing: add it", quoted(rest).join(", "));
    }
    if let Some(rest) = message.strip_prefix("duplicate field ") {
        return format!("{} is given twice: remove one", quoted(rest).join(", "));
    }
    let mismatch =
        message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid value: "));
    let mismatch = mismatch.and_then(|rest| rest.split_once(", expected "));
    if let Some((found, expected)) = mismatch {
        return format!(
            "{} is given, but this must be {}",
            found_value(found),
            expected_value(expected)
        );
    }
    if let Some((length, expected)) =
        message.strip_prefix("invalid length ").and_then(|rest| rest.split_once(", expected "))
    {
        return format!(
            "{length} entries are given, but this must be {}",
            expected_value(expected)
        );
    }
    message.to_owned()
}

/// Returns the texts in backticks.
fn quoted(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// Describes a value as serde's `Unexpected` does, in words of YAML.
fn found_value(found: &str) -> String {
    match found {
        "sequence" => "a list".to_owned(),
        "map" => "a map (key: value)".to_owned(),
        "unit value" | "Option value" => "nothing".to_owned(),
        _ => match (found.strip_prefix("string "), quoted(found).as_slice()) {
            (Some(text), _) => format!("the text {}", shortened(text)),
            (None, [number]) => (*number).to_owned(),
            (None, _) => found.to_owned(),
        },
    }
}

/// The most characters of a text in an error: a whole file may be one text in YAML.
const MOST_CHARACTERS: usize = 60;

/// Returns a text in quotation marks, without its end if it is long.
fn shortened(text: &str) -> String {
    match text.char_indices().nth(MOST_CHARACTERS) {
        Some((end, _)) => format!("{}…\"", &text[..end]),
        None => text.to_owned(),
    }
}

/// Describes an expected type in words of YAML.
fn expected_value(expected: &str) -> String {
    match expected {
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or more".to_owned(),
        "a nonzero u32" => "a whole number, 1 or more".to_owned(),
        "f32" | "f64" => "a number".to_owned(),
        "a string" | "path string" => "a text".to_owned(),
        "a sequence" => "a list".to_owned(),
        "struct ScenarioFile" => "a map with the keys graph and robots".to_owned(),
        _ if expected.starts_with("struct ") => "a map (key: value)".to_owned(),
        _ => match expected.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} numbers"),
            None => expected.to_owned(),
        },
    }
}

/// The least Jaro similarity of a suggestion, as in clap.
const LEAST_SIMILARITY: f64 = 0.7;

/// The least Jaro similarity of a name to one that it stands for without doubt.
const SURE_SIMILARITY: f64 = 0.85;

/// Whether a name is one of some candidates, but for a letter or two.
pub(super) fn is_misspelt(name: &str, candidates: &[&str]) -> bool {
    let name = name.to_lowercase();
    candidates.iter().any(|candidate| strsim::jaro(&name, candidate) > SURE_SIMILARITY)
}

/// Returns the candidate that a misspelt name most likely means, if any is similar to it.
pub fn closest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    let similar = candidates
        .into_iter()
        .map(|candidate| (strsim::jaro(&name, &candidate.to_lowercase()), candidate));
    let best = similar
        .filter(|(similarity, _)| *similarity > LEAST_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, candidate)| candidate)
}

/// Returns the end of a message about an unknown name: a question that names the closest candidate,
/// or nothing.
pub(super) fn did_you_mean<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> String {
    closest(name, candidates)
        .map(|candidate| format!("; did you mean '{candidate}'?"))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_places() {
        assert_eq!(place("robots[0].count"), "robots, entry 1, count");
        assert_eq!(place("lights[1].colour[2]"), "lights, entry 2, colour, entry 3");
        assert_eq!(place(""), "");
    }

    #[test]
    fn the_most_similar_name_is_suggested() {
        let plugins = ["collision", "hello", "metrics", "udp", "udp-source"];
        assert_eq!(closest("helo", plugins), Some("hello"));
        assert_eq!(closest("Colision", plugins), Some("collision"));
        assert_eq!(closest("udp-sauce", plugins), Some("udp-source"));
        assert_eq!(closest("xyz", plugins), None);
        assert_eq!(closest("", plugins), None);
    }

    #[test]
    fn other_words_are_no_misspelt_keys() {
        for name in ["grah", "robts", "Lights", "rates", "load"] {
            assert!(is_misspelt(name, &SCENARIO_KEYS), "{name}");
        }
        for name in ["colour", "name", "points", "version"] {
            assert!(!is_misspelt(name, &SCENARIO_KEYS), "{name}");
        }
    }
}
