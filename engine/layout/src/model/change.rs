//! Copies of a route graph with other edges, or with more roads.

use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{EdgeIndex, Ends, NodeIndex};

use super::facilities::{Door, Lift};
use super::path::Path;
use super::route_graph::{Edge, Node, RouteGraph};
use super::zones::Zone;

/// The distance of a cubic's middle from the chord, as a fraction of that of its handles: 2 · 3 · ¼
/// · ½.
const REACH_OF_HANDLES: f64 = 0.75;

/// A change of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EdgeChange {
    /// The edge is left out.
    Close,
    /// Its speeds are multiplied by this factor, above 0.
    Speed(f64),
    /// Its speeds are at least this one, in metres per second, above 0.
    AtLeast(f64),
    /// It leads from its destination to its origin. An edge with a reverse gear keeps it.
    Reverse,
    /// A second edge with the same nodes and speeds is added. Its middle is this distance in metres
    /// to the right of the middle of the first.
    Double(f64),
}

/// The error of changing a graph.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ChangeError {
    /// There is no such edge.
    #[error("edge {0}: the layout has no edge with this id")]
    Unknown(u32),
    /// The edge consists of several curves, which can't be doubled.
    #[error("edge {0}: it has several curves, so it can't be doubled")]
    SeveralCurves(u32),
    /// All edges are closed, and a graph needs one.
    #[error("all edges are closed: leave one open")]
    NothingLeft,
}

impl RouteGraph {
    /// Returns a copy in which some edges are changed, by their ids. Added edges have ids above all
    /// others.
    ///
    /// # Errors
    /// [`ChangeError`] if an edge doesn't exist or can't be doubled, or if none is left.
    ///
    /// ```
    /// use regatta_layout::{EdgeChange, ReadOptions, parse};
    ///
    /// let text = "id,x,y\nA,0,0\nB,10,0\n\nfrom,to,speed\nA,B,1.5\n";
    /// let (graph, _) = parse(text, "road.csv", &ReadOptions::default())?;
    /// let id = graph.edges()[0].id;
    /// let faster = graph.with_changes(&[(id, EdgeChange::Speed(2.0))]).expect("the edge exists");
    /// assert_eq!(faster.edges()[0].speed, 3.0);
    /// # Ok::<(), regatta_layout::GraphError>(())
    /// ```
    pub fn with_changes(&self, changes: &[(u32, EdgeChange)]) -> Result<Self, ChangeError> {
        let mut edges: Vec<Option<Edge>> = self.edges().iter().cloned().map(Some).collect();
        let mut added = Vec::new();
        let mut next_id = self.edges().iter().map(|edge| edge.id).max().unwrap_or(0);
        for &(id, change) in changes {
            let index = self.edge_by_id(id).ok_or(ChangeError::Unknown(id))?;
            let slot = &mut edges[index.0 as usize];
            let Some(edge) = slot else { continue };
            match change {
                EdgeChange::Close => *slot = None,
                EdgeChange::Speed(factor) => {
                    edge.speed *= factor;
                    edge.reverse_speed = edge.reverse_speed.map(|speed| speed * factor);
                }
                EdgeChange::AtLeast(speed) => {
                    edge.speed = edge.speed.max(speed);
                    edge.reverse_speed = edge.reverse_speed.map(|own| own.max(speed));
                }
                EdgeChange::Reverse => {
                    (edge.origin, edge.destination) = (edge.destination, edge.origin);
                    edge.path = edge.path.reversed();
                    let Ends { origin, destination } = edge.rotation;
                    edge.rotation = Ends { origin: destination, destination: origin };
                }
                EdgeChange::Double(metres) => {
                    next_id += 1;
                    let path = offset(&edge.path, metres).ok_or(ChangeError::SeveralCurves(id))?;
                    added.push((index, Edge { id: next_id, path, tags: None, ..edge.clone() }));
                }
            }
        }
        let kept = (0..).map(EdgeIndex).zip(edges);
        let kept = kept.filter_map(|(before, edge)| Some((before, edge?)));
        let (before, edges): (Vec<EdgeIndex>, Vec<Edge>) = kept.chain(added).unzip();
        if edges.is_empty() {
            return Err(ChangeError::NothingLeft);
        }
        let zones = self.zones().iter().map(|zone| with_edges(zone, &before)).collect();
        let (stations, background) = (self.stations().to_vec(), self.background().to_vec());
        Ok(Self::from_valid_parts(self.nodes().to_vec(), edges)
            .with_origin(self.origin())
            .with_surroundings(stations, background)
            .with_zones(zones)
            .with_facilities(self.doors_with(&before), self.lifts_with(&before)))
    }

    /// Returns a copy with more nodes and edges. An added node serves the stations of the node that
    /// it is like, if there is one.
    ///
    /// # Panics
    /// If an id is taken, or if an added edge refers to a node that is in neither.
    #[must_use]
    pub fn with_roads(&self, added: &[(Node, Option<NodeIndex>)], roads: &[Edge]) -> Self {
        let (mut nodes, mut edges) = (self.nodes().to_vec(), self.edges().to_vec());
        let (mut stations, mut zones) = (self.stations().to_vec(), self.zones().to_vec());
        for ((node, like), index) in added.iter().zip(nodes.len() as u32..) {
            assert!(self.node_by_id(node.id).is_none(), "node {} is there", node.id);
            nodes.push(node.clone());
            let Some(like) = like else { continue };
            for station in stations.iter_mut().filter(|it| it.nodes.contains(like)) {
                station.nodes.push(NodeIndex(index));
            }
            for zone in zones.iter_mut().filter(|it| it.nodes.contains(like)) {
                zone.nodes.push(NodeIndex(index));
            }
        }
        for edge in roads {
            assert!(self.edge_by_id(edge.id).is_none(), "edge {} is there", edge.id);
            edges.push(edge.clone());
        }
        Self::from_valid_parts(nodes, edges)
            .with_origin(self.origin())
            .with_surroundings(stations, self.background().to_vec())
            .with_zones(zones)
            .with_facilities(self.doors().to_vec(), self.lifts().to_vec())
    }

    /// Returns the doors of a copy of the graph; without those that no edge leads through any more.
    fn doors_with(&self, before: &[EdgeIndex]) -> Vec<Door> {
        let doors = self.doors().iter();
        let doors = doors.map(|door| Door { edges: renamed(&door.edges, before), ..door.clone() });
        doors.filter(|door| !door.edges.is_empty()).collect()
    }

    fn lifts_with(&self, before: &[EdgeIndex]) -> Vec<Lift> {
        let lifts = self.lifts().iter();
        lifts.map(|lift| Lift { rides: renamed(&lift.rides, before), ..lift.clone() }).collect()
    }
}

/// Returns a zone of a graph whose edges have changed.
fn with_edges(zone: &Zone, before: &[EdgeIndex]) -> Zone {
    Zone { edges: renamed(&zone.edges, before), ..zone.clone() }
}

/// Returns the edges of a changed graph that were among some edges, in ascending order. `before` is
/// by edge that which it was, or that it is added to.
fn renamed(some: &[EdgeIndex], before: &[EdgeIndex]) -> Vec<EdgeIndex> {
    let edges = (0..).map(EdgeIndex).zip(before);
    let kept = edges.filter(|(_, before)| some.binary_search(before).is_ok());
    kept.map(|(edge, _)| edge).collect()
}

/// Returns a curve with the same ends whose middle is `metres` to the right; `None` for a path of
/// several curves.
fn offset(path: &Path, metres: f64) -> Option<Path> {
    let [start, first_handle, last_handle, end] = path.single()?.control_points;
    let right = -(end - start).normalize_or_zero().perp() * (metres / REACH_OF_HANDLES);
    let control_points = [start, first_handle + right, last_handle + right, end];
    Some(CubicBezier { control_points }.into())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::model::options::ReadOptions;
    use crate::model::tags::{Role, Station};
    use crate::parse;

    fn graph() -> RouteGraph {
        let text = "id,x,y\nA,0,0\nB,10,0\n\nfrom,to,speed\nA,B,1.5\nB,A,1\n";
        parse(text, "t.csv", &ReadOptions::default()).expect("a graph").0
    }

    #[test]
    fn edges_are_closed_made_faster_and_doubled() {
        let graph = graph();
        let ids: Vec<u32> = graph.edges().iter().map(|edge| edge.id).collect();
        let changed = graph
            .with_changes(&[(ids[0], EdgeChange::Speed(2.0)), (ids[0], EdgeChange::Double(1.2))]);
        let changed = changed.expect("a graph");
        let [first, second, third] = changed.edges() else { panic!("{:?}", changed.edges()) };
        assert_eq!((first.speed, second.speed, third.speed), (3.0, 1.0, 3.0));
        assert_eq!(
            (third.id, third.origin, third.destination),
            (ids[1] + 1, first.origin, first.destination)
        );
        let middle = third.path.at(0.5).0;
        assert!(
            (middle.x - 5.0).abs() < 1e-9 && (middle.y + 1.2).abs() < 1e-9,
            "to the right of it: {middle}"
        );
        let closed = graph.with_changes(&[(ids[1], EdgeChange::Close)]).expect("a graph");
        assert_eq!(closed.edges().len(), 1);
        assert_eq!(closed.departures(closed.edges()[0].destination), []);
    }

    #[test]
    fn edges_are_turned_round_and_given_a_least_speed() {
        let graph = graph();
        let ids: Vec<u32> = graph.edges().iter().map(|edge| edge.id).collect();
        let changes = [(ids[0], EdgeChange::Reverse), (ids[1], EdgeChange::AtLeast(1.2))];
        let changed = graph.with_changes(&changes).expect("a graph");
        let [first, second] = changed.edges() else { panic!("{:?}", changed.edges()) };
        assert_eq!((first.origin, first.destination), (NodeIndex(1), NodeIndex(0)));
        assert_eq!((first.path.start().x, first.path.end().x), (10.0, 0.0));
        assert_eq!((first.speed, second.speed), (1.5, 1.2));
        assert_eq!(changed.departures(NodeIndex(0)), []);
    }

    #[test]
    fn an_added_node_serves_the_station_of_the_one_that_it_is_like() {
        let station = Station {
            name: "S".to_owned(),
            role: Role::Pick,
            nodes: vec![NodeIndex(1)],
            position: None,
            properties: BTreeMap::new(),
        };
        let graph = graph().with_surroundings(vec![station], Vec::new());
        let place = Node::new(7, glam::DVec2::new(10.0, 2.0), 0.0);
        let path = CubicBezier::straight(glam::DVec2::ZERO, place.position);
        let road = Edge::new(9, NodeIndex(0), NodeIndex(2), path, 1.5);
        let more = graph.with_roads(&[(place, Some(NodeIndex(1)))], &[road]);
        assert_eq!(more.stations()[0].nodes, [NodeIndex(1), NodeIndex(2)]);
        assert_eq!(more.departures(NodeIndex(0)).len(), 2);
    }

    #[test]
    fn what_cannot_be_changed_is_refused() {
        let graph = graph();
        let ids: Vec<u32> = graph.edges().iter().map(|edge| edge.id).collect();
        assert_eq!(
            graph.with_changes(&[(99, EdgeChange::Close)]).map(drop),
            Err(ChangeError::Unknown(99))
        );
        let all: Vec<_> = ids.iter().map(|id| (*id, EdgeChange::Close)).collect();
        assert_eq!(graph.with_changes(&all).map(drop), Err(ChangeError::NothingLeft));
    }
}
