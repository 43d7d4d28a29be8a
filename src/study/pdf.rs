//! The page of a study as PDF, printed by a browser of this machine.

use std::ffi::OsString;
use std::fs;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::failure::Failure;

/// Names a browser, in place of the first known one in the folders of programs.
const VARIABLE: &str = "REGATTA_BROWSER";
/// Browsers that print a page without a window, by the names of their programs.
const BROWSERS: [&str; 7] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "msedge",
];
/// The longest time that a browser may take for a page.
const LONGEST: Duration = Duration::from_mins(2);
/// The size of the largest PDF that is kept.
const MOST_BYTES: u64 = 256 << 20;
/// The time between two looks at a browser that prints.
const POLL: Duration = Duration::from_millis(20);
/// The most characters of a browser's messages in an error.
const MOST_TOLD: usize = 300;

/// A browser that can print pages.
#[derive(Debug)]
pub struct Browser {
    program: PathBuf,
}

impl Browser {
    /// Returns the browser that the variable `REGATTA_BROWSER` names, or else the first known one.
    ///
    /// # Errors
    /// If there is none.
    pub fn find() -> Result<Self, Failure> {
        let named = std::env::var_os(VARIABLE).filter(|name| !name.is_empty());
        if let Some(name) = named {
            let program = in_folders(Path::new(&name)).ok_or_else(|| {
                format!("{VARIABLE}: there is no program {}", Path::new(&name).display())
            })?;
            return Ok(Self { program });
        }
        match BROWSERS.iter().find_map(|name| in_folders(Path::new(name))) {
            Some(program) => Ok(Self { program }),
            None => Err(format!(
                "--pdf: no Chromium, Chrome or Edge was found; install one, or name its program \
                 in the variable {VARIABLE}"
            )
            .into()),
        }
    }

    /// Prints the page of a study, and returns the path of the PDF.
    ///
    /// # Errors
    /// If the browser fails, or takes two minutes.
    pub fn print(&self, folder: &Path) -> Result<PathBuf, Failure> {
        let page = std::path::absolute(folder.join("index.html"))?;
        // A browser in a sandbox of its own may see other temporary folders than this program.
        let profile = tempfile::Builder::new().prefix("pdf-").tempdir_in(folder)?;
        let printed = profile.path().join("study.pdf");
        let mut messages = tempfile::tempfile()?;
        let mut command = Command::new(&self.program);
        command.args(["--headless", "--disable-gpu", "--no-pdf-header-footer"]);
        command.arg(option("--user-data-dir", profile.path())?);
        command.arg(option("--print-to-pdf", &printed)?);
        if is_of_root(&profile) {
            // Chromium's sandbox refuses root. The page is our own, and loads nothing else.
            command.arg("--no-sandbox");
        }
        command.arg(&page);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(messages.try_clone()?);
        let is_done = wait_for(&mut command)?;
        if !is_done || !printed.is_file() {
            let text = told(&mut messages)?;
            let program = self.program.display();
            return Err(format!("{program} has not printed {}: {text}", page.display()).into());
        }
        let file = folder.join("study.pdf");
        crate::output::write_inside(&file, &regatta_base::file::read(&printed, MOST_BYTES)?)?;
        Ok(file)
    }
}

/// Returns an option of a browser whose value is a path.
fn option(name: &str, value: &Path) -> Result<OsString, Failure> {
    let mut option = OsString::from(format!("{name}="));
    option.push(std::path::absolute(value)?);
    Ok(option)
}

/// Returns the path of a program: itself if it has a folder in it, or else in the folders of
/// programs.
fn in_folders(program: &Path) -> Option<PathBuf> {
    if program.components().count() > 1 {
        return program.is_file().then(|| program.to_owned());
    }
    let folders = std::env::var_os("PATH")?;
    let name = format!("{}{}", program.display(), std::env::consts::EXE_SUFFIX);
    std::env::split_paths(&folders).map(|folder| folder.join(&name)).find(|path| path.is_file())
}

/// Whether a new folder belongs to the user root.
#[cfg(unix)]
fn is_of_root(folder: &TempDir) -> bool {
    use std::os::unix::fs::MetadataExt;
    folder.path().metadata().is_ok_and(|metadata| metadata.uid() == 0)
}

#[cfg(not(unix))]
fn is_of_root(_: &TempDir) -> bool {
    false
}

/// Runs a command; returns whether it has succeeded within the longest time.
fn wait_for(command: &mut Command) -> Result<bool, Failure> {
    let mut child = command.spawn()?;
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status.success());
        }
        if started.elapsed() >= LONGEST {
            child.kill()?;
            child.wait()?;
            return Ok(false);
        }
        std::thread::sleep(POLL);
    }
}

/// Returns the end of a program's messages as one line.
fn told(messages: &mut fs::File) -> Result<String, Failure> {
    messages.rewind()?;
    let mut bytes = Vec::new();
    messages.read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let skipped = line.chars().count().saturating_sub(MOST_TOLD);
    Ok(line.chars().skip(skipped).collect())
}
