//! The part of the selection panel about the work that a fleet manager gives a robot.

use egui::Ui;
use regatta_plugin::activity::Activity;
use regatta_plugin::column::{ACTIVITY, BATTERY, GOAL, WAITS_FOR};
use regatta_plugin::order::StopAction;
use regatta_plugin::world::NodeRecord;
use regatta_scene::stations::station_at;

use super::context::{PanelContext, Request};
use super::style::{self, heading, line};
use super::view_model::{Item, ViewModel};

/// The columns that this part shows.
pub const COLUMNS: [&str; 4] = [ACTIVITY.name(), WAITS_FOR.name(), GOAL.name(), BATTERY.name()];

/// Shows the order, the goal, the blocker and the battery of the selected robot, as far as it has
/// them and they are published.
pub(super) fn show(context: &PanelContext<'_>, ui: &mut Ui) {
    let [activity, waits_for, goal, battery] = COLUMNS.map(|name| context.model.value(name));
    let goal = goal.filter(|_| !is_idle(activity));
    let goal = goal.and_then(|goal| node_of(context.model, goal));
    let blocker = waits_for.and_then(|other| WAITS_FOR.element(other));
    let charge = battery.and_then(|value| BATTERY.element(value));
    let has_order = context.model.order.is_some() || context.model.named_order.is_some();
    if !has_order && goal.is_none() && blocker.is_none() && charge.is_none() {
        return;
    }
    heading(ui, "work");
    order(context, ui);
    let mut next = None;
    if let Some((index, node)) = goal
        && link(ui, "goal", name_of(context.model, node))
    {
        next = Some(Item::Node(index));
    }
    if let Some(other) = blocker
        && link(ui, "waits for", format!("robot {other}"))
    {
        next = Some(Item::Robot(other));
    }
    if let Some(charge) = charge {
        line(ui, "battery", format!("{charge:.0} %"));
    }
    if next.is_some() {
        context.ask(Request::Select(next));
    }
}

/// Whether a robot with this value of the column `activity` has nothing to do. Its last goal is
/// where it stands.
fn is_idle(activity: Option<f32>) -> bool {
    activity.and_then(|value| ACTIVITY.element(value)) == Some(Activity::Idle)
}

fn order(context: &PanelContext<'_>, ui: &mut Ui) {
    let (logged, named) = (context.model.order, context.model.named_order);
    // The log tells changes at once, but knows no stops of orders that began before this window.
    let complete = logged.filter(|order| order.next.is_some());
    let Some(order) = complete.or(named.map(|named| named.order)).or(logged) else { return };
    let name = named.map_or_else(|| order.number.to_string(), |named| named.name.clone());
    line(ui, "order", name);
    let Some(stop) = order.next else { return };
    let node = (0..).zip(context.model.world.nodes()).find(|(_, node)| node.id == stop.node);
    let place = node.map_or_else(
        || format!("node {}", stop.node),
        |(index, node)| {
            // The picture has the name of the station that is served from the node.
            let station = station_at(&context.model.world, index);
            station.unwrap_or_else(|| name_of(context.model, node))
        },
    );
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

/// Shows a line whose value is a link. Returns whether it was clicked.
fn link(ui: &mut Ui, name: &str, value: String) -> bool {
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
