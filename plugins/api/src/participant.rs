//! A process's place in a fleet: what everything else is opened on.

use std::rc::Rc;
use std::sync::Once;

use iceoryx2::prelude::*;

use crate::column::{ColumnPublisher, ColumnReader};
use crate::control_client::Control;
use crate::error::{OpenError, Result};
use crate::fleet_name::FleetName;
use crate::order_sender::Orders;
use crate::qos::Ipc;
use crate::route_ports::RouteClient;

/// A process's place in a fleet, by a name that `regatta doctor` shows.
///
/// Cheap to clone. It and all that is opened on it stay on the thread that made them: this is what spares
/// them locks. iceoryx2's own handling of signals is switched off (it takes over every signal a process can
/// get, and forgets one when the next arrives); [`run`](crate::run) and [`Termination`](crate::Termination) see to Ctrl-C.
#[derive(Clone, Debug)]
pub struct Participant {
    pub(crate) node: Rc<Node<Ipc>>,
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

    /// Opens a column for writing, by its name.
    ///
    /// # Errors
    /// As [`ColumnPublisher::open_on`]; or the name is none.
    pub fn column(&self, name: &str) -> Result<ColumnPublisher> {
        Ok(ColumnPublisher::open_on(self, &name.parse()?)?)
    }

    /// Opens a column for reading, by its name.
    ///
    /// # Errors
    /// As [`ColumnReader::open_on`]; or the name is none.
    pub fn column_reader(&self, name: &str) -> Result<ColumnReader> {
        Ok(ColumnReader::open_on(self, &name.parse()?)?)
    }

    /// Opens the orders, for sending.
    ///
    /// # Errors
    /// As [`Orders::open_on`].
    pub fn orders(&self) -> Result<Orders, OpenError> {
        Orders::open_on(self)
    }

    /// Opens the control service, for sending requests.
    ///
    /// # Errors
    /// As [`Control::open_on`].
    pub fn control(&self) -> Result<Control, OpenError> {
        Control::open_on(self)
    }

    /// Opens the routes, for asking.
    ///
    /// # Errors
    /// As [`RouteClient::open_on`].
    pub fn routes(&self) -> Result<RouteClient, OpenError> {
        RouteClient::open_on(self)
    }

    /// The fleet that it joined.
    pub fn fleet(&self) -> &FleetName {
        &self.fleet
    }

    /// The name that it joined by.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// The longest start of `text` of at most `bytes` bytes.
pub(crate) fn cut(text: &str, bytes: usize) -> &str {
    &text[..text.floor_char_boundary(bytes)]
}

static QUIET: Once = Once::new();

/// Sets how much of its own iceoryx2 writes to stderr: 0 nothing (unless `IOX2_LOG_LEVEL` asks for it),
/// 1 warnings, 2 all of it.
pub fn set_verbosity(level: u8) {
    QUIET.call_once(|| ());
    match level {
        0 => set_log_level_from_env_or(LogLevel::Fatal),
        1 => set_log_level(LogLevel::Warn),
        _ => set_log_level(LogLevel::Trace),
    }
}

/// iceoryx2's configuration: its defaults, unless a file `config/iceoryx2.toml` (here, in the user's or in the
/// system's configuration folder) says otherwise.
pub(crate) fn config() -> &'static Config {
    quiet();
    Config::global_config()
}

/// Unless [`set_verbosity`] was called: iceoryx2 logs nothing, because each of its errors becomes one of ours.
pub(crate) fn quiet() {
    QUIET.call_once(|| set_log_level_from_env_or(LogLevel::Fatal));
}
