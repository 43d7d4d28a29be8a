//! The minimap: the whole graph, small, and the part of it that the picture shows. A click moves the camera there.

use egui::{Area, Color32, Context, Id, Order, Pos2, Rect, Sense, Shape, Stroke, vec2};
use glam::Vec2;
use regatta_plugin::World;

use super::state::Interface;
use super::style;
use super::view_model::ViewModel;
use crate::camera::Bounds;
use crate::curves::curve_point;

/// The most edges that are drawn; of more, some are left out.
const MAX_EDGES: usize = 3000;
/// The longest side of the map, in points.
const SIDE: f32 = 170.0;

/// The lines of a route graph.
#[derive(Clone, Debug, Default)]
pub struct Minimap {
    /// The counts of nodes and edges, and the run of the world that the lines are of.
    source: Option<(usize, usize, u64)>,
    lines: Vec<[Vec2; 2]>,
}

impl Minimap {
    /// Takes the lines of a world if it is another one; `run` is its run.
    fn update(&mut self, world: &World<'_>, run: u64) {
        let source = Some((world.nodes().len(), world.edges().len(), run));
        if self.source == source {
            return;
        }
        self.source = source;
        let step = world.edges().len().div_ceil(MAX_EDGES).max(1);
        let lines = world.edges().iter().step_by(step).flat_map(|edge| world.curves(edge)).flat_map(|curve| {
            // The more edges there are, the smaller is each.
            let parts = if world.edges().len() < 500 { 8_u8 } else { 2 };
            let point = move |part: u8| curve_point(curve, f32::from(part) / f32::from(parts));
            (0..parts).map(move |part| [point(part), point(part + 1)])
        });
        self.lines = lines.collect();
    }
}

impl Interface {
    /// Shows the minimap in the upper left corner.
    pub(super) fn minimap(&mut self, context: &Context, picture: Rect, visible: Rect, model: &ViewModel<'_>) {
        if !self.settings.minimap || visible.width() < 2.0 * SIDE || visible.height() < 1.5 * SIDE {
            return;
        }
        self.minimap.update(&model.world, model.frame.map_or(0, |frame| frame.run_id()));
        let (bounds, offset) = (model.bounds, Vec2::from(self.settings.offset));
        let extent = (bounds.high - bounds.low).max(Vec2::splat(1.0));
        let scale = (SIDE / extent.x).min(SIDE / extent.y);
        let size = vec2(extent.x * scale, extent.y * scale);
        let theme = self.settings.theme();
        let area = Area::new(Id::unique("minimap")).order(Order::Background).fade_in(false);
        let corner =
            visible.left_top() + vec2(if self.camera_controller.camera().is_plan() { 60.0 } else { 10.0 }, 30.0);
        let shown = area.fixed_pos(corner).show(context, |ui| {
            let frame = style::floating(theme).inner_margin(egui::Margin::same(5));
            frame.show(ui, |ui| ui.allocate_exact_size(size, Sense::click_and_drag())).inner
        });
        let (place, response) = shown.inner;
        let at = |point: Vec2| {
            Pos2::new(
                place.left() + (point.x - bounds.low.x) * scale,
                place.bottom() - (point.y - bounds.low.y) * scale,
            )
        };
        let painter = context.layer_painter(shown.response.layer_id).with_clip_rect(place.expand(2.0));
        let colours = self.colours();
        for [from, to] in &self.minimap.lines {
            painter.line_segment(
                [at(*from + offset), at(*to + offset)],
                Stroke::new(1.0, colours.faint.gamma_multiply(0.7)),
            );
        }
        if let Some(seen) = self.seen_ground(picture, visible, bounds) {
            painter.add(Shape::closed_line(seen.map(at).to_vec(), Stroke::new(1.5, colours.accent)));
            painter.add(Shape::convex_polygon(
                seen.map(at).to_vec(),
                colours.accent.gamma_multiply(0.12),
                Stroke::NONE,
            ));
        }
        for robot in self.robots().iter().filter_map(|id| model.pose(*id, offset)) {
            painter.circle(at(robot.place), 3.0, colours.text, Stroke::new(1.0, Color32::BLACK));
        }
        if let Some(to) = response.interact_pointer_pos().filter(|_| response.clicked() || response.dragged()) {
            let to = Vec2::new((to.x - place.left()) / scale, (place.bottom() - to.y) / scale) + bounds.low;
            self.camera_controller.move_to(to);
        }
    }

    /// Returns the corners of the ground in sight; what lies beyond the horizon is cut far away.
    fn seen_ground(&self, picture: Rect, visible: Rect, bounds: Bounds) -> Option<[Vec2; 4]> {
        let (camera, size) = (self.camera_controller.camera(), Vec2::new(picture.width(), picture.height()));
        let far = (bounds.high - bounds.low).length() * 2.0 + camera.distance.min(1000.0);
        let corners = [visible.left_top(), visible.right_top(), visible.right_bottom(), visible.left_bottom()];
        let ground = |at: Pos2| {
            let pixel = Vec2::new(at.x - picture.left(), at.y - picture.top());
            let seen = camera
                .unproject(pixel, size)
                .filter(|seen| camera.is_plan() || seen.distance(camera.eye().truncate()) < far);
            seen.unwrap_or_else(|| {
                camera.eye().truncate() + camera.ray(pixel, size).truncate().normalize_or_zero() * far
            })
        };
        size.is_finite().then(|| corners.map(ground))
    }
}
