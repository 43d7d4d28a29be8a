//! The validated route graph: its nodes, edges and legs.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use regatta_base::graph::{EdgeIndex, Ends, Gear, Leg, NodeIndex, Rotation};
use regatta_base::rows::Rows;

use super::facilities::{Door, Lift};
use super::path::Path;
use super::tags::{BackgroundLine, Orientation, Role, Station, Tags};
use super::zones::Zone;

/// A place with a heading.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The id in the file, unique among nodes.
    pub id: u32,
    /// Metres to the east and to the north of [`RouteGraph::origin`].
    pub position: DVec2,
    /// The heading in radians, in (-π, π].
    pub theta: f64,
    /// Whether the file gives the heading. Otherwise `theta` is the heading of an edge.
    pub has_heading: bool,
    /// The purpose of the node.
    pub role: Role,
    /// The name and all other keys of the file; `None` if there are none.
    pub tags: Option<Box<Tags>>,
}

/// A directed curve from one node to another.
#[derive(Clone, Debug, PartialEq)]
pub struct Edge {
    /// The id in the file, unique among edges.
    pub id: u32,
    /// The node where the edge starts.
    pub origin: NodeIndex,
    /// The node where the edge ends.
    pub destination: NodeIndex,
    /// The shape of the edge. Straight edges are cubics with evenly spaced control points.
    pub path: Path,
    /// The speed from origin to destination in metres per second; above 0.
    pub speed: f64,
    /// The speed from destination to origin in reverse gear in metres per second; `None` if reverse
    /// gear isn't allowed.
    pub reverse_speed: Option<f64>,
    /// The heading of robots along the edge.
    pub orientation: Orientation,
    /// The way in which robots turn on the spot at the ends.
    pub rotation: Ends<Rotation>,
    /// The name and all other keys of the file; `None` if there are none.
    pub tags: Option<Box<Tags>>,
}

impl Node {
    /// Returns a node with a heading that its file gives, without a role and without tags.
    pub fn new(id: u32, position: DVec2, theta: f64) -> Self {
        Self { id, position, theta, has_heading: true, role: Role::None, tags: None }
    }

    /// Returns the name, if it has one.
    pub fn name(&self) -> Option<&str> {
        self.tags.as_ref()?.name.as_deref()
    }

    /// Returns the name of its level (floor), if it has one.
    pub fn level(&self) -> Option<&str> {
        self.tags.as_ref()?.level.as_deref()
    }

    /// Returns its other names: the one beside an id that is a text, and those of nodes that are
    /// joined with it.
    pub fn other_names(&self) -> Vec<String> {
        self.tags.as_ref().map(|tags| tags.aliases()).unwrap_or_default()
    }
}

impl Edge {
    /// Returns an edge that robots drive forward only, along its tangent, without tags. The speed
    /// is in metres per second.
    pub fn new(
        id: u32,
        origin: NodeIndex,
        destination: NodeIndex,
        path: impl Into<Path>,
        speed: f64,
    ) -> Self {
        Self {
            id,
            origin,
            destination,
            path: path.into(),
            speed,
            reverse_speed: None,
            orientation: Orientation::Tangential,
            rotation: Ends::default(),
            tags: None,
        }
    }

    /// Returns the name, if it has one.
    pub fn name(&self) -> Option<&str> {
        self.tags.as_ref()?.name.as_deref()
    }
}

/// A validated route graph: every index and every number is in range, every number is finite, every
/// id is unique, and there is at least one edge.
#[derive(Clone, Debug)]
pub struct RouteGraph {
    nodes: Vec<Node>,
    edges: Vec<Edge>,
    node_by_id: BTreeMap<u32, NodeIndex>,
    edge_by_id: BTreeMap<u32, EdgeIndex>,
    /// The legs that leave each node.
    departures: Rows<Leg>,
    origin: DVec2,
    stations: Vec<Station>,
    background: Vec<BackgroundLine>,
    zones: Vec<Zone>,
    doors: Vec<Door>,
    lifts: Vec<Lift>,
}

impl RouteGraph {
    /// Indexes nodes and edges that the caller has validated: numbers are finite and in range, ids
    /// are unique, and there is at least one edge. Texts are read by [`parse`](crate::parse).
    ///
    /// # Panics
    /// If an edge refers to a node that doesn't exist; `validate` rejects such files.
    pub fn from_valid_parts(nodes: Vec<Node>, edges: Vec<Edge>) -> Self {
        let node_by_id =
            (0..).map(NodeIndex).zip(&nodes).map(|(index, node)| (node.id, index)).collect();
        let edge_by_id =
            (0..).map(EdgeIndex).zip(&edges).map(|(index, edge)| (edge.id, index)).collect();
        let departures = legs(&edges).map(|leg| (leg_start(&edges, leg).0, leg)).collect();
        let departures = Rows::by_row(nodes.len(), departures);
        Self {
            nodes,
            edges,
            node_by_id,
            edge_by_id,
            departures,
            origin: DVec2::ZERO,
            stations: Vec::new(),
            background: Vec::new(),
            zones: Vec::new(),
            doors: Vec::new(),
            lifts: Vec::new(),
        }
    }

    /// Sets the origin.
    pub fn with_origin(self, origin: DVec2) -> Self {
        Self { origin, ..self }
    }

    /// Sets the stations, whose nodes must exist, and the lines of the background.
    pub fn with_surroundings(
        self,
        stations: Vec<Station>,
        background: Vec<BackgroundLine>,
    ) -> Self {
        Self { stations, background, ..self }
    }

    /// Sets the zones, whose nodes and edges must exist.
    pub fn with_zones(self, zones: Vec<Zone>) -> Self {
        Self { zones, ..self }
    }

    /// Sets the doors and the lifts, whose nodes and edges must exist. Each lift gets the zone of
    /// its robots, in place of one with the same name, and its rides get the speeds of the cabin.
    pub fn with_facilities(mut self, doors: Vec<Door>, lifts: Vec<Lift>) -> Self {
        for lift in &lifts {
            let zone = lift.zone(&self.edges);
            self.zones.retain(|other| other.name != zone.name);
            self.zones.push(zone);
            for ride in &lift.rides {
                lift.time_ride(&mut self.edges[ride.0 as usize]);
            }
        }
        Self { doors, lifts, ..self }
    }

    /// Gives a node another role or name.
    pub fn override_node(&mut self, node: NodeIndex, role: Option<Role>, name: Option<&str>) {
        let node = &mut self.nodes[node.0 as usize];
        node.role = role.unwrap_or(node.role);
        if let Some(name) = name {
            let tags = node.tags.take().map_or_else(Tags::default, |tags| *tags);
            node.tags = Tags { name: (!name.is_empty()).then(|| name.into()), ..tags }.boxed();
        }
    }

    /// Returns the point (0, 0) of the graph in the coordinates of the file, in metres. It is (0,
    /// 0), unless the file's coordinates are too large for exact poses in single precision. A
    /// position in the file is `origin + position`.
    pub fn origin(&self) -> DVec2 {
        self.origin
    }

    /// Returns the stations.
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// Returns the purpose of each node: its role or, if it has none or only they have loads, that
    /// of the stations that robots serve there.
    pub fn purposes(&self) -> Vec<Role> {
        let mut of_stations = vec![Role::None; self.nodes.len()];
        for station in &self.stations {
            for node in &station.nodes {
                let role = &mut of_stations[node.0 as usize];
                *role = role.and(station.role);
            }
        }
        for (purpose, node) in of_stations.iter_mut().zip(&self.nodes) {
            *purpose = match node.role {
                Role::None => *purpose,
                role if role.handles_loads() => role,
                role => role.and(*purpose),
            };
        }
        of_stations
    }

    /// Returns for each node whether robots charge there: its role or that of a station says so,
    /// also where loads are handled.
    pub fn chargers(&self) -> Vec<bool> {
        let mut chargers: Vec<bool> =
            self.nodes.iter().map(|node| node.role == Role::Charge).collect();
        for station in self.stations.iter().filter(|station| station.role == Role::Charge) {
            for node in &station.nodes {
                chargers[node.0 as usize] = true;
            }
        }
        chargers
    }

    /// Returns the zones with a rule.
    pub fn zones(&self) -> &[Zone] {
        &self.zones
    }

    /// Returns the doors.
    pub fn doors(&self) -> &[Door] {
        &self.doors
    }

    /// Returns the lifts.
    pub fn lifts(&self) -> &[Lift] {
        &self.lifts
    }

    /// Whether an edge is the ride of a lift.
    pub fn is_ride(&self, edge: EdgeIndex) -> bool {
        self.lifts.iter().any(|lift| lift.rides.binary_search(&edge).is_ok())
    }

    /// Returns the lines of the background, such as walls, in metres from [`origin`](Self::origin).
    pub fn background(&self) -> &[BackgroundLine] {
        &self.background
    }

    /// Returns all nodes, by [`NodeIndex`].
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Returns all edges, by [`EdgeIndex`].
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Returns the node at an index.
    pub fn node(&self, index: NodeIndex) -> &Node {
        &self.nodes[index.0 as usize]
    }

    /// Returns the edge at an index.
    pub fn edge(&self, index: EdgeIndex) -> &Edge {
        &self.edges[index.0 as usize]
    }

    /// Looks up a node by its id in the file.
    pub fn node_by_id(&self, id: u32) -> Option<NodeIndex> {
        self.node_by_id.get(&id).copied()
    }

    /// Returns the nodes with a name or, if there are none, those that have it as an alias.
    pub fn nodes_named(&self, name: &str) -> Vec<NodeIndex> {
        let named = self.nodes_where(|node| node.name() == Some(name));
        if !named.is_empty() {
            return named;
        }
        self.nodes_where(|node| node.other_names().iter().any(|other| other == name))
    }

    /// Returns the nodes with each name or alias that several nodes have, and no station.
    pub fn repeated_names(&self) -> BTreeMap<String, Vec<NodeIndex>> {
        let mut names: BTreeMap<String, Vec<NodeIndex>> = BTreeMap::new();
        for (node, index) in self.nodes.iter().zip((0..).map(NodeIndex)) {
            let own = node.name().map(str::to_owned).into_iter();
            for name in own.chain(node.other_names()).collect::<BTreeSet<_>>() {
                names.entry(name).or_default().push(index);
            }
        }
        for station in &self.stations {
            names.remove(&station.name);
        }
        names.retain(|_, nodes| nodes.len() > 1);
        names
    }

    fn nodes_where(&self, condition: impl Fn(&Node) -> bool) -> Vec<NodeIndex> {
        let nodes = (0..).map(NodeIndex).zip(&self.nodes);
        nodes.filter(|(_, node)| condition(node)).map(|(index, _)| index).collect()
    }

    /// Looks up an edge by its id in the file.
    pub fn edge_by_id(&self, id: u32) -> Option<EdgeIndex> {
        self.edge_by_id.get(&id).copied()
    }

    /// Returns the legs that leave a node, in the order of the edges: forward legs on edges that
    /// start at the node, reverse legs on edges that end there and allow reverse gear.
    pub fn departures(&self, node: NodeIndex) -> &[Leg] {
        self.departures.row(node.0)
    }

    /// Returns the node where a leg starts.
    pub fn leg_start(&self, leg: Leg) -> NodeIndex {
        leg_start(&self.edges, leg)
    }

    /// Returns the node where a leg ends.
    pub fn leg_end(&self, leg: Leg) -> NodeIndex {
        let edge = self.edge(leg.edge);
        match leg.gear {
            Gear::Forward => edge.destination,
            Gear::Reverse => edge.origin,
        }
    }

    /// Returns the speed of a leg in metres per second; `None` if the edge can't be driven in that
    /// gear.
    pub fn leg_speed(&self, leg: Leg) -> Option<f64> {
        let edge = self.edge(leg.edge);
        match leg.gear {
            Gear::Forward => Some(edge.speed),
            Gear::Reverse => edge.reverse_speed,
        }
    }
}

/// Returns all legs, in the order of the edges.
pub(crate) fn legs(edges: &[Edge]) -> impl Iterator<Item = Leg> + '_ {
    (0..).map(EdgeIndex).zip(edges).flat_map(|(index, edge)| {
        let reverse = edge.reverse_speed.map(|_| Leg { edge: index, gear: Gear::Reverse });
        std::iter::once(Leg { edge: index, gear: Gear::Forward }).chain(reverse)
    })
}

fn leg_start(edges: &[Edge], leg: Leg) -> NodeIndex {
    let edge = &edges[leg.edge.0 as usize];
    match leg.gear {
        Gear::Forward => edge.origin,
        Gear::Reverse => edge.destination,
    }
}
