//! Frame pacing: pictures are drawn at the screen's refresh rate while something moves, and
//! otherwise only for news.

use std::time::{Duration, Instant};

/// The time between two checks for news while nothing moves.
const CHECK_INTERVAL: Duration = Duration::from_millis(30);
/// The time for which drawing continues after the last news, because columns arrive shortly after
/// their frame.
const DRAW_ON: Duration = Duration::from_millis(400);
/// The refresh rate of screens that don't report it, in hertz.
const DEFAULT_RATE: f64 = 60.0;

/// The times of the last and the next picture.
#[derive(Debug)]
pub struct FramePacing {
    drawn_at: Instant,
    /// Until then, every picture of the screen is drawn.
    moves_until: Instant,
    /// The time of the next scheduled picture.
    scheduled: Option<Instant>,
    /// The shortest time between two pictures.
    period: Duration,
}

impl FramePacing {
    /// Creates the pacing for a screen with this refresh rate in hertz. `software` means that the
    /// processor draws.
    pub fn new(rate: Option<f64>, software: bool, now: Instant) -> Self {
        let period = 1.0 / rate.filter(|rate| *rate >= 1.0).unwrap_or(DEFAULT_RATE);
        // A screen limits the rate by itself; a shorter period only prevents needless pictures.
        let period = if software { period } else { period * 0.75 };
        Self {
            drawn_at: now,
            moves_until: now + DRAW_ON,
            scheduled: None,
            period: Duration::from_secs_f64(period),
        }
    }

    /// Records that a picture is drawn now.
    pub fn record_draw(&mut self, now: Instant) {
        // A multiple of the period rather than the current time, which is always a bit late.
        self.drawn_at =
            (self.drawn_at + self.period).max(now.checked_sub(self.period).unwrap_or(now));
        self.scheduled = None;
    }

    /// Draws at the refresh rate for a while, because there is news or something moves.
    pub fn keep_drawing(&mut self, now: Instant) {
        self.moves_until = now + DRAW_ON;
    }

    /// Schedules a picture at that time, or earlier if one is scheduled earlier.
    pub fn schedule(&mut self, at: Instant) {
        self.scheduled = Some(self.scheduled.map_or(at, |scheduled| scheduled.min(at)));
    }

    /// Returns whether to draw now, or when to check again.
    pub fn due(&self, now: Instant) -> Due {
        let next = if now < self.moves_until { Some(now) } else { self.scheduled };
        match next.map(|next| next.max(self.drawn_at + self.period)) {
            Some(at) if at <= now => Due::Now,
            Some(at) => Due::At(at.min(now + CHECK_INTERVAL)),
            None => Due::At(now + CHECK_INTERVAL),
        }
    }
}

/// The time at which a picture is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// Draw now.
    Now,
    /// Check again then.
    At(Instant),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_drawn_at_the_refresh_rate_while_something_moves() {
        let start = Instant::now();
        let mut frame_pacing = FramePacing::new(Some(50.0), true, start);
        let (mut now, mut pictures) = (start, 0);
        while now < start + Duration::from_secs(2) {
            match frame_pacing.due(now) {
                Due::Now => {
                    frame_pacing.record_draw(now);
                    pictures += 1;
                    now += Duration::from_millis(1);
                }
                Due::At(at) => {
                    assert!(at > now, "no busy waiting");
                    now = at;
                }
            }
        }
        assert!((18..=22).contains(&pictures), "{pictures} pictures after the start");
        frame_pacing.keep_drawing(now);
        assert_eq!(frame_pacing.due(now), Due::Now);
        let later = now + Duration::from_secs(1);
        frame_pacing.schedule(later + Duration::from_millis(10));
        assert_eq!(frame_pacing.due(later), Due::At(later + Duration::from_millis(10)));
    }
}
