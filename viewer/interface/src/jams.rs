//! Facts about jams: the traffic on edges, the robots at a place, and hot spots, where robots
//! touch, or stand and can't drive on, ranked by the time that they have cost.

use std::fmt::Write as _;
use std::sync::Arc;

use glam::Vec2;
use regatta_plugin::Frame;
use regatta_plugin::frame::RobotState;
pub use regatta_plugin::history::Trend;
use regatta_plugin::history::{FleetSample, HotSpot};
use regatta_plugin::traffic::{EdgeTraffic, TRAFFIC_PERIODS};
use regatta_scene::heat::{HeatFacts, HotEdge};

/// The known facts of an edge.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeFacts {
    /// Its index in the world.
    pub edge: u32,
    /// The traffic of each period; `None` without a traffic plugin.
    pub traffic: Option<[EdgeTraffic; TRAFFIC_PERIODS]>,
    /// The length of each period so far, in simulated seconds.
    pub period_secs: [f32; TRAFFIC_PERIODS],
    /// The robots there.
    pub present: Presence,
}

/// The known facts of a node.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NodeFacts {
    /// Its index in the world.
    pub node: u32,
    /// The robots over it.
    pub present: Presence,
}

/// The facts about jams that the interface shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JamFacts {
    /// The scale of the heat map; `None` as long as there is none.
    pub heat: Option<HeatFacts>,
    /// The hottest places of the heat map, the hottest first.
    pub hottest: Vec<HotEdge>,
    /// The watched edges.
    pub edges: Vec<EdgeFacts>,
    /// The watched node.
    pub node: Option<NodeFacts>,
    /// The hot spots, the worst first. Times of these and of the figures are those of the clock
    /// that is shown.
    pub spots: Arc<[Spot]>,
    /// The figures over time, the oldest first.
    pub series: Arc<[FleetSample]>,
    /// The part of the run that both are about.
    pub known: Known,
}

/// The part of a run whose history is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Its first time, in simulated seconds.
    pub from_secs: f64,
    /// Its last time, in simulated seconds.
    pub until_secs: f64,
    /// Whether a plugin keeps it, or a replay knows it of its recording; if not, this window does.
    pub is_published: bool,
}

impl JamFacts {
    /// Returns the facts of an edge, by its index in the world.
    pub fn edge(&self, edge: u32) -> Option<&EdgeFacts> {
        self.edges.iter().find(|facts| facts.edge == edge)
    }
}

/// The maximum number of robots that are listed.
pub const LISTED: usize = 12;

/// The robots at a place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Presence {
    /// The number of robots there.
    pub robots: u32,
    /// The number of them that wait.
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
        let near = (0..frame.len()).filter(|row| {
            let at = Vec2::new(frame.x()[*row], frame.y()[*row]);
            at.distance_squared(place) <= radius * radius
        });
        Self::of(frame, near)
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

/// A place where robots lose time.
#[derive(Clone, Debug, PartialEq)]
pub struct Spot {
    /// The middle of the losses, in metres.
    pub place: Vec2,
    /// The time that robots have touched others there, added up over robots, in seconds.
    pub contact_secs: f64,
    /// The time that other robots have stood there.
    pub standing_secs: f64,
    /// The simulated times of the first and of the last loss, in seconds.
    pub seen: [f64; 2],
    /// The edges with the most losses, by their indices in the world.
    pub edges: Vec<u32>,
    /// Whether it gets worse.
    pub trend: Trend,
}

impl Spot {
    /// All time that was lost, in robot seconds.
    pub fn lost_secs(&self) -> f64 {
        self.contact_secs + self.standing_secs
    }
}

impl From<&HotSpot> for Spot {
    fn from(spot: &HotSpot) -> Self {
        Self {
            place: Vec2::new(spot.x, spot.y),
            contact_secs: spot.contact_secs,
            standing_secs: spot.standing_secs,
            seen: spot.seen,
            edges: spot.edges().collect(),
            trend: spot.trend(),
        }
    }
}

/// Returns the spots as CSV, with the ids of edges by their indices in the world.
pub fn csv(spots: &[Spot], edge_ids: &dyn Fn(u32) -> Option<u32>) -> String {
    let mut text =
        String::from("rank,x_m,y_m,lost_s,contact_s,standing_s,first_s,last_s,trend,edges\n");
    for (rank, spot) in (1..).zip(spots) {
        let edges: Vec<_> =
            spot.edges.iter().filter_map(|edge| edge_ids(*edge)).map(|id| id.to_string()).collect();
        let ([first, last], trend) = (spot.seen, spot.trend.name());
        let (lost, contact, standing) = (spot.lost_secs(), spot.contact_secs, spot.standing_secs);
        // Writing to a string can't fail.
        let _ = writeln!(
            text,
            "{rank},{:.2},{:.2},{lost:.1},{contact:.1},{standing:.1},{first:.1},{last:.1},\
             {trend},{}",
            spot.place.x,
            spot.place.y,
            edges.join(" ")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};

    use super::*;

    #[test]
    fn a_spot_is_a_row_with_the_ids_of_its_edges() {
        let none = regatta_plugin::frame::NO_EDGE;
        let (seen, edges, trend) = ([1.0, 20.0], [2, 3, none, none], Trend::Easing as u32);
        let spot =
            HotSpot { x: 100.5, standing_secs: 40.0, seen, edges, trend, ..HotSpot::default() };
        let csv = csv(&[Spot::from(&spot)], &|edge| Some(100 + edge));
        assert_eq!(csv.lines().nth(1), Some("1,100.50,0.00,40.0,0.0,40.0,1.0,20.0,easing,102 103"));
    }

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
