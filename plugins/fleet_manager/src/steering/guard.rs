//! The ring guard: a robot must not take the last free place of a ring, in which each would then wait for the next.

use super::Steering;

/// The longest ring that is looked for.
const LONGEST_RING: usize = 128;

impl Steering {
    /// Whether a robot, at the end of its base, would wait for itself: for a robot that waits for another one, and so on.
    pub(super) fn closes_ring(&self, robot: u32) -> bool {
        let mut current = robot;
        for _ in 0..LONGEST_RING {
            let extension = self.traffic().extension_later(current, 0.1);
            let Some((blocker, _)) = extension.blocker.filter(|_| extension.stretches.is_empty()) else { return false };
            if blocker == robot {
                return true;
            }
            let goes_on = self.robot(blocker).is_some_and(|state| !state.horizon.is_empty());
            if !goes_on || blocker == current {
                return false;
            }
            current = blocker;
        }
        false
    }
}
