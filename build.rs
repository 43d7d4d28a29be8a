//! Passes on what `regatta --version` prints besides the version: the commit, and the version of
//! iceoryx2.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    // The commit is looked up again when the program has to be compiled anyway, so that a commit
    // alone compiles nothing.
    let mut sources = ["Cargo.toml", "Cargo.lock", "build.rs", "src"].map(PathBuf::from).to_vec();
    for folder in ["engine", "plugins", "study", "viewer"] {
        add_sources(Path::new(folder), &mut sources);
    }
    for path in sources.iter().filter(|path| path.exists()) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    println!("cargo::rustc-env=REGATTA_COMMIT={}", commit().unwrap_or_default());
    println!(
        "cargo::rustc-env=REGATTA_ICEORYX2={}",
        locked_version("iceoryx2").unwrap_or_default()
    );
}

/// Adds the folders `src` of the crates in a folder.
fn add_sources(folder: &Path, sources: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.ends_with("src") {
            sources.push(path);
        } else if path.join("Cargo.toml").exists() {
            add_sources(&path, sources);
        }
    }
}

/// Returns the commit, with `-modified` if sources differ from it; `None` for sources that aren't
/// from git.
fn commit() -> Option<String> {
    // A folder in somebody else's repository, such as an unpacked archive, has no commit of its
    // own.
    if !Path::new(".git").exists() {
        return None;
    }
    let commit = git(&["rev-parse", "--short=10", "HEAD"])?;
    let changes = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(if changes.is_empty() { commit } else { format!("{commit}-modified") })
}

fn git(args: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(args).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}

/// Returns the version of a crate in `Cargo.lock`.
fn locked_version(name: &str) -> Option<String> {
    let lock = fs::read_to_string("Cargo.lock").ok()?;
    let (_, package) = lock.split_once(&format!("name = \"{name}\"\nversion = \""))?;
    package.split('"').next().map(str::to_owned)
}
