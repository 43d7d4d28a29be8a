//! Claims within a process.

use core::cell::RefCell;
use std::rc::Rc;

use super::LocalFleet;

/// Something that one participant claims at a time: its number and name.
#[derive(Default)]
pub(crate) struct Claimed(RefCell<Option<(u64, String)>>);

impl Claimed {
    /// The claim of a name.
    pub(in crate::transport) fn of(fleet: &LocalFleet, name: &str) -> Rc<Self> {
        fleet.service(name)
    }

    /// The number of the participant that has it.
    pub(in crate::transport) fn member(&self) -> Option<u64> {
        self.0.borrow().as_ref().map(|(member, _)| *member)
    }

    /// The name of the participant that has it.
    pub(in crate::transport) fn name(&self) -> Option<String> {
        self.0.borrow().as_ref().map(|(_, name)| name.clone())
    }
}

/// A claim that a participant holds, until this is dropped.
pub(crate) struct Claim(Rc<Claimed>);

impl Claim {
    /// Takes the claim of a name for a participant, or returns the name of its holder.
    pub(in crate::transport) fn take(
        fleet: &LocalFleet,
        name: &str,
        holder: &str,
    ) -> Result<Self, String> {
        let claimed = Claimed::of(fleet, name);
        if let Some(holder) = claimed.name() {
            return Err(holder);
        }
        *claimed.0.borrow_mut() = Some((fleet.member, holder.to_owned()));
        Ok(Self(claimed))
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.0.0.borrow_mut().take();
    }
}
