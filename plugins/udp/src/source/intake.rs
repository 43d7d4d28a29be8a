//! From datagrams to robots.

use std::time::Duration;

use super::robots::Robots;
use crate::line::{AngleUnit, LineFault, PoseLine, Separator, lines};
use crate::tally::Faults;

/// Takes datagrams apart and counts what can't be used. Its memory is bounded by the number of robots allowed.
#[derive(Debug)]
pub struct Intake {
    unit: AngleUnit,
    offset: [f64; 2],
    most_bytes: usize,
    /// What was heard of the robots.
    pub robots: Robots,
    /// What was not used.
    pub faults: Faults,
    /// Lines that were used.
    pub lines: u64,
    /// All datagrams.
    pub datagrams: u64,
    /// Bytes in them.
    pub bytes: u64,
}

impl Intake {
    /// Takes datagrams of `most_bytes` at most, with angles in `unit`, for `most_robots` robots; adds `offset` to
    /// their positions, in metres.
    pub fn new(unit: AngleUnit, offset: [f64; 2], most_bytes: usize, most_robots: u32) -> Self {
        let robots = Robots::new(most_robots);
        Self { unit, offset, most_bytes, robots, faults: Faults::default(), lines: 0, datagrams: 0, bytes: 0 }
    }

    /// Takes a datagram that came at `now` (since any one moment), and hands each line that is used to `each`, with
    /// the offset added and theta as it came.
    pub fn take(&mut self, datagram: &[u8], now: Duration, mut each: impl FnMut(&PoseLine)) {
        self.datagrams += 1;
        self.bytes += datagram.len() as u64;
        if datagram.len() > self.most_bytes {
            self.faults.oversized += 1;
            return;
        }
        for line in lines(datagram) {
            match self.take_line(line, now) {
                Ok(line) => {
                    self.lines += 1;
                    each(&line);
                }
                Err(fault) => self.faults.count(fault),
            }
        }
    }

    fn take_line(&mut self, line: &[u8], now: Duration) -> Result<PoseLine, LineFault> {
        let line = PoseLine::parse(line, Separator::Comma)?;
        let [x, y] = [(line.x, self.offset[0]), (line.y, self.offset[1])].map(|(x, dx)| (f64::from(x) + dx) as f32);
        if !x.is_finite() || !y.is_finite() {
            return Err(LineFault::NotFinite);
        }
        let drawn = PoseLine { x, y, ..line };
        self.robots.hear(&PoseLine { theta: self.unit.to_radians(line.theta), ..drawn }, now)?;
        Ok(drawn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn intake(offset: [f64; 2]) -> Intake {
        Intake::new(AngleUnit::Degrees, offset, 100, 10)
    }

    #[test]
    fn good_lines_count_whatever_stands_between_them() {
        let mut intake = intake([10.0, -1.0]);
        let mut used = Vec::new();
        let datagram = b"3,1,2,90\n-1,0,0,0\nnonsense\n10,1,2,3\r\n4,nan,2,3\n5,-1.5,2,-180";
        intake.take(datagram, Duration::ZERO, |line| used.push(*line));
        let robots = [(3, 11.0, 1.0, 90.0), (5, 8.5, 1.0, -180.0)];
        assert_eq!(used, robots.map(|(id, x, y, theta)| PoseLine { id, x, y, theta }));
        let faults = Faults { malformed: 1, negative_id: 1, id_too_large: 1, not_finite: 1, oversized: 0 };
        assert_eq!((intake.faults, intake.lines, intake.robots.len()), (faults, 2, 6));
    }

    #[test]
    fn oversized_datagrams_are_left_alone() {
        let mut intake = intake([0.0; 2]);
        intake.take(&b"1,2,3,4\n".repeat(13), Duration::ZERO, |_| panic!("not used"));
        assert_eq!((intake.faults.oversized, intake.lines), (1, 0));
        intake.take(&b"1,2,3,4\n".repeat(12), Duration::ZERO, |_| ());
        assert_eq!((intake.lines, intake.datagrams), (12, 2));
    }

    #[test]
    fn an_offset_over_the_edge_of_the_numbers_is_not_finite() {
        let mut intake = intake([f64::from(f32::MAX), 0.0]);
        intake.take(format!("1,{},0,0", f32::MAX).as_bytes(), Duration::ZERO, |_| panic!("not used"));
        assert_eq!(intake.faults.not_finite, 1);
    }
}
