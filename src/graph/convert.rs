//! `regatta graph convert`: writes a layout in another format.

use std::fmt::Display;

use regatta_layout::{FindingKind, Format, Subject, parse_fixed, write};

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
    let (graph, findings, fixes) = parse_fixed(&file.text()?, &file.name(), &file.options())?;
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
