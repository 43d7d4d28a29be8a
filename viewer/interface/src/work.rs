//! The part of the selection panel about the work that a fleet manager gives a robot.

use egui::Ui;
use regatta_plugin::column::{ACTIVITY, BATTERY, GOAL, WAITS_FOR};
use regatta_plugin::order::StopAction;
use regatta_plugin::world::NodeRecord;

use super::context::{PanelContext, Request};
use super::style::{self, heading, line};
use super::view_model::{Item, ViewModel};

/// The columns that this part shows.
pub const COLUMNS: [&str; 4] = [ACTIVITY.name(), WAITS_FOR.name(), GOAL.name(), BATTERY.name()];

/// Shows the blocker, the goal, the order and the battery of the selected robot, if
/// they are published.
pub(super) fn show(context: &PanelContext<'_>, ui: &mut Ui) {
    let [activity, waits_for, goal, battery] = COLUMNS.map(|name| context.model.value(name));
    if [activity, waits_for, goal, battery].iter().all(Option::is_none)
        && context.model.order.is_none()
    {
        return;
    }
    heading(ui, "work");
    order(context, ui);
    let mut next = None;
    if let Some(goal) = goal {
        let node = node_of(context.model, goal);
        if link(ui, "goal", node.map(|(_, node)| name_of(context.model, node))) {
            next = node.map(|(index, _)| Item::Node(index));
        }
    }
    if let Some(other) = waits_for {
        let other = WAITS_FOR.element(other);
        if link(ui, "waits for", other.map(|id| format!("robot {id}"))) {
            next = other.map(Item::Robot);
        }
    }
    if let Some(charge) = battery.and_then(|value| BATTERY.element(value)) {
        line(ui, "battery", format!("{charge:.0} %"));
    }
    if next.is_some() {
        context.ask(Request::Select(next));
    }
}

fn order(context: &PanelContext<'_>, ui: &mut Ui) {
    let Some(order) = context.model.order else { return };
    line(ui, "order", order.number.to_string());
    let Some(stop) = order.next else { return };
    let node = context.model.world.nodes().iter().find(|node| node.id == stop.node);
    let place =
        node.map_or_else(|| format!("node {}", stop.node), |node| name_of(context.model, node));
    let verb = match (stop.action, order.is_handling) {
        (StopAction::None, false) => "to",
        (StopAction::None, true) => "at",
        (StopAction::Pick, false) => "to pick at",
        (StopAction::Pick, true) => "picks at",
        (StopAction::Drop, false) => "to drop at",
        (StopAction::Drop, true) => "drops at",
        (StopAction::Charge, false) => "to charge at",
        (StopAction::Charge, true) => "charges at",
        (StopAction::Park, false) => "to park at",
        (StopAction::Park, true) => "parks at",
    };
    let [number, stops] = order.stop;
    line(ui, &format!("stop {number} of {stops}"), format!("{verb} {place}"));
}

/// Shows a line whose value is a link; `none` without a value. Returns whether it was clicked.
fn link(ui: &mut Ui, name: &str, value: Option<String>) -> bool {
    let Some(value) = value else {
        line(ui, name, "none");
        return false;
    };
    let row = ui.horizontal(|ui| {
        ui.label(style::faint(ui, name));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.link(value).clicked()
        })
        .inner
    });
    row.inner
}

/// Returns the node of a value of the column `goal`, with its index in the world.
fn node_of<'a>(model: &ViewModel<'a>, value: f32) -> Option<(u32, &'a NodeRecord)> {
    let id = GOAL.element(value)?;
    (0..).zip(model.world.nodes()).find(|(_, node)| node.id == id)
}

/// Returns the name of a node, or its id if it has none.
fn name_of(model: &ViewModel<'_>, node: &NodeRecord) -> String {
    match model.world.text(node.name) {
        "" => format!("node {}", node.id),
        name => name.to_owned(),
    }
}
