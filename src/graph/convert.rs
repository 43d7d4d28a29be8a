//! `regatta graph convert`: writes a layout in another format.

use std::path::Path;

use regatta_layout::{Format, parse_fixed, write};

use super::FileArgs;
use crate::failure::Failure;
use crate::output::{Destination, Force};
use crate::progress::Progress;

/// Reads a layout and writes it in the format `to`, or in that of the output's ending. What the
/// format can't say goes to standard error.
pub fn run(
    file: &FileArgs,
    output: &Destination,
    to: Option<Format>,
    force: Force,
) -> Result<(), Failure> {
    let format = to.map_or_else(|| format_of(output), Ok)?;
    output.check(force)?;
    let progress = Progress::start(format!("reading {}", file.name()), 0);
    let graph = file.read()?;
    progress.set_current("writing");
    let written = write(&graph, format).ok_or_else(|| {
        format!("graphs can't be written as {format}: use regatta, lif, nav2 or opentcs")
    })?;
    drop(progress);
    for loss in &written.losses {
        eprintln!("regatta: {format} can't say everything: {loss}");
    }
    output.write(&written.text, force)
}

/// Writes a copy of a layout in which what has one obvious answer is mended, and says what that
/// was, and what the copy hasn't.
pub fn fix(file: &FileArgs, output: &Destination, force: Force) -> Result<(), Failure> {
    let format = format_of(output)
        .map_err(|_| "the ending of the copy tells its format: give one that ends in .yaml, .json, .geojson or .xml")?;
    output.check(force)?;
    let (graph, findings, fixes) = parse_fixed(&file.text()?, &file.name(), &file.options())?;
    let written =
        write(&graph, format).ok_or_else(|| format!("graphs can't be written as {format}"))?;
    fixes.iter().for_each(|fix| eprintln!("regatta: {fix}"));
    if fixes.is_empty() {
        eprintln!("regatta: {}: nothing to mend", file.name());
    }
    // What the reader didn't understand isn't in the copy.
    findings.as_slice().iter().for_each(|finding| eprintln!("{finding}"));
    for loss in &written.losses {
        eprintln!("regatta: {format} can't say everything: {loss}");
    }
    output.write(&written.text, force)
}

fn format_of(output: &Destination) -> Result<Format, Failure> {
    let Destination::File(path) = output else {
        return Err("give the format of standard output: --to regatta, lif, nav2 or opentcs".into());
    };
    let ending =
        |path: &Path| path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    match ending(path).as_deref() {
        Some("yaml" | "yml") => Ok(Format::Regatta),
        Some("json") => Ok(Format::Lif),
        Some("geojson") => Ok(Format::Nav2),
        Some("xml") => Ok(Format::OpenTcs),
        _ => {
            let name = path.display();
            Err(format!(
                "{name}: the ending tells no format; give --to regatta, lif, nav2 or opentcs"
            )
            .into())
        }
    }
}
