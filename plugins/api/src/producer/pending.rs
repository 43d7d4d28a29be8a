//! Control requests that wait for their answers.

use super::RefusalReason;

/// A request that was carried out or refused, and waits for its answer.
#[derive(Debug)]
pub(super) struct Pending {
    /// The ticket by which to answer it.
    pub(super) ticket: u64,
    /// The number of steps in all after which it is answered.
    pub(super) due: u64,
    /// The reason if it is refused.
    pub(super) refusal: Option<RefusalReason>,
}
