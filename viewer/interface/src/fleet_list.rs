//! The fleet panel: a list of all robots, sortable and searchable.

mod table;

use std::collections::BTreeMap;

use egui::{Align2, Color32, FontId, Key, Modifiers, Rect, Sense, Ui, pos2, vec2};
use glam::Vec2;
use regatta_plugin::activity::Activity;
use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{Frame, RobotState};
use regatta_scene::names::edge_name;
use regatta_scene::palette::Theme;

use super::context::{PanelContext, Request};
use super::filter::{FilterChoices, is_matching};
use super::icons::{self, Icon};
use super::rows::{RowQuery, Rows, SortBy};
use super::search::{self, Found, Suggestions, go_to, select_all};
use super::style::{self, ThemeColours, activity_colour, one_line};
use super::view_model::{Action, Item, ViewModel};
use super::virtual_list::{VirtualList, clickable};
use crate::robot_filter::{Filter, OrderFilter};
use crate::text::with_plural;

/// A column of the list: title, order, and right edge as a fraction of the width.
type Column = (&'static str, Option<SortBy>, f32);

/// The columns of a narrow list: the activity of a robot. The picture shows its place.
const NARROW: &[Column] = &[
    ("id", Some(SortBy::Id), 0.215),
    ("activity", Some(SortBy::Activity), 0.405),
    ("speed", Some(SortBy::Speed), 0.55),
    ("edge", Some(SortBy::Edge), 0.755),
    ("contact", None, 0.985),
];

/// The columns of a wide list.
const WIDE: &[Column] = &[
    ("id", Some(SortBy::Id), 0.112),
    ("activity", Some(SortBy::Activity), 0.25),
    ("speed", Some(SortBy::Speed), 0.335),
    ("edge", Some(SortBy::Edge), 0.455),
    ("x", Some(SortBy::X), 0.588),
    ("y", Some(SortBy::Y), 0.718),
    ("θ", Some(SortBy::Theta), 0.85),
    ("contact", None, 0.985),
];

/// The explanation of the search.
const SEARCH: &str = "Id or activity of a robot. With Enter, also n12 for a node, e12 for an edge, \
                      o12 for an order, and the name of a station, a node, an edge or an order";
/// The opacity of the row of a robot that doesn't match the filter.
const DIMMED: f32 = 0.35;

/// The least width of a wide list, in points.
const WIDE_POINTS: f32 = 440.0;
/// The width of a letter of equal widths, in heights of the font.
const LETTER: f32 = 0.6;
/// The space to the left of a column, in points.
const GAP: f32 = 6.0;
/// The size of the letters of a narrow and of a wide list, in points.
const LETTERS: [f32; 2] = [11.0, 12.0];

/// The fleet panel: the filter, the order and the scroll position of the list.
#[derive(Clone, Debug, Default)]
pub(super) struct FleetPanel {
    filter: FilterChoices,
    query: RowQuery,
    pub list: VirtualList,
    suggestions: Suggestions,
    /// Whether the search field requests the keyboard focus.
    requests_focus: bool,
    /// The rows while the pointer is over them: they don't move then.
    held: Option<Rows>,
    /// The last place of the list, in points.
    area: Option<egui::Rect>,
}

impl FleetPanel {
    /// Gives the search field the keyboard focus.
    pub fn focus_search(&mut self) {
        self.requests_focus = true;
    }

    /// Shows the panel.
    pub fn show(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let before = self.query.clone();
        self.filter.show(context, ui);
        self.search(context, ui);
        let colours = context.colours;
        let columns = if ui.available_width() >= WIDE_POINTS { WIDE } else { NARROW };
        header(ui, &mut self.query, &colours, columns);
        if self.query != before {
            self.list.first = 0.0;
            context.act(Action::Rows(self.query.clone()));
        }
        let Some(frame) = context.model.frame else {
            ui.label(style::faint(ui, "no robots yet"));
            return;
        };
        let query = self.query.clone();
        let newest = context.model.rows.filter(|rows| rows.query == query && !query.is_plain());
        let held = self.held_rows(ui, newest);
        let rows = held.as_ref();
        if rows.is_some_and(|rows| rows.ids.is_empty()) && !query.filter.trim().is_empty() {
            if let Some(found) = self.suggestions.show(context, &query.filter, ui) {
                self.go_to_other(context, found);
            }
            return;
        }
        let levels = contact_levels(context.model);
        let count = rows.map_or(frame.len(), |rows| rows.ids.len());
        let selected = context.selection.robots();
        let opacity = ui.opacity();
        let mut clicked = None;
        self.area = Some(ui.available_rect_before_wrap());
        self.list.show(ui, "fleet list", &colours, count, |ui, rect, row| {
            let id = match rows {
                Some(rows) => rows.ids[row],
                None if query.descending => (frame.len() - 1 - row) as u32,
                None => row as u32,
            };
            // A bit is looked up for each row in sight.
            ui.set_opacity(if is_matching(context, id) { opacity } else { opacity * DIMMED });
            let is_selected = selected.contains(&id);
            let response = clickable(ui, rect, id, is_selected, &colours, || format!("robot {id}"));
            if response.clicked() || response.double_clicked() {
                clicked = Some((id, response.double_clicked()));
            }
            let row = Row::new(context, &frame, id, &levels);
            cells(ui, rect, &frame, &row, columns, &colours);
        });
        self.held = held;
        if let Some((id, is_double)) = clicked {
            if !ui.input(|input| input.modifiers.command) {
                context.ask(Request::Select(Some(Item::Robot(id))));
            } else if !is_double {
                context.ask(Request::Toggle(Item::Robot(id)));
            }
            if is_double {
                context.ask(Request::FlyToSelected);
            }
        }
    }

    /// Copies the robots of the list, in its order.
    fn copy(&self, context: &PanelContext<'_>, ui: &Ui) {
        let Some(frame) = context.model.frame else { return };
        let is_sorted = |rows: &&Rows| rows.query == self.query && !self.query.is_plain();
        let rows = context.model.rows.filter(is_sorted);
        let all = 0..frame.len() as u32;
        let text = match rows {
            Some(rows) => table::csv(context, &frame, rows.ids.iter().copied()),
            None if self.query.descending => table::csv(context, &frame, all.rev()),
            None => table::csv(context, &frame, all),
        };
        let count = text.lines().count().saturating_sub(1);
        ui.ctx().copy_text(text);
        context.notify(format!("{} copied", with_plural(count as u64, "robot")));
    }

    /// Returns the rows to show. While the pointer is over the list, they don't change, so that the
    /// row under it stays.
    fn held_rows(&mut self, ui: &Ui, newest: Option<&Rows>) -> Option<Rows> {
        let newest = newest?;
        let is_over = self.area.is_some_and(|area| ui.rect_contains_pointer(area));
        let held = self.held.take().filter(|held| is_over && held.query == newest.query);
        held.or_else(|| Some(newest.clone()))
    }

    /// Goes to the place that the text of the search names, or shows the robots with an order.
    fn find_other(&mut self, context: &PanelContext<'_>) {
        if let Some(found) = search::find(&context.model.world, &self.query.filter) {
            return self.go_to_other(context, found);
        }
        let text = self.query.filter.trim().to_owned();
        if context.model.recording().is_some() {
            return context.notify(format!("there is no robot, place or name '{text}'"));
        }
        context.act(Action::FindOrder(text));
        self.show_all(context);
    }

    fn go_to_other(&mut self, context: &PanelContext<'_>, found: Found) {
        match found {
            Found::Place(item) => go_to(context, item),
            Found::Order(number) => {
                let order = OrderFilter::Number(number);
                context.ask(Request::Filter(Filter { order, ..context.filter.clone() }));
            }
        }
        self.show_all(context);
    }

    /// Lets the list show all robots again.
    fn show_all(&mut self, context: &PanelContext<'_>) {
        self.query.filter.clear();
        context.act(Action::Rows(self.query.clone()));
    }

    fn search(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let robots = context.model.frame.map_or(0, |frame| frame.len());
        style::row_from_right(ui, |ui| {
            if style::copy_button(ui, "these robots as a table").clicked() {
                self.copy(context, ui);
            }
            let hint = format!("{}: id, activity, n12, e12", with_plural(robots as u64, "robot"));
            let field = egui::TextEdit::singleline(&mut self.query.filter).hint_text(hint);
            let field = ui.add(field.desired_width(f32::INFINITY).id_salt("find"));
            let field = field.on_hover_text(SEARCH);
            if std::mem::take(&mut self.requests_focus) {
                field.request_focus();
                select_all(ui, field.id, &self.query.filter);
            }
            let extend = field.has_focus()
                && ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Enter));
            if extend || field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                let exact =
                    self.query.filter.trim().parse().ok().filter(|id| (*id as usize) < robots);
                let first = context
                    .model
                    .rows
                    .filter(|rows| rows.query == self.query)
                    .and_then(|rows| rows.ids.first());
                match exact.or(first.copied()) {
                    Some(id) if extend => context.ask(Request::Toggle(Item::Robot(id))),
                    Some(id) => go_to(context, Item::Robot(id)),
                    None => self.find_other(context),
                }
            }
        });
    }
}

fn header(ui: &mut Ui, query: &mut RowQuery, colours: &ThemeColours, columns: &[Column]) {
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), 22.0), Sense::hover());
    let mut left = area.left();
    for (name, sort, end) in columns {
        let right = area.left() + (area.width() - 10.0) * end;
        let rect = Rect::from_min_max(pos2(left, area.top()), pos2(right, area.bottom()));
        left = right;
        let sense = if sort.is_some() { Sense::click() } else { Sense::hover() };
        let response = ui.interact(rect, ui.scope_id().with(name), sense);
        let is_chosen = sort.is_some_and(|sort| query.sort == sort);
        let is_bright = is_chosen || sort.is_some() && response.hovered();
        let colour = if is_bright { colours.text } else { colours.faint };
        let at = pos2(right, area.bottom() - 8.0);
        let text =
            ui.painter().text(at, Align2::RIGHT_CENTER, *name, FontId::proportional(11.5), colour);
        let Some(sort) = *sort else { continue };
        response.widget_info(|| {
            egui::WidgetInfo::selected(
                egui::Role::Button,
                true,
                is_chosen,
                format!("sort by {name}"),
            )
        });
        if response.clicked() {
            *query = RowQuery {
                sort,
                descending: is_chosen && !query.descending,
                filter: query.filter.clone(),
            };
        }
        if is_chosen {
            // Beside the text, there would be no room for it.
            let icon = if query.descending { Icon::Descending } else { Icon::Ascending };
            icons::draw(ui.painter(), icon, pos2(text.center().x, area.top() + 4.0), 3.5, colour);
        }
    }
}

/// The values of a row beside the frame's columns.
struct Row {
    id: u32,
    /// The id of the edge.
    /// The name of its edge, and the id, for where the name has no room.
    edge: Option<(String, u32)>,
    level: Option<ContactLevel>,
    offset: Vec2,
    /// `None` if the robot is absent.
    activity: Option<Activity>,
    theme: Theme,
}

impl Row {
    fn new(
        context: &PanelContext<'_>,
        frame: &Frame<'_>,
        id: u32,
        levels: &BTreeMap<u32, ContactLevel>,
    ) -> Self {
        let world = &context.model.world;
        let edge = world.edges().get(frame.edge()[id as usize] as usize);
        Self {
            id,
            edge: edge.map(|edge| (edge_name(world, edge), edge.id)),
            level: levels.get(&id).copied(),
            offset: context.offset,
            activity: context.model.activity(id),
            theme: context.theme,
        }
    }
}

impl Row {
    /// The edge by its name, or by its id if the name has more than so many letters.
    fn edge_text(&self, letters: f32) -> String {
        match &self.edge {
            Some((name, _)) if name.chars().count() as f32 <= letters => name.clone(),
            Some((_, id)) => id.to_string(),
            None => "–".to_owned(),
        }
    }
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

fn cells(
    ui: &Ui,
    rect: Rect,
    frame: &Frame<'_>,
    row: &Row,
    columns: &[Column],
    colours: &ThemeColours,
) {
    let state = frame.state_of(row.id as usize);
    let size = LETTERS[usize::from(columns.len() > NARROW.len())];
    let dot = pos2(rect.left() + 5.0, rect.center().y);
    if let Some(activity) = row.activity {
        ui.painter().circle_filled(dot, 3.0, activity_colour(activity, row.theme));
    }
    let mut left = rect.left() + 8.0;
    for (place, (_, sort, end)) in columns.iter().enumerate() {
        let right = rect.left() + rect.width() * end;
        let is_last = place + 1 == columns.len();
        let (text, colour) = match (state, sort) {
            (RobotState::Absent, None) => (state.name().to_owned(), colours.faint),
            (RobotState::Absent, Some(sort)) if *sort != SortBy::Id => continue,
            (_, Some(SortBy::Edge)) => {
                (row.edge_text((right - left - GAP) / (LETTER * size)), colours.text)
            }
            (_, sort) => cell(frame, row, *sort, colours),
        };
        let is_word = is_last || *sort == Some(SortBy::Activity);
        let font = if is_word { FontId::proportional(size) } else { FontId::monospace(size) };
        let text = one_line(ui, &text, right - left - GAP, font, colour);
        let at = Align2::RIGHT_CENTER.anchor_size(pos2(right, rect.center().y), text.size());
        ui.painter().galley(at.min, text, colour);
        left = right;
    }
}

fn metres_text(metres: f32) -> String {
    if metres.abs() < 1000.0 { format!("{metres:.2}") } else { format!("{metres:.1}") }
}

/// Returns the text and the colour of a robot's cell; `None` is the column of contacts.
fn cell(
    frame: &Frame<'_>,
    row: &Row,
    sort: Option<SortBy>,
    colours: &ThemeColours,
) -> (String, Color32) {
    let id = row.id as usize;
    let text = match sort {
        Some(SortBy::Id) => row.id.to_string(),
        Some(SortBy::X) => metres_text(frame.x()[id] + row.offset.x),
        Some(SortBy::Y) => metres_text(frame.y()[id] + row.offset.y),
        Some(SortBy::Theta) => format!("{:.1}°", frame.theta()[id].to_degrees()),
        Some(SortBy::Speed) if frame.speed()[id].abs() >= 10.0 => {
            format!("{:.1}", frame.speed()[id])
        }
        Some(SortBy::Speed) => format!("{:.2}", frame.speed()[id]),
        Some(SortBy::Activity) => row.activity.map_or("", Activity::name).to_owned(),
        Some(SortBy::Edge) => row.edge_text(f32::INFINITY),
        None => match row.level {
            Some(ContactLevel::Touching) => return ("touching".to_owned(), colours.bad),
            Some(ContactLevel::Possible) => return ("possible".to_owned(), colours.warn),
            _ => String::new(),
        },
    };
    (text, colours.text)
}
