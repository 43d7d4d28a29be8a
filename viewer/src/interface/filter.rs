//! The filter of the fleet panel: choices of state, type, task and zone, and how many robots match.

use std::collections::BTreeSet;

use egui::{ComboBox, Role, TextEdit, Ui, WidgetInfo};
use regatta_plugin::frame::RobotState;

use super::state::Interface;
use super::style;
use super::view_model::{Action, ViewModel};
use crate::filter::{Filter, TaskFilter};
use crate::text::{thousands, with_plural};

/// The states to choose from.
const STATES: [RobotState; 8] = [
    RobotState::Idle,
    RobotState::Driving,
    RobotState::Waiting,
    RobotState::Held,
    RobotState::Faulted,
    RobotState::Turning,
    RobotState::Stalled,
    RobotState::Broken,
];

impl Interface {
    /// Shows the filter, and requests the robots that match it when it has changed.
    pub(super) fn filter(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let (before, theme) = (self.filter.clone(), self.settings.theme());
        ui.horizontal_wrapped(|ui| {
            state(ui, &mut self.filter);
            robot_type(ui, &mut self.filter, model);
            zone(ui, &mut self.filter, model);
            self.task_filter(ui);
        });
        // Of levels side by side, all robots are shown.
        let is_filtered = !Filter { level: None, ..self.filter.clone() }.is_empty();
        if is_filtered || self.filter.level.is_some() && self.parts().is_empty() {
            ui.horizontal(|ui| {
                let text = model.matches.map_or("counting …".to_owned(), |[matching, all]| {
                    let verb = if matching == 1 { "matches" } else { "match" };
                    format!("{} of {} {verb}", thousands(matching.into()), with_plural(all.into(), "robot"))
                });
                ui.label(style::faint(ui, theme, text));
                if ui.small_button("show all").clicked() {
                    (self.filter, self.task_number) = (Filter::default(), String::new());
                }
            });
        }
        if self.filter != before {
            actions.push(Action::Filter(self.filter.clone()));
        }
    }

    fn task_filter(&mut self, ui: &mut Ui) {
        let (task, number) = (&mut self.filter.task, &mut self.task_number);
        let name = match task {
            TaskFilter::Any => "any task".to_owned(),
            TaskFilter::Some => "with a task".to_owned(),
            TaskFilter::None => "without a task".to_owned(),
            TaskFilter::Number(number) => format!("task {number}"),
        };
        let shown = ComboBox::from_id_salt("filter task").selected_text(name).width(96.0).show_ui(ui, |ui| {
            ui.selectable_value(task, TaskFilter::Any, "any task");
            ui.selectable_value(task, TaskFilter::Some, "with a task");
            ui.selectable_value(task, TaskFilter::None, "without a task");
            let field = ui.add(TextEdit::singleline(number).hint_text("task number").desired_width(84.0));
            field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "task number"));
            if let Some(number) = number.trim().parse().ok().filter(|_| field.changed()) {
                *task = TaskFilter::Number(number);
            }
        });
        shown.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "filter: task"));
    }
}

fn state(ui: &mut Ui, filter: &mut Filter) {
    let name = filter.state.map_or("any state", RobotState::name);
    let shown = ComboBox::from_id_salt("filter state").selected_text(name).width(84.0).show_ui(ui, |ui| {
        ui.selectable_value(&mut filter.state, None, "any state");
        for state in STATES {
            ui.selectable_value(&mut filter.state, Some(state), state.name());
        }
    });
    shown.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "filter: state"));
}

fn robot_type(ui: &mut Ui, filter: &mut Filter, model: &ViewModel<'_>) {
    let types = model.world.robot_types();
    if types.len() < 2 && filter.robot_type.is_none() {
        return;
    }
    let name_of = |index: u32| types.get(index as usize).map_or("unknown", |robot_type| robot_type.name());
    let name = filter.robot_type.map_or("any type", name_of);
    let shown = ComboBox::from_id_salt("filter type").selected_text(name).width(84.0).show_ui(ui, |ui| {
        ui.selectable_value(&mut filter.robot_type, None, "any type");
        for index in 0..types.len() as u32 {
            ui.selectable_value(&mut filter.robot_type, Some(index), name_of(index));
        }
    });
    shown.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "filter: type"));
}

fn zone(ui: &mut Ui, filter: &mut Filter, model: &ViewModel<'_>) {
    let has_zones = model.world.edges().iter().any(|edge| edge.zone != 0);
    if !has_zones && filter.zone.is_none() {
        return;
    }
    let name = filter.zone.clone().unwrap_or_else(|| "any zone".to_owned());
    let shown = ComboBox::from_id_salt("filter zone").selected_text(name).width(84.0).show_ui(ui, |ui| {
        ui.selectable_value(&mut filter.zone, None, "any zone");
        let zones: BTreeSet<&str> = model.world.edges().iter().map(|edge| model.world.text(edge.zone)).collect();
        for zone in zones.into_iter().filter(|zone| !zone.is_empty()) {
            ui.selectable_value(&mut filter.zone, Some(zone.to_owned()), zone);
        }
    });
    shown.response.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, "filter: zone"));
}
