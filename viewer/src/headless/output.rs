//! Checks of the files that are to be written, before anything is drawn.

use std::path::Path;

use regatta_plugin::{Error, Result};

use crate::options::Options;

/// Returns an error if pictures would replace others without `--force`, or have an unknown format.
pub fn check(options: &Options) -> Result {
    check_format(options)?;
    let outputs = [&options.screenshot, &options.record, &options.film, &options.svg];
    let output = outputs.into_iter().find_map(Option::as_deref);
    match output.filter(|path| !options.force && is_taken(path)) {
        Some(path) => {
            Err(Error::new(format!("{}: this exists; --force replaces it", path.display())))
        }
        None => Ok(()),
    }
}

/// Returns an error if a path ends like a file of a format that isn't written.
fn check_format(options: &Options) -> Result {
    if let Some(path) = options.svg.as_deref().filter(|path| ending(path).as_deref() != Some("svg"))
    {
        return unknown(path, "give a name that ends in .svg");
    }
    match (&options.screenshot, options.record.as_ref().or(options.film.as_ref())) {
        (Some(path), _) if ending(path).as_deref() != Some("png") => {
            unknown(path, "give a name that ends in .png")
        }
        (_, Some(path)) if !path.is_dir() && ending(path).is_some_and(|ending| ending != "mp4") => {
            unknown(path, "give a name that ends in .mp4, or a folder for PNG files")
        }
        _ => Ok(()),
    }
}

fn ending(path: &Path) -> Option<String> {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase())
}

fn unknown(path: &Path, formats: &str) -> Result {
    Err(Error::new(format!(
        "{}: pictures are not written in this format: {formats}",
        path.display()
    )))
}

/// Whether there is a file, or a folder with something in it.
fn is_taken(path: &Path) -> bool {
    path.read_dir().map_or_else(|_| path.is_file(), |mut entries| entries.next().is_some())
}
