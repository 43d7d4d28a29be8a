//! Claims of something that one participant of a fleet has at a time, in either home.

use std::rc::Rc;

use super::local;
#[cfg(feature = "shared-memory")]
use super::shared;
use crate::ports::error::OpenError;
use crate::process::join::{Home, Participant};

/// A claim that this participant holds. It ends when this is dropped, or with the process.
pub(crate) enum Claim {
    #[cfg(feature = "shared-memory")]
    Shared(#[expect(dead_code, reason = "held for its drop")] Box<shared::Claim>),
    Local(#[expect(dead_code, reason = "held for its drop")] local::Claim),
}

impl Claim {
    /// Claims the thing of a name. `taken` makes the error if another participant has it, given its
    /// holder.
    pub(crate) fn take(
        participant: &Participant,
        name: &str,
        taken: impl FnOnce(String) -> OpenError,
    ) -> Result<Self, OpenError> {
        match participant.home() {
            #[cfg(feature = "shared-memory")]
            Home::Shared(_) => Ok(Self::Shared(Box::new(shared::claim(participant, name, taken)?))),
            Home::Local(fleet) => match local::Claim::take(fleet, name, participant.name()) {
                Ok(claim) => Ok(Self::Local(claim)),
                Err(holder) => Err(taken(holder)),
            },
        }
    }
}

/// The participant that holds a claim, or that has sent a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Member {
    #[cfg(feature = "shared-memory")]
    Shared(iceoryx2::identifiers::UniqueNodeId),
    Local(u64),
}

/// Tells who holds a claim.
pub(crate) enum Holder {
    #[cfg(feature = "shared-memory")]
    Shared(Box<shared::Holder>),
    Local(Rc<local::Claimed>),
}

impl Holder {
    /// Begins to watch the claim of a name.
    pub(crate) fn open(participant: &Participant, name: &str) -> Result<Self, OpenError> {
        Ok(match participant.home() {
            #[cfg(feature = "shared-memory")]
            Home::Shared(_) => Self::Shared(Box::new(shared::Holder::open(participant, name)?)),
            Home::Local(fleet) => Self::Local(local::Claimed::of(fleet, name)),
        })
    }

    /// The holder. One that was killed counts until [`forget_dead`](Self::forget_dead).
    pub(crate) fn member(&self) -> Option<Member> {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(holder) => holder.member().map(Member::Shared),
            Self::Local(claimed) => claimed.member().map(Member::Local),
        }
    }

    /// The name of the holder, for users: `fleet-manager (process 4711)`.
    pub(crate) fn name(&self) -> Option<String> {
        match self {
            #[cfg(feature = "shared-memory")]
            Self::Shared(holder) => holder.name(),
            Self::Local(claimed) => claimed.name(),
        }
    }

    /// Ends the claim of a process that has died. Takes a millisecond or so, at most once a second.
    pub(crate) fn forget_dead(&mut self) {
        #[cfg(feature = "shared-memory")]
        if let Self::Shared(holder) = self {
            holder.forget_dead();
        }
    }
}
