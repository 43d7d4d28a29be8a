//! A list of any length of which only the rows in sight are laid out. Positions are in rows rather
//! than points, so that the millionth row is placed as exactly as the first.

use egui::{Id, Rect, Response, Role, Sense, Ui, pos2, vec2};

use super::style::{ROW, ThemeColours};

/// The width of the scroll bar, in points.
const BAR: f32 = 8.0;
/// The smallest height of the scroll bar's handle, in points.
const MIN_HANDLE: f32 = 24.0;

/// The scroll position of a list.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VirtualList {
    /// The row at the top; its fraction is hidden above.
    pub first: f64,
    /// The number of rows in sight when the list was last shown.
    pub visible: f64,
}

impl VirtualList {
    /// Scrolls down by a number of pages.
    pub fn page(&mut self, pages: f64) {
        self.first += pages * (self.visible - 1.0).max(1.0);
    }

    /// Scrolls to a row unless it is in sight.
    pub fn reveal(&mut self, row: usize) {
        let row = row as f64;
        if row < self.first || row + 1.0 > self.first + self.visible {
            self.first = row - self.visible / 2.0;
        }
    }

    /// Shows the rows in sight in all the space that is left; `row` draws one into its rectangle.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        name: &str,
        colours: &ThemeColours,
        rows: usize,
        mut row: impl FnMut(&mut Ui, Rect, usize),
    ) {
        let (area, _) =
            ui.allocate_exact_size(ui.available_size().max(vec2(40.0, ROW)), Sense::hover());
        let id = Id::unique(name);
        self.visible = f64::from(area.height() / ROW);
        let last = (rows as f64 - self.visible).max(0.0);
        if ui.rect_contains_pointer(area) {
            let wheel = ui.input_mut(|input| std::mem::take(&mut input.smooth_scroll_delta.y));
            self.first -= f64::from(wheel / ROW);
        }
        self.bar(ui, id, area, last, rows as f64, colours);
        self.first = self.first.clamp(0.0, last);
        let inside = Rect::from_min_max(area.min, pos2(area.max.x - BAR - 2.0, area.max.y));
        let mut list = ui.new_child(egui::UiBuilder::new().id_salt(id).max_rect(inside));
        list.set_clip_rect(inside.intersect(ui.clip_rect()));
        let from = self.first.floor();
        let shown = (self.visible.ceil() as usize + 1).min(rows.saturating_sub(from as usize));
        for i in 0..shown {
            let top = inside.top() + ((from + i as f64 - self.first) * f64::from(ROW)) as f32;
            row(
                &mut list,
                Rect::from_min_size(pos2(inside.left(), top), vec2(inside.width(), ROW)),
                from as usize + i,
            );
        }
    }

    /// Shows the scroll bar; `last` is the largest value of `first`.
    fn bar(&mut self, ui: &Ui, id: Id, area: Rect, last: f64, rows: f64, colours: &ThemeColours) {
        if last <= 0.0 {
            return;
        }
        let track = Rect::from_min_max(pos2(area.right() - BAR, area.top()), area.max);
        let length =
            (track.height() * (self.visible / rows) as f32).max(MIN_HANDLE).min(track.height());
        let room = f64::from(track.height() - length).max(1.0);
        let response = ui.interact(track, id.with("bar"), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(Role::ScrollBar, true, "scroll bar"));
        if response.dragged() {
            self.first += f64::from(response.drag_delta().y) / room * last;
        } else if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
            self.first = f64::from(at.y - track.top() - length / 2.0) / room * last;
        }
        let top = track.top() + (self.first.clamp(0.0, last) / last * room) as f32;
        let handle = Rect::from_min_size(pos2(track.left(), top), vec2(BAR, length));
        let colour =
            if response.hovered() || response.dragged() { colours.accent } else { colours.line };
        ui.painter().rect_filled(handle.shrink2(vec2(1.0, 0.0)), BAR / 2.0, colour);
    }
}

/// Makes a row clickable and highlights it if it is selected or hovered; `name` is its accessible
/// name.
pub fn clickable(
    ui: &Ui,
    rect: Rect,
    id: u32,
    selected: bool,
    colours: &ThemeColours,
    name: impl Fn() -> String,
) -> Response {
    let response = ui.interact(rect, ui.scope_id().with(id), Sense::click());
    if selected {
        ui.painter().rect_filled(rect, 4.0, colours.accent.gamma_multiply(0.25));
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 4.0, colours.field);
    }
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, selected, name()));
    response
}
