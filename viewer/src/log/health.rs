//! The health of a fleet for which there is no event: whether its robots move, and whether its
//! manager is alive.

use regatta_interface::log::{AlarmChange, AlarmKey, Entry, Kind, Place, Severity};
use regatta_plugin::frame::{Frame, RobotState};

/// The simulated time between two looks from which on it is a jump in a recording, in nanoseconds.
const JUMP_NANOS: u64 = 10_000_000_000;
/// The simulated time for which robots that want to drive all stand, until that is an alarm, in
/// nanoseconds.
const STANDSTILL_NANOS: u64 = 30_000_000_000;
/// The simulated time without messages after which a fleet manager counts as silent, in
/// nanoseconds.
const SILENCE_NANOS: u64 = 5_000_000_000;

/// The health of a fleet, beyond its events.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Health {
    /// The last time at which robots that want to drive moved, in simulated nanoseconds.
    moved: u64,
    /// The time of the last look, in simulated nanoseconds.
    looked: u64,
    stands: bool,
    /// The last time that the fleet manager reported, in simulated nanoseconds; `None` if there was
    /// no manager in this run.
    managed: Option<u64>,
    is_silent: bool,
    is_managed: bool,
}

impl Health {
    /// The health at the start of a run, at a simulated time in nanoseconds.
    pub fn new(now: u64) -> Self {
        Self { moved: now, looked: now, ..Self::default() }
    }

    /// Takes the time of a look. A jump in a recording leaves the time in between unknown.
    pub fn look(&mut self, now: u64, is_replayed: bool) {
        if is_replayed && now.abs_diff(self.looked) > JUMP_NANOS {
            self.moved = now;
        }
        self.looked = now;
    }

    /// Takes the time that a fleet manager last reported.
    pub fn see_manager(&mut self, now: u64, told: Option<u64>) -> Option<(Entry, AlarmChange)> {
        self.managed = told.or(self.managed);
        let is_silent = self.managed.is_some_and(|told| now > told.saturating_add(SILENCE_NANOS));
        if std::mem::replace(&mut self.is_silent, is_silent) == is_silent {
            return None;
        }
        let (severity, text, change) = match is_silent {
            true => (
                Severity::Alarm,
                "the fleet manager is silent or gone",
                AlarmChange::Begins(AlarmKey::Manager),
            ),
            false => {
                (Severity::Info, "the fleet manager is back", AlarmChange::Ends(AlarmKey::Manager))
            }
        };
        Some((about_fleet(now, severity, text.to_owned()), change))
    }

    /// Whether a fleet manager steers the robots, if that has changed.
    pub fn change_of_management(&mut self) -> Option<bool> {
        let is_managed = self.managed.is_some() && !self.is_silent;
        (std::mem::replace(&mut self.is_managed, is_managed) != is_managed).then_some(is_managed)
    }

    /// Takes whether all robots that want to drive stand.
    pub fn see_motion(&mut self, now: u64, is_stuck: bool) -> Option<(Entry, AlarmChange)> {
        if !is_stuck || now < self.moved {
            self.moved = now;
        }
        let stands = now - self.moved >= STANDSTILL_NANOS;
        if std::mem::replace(&mut self.stands, stands) == stands {
            return None;
        }
        let secs = STANDSTILL_NANOS / 1_000_000_000;
        Some(match stands {
            true => {
                let text =
                    format!("standstill: robots want to drive, and none has moved for {secs} s");
                (about_fleet(now, Severity::Alarm, text), AlarmChange::Begins(AlarmKey::Standstill))
            }
            false => {
                let entry = about_fleet(now, Severity::Info, "robots move again".to_owned());
                (entry, AlarmChange::Ends(AlarmKey::Standstill))
            }
        })
    }
}

/// Whether robots want to drive, and none of them moves. Ends with the first one that does.
pub(super) fn is_stuck(frame: &Frame<'_>) -> bool {
    let columns = frame.columns();
    let mut waiting = false;
    for (state, speed) in columns.state.iter().zip(columns.speed) {
        match RobotState::from_number(*state) {
            RobotState::Turning => return false,
            RobotState::Driving | RobotState::Waiting if *speed != 0.0 => return false,
            RobotState::Driving | RobotState::Waiting => waiting = true,
            _ => {}
        }
    }
    waiting
}

pub(super) fn about_fleet(time_nanos: u64, severity: Severity, text: String) -> Entry {
    Entry { time_nanos, kind: Kind::Fleet, severity, robot: None, place: Place::None, text }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    #[test]
    fn a_manager_that_tells_of_no_frames_is_silent_until_it_does() {
        let mut health = Health::default();
        assert_eq!(health.see_manager(100 * SECOND, None), None, "there was none");
        assert_eq!(health.see_manager(101 * SECOND, Some(101 * SECOND)), None);
        assert_eq!(health.see_manager(105 * SECOND, Some(101 * SECOND)), None);
        let silent = health.see_manager(107 * SECOND, None).map(|(_, change)| change);
        assert_eq!(silent, Some(AlarmChange::Begins(AlarmKey::Manager)));
        assert_eq!(health.see_manager(108 * SECOND, None), None, "told once");
        let back = health.see_manager(109 * SECOND, Some(109 * SECOND)).map(|(_, change)| change);
        assert_eq!(back, Some(AlarmChange::Ends(AlarmKey::Manager)));
    }

    #[test]
    fn a_standstill_takes_half_a_minute() {
        let mut health = Health::default();
        assert_eq!(health.see_motion(SECOND, false), None);
        assert_eq!(health.see_motion(30 * SECOND, true), None);
        let stands = health.see_motion(31 * SECOND, true).map(|(_, change)| change);
        assert_eq!(stands, Some(AlarmChange::Begins(AlarmKey::Standstill)));
        assert_eq!(health.see_motion(90 * SECOND, true), None);
        let moves = health.see_motion(91 * SECOND, false).map(|(_, change)| change);
        assert_eq!(moves, Some(AlarmChange::Ends(AlarmKey::Standstill)));
    }

    #[test]
    fn a_jump_in_a_recording_is_no_standstill() {
        let mut health = Health::default();
        let mut see = |secs: u64| {
            health.look(secs * SECOND, true);
            health.see_motion(secs * SECOND, true).map(|(_, change)| change)
        };
        assert_eq!(see(1), None);
        assert_eq!(see(100), None, "what was in between isn't known");
        assert!((101..130).all(|secs| see(secs).is_none()));
        assert_eq!(see(130), Some(AlarmChange::Begins(AlarmKey::Standstill)));
    }
}
