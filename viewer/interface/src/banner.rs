//! The annotations of a picture or a film: a title, the simulated time, and a scale.

use egui::{Align2, Context, FontId, Rect, RichText, Stroke, vec2};
use glam::Vec2;
use regatta_base::round;
use regatta_scene::camera::Camera;
use regatta_scene::palette::Theme;

use super::overlay::float;
use super::placement::Placement;
use super::style;
use super::transport::clock_text;

/// The length of the scale's bar in points: from this one up to two and a half times as much.
const SHORTEST_BAR: f32 = 70.0;
/// The width that is kept for the clock beside a title, in points, with its margins.
const CLOCK_ROOM: f32 = 150.0;
/// The least width of a title, in points.
const SHORTEST_TITLE: f32 = 80.0;

/// The parts that are shown.
#[derive(Clone, Debug, Default)]
pub struct Banner {
    /// A text at the top.
    pub title: Option<String>,
    /// Simulated seconds.
    pub clock: Option<f64>,
    /// Whether a bar tells the scale.
    pub scale: bool,
}

impl Banner {
    /// Shows the parts over a picture. Returns the names of those that it has no room for.
    pub fn show(
        &self,
        context: &Context,
        picture: Rect,
        placement: &mut Placement,
        camera: &Camera,
        theme: Theme,
    ) -> Vec<&'static str> {
        let mut left_out = Vec::new();
        if let Some(seconds) = self.clock {
            let is_shown = float(context, placement, theme, "clock", Align2::RIGHT_TOP, |ui| {
                ui.add(
                    egui::Label::new(RichText::new(clock_text(seconds)).monospace().size(18.0))
                        .extend(),
                );
            });
            left_out.extend((!is_shown).then_some("clock"));
        }
        if let Some(title) = &self.title {
            let is_shown = float(context, placement, theme, "title", Align2::CENTER_TOP, |ui| {
                // Cut with an ellipsis where the clock would be, on the right as on the left.
                ui.set_max_width((picture.width() - 2.0 * CLOCK_ROOM).max(SHORTEST_TITLE));
                ui.add(egui::Label::new(RichText::new(title).size(22.0).strong()).truncate());
            });
            left_out.extend((!is_shown).then_some("title"));
        }
        let metre = points_per_metre(camera, Vec2::new(picture.width(), picture.height()));
        if let Some(metre) = metre.filter(|_| self.scale) {
            left_out.extend((!scale(context, placement, metre, theme)).then_some("scale"));
        }
        left_out
    }
}

/// Shows a bar with its length on the ground, at the middle of the picture; `metre` is the length
/// of a metre there, in points. Returns whether there is room for it.
fn scale(context: &Context, placement: &mut Placement, metre: f32, theme: Theme) -> bool {
    let metres = round::up(SHORTEST_BAR / metre) as f32;
    let colours = style::colours(theme);
    float(context, placement, theme, "scale", Align2::RIGHT_BOTTOM, |ui| {
        let (rect, _) = ui.allocate_exact_size(vec2(metres * metre, 20.0), egui::Sense::hover());
        let (painter, stroke) = (ui.painter(), Stroke::new(2.0, colours.text));
        painter.hline(rect.x_range(), rect.bottom() - 3.0, stroke);
        for x in [rect.left(), rect.right()] {
            painter.vline(x, rect.bottom() - 7.0..=rect.bottom(), stroke);
        }
        let text = if metres < 1.0 {
            format!("{:.0} cm", metres * 100.0)
        } else {
            format!("{metres:.0} m")
        };
        let font = FontId::proportional(12.0);
        painter.text(rect.center_top(), Align2::CENTER_TOP, text, font, colours.text);
    })
}

/// The length of a metre to the right at the camera's target, in points.
fn points_per_metre(camera: &Camera, size: Vec2) -> Option<f32> {
    let (target, right) = (camera.target, camera.target + camera.right());
    let length = (camera.project(right, size)? - camera.project(target, size)?).length();
    (length.is_finite() && length > 1e-6).then_some(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_metre_is_shorter_from_farther_away() {
        let camera = Camera { distance: 10.0, pitch: 1.0, ..Camera::default() };
        let size = Vec2::new(1920.0, 1080.0);
        let near = points_per_metre(&camera, size).expect("in sight");
        let far = points_per_metre(&Camera { distance: 20.0, ..camera }, size).expect("in sight");
        assert!((near / far - 2.0).abs() < 0.05, "{near} {far}");
    }

    #[test]
    fn a_long_title_ends_before_the_clock() {
        for width in [640.0, 1280.0] {
            let (context, picture) =
                (Context::default(), Rect::from_min_size(egui::Pos2::ZERO, vec2(width, 400.0)));
            let title = Some(
                "The whole plant with its three halls and its yard, on the first day of the trial "
                    .repeat(2),
            );
            let banner = Banner { title, clock: Some(36_000.0), scale: false };
            let mut placement = Placement::new(picture);
            let input = egui::RawInput { screen_rect: Some(picture), ..egui::RawInput::default() };
            let show = |ui: &mut egui::Ui| {
                placement = Placement::new(picture);
                banner.show(ui.ctx(), picture, &mut placement, &Camera::default(), Theme::Dark);
            };
            context.run_ui(input, show).textures_delta.clear();
            let place = |name: &str| placement.place_of(name).expect("shown");
            let (title, clock) = (place("title"), place("clock"));
            assert!(title.width() > 200.0 && title.right() < clock.left(), "{title} {clock}");
        }
    }
}
