//! When the next picture is due: at the screen's rate while something moves, else not before there is news.

use std::time::{Duration, Instant};

/// Between two looks for news while nothing moves.
const LOOK: Duration = Duration::from_millis(30);
/// Pictures go on for so long after the last news: columns come some moments after their frame.
const AFTERMATH: Duration = Duration::from_millis(400);
/// For screens that don't say how often they show a picture.
const USUAL_RATE: f64 = 60.0;

/// When to draw.
#[derive(Debug)]
pub struct Pulse {
    drawn: Instant,
    /// Something moves until then.
    moves_until: Instant,
    /// When the interface wants to be drawn.
    wanted: Option<Instant>,
    /// Least time between two pictures.
    period: Duration,
}

impl Pulse {
    /// For a screen of so many pictures a second.
    pub fn new(rate: Option<f64>, software: bool, now: Instant) -> Self {
        let period = 1.0 / rate.filter(|rate| *rate >= 1.0).unwrap_or(USUAL_RATE);
        // A real screen sets the pace itself: here it is only kept from being overrun.
        let period = if software { period } else { period * 0.75 };
        Self { drawn: now, moves_until: now + AFTERMATH, wanted: None, period: Duration::from_secs_f64(period) }
    }

    /// A picture is being drawn now.
    pub fn draw(&mut self, now: Instant) {
        // In step with the period rather than with the moment, which is always a bit late.
        self.drawn = (self.drawn + self.period).max(now.checked_sub(self.period).unwrap_or(now));
        self.wanted = None;
    }

    /// There is news, or something moves.
    pub fn stir(&mut self, now: Instant) {
        self.moves_until = now + AFTERMATH;
    }

    /// The interface wants to be drawn at that time.
    pub fn want(&mut self, at: Instant) {
        self.wanted = Some(self.wanted.map_or(at, |wanted| wanted.min(at)));
    }

    /// When to draw, `None` for as soon as there is news; and whether that is now.
    pub fn due(&self, now: Instant) -> Due {
        let wanted = if now < self.moves_until { Some(now) } else { self.wanted };
        match wanted.map(|wanted| wanted.max(self.drawn + self.period)) {
            Some(at) if at <= now => Due::Now,
            Some(at) => Due::At(at.min(now + LOOK)),
            None => Due::At(now + LOOK),
        }
    }
}

/// When a picture is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// Draw.
    Now,
    /// Look again then.
    At(Instant),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_draws_at_the_rate_while_something_moves_and_then_sleeps() {
        let start = Instant::now();
        let mut pulse = Pulse::new(Some(50.0), true, start);
        let (mut now, mut pictures) = (start, 0);
        while now < start + Duration::from_secs(2) {
            match pulse.due(now) {
                Due::Now => {
                    pulse.draw(now);
                    pictures += 1;
                    now += Duration::from_millis(1);
                }
                Due::At(at) => {
                    assert!(at > now, "no busy waiting");
                    now = at;
                }
            }
        }
        assert!((18..=22).contains(&pictures), "{pictures} in the aftermath of the start");
        pulse.stir(now);
        assert_eq!(pulse.due(now), Due::Now);
        let later = now + Duration::from_secs(1);
        pulse.want(later + Duration::from_millis(10));
        assert_eq!(pulse.due(later), Due::At(later + Duration::from_millis(10)));
    }
}
