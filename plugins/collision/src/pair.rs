//! When a pair comes to a level and when it leaves it.

use regatta_plugin::contact::ContactLevel;

use crate::body::{Body, apart, gap};
use crate::meeting::{Meeting, meet};
use crate::prediction::Piece;
use crate::settings::{HYSTERESIS, Settings};

/// Beyond the margin, in metres: by more than the hysteresis and what is lost by rounding.
const FAR: f32 = 0.2;

/// What a frame alone says about a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Signs(u8);

impl Signs {
    /// The footprints overlap.
    const TOUCH: u8 = 1;
    /// They do, but for the hysteresis.
    const STILL_TOUCH: u8 = 2;
    /// They are within the margin, or will touch within the horizon.
    const MAY: u8 = 4;
    /// They are or will, but for the hysteresis.
    const STILL_MAY: u8 = 8;

    /// Whether the pair may have a level at all.
    pub(crate) fn any(self) -> bool {
        self.0 != 0
    }

    fn has(self, sign: u8) -> bool {
        self.0 & sign != 0
    }

    /// The level of a pair that had that one before. It comes to a level when it gets there, and leaves it when it is
    /// farther than the hysteresis beyond.
    pub(crate) fn level(self, before: Option<ContactLevel>) -> Option<ContactLevel> {
        let touched = before == Some(ContactLevel::Touching);
        if self.has(Self::TOUCH) || touched && self.has(Self::STILL_TOUCH) {
            Some(ContactLevel::Touching)
        } else if self.has(Self::MAY) || before.is_some() && self.has(Self::STILL_MAY) {
            Some(ContactLevel::Possible)
        } else {
            None
        }
    }

    /// Of two robots of a frame, the one with the lower id first: so that they always come out the same.
    pub(crate) fn of(settings: Settings, (a, pieces_a): (&Body, &[Piece]), (b, pieces_b): (&Body, &[Piece])) -> Self {
        let margin = f64::from(settings.margin());
        let gap = if apart(a, b) > settings.margin() + FAR { f64::INFINITY } else { gap(a, b, margin + HYSTERESIS) };
        let sign = |holds: bool, sign: u8| if holds { sign } else { 0 };
        let now = sign(gap <= 0.0, Self::TOUCH)
            | sign(gap <= HYSTERESIS, Self::STILL_TOUCH)
            | sign(gap <= margin, Self::MAY)
            | sign(gap <= margin + HYSTERESIS, Self::STILL_MAY);
        if gap <= margin || settings.horizon() == 0.0 {
            return Self(now);
        }
        let later = match meet((a, pieces_a), (b, pieces_b), 0.5 * HYSTERESIS) {
            Meeting::None => 0,
            Meeting::Near => Self::STILL_MAY,
            Meeting::Overlap => Self::STILL_MAY | Self::MAY,
        };
        Self(now | later)
    }
}
