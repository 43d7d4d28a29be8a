//! The ring guard: a robot must not take the last free place of a ring, in which each would then
//! wait for the next.

use super::Steering;
use crate::traffic::Blocker;

/// The length of the longest ring that is found, in robots.
const LONGEST_RING: usize = 128;

impl Steering {
    /// Returns the blocker of a robot at the end of its base, if that one waits for another robot,
    /// and so on, and the last of them for the first.
    pub(super) fn closes_ring(&self, robot: u32) -> Option<Blocker> {
        let (mut current, mut first) = (robot, None);
        for _ in 0..LONGEST_RING {
            let extension = self.traffic().extension_later(current, 0.1);
            let blocker = extension.blocker.filter(|_| extension.stretches.is_empty())?;
            let first = *first.get_or_insert(blocker);
            if blocker.robot == robot {
                return Some(first);
            }
            let goes_on = self.robot(blocker.robot).is_some_and(|state| !state.horizon.is_empty());
            if !goes_on || blocker.robot == current {
                return None;
            }
            current = blocker.robot;
        }
        None
    }
}
