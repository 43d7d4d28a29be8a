//! The minimap: the whole graph, small, and the part of it that the picture shows. A click moves
//! the camera there.

use std::sync::Arc;

use egui::epaint::Tessellator;
use egui::{Area, Color32, Id, Mesh, Order, Pos2, Rect, Sense, Shape, Stroke, vec2};
use glam::Vec2;
use regatta_plugin::World;
use regatta_scene::background::walls;
use regatta_scene::camera::{Bounds, Camera};
use regatta_scene::curves::curve_point;

use super::context::{PanelContext, Request};
use super::levels::PictureArea;
use super::placement::Placement;
use super::style;

/// The maximum number of drawn edges. Further edges are left out.
const MAX_EDGES: usize = 3000;
/// The same of the lines of walls.
const MAX_WALLS: usize = 3000;
/// The longest side of the map, in points.
const SIDE: f32 = 170.0;
/// The distance from the map to its frame, in points.
const PADDING: i8 = 5;
/// The width of the frame on both sides together, in points.
const FRAME: f32 = 2.0 * (PADDING as f32 + 1.0);

/// The lines of a route graph.
#[derive(Clone, Debug, Default)]
pub(super) struct Minimap {
    /// The counts of nodes and edges, and the run of the world that the lines are of.
    source: Option<(usize, usize, u64)>,
    lines: Vec<[Vec2; 2]>,
    drawn: Option<(Drawn, Arc<Mesh>)>,
}

/// The values that the triangles depend on, beside the lines.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Drawn {
    /// The place of the map, in points.
    place: Rect,
    /// The lower left corner of the map in metres, without the offset.
    low: Vec2,
    /// Points per metre.
    scale: f32,
    colour: Color32,
    pixels_per_point: f32,
}

impl Minimap {
    /// Returns the triangles of all lines. They are made once, until the map is elsewhere or shows
    /// another world.
    fn mesh(&mut self, ctx: &egui::Context, drawn: Drawn) -> Arc<Mesh> {
        if let Some((_, mesh)) = self.drawn.as_ref().filter(|(known, _)| *known == drawn) {
            return Arc::clone(mesh);
        }
        let options = ctx.tessellation_options(|options| *options);
        // Lines need no texture, so its size is of no importance.
        let mut tessellator = Tessellator::new(drawn.pixels_per_point, options, [1, 1], Vec::new());
        let mut mesh = Mesh::default();
        for line in &self.lines {
            let ends = line.map(|end| drawn.at(end));
            let shape = Shape::line_segment(ends, Stroke::new(1.0, drawn.colour));
            tessellator.tessellate_shape(shape, &mut mesh);
        }
        let mesh = Arc::new(mesh);
        self.drawn = Some((drawn, Arc::clone(&mesh)));
        mesh
    }

    /// Takes the lines of a world if it is another one; `run` is its run.
    fn update(&mut self, world: &World<'_>, run: u64) {
        let source = Some((world.nodes().len(), world.edges().len(), run));
        if self.source == source {
            return;
        }
        (self.source, self.drawn) = (source, None);
        let step = world.edges().len().div_ceil(MAX_EDGES).max(1);
        let lines =
            world.edges().iter().step_by(step).flat_map(|edge| world.curves(edge)).flat_map(
                |curve| {
                    // The more edges there are, the smaller is each.
                    let parts = if world.edges().len() < 500 { 8_u8 } else { 2 };
                    let point =
                        move |part: u8| curve_point(curve, f32::from(part) / f32::from(parts));
                    (0..parts).map(move |part| [point(part), point(part + 1)])
                },
            );
        self.lines = lines.collect();
        let walls = walls(world, None);
        let step = walls.len().div_ceil(MAX_WALLS).max(1);
        self.lines.extend(walls.iter().step_by(step).map(|wall| wall.ends));
    }
}

impl Drawn {
    fn at(&self, point: Vec2) -> Pos2 {
        let at = (point - self.low) * self.scale;
        Pos2::new(self.place.left() + at.x, self.place.bottom() - at.y)
    }
}

impl Minimap {
    /// Shows the minimap in the upper left corner.
    pub fn show(
        &mut self,
        context: &PanelContext<'_>,
        ctx: &egui::Context,
        area: PictureArea,
        placement: &mut Placement,
    ) {
        let whole = area.whole;
        if whole.width() < 2.0 * SIDE || whole.height() < 1.5 * SIDE {
            return;
        }
        let model = context.model;
        self.update(&model.world, model.frame.map_or(0, |frame| frame.run_id()));
        let (bounds, offset) = (model.bounds, context.offset);
        let extent = (bounds.high - bounds.low).max(Vec2::splat(1.0));
        let scale = (SIDE / extent.x).min(SIDE / extent.y);
        let size = vec2(extent.x * scale, extent.y * scale);
        let floating = Area::new(Id::unique("minimap")).order(Order::Background).fade_in(false);
        // A plan has its coordinates at the sides.
        let corner =
            whole.left_top() + vec2(if context.camera.is_plan() { 60.0 } else { 10.0 }, 30.0);
        let framed = Rect::from_min_size(corner, size + vec2(FRAME, FRAME));
        let Some(place) = placement.take_near("minimap", framed) else { return };
        let shown = floating.fixed_pos(place.min).show(ctx, |ui| {
            let frame = style::floating(context.theme).inner_margin(egui::Margin::same(PADDING));
            frame.show(ui, |ui| ui.allocate_exact_size(size, Sense::click_and_drag())).inner
        });
        let (place, response) = shown.inner;
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "minimap"));
        let at = |point: Vec2| {
            Pos2::new(
                place.left() + (point.x - bounds.low.x) * scale,
                place.bottom() - (point.y - bounds.low.y) * scale,
            )
        };
        let painter = ctx.layer_painter(shown.response.layer_id).with_clip_rect(place.expand(2.0));
        let colours = context.colours;
        let drawn = Drawn {
            place,
            low: bounds.low - offset,
            scale,
            colour: colours.faint.gamma_multiply(0.7),
            pixels_per_point: ctx.pixels_per_point(),
        };
        painter.add(Shape::Mesh(self.mesh(ctx, drawn)));
        if let Some(seen) = seen_ground(&context.camera, area, bounds) {
            painter
                .add(Shape::closed_line(seen.map(at).to_vec(), Stroke::new(1.5, colours.accent)));
            painter.add(Shape::convex_polygon(
                seen.map(at).to_vec(),
                colours.accent.gamma_multiply(0.12),
                Stroke::NONE,
            ));
        }
        for robot in
            context.selection.robots().iter().filter_map(|id| context.model.pose(*id, offset))
        {
            painter.circle(at(robot.place), 3.0, colours.text, Stroke::new(1.0, Color32::BLACK));
        }
        if let Some(to) =
            response.interact_pointer_pos().filter(|_| response.clicked() || response.dragged())
        {
            let to = Vec2::new((to.x - place.left()) / scale, (place.bottom() - to.y) / scale)
                + bounds.low;
            context.ask(Request::MoveTo(to));
        }
    }
}

/// Returns the corners of the ground in sight; what lies beyond the horizon is cut far away.
fn seen_ground(camera: &Camera, area: PictureArea, bounds: Bounds) -> Option<[Vec2; 4]> {
    let (PictureArea { picture, visible, .. }, size) = (area, area.size());
    let far = (bounds.high - bounds.low).length() * 2.0 + camera.distance.min(1000.0);
    let corners =
        [visible.left_top(), visible.right_top(), visible.right_bottom(), visible.left_bottom()];
    if !size.is_finite() {
        return None;
    }
    Some(corners.map(|at| {
        let pixel = Vec2::new(at.x - picture.left(), at.y - picture.top());
        let seen = camera
            .unproject(pixel, size)
            .filter(|seen| camera.is_plan() || seen.distance(camera.eye().truncate()) < far);
        seen.unwrap_or_else(|| {
            camera.eye().truncate() + camera.ray(pixel, size).truncate().normalize_or_zero() * far
        })
    }))
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{CurveRecord, EdgeRecord, WorldData};

    use egui::Context;

    use super::*;

    #[test]
    fn lines_are_made_into_triangles_once_and_anew_where_the_map_is_elsewhere() {
        let mut world = WorldData::default();
        world.add_edge(EdgeRecord::default(), [CurveRecord::straight([0.0, 0.0], [10.0, 0.0])]);
        let (context, mut minimap) = (Context::default(), Minimap::default());
        minimap.update(&world.view(1, 1), 1);
        let place = Rect::from_min_size(Pos2::new(20.0, 30.0), vec2(170.0, 90.0));
        let drawn = Drawn {
            place,
            low: Vec2::ZERO,
            scale: 10.0,
            colour: Color32::WHITE,
            pixels_per_point: 1.0,
        };
        let first = minimap.mesh(&context, drawn);
        assert!(Arc::ptr_eq(&first, &minimap.mesh(&context, drawn)), "the same triangles");
        let bounds = first.calc_bounds();
        assert!(
            (bounds.left() - 20.0).abs() < 2.0 && (bounds.right() - 120.0).abs() < 2.0,
            "{bounds:?}"
        );
        assert!((bounds.center().y - 120.0).abs() < 1.0, "the south is below: {bounds:?}");
        let moved =
            minimap.mesh(&context, Drawn { place: place.translate(vec2(50.0, 0.0)), ..drawn });
        assert!((moved.calc_bounds().left() - 70.0).abs() < 2.0);
        world.add_edge(EdgeRecord::default(), [CurveRecord::straight([0.0, 0.0], [0.0, 10.0])]);
        minimap.update(&world.view(1, 2), 1);
        assert!(
            minimap.mesh(&context, drawn).vertices.len() > first.vertices.len(),
            "another world"
        );
    }
}
