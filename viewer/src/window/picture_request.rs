//! A picture of the window that the user has asked for: it waits until what is shown has settled.

use std::time::{Duration, Instant};

/// The time after which a picture is taken although something still moves.
const PATIENCE: Duration = Duration::from_secs(5);

/// A picture that is to be written to a file instead of the screen, if one is.
#[derive(Debug, Default)]
pub struct PictureRequest {
    asked_at: Option<Instant>,
}

impl PictureRequest {
    /// Asks for a picture. A picture that was asked for before, but not yet taken, is the same one.
    pub fn ask(&mut self, now: Instant) {
        self.asked_at.get_or_insert(now);
    }

    /// Whether a picture is asked for.
    pub fn is_pending(&self) -> bool {
        self.asked_at.is_some()
    }

    /// Returns whether to take the picture that began to be drawn at `begun`, and forgets the
    /// request if so. The picture in which the key was pressed is never taken: the keys pressed
    /// before it have changed the panels in it, but not yet all of the scene.
    pub fn take(&mut self, begun: Instant, is_settled: bool) -> bool {
        let Some(asked_at) = self.asked_at else { return false };
        let is_later = begun > asked_at;
        let is_late = begun.saturating_duration_since(asked_at) >= PATIENCE;
        let is_due = is_later && (is_settled || is_late);
        if is_due {
            self.asked_at = None;
        }
        is_due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_waits_until_everything_has_settled() {
        let begun = Instant::now();
        let at = |millis| begun + Duration::from_millis(millis);
        let mut request = PictureRequest::default();
        assert!(!request.take(at(0), true), "nobody has asked");
        request.ask(at(10));
        assert!(!request.take(at(0), true), "the picture in which the key was pressed");
        assert!(!request.take(at(20), false), "a flight is under way");
        assert!(request.is_pending());
        assert!(request.take(at(30), true));
        assert!(!request.is_pending() && !request.take(at(40), true), "one picture for a key");
    }

    #[test]
    fn a_picture_does_not_wait_for_ever() {
        let begun = Instant::now();
        let mut request = PictureRequest::default();
        request.ask(begun);
        request.ask(begun + Duration::from_secs(4));
        assert!(!request.take(begun + Duration::from_secs(4), false));
        assert!(request.take(begun + PATIENCE, false));
    }
}
