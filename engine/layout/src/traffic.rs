//! Certificates of traffic: what a layout allows, before any run.
//!
//! # The model
//!
//! - All robots are of one [`RobotType`]. They stand at nodes, one at each, with any heading that
//!   an edge has there.
//! - A robot moves along one leg at a time, from its start to its end; reverse gear is allowed
//!   where the edge allows it. One robot moves at a time.
//! - Two robots can't stand at nodes where they touch with some headings. A standing robot *blocks*
//!   a leg if a robot somewhere on the leg's edge touches it, if none can stand at the leg's end,
//!   or if a robot touches it that turns on the spot at the leg's start, where a turn may be
//!   necessary.
//! - Robots enlarged by 3 mm touch if their swept boxes do
//!   ([`sweep`](regatta_base::sweep)): what is said to be free is free.
//!
//! Only the main part has sections, and legs under a [crawl](regatta_base::graph::CRAWL) are no
//! ways. Zones aren't in the model: they may allow fewer robots, so that numbers are bounds then,
//! and rings that a zone never lets close are told as such.
//! Robots on different levels of a building don't touch. Robots that stop between nodes, or
//! move at the same time, can do more than the model, and a fleet manager may do less. Where a
//! number of the model would take too long to compute, it is a bound, and says so
//! ([`Certainty`]).
//!
//! ```
//! use regatta_layout::traffic::{Certificate, RobotType};
//! use regatta_layout::{ReadOptions, parse};
//!
//! let text = "id,x,y\nA,0,0\nB,10,0\nC,20,0\n\nfrom,to,speed\nA,B,1\nB,A,1\nB,C,1\nC,B,1\n";
//! let (graph, _) = parse(text, "road.csv", &ReadOptions::default())?;
//! let certificate = Certificate::new(&graph, &RobotType::default());
//! assert_eq!(certificate.sections[0].metres, 20.0);
//! assert_eq!(certificate.under_way.at_nodes.robots, 2);
//! # Ok::<(), regatta_layout::GraphError>(())
//! ```

mod conflicts;
mod cover;
mod levels;
mod main_part;
mod network;
mod parts;
mod passing;
mod report;
mod rings;
mod robot;
mod room;
mod sections;
mod slow;
mod stations;
#[cfg(test)]
mod tests;
mod tracks;
mod under_way;

use regatta_base::graph::{EdgeIndex, NodeIndex};

use self::conflicts::{Conflicts, Sweeps};
pub use self::main_part::{LeftOut, MainPart};
use self::network::{Network, Search};
pub use self::parts::{Cause, CutOff, Part};
pub use self::report::{Remark, Topic};
pub use self::rings::{MOST_RINGS, Others, Rings};
pub use self::robot::{Outline, RobotType, RobotTypeError, Turning};
pub use self::room::{Certainty, Count};
pub use self::sections::{Exchange, Section, SectionKind, Shape};
pub use self::slow::{SlowLeg, WALK};
pub use self::stations::{BlockingStation, Effect, StationNames};
use self::tracks::Tracks;
pub use self::under_way::MostUnderWay;
use crate::model::route_graph::RouteGraph;
use crate::model::zones::{Zone, ZoneRule};

/// A node where a robot is in the way of robots on roads that don't meet there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InTheWay {
    /// The node.
    pub node: NodeIndex,
    /// The edges on which robots touch one that stands there, in ascending order.
    pub edges: Vec<EdgeIndex>,
    /// The further edges on which robots touch one that turns on the spot there, in ascending
    /// order.
    pub swept: Vec<EdgeIndex>,
}

/// The certificate of a layout: the traffic that it allows robots of a type.
#[derive(Clone, Debug)]
pub struct Certificate {
    /// The robots.
    pub robot: RobotType,
    /// The single tracks, on which two robots can't pass each other.
    pub sections: Vec<Section>,
    /// The stations at which a standing robot blocks a through road.
    pub stations: Vec<BlockingStation>,
    /// The rings of roads on which robots may all wait for the next one.
    pub rings: Rings,
    /// The parts that can't be reached or left.
    pub parts: Vec<Part>,
    /// The nodes at which a robot that stands or turns is in the way on other roads.
    pub in_the_way: Vec<InTheWay>,
    /// The legs that are slower than a walk.
    pub slow: Vec<SlowLeg>,
    /// The largest number of robots that can be under way.
    pub under_way: MostUnderWay,
    /// The nodes that legs lead to, and no way leaves.
    pub sinks: Vec<NodeIndex>,
    /// The zones that may keep robots out. Of the numbers here, only that of [safe
    /// robots](Self::safe_robots) and [rings of two](Rings::pairs) count them.
    pub zones: Vec<Zone>,
    station_names: StationNames,
}

impl Certificate {
    /// Examines a layout.
    pub fn new(graph: &RouteGraph, robot: &RobotType) -> Self {
        let network = Network::new(graph);
        let sweeps = Sweeps::new(graph);
        let conflicts = Conflicts::new(&network, &sweeps, robot);
        let tracks = Tracks::new(&network, &sweeps, robot);
        let names = stations::station_names(graph);
        Self {
            robot: *robot,
            sections: sections::sections(&network, &conflicts, &tracks, robot),
            stations: stations::blocking_stations(&network, &conflicts, &names),
            rings: rings::rings(&network, &conflicts),
            parts: parts::parts(&network, &names),
            in_the_way: in_the_way(&network, &conflicts),
            slow: slow::slow_legs(graph),
            under_way: under_way::most_under_way(&network, &conflicts, robot),
            sinks: sinks(&network),
            zones: graph.zones().iter().filter(|zone| zone.is_limit()).cloned().collect(),
            station_names: names,
        }
    }

    /// The largest number of robots of which it is proved that they never all stand still:
    /// wherever they stand at nodes, and whichever legs they want to drive next, one of them can
    /// drive. `None` if that is proved for any number. Zones count: no more robots are safe than
    /// any zone lets in at once.
    pub fn safe_robots(&self) -> Option<u32> {
        self.safe_on_roads().into_iter().chain(self.safe_in_zones()).min()
    }

    /// As [`safe_robots`](Self::safe_robots), without zones.
    fn safe_on_roads(&self) -> Option<u32> {
        let rings = &self.rings;
        let fewest = if rings.kept_apart > 0 { Some(2) } else { rings.fewest() };
        match (self.sinks.is_empty(), fewest, rings.certainty) {
            (false, _, _) => Some(0),
            (true, None, Certainty::Exact) => None,
            (true, Some(2), _) => Some(1),
            (true, Some(robots), Certainty::Exact) => Some(robots as u32 - 1),
            // All pairs are known: there is none.
            (true, _, Certainty::Bound) => Some(2),
        }
    }

    /// The largest number of robots that no zone keeps out; `None` without zones.
    fn safe_in_zones(&self) -> Option<u32> {
        self.zones.iter().map(|zone| safe_in(zone.rule)).min()
    }
}

/// Returns the largest number of robots of a type that can be under way, without the rest of a
/// certificate.
pub fn most_under_way(graph: &RouteGraph, robot: &RobotType) -> MostUnderWay {
    let network = Network::new(graph);
    let sweeps = Sweeps::new(graph);
    let conflicts = Conflicts::new(&network, &sweeps, robot);
    under_way::most_under_way(&network, &conflicts, robot)
}

/// The largest number of robots of which a zone never keeps one out.
fn safe_in(rule: ZoneRule) -> u32 {
    match rule {
        ZoneRule::Capacity(robots) => robots.get(),
        ZoneRule::SameDirection => 1,
    }
}

fn sinks(network: &Network<'_>) -> Vec<NodeIndex> {
    let nodes = (0..network.nodes()).filter(|&node| {
        network.steps(node, Search::Forwards).next().is_none() && !network.arrivals(node).is_empty()
    });
    nodes.map(NodeIndex).collect()
}

fn in_the_way(network: &Network<'_>, conflicts: &Conflicts) -> Vec<InTheWay> {
    let mut found = Vec::new();
    for node in (0..network.nodes()).map(NodeIndex) {
        let [edges, swept] =
            [conflicts.touched(node.0), conflicts.swept(node.0)].map(|edges| -> Vec<EdgeIndex> {
                let edges = edges.iter().copied().map(EdgeIndex);
                edges.filter(|edge| !is_ride_past(network.graph, *edge, node)).collect()
            });
        if !(edges.is_empty() && swept.is_empty()) {
            found.push(InTheWay { node, edges, swept });
        }
    }
    found
}

/// Whether an edge is a ride of the lift in whose cabin robots are at a node: the cabin isn't at
/// both.
fn is_ride_past(graph: &RouteGraph, edge: EdgeIndex, node: NodeIndex) -> bool {
    graph.lifts().iter().any(|lift| {
        lift.rides.contains(&edge) && lift.levels.iter().any(|level| level.nodes.contains(&node))
    })
}
