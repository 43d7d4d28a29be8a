//! The selection panel: everything about the selected robot, edge or node.

use egui::{RichText, Ui};
use egui_plot::{Line, Plot};
use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{Frame, NO_EDGE, RobotState};
use regatta_plugin::world::{Orientation, Role};
use regatta_scene::route::Remaining;

use super::camera_controller::Follow;
use super::history::{PLOTS, SPAN};
use super::places::value_text;
use super::state::Interface;
use super::style::{self, heading, line, state_colour, status_dot};
use super::view_model::{Action, Item, ViewModel};
use super::work;
use crate::text::with_plural;

impl Interface {
    pub(super) fn selection(
        &mut self,
        ui: &mut Ui,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        match self.selected {
            Some(Item::Robot(id)) => self.robot(ui, model, id, actions),
            Some(Item::Edge(index)) => self.edge(ui, model, index, actions),
            Some(Item::Node(index)) => self.node(ui, model, index),
            None => {
                ui.label(style::faint(
                    ui,
                    self.settings.theme(),
                    "Click a robot, an edge or a node.",
                ));
            }
        }
    }

    fn robot(&mut self, ui: &mut Ui, model: &ViewModel<'_>, id: u32, actions: &mut Vec<Action>) {
        let theme = self.settings.theme();
        ui.label(RichText::new(format!("Robot {id}")).size(20.0));
        self.other_robots(ui);
        let row = id as usize;
        let Some(frame) = model.frame.filter(|frame| frame.state_of(row) != RobotState::Absent)
        else {
            ui.label(style::faint(ui, theme, "not in the fleet now"));
            return;
        };
        let state = frame.state_of(row);
        ui.horizontal(|ui| {
            status_dot(ui, state_colour(state, theme), RichText::new(state.name()));
            let index = model.robot_type_column.and_then(|column| column.get(row));
            let robot_type = index.and_then(|index| model.world.robot_types().get(*index as usize));
            ui.label(style::faint(
                ui,
                theme,
                robot_type.map_or("", |robot_type| robot_type.name()),
            ));
        });
        self.robot_buttons(ui, model, id);
        self.command_buttons(ui, Item::Robot(id), model, actions);
        if model.is_past() {
            ui.label(style::faint(ui, theme, "Of the past, only poses and states are kept."));
        } else {
            self.work(ui, model);
        }
        heading(ui, theme, "pose");
        let offset = self.settings.offset;
        line(ui, theme, "x", format!("{:.3} m", frame.x()[row] + offset[0]));
        line(ui, theme, "y", format!("{:.3} m", frame.y()[row] + offset[1]));
        line(ui, theme, "θ", format!("{:.2}°", frame.theta()[row].to_degrees()));
        line(ui, theme, "speed", format!("{:.3} m/s", frame.speed()[row]));
        heading(ui, theme, "on the graph");
        self.place_on_graph(ui, model, &frame, row);
        if !model.is_past() {
            self.present(ui, model, id);
        }
        heading(ui, theme, "last minute");
        for (plot, (name, unit, span)) in PLOTS.into_iter().enumerate() {
            self.plot(ui, plot, name, unit, span);
        }
    }

    /// What is known of a robot now, and not of the past: its route, its collisions, and what
    /// plugins say of it.
    fn present(&mut self, ui: &mut Ui, model: &ViewModel<'_>, id: u32) {
        let theme = self.settings.theme();
        self.route(ui, model);
        self.robot_collisions(ui, model, id);
        let others: Vec<_> = model
            .values
            .iter()
            .filter(|(name, _)| !work::COLUMNS.contains(&name.as_str()))
            .collect();
        if !others.is_empty() {
            heading(ui, theme, "columns");
            for (name, value) in others {
                line(ui, theme, name.as_str(), value_text(name, *value, theme));
            }
        }
    }

    /// Lists the other selected robots; a click on one shows it.
    fn other_robots(&mut self, ui: &mut Ui) {
        let theme = self.settings.theme();
        let mut clicked = None;
        if !self.also_selected.is_empty() {
            ui.horizontal_wrapped(|ui| {
                ui.label(style::faint(ui, theme, "also selected:"));
                for id in &self.also_selected {
                    clicked = ui.link(id.to_string()).clicked().then_some(*id).or(clicked);
                }
            });
        }
        if let (Some(id), Some(Item::Robot(shown))) = (clicked, self.selected) {
            self.also_selected.retain(|robot| *robot != id);
            self.also_selected.insert(0, shown);
            self.selected = Some(Item::Robot(id));
        }
    }

    fn robot_buttons(&mut self, ui: &mut Ui, model: &ViewModel<'_>, id: u32) {
        ui.horizontal(|ui| {
            if ui.button("Fly there").on_hover_text("Key J").clicked() {
                self.fly_to_selected(model);
            }
            let followed = self
                .camera_controller
                .followed()
                .filter(|(robot, _)| *robot == id)
                .map(|(_, follow)| follow);
            for (follow, name) in [(Follow::Behind, "Behind"), (Follow::Above, "Above")] {
                if ui
                    .selectable_label(followed == Some(follow), name)
                    .on_hover_text("Key F")
                    .clicked()
                {
                    self.camera_controller
                        .follow((followed != Some(follow)).then_some((id, follow)));
                }
            }
        });
    }

    fn place_on_graph(
        &mut self,
        ui: &mut Ui,
        model: &ViewModel<'_>,
        frame: &Frame<'_>,
        row: usize,
    ) {
        let (theme, index) = (self.settings.theme(), frame.edge()[row]);
        let Some(edge) = model.world.edges().get(index as usize).filter(|_| index != NO_EDGE)
        else {
            line(ui, theme, "edge", "none");
            return;
        };
        line(ui, theme, "edge", edge.id.to_string());
        let ids = [edge.origin, edge.destination]
            .map(|node| model.world.nodes().get(node as usize).map_or(0, |node| node.id));
        line(ui, theme, "from, to", format!("{} → {}", ids[0], ids[1]));
        line(ui, theme, "driven", format!("{:.2} of {:.2} m", frame.s()[row], edge.length));
        if ui.link("show the edge").clicked() {
            self.select(Some(Item::Edge(index)));
        }
    }

    fn route(&self, ui: &mut Ui, model: &ViewModel<'_>) {
        let (Some(route), theme) = (model.route, self.settings.theme()) else { return };
        heading(ui, theme, "route");
        if route == Remaining::default() {
            ui.label(style::faint(ui, theme, "nothing left to drive"));
            return;
        }
        for (name, part) in [("released", route.released), ("planned", route.planned)] {
            let more = if part.is_partial { "> " } else { "" };
            line(
                ui,
                theme,
                name,
                format!("{}, {more}{:.1} m", with_plural(part.edges.into(), "edge"), part.metres),
            );
        }
    }

    fn robot_collisions(&mut self, ui: &mut Ui, model: &ViewModel<'_>, id: u32) {
        let Some(contacts) = model.contacts else { return };
        let (theme, colours) = (self.settings.theme(), self.colours());
        heading(ui, theme, "collisions");
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
                ui.label(style::faint(ui, theme, format!("{:.2} m/s", pair.relative_speed)));
            });
        }
        if is_empty {
            ui.label(style::faint(ui, theme, "none now"));
        }
        if let Some(other) = next {
            self.select(Some(Item::Robot(other)));
        }
    }

    fn plot(&self, ui: &mut Ui, plot: usize, name: &str, unit: &str, span: f64) {
        let (colours, [low, high]) = (self.colours(), self.history.range(plot, span));
        ui.label(style::faint(ui, self.settings.theme(), format!("{name} [{unit}]")));
        Plot::new(("plot", plot))
            .height(64.0)
            .show_axes([false, true])
            .show_grid([false, true])
            .y_axis_min_width(34.0)
            .include_x(-SPAN)
            .include_x(0.0)
            .include_y(low)
            .include_y(high)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .show_background(false)
            .show(ui, |axes| {
                for points in self.history.lines(plot) {
                    axes.line(Line::new(name, points).color(colours.accent).width(1.5));
                }
            });
    }

    fn edge(&mut self, ui: &mut Ui, model: &ViewModel<'_>, index: u32, actions: &mut Vec<Action>) {
        let theme = self.settings.theme();
        let Some(edge) = model.world.edges().get(index as usize) else {
            ui.label(style::faint(ui, theme, "this edge no longer exists"));
            return;
        };
        ui.label(RichText::new(format!("Edge {}", edge.id)).size(20.0));
        self.texts(ui, model, [edge.name, edge.level, edge.zone]);
        if model.closed.binary_search(&index).is_ok() {
            ui.label(RichText::new("closed: no robot may enter it").color(self.colours().bad));
        }
        self.command_buttons(ui, Item::Edge(index), model, actions);
        line(ui, theme, "length", format!("{:.3} m", edge.length));
        line(ui, theme, "forward", format!("{:.2} m/s", edge.speed));
        let backwards = edge.reverse_speed;
        line(
            ui,
            theme,
            "in reverse",
            if backwards > 0.0 { format!("{backwards:.2} m/s") } else { "not allowed".into() },
        );
        match edge.orientation() {
            Orientation::Tangential => {}
            Orientation::Offset(angle) => {
                line(ui, theme, "heading", format!("tangent + {:.1}°", angle.to_degrees()))
            }
            Orientation::Fixed(angle) => {
                line(ui, theme, "heading", format!("{:.1}°", angle.to_degrees()))
            }
        }
        self.robots_on_edge(ui, model, index);
        self.edge_traffic(ui, model, index);
        heading(ui, theme, "nodes");
        for (end, node) in [("from", edge.origin), ("to", edge.destination)] {
            let Some(record) = model.world.nodes().get(node as usize) else { continue };
            ui.horizontal(|ui| {
                ui.label(style::faint(ui, theme, end));
                if ui.link(format!("node {}", record.id)).clicked() {
                    self.select(Some(Item::Node(node)));
                }
            });
        }
    }

    /// Shows the name, the level and the zone of a node or an edge, as far as it has them.
    fn texts(&self, ui: &mut Ui, model: &ViewModel<'_>, offsets: [u32; 3]) {
        for (name, offset) in ["name", "level", "zone"].into_iter().zip(offsets) {
            let text = model.world.text(offset);
            if !text.is_empty() {
                line(ui, self.settings.theme(), name, text);
            }
        }
    }

    fn node(&mut self, ui: &mut Ui, model: &ViewModel<'_>, index: u32) {
        let theme = self.settings.theme();
        let Some(node) = model.world.nodes().get(index as usize) else {
            ui.label(style::faint(ui, theme, "this node no longer exists"));
            return;
        };
        ui.label(RichText::new(format!("Node {}", node.id)).size(20.0));
        self.texts(ui, model, [node.name, node.level, node.zone]);
        if node.role() != Role::None {
            line(ui, theme, "role", node.role().name());
        }
        let offset = self.settings.offset;
        line(ui, theme, "x", format!("{:.3} m", node.x + offset[0]));
        line(ui, theme, "y", format!("{:.3} m", node.y + offset[1]));
        line(ui, theme, "θ", format!("{:.2}°", node.theta.to_degrees()));
        self.robots_at_node(ui, model, index, node);
        heading(ui, theme, "edges");
        let edges = model
            .world
            .edges()
            .iter()
            .enumerate()
            .filter(|(_, edge)| [edge.origin, edge.destination].contains(&index));
        for (i, edge) in edges.take(32) {
            let direction = if edge.origin == index { "out" } else { "in" };
            ui.horizontal(|ui| {
                ui.label(style::faint(ui, theme, direction));
                if ui.link(format!("edge {}", edge.id)).clicked() {
                    self.select(Some(Item::Edge(i as u32)));
                }
            });
        }
    }
}
