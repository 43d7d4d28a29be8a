//! The executable `regatta` that child processes run.

use std::env::consts::EXE_SUFFIX;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::failure::Failure;
use crate::version;

/// An executable of `regatta`, and its version.
#[derive(Clone, Debug)]
pub struct Program {
    path: PathBuf,
    version: String,
}

impl Program {
    /// Returns this executable, which must be `regatta`.
    ///
    /// # Errors
    /// If the system doesn't tell its path.
    pub fn this() -> io::Result<Self> {
        Ok(Self { path: std::env::current_exe()?, version: version::short() })
    }

    /// Returns the executable `regatta` beside this one.
    ///
    /// # Errors
    /// If there is none, or if it can't share a fleet with this program.
    pub fn beside_this() -> Result<Self, Failure> {
        let path = std::env::current_exe()?.with_file_name(format!("regatta{EXE_SUFFIX}"));
        Self::at(&path)
    }

    /// Returns the executable at a path.
    ///
    /// # Errors
    /// If it doesn't run, or if its contract or its iceoryx2 has another version than those of this
    /// program: they couldn't share a fleet.
    pub fn at(path: &Path) -> Result<Self, Failure> {
        let name = path.display();
        let output = Command::new(path).arg("--version").stdin(Stdio::null()).output();
        let output = output.map_err(|error| {
            format!(
                "can't run {name}: {error}; build it with `cargo build --release`, or give \
                 another with --regatta"
            )
        })?;
        let text = String::from_utf8_lossy(&output.stdout);
        let Some((version, interfaces)) =
            text.trim_end().strip_prefix("regatta ").and_then(|text| text.split_once('\n'))
        else {
            return Err(format!("{name} is not the program `regatta`").into());
        };
        if interfaces != version::interfaces() {
            let [theirs, ours] =
                [interfaces, &version::interfaces()].map(|text| text.replace('\n', ", "));
            return Err(format!(
                "{name} has {theirs}, and this program {ours}: build both from the same sources"
            )
            .into());
        }
        Ok(Self { path: path.to_owned(), version: version.to_owned() })
    }

    /// Returns a command that runs the executable.
    pub fn command(&self) -> Command {
        Command::new(&self.path)
    }

    /// Returns its version, with the commit if there is one.
    pub fn version(&self) -> &str {
        &self.version
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_program_is_refused_with_the_command_that_builds_it() {
        let error = Program::at(Path::new("/no/regatta")).expect_err("it is missing").to_string();
        assert!(error.starts_with("can't run /no/regatta: "), "{error}");
        assert!(error.contains("`cargo build --release`"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn another_program_is_refused() {
        let error = Program::at(Path::new("/bin/true")).expect_err("another program").to_string();
        assert_eq!(error, "/bin/true is not the program `regatta`");
    }
}
