//! When a pair comes to a level and when it leaves it.

use regatta_plugin::contact::ContactLevel;

use crate::body::gap;
use crate::crowd::Crowd;
use crate::meeting::meet;
use crate::settings::{HYSTERESIS, Settings};

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

    /// Bits that hold them.
    pub(crate) const BITS: u32 = 4;

    pub(crate) fn to_bits(self) -> u64 {
        self.0.into()
    }

    pub(crate) fn from_bits(bits: u64) -> Self {
        Self(bits as u8 & ((1 << Self::BITS) - 1))
    }

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

    /// Of two robots of a frame that both are there, the one with the lower id first: so that they always come out the
    /// same.
    pub(crate) fn of(crowd: &Crowd, settings: Settings, first: u32, second: u32) -> Self {
        let (a, b) = (crowd.body_of(first), crowd.body_of(second));
        let margin = f64::from(settings.margin());
        let gap = gap(a, b, margin + HYSTERESIS);
        let mut signs = 0;
        if gap <= 0.0 {
            signs |= Self::TOUCH;
        }
        if gap <= HYSTERESIS {
            signs |= Self::STILL_TOUCH;
        }
        let is_near = gap <= margin + HYSTERESIS;
        if is_near {
            signs |= Self::STILL_MAY;
        }
        if gap <= margin {
            return Self(signs | Self::MAY);
        }
        let ways = (crowd.way(first, a.outline()), crowd.way(second, b.outline()));
        if is_near || meet(ways.0, ways.1, 0.5 * HYSTERESIS) {
            signs |= Self::STILL_MAY;
            if meet(ways.0, ways.1, 0.0) {
                signs |= Self::MAY;
            }
        }
        Self(signs)
    }
}
