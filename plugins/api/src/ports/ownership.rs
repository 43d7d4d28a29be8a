//! The ownership of movement: while a process of a fleet owns it, no other one may send robots
//! along routes.

use super::error::OpenError;
use super::services;
use crate::process::join::Participant;
use crate::records::command::{Authority, CommandHeader, CommandKind, CommandRecord};
use crate::transport::{Claim, Holder, Member, Sample, Subscriber};

/// The movement of a fleet's robots, which this process owns. Only its commands assign, extend,
/// release and cancel routes; the engine refuses those of others, with
/// [`Refusal::NotOwner`](crate::event::Refusal::NotOwner). Others may still hold, resume, break,
/// repair, add and remove robots, and close and open edges.
///
/// Ownership doesn't depend on an engine: it can be claimed before there is one. It ends when this
/// is dropped, or with the process, however that ends. A fleet without an owner is moved by all.
///
/// ```
/// use regatta_plugin::{Commands, OpenError, Ownership, Participant, Result};
///
/// # fn main() -> Result {
/// # let fleet = format!("doc-ownership-{}", std::process::id()).parse()?;
/// let manager = Participant::join(&fleet, "manager")?;
/// let _ownership = Ownership::claim(&manager)?;
/// let _commands = Commands::open_on(&manager)?;
///
/// let other = Participant::join(&fleet, "other")?;
/// assert!(matches!(Ownership::claim(&other), Err(OpenError::Owned { .. })));
/// # Ok(())
/// # }
/// ```
pub struct Ownership {
    #[expect(dead_code, reason = "held for its drop")]
    claim: Claim,
}

impl Ownership {
    /// Claims the movement of a fleet. The owner's commands are those that this participant sends.
    ///
    /// # Errors
    /// [`OpenError::Owned`] if another process owns it, [`OpenError::OtherVersion`] if the fleet
    /// uses another contract, else [`OpenError::SharedMemory`].
    pub fn claim(participant: &Participant) -> Result<Self, OpenError> {
        let fleet = participant.fleet().clone();
        let claim =
            Claim::take(participant, services::OWNER, |owner| OpenError::Owned { fleet, owner })?;
        Ok(Self { claim })
    }
}

impl core::fmt::Debug for Ownership {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Ownership").finish_non_exhaustive()
    }
}

/// Tells a producer who owns the movement of its robots.
pub(super) struct OwnerWatch {
    holder: Holder,
    /// The last owner, and its name.
    known: Option<(Member, String)>,
}

impl OwnerWatch {
    pub(super) fn open(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { holder: Holder::open(participant, services::OWNER)?, known: None })
    }

    /// The name of the owner. It is looked up once for each owner, because it lies in files.
    pub(super) fn name(&mut self) -> Option<&str> {
        let member = self.holder.member()?;
        if self.known.as_ref().is_none_or(|(known, _)| *known != member) {
            self.known = Some((member, self.holder.name()?));
        }
        self.known.as_ref().map(|(_, name)| name.as_str())
    }

    /// Returns the commands that the sender of a sample may give. An owner that has died owns
    /// nothing.
    pub(super) fn authority(
        &mut self,
        samples: &Subscriber<CommandRecord, CommandHeader>,
        sample: &Sample<CommandRecord, CommandHeader>,
    ) -> Authority {
        let Some(owner) = self.holder.member() else { return Authority::Full };
        if samples.sender(sample) == Some(owner) || !sample.records().iter().any(moves) {
            return Authority::Full;
        }
        self.holder.forget_dead();
        match self.holder.member() {
            Some(_) => Authority::WithoutMovement,
            None => Authority::Full,
        }
    }
}

fn moves(record: &CommandRecord) -> bool {
    CommandKind::from_number(record.kind).is_some_and(CommandKind::moves)
}
