//! Encodes the fleet and its route graph as Foxglove's messages, which general tools show.

use glam::{DVec2, Vec2};
use prost::Message;
use prost_types::Timestamp;
use regatta_base::bezier::CubicBezier;
use regatta_plugin::activity::{Activity, Ground};
use regatta_plugin::contact::{ContactLevel, ContactRecord};
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::CurveRecord;
use regatta_plugin::{Frame, World};

use crate::schema::FRAME_ID;
use crate::schema::foxglove::{
    Color, LinePrimitive, Log, PackedElementField, Point3, PointCloud, Pose, PosesInFrame,
    Quaternion, SceneEntity, SceneUpdate, SpherePrimitive, TextPrimitive, Vector3, line_primitive,
    log::Level, packed_element_field::NumericType,
};

/// The number of line segments that approximate a curve.
const SEGMENTS: usize = 12;
/// The width of an edge on the screen, in pixels.
const EDGE_PIXELS: f64 = 1.5;
/// The size of the letters of names on the screen, in pixels.
const LETTER_PIXELS: f64 = 12.0;
/// The height of the graph's points, in metres.
const GRAPH_Z: f32 = -0.5;
const WALL_COLOUR: Color = Color { r: 0.35, g: 0.37, b: 0.4, a: 1.0 };
/// The diameter of the marker of a contact, in metres.
const CONTACT_SIZE: f64 = 0.6;
/// The most markers of contacts in a message; pairs that touch come first.
const MOST_CONTACTS: usize = 1_000;
const TOUCHING_COLOUR: Color = Color { r: 0.95, g: 0.15, b: 0.15, a: 0.9 };
const POSSIBLE_COLOUR: Color = Color { r: 0.98, g: 0.75, b: 0.15, a: 0.7 };
const EDGE_COLOUR: Color = Color { r: 0.45, g: 0.55, b: 0.65, a: 1.0 };

/// Encodes the poses of all robots except absent ones, in order of their ids.
pub fn poses(frame: &Frame<'_>, log_time: u64) -> Vec<u8> {
    let columns = frame.columns();
    let rows = columns.x.iter().zip(columns.y).zip(columns.theta).zip(columns.state);
    let poses = rows
        .filter(|(_, state)| RobotState::from_number(**state) != RobotState::Absent)
        .map(|(((x, y), theta), _)| pose(f64::from(*x), f64::from(*y), f64::from(*theta)))
        .collect();
    PosesInFrame { timestamp: Some(timestamp(log_time)), frame_id: FRAME_ID.to_owned(), poses }
        .encode_to_vec()
}

fn pose(x: f64, y: f64, theta: f64) -> Pose {
    let (sine, cosine) = (theta / 2.0).sin_cos();
    Pose {
        position: Some(Vector3 { x, y, z: 0.0 }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine }),
    }
}

/// Encodes the positions of all robots except absent ones, coloured by state.
pub fn robots(frame: &Frame<'_>, log_time: u64) -> Vec<u8> {
    let columns = frame.columns();
    let rows = columns.x.iter().zip(columns.y).zip(columns.state);
    let points = rows.filter_map(|((x, y), state)| {
        Some(([*x, *y, 0.0], colour(RobotState::from_number(*state))?))
    });
    cloud(points, log_time)
}

/// Returns the red, green, blue and alpha of a state's activity, or `None` for an absent robot.
fn colour(state: RobotState) -> Option<[u8; 4]> {
    let [red, green, blue] = Activity::of_state(state)?.rgb(Ground::Dark);
    Some([red, green, blue, 255])
}

/// Encodes points along the route graph, slightly below the robots' points so that they don't cover
/// them.
pub fn graph_points(world: &World<'_>, log_time: u64) -> Vec<u8> {
    let curves = world.edges().iter().flat_map(|edge| world.curves(edge));
    let points = curves.flat_map(|record| curve(&record.control_points));
    let colour = [70, 85, 100, 255];
    cloud(points.map(|point| ([point.x as f32, point.y as f32, GRAPH_Z], colour)), log_time)
}

fn cloud(points: impl Iterator<Item = ([f32; 3], [u8; 4])>, log_time: u64) -> Vec<u8> {
    let data = points.flat_map(|(position, colour)| {
        let [x, y, z] = position.map(f32::to_le_bytes);
        [x, y, z, colour].into_iter().flatten()
    });
    PointCloud {
        timestamp: Some(timestamp(log_time)),
        frame_id: FRAME_ID.to_owned(),
        pose: Some(pose(0.0, 0.0, 0.0)),
        point_stride: 16,
        fields: vec![
            field("x", 0, NumericType::Float32),
            field("y", 4, NumericType::Float32),
            field("z", 8, NumericType::Float32),
            field("red", 12, NumericType::Uint8),
            field("green", 13, NumericType::Uint8),
            field("blue", 14, NumericType::Uint8),
            field("alpha", 15, NumericType::Uint8),
        ],
        data: data.collect(),
    }
    .encode_to_vec()
}

fn field(name: &str, offset: u32, numeric_type: NumericType) -> PackedElementField {
    PackedElementField { name: name.to_owned(), offset, r#type: numeric_type as i32 }
}

/// Encodes walls, the route graph and the names of stations, which replace those of the previous
/// message.
pub fn graph(world: &World<'_>, log_time: u64) -> Vec<u8> {
    let points = world.edges().iter().flat_map(|edge| world.curves(edge)).flat_map(lines).collect();
    let entity = SceneEntity {
        timestamp: Some(timestamp(log_time)),
        frame_id: FRAME_ID.to_owned(),
        id: "graph".to_owned(),
        lines: vec![line_list(walls(world), WALL_COLOUR), line_list(points, EDGE_COLOUR)],
        texts: stations(world),
        ..SceneEntity::default()
    };
    SceneUpdate { entities: vec![entity], ..SceneUpdate::default() }.encode_to_vec()
}

/// Encodes pairs of robots that touch, or may, as spheres, which replace those of the previous
/// message.
pub fn contact_markers(pairs: &[ContactRecord], log_time: u64) -> Vec<u8> {
    let entity = SceneEntity {
        timestamp: Some(timestamp(log_time)),
        frame_id: FRAME_ID.to_owned(),
        id: "contacts".to_owned(),
        spheres: pairs.iter().take(MOST_CONTACTS).map(contact_marker).collect(),
        ..SceneEntity::default()
    };
    SceneUpdate { entities: vec![entity], ..SceneUpdate::default() }.encode_to_vec()
}

fn contact_marker(pair: &ContactRecord) -> SpherePrimitive {
    let is_touching = pair.level == ContactLevel::Touching as u32;
    SpherePrimitive {
        pose: Some(pose(f64::from(pair.x), f64::from(pair.y), 0.0)),
        size: Some(Vector3 { x: CONTACT_SIZE, y: CONTACT_SIZE, z: CONTACT_SIZE }),
        color: Some(if is_touching { TOUCHING_COLOUR } else { POSSIBLE_COLOUR }),
    }
}

/// Encodes an entry of a log. `name` is the part that it comes from.
pub fn log(level: Level, name: &str, message: String, log_time: u64) -> Vec<u8> {
    Log {
        timestamp: Some(timestamp(log_time)),
        level: level as i32,
        message,
        name: name.to_owned(),
        ..Log::default()
    }
    .encode_to_vec()
}

/// Returns lines between pairs of points.
fn line_list(points: Vec<Point3>, colour: Color) -> LinePrimitive {
    LinePrimitive {
        r#type: line_primitive::Type::LineList as i32,
        pose: Some(pose(0.0, 0.0, 0.0)),
        thickness: EDGE_PIXELS,
        scale_invariant: true,
        points,
        color: Some(colour),
        ..LinePrimitive::default()
    }
}

/// Returns the lines of the background as pairs of points.
fn walls(world: &World<'_>) -> Vec<Point3> {
    let lines = world.background_lines().iter().map(|line| world.background_points(line));
    let ends = lines.flat_map(|points| points.windows(2)).flatten();
    let ends = ends.map(|[x, y]| [f64::from(*x), f64::from(*y)]);
    ends.map(|[x, y]| Point3 { x, y, z: 0.0 }).collect()
}

/// Returns the names of the stations.
fn stations(world: &World<'_>) -> Vec<TextPrimitive> {
    let stations = world.stations().iter();
    let texts = stations.map(|station| TextPrimitive {
        pose: Some(pose(f64::from(station.x), f64::from(station.y), 0.0)),
        billboard: true,
        font_size: LETTER_PIXELS,
        scale_invariant: true,
        color: Some(EDGE_COLOUR),
        text: world.text(station.name).to_owned(),
    });
    texts.collect()
}

/// Returns a curve's line segments as pairs of points.
fn lines(curve: &CurveRecord) -> Vec<Point3> {
    let points = polyline(&curve.control_points);
    let ends = points.windows(2).flat_map(|pair| [pair[0], pair[1]]);
    ends.map(|DVec2 { x, y }| Point3 { x, y, z: 0.0 }).collect()
}

/// Returns points on a cubic Bézier curve: the two ends of a straight one, or else
/// `SEGMENTS + 1` points.
fn polyline(control_points: &[[f32; 2]; 4]) -> Vec<DVec2> {
    let [p0, p1, p2, p3] = cubic(control_points).control_points;
    let chord = p3 - p0;
    let off_chord = [p1, p2].map(|p| chord.perp_dot(p - p0).abs() / chord.length().max(1e-9));
    if chord != DVec2::ZERO && off_chord[0].max(off_chord[1]) < 1e-3 {
        return vec![p0, p3];
    }
    curve(control_points).collect()
}

/// Returns `SEGMENTS + 1` points on a cubic Bézier curve.
fn curve(control_points: &[[f32; 2]; 4]) -> impl Iterator<Item = DVec2> + use<> {
    let cubic = cubic(control_points);
    (0..=SEGMENTS).map(move |i| cubic.position(i as f64 / SEGMENTS as f64))
}

fn cubic(control_points: &[[f32; 2]; 4]) -> CubicBezier {
    CubicBezier { control_points: control_points.map(|point| Vec2::from(point).as_dvec2()) }
}

fn timestamp(nanos: u64) -> Timestamp {
    Timestamp { seconds: (nanos / 1_000_000_000) as i64, nanos: (nanos % 1_000_000_000) as i32 }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{StationRecord, WorldData};

    use super::*;

    #[test]
    fn walls_and_the_names_of_stations_are_in_the_scene() {
        let mut data = WorldData::default();
        let name = data.texts.add("dock");
        data.add_station(StationRecord { name, x: 2.0, y: 3.0, ..StationRecord::default() }, []);
        data.add_background_line(0, [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]]);
        let scene = SceneUpdate::decode(&*graph(&data.view(1, 1), 0)).expect("a scene");
        let entity = &scene.entities[0];
        assert_eq!((entity.lines[0].points.len(), entity.lines[1].points.len()), (4, 0));
        assert_eq!(entity.texts[0].text, "dock");
        assert_eq!(entity.texts[0].pose.expect("a pose").position.expect("a place").y, 3.0);
    }

    #[test]
    fn polylines_start_and_end_at_the_ends_of_their_curve() {
        let curve = [[0.0, 0.0], [2.0, 0.0], [4.0, 1.0], [4.0, 4.0]];
        let points = polyline(&curve);
        assert_eq!((points.len(), points[0], points[12]), (13, DVec2::ZERO, DVec2::splat(4.0)));
        let straight = [[1.0, 1.0], [2.0, 2.0], [3.0, 3.0], [4.0, 4.0]];
        assert_eq!(polyline(&straight), [DVec2::ONE, DVec2::splat(4.0)]);
    }
}
