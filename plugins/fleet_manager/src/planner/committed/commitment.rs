//! The ways that robots are committed to.

use crate::roads::Leg;

/// The way that a robot is committed to.
#[derive(Clone, Debug)]
pub struct Commitment {
    /// The leg that its base ended on when the way was last brought up to date.
    pub from: Leg,
    /// The legs from there to its end.
    pub way: Vec<Leg>,
    /// The number of them that it is sent along; it drives the others only if it has to leave.
    pub sent: usize,
    /// The rest place where it ends.
    pub end: u32,
    /// The goal that it leads to; `None` if it only leads nearer to it.
    pub goal: Option<u32>,
}

impl Commitment {
    /// The legs ahead of a robot whose base ends on a leg; `None` if it has left the way.
    pub(super) fn ahead(&self, last: Leg) -> Option<&[Leg]> {
        if last == self.from {
            return Some(&self.way);
        }
        let driven = self.way.iter().position(|leg| *leg == last)?;
        Some(&self.way[driven + 1..])
    }

    /// Takes the legs away that have become part of the base.
    pub(super) fn advance(&mut self, last: Leg) -> bool {
        let Some(ahead) = self.ahead(last).map(<[Leg]>::len) else { return false };
        let driven = self.way.len() - ahead;
        self.way.drain(..driven);
        self.sent = self.sent.saturating_sub(driven);
        self.from = last;
        true
    }
}
