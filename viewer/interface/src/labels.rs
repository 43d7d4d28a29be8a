//! The names of stations, doors and lifts, drawn beside them as far as there is room, and the names
//! or ids of nodes and edges where the camera is near enough.

use std::cmp::Ordering;
use std::collections::{BTreeSet, HashSet};

use egui::{Align, Align2, Context, FontId, LayerId, Pos2, Rect, pos2};
use glam::Vec2;
use regatta_plugin::World;
use regatta_scene::camera::{Bounds, Camera};
use regatta_scene::curves::midpoint;
use regatta_scene::is_on_level;
use regatta_scene::names::{Name, names};
use regatta_scene::palette::Theme;
use regatta_scene::stations::{is_station, served};

use super::placement::Placement;
use super::plan::within_rulers;
use super::robot_spots::Spot;
use super::style;

/// Points per metre of the picture from which ids are drawn, and all names for which there is room.
const NEAR: f32 = 32.0;
/// The size of the letters of names, in points.
const NAME: f32 = 11.0;
/// The part of the scale at which a name has room on one side from which on it is tried.
const EARLIER: f32 = 0.25;
/// The size of the digits of ids, in points.
const ID: f32 = 9.5;
/// The largest number of labels in a picture.
const MAX_LABELS: usize = 240;
/// Width and height of a cell of the picture, in points. Two ids are never in the same cell nor in
/// neighbouring cells of a row.
const CELL: Vec2 = Vec2::new(30.0, 15.0);

/// The labels of a route graph, by the scales from which they are drawn.
#[derive(Debug, Default)]
pub struct Labels(Vec<Band>);

/// The labels that are drawn from a scale on.
#[derive(Debug)]
struct Band {
    points_per_metre: f32,
    /// Sorted from west to east.
    labels: Vec<Label>,
}

/// The kinds of labels; the last are drawn first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Edge,
    Node,
    /// A station, a door or a lift.
    Station,
}

impl Kind {
    /// The places of a label beside what has it, at `at`: the first one with room is taken. They are
    /// right and left of the badge, of the node, or of the arrow in the middle of the edge; a name of
    /// a station may also lie below, or in the middle above or below it.
    fn sides(self, at: Pos2, size: egui::Vec2) -> Vec<Rect> {
        let (gap, down, anchors) = match self {
            Self::Station => (14.0, 10.0, &STATION_SIDES[..]),
            Self::Node => (5.0, 5.0, &[Align2::LEFT_BOTTOM, Align2::RIGHT_BOTTOM][..]),
            Self::Edge => (6.0, 6.0, &[Align2::LEFT_TOP, Align2::RIGHT_TOP][..]),
        };
        let beside = |anchor: &Align2| {
            let x = -anchor.x().to_sign() * gap;
            let y = match anchor.y() {
                // In the middle, the badge lies between.
                Align::Min if x == 0.0 => gap,
                Align::Max if x == 0.0 => -gap,
                y => -y.to_sign() * down,
            };
            anchor.anchor_size(at + egui::vec2(x, y), size)
        };
        anchors.iter().map(beside).collect()
    }
}

/// The sides of a station on which its name may lie, by the corner or side of the name that is
/// nearest to it; the best first.
const STATION_SIDES: [Align2; 8] = [
    Align2::LEFT_BOTTOM,
    Align2::LEFT_TOP,
    Align2::RIGHT_BOTTOM,
    Align2::RIGHT_TOP,
    Align2::LEFT_CENTER,
    Align2::RIGHT_CENTER,
    Align2::CENTER_BOTTOM,
    Align2::CENTER_TOP,
];

/// The picture over which labels are drawn.
#[derive(Clone, Copy, Debug)]
pub struct LabelView<'a> {
    /// The place of the picture, in points.
    pub picture: Rect,
    /// Its camera.
    pub camera: &'a Camera,
    /// The offset of all positions, in metres.
    pub offset: Vec2,
    /// The theme.
    pub theme: Theme,
    /// The robots in the picture.
    pub robots: &'a [Spot],
    /// The elements that lie over the picture.
    pub placement: &'a Placement,
}

/// Returns the distance from the eye up to which ids are drawn in a picture of `size` points;
/// `None` if the camera is farther away from the ground than that.
pub(super) fn reach(camera: &Camera, size: Vec2) -> Option<f32> {
    reach_of(NEAR, camera, size)
}

/// Returns the distance from the eye up to which a metre has so many points.
fn reach_of(points_per_metre: f32, camera: &Camera, size: Vec2) -> Option<f32> {
    let reach = camera.pixels_per_radian(size.y) / points_per_metre;
    (camera.eye().z < reach && size.min_element() > 0.0).then_some(reach)
}

/// Returns a rectangle of the ground with all places in a picture up to a distance from the eye.
pub(super) fn ground_in_sight(camera: &Camera, size: Vec2, reach: f32) -> Bounds {
    let eye = camera.eye().truncate();
    let corners = [Vec2::ZERO, Vec2::new(size.x, 0.0), Vec2::new(0.0, size.y), size];
    let ground: Option<Vec<Vec2>> =
        corners.into_iter().map(|corner| camera.unproject(corner, size)).collect();
    let around = Bounds { low: eye - reach, high: eye + reach };
    ground.and_then(Bounds::from_points).map_or(around, |seen| Bounds {
        low: seen.low.max(around.low),
        high: seen.high.min(around.high),
    })
}

#[derive(Clone, Debug, PartialEq)]
struct Label {
    place: Vec2,
    id: u32,
    kind: Kind,
    /// The name; `None` for the id.
    name: Option<Box<str>>,
}

/// The least distance of a label from the end of the picture, in points.
const BORDER: f32 = 4.0;

impl Labels {
    /// Collects the labels of a route graph, or of one of its levels.
    pub fn new(world: &World<'_>, level: Option<&str>) -> Self {
        let mut bands: Vec<Band> = Vec::new();
        for Name { text, place, scale } in names(world, level) {
            // Names have room on several sides: they are tried earlier than at the scale at which
            // all have room on the same side.
            let points_per_metre = (scale * NAME * EARLIER).min(NEAR);
            if bands.last().is_none_or(|band| band.points_per_metre < points_per_metre) {
                bands.push(Band { points_per_metre, labels: Vec::new() });
            }
            if let Some(band) = bands.last_mut() {
                band.labels.push(Label { place, id: 0, kind: Kind::Station, name: Some(text) });
            }
        }
        bands.push(Band { points_per_metre: NEAR, labels: ids(world, level) });
        for band in &mut bands {
            band.labels.sort_by(|a, b| a.place.x.total_cmp(&b.place.x));
        }
        Self(bands)
    }

    /// Draws names and ids over a picture, of which `clip` is in sight. Where space is short, names
    /// precede nodes, these edges, and near ones far ones. None covers a robot, another label or an
    /// element over the picture, and none is cut.
    pub fn draw(&self, context: &Context, clip: Rect, view: &LabelView<'_>) {
        let LabelView { picture, camera, offset, theme, robots, placement } = *view;
        let clip = if camera.is_plan() { within_rulers(clip) } else { clip.shrink(BORDER) };
        let painter = context.layer_painter(LayerId::background()).with_clip_rect(clip);
        let colours = style::colours(theme);
        let mut drawn: Vec<Rect> = Vec::new();
        for (label, at) in
            self.visible(camera, offset, Vec2::new(picture.width(), picture.height()))
        {
            // Ids of robots are framed; those of the graph are small and faint digits on the floor.
            let (colour, font) = match (&label.name, label.kind) {
                (None, _) => (colours.faint, FontId::proportional(ID)),
                (_, Kind::Edge) => {
                    (colours.text.gamma_multiply(0.8), FontId::proportional(NAME - 1.0))
                }
                _ => (colours.text, FontId::proportional(NAME)),
            };
            let galley = painter.layout_no_wrap(label.text(), font, colour);
            let at = picture.min + egui::vec2(at.x, at.y);
            let has_room = |text: &Rect| {
                let covers_robot = robots.iter().any(|spot| {
                    let middle = picture.min + egui::vec2(spot.at.x, spot.at.y);
                    text.distance_sq_to_pos(middle) < spot.radius * spot.radius
                });
                let is_clear = clip.contains_rect(*text) && placement.is_clear(*text);
                is_clear && !covers_robot && !drawn.iter().any(|other| other.intersects(*text))
            };
            let sides = label.kind.sides(at, galley.size());
            let Some(text) = sides.into_iter().find(has_room) else { continue };
            drawn.push(text);
            painter.rect_filled(
                text.expand2(egui::vec2(3.0, 0.0)),
                3.0,
                colours.panel.gamma_multiply(0.6),
            );
            painter.galley(text.min, galley, colour);
        }
    }

    /// Draws the ids of some robots above them.
    pub fn draw_robots(
        context: &Context,
        picture: Rect,
        clip: Rect,
        camera: &Camera,
        theme: Theme,
        robots: impl IntoIterator<Item = (u32, Vec2)>,
    ) {
        let painter = context.layer_painter(LayerId::background()).with_clip_rect(clip);
        let colours = style::colours(theme);
        for (id, place) in robots {
            let Some(at) =
                camera.project(place.extend(0.4), Vec2::new(picture.width(), picture.height()))
            else {
                continue;
            };
            let galley = painter.layout_no_wrap(
                format!("robot {id}"),
                FontId::proportional(12.0),
                colours.text,
            );
            let above = pos2(picture.left() + at.x, picture.top() + at.y - 14.0);
            let text = Align2::CENTER_BOTTOM.anchor_size(above, galley.size());
            painter.rect_filled(
                text.expand2(egui::vec2(5.0, 2.0)),
                4.0,
                colours.panel.gamma_multiply(0.85),
            );
            painter.galley(text.min, galley, colours.text);
        }
    }

    /// Returns the labels to draw and their places in a picture of this size, in points.
    fn visible(&self, camera: &Camera, offset: Vec2, size: Vec2) -> Vec<(&Label, Vec2)> {
        let mut near = Vec::new();
        for band in &self.0 {
            band.find(camera, offset, size, &mut near);
        }
        near.sort_by(Found::compare);
        let mut taken = HashSet::new();
        let mut visible = Vec::new();
        for Found { label, at, .. } in near {
            // Of several sides, one may have room: that is seen when it is drawn.
            if label.kind == Kind::Station {
                visible.push((label, at));
                continue;
            }
            let (cell, cells) = ((at / CELL).floor().as_ivec2(), label.cells());
            if (-1..=cells).all(|step| !taken.contains(&(cell.x + step, cell.y))) {
                taken.extend((0..cells).map(|step| (cell.x + step, cell.y)));
                visible.push((label, at));
            }
            if visible.len() == MAX_LABELS {
                break;
            }
        }
        visible
    }
}

/// A label in a picture.
struct Found<'a> {
    /// The scale from which it is drawn.
    points_per_metre: f32,
    /// Metres from the eye.
    far: f32,
    label: &'a Label,
    /// Its place in the picture.
    at: Vec2,
}

impl Found<'_> {
    /// Names come before nodes, these before edges, names that are drawn from a smaller scale on
    /// before others, and near labels before far ones.
    fn compare(&self, other: &Self) -> Ordering {
        (other.label.kind.cmp(&self.label.kind))
            .then(self.points_per_metre.total_cmp(&other.points_per_metre))
            .then(self.far.total_cmp(&other.far))
    }
}

impl Band {
    /// Adds the labels in a picture.
    fn find<'a>(&'a self, camera: &Camera, offset: Vec2, size: Vec2, found: &mut Vec<Found<'a>>) {
        let Some(reach) = reach_of(self.points_per_metre, camera, size) else { return };
        let ground = ground_in_sight(camera, size, reach);
        let (west, east) = (ground.low.x - offset.x, ground.high.x - offset.x);
        let first = self.labels.partition_point(|label| label.place.x < west);
        for label in self.labels[first..].iter().take_while(|label| label.place.x <= east) {
            let place = (label.place + offset).extend(0.0);
            let far = place.distance(camera.eye());
            if let Some(at) = camera.project(place, size)
                && far < reach
                && at.cmpge(Vec2::ZERO).all()
                && at.cmple(size).all()
            {
                found.push(Found { points_per_metre: self.points_per_metre, far, label, at });
            }
        }
    }
}

/// Returns the names, or else the ids, of edges and of nodes that are no stations.
fn ids(world: &World<'_>, level: Option<&str>) -> Vec<Label> {
    let served = served(world);
    let nodes = world.nodes().iter().zip(0..);
    let nodes = nodes.filter(|(node, index)| !is_station(node, *index, &served));
    let nodes = nodes.map(|(node, _)| node).filter(|node| is_on_level(world, node.level, level));
    let nodes = nodes.map(|node| Label {
        place: Vec2::new(node.x, node.y),
        id: node.id,
        kind: Kind::Node,
        name: named(world.text(node.name)),
    });
    let edges = world.edges().iter().filter(|edge| is_on_level(world, edge.level, level));
    let edges = edges.filter_map(|edge| {
        let place = midpoint(world, edge)?;
        Some(Label { place, id: edge.id, kind: Kind::Edge, name: named(world.text(edge.name)) })
    });
    nodes.chain(edges).collect()
}

fn named(name: &str) -> Option<Box<str>> {
    (!name.is_empty()).then(|| name.into())
}

impl Label {
    fn text(&self) -> String {
        self.name.as_deref().map_or_else(|| self.id.to_string(), str::to_owned)
    }

    /// The number of cells that the text takes; a letter takes some six points.
    fn cells(&self) -> i32 {
        let letters = self.name.as_deref().map_or(0, |name| name.chars().count());
        (letters as f32 * 6.0 / CELL.x).ceil().max(1.0) as i32
    }
}

/// Returns the names of a world's levels.
pub fn levels(world: &World<'_>) -> Vec<String> {
    let all = world
        .nodes()
        .iter()
        .map(|node| node.level)
        .chain(world.edges().iter().map(|edge| edge.level));
    let offsets: BTreeSet<u32> = all.collect();
    let names: BTreeSet<&str> = offsets.into_iter().map(|offset| world.text(offset)).collect();
    names.into_iter().filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests;
