//! Joining a fleet. Every port is opened on a [`Participant`].

use std::rc::Rc;
use std::sync::Once;

use iceoryx2::prelude::*;

use crate::ports::error::OpenError;
use crate::ports::services::Ipc;
use crate::records::cut;
use crate::records::name::FleetName;

/// A process that has joined a fleet, under a name that `regatta doctor` shows.
///
/// Cheap to clone. It and all ports that are opened on it stay on the thread that created them, which spares them locks.
/// iceoryx2's own handling of signals is switched off (it intercepts every signal that a process can get, and forgets one
/// when the next arrives); [`run`](crate::run) and [`Termination`](crate::Termination) handle Ctrl-C.
#[derive(Clone, Debug)]
pub struct Participant {
    node: Rc<Node<Ipc>>,
    fleet: FleetName,
    name: String,
}

impl Participant {
    /// Joins a fleet, whether or not it has a producer yet. Cleans up what dead processes left behind.
    ///
    /// `name` is cut to 64 bytes.
    ///
    /// # Errors
    /// [`OpenError::SharedMemory`] if this process may not use it.
    pub fn join(fleet: &FleetName, name: &str) -> Result<Self, OpenError> {
        quiet();
        let name = cut(name, 64).to_owned();
        let failed = |reason: String| OpenError::SharedMemory { what: format!("fleet '{fleet}'"), reason };
        let node = NodeBuilder::new()
            .name(&NodeName::new(&format!("regatta/{fleet}/{name}")).map_err(|e| failed(format!("{e:?}")))?)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|e| failed(e.to_string()))?;
        Ok(Self { node: Rc::new(node), fleet: fleet.clone(), name })
    }

    /// The node of iceoryx2 that represents this process.
    pub(crate) fn node(&self) -> &Node<Ipc> {
        &self.node
    }

    /// The fleet.
    pub fn fleet(&self) -> &FleetName {
        &self.fleet
    }

    /// The name of this process in the fleet.
    pub fn name(&self) -> &str {
        &self.name
    }
}

static QUIET: Once = Once::new();

/// Sets how much of its own log iceoryx2 writes to stderr: 0 nothing (unless `IOX2_LOG_LEVEL` says otherwise),
/// 1 warnings, 2 everything.
pub fn set_verbosity(level: u8) {
    QUIET.call_once(|| ());
    match level {
        0 => set_log_level_from_env_or(LogLevel::Fatal),
        1 => set_log_level(LogLevel::Warn),
        _ => set_log_level(LogLevel::Trace),
    }
}

/// The configuration of iceoryx2: its defaults, unless a file `config/iceoryx2.toml` (in the current, the user's or the
/// system's configuration folder) says otherwise.
pub(crate) fn config() -> &'static Config {
    quiet();
    Config::global_config()
}

/// Silences iceoryx2's log unless [`set_verbosity`] was called: each of its errors becomes one of ours.
pub(crate) fn quiet() {
    QUIET.call_once(|| set_log_level_from_env_or(LogLevel::Fatal));
}
