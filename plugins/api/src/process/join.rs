//! Joining a fleet. Every port is opened on a [`Participant`].

use std::rc::Rc;

use iceoryx2::prelude::*;

use super::domain::config;
use super::health;
use super::management;
use crate::ports::error::OpenError;
use crate::ports::full_memory::{FULL, guarded};
use crate::ports::services::Ipc;
use crate::records::cut;
use crate::records::name::FleetName;

/// A process that has joined a fleet, under a name that `regatta doctor` shows.
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
    node: Rc<Node<Ipc>>,
    fleet: FleetName,
    name: String,
}

impl Participant {
    /// Joins a fleet, whether or not it has a producer yet. Removes the resources of dead
    /// processes.
    ///
    /// `name` is cut to 64 bytes.
    ///
    /// # Errors
    /// [`OpenError::Domain`] if this user has no directory for shared memory,
    /// [`OpenError::SharedMemory`] if this process may not use it.
    pub fn join(fleet: &FleetName, name: &str) -> Result<Self, OpenError> {
        let name = cut(name, 64).to_owned();
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
        let node = node.map_err(|e| failed(e.to_string()))?;
        management::close_to_others();
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

/// iceoryx2's limit. The name of a node serves `regatta doctor` only, so a longer one is cut.
const MAX_NODE_NAME_BYTES: usize = 128;
