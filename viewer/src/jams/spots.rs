//! Hot spots: places where robots touch, or stand and can't drive on, ranked by the time that they
//! have cost.

use std::fmt::Write as _;

use glam::Vec2;
use regatta_plugin::history::HotSpot;
pub use regatta_plugin::history::Trend;

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
            "{rank},{:.2},{:.2},{lost:.1},{contact:.1},{standing:.1},{first:.1},{last:.1},{trend},{}",
            spot.place.x,
            spot.place.y,
            edges.join(" ")
        );
    }
    text
}

#[cfg(test)]
mod tests {
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
}
