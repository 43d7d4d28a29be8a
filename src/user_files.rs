//! The files of this user, in the folder for settings.

use std::path::PathBuf;

use etcetera::BaseStrategy;

/// Returns the path of a file of the user; `None` for a user without a home folder.
pub fn path(name: &str) -> Option<PathBuf> {
    Some(etcetera::choose_base_strategy().ok()?.config_dir().join("regatta").join(name))
}
