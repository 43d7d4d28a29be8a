//! The places of robots in a picture, for their ids; no id of a node or an edge covers a robot.
//!
//! They are found only in pictures that are near enough for ids, in one pass over the columns x and
//! y. Nothing else of the interface looks at all robots.

use std::collections::BTreeSet;

use egui::{Align2, Context, FontId, LayerId, Rect, pos2};
use glam::Vec2;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::Shape;
use regatta_plugin::{Frame, World};
use regatta_scene::camera::{Bounds, Camera};
use regatta_scene::palette::Theme;

use super::labels::{ground_in_sight, reach};
use super::placement::Placement;
use super::style;

/// The maximum number of robots that are found.
const MAX_SPOTS: usize = 1024;
/// The height at which ids are drawn over robots, in metres.
const ID_HEIGHT: f32 = 0.4;

/// A robot in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The robot.
    pub id: u32,
    /// The robot's place in the picture, in points from its top left.
    pub at: Vec2,
    /// The radius of a circle around the robot, in points.
    pub radius: f32,
}

/// Returns the radius of a circle around the largest robot type, in metres.
pub fn radius(world: &World<'_>) -> f32 {
    let radii = world.robot_types().iter().map(|robot_type| match robot_type.shape() {
        Shape::Circle => robot_type.length / 2.0,
        Shape::Rectangle => Vec2::new(robot_type.length, robot_type.width).length() / 2.0,
    });
    radii.filter(|radius| radius.is_finite()).reduce(f32::max).unwrap_or(0.5)
}

/// Finds the robots of a picture of `size` points, of which ids could be read; of one level only if
/// it is given.
pub fn find(
    frame: &Frame<'_>,
    world: &World<'_>,
    level: Option<&str>,
    camera: &Camera,
    offset: Vec2,
    size: Vec2,
) -> Vec<Spot> {
    let radius = radius(world);
    let Some(near) = near_bounds(camera, size, radius) else { return Vec::new() };
    let (low, high) = (near.low - offset, near.high - offset);
    let mut spots = Vec::new();
    for (row, (&x, &y)) in frame.x().iter().zip(frame.y()).enumerate() {
        let is_near = x >= low.x && x <= high.x && y >= low.y && y <= high.y;
        if !is_near
            || frame.state_of(row) == RobotState::Absent
            || level.is_some_and(|level| !is_on(level, frame.edge()[row], world))
        {
            continue;
        }
        let place = (Vec2::new(x, y) + offset).extend(ID_HEIGHT);
        let Some(at) = camera.project(place, size) else { continue };
        if !(at.cmpge(Vec2::ZERO).all() && at.cmple(size).all()) {
            continue;
        }
        let depth = (place - camera.eye()).dot(camera.forward());
        let radius = radius * camera.pixels_per_radian(size.y) / depth.max(0.1);
        spots.push(Spot { id: row as u32, at, radius });
        if spots.len() == MAX_SPOTS {
            break;
        }
    }
    spots
}

/// Whether an edge is on a level.
fn is_on(level: &str, edge: u32, world: &World<'_>) -> bool {
    world.edges().get(edge as usize).is_some_and(|edge| world.text(edge.level) == level)
}

/// Returns a rectangle of the ground that has all robots whose ids could be read; `None` if the
/// camera is too far away.
fn near_bounds(camera: &Camera, size: Vec2, radius: f32) -> Option<Bounds> {
    let seen = ground_in_sight(camera, size, reach(camera, size)?);
    Some(Bounds { low: seen.low - radius, high: seen.high + radius })
}

/// Draws the ids of robots over them, in a look that ids of nodes and edges don't have. Where they
/// are dense, some are left out, and so are those that would lie under an element over the picture
/// or beyond its end.
pub fn draw(
    context: &Context,
    clip: Rect,
    picture: Rect,
    theme: Theme,
    spots: &[Spot],
    placement: &Placement,
) {
    let painter = context.layer_painter(LayerId::background()).with_clip_rect(clip);
    let colours = style::colours(theme);
    let mut taken = BTreeSet::new();
    for spot in spots {
        let text =
            painter.layout_no_wrap(spot.id.to_string(), FontId::monospace(11.0), colours.panel);
        let at = pos2(picture.left() + spot.at.x, picture.top() + spot.at.y);
        let place =
            Align2::CENTER_CENTER.anchor_size(at, text.size()).expand2(egui::vec2(4.0, 1.0));
        let has_room = clip.contains_rect(place) && placement.is_clear(place);
        if !has_room || cells(place).any(|cell| taken.contains(&cell)) {
            continue;
        }
        taken.extend(cells(place));
        painter.rect_filled(place, 6.0, colours.text);
        painter.galley(place.min + egui::vec2(4.0, 1.0), text, colours.panel);
    }
}

/// Returns the cells of a grid that a rectangle covers.
fn cells(rect: Rect) -> impl Iterator<Item = (i32, i32)> {
    let (low, high) = ((rect.min / 12.0).floor(), (rect.max / 12.0).floor());
    let columns = low.x as i32..=high.x as i32;
    columns.flat_map(move |x| (low.y as i32..=high.y as i32).map(move |y| (x, y)))
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};
    use regatta_plugin::world::{EdgeRecord, WorldData};

    use super::*;

    #[test]
    fn robots_of_another_level_and_on_no_edge_have_no_ids() {
        let mut world = WorldData::default();
        for name in ["cellar", "ground"] {
            let level = world.texts.add(name);
            world.add_edge(EdgeRecord { level, ..EdgeRecord::default() }, []);
        }
        let mut lines = vec![Line::default(); frame_lines(3)];
        let columns = ColumnsMut::split(&mut lines, 3);
        for (robot, edge) in [0, 1, u32::MAX].into_iter().enumerate() {
            (columns.x[robot], columns.edge[robot]) = (robot as f32, edge);
            columns.state[robot] = RobotState::Driving as u8;
        }
        let header = FrameHeader {
            robots: 3,
            stride_lines: stride_lines(3) as u32,
            ..FrameHeader::default()
        };
        let frame = Frame::new(&header, &lines).expect("a frame");
        let camera = Camera::plan_around(Vec2::ZERO, 10.0);
        let ids = |level| {
            let spots = find(
                &frame,
                &world.view(1, 1),
                level,
                &camera,
                Vec2::ZERO,
                Vec2::new(800.0, 600.0),
            );
            spots.iter().map(|spot| spot.id).collect::<Vec<_>>()
        };
        assert_eq!(ids(None), [0, 1, 2]);
        assert_eq!(ids(Some("cellar")), [0]);
        assert_eq!(ids(Some("ground")), [1]);
    }
}
