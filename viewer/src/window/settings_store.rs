//! The settings of a window and their file, which is written some time after a change.

use std::time::{Duration, Instant};

use crate::interface::settings::Settings;
use crate::interface::settings::file::{self, SettingsError};
use crate::options::Options;

/// The time from the last change of the settings until they are written.
const SAVE_DELAY: Duration = Duration::from_secs(2);

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
        let loaded = file::path().as_deref().map_or(Ok(Settings::default()), Settings::load);
        let (stored, error) = match loaded {
            Ok(stored) => (stored, None),
            Err(error) => (Settings::default(), Some(error)),
        };
        let mut initial = stored.clone().overridden_by(&options.look);
        if let Some(size) = options.size {
            initial.window = size.0.as_vec2().to_array();
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
        file::path().map_or(Ok(()), |path| to_store.save(&path))
    }
}
