//! The fleet list: `id x y theta` of all robots, sortable and searchable.

use egui::{Align2, FontId, Key, Modifiers, Rect, RichText, Sense, Ui, pos2, vec2};
use regatta_plugin::frame::{Frame, RobotState};

use super::Interface;
use super::facts::{Action, Facts, Thing};
use super::icons::{self, Icon};
use super::list::{Scroll, clickable};
use super::rows::{RowQuery, SortBy, state_name};
use super::style::{self, Tones, thousands};

/// Names of the columns, and where they end, as parts of the width.
const COLUMNS: [(&str, SortBy, f32); 4] =
    [("id", SortBy::Id, 0.24), ("x", SortBy::X, 0.50), ("y", SortBy::Y, 0.76), ("θ", SortBy::Theta, 0.97)];

/// Where the list is, and what it shows.
#[derive(Clone, Debug, Default)]
pub struct FleetList {
    /// Which robots, in which order.
    pub query: RowQuery,
    /// Where it is.
    pub scroll: Scroll,
    /// The search field wants the keyboard.
    pub find: bool,
}

impl Interface {
    pub(super) fn fleet_list(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let before = self.list.query.clone();
        self.search(ui, facts);
        let tones = self.tones();
        header(ui, &mut self.list.query, &tones);
        if self.list.query != before {
            self.list.scroll.first = 0.0;
            actions.push(Action::Rows(self.list.query.clone()));
        }
        let Some(frame) = facts.frame else {
            ui.label(style::faint(ui, self.settings.theme(), "no robots yet"));
            return;
        };
        let query = self.list.query.clone();
        let rows = facts.rows.filter(|rows| rows.query == query && !query.is_plain());
        let count = rows.map_or(frame.len(), |rows| rows.ids.len());
        let id_of = |row: usize| match rows {
            Some(rows) => rows.ids[row],
            None if query.descending => (frame.len() - 1 - row) as u32,
            None => row as u32,
        };
        let (selected, offset) = (self.robots(), self.settings.offset);
        let mut clicked = None;
        self.list.scroll.show(ui, "fleet list", &tones, count, |ui, rect, row| {
            let id = id_of(row);
            let chosen = selected.contains(&id);
            let response = clickable(ui, rect, id, chosen, &tones, || format!("robot {id}"));
            if response.clicked() || response.double_clicked() {
                clicked = Some((id, response.double_clicked()));
            }
            cells(ui, rect, &frame, id, offset, &tones);
        });
        if let Some((id, twice)) = clicked {
            if !ui.input(|input| input.modifiers.command) {
                self.select(Some(Thing::Robot(id)));
            } else if !twice {
                self.select_beside(Thing::Robot(id));
            }
            if twice {
                self.fly_to_selected(facts);
            }
        }
    }

    fn search(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        let robots = facts.frame.map_or(0, |frame| frame.len());
        ui.horizontal(|ui| {
            let hint = format!("{} robots: id or state", thousands(robots as u64));
            let field = egui::TextEdit::singleline(&mut self.list.query.filter).hint_text(hint);
            let field = ui.add(field.desired_width(f32::INFINITY).id_salt("find"));
            if std::mem::take(&mut self.list.find) {
                field.request_focus();
            }
            let beside = field.has_focus() && ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Enter));
            if beside || field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                let exact = self.list.query.filter.trim().parse().ok().filter(|id| (*id as usize) < robots);
                let first = facts.rows.filter(|rows| rows.query == self.list.query).and_then(|rows| rows.ids.first());
                match exact.or(first.copied()) {
                    Some(id) if beside => self.select_beside(Thing::Robot(id)),
                    Some(id) => {
                        self.select(Some(Thing::Robot(id)));
                        self.fly_to_selected(facts);
                    }
                    None => self.tell(format!("no robot '{}'", self.list.query.filter.trim())),
                }
            }
        });
    }
}

fn header(ui: &mut Ui, query: &mut RowQuery, tones: &Tones) {
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), 16.0), Sense::hover());
    let mut left = area.left();
    for (name, sort, end) in COLUMNS {
        let right = area.left() + (area.width() - 10.0) * end;
        let rect = Rect::from_min_max(pos2(left, area.top()), pos2(right, area.bottom()));
        left = right;
        let response = ui.interact(rect, ui.scope_id().with(name), Sense::click());
        let chosen = query.sort == sort;
        response
            .widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, chosen, format!("sort by {name}")));
        if response.clicked() {
            *query = RowQuery { sort, descending: chosen && !query.descending, filter: query.filter.clone() };
        }
        let colour = if chosen || response.hovered() { tones.text } else { tones.faint };
        let at = pos2(right, area.center().y);
        let text = ui.painter().text(at, Align2::RIGHT_CENTER, name, FontId::proportional(11.5), colour);
        if chosen {
            let icon = if query.descending { Icon::Descending } else { Icon::Ascending };
            icons::draw(ui.painter(), icon, pos2(text.left() - 8.0, at.y), 3.5, colour);
        }
    }
}

fn cells(ui: &Ui, rect: Rect, frame: &Frame<'_>, id: u32, offset: [f32; 2], tones: &Tones) {
    let row = id as usize;
    let write = |end: f32, text: String, colour| {
        let at = pos2(rect.left() + rect.width() * end, rect.center().y);
        ui.painter().text(at, Align2::RIGHT_CENTER, text, FontId::monospace(12.0), colour);
    };
    write(COLUMNS[0].2, id.to_string(), tones.text);
    let state = frame.state_of(row);
    if state == RobotState::Absent {
        write(COLUMNS[3].2, state_name(state).to_owned(), tones.faint);
        return;
    }
    let dot = pos2(rect.left() + 5.0, rect.center().y);
    ui.painter().circle_filled(dot, 3.0, state_colour(state, tones));
    let numbers = [frame.x()[row] + offset[0], frame.y()[row] + offset[1], frame.theta()[row].to_degrees()];
    for ((number, decimals), (_, _, end)) in numbers.into_iter().zip([2, 2, 1]).zip(&COLUMNS[1..]) {
        let unit = if decimals == 1 { "°" } else { "" };
        write(*end, format!("{number:.decimals$}{unit}"), tones.text);
    }
}

/// The colour of a state's dot.
pub fn state_colour(state: RobotState, tones: &Tones) -> egui::Color32 {
    match state {
        RobotState::Driving => tones.good,
        RobotState::Waiting | RobotState::Held => tones.warn,
        RobotState::Faulted => tones.bad,
        RobotState::Idle | RobotState::Absent => tones.faint,
    }
}

/// A dot of a colour, and a word.
pub fn dot(ui: &mut Ui, colour: egui::Color32, text: RichText) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        let (rect, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
        ui.painter().circle_filled(rect.center(), 4.0, colour);
        ui.label(text);
    });
}
