//! An entry of a legend: a symbol and its meaning, which no end of a line parts.

use egui::{FontId, Rect, Role, Sense, Ui, Vec2, WidgetInfo, pos2, vec2};

use super::style;

/// The size of the letters, in points.
const LETTER: f32 = 12.0;
/// The space between the symbol and its meaning, in points.
const GAP: f32 = 8.0;

/// Shows the meaning of a symbol, which is cut with an ellipsis where the room is too narrow.
/// Returns the place for the symbol.
pub fn show(ui: &mut Ui, symbol: Vec2, meaning: &str) -> Rect {
    let room = ui.max_rect().width() - symbol.x - GAP;
    let colour = style::colours_of(ui.ctx()).faint;
    let text =
        style::one_line(ui, &style::unbroken(meaning), room, FontId::proportional(LETTER), colour);
    let size = vec2(symbol.x + GAP + text.size().x, symbol.y.max(text.size().y));
    let (place, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, style::unbroken(meaning)));
    let left = pos2(place.left() + symbol.x + GAP, place.center().y - 0.5 * text.size().y);
    ui.painter().galley(left, text, colour);
    let corner = pos2(place.left(), place.center().y - 0.5 * symbol.y);
    Rect::from_min_size(corner, symbol)
}
