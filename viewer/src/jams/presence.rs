//! Who is on an edge or over a node. That takes a pass over all robots, so it is done on a thread
//! that no picture waits for.

use glam::Vec2;
use regatta_plugin::Frame;
use regatta_plugin::frame::RobotState;

/// The most robots that are listed.
pub const LISTED: usize = 12;

/// The robots at a place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Presence {
    /// How many are there.
    pub robots: u32,
    /// How many of them wait.
    pub waiting: u32,
    /// The ids of the first ones.
    pub listed: Vec<u32>,
}

impl Presence {
    /// The robots on an edge, by its index in the world.
    pub fn on_edge(frame: &Frame<'_>, edge: u32) -> Self {
        let rows = frame.edge().iter().enumerate().filter(|(_, on)| **on == edge);
        Self::of(frame, rows.map(|(row, _)| row))
    }

    /// The robots within a radius around a place, in metres.
    pub fn around(frame: &Frame<'_>, place: Vec2, radius: f32) -> Self {
        let is_near = |x: f32, y: f32| Vec2::new(x, y).distance_squared(place) <= radius * radius;
        let rows =
            frame.x().iter().zip(frame.y()).enumerate().filter(|(_, (x, y))| is_near(**x, **y));
        Self::of(frame, rows.map(|(row, _)| row))
    }

    fn of(frame: &Frame<'_>, rows: impl Iterator<Item = usize>) -> Self {
        let mut all = Self::default();
        for row in rows.filter(|row| frame.state_of(*row) != RobotState::Absent) {
            all.robots += 1;
            all.waiting += u32::from(frame.state_of(row) == RobotState::Waiting);
            if all.listed.len() < LISTED {
                all.listed.push(row as u32);
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};

    use super::*;

    #[test]
    fn robots_at_a_place_are_counted_and_absent_ones_are_not() {
        let robots = 40;
        let header = FrameHeader {
            robots: robots as u32,
            stride_lines: stride_lines(robots) as u32,
            ..FrameHeader::default()
        };
        let mut lines = vec![Line::default(); frame_lines(robots)];
        let columns = ColumnsMut::split(&mut lines, robots);
        for i in 0..robots {
            (columns.edge[i], columns.x[i]) = ((i % 2) as u32, i as f32);
            let waits = if i % 4 == 1 { RobotState::Waiting } else { RobotState::Driving };
            columns.state[i] = if i == 1 { RobotState::Absent as u8 } else { waits as u8 };
        }
        let frame = Frame::new(&header, &lines).expect("a frame");
        let (even, odd) = (Presence::on_edge(&frame, 0), Presence::on_edge(&frame, 1));
        assert_eq!((even.robots, even.waiting, odd.robots, odd.waiting), (20, 0, 19, 9));
        assert_eq!((odd.listed.len(), &odd.listed[..3]), (LISTED, &[3, 5, 7][..]));
        let around = Presence::around(&frame, Vec2::new(2.0, 0.0), 1.0);
        assert_eq!(
            around,
            Presence { robots: 2, waiting: 0, listed: vec![2, 3] },
            "robot 1 is absent"
        );
    }
}
