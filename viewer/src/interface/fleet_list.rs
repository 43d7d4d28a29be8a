//! The fleet panel: a list of all robots with `id x y theta`, sortable and searchable.

use egui::{Align2, FontId, Key, Modifiers, Rect, Sense, Ui, pos2, vec2};
use regatta_plugin::frame::{Frame, RobotState};

use super::icons::{self, Icon};
use super::rows::{RowQuery, SortBy, state_name};
use super::state::Interface;
use super::style::{self, ThemeColours, thousands};
use super::view_model::{Action, Item, ViewModel};
use super::virtual_list::clickable;

/// The columns: title, sort key, and right edge as a fraction of the width.
const COLUMNS: [(&str, SortBy, f32); 4] =
    [("id", SortBy::Id, 0.24), ("x", SortBy::X, 0.50), ("y", SortBy::Y, 0.76), ("θ", SortBy::Theta, 0.97)];

impl Interface {
    pub(super) fn fleet_list(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let before = self.fleet_list.query.clone();
        self.filter(ui, model, actions);
        self.search(ui, model);
        let colours = self.colours();
        header(ui, &mut self.fleet_list.query, &colours);
        if self.fleet_list.query != before {
            self.fleet_list.list.first = 0.0;
            actions.push(Action::Rows(self.fleet_list.query.clone()));
        }
        let Some(frame) = model.frame else {
            ui.label(style::faint(ui, self.settings.theme(), "no robots yet"));
            return;
        };
        let query = self.fleet_list.query.clone();
        let rows = model.rows.filter(|rows| rows.query == query && !query.is_plain());
        let count = rows.map_or(frame.len(), |rows| rows.ids.len());
        let id_of = |row: usize| match rows {
            Some(rows) => rows.ids[row],
            None if query.descending => (frame.len() - 1 - row) as u32,
            None => row as u32,
        };
        let (selected, offset) = (self.robots(), self.settings.offset);
        let mut clicked = None;
        self.fleet_list.list.show(ui, "fleet list", &colours, count, |ui, rect, row| {
            let id = id_of(row);
            let is_selected = selected.contains(&id);
            let response = clickable(ui, rect, id, is_selected, &colours, || format!("robot {id}"));
            if response.clicked() || response.double_clicked() {
                clicked = Some((id, response.double_clicked()));
            }
            cells(ui, rect, &frame, id, offset, &colours);
        });
        if let Some((id, is_double)) = clicked {
            if !ui.input(|input| input.modifiers.command) {
                self.select(Some(Item::Robot(id)));
            } else if !is_double {
                self.toggle_selected(Item::Robot(id));
            }
            if is_double {
                self.fly_to_selected(model);
            }
        }
    }

    fn search(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let robots = model.frame.map_or(0, |frame| frame.len());
        ui.horizontal(|ui| {
            let hint = format!("{} robots: id or state", thousands(robots as u64));
            let field = egui::TextEdit::singleline(&mut self.fleet_list.query.filter).hint_text(hint);
            let field = ui.add(field.desired_width(f32::INFINITY).id_salt("find"));
            if std::mem::take(&mut self.fleet_list.request_focus) {
                field.request_focus();
            }
            let extend = field.has_focus() && ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Enter));
            if extend || field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                let exact = self.fleet_list.query.filter.trim().parse().ok().filter(|id| (*id as usize) < robots);
                let first =
                    model.rows.filter(|rows| rows.query == self.fleet_list.query).and_then(|rows| rows.ids.first());
                match exact.or(first.copied()) {
                    Some(id) if extend => self.toggle_selected(Item::Robot(id)),
                    Some(id) => {
                        self.select(Some(Item::Robot(id)));
                        self.fly_to_selected(model);
                    }
                    None => self.notify(format!("no robot '{}'", self.fleet_list.query.filter.trim())),
                }
            }
        });
    }
}

fn header(ui: &mut Ui, query: &mut RowQuery, colours: &ThemeColours) {
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), 16.0), Sense::hover());
    let mut left = area.left();
    for (name, sort, end) in COLUMNS {
        let right = area.left() + (area.width() - 10.0) * end;
        let rect = Rect::from_min_max(pos2(left, area.top()), pos2(right, area.bottom()));
        left = right;
        let response = ui.interact(rect, ui.scope_id().with(name), Sense::click());
        let is_chosen = query.sort == sort;
        response
            .widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_chosen, format!("sort by {name}")));
        if response.clicked() {
            *query = RowQuery { sort, descending: is_chosen && !query.descending, filter: query.filter.clone() };
        }
        let colour = if is_chosen || response.hovered() { colours.text } else { colours.faint };
        let at = pos2(right, area.center().y);
        let text = ui.painter().text(at, Align2::RIGHT_CENTER, name, FontId::proportional(11.5), colour);
        if is_chosen {
            let icon = if query.descending { Icon::Descending } else { Icon::Ascending };
            icons::draw(ui.painter(), icon, pos2(text.left() - 8.0, at.y), 3.5, colour);
        }
    }
}

fn cells(ui: &Ui, rect: Rect, frame: &Frame<'_>, id: u32, offset: [f32; 2], colours: &ThemeColours) {
    let row = id as usize;
    let write = |end: f32, text: String, colour| {
        let at = pos2(rect.left() + rect.width() * end, rect.center().y);
        ui.painter().text(at, Align2::RIGHT_CENTER, text, FontId::monospace(12.0), colour);
    };
    write(COLUMNS[0].2, id.to_string(), colours.text);
    let state = frame.state_of(row);
    if state == RobotState::Absent {
        write(COLUMNS[3].2, state_name(state).to_owned(), colours.faint);
        return;
    }
    let dot = pos2(rect.left() + 5.0, rect.center().y);
    ui.painter().circle_filled(dot, 3.0, state_colour(state, colours));
    let numbers = [frame.x()[row] + offset[0], frame.y()[row] + offset[1], frame.theta()[row].to_degrees()];
    for ((number, decimals), (_, _, end)) in numbers.into_iter().zip([2, 2, 1]).zip(&COLUMNS[1..]) {
        let unit = if decimals == 1 { "°" } else { "" };
        write(*end, format!("{number:.decimals$}{unit}"), colours.text);
    }
}

/// Returns the colour of a robot state.
pub fn state_colour(state: RobotState, colours: &ThemeColours) -> egui::Color32 {
    match state {
        RobotState::Driving | RobotState::Turning => colours.good,
        RobotState::Waiting | RobotState::Held | RobotState::Stalled => colours.warn,
        RobotState::Faulted | RobotState::Broken => colours.bad,
        RobotState::Idle | RobotState::Absent => colours.faint,
    }
}
