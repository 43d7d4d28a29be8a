//! A message to the user, once, that a plugin waits for something.

use std::time::{Duration, Instant};

use crate::ports::frames::Subscriber;

/// The time without a frame after which the user is told.
pub(super) const SILENCE: Duration = Duration::from_secs(1);

/// Reports once, on stderr, that the fleet has no engine.
#[derive(Debug)]
pub(super) struct Silence {
    since: Instant,
    reported: bool,
}

impl Silence {
    pub(super) fn new() -> Self {
        Self { since: Instant::now(), reported: false }
    }

    /// No frame has come.
    pub(super) fn check(&mut self, frames: &Subscriber) {
        if self.reported || self.since.elapsed() < SILENCE {
            return;
        }
        self.since = Instant::now();
        frames.forget_dead();
        if !frames.has_producer() {
            let participant = frames.participant();
            crate::tell!(
                "{}: waiting for an engine of fleet '{}'",
                participant.name(),
                participant.fleet()
            );
            self.reported = true;
        }
    }

    /// A frame has come.
    pub(super) fn end(&mut self) {
        *self = Self::new();
    }
}
