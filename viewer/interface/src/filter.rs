//! The filter of the fleet panel: choices of activity, type, order and zone, and how many robots
//! match.

use std::collections::BTreeSet;

use egui::{Button, ComboBox, Role, TextEdit, Ui, WidgetInfo};
use regatta_plugin::activity::Activity;

use super::context::{PanelContext, Request};
use super::style;
use super::view_model::ViewModel;
use crate::robot_filter::{Filter, MatchCounts, OrderFilter, is_in};
use crate::text::{thousands, with_plural};

/// An order's number as typed into the filter.
#[derive(Clone, Debug, Default)]
pub(super) struct FilterChoices {
    order_number: String,
}

impl FilterChoices {
    /// Shows the filter, and requests the robots that match it when it has changed.
    pub fn show(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let mut filter = context.filter.clone();
        ui.horizontal_wrapped(|ui| {
            activity(ui, &mut filter);
            robot_type(ui, &mut filter, context.model);
            zone(ui, &mut filter, context.model);
            self.order(&mut filter.order, ui);
        });
        // The line is there without a filter too, so that the list below it stays where it is.
        ui.horizontal(|ui| {
            let text = count_text(&filter, context);
            ui.label(style::faint(ui, text));
            if ui.add_enabled(filter.has_conditions(), Button::new("show all").small()).clicked() {
                filter = Filter::default().of_level(filter.level.as_deref());
                self.order_number.clear();
            }
        });
        if filter != context.filter {
            context.ask(Request::Filter(filter));
        }
    }

    fn order(&mut self, order: &mut OrderFilter, ui: &mut Ui) {
        let number = &mut self.order_number;
        let name = match order {
            OrderFilter::Any => "any order".to_owned(),
            OrderFilter::Some => "with an order".to_owned(),
            OrderFilter::None => "without an order".to_owned(),
            OrderFilter::Number(number) => format!("order {number}"),
        };
        let combo = ComboBox::from_id_salt("filter order").selected_text(name).width(96.0);
        style::choice(ui, "filter: order", combo, |ui| {
            ui.selectable_value(order, OrderFilter::Any, "any order");
            ui.selectable_value(order, OrderFilter::Some, "with an order");
            ui.selectable_value(order, OrderFilter::None, "without an order");
            let field =
                ui.add(TextEdit::singleline(number).hint_text("order number").desired_width(84.0));
            field.widget_info(|| WidgetInfo::labeled(Role::TextInput, true, "order number"));
            if let Some(number) = number.trim().parse().ok().filter(|_| field.changed()) {
                *order = OrderFilter::Number(number);
            }
        });
    }
}

/// Returns the number of robots that match, as a text; without a filter, the number of those on the
/// level that alone is shown.
fn count_text(filter: &Filter, context: &PanelContext<'_>) -> String {
    let is_level_alone = filter.level.is_some() && !context.is_side_by_side;
    let has_conditions = filter.has_conditions();
    if !is_level_alone && !has_conditions {
        return "no filter".to_owned();
    }
    let Some(MatchCounts { matching, on_level, all }) =
        context.model.matches.map(|matches| matches.counts)
    else {
        return "counting …".to_owned();
    };
    // Of levels side by side, all robots are shown.
    let number = if is_level_alone { on_level } else { matching };
    let verb = match (has_conditions, number) {
        (false, _) => "on this level",
        (true, 1) => "matches",
        (true, _) => "match",
    };
    format!("{} of {} {verb}", thousands(number.into()), with_plural(all.into(), "robot"))
}

/// Whether a robot matches the filter, and is on the only shown level. Until the matches are known,
/// all robots match.
pub(super) fn is_matching(context: &PanelContext<'_>, robot: u32) -> bool {
    context.model.matches.is_none_or(|matches| {
        let is_on_level = context.is_side_by_side || is_in(matches.on_level.as_ref(), robot);
        is_on_level && is_in(matches.matching.as_ref(), robot)
    })
}

/// The choice of robots of any activity.
const ANY: &str = "any activity";

fn activity(ui: &mut Ui, filter: &mut Filter) {
    let name = filter.activity.map_or(ANY, Activity::name);
    let combo = ComboBox::from_id_salt("filter activity").selected_text(name).width(84.0);
    style::choice(ui, "filter: activity", combo, |ui| {
        ui.selectable_value(&mut filter.activity, None, ANY);
        for activity in Activity::ALL {
            ui.selectable_value(&mut filter.activity, Some(activity), activity.name());
        }
    });
}

fn robot_type(ui: &mut Ui, filter: &mut Filter, model: &ViewModel<'_>) {
    let types = model.world.robot_types();
    if types.len() < 2 && filter.robot_type.is_none() {
        return;
    }
    let name_of =
        |index: u32| types.get(index as usize).map_or("unknown", |robot_type| robot_type.name());
    let name = filter.robot_type.map_or("any type", name_of);
    let combo = ComboBox::from_id_salt("filter type").selected_text(name).width(84.0);
    style::choice(ui, "filter: type", combo, |ui| {
        ui.selectable_value(&mut filter.robot_type, None, "any type");
        for index in 0..types.len() as u32 {
            ui.selectable_value(&mut filter.robot_type, Some(index), name_of(index));
        }
    });
}

fn zone(ui: &mut Ui, filter: &mut Filter, model: &ViewModel<'_>) {
    let has_zones = model.world.edges().iter().any(|edge| edge.zone != 0);
    if !has_zones && filter.zone.is_none() {
        return;
    }
    let name = filter.zone.clone().unwrap_or_else(|| "any zone".to_owned());
    let combo = ComboBox::from_id_salt("filter zone").selected_text(name).width(84.0);
    style::choice(ui, "filter: zone", combo, |ui| {
        ui.selectable_value(&mut filter.zone, None, "any zone");
        let zones: BTreeSet<&str> =
            model.world.edges().iter().map(|edge| model.world.text(edge.zone)).collect();
        for zone in zones.into_iter().filter(|zone| !zone.is_empty()) {
            ui.selectable_value(&mut filter.zone, Some(zone.to_owned()), zone);
        }
    });
}
