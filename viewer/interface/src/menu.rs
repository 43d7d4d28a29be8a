//! The menu of a robot, a node or an edge, which a right click opens: commands to the fleet, each
//! undone by the same menu.

use egui::containers::menu::menu_style;
use egui::{Align, Area, Button, Frame, Id, Layout, Order, Pos2, Rect, RichText, Ui};
use regatta_plugin::frame::RobotState;
use regatta_scene::names::{edge_name, node_name};
use regatta_scene::stations::station_at;

use super::camera_controller::Follow;
use super::context::{PanelContext, Request};
use super::style;
use super::view_model::{Action, EngineState, Item, ViewModel};
use crate::commands::UserCommand;

/// The maximum number of robots that one click sends commands to. Each command has an answer.
const MOST_ROBOTS: usize = 64;

/// The width of the menu, in points.
const WIDTH: f32 = 210.0;

/// The menu, as far as it is open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Menu(Option<OpenMenu>);

#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenMenu {
    item: Item,
    /// The place where it was opened, in points.
    at: Pos2,
    /// Whether it has been shown: the click that opened it doesn't close it.
    is_shown: bool,
}

/// An entry of the menu.
struct Entry {
    name: String,
    /// The effect, or the reason for which it is impossible.
    hint: String,
    is_possible: bool,
    commands: Vec<UserCommand>,
}

impl Menu {
    /// Opens the menu of an item, in points of the window.
    pub fn open(&mut self, item: Option<Item>, at: Pos2) {
        self.0 = item.map(|item| OpenMenu { item, at, is_shown: false });
    }

    /// Closes the menu. Returns whether one was open.
    pub fn close(&mut self) -> bool {
        self.0.take().is_some()
    }

    /// Whether a menu is open.
    pub fn is_open(&self) -> bool {
        self.0.is_some()
    }

    /// Shows the open menu, within the part of the picture that no panel covers.
    pub fn show(&mut self, context: &PanelContext<'_>, ctx: &egui::Context, visible: Rect) {
        let Some(menu) = &mut self.0 else { return };
        let mut is_done = false;
        let area = Area::new(Id::unique("menu"))
            .order(Order::Foreground)
            .fixed_pos(menu.at)
            .constrain_to(visible);
        let shown = area.fade_in(false).show(ctx, |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(WIDTH);
                ui.with_layout(Layout::top_down_justified(Align::LEFT), |ui| {
                    menu_style(ui.style_mut());
                    is_done |= rows(context, ui, menu.item);
                });
            });
        });
        let pressed_elsewhere = ctx.input(|input| {
            let at = input.pointer.interact_pos();
            input.pointer.any_pressed() && at.is_some_and(|at| !shown.response.rect.contains(at))
        });
        if !menu.is_shown {
            ctx.request_repaint();
        }
        let closes = is_done || menu.is_shown && pressed_elsewhere;
        menu.is_shown = true;
        if closes {
            self.0 = None;
        }
    }
}

/// Shows the rows of the menu, each as wide as the menu. Returns whether one was clicked.
fn rows(context: &PanelContext<'_>, ui: &mut Ui, item: Item) -> bool {
    ui.label(RichText::new(title(context, item)).strong());
    let mut is_done = false;
    for entry in entries(context, item) {
        is_done |= show_entry(context, ui, entry);
    }
    is_done |= view_entries(context, ui, item);
    if let Some(reason) = unsteerable(context.model) {
        ui.label(style::faint(ui, reason));
    }
    is_done
}

/// The heading, in the names of the panels and the labels.
fn title(context: &PanelContext<'_>, item: Item) -> String {
    let world = &context.model.world;
    match item {
        Item::Robot(robot) => match robots_with(context, robot).len() {
            1 => format!("Robot {robot}"),
            count => format!("Robot {robot} and {} more", count - 1),
        },
        Item::Edge(index) => {
            let edge = world.edges().get(index as usize);
            format!("Edge {}", edge.map_or_else(String::new, |edge| edge_name(world, edge)))
        }
        Item::Node(index) => {
            let node = world.nodes().get(index as usize);
            let node = node.map_or_else(String::new, |node| node_name(world, node));
            match station_at(world, index) {
                Some(station) if station == node => format!("Station {station}"),
                Some(station) => format!("Station {station} (node {node})"),
                None => format!("Node {node}"),
            }
        }
    }
}

/// The robots that a click on one of them means: all selected ones, if it is among them.
fn robots_with(context: &PanelContext<'_>, robot: u32) -> Vec<u32> {
    let mut robots = context.selection.robots();
    if !robots.contains(&robot) {
        return vec![robot];
    }
    robots.truncate(MOST_ROBOTS);
    robots
}

fn entries(context: &PanelContext<'_>, item: Item) -> Vec<Entry> {
    // Plans are watched only of selected robots.
    let model = context.model;
    let is_managed = model.plans.has_goals || context.is_managed;
    match item {
        Item::Robot(robot) => robot_entries(&robots_with(context, robot), robot, is_managed, model),
        Item::Edge(index) => vec![edge_entry(model, index)],
        Item::Node(index) => {
            vec![send_entry(context.selection.robots(), node_id(model, index), is_managed)]
        }
    }
}

/// Shows the commands for a robot or an edge as buttons of the selection panel.
pub(super) fn command_buttons(context: &PanelContext<'_>, ui: &mut Ui, item: Item) {
    ui.horizontal_wrapped(|ui| {
        for entry in entries(context, item) {
            show_entry(context, ui, entry);
        }
    });
}

/// Shows an entry. Returns whether it was clicked.
fn show_entry(context: &PanelContext<'_>, ui: &mut Ui, entry: Entry) -> bool {
    let reason = unsteerable(context.model);
    let button = ui.add_enabled(entry.is_possible && reason.is_none(), Button::new(entry.name));
    let hint = reason.map_or(entry.hint, str::to_owned);
    let is_clicked = button.on_hover_text(&hint).on_disabled_hover_text(&hint).clicked();
    if is_clicked {
        if context.model.is_paused() {
            context.notify("the clock is paused: the fleet takes commands at its next tick");
        }
        for command in entry.commands {
            context.act(Action::Command(command));
        }
    }
    is_clicked
}

/// Shows the entries that change only the view. Returns whether one was clicked.
fn view_entries(context: &PanelContext<'_>, ui: &mut Ui, item: Item) -> bool {
    ui.separator();
    let selects = ui.button("Select").clicked();
    if selects {
        context.ask(Request::Select(Some(item)));
    }
    if let Item::Robot(robot) = item
        && context.model.pose(robot, context.offset).is_some()
        && ui.button("Follow").clicked()
    {
        context.ask(Request::Follow(Some((robot, Follow::Behind))));
        return true;
    }
    selects
}

/// The reason for which this fleet takes no commands now; `None` if it takes them.
fn unsteerable(model: &ViewModel<'_>) -> Option<&'static str> {
    match model.engine {
        _ if model.recording().is_some() => {
            Some("This is a recording: nothing in it can be changed.")
        }
        _ if model.is_past() => {
            Some("This is the past: show the run as it is (U) to give commands.")
        }
        EngineState::Awaited => Some("No engine runs."),
        EngineState::WarmingUp(_) => Some("The run warms up: it begins in a moment."),
        EngineState::Gone => Some("The engine has ended."),
        EngineState::Running | EngineState::Paused | EngineState::Silent => None,
    }
}

fn robot_entries(
    robots: &[u32],
    clicked: u32,
    is_managed: bool,
    model: &ViewModel<'_>,
) -> Vec<Entry> {
    let state = model.frame.map_or(RobotState::Absent, |frame| frame.state_of(clicked as usize));
    let command = |name: &str, hint: &str, command: fn(u32) -> UserCommand| Entry {
        name: name.into(),
        hint: hint.into(),
        is_possible: state != RobotState::Absent,
        commands: robots.iter().map(|robot| command(*robot)).collect(),
    };
    let hold = match state {
        RobotState::Held => command("Resume", "End the hold", UserCommand::Resume),
        // A hold of a broken robot would be invisible, and couldn't be ended before the repair.
        RobotState::Broken => Entry {
            is_possible: false,
            ..command(
                "Hold",
                "The robot stands already: repair it before you hold it",
                UserCommand::Hold,
            )
        },
        _ => command("Hold", "Brake, stand and keep the route until resumed", UserCommand::Hold),
    };
    let repair = match state {
        RobotState::Broken => {
            command("Repair", "Repair the robot: it goes on with its route", UserCommand::Repair)
        }
        _ => command(
            "Break down",
            "Let the robot break down until it is repaired",
            UserCommand::Break,
        ),
    };
    let cancel = match is_managed {
        true => command(
            "Recall",
            "End what the robot was sent for: the fleet manager gives it orders again",
            UserCommand::Recall,
        ),
        false => {
            command("Cancel route", "Drop the route beyond the robot's edge", UserCommand::Cancel)
        }
    };
    vec![hold, repair, cancel]
}

/// The hint of sending a robot while a fleet manager runs. The manager claims space for each robot
/// and stops those that leave theirs, so it has to send them.
const BY_MANAGER: &str = "The fleet manager sends it: at once, or with a load when its order is \
                          finished. Recall takes it back.";

fn send_entry(mut robots: Vec<u32>, node: u32, is_managed: bool) -> Entry {
    robots.truncate(MOST_ROBOTS);
    let (name, hint) = match robots.as_slice() {
        [] => ("Send here".to_owned(), "Select the robot first, then right-click the node"),
        [robot] => (
            format!("Send robot {robot} here"),
            "Along the fastest route of open edges, in forward gear",
        ),
        robots => (
            format!("Send {} robots here", robots.len()),
            "Each along its fastest route of open edges",
        ),
    };
    Entry {
        name,
        hint: if is_managed && !robots.is_empty() { BY_MANAGER } else { hint }.to_owned(),
        is_possible: !robots.is_empty(),
        commands: robots
            .into_iter()
            .map(|robot| match is_managed {
                true => UserCommand::SendByManager { robot, node },
                false => UserCommand::Send { robot, node },
            })
            .collect(),
    }
}

fn edge_entry(model: &ViewModel<'_>, index: u32) -> Entry {
    let id = edge_id(model, index);
    let (name, hint, command) = match model.closed.binary_search(&index) {
        Ok(_) => ("Open edge", "Let robots drive here again", UserCommand::Open(id)),
        Err(_) => (
            "Close edge",
            "No robot enters it, and no new route leads here; robots on it leave it",
            UserCommand::Close(id),
        ),
    };
    Entry { name: name.into(), hint: hint.into(), is_possible: true, commands: vec![command] }
}

fn edge_id(model: &ViewModel<'_>, index: u32) -> u32 {
    model.world.edges().get(index as usize).map_or(u32::MAX, |edge| edge.id)
}

fn node_id(model: &ViewModel<'_>, index: u32) -> u32 {
    model.world.nodes().get(index as usize).map_or(u32::MAX, |node| node.id)
}
