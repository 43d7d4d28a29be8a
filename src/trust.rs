//! Trust in a folder. A file that comes from somebody else is read, refused or shown, but it starts
//! no program, writes no file and uses no network, unless the user trusts its folder. The user is
//! asked once, on a terminal, as editors do; the answer is kept in a list of folders.

use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use regatta_base::file;
use regatta_plugin::visible;

use crate::failure::Failure;
use crate::user_files;

/// The user's file with the trusted folders, one path a line.
const LIST: &str = "trusted";
/// The size of the largest list.
const MAX_LIST_BYTES: u64 = 4 << 20;
/// The largest number of wishes that are named.
const MOST_NAMED: usize = 3;

/// Whether a file is trusted.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct TrustArgs {
    /// Start the programs that the file names, and let plugins use its files and addresses, without
    /// asking
    #[arg(long, help_heading = "Processes")]
    pub trust: bool,
}

/// Checks that the user trusts a file with what it wants: descriptions of programs and of plugins
/// with their arguments. Without a wish, nothing is asked. A text from standard input has no
/// `folder`.
///
/// # Errors
/// If the user doesn't trust it, or can't be asked.
pub fn require(
    name: &str,
    folder: Option<&Path>,
    wishes: &[String],
    args: TrustArgs,
) -> Result<(), Failure> {
    if wishes.is_empty() || args.trust {
        return Ok(());
    }
    let folder = folder.map(real_path).transpose()?;
    if let Some(folder) = &folder {
        if is_trusted(folder) {
            return Ok(());
        }
        if io::stdin().is_terminal() && io::stderr().is_terminal() {
            return ask(name, folder, wishes);
        }
    }
    Err(format!(
        "{name}: it wants to start {}, and its folder is not trusted yet: read the file, then \
         start it with --trust, or confirm it in a terminal",
        in_words(wishes)
    )
    .into())
}

/// Adds a folder to those that the user trusts.
///
/// # Errors
/// If the list can't be written.
pub fn remember(folder: &Path) -> io::Result<()> {
    let (folder, path) = (real_path(folder)?, list_path()?);
    if is_trusted(&folder) {
        return Ok(());
    }
    // Other paths couldn't be told from several lines.
    let line = folder.to_str().filter(|line| !line.contains(['\n', '\r']));
    let line = line.ok_or(io::ErrorKind::InvalidFilename)?;
    let mut list = read_list();
    list.push_str(line);
    list.push('\n');
    fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
    regatta_kit::whole_file::write(&path, list.as_bytes())
}

/// Whether the user trusts a folder, or one that it is in.
fn is_trusted(folder: &Path) -> bool {
    let list = read_list();
    list.lines().any(|line| Path::new(line).is_absolute() && folder.starts_with(line))
}

fn list_path() -> io::Result<PathBuf> {
    user_files::path(LIST).ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "no home folder"))
}

fn read_list() -> String {
    // Without a list, nothing is trusted.
    let text = list_path().and_then(|path| file::read_text(&path, MAX_LIST_BYTES));
    text.unwrap_or_default()
}

fn real_path(folder: &Path) -> io::Result<PathBuf> {
    let is_here = folder.as_os_str().is_empty();
    fs::canonicalize(if is_here { Path::new(".") } else { folder })
}

fn ask(name: &str, folder: &Path, wishes: &[String]) -> Result<(), Failure> {
    regatta_plugin::tell!("{name} wants to start {}.", in_words(wishes));
    let question = format!("Do you trust the files in {}? [y/N] ", folder.display());
    io::stderr().write_all(visible(&question).as_bytes())?;
    let mut answer = String::new();
    io::stdin().read_line(&mut answer)?;
    if !["y", "yes"].contains(&answer.trim().to_ascii_lowercase().as_str()) {
        return Err(format!("{name}: not trusted, so nothing was started").into());
    }
    if let Err(error) = remember(folder) {
        regatta_plugin::tell!("regatta: can't remember that: {error}");
    }
    Ok(())
}

/// Names some wishes, without the control characters of a stranger.
fn in_words(wishes: &[String]) -> String {
    let named = wishes.iter().take(MOST_NAMED);
    let named: Vec<String> = named.map(|wish| format!("'{}'", wish.escape_debug())).collect();
    match wishes.len().saturating_sub(MOST_NAMED) {
        0 => named.join(", "),
        more => format!("{} and {more} more", named.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wish_is_shown_as_it_is_and_without_control_characters() {
        let wishes = ["rm -rf x", "a\u{1b}[2Jb", "c", "d", "e"].map(str::to_owned);
        assert_eq!(in_words(&wishes[..1]), "'rm -rf x'");
        assert_eq!(in_words(&wishes), "'rm -rf x', 'a\\u{1b}[2Jb', 'c' and 2 more");
    }

    #[test]
    fn nothing_is_asked_for_a_file_without_wishes_or_with_trust() {
        let untrusted = TrustArgs::default();
        assert!(require("a.yaml", None, &[], untrusted).is_ok());
        let wishes = ["false".to_owned()];
        assert!(require("a.yaml", None, &wishes, TrustArgs { trust: true }).is_ok());
        let error = require("a.yaml", None, &wishes, untrusted).expect_err("untrusted");
        assert!(error.to_string().starts_with("a.yaml: it wants to start 'false', and its"));
    }
}
