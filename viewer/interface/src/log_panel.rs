//! The log panel: alarms to acknowledge, and below them all that happened; a click goes there.

use std::sync::Arc;

use egui::style::ScrollStyle;
use egui::{
    Align2, ComboBox, FontId, Rect, RichText, Role, ScrollArea, TextEdit, TextWrapMode, Ui,
    WidgetInfo, pos2,
};
use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::control::{ControlKind, ControlRequest};
use regatta_scene::curves::midpoint;
use regatta_scene::names::edge_name;

use super::context::{PanelContext, Request};
use super::style::{self, ThemeColours, one_line};
use super::transport::clock_text;
use super::view_model::{Action, Item};
use super::virtual_list::{VirtualList, clickable};
use crate::commands::UserCommand;
use crate::log::{
    Alarm, AlarmChange, AlarmKey, Entry, FleetLog, Kind, LogFilter, LogLosses, LogReport, Place,
    Repeated, Severity, of_mark, repeated,
};
use crate::text::{thousands, with_plural};

/// The part of the panel's height that alarms take at most.
const ALARMS: f32 = 0.4;

/// The log and what of it is shown.
#[derive(Debug, Default)]
pub(super) struct LogPanel {
    pub log: FleetLog,
    filter: LogFilter,
    pub list: VirtualList,
    /// The source of `shown`: the revision of the log, and the filter.
    made_of: Option<(u64, LogFilter)>,
    /// The entries that the filter shows, by their places in the log, the newest first.
    shown: Vec<Repeated>,
}

impl LogPanel {
    fn update(&mut self) {
        let wanted = (self.log.revision(), self.filter.clone());
        if self.made_of.as_ref() != Some(&wanted) {
            self.shown = repeated(self.log.entries(), &self.filter);
            self.made_of = Some(wanted);
        }
    }

    /// Keeps the reason for which a command of the user came to nothing.
    pub fn add_refusal(&mut self, command: UserCommand, text: String, time_nanos: u64) {
        let (robot, place) = match command {
            UserCommand::Close(edge) | UserCommand::Open(edge) => (None, Place::Edge(edge)),
            _ => (command.robot(), Place::None),
        };
        let entry = Entry {
            time_nanos,
            kind: Kind::Order,
            severity: Severity::Warning,
            robot,
            place,
            text,
        };
        self.log.take(LogReport { news: vec![(entry, AlarmChange::None)], ..LogReport::default() });
    }

    /// Shows the panel.
    pub fn show(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        self.alarms(context, ui);
        if let Some(recording) = context.model.recording() {
            // A recording's marks are known for all of its time.
            let entries: Vec<Entry> = recording.marks.iter().filter_map(of_mark).collect();
            ui.label(RichText::new(with_plural(entries.len() as u64, "mark")).size(20.0));
            let copies = self.filters(ui);
            let shown: Vec<&Entry> =
                entries.iter().filter(|entry| self.filter.shows(entry)).collect();
            if copies {
                copy(context, ui, shown.iter().map(|entry| (*entry, 0)));
            }
            let clicked =
                list_entries(context, ui, &mut self.list, shown.len(), &|row| (shown[row], 0));
            if let Some(entry) = clicked {
                context.act(Action::Control(ControlRequest {
                    count: entry.time_nanos,
                    ..ControlRequest::new(ControlKind::Seek)
                }));
                jump(context, &entry);
            }
            return;
        }
        let copies = self.filters(ui);
        self.update();
        let (entries, shown) = (self.log.entries(), &self.shown);
        if copies {
            copy(context, ui, shown.iter().map(|row| (&entries[row.place], row.more)));
        }
        let clicked = list_entries(context, ui, &mut self.list, shown.len(), &|row| {
            let Repeated { place, more } = shown[row];
            (&entries[place], more)
        });
        if let Some(entry) = clicked {
            jump(context, &entry);
        }
    }

    fn alarms(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let colours = context.colours;
        let alarms = self.log.alarms();
        let unacknowledged = self.log.unacknowledged();
        // Alarms of a recording need no acknowledgement.
        let is_recording = context.model.recording().is_some();
        let (mut acknowledged, mut clicked) = (None, None);
        ui.horizontal(|ui| {
            let colour = if unacknowledged > 0 { colours.bad } else { colours.text };
            ui.label(RichText::new(count_text(alarms.len())).size(20.0).color(colour));
            if unacknowledged > 0 && !is_recording && ui.button("Acknowledge all").clicked() {
                acknowledged = Some(None);
            }
        });
        let LogLosses { forgotten, left_out } = self.log.losses();
        if left_out > 0 {
            let verb = if left_out == 1 { "has" } else { "have" };
            let text = format!("{} {verb} no room here", with_plural(left_out, "more alarm"));
            ui.label(RichText::new(text).color(colours.warn));
        }
        let height = ui.available_height() * ALARMS;
        // A floating bar would be seen only under the pointer.
        ui.spacing_mut().scroll = ScrollStyle { foreground_color: true, ..ScrollStyle::solid() };
        ScrollArea::vertical()
            .id_salt("alarms")
            .max_height(height)
            .auto_shrink([false, true])
            .show(ui, |ui| {
                for (key, alarm) in &alarms {
                    ui.horizontal(|ui| {
                        if !alarm.is_acknowledged
                            && !is_recording
                            && acknowledge_button(ui, &context.model.world, *key).clicked()
                        {
                            acknowledged = Some(Some(*key));
                        }
                        ui.style_mut().wrap_mode = Some(TextWrapMode::Wrap);
                        if ui
                            .link(
                                RichText::new(alarm_text(&context.model.world, alarm))
                                    .color(alarm_colour(alarm, &colours)),
                            )
                            .clicked()
                        {
                            clicked = Some(alarm.entry.clone());
                        }
                    });
                }
            });
        if forgotten > 0 && !is_recording {
            let text = match forgotten {
                1 => "1 older entry is forgotten".to_owned(),
                forgotten => format!("{} older entries are forgotten", thousands(forgotten)),
            };
            ui.label(style::faint(ui, text));
        }
        if let Some(key) = acknowledged {
            self.log.acknowledge(key);
        }
        if let Some(entry) = clicked {
            jump(context, &entry);
        }
    }

    /// Shows the filters. Returns whether the entries are to be copied.
    fn filters(&mut self, ui: &mut Ui) -> bool {
        let filter = &mut self.filter;
        let mut copies = false;
        ui.horizontal(|ui| {
            let combo =
                ComboBox::from_id_salt("log kind").selected_text(name_of(filter.kind)).width(90.0);
            style::choice(ui, "kind of entries", combo, |ui| {
                for kind in std::iter::once(None).chain(Kind::ALL.map(Some)) {
                    ui.selectable_value(&mut filter.kind, kind, name_of(kind));
                }
            });
            style::row_from_right(ui, |ui| {
                copies = style::copy_button(ui, "these entries").clicked();
                let text = TextEdit::singleline(&mut filter.text)
                    .hint_text("text, or #7")
                    .desired_width(f32::INFINITY);
                ui.add(text)
                    .on_hover_text("Entries with this text; #7 for those of robot 7")
                    .widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "text of entries"));
            });
        });
        copies
    }
}

/// Copies entries, each a line with its time.
fn copy<'a>(
    context: &PanelContext<'_>,
    ui: &Ui,
    entries: impl ExactSizeIterator<Item = (&'a Entry, u32)>,
) {
    let count = entries.len() as u64;
    let lines = entries.map(|(entry, more)| {
        let time = clock_text(entry.time_nanos as f64 / 1e9);
        format!("{time}\t{}\n", row_text(&context.model.world, entry, more))
    });
    ui.ctx().copy_text(lines.collect());
    let noun = if count == 1 { "entry" } else { "entries" };
    context.notify(format!("{} {noun} copied", thousands(count)));
}

/// Shows the entries in sight. Returns the one that was clicked.
fn list_entries<'a>(
    context: &PanelContext<'_>,
    ui: &mut Ui,
    list: &mut VirtualList,
    count: usize,
    entry: &dyn Fn(usize) -> (&'a Entry, u32),
) -> Option<Entry> {
    let (colours, selected) = (context.colours, context.selection.robots());
    if count == 0 {
        ui.label(style::faint(ui, "no entries to show"));
        return None;
    }
    let mut clicked = None;
    list.show(ui, "log", &colours, count, |ui, rect, row| {
        let (entry, more) = entry(row);
        let text = row_text(&context.model.world, entry, more);
        let is_selected = entry.robot.is_some_and(|robot| selected.contains(&robot));
        let time = clock_text(entry.time_nanos as f64 / 1e9);
        let response =
            clickable(ui, rect, row as u32, is_selected, &colours, || format!("{time} {text}"));
        if response.clicked() {
            clicked = Some(entry.clone());
        }
        if paint(ui, rect, (entry.severity, &text), &time, &colours) {
            response.on_hover_text(text);
        }
    });
    clicked
}

/// The text of a row: that of its entry, and how many like it the row stands for.
fn row_text(world: &World<'_>, entry: &Entry, more: u32) -> String {
    let text = text_of(world, entry);
    match more {
        0 => text,
        more => format!("{text}, and {} more like it", thousands(more.into())),
    }
}

/// The text of an entry, in which an edge has its name, as everywhere else. The collector of the log
/// knows its id alone.
fn text_of(world: &World<'_>, entry: &Entry) -> String {
    let Place::Edge(id) = entry.place else { return entry.text.clone() };
    entry.text.replacen(&format!("edge {id}"), &format!("edge {}", named_edge(world, id)), 1)
}

/// The name of an edge by its id, or else the id.
fn named_edge(world: &World<'_>, id: u32) -> String {
    let edge = world.edges().iter().find(|edge| edge.id == id);
    edge.map_or_else(|| id.to_string(), |edge| edge_name(world, edge))
}

/// Selects the subject of an entry, and flies there.
fn jump(context: &PanelContext<'_>, entry: &Entry) {
    if let Some(robot) = entry.robot {
        context.ask(Request::Select(Some(Item::Robot(robot))));
    }
    match entry.place {
        Place::At { x, y } => context.ask(Request::FlyTo(Vec2::new(x, y) + context.offset)),
        Place::Edge(id) => {
            let world = &context.model.world;
            let Some((index, edge)) = (0..).zip(world.edges()).find(|(_, edge)| edge.id == id)
            else {
                return;
            };
            context.ask(Request::Select(Some(Item::Edge(index))));
            if let Some(middle) = midpoint(world, edge) {
                context.ask(Request::FlyTo(middle + context.offset));
            }
        }
        Place::None if entry.robot.is_some() => context.ask(Request::FlyToSelected),
        Place::None => {}
    }
}

fn name_of(kind: Option<Kind>) -> &'static str {
    kind.map_or("everything", Kind::name)
}

fn acknowledge_button(ui: &mut Ui, world: &World<'_>, key: AlarmKey) -> egui::Response {
    let response = ui.small_button("OK").on_hover_text("Acknowledge");
    let name = format!("acknowledge {}", subject_of(world, key));
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
    response
}

/// The subject of an alarm, in words.
fn subject_of(world: &World<'_>, key: AlarmKey) -> String {
    match key {
        AlarmKey::Robot(robot) => format!("robot {robot}"),
        AlarmKey::Contact([one, other]) => format!("robots {one} and {other}"),
        AlarmKey::Edge(edge) => format!("edge {}", named_edge(world, edge)),
        AlarmKey::Standstill => "the standstill".to_owned(),
        AlarmKey::Manager => "the fleet manager".to_owned(),
    }
}

fn count_text(alarms: usize) -> String {
    match alarms {
        0 => "no alarms".to_owned(),
        count => with_plural(count as u64, "alarm"),
    }
}

fn alarm_text(world: &World<'_>, alarm: &Alarm) -> String {
    let time = clock_text(alarm.entry.time_nanos as f64 / 1e9);
    let over = if alarm.is_active { "" } else { " (over)" };
    style::unbroken(&format!("{time} {}{over}", text_of(world, &alarm.entry)))
}

fn alarm_colour(alarm: &Alarm, colours: &ThemeColours) -> egui::Color32 {
    match (alarm.is_acknowledged, alarm.is_active) {
        (true, _) => colours.faint,
        (false, true) => colours.bad,
        (false, false) => colours.warn,
    }
}

/// Paints an entry. Returns whether its text ends with an ellipsis because the row is too short.
fn paint(
    ui: &Ui,
    rect: Rect,
    (severity, text): (Severity, &str),
    time: &str,
    colours: &ThemeColours,
) -> bool {
    let colour = match severity {
        Severity::Info => colours.good,
        Severity::Warning => colours.warn,
        Severity::Alarm => colours.bad,
    };
    let painter = ui.painter();
    painter.circle_filled(pos2(rect.left() + 6.0, rect.center().y), 3.5, colour);
    let at = pos2(rect.left() + 16.0, rect.center().y);
    let time = painter.text(at, Align2::LEFT_CENTER, time, FontId::monospace(12.0), colours.faint);
    let left = time.right() + 8.0;
    let text = one_line(ui, text, rect.right() - left, FontId::proportional(12.0), colours.text);
    let place = Align2::LEFT_CENTER.anchor_size(pos2(left, rect.center().y), text.size());
    painter.galley(place.min, Arc::clone(&text), colours.text);
    text.elided
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{CurveRecord, EdgeRecord, WorldData};

    use super::*;

    #[test]
    fn entries_have_the_names_of_edges() {
        let mut world = WorldData::default();
        let name = world.texts.add("A --- B");
        for (id, name) in [(12, name), (13, Default::default())] {
            let edge = EdgeRecord { id, name, ..EdgeRecord::default() };
            world.add_edge(edge, [CurveRecord::default()]);
        }
        let world = world.view(1, 1);
        let text = |id| {
            let entry = Entry {
                time_nanos: 0,
                kind: Kind::Edge,
                severity: Severity::Warning,
                robot: None,
                place: Place::Edge(id),
                text: format!("edge {id} closed"),
            };
            row_text(&world, &entry, 0)
        };
        assert_eq!(
            [12, 13, 14].map(text),
            ["edge A --- B closed", "edge 13 closed", "edge 14 closed"]
        );
        assert_eq!(subject_of(&world, AlarmKey::Edge(12)), "edge A --- B");
    }
}
