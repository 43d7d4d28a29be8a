//! The common parts of all drawings of a route graph: stations under one naming, that of the
//! viewer's pictures, and the kinds of the lines of the background.

use std::collections::BTreeSet;

use glam::DVec2;
use regatta_base::badge::Sign;
use regatta_base::graph::NodeIndex;
use regatta_base::outline::{LineKind, kinds};

use super::route_graph::{Edge, RouteGraph};
use super::tags::Role;

/// A station on a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnStation<'a> {
    /// Its name; the role and the id of a node without a name.
    pub name: String,
    /// The work of robots there.
    pub role: Role,
    /// Metres from [`RouteGraph::origin`].
    pub place: DVec2,
    /// The nodes from which robots serve it; none if it is a node itself.
    pub nodes: &'a [NodeIndex],
}

impl Role {
    /// The sign of stations of this role in drawings.
    pub fn sign(self) -> Sign {
        match self {
            Self::None => Sign::None,
            Self::Pick => Sign::Pick,
            Self::Drop => Sign::Drop,
            Self::Park => Sign::Park,
            Self::Charge => Sign::Charge,
            Self::Transfer => Sign::Transfer,
        }
    }
}

impl RouteGraph {
    /// Returns the stations on a drawing. One without a position is at the first of its nodes. A
    /// node with a role that serves no station is a station of its own.
    pub fn drawn_stations(&self) -> Vec<DrawnStation<'_>> {
        let mut drawn: Vec<DrawnStation<'_>> = Vec::new();
        for station in self.stations() {
            let first = station.nodes.first().map(|node| self.node(*node).position);
            let Some(place) = station.position.or(first) else { continue };
            let (name, role, nodes) = (station.name.clone(), station.role, &*station.nodes);
            drawn.push(DrawnStation { name, role, place, nodes });
        }
        for index in self.station_nodes() {
            let node = self.node(index);
            let name = match node.name() {
                Some(name) => name.to_owned(),
                None => format!("{} {}", node.role.name(), node.id),
            };
            drawn.push(DrawnStation { name, role: node.role, place: node.position, nodes: &[] });
        }
        drawn
    }

    /// Returns the level of an edge on a drawing: that of its origin or, if that is on none, its own
    /// or that of its destination.
    pub fn drawn_level<'a>(&'a self, edge: &'a Edge) -> Option<&'a str> {
        let own = edge.tags.as_ref().and_then(|tags| tags.level.as_deref());
        let [from, to] = [edge.origin, edge.destination].map(|node| self.node(node).level());
        from.or(own).or(to)
    }

    /// Returns the kind of each line of the background.
    pub fn background_kinds(&self) -> Vec<LineKind> {
        let lines: Vec<_> = self.background().iter().map(|line| line.points.clone()).collect();
        kinds(&lines, self.nodes().iter().map(|node| node.position))
    }

    /// Returns the nodes that are stations of their own: those with a role that serve no station.
    pub fn station_nodes(&self) -> impl Iterator<Item = NodeIndex> {
        let served: BTreeSet<NodeIndex> =
            self.stations().iter().flat_map(|station| &station.nodes).copied().collect();
        let nodes = (0..).map(NodeIndex).zip(self.nodes());
        let nodes = nodes.filter(|(_, node)| node.role != Role::None);
        nodes.map(|(index, _)| index).filter(move |index| !served.contains(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::options::ReadOptions;
    use crate::parse;

    #[test]
    fn stations_precede_the_nodes_with_a_role_that_none_of_them_has() {
        let text = "Vertices:\n- {Id: 1, X: 1, Y: 1, Theta: 0, Role: pick}\n\
            - {Id: 2, X: 5, Y: 1, Theta: 0, Role: charge}\n\
            - {Id: 3, X: 9, Y: 1, Theta: 0, Role: park, Name: Yard}\n\
            Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, \
            VelocityForward: 1}\n\
            - {Id: 2, Origin_ID: 2, Destination_ID: 3, CurveType: Linear, VelocityForward: 1}\n\
            Stations:\n- {Name: Storage 01, Role: pick, Nodes: [1], X: 1, Y: 2.5}\n";
        let graph = parse(text, "g", &ReadOptions::default()).expect("a graph").0;
        let drawn = graph.drawn_stations();
        let names: Vec<_> = drawn.iter().map(|station| &*station.name).collect();
        assert_eq!(names, ["Storage 01", "charge 2", "Yard"], "as in the viewer");
        let station = &drawn[0];
        assert_eq!((station.role, station.place), (Role::Pick, DVec2::new(1.0, 2.5)));
        assert_eq!((station.nodes, drawn[1].nodes), (&[NodeIndex(0)][..], &[][..]));
    }
}
