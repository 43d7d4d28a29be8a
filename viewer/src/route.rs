//! Routes of selected robots: asked for a few times a second, and what is drawn and told of them.

use std::time::{Duration, Instant};

use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use regatta_plugin::frame::RobotState;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::world::EdgeRecord;
use regatta_plugin::{Frame, OpenError, Participant, RouteClient, RouteError};

/// Robots whose routes are asked for.
pub const MOST_ROBOTS: usize = 8;
/// Between two times of asking.
const ASK_EVERY: Duration = Duration::from_millis(250);
/// Legs among which the one that a robot is on by now is looked for: it drives no more of them between two answers.
const NEXT_LEGS: usize = 8;
/// Chords by which the length of a curve is measured.
const CHORDS: u32 = 32;

/// A part of an edge, as it is drawn: an instance of routes.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Stretch {
    /// Index of the edge in the world.
    pub edge: u32,
    /// Which part of its curve, 0 at its origin and 1 at its destination: from and to.
    pub part: [f32; 2],
    /// 1 if it may be driven now, 0 if it is only planned.
    pub released: u32,
}

/// What a robot has still to drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Remaining {
    /// Edges that it may drive now, the one that it is on among them.
    pub released: Way,
    /// Edges that are only planned.
    pub planned: Way,
}

/// A number of edges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Way {
    /// How many.
    pub edges: u32,
    /// How long they are, in metres, as far as they are known: of a long route only the first legs are.
    pub metres: f32,
    /// Whether all of them are known.
    pub partly: bool,
}

/// What is left of a route for a robot where it is in a frame: the parts of edges to be drawn, and how much it is.
/// Nothing if frame and route are of different runs.
pub fn ahead(route: &RouteResponse, frame: &Frame<'_>, edges: &[EdgeRecord]) -> (Vec<Stretch>, Remaining) {
    let row = route.robot as usize;
    let state = frame.state_of(row);
    let mut remaining = Remaining::default();
    if route.run_id != frame.run_id() || matches!(state, RobotState::Absent | RobotState::Idle) {
        return (Vec::new(), remaining);
    }
    // The robot has gone on since it was asked.
    let (on, s) = (frame.edge()[row], frame.s()[row]);
    let is_here = |edge: u32| edge == on && state != RobotState::Waiting;
    let driven = match state {
        RobotState::Waiting => (route.released as usize).min(route.legs().len()),
        _ => route.legs().take(NEXT_LEGS).position(|leg| is_here(leg.edge)).unwrap_or(0),
    };
    let mut stretches = Vec::with_capacity(route.legs().len() - driven);
    for (place, leg) in route.legs().enumerate().skip(driven) {
        let Some(edge) = edges.get(leg.edge as usize) else { break };
        let here = place == driven && is_here(leg.edge);
        let ends = if leg.reverse { [1.0, 0.0] } else { [0.0, 1.0] };
        let start = if here { part_at(edge, s) } else { ends[0] };
        let metres = match (here, leg.reverse) {
            (true, false) => (edge.length - s).max(0.0),
            (true, true) => s.max(0.0),
            (false, _) => edge.length,
        };
        let way = if leg.released { &mut remaining.released } else { &mut remaining.planned };
        (way.edges, way.metres) = (way.edges + 1, way.metres + metres);
        stretches.push(Stretch { edge: leg.edge, part: [start, ends[1]], released: leg.released.into() });
    }
    let released = route.released.saturating_sub(driven as u32);
    let planned = route.legs.saturating_sub(route.released.max(driven as u32));
    for (way, edges) in [(&mut remaining.released, released), (&mut remaining.planned, planned)] {
        (way.partly, way.edges) = (way.edges < edges, edges);
    }
    (stretches, remaining)
}

/// The parameter of an edge's curve some metres from its origin.
fn part_at(edge: &EdgeRecord, s: f32) -> f32 {
    let [a, b, c, d] = edge.control_points.map(Vec2::from);
    let point = |at: f32| {
        let ends = [a.lerp(b, at), b.lerp(c, at), c.lerp(d, at)];
        ends[0].lerp(ends[1], at).lerp(ends[1].lerp(ends[2], at), at)
    };
    let ends = |chord: u32| [chord, chord + 1].map(|number| number as f32 / CHORDS as f32);
    let lengths = (0..CHORDS).map(|chord| {
        let [from, to] = ends(chord);
        point(from).distance(point(to))
    });
    // Chords are a little shorter than the curve.
    let whole: f32 = lengths.clone().sum();
    let mut rest = s / edge.length.max(1e-6) * whole;
    for (chord, length) in (0..CHORDS).zip(lengths) {
        if rest < length {
            let [from, to] = ends(chord);
            return from + (to - from) * (rest / length).max(0.0);
        }
        rest -= length;
    }
    1.0
}

/// Asks for the routes of some robots again and again.
#[derive(Debug, Default)]
pub struct RouteWatch {
    robots: Vec<u32>,
    /// Open only while routes are wanted.
    client: Option<RouteClient>,
    due: Option<Instant>,
}

impl RouteWatch {
    /// Of these robots from now on, the first [`MOST_ROBOTS`] of them.
    pub fn watch(&mut self, mut robots: Vec<u32>, now: Instant) {
        robots.truncate(MOST_ROBOTS);
        self.due = (!robots.is_empty()).then_some(now);
        self.robots = robots;
    }

    /// When to ask next; `None` if nothing is to be asked.
    pub fn due(&self) -> Option<Instant> {
        self.due
    }

    /// Asks if it is time to, and waits for the answers, `patience` at most. `None` if there is nothing new; without
    /// routes if nobody knows any.
    ///
    /// # Errors
    /// As [`RouteClient::open_on`]. Nothing is asked from then on.
    pub fn ask(
        &mut self,
        participant: &Participant,
        patience: Duration,
    ) -> Result<Option<Vec<RouteResponse>>, OpenError> {
        if self.robots.is_empty() {
            self.client = None;
        }
        if self.due.is_none_or(|due| Instant::now() < due) {
            return Ok(None);
        }
        self.due = None;
        let client = match &mut self.client {
            Some(client) => client,
            none => none.insert(RouteClient::open_on(&participant)?),
        };
        let answers = client.routes(&self.robots, patience);
        self.due = Some(Instant::now() + ASK_EVERY);
        Ok(match answers {
            Ok(routes) => Some(routes),
            Err(RouteError::Timeout { .. }) => None,
            Err(error) => {
                tracing::debug!(%error, "asking for routes");
                Some(Vec::new())
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};

    use super::*;

    /// Three edges, one after the other: ten metres, a bend of ten, ten.
    fn edges() -> [EdgeRecord; 3] {
        let edge = |control_points| EdgeRecord { length: 10.0, control_points, ..EdgeRecord::default() };
        [
            edge([[0.0, 0.0], [1.0, 0.0], [9.0, 0.0], [10.0, 0.0]]),
            edge([[10.0, 0.0], [14.0, 0.0], [16.37, 2.37], [16.37, 6.37]]),
            edge([[16.37, 6.37], [16.37, 9.0], [16.37, 13.0], [16.37, 16.37]]),
        ]
    }

    fn remaining(edge: u32, s: f32, state: RobotState, route: &RouteResponse) -> (Vec<Stretch>, Remaining) {
        let header =
            FrameHeader { run_id: 5, robots: 1, stride_lines: stride_lines(1) as u32, ..FrameHeader::default() };
        let mut lines = vec![Line::default(); frame_lines(1)];
        let columns = ColumnsMut::split(&mut lines, 1);
        (columns.edge[0], columns.s[0], columns.state[0]) = (edge, s, state as u8);
        ahead(route, &Frame::new(&header, &lines).expect("a frame"), &edges())
    }

    fn route(released: usize, legs: &[(u32, bool)]) -> RouteResponse {
        RouteResponse::unknown(5, 1, 0).with_legs(released, legs.len(), legs.iter().copied())
    }

    #[test]
    fn a_route_begins_where_the_robot_is_by_now() {
        let route = route(2, &[(0, false), (1, false), (2, false)]);
        let (stretches, left) = remaining(0, 2.5, RobotState::Driving, &route);
        assert_eq!(left.released, Way { edges: 2, metres: 17.5, partly: false });
        assert_eq!(left.planned, Way { edges: 1, metres: 10.0, partly: false });
        assert_eq!((stretches.len(), stretches[1].part, stretches[1].released), (3, [0.0, 1.0], 1));
        // Slow at its ends, where the handles are short.
        assert!((0.28..0.40).contains(&stretches[0].part[0]), "{stretches:?}");

        let (stretches, left) = remaining(1, 5.0, RobotState::Driving, &route);
        assert_eq!((stretches.len(), left.released.edges, left.released.metres), (2, 1, 5.0));
        assert!((stretches[0].part[0] - 0.5).abs() < 1e-3, "an even bend");
        let (stretches, left) = remaining(1, 10.0, RobotState::Waiting, &route);
        assert_eq!((stretches.len(), left.released.edges, left.planned.edges), (1, 0, 1));
        assert_eq!(remaining(2, 10.0, RobotState::Idle, &route).0, [], "it has arrived");
    }

    #[test]
    fn in_reverse_gear_the_rest_is_towards_the_origin() {
        let (stretches, left) = remaining(2, 4.0, RobotState::Driving, &route(2, &[(2, true), (1, true)]));
        assert_eq!((left.released.edges, left.released.metres), (2, 14.0));
        assert_eq!((stretches[0].part[1], stretches[1].part), (0.0, [1.0, 0.0]));
    }

    #[test]
    fn what_is_not_listed_is_counted_and_other_runs_and_worlds_do_no_harm() {
        let legs = [(0, false)].repeat(300);
        let (stretches, left) = remaining(1, 0.0, RobotState::Driving, &route(290, &legs));
        assert_eq!(stretches.len(), 256);
        assert_eq!(left.released, Way { edges: 290, metres: 2560.0, partly: true });
        assert_eq!(left.planned, Way { edges: 10, metres: 0.0, partly: true });
        let (stretches, left) = remaining(0, 0.0, RobotState::Driving, &route(2, &[(0, false), (77, false)]));
        assert_eq!((stretches.len(), left.released.edges, left.released.partly), (1, 2, true));
        let other = RouteResponse { run_id: 6, ..route(1, &[(0, false)]) };
        assert_eq!(remaining(0, 0.0, RobotState::Driving, &other).0, []);
        let unknown = RouteResponse { robot: 9, ..route(1, &[(0, false)]) };
        assert_eq!(remaining(0, 0.0, RobotState::Driving, &unknown).0, []);
    }
}
