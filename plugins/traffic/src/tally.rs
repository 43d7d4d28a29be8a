//! The tally of a frame: the number of robots on each edge, by state.

use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};

use crate::routes::EdgeRoutes;

/// The counts of an edge: in a frame, or added up over robots and seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))] // An edge lies within one cache line.
pub struct Counts {
    /// Robots on the edge; robot seconds.
    pub robots: f32,
    /// Robots that have entered it.
    pub entered: f32,
    /// Their speeds, in metres per second; metres driven.
    pub metres: f32,
    /// Robots that wait there to drive on; seconds.
    pub waiting: f32,
    /// Robots there that touch others; seconds.
    pub touching: f32,
    /// Robots whose released route leads over it; robot seconds.
    pub released: f32,
    /// Other robots whose planned route leads over it; robot seconds.
    pub planned: f32,
}

impl Counts {
    /// Adds the counts of a frame that lasted for some seconds; with 1, counts that are added up.
    pub(crate) fn add(&mut self, frame: &Self, secs: f32) {
        self.robots += frame.robots * secs;
        self.entered += frame.entered;
        self.metres += frame.metres * secs;
        self.waiting += frame.waiting * secs;
        self.touching += frame.touching * secs;
        self.released += frame.released * secs;
        self.planned += frame.planned * secs;
    }
}

/// Counts robots frame by frame.
#[derive(Debug, Default)]
pub struct Tally {
    /// By edge.
    counts: Vec<Counts>,
    /// By robot: the edge it was on in the frame before; [`NO_EDGE`] if it is unknown.
    edges: Vec<u32>,
}

impl Tally {
    /// Begins a run on a number of edges.
    pub fn begin(&mut self, edges: usize) {
        self.counts.clear();
        self.counts.resize(edges, Counts::default());
        self.edges.clear();
    }

    /// Forgets where robots were: none enters an edge in the next frame.
    pub fn forget_places(&mut self) {
        self.edges.fill(NO_EDGE);
    }

    /// Adds the robots whose routes lead over each edge to the counts of a frame.
    pub fn count_routes(&mut self, routes: &[EdgeRoutes]) -> &[Counts] {
        for (counts, routes) in self.counts.iter_mut().zip(routes) {
            (counts.released, counts.planned) = (routes.released as f32, routes.planned as f32);
        }
        &self.counts
    }

    /// Counts the robots of a frame. `contacts` has a [`ContactLevel`] for each robot, or is empty
    /// without a collision checker. Robots on edges that the world doesn't have are left out.
    /// Returns the counts by edge.
    pub fn count(&mut self, columns: &Columns<'_>, contacts: &[f32]) -> &[Counts] {
        self.counts.fill(Counts::default());
        self.edges.resize(columns.edge.len(), NO_EDGE);
        let rows = columns.edge.iter().zip(columns.speed).zip(columns.state);
        for (((&edge, &speed), &state), before) in rows.zip(&mut self.edges) {
            // An absent robot isn't on an edge.
            let edge = if state == RobotState::Absent as u8 { NO_EDGE } else { edge };
            let entered = edge != *before && *before != NO_EDGE;
            *before = edge;
            if let Some(counts) = self.counts.get_mut(edge as usize) {
                counts.robots += 1.0;
                counts.entered += f32::from(u8::from(entered));
                counts.metres += speed.abs();
                counts.waiting += f32::from(u8::from(state == RobotState::Waiting as u8));
            }
        }
        for (&edge, &level) in self.edges.iter().zip(contacts) {
            if level == ContactLevel::Touching as u32 as f32
                && let Some(counts) = self.counts.get_mut(edge as usize)
            {
                counts.touching += 1.0;
            }
        }
        &self.counts
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, Line, frame_lines};

    use super::*;

    /// Robots by edge, speed and state, as columns of a frame.
    fn count(
        tally: &mut Tally,
        robots: &[(u32, f32, RobotState)],
        contacts: &[f32],
    ) -> Vec<Counts> {
        let mut lines = vec![Line::default(); frame_lines(robots.len())];
        let columns = ColumnsMut::split(&mut lines, robots.len());
        for (row, (edge, speed, state)) in robots.iter().enumerate() {
            (columns.edge[row], columns.speed[row], columns.state[row]) =
                (*edge, *speed, *state as u8);
        }
        tally.count(&Columns::split(&lines, robots.len()).expect("lines"), contacts).to_vec()
    }

    #[test]
    fn robots_count_where_they_are() {
        let mut tally = Tally::default();
        tally.begin(3);
        let (driving, waiting, absent) =
            (RobotState::Driving, RobotState::Waiting, RobotState::Absent);
        let robots = [
            (0, 2.0, driving),
            (0, -1.0, driving),
            (1, 0.0, waiting),
            (2, 1.0, absent),
            (NO_EDGE, 0.0, driving),
        ];
        let counts = count(&mut tally, &robots, &[0.0, 2.0, 1.0, 2.0, 2.0]);
        assert_eq!(
            counts[0],
            Counts { robots: 2.0, metres: 3.0, touching: 1.0, ..Counts::default() }
        );
        assert_eq!(
            counts[1],
            Counts { robots: 1.0, waiting: 1.0, ..Counts::default() },
            "a possible contact is none"
        );
        assert_eq!(counts[2], Counts::default());
        let counts =
            count(&mut tally, &[(1, 2.0, driving), (0, 1.0, driving), (9, 0.0, driving)], &[]);
        assert_eq!((counts[0].entered, counts[1].entered), (0.0, 1.0), "robot 0 has driven on");
        let counts = count(
            &mut tally,
            &[(1, 2.0, driving), (NO_EDGE, 1.0, driving), (1, 0.0, driving)],
            &[],
        );
        assert_eq!(
            counts[1],
            Counts { robots: 2.0, metres: 2.0, entered: 1.0, ..Counts::default() }
        );
    }
}
