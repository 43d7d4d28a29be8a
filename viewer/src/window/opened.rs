//! Recordings, layouts and scenarios that are dropped on the window or chosen in the file dialog:
//! each opens in a window of its own.

use std::ffi::OsString;
use std::io::Read;
use std::path::Path;

use regatta_base::file;

use super::child::ChildProcess;

/// The endings of layouts of all formats and of scenarios.
pub const PLANTS: [&str; 11] =
    ["yaml", "yml", "json", "geojson", "xml", "dxf", "csv", "map", "scen", "lif", "opentcs"];
/// The ending of recordings.
pub const RECORDING: &str = "mcap";

/// The bytes of a file that tell what it is.
const BEGINNING: u64 = 4096;

/// The programs that show opened files.
#[derive(Debug, Default)]
pub struct OpenedFiles {
    opened: Vec<(String, ChildProcess)>,
    /// The number of fleets so far, for their names.
    fleets: u32,
}

/// The content of a file, as far as the window knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Content {
    Recording,
    /// A layout, or a scenario.
    Plant,
    /// A mesh, an image or a map for the floor.
    Look,
}

impl OpenedFiles {
    /// Opens a file. Returns a message for the user; `None` for a file that only changes the look
    /// of this window.
    pub fn open(&mut self, path: &Path) -> Option<String> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let args = self.command_line(path)?;
        Some(match ChildProcess::start("opened file", args) {
            Ok(process) => {
                self.opened.push((name.clone(), process));
                format!("{name} opens in a window of its own; this fleet goes on")
            }
            Err(error) => format!("can't open {name}: {error}"),
        })
    }

    /// Returns the arguments of this program that show a file; `None` for a file that only changes
    /// the look of this window.
    fn command_line(&mut self, path: &Path) -> Option<Vec<OsString>> {
        let file = path.as_os_str().to_owned();
        match content(path) {
            Content::Look => None,
            Content::Recording => Some(vec!["viewer".into(), file]),
            Content::Plant => {
                self.fleets += 1;
                let fleet = format!("opened-{}-{}", std::process::id(), self.fleets);
                Some(vec!["run".into(), file, "--fleet".into(), fleet.into()])
            }
        }
    }

    /// Removes the programs that have ended, and returns the messages of those that have failed.
    pub fn remove_ended(&mut self) -> Vec<String> {
        let mut messages = Vec::new();
        self.opened.retain_mut(|(name, process)| {
            let Some(outcome) = process.outcome() else { return true };
            messages.extend(outcome.map(|message| format!("{name}: {message}")));
            false
        });
        messages
    }
}

/// Returns the content of a file, by its ending and, for YAML, its beginning.
fn content(path: &Path) -> Content {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some(RECORDING) => Content::Recording,
        // A map of the ROS map server is for the floor.
        Some("yaml" | "yml") if beginning(path).contains("resolution:") => Content::Look,
        Some(ending) if PLANTS.contains(&ending) => Content::Plant,
        _ => Content::Look,
    }
}

/// The beginning of a file; nothing if it can't be read.
fn beginning(path: &Path) -> String {
    let mut bytes = Vec::new();
    if let Ok(file) = file::open(path, u64::MAX) {
        // An error leaves what was read before.
        let _ = file.take(BEGINNING).read_to_end(&mut bytes);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_apart_by_ending_and_beginning() {
        for (name, expected) in [
            ("run.mcap", Content::Recording),
            ("plant.lif.json", Content::Plant),
            ("no-such-file.YAML", Content::Plant),
            ("nav2.geojson", Content::Plant),
            ("nodes.csv", Content::Plant),
            ("maze.map", Content::Plant),
            ("tug.stl", Content::Look),
            ("floor.png", Content::Look),
        ] {
            assert_eq!(content(Path::new(name)), expected, "{name}");
        }
        let map = std::env::temp_dir().join(format!("regatta-map-{}.yaml", std::process::id()));
        std::fs::write(&map, "image: map.pgm\nresolution: 0.05").expect("written");
        assert_eq!(content(&map), Content::Look, "a map of the ROS map server");
        std::fs::write(&map, "graph: plant.yaml").expect("written");
        assert_eq!(content(&map), Content::Plant);
        std::fs::remove_file(&map).expect("removed");
    }

    #[test]
    fn each_dropped_file_is_shown_by_a_program_of_its_own() {
        let mut opened = OpenedFiles::default();
        let of_recording = opened.command_line(Path::new("a b/run.mcap"));
        assert_eq!(of_recording, Some(vec!["viewer".into(), "a b/run.mcap".into()]));
        let fleets = ["plant.json", "plant.json"].map(|plant| {
            let args = opened.command_line(Path::new(plant)).expect("it is shown");
            assert_eq!(args[..3], ["run", plant, "--fleet"].map(OsString::from));
            args[3].clone()
        });
        assert_ne!(fleets[0], fleets[1], "each has a fleet of its own");
        assert_eq!(opened.command_line(Path::new("floor.png")), None);
    }
}
