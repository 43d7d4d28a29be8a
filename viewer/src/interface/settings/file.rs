//! The settings file.

use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;

use super::Settings;

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

/// Returns the path of the settings file in the user's configuration folder; `None` for a user
/// without a home folder.
pub fn path() -> Option<PathBuf> {
    Some(etcetera::choose_base_strategy().ok()?.config_dir().join("regatta").join("viewer.json"))
}

impl Settings {
    /// Reads the settings file. Returns the default settings if it doesn't exist.
    ///
    /// # Errors
    /// If the file can't be read or is not valid.
    pub fn load(path: &Path) -> Result<Self, SettingsError> {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Ok(Self::default());
            }
            Err(error) => {
                return Err(SettingsError::File { path: path.into(), reason: error.to_string() });
            }
        };
        let settings = serde_json::from_str::<Self>(&text);
        settings
            .map(Self::sanitized)
            .map_err(|error| SettingsError::Broken { path: path.into(), reason: error.to_string() })
    }

    /// Writes the settings file atomically.
    ///
    /// # Errors
    /// [`SettingsError::File`] if the file can't be written.
    pub fn save(&self, path: &Path) -> Result<(), SettingsError> {
        let failed = |error: std::io::Error| SettingsError::File {
            path: path.into(),
            reason: error.to_string(),
        };
        let text = serde_json::to_string_pretty(self).map_err(|error| failed(error.into()))?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(failed)?;
        }
        let draft = path.with_extension(format!("{}.tmp", std::process::id()));
        std::fs::write(&draft, text + "\n").map_err(failed)?;
        std::fs::rename(&draft, path).map_err(failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interface::settings::{LeftPanel, RightPanel};

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
            offset: [1.5, -2.0],
            floor: Some([40.0, 30.0]),
            left: Some(LeftPanel::Fleet),
            right: Some(RightPanel::View),
            ..Settings::default()
        };
        settings.save(&path).unwrap();
        assert_eq!(Settings::load(&path).unwrap(), settings);
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn a_missing_file_gives_the_defaults_and_the_error_of_a_broken_one_names_it() {
        let path = file("broken");
        assert_eq!(Settings::load(&path).unwrap(), Settings::default());
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        for text in ["", "{", "[1]", "{\"light\": 3}", "\u{0}\u{1}"] {
            std::fs::write(&path, text).unwrap();
            let message = Settings::load(&path).unwrap_err().to_string();
            assert!(message.contains("viewer.json"), "{message}");
        }
        std::fs::write(
            &path,
            "{\"trails\": 4000000, \"scale\": 90, \"colour\": \"no/name\", \"later\": 1}",
        )
        .unwrap();
        let settings = Settings::load(&path).unwrap();
        assert_eq!(
            (settings.trails, settings.scale, settings.colour.as_str()),
            (4096, 3.0, "collision")
        );
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }
}
