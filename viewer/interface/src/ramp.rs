//! A ramp of colours with numbers under their places.

use egui::{Align2, FontId, Rect, Sense, Ui, pos2, vec2};
use regatta_scene::palette::{Rgb, Theme};

use super::style::{self, color32};
use crate::text::thousands;

/// The width of a ramp in points.
const WIDTH: f32 = 168.0;

/// Shows a ramp. `numbers` are texts and their places, from 0 at the left end to 1 at the right
/// one.
pub fn show(ui: &mut Ui, theme: Theme, colours: &[Rgb], numbers: &[(f32, String)]) {
    let (area, _) = ui.allocate_exact_size(vec2(WIDTH, 25.0), Sense::hover());
    let width = area.width() / colours.len() as f32;
    for (i, colour) in colours.iter().enumerate() {
        let left = area.left() + i as f32 * width;
        let part = Rect::from_min_size(pos2(left, area.top()), vec2(width + 0.5, 10.0));
        ui.painter().rect_filled(part, 0.0, color32(*colour));
    }
    let faint = style::colours(theme).faint;
    for (place, text) in numbers {
        let x = area.left() + place * area.width();
        ui.painter().vline(
            x.clamp(area.left() + 0.5, area.right() - 0.5),
            area.top() + 10.0..=area.top() + 13.0,
            (1.0, faint),
        );
        // The outermost numbers stay within the ramp.
        let align = match *place {
            0.0 => Align2::LEFT_TOP,
            1.0 => Align2::RIGHT_TOP,
            _ => Align2::CENTER_TOP,
        };
        ui.painter().text(
            pos2(x, area.top() + 13.0),
            align,
            text,
            FontId::proportional(11.0),
            faint,
        );
    }
}

/// Returns the numbers of a ramp between two ends: both, and the middle.
pub fn numbers(low: f32, high: f32) -> Vec<(f32, String)> {
    [0.0, 0.5, 1.0].map(|place| (place, short(low + (high - low) * place))).to_vec()
}

/// Formats a number with about three digits, with commas between thousands.
pub fn short(value: f32) -> String {
    let text = match value.abs() {
        large if large >= 999.5 => {
            let sign = if value < 0.0 { "-" } else { "" };
            return format!("{sign}{}", thousands(large.round() as u64));
        }
        large if large >= 99.95 => format!("{value:.0}"),
        middling if middling >= 9.995 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    };
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_under_their_places() {
        assert_eq!(
            [0.0, 0.05, 12.5, 99.96, 999.6, 1200.0, -5_000_000.0, -0.4].map(short),
            ["0", "0.05", "12.5", "100", "1,000", "1,200", "-5,000,000", "-0.4"]
        );
        let wanted =
            [(0.0, "100"), (0.5, "50"), (1.0, "0")].map(|(place, text)| (place, text.to_owned()));
        assert_eq!(numbers(100.0, 0.0), wanted);
    }
}
