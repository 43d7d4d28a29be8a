//! The fleet panel: a list of all robots of all robots, sortable and searchable.

use std::collections::BTreeMap;

use egui::{Align2, FontId, Key, Modifiers, Rect, Sense, Ui, pos2, vec2};
use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{Frame, RobotState};

use super::icons::{self, Icon};
use super::rows::{RowQuery, Rows, SortBy};
use super::state::Interface;
use super::style::{self, ThemeColours};
use super::view_model::{Action, Item, ViewModel};
use super::virtual_list::clickable;
use crate::text::with_plural;

/// A column of the list: title, order, and right edge as a fraction of the width.
type Column = (&'static str, Option<SortBy>, f32);

/// The columns of a narrow list.
const NARROW: &[Column] = &[
    ("id", Some(SortBy::Id), 0.24),
    ("x", Some(SortBy::X), 0.50),
    ("y", Some(SortBy::Y), 0.76),
    ("θ", Some(SortBy::Theta), 0.97),
];

/// The columns of a wide list.
const WIDE: &[Column] = &[
    ("id", Some(SortBy::Id), 0.11),
    ("state", Some(SortBy::State), 0.24),
    ("speed", Some(SortBy::Speed), 0.335),
    ("edge", Some(SortBy::Edge), 0.435),
    ("x", Some(SortBy::X), 0.565),
    ("y", Some(SortBy::Y), 0.695),
    ("θ", Some(SortBy::Theta), 0.83),
    ("contact", None, 0.98),
];

/// The opacity of the row of a robot that doesn't match the filter.
const DIMMED: f32 = 0.35;

/// The least width of a wide list, in points.
const WIDE_POINTS: f32 = 420.0;

impl Interface {
    pub(super) fn fleet_list(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let before = self.fleet_list.query.clone();
        self.filter(ui, model, actions);
        self.search(ui, model);
        let colours = self.colours();
        let columns = if ui.available_width() >= WIDE_POINTS { WIDE } else { NARROW };
        header(ui, &mut self.fleet_list.query, &colours, columns);
        if self.fleet_list.query != before {
            self.fleet_list.list.first = 0.0;
            actions.push(Action::Rows(self.fleet_list.query.clone()));
        }
        let Some(frame) = model.frame else {
            ui.label(style::faint(ui, self.settings.theme(), "no robots yet"));
            return;
        };
        let query = self.fleet_list.query.clone();
        let held = self.held_rows(ui, model.rows.filter(|rows| rows.query == query && !query.is_plain()));
        let rows = held.as_ref();
        let levels = contact_levels(model);
        let count = rows.map_or(frame.len(), |rows| rows.ids.len());
        let id_of = |row: usize| match rows {
            Some(rows) => rows.ids[row],
            None if query.descending => (frame.len() - 1 - row) as u32,
            None => row as u32,
        };
        let (selected, offset, opacity) = (self.robots(), self.settings.offset, ui.opacity());
        let mut clicked = None;
        let mut list = self.fleet_list.list;
        self.fleet_list.area = Some(ui.available_rect_before_wrap());
        list.show(ui, "fleet list", &colours, count, |ui, rect, row| {
            let id = id_of(row);
            // A bit is looked up for each row in sight.
            ui.set_opacity(if self.is_matching(model, id) { opacity } else { opacity * DIMMED });
            let is_selected = selected.contains(&id);
            let response = clickable(ui, rect, id, is_selected, &colours, || format!("robot {id}"));
            if response.clicked() || response.double_clicked() {
                clicked = Some((id, response.double_clicked()));
            }
            let edge = model.world.edges().get(frame.edge()[id as usize] as usize).map(|edge| edge.id);
            let row = Row { id, edge, level: levels.get(&id).copied(), offset };
            cells(ui, rect, &frame, &row, columns, &colours);
        });
        (self.fleet_list.list, self.fleet_list.held) = (list, held);
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

    /// Returns the rows to show: while the pointer is over the list those that it came upon, so that the row under it stays.
    fn held_rows(&mut self, ui: &Ui, newest: Option<&Rows>) -> Option<Rows> {
        let newest = newest?;
        let is_over = self.fleet_list.area.is_some_and(|area| ui.rect_contains_pointer(area));
        let held = self.fleet_list.held.take().filter(|held| is_over && held.query == newest.query);
        held.or_else(|| Some(newest.clone()))
    }

    fn search(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let robots = model.frame.map_or(0, |frame| frame.len());
        ui.horizontal(|ui| {
            let hint = format!("{}: id or state", with_plural(robots as u64, "robot"));
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

fn header(ui: &mut Ui, query: &mut RowQuery, colours: &ThemeColours, columns: &[Column]) {
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), 16.0), Sense::hover());
    let mut left = area.left();
    for (name, sort, end) in columns {
        let right = area.left() + (area.width() - 10.0) * end;
        let rect = Rect::from_min_max(pos2(left, area.top()), pos2(right, area.bottom()));
        left = right;
        let response = ui.interact(rect, ui.scope_id().with(name), Sense::click());
        let Some(sort) = *sort else {
            let at = pos2(right, area.center().y);
            ui.painter().text(at, Align2::RIGHT_CENTER, *name, FontId::proportional(11.5), colours.faint);
            continue;
        };
        let is_chosen = query.sort == sort;
        response
            .widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, is_chosen, format!("sort by {name}")));
        if response.clicked() {
            *query = RowQuery { sort, descending: is_chosen && !query.descending, filter: query.filter.clone() };
        }
        let colour = if is_chosen || response.hovered() { colours.text } else { colours.faint };
        let at = pos2(right, area.center().y);
        let text = ui.painter().text(at, Align2::RIGHT_CENTER, *name, FontId::proportional(11.5), colour);
        if is_chosen {
            let icon = if query.descending { Icon::Descending } else { Icon::Ascending };
            icons::draw(ui.painter(), icon, pos2(text.left() - 8.0, at.y), 3.5, colour);
        }
    }
}

/// What a row shows beside the frame's columns.
struct Row {
    id: u32,
    /// The id of the edge.
    edge: Option<u32>,
    level: Option<ContactLevel>,
    offset: [f32; 2],
}

/// Returns the worst contact of each robot that has one.
fn contact_levels(model: &ViewModel<'_>) -> BTreeMap<u32, ContactLevel> {
    let mut levels = BTreeMap::new();
    for pair in model.contacts.iter().flat_map(|contacts| contacts.pairs) {
        for robot in pair.robots {
            let is_touching = pair.level == ContactLevel::Touching as u32;
            let level = levels.entry(robot).or_insert(ContactLevel::Possible);
            if is_touching {
                *level = ContactLevel::Touching;
            }
        }
    }
    levels
}

fn cells(ui: &Ui, rect: Rect, frame: &Frame<'_>, row: &Row, columns: &[Column], colours: &ThemeColours) {
    let (id, state) = (row.id as usize, frame.state_of(row.id as usize));
    let write = |end: f32, text: String, colour| {
        let at = pos2(rect.left() + rect.width() * end, rect.center().y);
        ui.painter().text(at, Align2::RIGHT_CENTER, text, FontId::monospace(12.0), colour);
    };
    write(columns[0].2, row.id.to_string(), colours.text);
    if state == RobotState::Absent {
        write(columns[columns.len() - 1].2, state.name().to_owned(), colours.faint);
        return;
    }
    let dot = pos2(rect.left() + 5.0, rect.center().y);
    ui.painter().circle_filled(dot, 3.0, state_colour(state, colours));
    for (_, sort, end) in &columns[1..] {
        let (text, colour) = match sort {
            Some(SortBy::Id) => continue,
            Some(SortBy::X) => (format!("{:.2}", frame.x()[id] + row.offset[0]), colours.text),
            Some(SortBy::Y) => (format!("{:.2}", frame.y()[id] + row.offset[1]), colours.text),
            Some(SortBy::Theta) => (format!("{:.1}°", frame.theta()[id].to_degrees()), colours.text),
            Some(SortBy::Speed) => (format!("{:.2}", frame.speed()[id]), colours.text),
            Some(SortBy::State) => (state.name().to_owned(), state_colour(state, colours)),
            Some(SortBy::Edge) => (row.edge.map_or("–".to_owned(), |edge| edge.to_string()), colours.text),
            None => match row.level {
                Some(ContactLevel::Touching) => ("touching".to_owned(), colours.bad),
                Some(ContactLevel::Possible) => ("possible".to_owned(), colours.warn),
                _ => (String::new(), colours.faint),
            },
        };
        write(*end, text, colour);
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
