//! Parses received datagrams and updates the robots.

use std::time::Duration;

use super::robots::Robots;
use crate::line::{AngleUnit, LineFault, PoseLine, Separator, lines};
use crate::tally::Faults;

/// The parser of received datagrams. Counts ignored lines. Its memory is bounded by the allowed
/// number of robots.
#[derive(Debug)]
pub struct Intake {
    unit: AngleUnit,
    offset: [f64; 2],
    max_bytes: usize,
    /// The newest pose of each robot.
    pub robots: Robots,
    /// The numbers of ignored lines and datagrams.
    pub faults: Faults,
    /// The number of accepted lines.
    pub lines: u64,
    /// The number of datagrams.
    pub datagrams: u64,
    /// The number of bytes in all datagrams.
    pub bytes: u64,
}

impl Intake {
    /// Creates a parser of datagrams of at most `max_bytes` bytes with angles in `unit`, for at
    /// most `max_robots` robots. `offset` is added to all positions, in metres.
    pub fn new(unit: AngleUnit, offset: [f64; 2], max_bytes: usize, max_robots: u32) -> Self {
        let robots = Robots::new(max_robots);
        Self {
            unit,
            offset,
            max_bytes,
            robots,
            faults: Faults::default(),
            lines: 0,
            datagrams: 0,
            bytes: 0,
        }
    }

    /// Parses a datagram that was received at `now`, the time since any fixed instant. Calls `each`
    /// with each accepted line, with the offset added and theta as received.
    pub fn take(&mut self, datagram: &[u8], now: Duration, mut each: impl FnMut(&PoseLine)) {
        self.datagrams += 1;
        self.bytes += datagram.len() as u64;
        if datagram.len() > self.max_bytes {
            self.faults.oversized += 1;
            return;
        }
        for line in lines(datagram) {
            match self.parse_line(line, now) {
                Ok(line) => {
                    self.lines += 1;
                    each(&line);
                }
                Err(fault) => self.faults.count(fault),
            }
        }
    }

    fn parse_line(&mut self, line: &[u8], now: Duration) -> Result<PoseLine, LineFault> {
        let line = PoseLine::parse(line, Separator::Comma)?;
        let [x, y] = [(line.x, self.offset[0]), (line.y, self.offset[1])]
            .map(|(x, dx)| (f64::from(x) + dx) as f32);
        if !x.is_finite() || !y.is_finite() {
            return Err(LineFault::NotFinite);
        }
        let line = PoseLine { x, y, ..line };
        self.robots.update(&PoseLine { theta: self.unit.to_radians(line.theta), ..line }, now)?;
        Ok(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn intake(offset: [f64; 2]) -> Intake {
        Intake::new(AngleUnit::Degrees, offset, 100, 10)
    }

    #[test]
    fn valid_lines_between_invalid_ones_are_accepted() {
        let mut intake = intake([10.0, -1.0]);
        let mut accepted = Vec::new();
        let datagram = b"3,1,2,90\n-1,0,0,0\nnonsense\n10,1,2,3\r\n4,nan,2,3\n5,-1.5,2,-180";
        intake.take(datagram, Duration::ZERO, |line| accepted.push(*line));
        let robots = [(3, 11.0, 1.0, 90.0), (5, 8.5, 1.0, -180.0)];
        assert_eq!(accepted, robots.map(|(id, x, y, theta)| PoseLine { id, x, y, theta }));
        let faults =
            Faults { malformed: 1, negative_id: 1, id_too_large: 1, not_finite: 1, oversized: 0 };
        assert_eq!((intake.faults, intake.lines, intake.robots.len()), (faults, 2, 6));
    }

    #[test]
    fn oversized_datagrams_are_ignored() {
        let mut intake = intake([0.0; 2]);
        intake
            .take(&b"1,2,3,4\n".repeat(13), Duration::ZERO, |_| panic!("the line is not accepted"));
        assert_eq!((intake.faults.oversized, intake.lines), (1, 0));
        intake.take(&b"1,2,3,4\n".repeat(12), Duration::ZERO, |_| ());
        assert_eq!((intake.lines, intake.datagrams), (12, 2));
    }

    #[test]
    fn a_position_that_overflows_by_the_offset_is_not_finite() {
        let mut intake = intake([f64::from(f32::MAX), 0.0]);
        intake.take(format!("1,{},0,0", f32::MAX).as_bytes(), Duration::ZERO, |_| {
            panic!("the line is not accepted")
        });
        assert_eq!(intake.faults.not_finite, 1);
    }
}
