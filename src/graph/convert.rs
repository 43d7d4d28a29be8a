//! `regatta graph convert`: writes a layout in another format.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::Path;

use regatta_layout::{FindingKind, Format, GraphError, Subject, parse_fixed, write};
use regatta_scenario::{document, is_scenario};
use serde_json::Value;

use super::FileArgs;
use crate::failure::Failure;
use crate::output::{Destination, Force};
use crate::progress::Progress;

/// Reads a layout and writes it in the format `to`, or in that of the output's ending. Lists the
/// losses on standard error: those of reading, and those of writing.
pub fn run(
    file: &FileArgs,
    output: &Destination,
    to: Option<Format>,
    force: Force,
) -> Result<(), Failure> {
    let format = to.map_or_else(|| format_of(output), Ok)?;
    output.check(force)?;
    let progress = Progress::start(format!("reading {}", file.name()), 0);
    let (graph, findings) = file.read_with_findings()?;
    progress.set_current("writing");
    let written = write(&graph, format).ok_or_else(|| {
        format!("graphs can't be written as {format}: use regatta, lif, nav2 or opentcs")
    })?;
    drop(progress);
    // The output lacks what the reader left out.
    for finding in findings.as_slice().iter().filter(|finding| finding.subject == Subject::File) {
        if finding.kind != FindingKind::TurnsAtNodes {
            regatta_plugin::tell!("{finding}");
        }
    }
    print_losses(format, &written.losses);
    output.write(&written.text, force)
}

fn print_losses(format: Format, losses: &[impl Display]) {
    for loss in losses {
        regatta_plugin::tell!("regatta: {format} can't express everything: {loss}");
    }
}

/// Writes a copy of a layout that corrects all problems with one obvious correction. Lists the
/// corrections and the losses on standard error.
pub fn fix(file: &FileArgs, output: &Destination, force: Force) -> Result<(), Failure> {
    let format = format_of(output).map_err(|_| {
        "the ending of the copy tells its format: give one that ends in .yaml, .json, .geojson \
                      or .xml"
    })?;
    output.check(force)?;
    let text = file.text()?;
    let fixed = parse_fixed(&text, &file.name(), &file.options());
    let (graph, findings, fixes) = fixed.map_err(|error| not_fixed(file, &text, error))?;
    let written =
        write(&graph, format).ok_or_else(|| format!("graphs can't be written as {format}"))?;
    for fix in &fixes {
        regatta_plugin::tell!("regatta: {fix}");
    }
    if fixes.is_empty() {
        regatta_plugin::tell!("regatta: {}: nothing to fix", file.name());
    }
    // The copy lacks everything that the reader didn't understand.
    for finding in findings.as_slice() {
        regatta_plugin::tell!("{finding}");
    }
    print_losses(format, &written.losses);
    output.write(&written.text, force)
}

/// Returns the error of a file that isn't corrected: that of a scenario names its layout.
fn not_fixed(file: &FileArgs, text: &str, error: GraphError) -> Failure {
    if !is_scenario(text) {
        return error.into();
    }
    let name = file.name();
    let keys: BTreeMap<String, Value> = document(text, Path::new(&name)).unwrap_or_default();
    let advice = match keys.get("graph").and_then(Value::as_str) {
        Some(graph) => {
            let layout = file.folder().unwrap_or(Path::new("")).join(graph);
            format!("give {}", layout.display())
        }
        None => "give the one that it names".to_owned(),
    };
    format!("{name}: this is a scenario, and --fix corrects a layout's file: {advice}").into()
}

fn format_of(output: &Destination) -> Result<Format, Failure> {
    let Destination::File(path) = output else {
        return Err("give the format of standard output: --to regatta, lif, nav2 or opentcs".into());
    };
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match &*ending {
        "yaml" | "yml" => Ok(Format::Regatta),
        "json" => Ok(Format::Lif),
        "geojson" => Ok(Format::Nav2),
        "xml" => Ok(Format::OpenTcs),
        _ => {
            let advice = "the ending tells no format; give --to regatta, lif, nav2 or opentcs";
            Err(format!("{}: {advice}", path.display()).into())
        }
    }
}
