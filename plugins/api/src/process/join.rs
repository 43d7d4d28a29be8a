//! Joining a fleet. Every port is opened on a [`Participant`].

#[cfg(feature = "shared-memory")]
use std::rc::Rc;

#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::*;

#[cfg(feature = "shared-memory")]
use super::{domain::config, health, management, open_files::reason};
use crate::ports::error::OpenError;
use crate::records::cut;
use crate::records::name::{ColumnName, FleetName};
use crate::transport::local::LocalFleet;
#[cfg(feature = "shared-memory")]
use crate::transport::shared::{FULL, Ipc, guarded};

/// The member of a fleet that opens ports: a process that has joined one, under a name that
/// `regatta doctor` shows, or a part of a [`LocalFleet`].
///
/// ```
/// use regatta_plugin::{Participant, Result, Subscriber, WorldReader};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-join-{}", std::process::id()).parse()?;
/// let participant = Participant::join(&fleet, "watcher")?;
/// let frames = Subscriber::open_on(&participant)?;
/// let worlds = WorldReader::open_on(&participant)?;
/// assert!(!frames.has_producer());
/// # Ok(())
/// # }
/// ```
///
/// Cheap to clone. It and all ports that are opened on it stay on the thread that created them,
/// which spares them locks. iceoryx2's own handling of signals is switched off (it intercepts every
/// signal that a process can get, and forgets one when the next arrives); [`run`](crate::run) and
/// [`Termination`](crate::Termination) handle Ctrl-C.
#[derive(Clone, Debug)]
pub struct Participant {
    home: Home,
    fleet: FleetName,
    name: String,
}

/// The place of a fleet's ports.
#[derive(Clone, Debug)]
pub(crate) enum Home {
    /// Shared memory. The node of iceoryx2 represents this process.
    #[cfg(feature = "shared-memory")]
    Shared(Rc<Node<Ipc>>),
    /// The memory of this process.
    Local(LocalFleet),
}

/// The longest name of a participant, in bytes.
const MAX_NAME_BYTES: usize = 64;

impl Participant {
    /// Joins a fleet, whether or not it has a producer yet. Removes the resources of dead
    /// processes.
    ///
    /// `name` is cut to 64 bytes.
    ///
    /// # Errors
    /// [`OpenError::Domain`] if this user has no directory for shared memory,
    /// [`OpenError::SharedMemory`] if this process may not use it.
    #[cfg(feature = "shared-memory")]
    pub fn join(fleet: &FleetName, name: &str) -> Result<Self, OpenError> {
        let name = cut(name, MAX_NAME_BYTES).to_owned();
        let failed =
            |reason: String| OpenError::SharedMemory { what: format!("fleet '{fleet}'"), reason };
        let config = config()?;
        // Checked first: iceoryx2 would wait for ever for a segment without contents.
        if let Some(damage) = management::damage() {
            return Err(failed(damage));
        }
        let node_name = format!("regatta/{fleet}/{name}");
        let builder = NodeBuilder::new()
            .config(config)
            .name(
                &NodeName::new(cut(&node_name, MAX_NODE_NAME_BYTES))
                    .map_err(|e| failed(format!("{e:?}")))?,
            )
            .signal_handling_mode(SignalHandlingMode::Disabled);
        health::remove_unfinished();
        let (node, missing) = guarded(|| builder.create::<Ipc>());
        if missing.any() {
            return Err(failed(FULL.to_owned()));
        }
        let node = node.map_err(|e| failed(reason(e)))?;
        management::close_to_others();
        Ok(Self { home: Home::Shared(Rc::new(node)), fleet: fleet.clone(), name })
    }

    /// Joins a fleet: impossible without shared memory.
    ///
    /// # Errors
    /// Always [`OpenError::SharedMemory`].
    #[cfg(not(feature = "shared-memory"))]
    pub fn join(fleet: &FleetName, _name: &str) -> Result<Self, OpenError> {
        Err(OpenError::SharedMemory {
            what: format!("fleet '{fleet}'"),
            reason: "this program was built without it".to_owned(),
        })
    }

    /// Creates a participant of a local fleet.
    pub(crate) fn of_local(fleet: LocalFleet, name: &str) -> Self {
        let name = cut(name, MAX_NAME_BYTES).to_owned();
        Self { fleet: fleet.name().clone(), home: Home::Local(fleet), name }
    }

    /// The place of the fleet's ports.
    pub(crate) fn home(&self) -> &Home {
        &self.home
    }

    /// The node of iceoryx2; `None` in a local fleet.
    #[cfg(feature = "shared-memory")]
    pub(crate) fn node(&self) -> Option<&Node<Ipc>> {
        match &self.home {
            Home::Shared(node) => Some(node),
            Home::Local(_) => None,
        }
    }

    /// The participant in shared memory: this one, or that by which a local fleet is published.
    #[cfg(feature = "shared-memory")]
    pub(crate) fn shared(&self) -> Option<&Self> {
        match &self.home {
            Home::Shared(_) => Some(self),
            Home::Local(fleet) => fleet.mirror(),
        }
    }

    /// Whether all ports of the fleet belong to this thread, so that nobody can be waited for.
    pub fn is_local(&self) -> bool {
        matches!(self.home, Home::Local(_))
    }

    /// Returns the columns that are published or read in the fleet, sorted. In shared memory it
    /// lists all services of the machine, which is too slow to do for every frame.
    pub fn column_names(&self) -> Vec<ColumnName> {
        match &self.home {
            #[cfg(feature = "shared-memory")]
            Home::Shared(_) => crate::ports::columns::column_names(&self.fleet),
            Home::Local(fleet) => fleet.column_names(),
        }
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

#[cfg(feature = "shared-memory")]
/// iceoryx2's limit. The name of a node serves `regatta doctor` only, so a longer one is cut.
const MAX_NODE_NAME_BYTES: usize = 128;
