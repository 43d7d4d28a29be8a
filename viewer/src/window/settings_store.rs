//! The settings of a window and their file, which is written some time after a change.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use etcetera::BaseStrategy;
use regatta_interface::settings::{RobotMesh, Settings};
use regatta_scene::palette::Theme;

use crate::options::{LookOptions, Options};

/// The time from the last change of the settings until they are written.
const SAVE_DELAY: Duration = Duration::from_secs(2);

/// The error of reading or writing the settings file.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The file is not valid.
    #[error("invalid settings file {} ({reason}); the default settings are used", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// The error of the parser.
        reason: String,
    },
    /// The file can't be read or written.
    #[error("can't read or write the settings file {}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        reason: String,
    },
}

/// The settings that a window started with, and those that were written last.
#[derive(Debug)]
pub struct SettingsStore {
    /// The settings in the file.
    stored: Settings,
    /// The stored settings overridden by the options of the command line.
    initial: Settings,
    saved: Settings,
    changed_at: Option<Instant>,
}

impl SettingsStore {
    /// Reads the settings file, and applies the options of the command line. If the file can't be
    /// read, the default settings are used, and the error is returned too.
    pub fn load(options: &Options) -> (Self, Option<SettingsError>) {
        let loaded = file_path().as_deref().map_or(Ok(Settings::default()), load);
        let (stored, error) = match loaded {
            Ok(stored) => (stored, None),
            Err(error) => (Settings::default(), Some(error)),
        };
        let mut initial = overridden(stored.clone(), &options.look);
        if let Some(size) = options.size {
            initial.window = size.as_vec2();
        }
        (Self { stored, saved: initial.clone(), initial, changed_at: None }, error)
    }

    /// Returns the settings to start with.
    pub fn initial(&self) -> &Settings {
        &self.initial
    }

    /// Forgets a file that could not be loaded, so that no later start tries again. Where an option
    /// of the command line has named it, the stored settings keep the file that they have.
    pub fn forget(&mut self, file: &str) {
        for settings in [&mut self.initial, &mut self.stored] {
            settings.mesh.take_if(|mesh| mesh.file == file);
            if settings.floor_image == file {
                settings.floor_image.clear();
            }
        }
    }

    /// Writes changed settings once they have stayed the same for [`SAVE_DELAY`].
    ///
    /// # Errors
    /// If the file can't be written.
    pub fn save_later(&mut self, settings: &Settings, now: Instant) -> Result<(), SettingsError> {
        if *settings == self.saved {
            self.changed_at = None;
        } else if now.saturating_duration_since(*self.changed_at.get_or_insert(now)) > SAVE_DELAY {
            return self.save(settings);
        }
        Ok(())
    }

    /// Writes changed settings.
    ///
    /// # Errors
    /// If the file can't be written.
    pub fn save(&mut self, settings: &Settings) -> Result<(), SettingsError> {
        if *settings == self.saved {
            return Ok(());
        }
        self.saved = settings.clone();
        self.changed_at = None;
        let to_store = settings.to_store(&self.initial, &self.stored);
        file_path().map_or(Ok(()), |path| save(&to_store, &path))
    }
}

/// Returns the path of the settings file in the user's configuration folder; `None` for a user
/// without a home folder.
fn file_path() -> Option<PathBuf> {
    Some(etcetera::choose_base_strategy().ok()?.config_dir().join("regatta").join("viewer.json"))
}

/// The size of the largest settings file that is read.
const MAX_BYTES: u64 = 16 << 20;

/// Reads the settings file. Returns the default settings if it doesn't exist.
///
/// # Errors
/// If the file can't be read or is not valid.
fn load(path: &Path) -> Result<Settings, SettingsError> {
    let text = match regatta_base::file::read_text(path, MAX_BYTES) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Ok(Settings::default());
        }
        Err(error) => {
            return Err(SettingsError::File { path: path.into(), reason: error.to_string() });
        }
    };
    let settings = serde_json::from_str::<Settings>(&text);
    settings
        .map(Settings::sanitized)
        .map_err(|error| SettingsError::Broken { path: path.into(), reason: error.to_string() })
}

/// Writes the settings file atomically.
///
/// # Errors
/// [`SettingsError::File`] if the file can't be written.
fn save(settings: &Settings, path: &Path) -> Result<(), SettingsError> {
    let failed = |error: std::io::Error| SettingsError::File {
        path: path.into(),
        reason: error.to_string(),
    };
    let text = serde_json::to_string_pretty(settings).map_err(|error| failed(error.into()))?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    regatta_kit::whole_file::write(path, (text + "\n").as_bytes()).map_err(failed)
}

/// Returns the settings overridden by the options of the command line.
fn overridden(mut settings: Settings, look: &LookOptions) -> Settings {
    if let Some(theme) = look.theme {
        settings.light = theme == Theme::Light;
    }
    if let Some(colour) = &look.colour {
        settings.colour = colour.to_string();
    }
    if let Some(offset) = look.offset {
        settings.offset = offset;
    }
    if let Some(size) = look.floor {
        settings.floor = Some(size.abs());
    }
    if let Some(points) = look.trails {
        settings.trails = points;
    }
    settings.trails_of_selected |= look.trails_of_selected;
    if let Some(path) = &look.floor_image {
        settings.floor_image = path.display().to_string();
    }
    settings.floor_at = look.floor_at.or(settings.floor_at);
    if let Some(model) = look.mesh.iter().rfind(|model| model.robot_type.is_none()) {
        settings.mesh = Some(RobotMesh::new(model.path.display().to_string(), model.placement));
    }
    if !look.light.is_empty() {
        settings.lamps.clone_from(&look.light);
    }
    settings.grid &= !look.no_grid;
    settings.shadows &= !look.no_shadows;
    (settings.edges, settings.nodes) =
        (settings.edges && !look.no_graph, settings.nodes && !look.no_graph);
    settings.ids &= !look.no_graph && !look.no_ids;
    settings.robot_ids |= look.robot_ids;
    settings.plans |= look.plans;
    settings.waits |= look.waits;
    settings.density &= !look.no_density;
    if let Some(heat) = look.heat {
        (settings.heat, settings.heat_of) = (true, heat);
    }
    settings.sanitized()
}

#[cfg(test)]
mod tests {
    use glam::Vec2;
    use regatta_interface::settings::{LeftPanel, RightPanel};

    use super::*;

    fn file(test: &str) -> PathBuf {
        std::env::temp_dir()
            .join(format!("regatta-settings-{test}-{}", std::process::id()))
            .join("viewer.json")
    }

    #[test]
    fn saved_settings_are_loaded() {
        let path = file("saved");
        let settings = Settings {
            light: true,
            colour: "speed".into(),
            offset: Vec2::new(1.5, -2.0),
            floor: Some(Vec2::new(40.0, 30.0)),
            left: Some(LeftPanel::Fleet),
            right: Some(RightPanel::View),
            ..Settings::default()
        };
        save(&settings, &path).unwrap();
        assert_eq!(load(&path).unwrap(), settings);
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_pipe_keeps_nobody_waiting() {
        let path = file("pipe");
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let made = std::process::Command::new("mkfifo").arg(&path).status().unwrap();
        assert!(made.success());
        let message = load(&path).unwrap_err().to_string();
        assert!(message.contains("a pipe or a device"), "{message}");
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn a_missing_file_gives_the_defaults_and_the_error_of_a_broken_one_names_it() {
        let path = file("broken");
        assert_eq!(load(&path).unwrap(), Settings::default());
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        for text in ["", "{", "[1]", "{\"light\": 3}", "\u{0}\u{1}"] {
            std::fs::write(&path, text).unwrap();
            let message = load(&path).unwrap_err().to_string();
            assert!(message.contains("viewer.json"), "{message}");
        }
        std::fs::write(
            &path,
            "{\"trails\": 4000000, \"scale\": 90, \"colour\": \"no/name\", \"later\": 1}",
        )
        .unwrap();
        let settings = load(&path).unwrap();
        assert_eq!(
            (settings.trails, settings.scale, settings.colour.as_str()),
            (4096, 3.0, "automatic")
        );
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn options_of_the_command_line_override_settings_and_are_not_stored() {
        use clap::{Args, FromArgMatches};
        let look = |args: &[&str]| {
            let command = Options::augment_args(clap::Command::new("viewer").no_binary_name(true));
            Options::from_arg_matches(&command.try_get_matches_from(args).unwrap()).unwrap().look
        };
        let stored =
            Settings { light: true, colour: "speed".into(), trails: 9, ..Settings::default() };
        let initial = overridden(
            stored.clone(),
            &look(&[
                "--theme",
                "dark",
                "--colour",
                "collision",
                "--trails",
                "0",
                "--no-grid",
                "--plans",
                "--waits",
                "--no-density",
                "--heat",
                "speed:run",
            ]),
        );
        assert!(initial.plans && initial.waits && initial.heat && !initial.density);
        assert_eq!(initial.heat_of.to_string(), "speed:run");
        assert_eq!(
            (initial.light, initial.colour.as_str(), initial.trails, initial.grid),
            (false, "collision", 0, false)
        );
        assert_eq!(initial.to_store(&initial, &stored), stored);
        let changed = Settings { colour: "state".into(), shadows: false, ..initial.clone() };
        let wanted = Settings { colour: "state".into(), shadows: false, ..stored.clone() };
        assert_eq!(changed.to_store(&initial, &stored), wanted);
        let lit = overridden(
            Settings::default(),
            &look(&["--light", "1,2,3", "--mesh", "a.stl,0.5", "--mesh", "tug=b.stl"]),
        );
        assert_eq!(lit.lamps, [[1.0, 2.0, 3.0, 1.0, 1.0, 1.0].into()]);
        assert_eq!(lit.mesh.map(|mesh| (mesh.file, mesh.scale)), Some(("a.stl".into(), 0.5)));
    }
}
