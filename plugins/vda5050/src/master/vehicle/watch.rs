//! Troubles of a vehicle: noted, told, and kept away from.

use regatta_plugin::event::{BreakdownCause, EventKind, EventRecord};

use super::super::trouble::Trouble;
use super::{Limits, Size, Vehicle, event};
use crate::message::ConnectionState;

impl Vehicle {
    /// Looks after the vehicle: notes and tells troubles that begin and end.
    pub fn look(&mut self, limits: Limits, now: f64) {
        let trouble = self.find_trouble(limits, now);
        let is_same = match (&self.trouble, &trouble) {
            (None, None) => true,
            (Some(before), Some(after)) => before.is_like(after),
            _ => false,
        };
        if !is_same {
            self.tell(trouble.as_ref());
        }
        self.is_loose |= trouble.as_ref().is_some_and(Trouble::is_loose);
        self.trouble = trouble;
    }

    fn tell(&mut self, trouble: Option<&Trouble>) {
        match trouble {
            Some(trouble) => {
                let measure = match trouble.is_loose() {
                    true => "the edges around it are closed",
                    false => "its path is kept free",
                };
                self.lines.push(format!("{trouble}; {measure}"));
                if self.trouble.is_none() {
                    let detail = BreakdownCause::Unknown as u32;
                    self.events.push(EventRecord { detail, ..event(EventKind::BrokenDown, 0) });
                }
            }
            None => {
                self.lines.push("it can be steered again".to_owned());
                self.events.push(event(EventKind::Repaired, 0));
            }
        }
    }

    fn find_trouble(&self, limits: Limits, now: f64) -> Option<Trouble> {
        if self.connection != ConnectionState::Online {
            return Some(Trouble::Gone(self.connection));
        }
        let state = self.state.as_ref()?;
        let silence = now - self.heard;
        if silence > limits.silence {
            return Some(Trouble::Silent(silence as u64));
        }
        if let Some(trouble) = Trouble::of_state(state) {
            return Some(trouble);
        }
        if let Size::TooLarge(size) = self.size {
            return Some(Trouble::TooLarge(size));
        }
        if self.course.is_none() {
            return Some(Trouble::OffRoads);
        }
        if self.off_way > limits.tolerance {
            return Some(Trouble::Astray(self.off_way));
        }
        if self.has_stray_load() {
            return Some(Trouble::Loaded);
        }
        if let Some(reason) = self.talk.rejection() {
            return Some(Trouble::Rejects(reason.to_owned()));
        }
        self.talk.is_unanswered().then_some(Trouble::Mute)
    }

    /// The position of a vehicle around which no robot may drive.
    pub fn loose_at(&self) -> Option<[f64; 2]> {
        let is_loose = self.is_loose && self.is_known() && !self.is_removed;
        let position = self.position.as_ref().filter(|_| is_loose)?;
        Some([position.x, position.y])
    }
}
