//! When a pair comes to a level and when it leaves it.

use regatta_plugin::contact::ContactLevel;

use crate::body::{Body, gap};
use crate::meeting::Meeting;
use crate::settings::{HYSTERESIS, Settings};

/// By how much both are larger, on all sides, that are to stay apart on their ways, in metres.
pub(crate) const GROWN: f64 = 0.5 * HYSTERESIS;

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

    /// Whether the present alone makes it possible, or certain, so that it doesn't matter what they do next.
    pub(crate) fn may(self) -> bool {
        self.has(Self::MAY)
    }

    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// What the footprints of two robots say by themselves; the one with the lower id first, so that they always come out
    /// the same.
    pub(crate) fn now(settings: Settings, a: &Body, b: &Body) -> Self {
        let margin = f64::from(settings.margin());
        let gap = gap(a, b, margin + HYSTERESIS);
        let sign = |holds: bool, sign: u8| if holds { sign } else { 0 };
        Self(
            sign(gap <= 0.0, Self::TOUCH)
                | sign(gap <= HYSTERESIS, Self::STILL_TOUCH)
                | sign(gap <= margin, Self::MAY)
                | sign(gap <= margin + HYSTERESIS, Self::STILL_MAY),
        )
    }

    /// What their ways say, grown by [`GROWN`].
    pub(crate) fn later(meeting: Meeting) -> Self {
        match meeting {
            Meeting::None => Self(0),
            Meeting::Near => Self(Self::STILL_MAY),
            Meeting::Overlap => Self(Self::STILL_MAY | Self::MAY),
        }
    }
}
