//! Signs that are drawn rather than written: no font has to have them.

use egui::{Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2};

/// A sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Icon {
    /// Go on.
    Play,
    /// Stand still.
    Pause,
    /// One tick.
    Step,
    /// The light theme.
    Sun,
    /// The dark theme.
    Moon,
    /// The largest at the bottom.
    Ascending,
    /// The largest at the top.
    Descending,
}

/// A button with a sign; `name` is for those who don't see it.
pub fn button(ui: &mut Ui, icon: Icon, name: &str, size: egui::Vec2) -> Response {
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let enabled = ui.is_enabled();
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, name));
    let look = ui.style().interact(&response);
    let focus = if response.has_focus() { ui.visuals().selection.bg_fill } else { look.bg_stroke.color };
    ui.painter().rect(rect, look.corner_radius, look.weak_bg_fill, (1.0, focus), egui::StrokeKind::Inside);
    let colour = if enabled { look.fg_stroke.color } else { ui.visuals().weak_text_color() };
    draw(ui.painter(), icon, rect.center(), 6.0, colour);
    response
}

/// Draws a sign of so many points from its middle to its side.
pub fn draw(painter: &Painter, icon: Icon, at: Pos2, half: f32, colour: Color32) {
    let triangle = |points: [(f32, f32); 3]| {
        let points = points.map(|(x, y)| at + vec2(x, y) * half).to_vec();
        painter.add(Shape::convex_polygon(points, colour, Stroke::NONE));
    };
    let bar = |x: f32, width: f32| {
        let middle = pos2(at.x + x * half, at.y);
        painter.rect_filled(Rect::from_center_size(middle, vec2(width, 2.0) * half), 1.0, colour);
    };
    match icon {
        Icon::Play => triangle([(-0.7, -1.0), (1.0, 0.0), (-0.7, 1.0)]),
        Icon::Pause => [-0.55, 0.55].into_iter().for_each(|x| bar(x, 0.6)),
        Icon::Step => {
            bar(0.8, 0.45);
            triangle([(-1.0, -0.95), (0.4, 0.0), (-1.0, 0.95)]);
        }
        Icon::Sun => {
            painter.circle_filled(at, half * 0.5, colour);
            for i in 0..8_u8 {
                let ray = egui::Vec2::angled(f32::from(i) * core::f32::consts::FRAC_PI_4);
                painter.line_segment([at + ray * half * 0.75, at + ray * half * 1.1], Stroke::new(1.2, colour));
            }
        }
        Icon::Moon => {
            // A disc with a bite, as a thick arc that gets thinner to its ends.
            for i in 0..=24_u8 {
                let part = f32::from(i) / 24.0;
                let way = egui::Vec2::angled(0.9 + part * 4.0);
                painter.circle_filled(
                    at + way * half * 0.68,
                    half * 0.36 * (part * core::f32::consts::PI).sin(),
                    colour,
                );
            }
        }
        Icon::Ascending => triangle([(-1.0, 0.5), (0.0, -0.7), (1.0, 0.5)]),
        Icon::Descending => triangle([(-1.0, -0.5), (0.0, 0.7), (1.0, -0.5)]),
    }
}
