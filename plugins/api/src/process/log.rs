//! iceoryx2's own log, which is silent by default.

use std::sync::Once;

use iceoryx2::prelude::{LogLevel, set_log_level, set_log_level_from_env_or};

static QUIET: Once = Once::new();

/// Sets the level of the log that iceoryx2 writes to stderr: 0 nothing (unless `IOX2_LOG_LEVEL`
/// says otherwise), 1 warnings, 2 everything.
pub fn set_verbosity(level: u8) {
    QUIET.call_once(|| ());
    match level {
        0 => set_log_level_from_env_or(LogLevel::Fatal),
        1 => set_log_level(LogLevel::Warn),
        _ => set_log_level(LogLevel::Trace),
    }
}

/// Silences iceoryx2's log unless [`set_verbosity`] was called: each of its errors becomes one of
/// ours.
pub(super) fn quiet() {
    QUIET.call_once(|| set_log_level_from_env_or(LogLevel::Fatal));
}
