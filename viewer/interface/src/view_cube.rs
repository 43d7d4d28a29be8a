//! The view cube: shows from which direction the camera looks; a click on one of its sides turns
//! the camera.

use core::f32::consts::{FRAC_PI_2, PI};

use egui::{Align2, Area, FontId, Id, Order, Pos2, Role, Sense, Shape, Stroke, WidgetInfo, vec2};
use glam::Vec3;

use super::context::{PanelContext, Request};
use super::placement::Placement;

/// Width and height in points, and the length of the cube's half edge.
const SIZE: f32 = 74.0;
const HALF: f32 = 20.0;
/// The pitch of views from a side, in radians below the horizon.
const SIDE_PITCH: f32 = 0.35;

/// A side of the cube: its name, the direction that it faces, and the camera's yaw and pitch on a
/// click.
const SIDES: [(&str, Vec3, [f32; 2]); 5] = [
    ("top", Vec3::Z, [FRAC_PI_2, FRAC_PI_2]),
    ("S", Vec3::NEG_Y, [FRAC_PI_2, SIDE_PITCH]),
    ("N", Vec3::Y, [-FRAC_PI_2, SIDE_PITCH]),
    ("E", Vec3::X, [PI, SIDE_PITCH]),
    ("W", Vec3::NEG_X, [0.0, SIDE_PITCH]),
];

/// Shows the cube in the upper right corner; a plan has its arrow to the north there.
pub(super) fn show(context: &PanelContext<'_>, ctx: &egui::Context, placement: &mut Placement) {
    let (camera, room) = (context.camera, placement.room());
    if camera.is_plan() || room.width() < 400.0 || room.height() < 200.0 {
        return;
    }
    let Some(place) = placement.take("view cube", vec2(SIZE, SIZE), Align2::RIGHT_TOP) else {
        return;
    };
    let area = Area::new(Id::unique("view cube"))
        .order(Order::Background)
        .fade_in(false)
        .fixed_pos(place.min);
    let shown = area.show(ctx, |ui| ui.allocate_exact_size(vec2(SIZE, SIZE), Sense::click()));
    let (place, response) = shown.inner;
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, "view cube"));
    let (right, up, back) = (camera.right(), camera.up(), -camera.forward());
    let at = |point: Vec3| place.center() + vec2(point.dot(right), -point.dot(up)) * HALF;
    let (colours, painter) = (context.colours, ctx.layer_painter(shown.response.layer_id));
    let hovered = response.hover_pos();
    for (name, normal, view) in SIDES.into_iter().filter(|(_, normal, _)| normal.dot(back) > 0.02) {
        let across = if normal == Vec3::Z { Vec3::X } else { Vec3::Z.cross(normal) };
        let along = normal.cross(across);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| at(normal + across * x + along * y));
        let is_hovered = hovered.is_some_and(|pointer| contains(&corners, pointer));
        let fill = if is_hovered {
            colours.accent.gamma_multiply(0.6)
        } else {
            colours.panel.gamma_multiply(0.9)
        };
        painter.add(Shape::convex_polygon(corners.to_vec(), fill, Stroke::new(1.2, colours.faint)));
        let area = shoelace(&corners).abs();
        if area > HALF * HALF * 0.8 {
            painter.text(
                at(normal),
                Align2::CENTER_CENTER,
                name,
                FontId::proportional(12.0),
                colours.text,
            );
        }
        if is_hovered && response.clicked() {
            let [yaw, pitch] = view;
            context.ask(Request::Look { yaw, pitch });
        }
    }
}

fn shoelace(corners: &[Pos2; 4]) -> f32 {
    (0..4)
        .map(|i| corners[i].x * corners[(i + 1) % 4].y - corners[(i + 1) % 4].x * corners[i].y)
        .sum::<f32>()
        / 2.0
}

/// Whether a convex polygon, in either direction, contains a point.
fn contains(corners: &[Pos2; 4], point: Pos2) -> bool {
    let signs = [0, 1, 2, 3].map(|i: usize| {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        (to.x - from.x) * (point.y - from.y) - (to.y - from.y) * (point.x - from.x) >= 0.0
    });
    signs.iter().all(|sign| *sign) || signs.iter().all(|sign| !sign)
}
