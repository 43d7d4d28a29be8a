//! The roads of a world: its legs, the conflicts between stretches of them, and the places at which
//! a robot may stand without blocking others.

mod cache;
mod conflicts;
mod delays;
mod driving_times;
mod reservoirs;
mod stops;
mod stubs;
#[cfg(test)]
mod tests;
mod zones;

use std::sync::{Arc, OnceLock};

use glam::{DVec2, Vec2, vec2};
use regatta_base::cores;
use regatta_base::graph::CRAWL;
use regatta_base::rows::Rows;
use regatta_base::sweep::{BodyHeading, Footprint, Sweep, angle_between};
use regatta_plugin::World;
use regatta_plugin::world::{CurveRecord, EdgeRecord, Levels, Orientation, RobotTypeRecord, Shape};

pub use self::cache::{CacheError, default_folder as default_cache_folder};
use self::cache::{Reader, Writer};
pub use self::conflicts::{ConflictTable, Conflicts, RESOLUTION, Relation};
use self::driving_times::DrivingTimes;
pub use self::driving_times::lower_costs;
pub use self::stops::Stops;
pub use self::stubs::Stubs;
pub use self::zones::{Rule, ZonePart, Zones};

/// An edge that is driven in one gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Leg(u32);

impl Leg {
    /// Returns the leg of an edge, by its index in the world (less than 2³¹).
    pub const fn new(edge: u32, reverse: bool) -> Self {
        Self(edge << 1 | reverse as u32)
    }

    /// Index of the edge in the world.
    pub const fn edge(self) -> u32 {
        self.0 >> 1
    }

    /// Whether it is driven from destination to origin, in reverse gear.
    pub const fn is_reverse(self) -> bool {
        self.0 & 1 == 1
    }

    /// A dense index: less than twice the number of edges.
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// Returns the leg with a dense index.
    pub const fn from_index(index: u32) -> Self {
        Self(index)
    }
}

/// An edge of the roads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Road {
    /// Id in the route graph's file.
    pub id: u32,
    /// Index of the origin among the world's nodes.
    pub origin: u32,
    /// Index of the destination.
    pub destination: u32,
    /// Metres.
    pub length: f32,
    /// Metres per second; 0 if the edge isn't driven forward.
    pub speed: f32,
    /// Metres per second in reverse gear; 0 if that isn't allowed.
    pub reverse_speed: f32,
    /// Headings of robots at its origin and its destination, in radians in (-π, π].
    pub headings: [f32; 2],
    /// Seconds that its doors, or its lift, cost besides driving.
    pub delay_secs: f32,
}

/// The properties of a robot type that roads depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotClass {
    /// Index among the [footprints](Roads::footprints).
    pub footprint: usize,
    /// Metres per second; infinity for no limit.
    pub max_speed: f32,
    /// Metres per second squared; infinity for no limit.
    pub max_acceleration: f32,
    /// Whether it turns on the spot.
    pub turns: bool,
}

/// The roads of a world.
#[derive(Debug)]
pub struct Roads {
    edges: Vec<Road>,
    nodes: u32,
    node_ids: Vec<u32>,
    positions: Vec<Vec2>,
    levels: Levels,
    /// By node: the legs that leave it.
    exits: Rows<Leg>,
    /// By node: a leg that leads there, in reverse gear only if there is no other.
    arrivals: Vec<Option<Leg>>,
    /// By robot type.
    classes: Vec<RobotClass>,
    footprints: Vec<Footprint>,
    conflicts: Conflicts,
    stops: Vec<Stops>,
    /// By edge.
    reservoirs: Vec<bool>,
    stubs: Stubs,
    zones: Arc<Zones>,
    driving_times: OnceLock<DrivingTimes>,
}

/// The largest difference in radians between the headings of consecutive legs that robots drive
/// through without a turn on the spot: 5°, as in the engine.
pub const SMOOTH: f32 = 5.0 * core::f32::consts::PI / 180.0;

impl Roads {
    /// Computes the roads of a world: samples every edge and tests which stretches touch.
    pub fn new(world: &World<'_>) -> Self {
        let sweeps = sweeps(world);
        let edges = world.edges().iter().zip(&sweeps);
        let mut roads = Self::of_edges(
            world,
            edges.map(|(edge, sweep)| {
                let headings = sweep.headings().map(|heading| edge.orientation().heading(heading));
                road(edge, sweep.length(), headings)
            }),
        );
        let turns = roads.classes.iter().any(|class| class.turns);
        let discs = if turns { roads.turning_nodes() } else { Vec::new() };
        roads.conflicts = Conflicts::new(&roads, &sweeps, &discs);
        roads.stops =
            (0..roads.footprints.len()).map(|footprint| Stops::new(&roads, footprint)).collect();
        roads.reservoirs = reservoirs::reservoirs(&roads);
        roads
    }

    /// Makes the roads without conflicts and stopping places.
    fn of_edges(world: &World<'_>, edges: impl Iterator<Item = Road>) -> Self {
        let mut edges: Vec<Road> = edges.collect();
        delays::add(world, &mut edges);
        let (classes, footprints) = classes(world.robot_types());
        let mut roads = Self {
            nodes: world.nodes().len() as u32,
            node_ids: world.nodes().iter().map(|node| node.id).collect(),
            positions: world.nodes().iter().map(|node| vec2(node.x, node.y)).collect(),
            levels: Levels::new(world),
            zones: Arc::new(Zones::new(world, &edges)),
            arrivals: arrivals(&edges, world.nodes().len()),
            exits: exits(&edges, world.nodes().len()),
            edges,
            classes,
            footprints,
            conflicts: Conflicts::default(),
            stops: Vec::new(),
            reservoirs: Vec::new(),
            stubs: Stubs::default(),
            driving_times: OnceLock::new(),
        };
        roads.stubs = Stubs::new(&roads);
        roads
    }

    /// Writes what [`new`](Self::new) has computed.
    fn write(&self, writer: &mut Writer) {
        writer.floats(self.edges.iter().map(|edge| edge.length));
        for end in [0, 1] {
            writer.floats(self.edges.iter().map(|edge| edge.headings[end]));
        }
        self.conflicts.write(writer);
        for stops in &self.stops {
            stops.write(writer);
        }
        writer.list(self.reservoirs.iter().map(|is_reservoir| u32::from(*is_reservoir)));
    }

    /// Reads what [`new`](Self::new) has computed for a world; `None` if it doesn't fit the world.
    fn read(world: &World<'_>, reader: &mut Reader<'_>) -> Option<Self> {
        let count = world.edges().len();
        let (lengths, starts, ends) =
            (reader.floats(count)?, reader.floats(count)?, reader.floats(count)?);
        let shapes = lengths.into_iter().zip(starts.into_iter().zip(ends));
        let edges = world.edges().iter().zip(shapes);
        let mut roads = Self::of_edges(
            world,
            edges.map(|(edge, (length, (start, end)))| road(edge, length, [start, end])),
        );
        roads.conflicts = Conflicts::read(&roads, reader)?;
        roads.stops =
            roads.footprints.iter().map(|_| Stops::read(count, reader)).collect::<Option<_>>()?;
        roads.reservoirs =
            reader.list_of(count)?.into_iter().map(|is_reservoir| is_reservoir != 0).collect();
        Some(roads)
    }

    /// All edges, by their index in the world.
    pub fn edges(&self) -> &[Road] {
        &self.edges
    }

    /// An edge.
    pub fn edge(&self, edge: u32) -> &Road {
        &self.edges[edge as usize]
    }

    /// Number of nodes.
    pub fn nodes(&self) -> u32 {
        self.nodes
    }

    /// The id of a node in the route graph's file.
    pub fn node_id(&self, node: u32) -> u32 {
        self.node_ids[node as usize]
    }

    /// The position of a node, in metres.
    pub fn position(&self, node: u32) -> Vec2 {
        self.positions[node as usize]
    }

    /// The robot types.
    pub fn classes(&self) -> &[RobotClass] {
        &self.classes
    }

    /// The footprints of all robot types, without repetitions.
    pub fn footprints(&self) -> &[Footprint] {
        &self.footprints
    }

    /// The conflicts between tracks.
    pub fn conflicts(&self) -> &Conflicts {
        &self.conflicts
    }

    /// The places where robots with a footprint may stop.
    pub fn stops(&self, footprint: usize) -> &Stops {
        &self.stops[footprint]
    }

    /// Whether robots may queue on an edge without blocking robots that drive elsewhere.
    pub fn is_reservoir(&self, edge: u32) -> bool {
        self.reservoirs[edge as usize]
    }

    /// Dead ends in which no two robots can pass each other.
    pub fn stubs(&self) -> &Stubs {
        &self.stubs
    }

    /// The zones with a rule.
    pub fn zones(&self) -> &Arc<Zones> {
        &self.zones
    }

    /// The node nearest to a position; `None` if there is none.
    pub fn nearest_node(&self, position: Vec2) -> Option<u32> {
        let distance = |node: &u32| self.position(*node).distance(position);
        (0..self.nodes).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// The legs that leave a node.
    pub fn exits(&self, node: u32) -> &[Leg] {
        self.exits.row(node)
    }

    /// A leg that leads to a node, in reverse gear only if there is no other; `None` if there is
    /// none.
    pub fn arrival(&self, node: u32) -> Option<Leg> {
        self.arrivals[node as usize]
    }

    /// The node that a leg leaves.
    pub fn start(&self, leg: Leg) -> u32 {
        let edge = self.edge(leg.edge());
        if leg.is_reverse() { edge.destination } else { edge.origin }
    }

    /// The node that a leg leads to.
    pub fn end(&self, leg: Leg) -> u32 {
        let edge = self.edge(leg.edge());
        if leg.is_reverse() { edge.origin } else { edge.destination }
    }

    /// The speed of a class on a leg, in metres per second.
    pub fn speed(&self, class: &RobotClass, leg: Leg) -> f32 {
        self.allowed_speed(leg).min(class.max_speed)
    }

    /// The speed of robots without a limit of their own on a leg, in metres per second.
    pub fn allowed_speed(&self, leg: Leg) -> f32 {
        let edge = self.edge(leg.edge());
        if leg.is_reverse() { edge.reverse_speed } else { edge.speed }
    }

    /// Whether a robot of any footprint may stand at the end of a leg: it is only in the way of
    /// edges that meet there.
    pub fn is_place(&self, leg: Leg) -> bool {
        self.stops.iter().all(|stops| stops.is_siding(leg))
    }

    /// The headings of robots where they enter and where they leave a leg.
    pub fn headings(&self, leg: Leg) -> [f32; 2] {
        let [origin, destination] = self.edge(leg.edge()).headings;
        if leg.is_reverse() { [destination, origin] } else { [origin, destination] }
    }

    /// Whether robots that turn on the spot do so between two legs.
    pub fn is_turn(&self, from: Leg, to: Leg) -> bool {
        angle_between(self.headings(from)[1], self.headings(to)[0]) > SMOOTH
    }

    /// The number of the track of a node at which robots turn on the spot; tracks below it are the
    /// edges.
    pub fn disc(&self, node: u32) -> u32 {
        self.edges.len() as u32 + node
    }

    /// Whether robots on two tracks aren't on different levels.
    fn may_meet(&self, a: u32, b: u32) -> bool {
        let [a, b] = [a, b].map(|track| match track.checked_sub(self.edges.len() as u32) {
            Some(node) => self.levels.of_node(node),
            None => self.levels.of_edge(track),
        });
        a.may_meet(b)
    }

    fn turning_nodes(&self) -> Vec<u32> {
        let mut arrivals = vec![Vec::new(); self.nodes as usize];
        for node in 0..self.nodes {
            for &leg in self.exits(node) {
                arrivals[self.end(leg) as usize].push(leg);
            }
        }
        let mut turning = Vec::new();
        for (node, arrivals) in (0..).zip(arrivals) {
            let exits = self.exits(node);
            if arrivals.iter().any(|&from| exits.iter().any(|&to| self.is_turn(from, to))) {
                turning.push(node);
            }
        }
        turning
    }
}

/// Samples all edges.
fn sweeps(world: &World<'_>) -> Vec<Sweep> {
    let edges = world.edges();
    cores::map(edges.len(), |edge| sweep(&edges[edge], world.curves(&edges[edge])))
}

fn sweep(edge: &EdgeRecord, curves: &[CurveRecord]) -> Sweep {
    let heading = match edge.orientation() {
        Orientation::Tangential => BodyHeading::Tangential,
        Orientation::Offset(offset) => BodyHeading::Offset(offset.into()),
        Orientation::Fixed(heading) => BodyHeading::Fixed(heading.into()),
    };
    Sweep::new(heading, curves.iter().map(control_points))
}

fn control_points(curve: &CurveRecord) -> [DVec2; 4] {
    curve.control_points.map(|[x, y]| DVec2::new(x.into(), y.into()))
}

fn road(edge: &EdgeRecord, length: f32, headings: [f32; 2]) -> Road {
    Road {
        id: edge.id,
        origin: edge.origin,
        destination: edge.destination,
        length,
        speed: edge.speed,
        reverse_speed: edge.reverse_speed,
        headings,
        delay_secs: 0.0,
    }
}

fn classes(types: &[RobotTypeRecord]) -> (Vec<RobotClass>, Vec<Footprint>) {
    let mut footprints: Vec<Footprint> = Vec::new();
    let mut classes = Vec::with_capacity(types.len());
    for robot_type in types {
        let footprint = match robot_type.shape() {
            Shape::Rectangle => Footprint::rectangle(robot_type.length, robot_type.width),
            Shape::Circle => Footprint::circle(robot_type.length),
        };
        let index =
            footprints.iter().position(|known| *known == footprint).unwrap_or(footprints.len());
        if index == footprints.len() {
            footprints.push(footprint);
        }
        classes.push(RobotClass {
            footprint: index,
            max_speed: robot_type.max_speed,
            max_acceleration: robot_type.max_acceleration,
            turns: robot_type.max_rotation_speed > 0.0,
        });
    }
    (classes, footprints)
}

/// Returns the legs that leave each node, in ascending order, without those that are slower than a
/// [crawl](CRAWL).
fn exits(edges: &[Road], nodes: usize) -> Rows<Leg> {
    let mut legs = Vec::with_capacity(edges.len());
    for (index, edge) in (0..).zip(edges) {
        if edge.speed >= CRAWL as f32 {
            legs.push((edge.origin, Leg::new(index, false)));
        }
        if edge.reverse_speed >= CRAWL as f32 {
            legs.push((edge.destination, Leg::new(index, true)));
        }
    }
    Rows::new(nodes, legs)
}

fn arrivals(edges: &[Road], nodes: usize) -> Vec<Option<Leg>> {
    let mut arrivals = vec![None; nodes];
    for (index, edge) in (0..).zip(edges) {
        if edge.reverse_speed >= CRAWL as f32 {
            arrivals[edge.origin as usize] = Some(Leg::new(index, true));
        }
    }
    for (index, edge) in (0..).zip(edges) {
        arrivals[edge.destination as usize] = Some(Leg::new(index, false));
    }
    arrivals
}
