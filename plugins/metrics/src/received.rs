//! Values that another plugin publishes, and whether they still belong to the newest frame.

/// The largest age of results relative to the newest frame, in nanoseconds of wall time. With older
/// results, their publisher has died or hangs.
const MAX_AGE_NANOS: u64 = 2_000_000_000;

/// A value of a run, with the wall time in nanoseconds at which it was received.
#[derive(Clone, Debug)]
pub(crate) struct Received<T> {
    /// Run that the value belongs to.
    pub run_id: u64,
    /// Time at which it was received.
    pub received_nanos: u64,
    /// The value.
    pub value: T,
}

impl<T> Received<T> {
    /// Returns the value if it belongs to the newest frame, given its run id and its wall time in
    /// nanoseconds.
    pub fn if_current(&self, (run_id, wall): (u64, u64)) -> Option<&T> {
        (self.run_id == run_id && wall.saturating_sub(self.received_nanos) < MAX_AGE_NANOS)
            .then_some(&self.value)
    }
}
