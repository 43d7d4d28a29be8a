//! The annotations of a plan: coordinates along the grid, a scale bar, and an arrow to the north.

use egui::{Align2, Context, FontId, LayerId, Painter, Pos2, Rect, Shape, Stroke, pos2, vec2};
use glam::Vec2;
use regatta_base::round;
use regatta_scene::camera::Camera;
use regatta_scene::palette::Theme;

use super::legend::LEGEND;
use super::placement::Placement;
use super::style::{self, ThemeColours};

/// The least distance between two labels of the grid, in points.
const LABEL_POINTS: f32 = 90.0;
/// The least and the greatest length of the scale bar are some 60 and 150 points.
const BAR_POINTS: f32 = 150.0;
/// The width beside the scale bar, into which the texts of its ends reach, in points.
const BAR_MARGIN: f32 = 22.0;
/// The least size of a picture with a scale bar and an arrow to the north, in points.
const WITH_SCALE: egui::Vec2 = vec2(300.0, 200.0);
/// The width and height of the arrow to the north with its letter, in points.
const NORTH: f32 = 76.0;

/// Returns the largest of 1, 2 and 5 times a power of ten that is not above `limit`.
pub fn round_step(limit: f32) -> f32 {
    // A limit that is a round number, but for its precision, is its own step.
    round::down(limit.max(1e-6) * (1.0 + f32::EPSILON)) as f32
}

/// Formats metres without digits that they don't need.
pub fn metres_text(metres: f32) -> String {
    match metres.abs() {
        long if long >= 10_000.0 => format!("{} km", metres / 1000.0),
        short if short > 0.0 && short < 0.995 => format!("{} cm", (metres * 100.0).round()),
        // To the millimetre: a multiple of a step has rounding errors.
        _ => format!("{} m", (f64::from(metres) * 1e3).round() / 1e3),
    }
}

/// The room that coordinates take at the left and at the upper side, in points.
const RULERS: egui::Vec2 = vec2(50.0, 22.0);

/// The height of a number of an axis, in points.
const AXIS_NUMBER: f32 = 14.0;

/// The places of the scale bar and of the arrow to the north, as far as there is room for them.
#[derive(Clone, Copy, Debug)]
pub struct PlanScale {
    bar: Option<Rect>,
    north: Option<Rect>,
}

impl PlanScale {
    /// Takes the places of both in a picture, whose part `clip` is visible. A small picture has no
    /// room for them.
    pub fn place(placement: &mut Placement, picture: Rect, clip: Rect, camera: &Camera) -> Self {
        if clip.width() < WITH_SCALE.x || clip.height() < WITH_SCALE.y {
            return Self { bar: None, north: None };
        }
        let per_point = camera.metres_per_pixel(picture.height());
        let bar = vec2(round_step(BAR_POINTS * per_point) / per_point + 2.0 * BAR_MARGIN, 36.0);
        // The legend is on the left, so that the middle of the rest is right of the middle.
        let left = placement
            .place_of(LEGEND)
            .map_or(clip.left(), |legend| legend.right())
            .max(clip.left());
        let bar =
            Rect::from_center_size(pos2((left + clip.right()) / 2.0, clip.bottom() - 22.0), bar);
        let bar = placement.take_near("scale bar", bar.translate(vec2(0.0, -6.0)));
        let north =
            Rect::from_center_size(clip.right_top() + vec2(-50.0, 70.0), vec2(NORTH, NORTH));
        Self { bar, north: placement.take_near("north", north) }
    }

    /// Draws both, and coordinates along the sides, except under other elements.
    pub fn draw(
        self,
        context: &Context,
        placement: &Placement,
        picture: Rect,
        clip: Rect,
        camera: &Camera,
        theme: Theme,
    ) {
        let painter = context.layer_painter(LayerId::background()).with_clip_rect(clip);
        let colours = style::colours(theme);
        coordinates(&painter, placement, (picture, clip), camera, &colours);
        if let Some(place) = self.bar {
            scale_bar(&painter, place, camera.metres_per_pixel(picture.height()), &colours);
        }
        if let Some(place) = self.north {
            north(&painter, place.center(), camera.yaw, &colours);
        }
    }
}

/// The part of a plan beside the coordinates along its sides.
pub(super) fn within_rulers(clip: Rect) -> Rect {
    Rect::from_min_max(clip.min + RULERS, clip.max)
}

/// Writes x along the upper side and y along the left side, at round distances, where north is up.
fn coordinates(
    painter: &Painter,
    placement: &Placement,
    (picture, clip): (Rect, Rect),
    camera: &Camera,
    colours: &ThemeColours,
) {
    if (camera.yaw - core::f32::consts::FRAC_PI_2).abs() > 1e-3 {
        return;
    }
    let size = Vec2::new(picture.width(), picture.height());
    let [Some(low), Some(high)] = [clip.left_bottom(), clip.right_top()]
        .map(|at| camera.unproject(Vec2::new(at.x - picture.left(), at.y - picture.top()), size))
    else {
        return;
    };
    let per_point = camera.metres_per_pixel(picture.height());
    let step = round_step(LABEL_POINTS * 2.2 * per_point);
    let place =
        |x: f32, y: f32| camera.project(glam::Vec3::new(x, y, 0.0), size).unwrap_or_default();
    let tick =
        |from: Pos2, to: Pos2| painter.line_segment([from, to], Stroke::new(1.0, colours.faint));
    let write = |at: Pos2, align: Align2, text: String| {
        let text = painter.layout_no_wrap(text, FontId::monospace(10.0), colours.text);
        let rect = align.anchor_size(at, text.size());
        if !placement.is_clear(rect) {
            return;
        }
        painter.rect_filled(rect.expand(1.5), 2.0, colours.panel.gamma_multiply(0.75));
        painter.galley(rect.min, text, colours.text);
    };
    let (first, last) = ((low / step).ceil().as_ivec2(), (high / step).floor().as_ivec2());
    for i in first.x..=last.x.min(first.x + 100) {
        let x = i as f32 * step;
        let at = picture.left() + place(x, high.y).x;
        // The corner is that of both axes.
        if at < clip.left() + 60.0 || at > clip.right() - 24.0 {
            continue;
        }
        tick(pos2(at, clip.top()), pos2(at, clip.top() + 6.0));
        write(pos2(at, clip.top() + 8.0), Align2::CENTER_TOP, metres_text(x));
    }
    for i in first.y..=last.y.min(first.y + 100) {
        let y = i as f32 * step;
        let at = picture.top() + place(low.x, y).y;
        if at < clip.top() + 26.0 || at > clip.bottom() - 8.0 {
            continue;
        }
        let left = beside(placement, clip.left(), at);
        tick(pos2(left, at), pos2(left + 6.0, at));
        write(pos2(left + 9.0, at), Align2::LEFT_CENTER, metres_text(y));
    }
}

/// Returns where the axis of y is at a height: at the left side, or beside the legend there.
fn beside(placement: &Placement, left: f32, at: f32) -> f32 {
    let number = Rect::from_center_size(pos2(left, at), vec2(2.0 * RULERS.x, AXIS_NUMBER));
    let legend = placement.place_of(LEGEND).filter(|legend| legend.intersects(number));
    legend.map_or(left, |legend| legend.right())
}

/// Draws the scale bar.
fn scale_bar(painter: &Painter, back: Rect, per_point: f32, colours: &ThemeColours) {
    let metres = round_step(BAR_POINTS * per_point);
    let width = metres / per_point;
    let left = back.min + vec2(BAR_MARGIN, 22.0);
    painter.rect_filled(back, 5.0, colours.panel.gamma_multiply(0.85));
    for part in 0..4_u8 {
        let from = left + vec2(width * f32::from(part) / 4.0, 0.0);
        let fill = if part % 2 == 0 { colours.text } else { colours.panel };
        let rect = Rect::from_min_size(from, vec2(width / 4.0, 6.0));
        painter.rect(rect, 0.0, fill, Stroke::new(1.0, colours.text), egui::StrokeKind::Middle);
    }
    for (x, text) in [(0.0, "0".to_owned()), (width, metres_text(metres))] {
        let at = left + vec2(x, -3.0);
        painter.text(at, Align2::CENTER_BOTTOM, text, FontId::monospace(11.0), colours.text);
    }
}

/// Draws an arrow to the north; `yaw` is the heading of the picture's upper side.
fn north(painter: &Painter, at: Pos2, yaw: f32, colours: &ThemeColours) {
    // The direction of north in the picture, whose y goes down.
    let angle = yaw - core::f32::consts::FRAC_PI_2;
    let up = vec2(angle.sin(), -angle.cos());
    let side = vec2(-up.y, up.x);
    painter.circle_filled(at, 24.0, colours.panel.gamma_multiply(0.85));
    for (sign, fill) in [(-1.0, colours.text), (1.0, colours.panel)] {
        let points = vec![at + up * 15.0, at + side * sign * 7.0 - up * 9.0, at - up * 4.0];
        painter.add(Shape::convex_polygon(points, fill, Stroke::new(1.0, colours.text)));
    }
    painter.text(
        at + up * 30.0,
        Align2::CENTER_CENTER,
        "N",
        FontId::proportional(13.0),
        colours.text,
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axis_of_y_makes_room_for_the_legend() {
        let mut placement = Placement::new(Rect::from_min_size(Pos2::ZERO, vec2(800.0, 600.0)));
        assert_eq!(beside(&placement, 0.0, 500.0), 0.0, "no legend");
        let legend = placement.take(LEGEND, vec2(90.0, 200.0), Align2::LEFT_BOTTOM);
        let legend = legend.expect("room");
        assert_eq!(beside(&placement, 0.0, 500.0), legend.right());
        assert_eq!(beside(&placement, 0.0, 100.0), 0.0, "above the legend");
        assert_eq!(beside(&placement, 0.0, legend.top() - 4.0), legend.right(), "half of a number");
    }

    #[test]
    fn steps_are_round_and_texts_short() {
        for (limit, step) in
            [(0.3, 0.2), (1.0, 1.0), (4.99, 2.0), (7.0, 5.0), (230.0, 200.0), (9_999.0, 5_000.0)]
        {
            assert!(
                (round_step(limit) - step).abs() < step * 1e-4,
                "{limit}: {}",
                round_step(limit)
            );
        }
        for (metres, text) in [
            (0.0, "0 m"),
            (0.2, "20 cm"),
            (-5.0, "-5 m"),
            (200.0, "200 m"),
            (36.899_998, "36.9 m"),
            (20_000.0, "20 km"),
        ] {
            assert_eq!(metres_text(metres), text);
        }
    }
}
