//! The selection panel: everything about the selected robot, edge or node.

use egui::{RichText, Sense, Ui};
use egui_plot::{Line, Plot};
use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{Frame, NO_EDGE, RobotState};
use regatta_plugin::world::{Orientation, Role};
use regatta_scene::names::{edge_name, node_name};
use regatta_scene::route::Remaining;

use super::camera_controller::Follow;
use super::context::{PanelContext, Request};
use super::history::{History, PLOTS, Recorder, SPAN};
use super::menu;
use super::places::{PresenceCounter, list_robots, value_text};
use super::style::{self, activity_colour, heading, line, status_dot};
use super::view_model::Item;
use super::{heat, work};
use crate::text::with_plural;

/// The selection panel.
#[derive(Debug, Default)]
pub(super) struct SelectionPanel {
    history: History,
    /// The recent values of all robots of a fleet that is not too large.
    recorder: Recorder,
    presence: PresenceCounter,
}

impl SelectionPanel {
    /// Records the values of a frame, and those of the selected robot.
    pub fn record(&mut self, frame: &Frame<'_>, robot: Option<u32>) {
        self.recorder.push(frame);
        if let Some(robot) = robot {
            self.history.push(frame, robot, &self.recorder);
        }
    }

    /// Shows the panel.
    pub fn show(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        match context.selection.item {
            Some(Item::Robot(id)) => self.robot(context, ui, id),
            Some(Item::Edge(index)) => self.edge(context, ui, index),
            Some(Item::Node(index)) => self.node(context, ui, index),
            None => _ = ui.label(style::faint(ui, "Click a robot, an edge or a node.")),
        }
    }

    fn robot(&mut self, context: &PanelContext<'_>, ui: &mut Ui, id: u32) {
        ui.label(RichText::new(format!("Robot {id}")).size(20.0));
        other_robots(context, ui);
        let row = id as usize;
        let Some(frame) =
            context.model.frame.filter(|frame| frame.state_of(row) != RobotState::Absent)
        else {
            ui.label(style::faint(ui, "not in the fleet now"));
            return;
        };
        ui.horizontal(|ui| {
            if let Some(activity) = context.model.activity(id) {
                let colour = activity_colour(activity, context.theme);
                status_dot(ui, colour, RichText::new(activity.name()));
            }
            let index = context.model.robot_type_column.and_then(|column| column.get(row));
            let robot_type =
                index.and_then(|index| context.model.world.robot_types().get(*index as usize));
            ui.label(style::faint(ui, robot_type.map_or("", |robot_type| robot_type.name())));
        });
        robot_buttons(context, ui, id);
        menu::command_buttons(context, ui, Item::Robot(id));
        if context.model.is_past() {
            ui.label(style::faint(ui, "Of the past, only poses, states and activities are kept."));
        } else {
            work::show(context, ui);
        }
        heading(ui, "pose");
        let offset = context.offset;
        line(ui, "x", format!("{:.3} m", frame.x()[row] + offset.x));
        line(ui, "y", format!("{:.3} m", frame.y()[row] + offset.y));
        line(ui, "θ", format!("{:.2}°", frame.theta()[row].to_degrees()));
        line(ui, "speed", format!("{:.3} m/s", frame.speed()[row]));
        heading(ui, "on the graph");
        place_on_graph(context, ui, &frame, row);
        if !context.model.is_past() {
            present(context, ui, id);
        }
        heading(ui, "last minute");
        for plot in 0..PLOTS.len() {
            self.plot(context, ui, plot);
        }
    }

    fn plot(&self, context: &PanelContext<'_>, ui: &mut Ui, plot: usize) {
        let (name, unit, span) = PLOTS[plot];
        let [low, high] = self.history.range(plot, span);
        ui.label(style::faint(ui, format!("{name} [{unit}]")));
        Plot::new(("plot", plot))
            .height(64.0)
            .show_axes([false, true])
            .show_grid([false, true])
            .y_axis_min_width(34.0)
            .include_x(-SPAN)
            .include_x(0.0)
            .include_y(low)
            .include_y(high)
            .sense(Sense::hover())
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .show_background(false)
            .show(ui, |axes| {
                for points in self.history.lines(plot) {
                    axes.line(Line::new(name, points).color(context.colours.accent).width(1.5));
                }
            });
    }

    fn edge(&mut self, context: &PanelContext<'_>, ui: &mut Ui, index: u32) {
        let Some(edge) = context.model.world.edges().get(index as usize) else {
            ui.label(style::faint(ui, "this edge no longer exists"));
            return;
        };
        let name = edge_name(&context.model.world, edge);
        ui.label(RichText::new(format!("Edge {name}")).size(20.0));
        texts(context, ui, [edge.level, edge.zone]);
        id_beside(ui, &name, edge.id);
        if context.model.closed.binary_search(&index).is_ok() {
            ui.label(RichText::new("closed: no robot may enter it").color(context.colours.bad));
        }
        menu::command_buttons(context, ui, Item::Edge(index));
        line(ui, "length", format!("{:.3} m", edge.length));
        line(ui, "forward", format!("{:.2} m/s", edge.speed));
        let backwards = edge.reverse_speed;
        line(
            ui,
            "in reverse",
            if backwards > 0.0 { format!("{backwards:.2} m/s") } else { "not allowed".into() },
        );
        match edge.orientation() {
            Orientation::Tangential => {}
            Orientation::Offset(angle) => {
                line(ui, "heading", format!("tangent + {:.1}°", angle.to_degrees()))
            }
            Orientation::Fixed(angle) => line(ui, "heading", format!("{:.1}°", angle.to_degrees())),
        }
        list_robots(context, ui, "robots on it", self.presence.on_edge(context.model, index));
        heat::edge_traffic(context, ui, index);
        heading(ui, "nodes");
        for (end, node) in [("from", edge.origin), ("to", edge.destination)] {
            let Some(record) = context.model.world.nodes().get(node as usize) else { continue };
            ui.horizontal(|ui| {
                ui.label(style::faint(ui, end));
                let name = node_name(&context.model.world, record);
                if ui.link(format!("node {name}")).clicked() {
                    context.ask(Request::Select(Some(Item::Node(node))));
                }
            });
        }
    }

    fn node(&mut self, context: &PanelContext<'_>, ui: &mut Ui, index: u32) {
        let Some(node) = context.model.world.nodes().get(index as usize) else {
            ui.label(style::faint(ui, "this node no longer exists"));
            return;
        };
        let name = node_name(&context.model.world, node);
        ui.label(RichText::new(format!("Node {name}")).size(20.0));
        stations(context, ui, index);
        texts(context, ui, [node.level, node.zone]);
        id_beside(ui, &name, node.id);
        if node.role() != Role::None {
            line(ui, "role", node.role().name());
        }
        let offset = context.offset;
        line(ui, "x", format!("{:.3} m", node.x + offset.x));
        line(ui, "y", format!("{:.3} m", node.y + offset.y));
        line(ui, "θ", format!("{:.2}°", node.theta.to_degrees()));
        let present = self.presence.at_node(context.model, index);
        list_robots(context, ui, "robots over it", present);
        heading(ui, "edges");
        let edges = context
            .model
            .world
            .edges()
            .iter()
            .enumerate()
            .filter(|(_, edge)| [edge.origin, edge.destination].contains(&index));
        for (i, edge) in edges.take(32) {
            let direction = if edge.origin == index { "out" } else { "in" };
            ui.horizontal(|ui| {
                ui.label(style::faint(ui, direction));
                let name = edge_name(&context.model.world, edge);
                if ui.link(format!("edge {name}")).clicked() {
                    context.ask(Request::Select(Some(Item::Edge(i as u32))));
                }
            });
        }
    }
}

/// Shows the other names of a node: those of its stations.
fn stations(context: &PanelContext<'_>, ui: &mut Ui, index: u32) {
    let world = &context.model.world;
    for other in world.other_names().iter().filter(|other| other.node == index) {
        line(ui, "station", world.text(other.name));
    }
}

/// Shows the id of something that has a name.
fn id_beside(ui: &mut Ui, name: &str, id: u32) {
    let id = id.to_string();
    if name != id {
        line(ui, "id", id);
    }
}

/// Shows facts that are known of the present only: route, collisions, and columns of plugins.
fn present(context: &PanelContext<'_>, ui: &mut Ui, id: u32) {
    route(context, ui);
    robot_collisions(context, ui, id);
    let others: Vec<_> = context
        .model
        .values
        .iter()
        .filter(|(name, _)| !work::COLUMNS.contains(&name.as_str()))
        .collect();
    if !others.is_empty() {
        heading(ui, "columns");
        for (name, value) in others {
            line(ui, name.as_str(), value_text(name, *value, context.theme));
        }
    }
}

/// Lists the other selected robots; a click on one describes it.
fn other_robots(context: &PanelContext<'_>, ui: &mut Ui) {
    if context.selection.others().is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label(style::faint(ui, "also selected:"));
        for id in context.selection.others() {
            if ui.link(id.to_string()).clicked() {
                context.ask(Request::Describe(*id));
            }
        }
    });
}

fn robot_buttons(context: &PanelContext<'_>, ui: &mut Ui, id: u32) {
    ui.horizontal(|ui| {
        if ui.button("Fly there").on_hover_text("Key J").clicked() {
            context.ask(Request::FlyToSelected);
        }
        let followed = context.followed.filter(|(robot, _)| *robot == id).map(|(_, follow)| follow);
        for (follow, name) in [(Follow::Behind, "Behind"), (Follow::Above, "Above")] {
            if ui.selectable_label(followed == Some(follow), name).on_hover_text("Key F").clicked()
            {
                let wanted = (followed != Some(follow)).then_some((id, follow));
                context.ask(Request::Follow(wanted));
            }
        }
    });
}

fn place_on_graph(context: &PanelContext<'_>, ui: &mut Ui, frame: &Frame<'_>, row: usize) {
    let index = frame.edge()[row];
    let Some(edge) = context.model.world.edges().get(index as usize).filter(|_| index != NO_EDGE)
    else {
        line(ui, "edge", "none");
        return;
    };
    let world = &context.model.world;
    line(ui, "edge", edge_name(world, edge));
    for (end, node) in [("from", edge.origin), ("to", edge.destination)] {
        let node = world.nodes().get(node as usize);
        line(ui, end, node.map_or("–".to_owned(), |node| node_name(world, node)));
    }
    line(ui, "driven", format!("{:.2} of {:.2} m", frame.s()[row], edge.length));
    if ui.link("show the edge").clicked() {
        context.ask(Request::Select(Some(Item::Edge(index))));
    }
}

fn route(context: &PanelContext<'_>, ui: &mut Ui) {
    let Some(route) = context.model.route else { return };
    heading(ui, "route");
    if route == Remaining::default() {
        ui.label(style::faint(ui, "no route"));
        return;
    }
    for (name, part) in [("released", route.released), ("planned", route.planned)] {
        let more = if part.is_partial { "> " } else { "" };
        line(
            ui,
            name,
            format!("{}, {more}{:.1} m", with_plural(part.edges.into(), "edge"), part.metres),
        );
    }
}

fn robot_collisions(context: &PanelContext<'_>, ui: &mut Ui, id: u32) {
    let Some(contacts) = context.model.contacts else { return };
    let colours = context.colours;
    heading(ui, "collisions");
    let pairs = contacts.pairs.iter().filter(|pair| pair.robots.contains(&id)).take(6);
    let mut next = None;
    let mut is_empty = true;
    for pair in pairs {
        is_empty = false;
        let other = if pair.robots[0] == id { pair.robots[1] } else { pair.robots[0] };
        let touching = pair.level == ContactLevel::Touching as u32;
        let (word, colour) =
            if touching { ("touches", colours.bad) } else { ("may touch", colours.warn) };
        ui.horizontal(|ui| {
            ui.label(RichText::new(word).color(colour));
            if ui.link(format!("robot {other}")).clicked() {
                next = Some(other);
            }
            ui.label(style::faint(ui, format!("{:.2} m/s", pair.relative_speed)));
        });
    }
    if is_empty {
        ui.label(style::faint(ui, "none now"));
    }
    if let Some(other) = next {
        context.ask(Request::Select(Some(Item::Robot(other))));
    }
}

/// Shows the level and the zone of a node or an edge, if it has them.
fn texts(context: &PanelContext<'_>, ui: &mut Ui, offsets: [u32; 2]) {
    for (name, offset) in ["level", "zone"].into_iter().zip(offsets) {
        let text = context.model.world.text(offset);
        if !text.is_empty() {
            line(ui, name, text);
        }
    }
}
