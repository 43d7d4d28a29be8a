//! A list of any length of which only the rows in sight are made. It counts in rows rather than points, so that the
//! millionth row stands as exactly as the first.

use egui::{Id, Rect, Response, Sense, Ui, pos2, vec2};

use super::style::{ROW, Tones};

/// Width of the bar on the right, in points.
const BAR: f32 = 8.0;
/// Least height of its handle.
const HANDLE: f32 = 24.0;

/// Where a list is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scroll {
    /// The row at the top, and the part of it that is above.
    pub first: f64,
    /// Rows in sight when it was shown last.
    pub visible: f64,
}

impl Scroll {
    /// Goes so many pages on.
    pub fn page(&mut self, pages: f64) {
        self.first += pages * (self.visible - 1.0).max(1.0);
    }

    /// Brings a row into sight.
    pub fn reveal(&mut self, row: usize) {
        let row = row as f64;
        if row < self.first || row + 1.0 > self.first + self.visible {
            self.first = row - self.visible / 2.0;
        }
    }

    /// Shows the rows that are in sight in all the room that is left: `row` draws one into its rectangle.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        name: &str,
        tones: &Tones,
        rows: usize,
        mut row: impl FnMut(&mut Ui, Rect, usize),
    ) {
        let (area, _) = ui.allocate_exact_size(ui.available_size().max(vec2(40.0, ROW)), Sense::hover());
        let id = Id::unique(name);
        self.visible = f64::from(area.height() / ROW);
        let most = (rows as f64 - self.visible).max(0.0);
        if ui.rect_contains_pointer(area) {
            let wheel = ui.input_mut(|input| std::mem::take(&mut input.smooth_scroll_delta.y));
            self.first -= f64::from(wheel / ROW);
        }
        self.bar(ui, id, area, most, rows as f64, tones);
        self.first = self.first.clamp(0.0, most);
        let inside = Rect::from_min_max(area.min, pos2(area.max.x - BAR - 2.0, area.max.y));
        let mut list = ui.new_child(egui::UiBuilder::new().id_salt(id).max_rect(inside));
        list.set_clip_rect(inside.intersect(ui.clip_rect()));
        let from = self.first.floor();
        let shown = (self.visible.ceil() as usize + 1).min(rows.saturating_sub(from as usize));
        for i in 0..shown {
            let top = inside.top() + ((from + i as f64 - self.first) * f64::from(ROW)) as f32;
            row(&mut list, Rect::from_min_size(pos2(inside.left(), top), vec2(inside.width(), ROW)), from as usize + i);
        }
    }

    fn bar(&mut self, ui: &Ui, id: Id, area: Rect, most: f64, rows: f64, tones: &Tones) {
        if most <= 0.0 {
            return;
        }
        let track = Rect::from_min_max(pos2(area.right() - BAR, area.top()), area.max);
        let length = (track.height() * (self.visible / rows) as f32).max(HANDLE).min(track.height());
        let room = f64::from(track.height() - length).max(1.0);
        let response = ui.interact(track, id.with("bar"), Sense::click_and_drag());
        if response.dragged() {
            self.first += f64::from(response.drag_delta().y) / room * most;
        } else if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
            self.first = f64::from(at.y - track.top() - length / 2.0) / room * most;
        }
        let top = track.top() + (self.first.clamp(0.0, most) / most * room) as f32;
        let handle = Rect::from_min_size(pos2(track.left(), top), vec2(BAR, length));
        let colour = if response.hovered() || response.dragged() { tones.accent } else { tones.line };
        ui.painter().rect_filled(handle.shrink2(vec2(1.0, 0.0)), BAR / 2.0, colour);
    }
}

/// A row that can be clicked, with the look of one that is chosen or pointed at.
pub fn clickable(ui: &Ui, rect: Rect, id: u32, chosen: bool, tones: &Tones, name: impl Fn() -> String) -> Response {
    let response = ui.interact(rect, ui.scope_id().with(id), Sense::click());
    if chosen {
        ui.painter().rect_filled(rect, 4.0, tones.accent.gamma_multiply(0.25));
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 4.0, tones.field);
    }
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, chosen, name()));
    response
}
