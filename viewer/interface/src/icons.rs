//! Icons drawn as shapes, so that they do not depend on a font.

use egui::{Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, vec2};

/// An icon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    /// Resume.
    Play,
    /// Pause.
    Pause,
    /// Advance one tick.
    Step,
    /// Go back one frame.
    StepBack,
    /// Go to the next mark.
    NextMark,
    /// Go to the previous mark.
    PreviousMark,
    /// The light theme.
    Sun,
    /// The dark theme.
    Moon,
    /// The largest at the bottom.
    Ascending,
    /// The largest at the top.
    Descending,
}

/// Shows a button with an icon; `name` is its accessible name.
pub fn button(ui: &mut Ui, icon: Icon, name: &str, size: egui::Vec2) -> Response {
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let enabled = ui.is_enabled();
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, name));
    let visuals = ui.style().interact(&response);
    let focus =
        if response.has_focus() { ui.visuals().selection.bg_fill } else { visuals.bg_stroke.color };
    ui.painter().rect(
        rect,
        visuals.corner_radius,
        visuals.weak_bg_fill,
        (1.0, focus),
        egui::StrokeKind::Inside,
    );
    let colour = if enabled { visuals.fg_stroke.color } else { ui.visuals().weak_text_color() };
    draw(ui.painter(), icon, rect.center(), 6.0, colour);
    response
}

/// Draws an icon; `half` is half of its width, in points.
pub fn draw(painter: &Painter, icon: Icon, at: Pos2, half: f32, colour: Color32) {
    match icon {
        Icon::Play => triangle(painter, at, half, colour, [(-0.7, -1.0), (1.0, 0.0), (-0.7, 1.0)]),
        Icon::Pause => {
            for x in [-0.55, 0.55] {
                bar(painter, at + vec2(x, 0.0) * half, 0.6 * half, half, colour);
            }
        }
        Icon::Step => {
            bar(painter, at + vec2(0.8, 0.0) * half, 0.45 * half, half, colour);
            triangle(painter, at, half, colour, [(-1.0, -0.95), (0.4, 0.0), (-1.0, 0.95)]);
        }
        Icon::StepBack => {
            bar(painter, at + vec2(-0.8, 0.0) * half, 0.45 * half, half, colour);
            triangle(painter, at, half, colour, [(1.0, -0.95), (-0.4, 0.0), (1.0, 0.95)]);
        }
        Icon::NextMark => {
            triangle(painter, at, half, colour, [(-1.0, -0.75), (0.1, 0.0), (-1.0, 0.75)]);
            painter.circle_filled(at + vec2(0.75, 0.0) * half, half * 0.4, colour);
        }
        Icon::PreviousMark => {
            triangle(painter, at, half, colour, [(1.0, -0.75), (-0.1, 0.0), (1.0, 0.75)]);
            painter.circle_filled(at - vec2(0.75, 0.0) * half, half * 0.4, colour);
        }
        Icon::Sun => {
            painter.circle_filled(at, half * 0.5, colour);
            for i in 0..8_u8 {
                let ray = egui::Vec2::angled(f32::from(i) * core::f32::consts::FRAC_PI_4);
                painter.line_segment(
                    [at + ray * half * 0.75, at + ray * half * 1.1],
                    Stroke::new(1.2, colour),
                );
            }
        }
        Icon::Moon => {
            // A crescent: an arc of discs that get smaller towards both ends.
            for i in 0..=24_u8 {
                let part = f32::from(i) / 24.0;
                let direction = egui::Vec2::angled(0.9 + part * 4.0);
                painter.circle_filled(
                    at + direction * half * 0.68,
                    half * 0.36 * (part * core::f32::consts::PI).sin(),
                    colour,
                );
            }
        }
        Icon::Ascending => {
            triangle(painter, at, half, colour, [(-1.0, 0.5), (0.0, -0.7), (1.0, 0.5)])
        }
        Icon::Descending => {
            triangle(painter, at, half, colour, [(-1.0, -0.5), (0.0, 0.7), (1.0, -0.5)])
        }
    }
}

/// Draws a triangle by its corners, in halves of the icon's width.
fn triangle(painter: &Painter, at: Pos2, half: f32, colour: Color32, corners: [(f32, f32); 3]) {
    let points = corners.map(|(x, y)| at + vec2(x, y) * half).to_vec();
    painter.add(Shape::convex_polygon(points, colour, Stroke::NONE));
}

/// Draws an upright bar around a point.
fn bar(painter: &Painter, middle: Pos2, width: f32, half: f32, colour: Color32) {
    let size = vec2(width, 2.0 * half);
    painter.rect_filled(Rect::from_center_size(middle, size), 1.0, colour);
}
