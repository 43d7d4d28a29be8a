//! The number of robots, and the world and types that the engine publishes.

use std::collections::BTreeMap;

use glam::DVec2;
use regatta_base::random::mix;
use regatta_layout::traffic::MainPart;
use regatta_layout::{
    Cabin, CubicBezier, Edge, EdgeIndex, Lift, Node, NodeIndex, Orientation, Role, RouteGraph,
    Station, Tags, Zone, ZoneRule,
};
use regatta_motion::Tracks;
use regatta_plugin::PublishError;
use regatta_plugin::column::{BATTERY, TYPE};
use regatta_plugin::event::Refusal;
use regatta_plugin::producer::Session;
use regatta_plugin::world::{
    self, CurveRecord, DoorRecord, EdgeRecord, LiftRecord, MAX_BACKGROUND_POINTS, NodeRecord,
    OtherNameRecord, RobotTypeRecord, StationRecord, Texts, WorldData, ZoneRecord,
};
use regatta_scenario::{RobotType, Shape, Start};

use super::standing::StandingPlaces;
use super::{EngineError, PlacesTaken, Scenario, Simulation};
use crate::arc_length;
use crate::fleet::{Placement, RouteSource};

impl Simulation {
    /// Spawns robots as the scenario defines them, or removes those with the highest ids, until
    /// there are `wanted`.
    ///
    /// # Errors
    /// [`EngineError::NoRoom`] if no place is left for a robot that stands,
    /// [`EngineError::NoCabin`] if one would begin in a shaft; those before it are there then.
    pub(super) fn place_robots(&mut self, wanted: u32) -> Result<(), EngineError> {
        let mut standing = None;
        self.fleet.reserve(wanted as usize);
        while self.fleet.present() > wanted as usize {
            let last = self.fleet.robots() as u32 - 1;
            self.fleet.remove(last, &mut self.events).expect("the last row always holds a robot");
        }
        while self.fleet.present() < wanted as usize {
            let robot = self.fleet.present() as u32;
            let group = self.scenario.group_of(robot);
            let (placement, route) = match &group.start {
                Start::Route { legs, repeat } => (
                    Placement::Node(self.scenario.graph.leg_start(legs[0])),
                    RouteSource::Listed(legs.clone(), *repeat),
                ),
                Start::Random => (self.random_place(robot), RouteSource::Random),
                Start::Node(node) => (Placement::Node(*node), RouteSource::None),
                Start::Standing => {
                    let places = standing.get_or_insert_with(|| self.standing_places());
                    let index = group.robot_type;
                    let robot_type = &self.scenario.robot_types[usize::from(index)];
                    let graph = (&*self.scenario.graph, &*self.tracks);
                    let place = places.take(graph, (index, robot_type));
                    let Some(place) = place else {
                        let are_all = places.are_all_taken(graph, &self.scenario.robot_types);
                        let places = if are_all { PlacesTaken::All } else { PlacesTaken::Some };
                        return Err(EngineError::NoRoom { wanted, fit: robot, places });
                    };
                    (place, RouteSource::None)
                }
            };
            let spawned = self.fleet.spawn(placement, group.robot_type, route, 0, &mut self.events);
            match spawned {
                Err(Refusal::NoCabin) => return Err(EngineError::NoCabin { robot }),
                spawned => drop(spawned.expect("connected routes, and places on the graph")),
            }
        }
        Ok(())
    }

    /// Returns the places for robots that stand, with those that robots are on already.
    fn standing_places(&self) -> StandingPlaces {
        let Scenario { graph, robot_types, seed, .. } = &self.scenario;
        let mut places = StandingPlaces::new(graph, robot_types, *seed);
        for robot in 0..self.fleet.robots() as u32 {
            if let (Some([x, y, theta]), Some(place)) =
                (self.fleet.pose(robot), self.fleet.place(robot))
            {
                let robot_type =
                    &robot_types[usize::from(self.fleet.robot_types()[robot as usize])];
                let pose = (DVec2::new(x.into(), y.into()), DVec2::from_angle(theta.into()));
                places.occupy(robot_type, pose, place);
            }
        }
        places
    }

    /// Returns a random place on a random edge, determined by the scenario's seed and the robot.
    /// Robots begin in no lift.
    fn random_place(&self, robot: u32) -> Placement {
        let mut random = mix(self.scenario.seed ^ mix(u64::from(robot)));
        for _ in 0..MOST_DRAWS {
            let place = self.place_at(random);
            if !is_at_lift(&self.scenario.graph, place) {
                return place;
            }
            random = mix(random);
        }
        self.place_at(random)
    }

    /// Returns the place on an edge that a random number stands for.
    fn place_at(&self, random: u64) -> Placement {
        let edges = self.scenario.graph.edges().len() as u64;
        let edge = EdgeIndex((((random >> 32) * edges) >> 32) as u32);
        let part = (random & 0xff_ffff) as f32 / (1 << 24) as f32;
        Placement::Edge(edge, self.tracks.edge_length(edge) as f32 * part)
    }

    /// Publishes the graph and the robot types.
    pub(super) fn publish_world(&mut self, session: &mut Session) -> Result<(), EngineError> {
        session.ports().publish_world(&typed_world(&self.scenario, &self.tracks))?;
        Ok(())
    }

    /// Publishes each robot's type as a column.
    pub(super) fn publish_types(&mut self, session: &mut Session) -> Result<(), EngineError> {
        self.robot_types.clear();
        self.robot_types.extend_from_slice(self.fleet.robot_types());
        let types: Vec<f32> =
            self.robot_types.iter().map(|&robot_type| f32::from(robot_type)).collect();
        let tick = session.tick();
        let published = session.ports().publish_column(TYPE.name(), tick, &types);
        if matches!(published, Err(PublishError::MemoryFull { .. })) {
            // They are published when there is room again.
            self.robot_types.clear();
        }
        Ok(session.unless_full(published)?)
    }

    /// Publishes the charge of each robot's battery as a column, from time to time, if robots have
    /// batteries.
    pub(super) fn publish_batteries(&mut self, session: &mut Session) -> Result<(), EngineError> {
        let Some(charges) = self.fleet.battery_charges() else { return Ok(()) };
        let tick = session.tick();
        self.batteries_due = tick + self.ticks_per_second();
        let published = session.ports().publish_column(BATTERY.name(), tick, &charges);
        Ok(session.unless_full(published)?)
    }

    fn ticks_per_second(&self) -> u64 {
        (1.0 / self.scenario.tick_period.as_secs_f64()).round().max(1.0) as u64
    }
}

/// The largest number of random places that are drawn for a robot.
const MOST_DRAWS: u32 = 1000;

/// Whether a place is on an edge that leads into a cabin, out of it, or from level to level.
fn is_at_lift(graph: &RouteGraph, place: Placement) -> bool {
    let Placement::Edge(edge, _) = place else { return false };
    let edge = graph.edge(edge);
    let mut ends = graph
        .lifts()
        .iter()
        .flat_map(|lift| [edge.origin, edge.destination].map(|node| lift.level_of(node)));
    ends.any(|level| level.is_some())
}

/// Returns a layout as the world that an engine publishes, without robot types and the lengths of
/// edges.
pub fn world(graph: &RouteGraph) -> WorldData {
    world_of(graph, std::iter::repeat(0.0))
}

/// Returns the world of a scenario, as an engine publishes it.
pub fn scenario_world(scenario: &Scenario) -> WorldData {
    typed_world(scenario, &arc_length::compile(&scenario.graph))
}

fn typed_world(scenario: &Scenario, tracks: &Tracks) -> WorldData {
    let lengths = (0..).map(|index| tracks.edge_length(EdgeIndex(index)) as f32);
    let mut world = world_of(&scenario.graph, lengths);
    world.robot_types = scenario.robot_types.iter().map(robot_type_record).collect();
    world
}

/// Returns a graph as a world without robot types. `lengths` are those of the edges, in metres.
fn world_of(graph: &RouteGraph, lengths: impl Iterator<Item = f32>) -> WorldData {
    let mut world = WorldData { origin: graph.origin().to_array(), ..WorldData::default() };
    let nodes = graph.nodes().iter().zip(graph.purposes());
    world.nodes = nodes.map(|(node, role)| node_record(node, role, &mut world.texts)).collect();
    for (edge, length) in graph.edges().iter().zip(lengths) {
        let record = edge_record(edge, length, &mut world.texts);
        world.add_edge(record, edge.path.cubics().map(curve_record));
    }
    for zone in graph.zones() {
        let (nodes, edges) = (zone.nodes.iter(), zone.edges.iter());
        let record = zone_record(zone, &mut world.texts);
        world.add_zone(record, nodes.map(|node| node.0), edges.map(|edge| edge.0));
    }
    add_other_names(graph, &mut world);
    add_facilities(graph, &mut world);
    add_stations(graph, &mut world);
    add_background(graph, &mut world);
    world
}

/// Adds the stations. One without a position is at the first of its nodes; without nodes, too, it
/// is left out.
fn add_stations(graph: &RouteGraph, world: &mut WorldData) {
    for station in graph.stations() {
        let first = station.nodes.first().map(|node| graph.node(*node));
        let Some(place) = station.position.or(first.map(|node| node.position)) else { continue };
        let level = first.and_then(|node| node.tags.as_ref()?.level.as_deref());
        let [x, y] = place.as_vec2().to_array();
        let record = StationRecord {
            name: world.texts.add(&station.name),
            level: world.texts.add(level.unwrap_or_default()),
            x,
            y,
            role: station.role as u32,
            ..StationRecord::default()
        };
        world.add_station(record, station.nodes.iter().map(|node| node.0));
    }
}

/// Adds the lines of the background, as far as there is room for them.
fn add_background(graph: &RouteGraph, world: &mut WorldData) {
    let mut is_whole = true;
    for line in graph.background() {
        let level = world.texts.add(line.level.as_deref().unwrap_or_default());
        let points = line.points.iter().map(|point| point.as_vec2().to_array());
        is_whole &= world.add_background_line(level, points);
    }
    if !is_whole {
        tracing::warn!(
            "the background has more than {MAX_BACKGROUND_POINTS} points: readers get a part of it"
        );
    }
}

/// Adds the doors and the lifts.
fn add_facilities(graph: &RouteGraph, world: &mut WorldData) {
    for door in graph.doors() {
        let line = door.drawn_line(graph).map(|point| point.as_vec2().to_array());
        let record = DoorRecord {
            name: world.texts.add(&door.name),
            opening_secs: door.times.opening_secs as f32,
            closing_secs: door.times.closing_secs as f32,
            line,
            ..DoorRecord::default()
        };
        world.add_door(record, door.edges.iter().map(|edge| edge.0));
    }
    for lift in graph.lifts() {
        let record = lift_record(graph, lift, &mut world.texts);
        let names: Vec<u32> =
            lift.levels.iter().map(|level| world.texts.add(&level.name)).collect();
        let nodes = lift.levels.iter().map(|level| level.nodes.iter().map(|node| node.0));
        let rides = lift.rides.iter().map(|edge| edge.0);
        world.add_lift(record, names.into_iter().zip(nodes), rides);
    }
}

/// Returns a lift without its levels and rides. A cabin without a footprint in the file is centred
/// at its first node.
fn lift_record(graph: &RouteGraph, lift: &Lift, texts: &mut Texts) -> LiftRecord {
    let centre = graph.node(lift.levels[0].nodes[0]).position;
    let cabin = lift.cabin.unwrap_or(Cabin { centre, size: DVec2::ZERO, yaw: 0.0 });
    LiftRecord {
        name: texts.add(&lift.name),
        capacity: lift.places().get(),
        level_secs: lift.level_secs as f32,
        opening_secs: lift.door_times.opening_secs as f32,
        closing_secs: lift.door_times.closing_secs as f32,
        centre: cabin.centre.as_vec2().to_array(),
        size: cabin.size.as_vec2().to_array(),
        yaw: cabin.yaw as f32,
        ..LiftRecord::default()
    }
}

/// Adds the names that one station has, and the aliases that one node has.
fn add_other_names(graph: &RouteGraph, world: &mut WorldData) {
    let mut add = |name: &str, node: u32| {
        world.other_names.push(OtherNameRecord { name: world.texts.add(name), node });
    };
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for name in graph.stations().iter().flat_map(Station::names) {
        *counts.entry(name).or_default() += 1;
    }
    // The first node of a station is the one that orders for it mean.
    let cut_off = MainPart::of(graph).map(|main| main.cut_off).unwrap_or_default();
    for station in graph.stations() {
        let (others, first): (Vec<NodeIndex>, Vec<NodeIndex>) =
            station.nodes.iter().partition(|node| cut_off.contains_key(*node));
        for name in station.names().filter(|name| counts[name] == 1) {
            for node in first.iter().chain(&others) {
                add(name, node.0);
            }
        }
    }
    let repeated = graph.repeated_names();
    for (node, index) in graph.nodes().iter().zip(0..) {
        for name in node.other_names().iter().filter(|name| !repeated.contains_key(*name)) {
            add(name, index);
        }
    }
}

fn node_record(node: &Node, role: Role, texts: &mut Texts) -> NodeRecord {
    let [x, y] = node.position.as_vec2().to_array();
    let [name, level, zone] = text_offsets(node.tags.as_deref(), texts);
    NodeRecord { id: node.id, x, y, theta: node.theta as f32, name, level, zone, role: role as u32 }
}

/// Returns the offsets of the name, the level and the zone.
fn text_offsets(tags: Option<&Tags>, texts: &mut Texts) -> [u32; 3] {
    let Some(tags) = tags else { return [0; 3] };
    [&tags.name, &tags.level, &tags.zone].map(|text| texts.add(text.as_deref().unwrap_or_default()))
}

fn curve_record(cubic: &CubicBezier) -> CurveRecord {
    CurveRecord { control_points: cubic.control_points.map(|point| point.as_vec2().to_array()) }
}

fn orientation(orientation: Orientation) -> world::Orientation {
    match orientation {
        Orientation::Tangential => world::Orientation::Tangential,
        Orientation::Offset(angle) => world::Orientation::Offset(angle as f32),
        Orientation::Fixed(angle) => world::Orientation::Fixed(angle as f32),
    }
}

/// Returns an edge without its curves.
fn edge_record(edge: &Edge, length: f32, texts: &mut Texts) -> EdgeRecord {
    let [name, level, zone] = text_offsets(edge.tags.as_deref(), texts);
    EdgeRecord {
        id: edge.id,
        origin: edge.origin.0,
        destination: edge.destination.0,
        length,
        speed: edge.speed as f32,
        reverse_speed: edge.reverse_speed.unwrap_or(0.0) as f32,
        name,
        level,
        zone,
        ..EdgeRecord::default()
    }
    .with_orientation(orientation(edge.orientation))
}

/// Returns a zone without its members.
fn zone_record(zone: &Zone, texts: &mut Texts) -> ZoneRecord {
    let (rule, capacity) = match zone.rule {
        ZoneRule::Capacity(robots) => (world::ZoneRule::Capacity, robots.get()),
        ZoneRule::SameDirection => (world::ZoneRule::SameDirection, 0),
    };
    ZoneRecord { name: texts.add(&zone.name), rule: rule as u32, capacity, ..ZoneRecord::default() }
}

fn robot_type_record(robot_type: &RobotType) -> RobotTypeRecord {
    let battery = robot_type.battery.unwrap_or_default();
    RobotTypeRecord {
        name: RobotTypeRecord::padded_name(&robot_type.name),
        shape: match robot_type.shape {
            Shape::Rectangle => world::Shape::Rectangle,
            Shape::Circle => world::Shape::Circle,
        } as u32,
        length: robot_type.length,
        width: robot_type.width,
        max_speed: robot_type.max_speed,
        max_acceleration: robot_type.max_acceleration,
        max_rotation_speed: robot_type.max_rotation_speed,
        max_rotation_acceleration: robot_type.max_rotation_acceleration,
        battery_capacity: battery.capacity,
        drain_moving: battery.drain_moving,
        drain_standing: battery.drain_standing,
        charge_rate: battery.charge_rate,
    }
}

#[cfg(test)]
mod tests {
    use regatta_layout::{NodeIndex, Path};

    use super::*;

    #[test]
    fn roles_have_the_numbers_and_names_of_the_contract() {
        for &role in Role::ALL {
            let node = Node { role, ..Node::new(1, DVec2::ZERO, 0.0) };
            let mut world = WorldData::default();
            world.nodes = vec![node_record(&node, role, &mut world.texts)];
            let published = world.view(1, 1).nodes()[0].role();
            assert_eq!((published as u32, published.name()), (role as u32, role.name()));
        }
    }

    #[test]
    fn a_world_has_the_curves_texts_and_origin_of_its_graph() {
        let corners = [DVec2::ZERO, DVec2::X * 2.0, DVec2::new(2.0, 3.0)];
        let tags =
            |name: &str| Tags { level: Some("ground floor".into()), ..Tags::named(name) }.boxed();
        let node = |id: u32, place, name| Node { tags: tags(name), ..Node::new(id, place, 0.0) };
        let nodes = vec![
            Node { role: Role::Charge, ..node(1, corners[0], "dock") },
            node(2, corners[2], "gate"),
        ];
        let cubics = [0, 1].map(|part| CubicBezier::straight(corners[part], corners[part + 1]));
        let path = Path::from_cubics(&cubics).expect("two cubics");
        let mut edge = Edge::new(7, NodeIndex(0), NodeIndex(1), path, 1.5);
        edge.reverse_speed = Some(0.5);
        edge.orientation = Orientation::Fixed(1.0);
        let graph =
            RouteGraph::from_valid_parts(nodes, vec![edge]).with_origin(DVec2::new(3.5e6, -1.0));

        let data = world_of(&graph, [5.0].into_iter());
        let world = data.view(1, 1);
        let (first, edge) = (&world.nodes()[0], &world.edges()[0]);
        assert_eq!((world.origin(), first.role().name()), ([3.5e6, -1.0], "charge"));
        assert_eq!((world.text(first.name), world.text(first.level)), ("dock", "ground floor"));
        assert_eq!(first.level, world.nodes()[1].level, "equal texts are stored once");
        assert_eq!(
            (edge.length, edge.orientation(), edge.name),
            (5.0, world::Orientation::Fixed(1.0), 0)
        );
        let ends: Vec<_> = world.curves(edge).iter().map(|curve| curve.control_points[3]).collect();
        assert_eq!(ends, [[2.0, 0.0], [2.0, 3.0]]);
    }

    #[test]
    fn stations_and_walls_are_published_with_their_levels() {
        let text = include_str!("../../../graphs/imported/open-rmf/office.building.yaml");
        let options = regatta_layout::ReadOptions::default();
        let (graph, _) = regatta_layout::parse(text, "office.building.yaml", &options).unwrap();
        let data = world(&graph);
        let world = data.view(1, 1);
        let stations = world.stations().iter();
        let named = |name: &str| stations.clone().find(|station| world.text(station.name) == name);
        let dispenser = named("coke_dispenser").expect("a station");
        assert_eq!((world.text(dispenser.level), dispenser.role().name()), ("L1", "pick"));
        let [node] = world.station_nodes(dispenser) else { panic!("one node") };
        assert_eq!(world.text(world.nodes()[*node as usize].name), "pantry");
        assert!((dispenser.x - 17.76).abs() < 0.1 && (dispenser.y + 5.5).abs() < 0.1);
        assert_eq!(world.background_lines().len(), graph.background().len());
        for (line, drawn) in world.background_lines().iter().zip(graph.background()) {
            assert_eq!(world.text(line.level), "L1");
            assert_eq!(world.background_points(line).len(), drawn.points.len());
        }
    }
}
