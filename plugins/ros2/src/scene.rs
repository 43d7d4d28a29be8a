//! Markers: the graph, the shapes of chosen robots, their routes, contacts.

use std::time::{Duration, Instant};

use glam::{DVec2, Vec2};
use regatta_base::bezier::CubicBezier;
use regatta_plugin::activity::{Activity, Ground};
use regatta_plugin::contact::ContactLevel;
use regatta_plugin::route::LegAhead;
use regatta_plugin::world::{CurveRecord, RobotTypeRecord, Shape};
use regatta_plugin::{
    ColumnReader, ContactReader, Participant, Result, RouteClient, World, column, tell,
};

use crate::link::{Keep, Link, LinkError, Output};
use crate::message::display::{DELETE_ALL, Marker, MarkerArray, shape};
use crate::message::geometry::{ColorRGBA, Header, Point, Pose, Time, Vector3};
use crate::options::Namespace;
use crate::poses::MAP;
use crate::snapshot::Snapshot;

/// Line segments that approximate a curve.
const SEGMENTS: usize = 8;
/// Points of one message: 96 kB.
const POINTS: usize = 4_000;
/// Bytes of a point.
const POINT_BYTES: usize = 24;
/// Contacts of one message.
const CONTACTS: usize = 200;
/// The time between two publications of routes, whose answers cost the engine time.
const ROUTES_EVERY: Duration = Duration::from_millis(500);
/// The time that all answers may take.
const ROUTES_TIMEOUT: Duration = Duration::from_millis(100);

const GRAPH_COLOUR: [u8; 3] = [115, 140, 166];
const BASE_COLOUR: [u8; 3] = [60, 160, 255];
const HORIZON_COLOUR: [u8; 3] = [150, 150, 150];
const TOUCHING_COLOUR: [u8; 3] = [230, 30, 30];
const POSSIBLE_COLOUR: [u8; 3] = [240, 180, 30];

/// The ports of the fleet that markers are made of.
struct Ports {
    routes: RouteClient,
    contacts: ContactReader,
    types: ColumnReader,
}

/// The topics.
pub(crate) struct Scene {
    namespace: Namespace,
    graph: Vec<Output<MarkerArray>>,
    robots: Output<MarkerArray>,
    routes: Output<MarkerArray>,
    contacts: Output<MarkerArray>,
    ports: Option<Ports>,
    origin: [f64; 2],
    /// The points of each edge, on the map.
    edges: Vec<Vec<Point>>,
    robot_types: Vec<RobotTypeRecord>,
    /// The robots that are drawn.
    chosen: Vec<u32>,
    /// The types of all robots, as far as they are known.
    types: Vec<usize>,
    /// The chosen robots and their types, as last published.
    shown: Vec<(u32, usize)>,
    routes_published: Instant,
}

impl Scene {
    pub fn open(link: &mut Link, namespace: &Namespace) -> Result<Self, LinkError> {
        let bytes = POINTS * POINT_BYTES;
        Ok(Self {
            namespace: namespace.clone(),
            graph: Vec::new(),
            robots: link.output("robots", Keep::Newest, bytes)?,
            routes: link.output("routes", Keep::Nothing, bytes)?,
            contacts: link.output("contacts", Keep::Nothing, bytes)?,
            ports: None,
            origin: [0.0; 2],
            edges: Vec::new(),
            robot_types: Vec::new(),
            chosen: Vec::new(),
            types: Vec::new(),
            shown: Vec::new(),
            routes_published: Instant::now(),
        })
    }

    pub fn join(&mut self, fleet: &Participant) -> Result {
        self.ports = Some(Ports {
            routes: RouteClient::open_on(fleet)?,
            contacts: ContactReader::open_on(fleet)?,
            types: ColumnReader::open_on(fleet, column::TYPE.name())?,
        });
        Ok(())
    }

    /// Draws a robot.
    pub fn choose(&mut self, robot: u32) {
        self.chosen.push(robot);
    }

    /// Publishes the graph of a world.
    pub fn take_world(&mut self, world: &World<'_>, link: &mut Link) -> Result<(), LinkError> {
        self.origin = world.origin();
        self.robot_types = world.robot_types().to_vec();
        self.shown.clear();
        self.edges.clear();
        for edge in world.edges() {
            self.edges.push(polyline(world.curves(edge), self.origin));
        }
        let segments = self.edges.iter().flat_map(|points| points.windows(2));
        let ends = segments.flat_map(|pair| [pair[0].clone(), pair[1].clone()]);
        let ends: Vec<Point> = ends.collect();
        let parts = ends.chunks(POINTS).map(<[Point]>::to_vec);
        // Topics beyond those of a graph that has shrunk get an empty message.
        let parts = parts.chain(std::iter::repeat(Vec::new()));
        let topics = ends.len().div_ceil(POINTS).max(self.graph.len());
        for (number, points) in parts.take(topics).enumerate() {
            self.publish_graph(number, points, link)?;
        }
        if self.graph.len() > 1 {
            let last = self.graph.len() - 1;
            tell!(
                "ros2: DDS loses larger messages: the topics of the graph are graph to graph_{last}"
            );
        }
        Ok(())
    }

    fn publish_graph(
        &mut self,
        number: usize,
        points: Vec<Point>,
        link: &mut Link,
    ) -> Result<(), LinkError> {
        if number == self.graph.len() {
            let name = if number == 0 { "graph".to_owned() } else { format!("graph_{number}") };
            self.graph.push(link.output(&name, Keep::Newest, POINTS * POINT_BYTES)?);
        }
        let mut markers = vec![clear(Time::default())];
        if !points.is_empty() {
            let header = Header::new(&Time::default(), MAP);
            let graph = line(shape::LINE_LIST, points, 0.05, GRAPH_COLOUR);
            markers.push(Marker { header, ns: "graph".to_owned(), ..graph });
        }
        self.graph[number].publish(MarkerArray { markers });
        Ok(())
    }

    /// Publishes what changes with a frame.
    pub fn publish(&mut self, snapshot: &Snapshot) -> Result {
        let Some(mut ports) = self.ports.take() else { return Ok(()) };
        let outcome = self.publish_by(snapshot, &mut ports);
        self.ports = Some(ports);
        outcome
    }

    fn publish_by(&mut self, snapshot: &Snapshot, ports: &mut Ports) -> Result {
        ports.types.latest()?;
        if let Some(types) = ports.types.current()? {
            self.types.clear();
            self.types.extend(types.values.iter().map(|kind| *kind as usize));
        }
        self.publish_robots(snapshot);
        self.publish_contacts(snapshot, &mut ports.contacts)?;
        if self.routes_published.elapsed() >= ROUTES_EVERY {
            self.routes_published = Instant::now();
            self.publish_routes(snapshot, &mut ports.routes);
        }
        Ok(())
    }

    /// Publishes the shapes of the chosen robots if they are others than before: they move with
    /// their frames.
    fn publish_robots(&mut self, snapshot: &Snapshot) {
        let there = self.chosen.iter().filter(|robot| snapshot.robot(**robot).is_some());
        let kind = |robot: &u32| self.types.get(*robot as usize).copied().unwrap_or_default();
        let shown: Vec<_> = there.map(|robot| (*robot, kind(robot))).collect();
        if shown == self.shown {
            return;
        }
        let mut markers = vec![clear(Time::default())];
        for (robot, kind) in &shown {
            let Some(kind) = self.robot_types.get(*kind) else { continue };
            markers.push(Marker {
                header: Header::new(&Time::default(), &self.namespace.frame_of(*robot)),
                id: *robot as i32,
                ..body(kind)
            });
        }
        self.robots.publish(MarkerArray { markers });
        self.shown = shown;
    }

    fn publish_contacts(&mut self, snapshot: &Snapshot, contacts: &mut ContactReader) -> Result {
        let Some(found) = contacts.latest()? else { return Ok(()) };
        let mut markers = vec![clear(snapshot.stamp())];
        for (pair, id) in found.pairs.iter().zip(0..).take(CONTACTS) {
            let is_touching = pair.level == ContactLevel::Touching as u32;
            let colour = if is_touching { TOUCHING_COLOUR } else { POSSIBLE_COLOUR };
            let [x, y] = [self.origin[0] + f64::from(pair.x), self.origin[1] + f64::from(pair.y)];
            markers.push(Marker {
                header: Header::new(&snapshot.stamp(), MAP),
                ns: if is_touching { "touching" } else { "possible" }.to_owned(),
                id,
                r#type: shape::SPHERE,
                pose: Pose::on_ground(x, y, 0.0),
                scale: Vector3 { x: 0.6, y: 0.6, z: 0.6 },
                color: colour_of(colour),
                ..Marker::default()
            });
        }
        self.contacts.publish(MarkerArray { markers });
        Ok(())
    }

    /// Publishes the routes of the chosen robots, if the producer knows them.
    fn publish_routes(&mut self, snapshot: &Snapshot, routes: &mut RouteClient) {
        if self.chosen.is_empty() || !routes.has_routes() {
            return;
        }
        let Ok(answers) = routes.routes(&self.chosen, ROUTES_TIMEOUT) else { return };
        let mut markers = vec![clear(snapshot.stamp())];
        let mut left = POINTS;
        for answer in answers {
            let Some(robot) = snapshot.robot(answer.robot) else { continue };
            let legs: Vec<_> = answer.legs().collect();
            let (base, horizon) = legs.split_at(legs.iter().filter(|leg| leg.released).count());
            let at = Point { x: robot.x, y: robot.y, z: 0.0 };
            for (legs, ns, colour) in
                [(base, "base", BASE_COLOUR), (horizon, "horizon", HORIZON_COLOUR)]
            {
                let points = self.ahead(legs, &at);
                if points.len() < 2 || points.len() > left {
                    continue;
                }
                left -= points.len();
                markers.push(Marker {
                    header: Header::new(&snapshot.stamp(), MAP),
                    ns: ns.to_owned(),
                    id: answer.robot as i32,
                    ..line(shape::LINE_STRIP, points, 0.15, colour)
                });
            }
        }
        self.routes.publish(MarkerArray { markers });
    }

    /// The points of legs; the first leg begins at the point of it that is nearest to the robot.
    fn ahead(&self, legs: &[LegAhead], robot: &Point) -> Vec<Point> {
        let mut points = Vec::new();
        for (place, leg) in legs.iter().enumerate() {
            let mut leg_points = self.edges.get(leg.edge as usize).cloned().unwrap_or_default();
            if leg.reverse {
                leg_points.reverse();
            }
            if place == 0 {
                let distance = |point: &Point| (point.x - robot.x).hypot(point.y - robot.y);
                let near = leg_points.iter().map(distance).enumerate();
                let near = near.min_by(|one, other| one.1.total_cmp(&other.1));
                leg_points.drain(..near.map_or(0, |(near, _)| near));
            }
            points.extend(leg_points);
        }
        points
    }
}

/// The points of an edge on the map, whose origin the fleet's positions have.
fn polyline(curves: &[CurveRecord], origin: [f64; 2]) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for record in curves {
        let control_points = record.control_points.map(|point| Vec2::from(point).as_dvec2());
        let curve = CubicBezier { control_points };
        let segments = if is_straight(&curve) { 1 } else { SEGMENTS };
        let first = usize::from(!points.is_empty());
        for step in first..=segments {
            let DVec2 { x, y } = curve.position(step as f64 / segments as f64);
            points.push(Point { x: origin[0] + x, y: origin[1] + y, z: 0.0 });
        }
    }
    points
}

/// Whether a curve is within a millimetre or so of its chord.
fn is_straight(curve: &CubicBezier) -> bool {
    let [p0, p1, p2, p3] = curve.control_points;
    let chord = p3 - p0;
    let off_chord = [p1, p2].map(|p| chord.perp_dot(p - p0).abs() / chord.length().max(1e-9));
    chord != DVec2::ZERO && off_chord[0].max(off_chord[1]) < 1e-3
}

fn line(kind: i32, points: Vec<Point>, width: f64, colour: [u8; 3]) -> Marker {
    Marker {
        r#type: kind,
        pose: Pose::on_ground(0.0, 0.0, 0.0),
        scale: Vector3 { x: width, ..Vector3::default() },
        color: colour_of(colour),
        points,
        ..Marker::default()
    }
}

/// The shape of a robot type, half as high as it is wide.
fn body(kind: &RobotTypeRecord) -> Marker {
    let [length, width] = [kind.length, kind.width].map(f64::from);
    let (kind_of_marker, width) = match kind.shape() {
        Shape::Circle => (shape::CYLINDER, length),
        Shape::Rectangle => (shape::CUBE, width),
    };
    let mut pose = Pose::on_ground(0.0, 0.0, 0.0);
    pose.position.z = width / 4.0;
    Marker {
        ns: "robots".to_owned(),
        r#type: kind_of_marker,
        pose,
        scale: Vector3 { x: length, y: width, z: width / 2.0 },
        color: colour_of(Activity::Moving.rgb(Ground::Dark)),
        frame_locked: true,
        ..Marker::default()
    }
}

/// A marker that removes those before.
fn clear(stamp: Time) -> Marker {
    Marker {
        header: Header::new(&stamp, MAP),
        action: DELETE_ALL,
        pose: Pose::on_ground(0.0, 0.0, 0.0),
        ..Marker::default()
    }
}

fn colour_of([r, g, b]: [u8; 3]) -> ColorRGBA {
    let [r, g, b] = [r, g, b].map(|part| f32::from(part) / 255.0);
    ColorRGBA { r, g, b, a: 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_are_points_on_the_map_without_repeats() {
        let straight = CurveRecord::straight([0.0, 0.0], [3.0, 0.0]);
        let bent = CurveRecord { control_points: [[3.0, 0.0], [4.0, 0.0], [5.0, 1.0], [5.0, 2.0]] };
        let points = polyline(&[straight, bent], [100.0, 50.0]);
        assert_eq!(points.len(), 2 + SEGMENTS);
        assert_eq!((points[1].x, points[1].y), (103.0, 50.0));
        assert_eq!(points.last().map(|point| (point.x, point.y)), Some((105.0, 52.0)));
    }

    #[test]
    fn robots_have_the_size_of_their_types() {
        let cart = body(&RobotTypeRecord::new("cart", 1.5, 0.5));
        assert_eq!((cart.r#type, cart.scale.x, cart.scale.y), (shape::CUBE, 1.5, 0.5));
        let round =
            RobotTypeRecord { shape: Shape::Circle as u32, ..RobotTypeRecord::new("r", 0.5, 0.5) };
        let round = body(&round);
        assert_eq!((round.r#type, round.scale.x, round.scale.y), (shape::CYLINDER, 0.5, 0.5));
    }
}
