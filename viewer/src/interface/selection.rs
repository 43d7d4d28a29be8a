//! What is selected: all that is known of a robot, an edge or a node.

use std::collections::VecDeque;

use egui::{RichText, Ui};
use egui_plot::{Line, Plot, PlotPoints};
use regatta_plugin::contact::ContactLevel;
use regatta_plugin::frame::{Frame, NO_EDGE, RobotState};

use super::Interface;
use super::facts::{Facts, Thing};
use super::fleet_list::{dot, state_colour};
use super::rig::Follow;
use super::rows::state_name;
use super::style::{self, heading, line};
use crate::route::Remaining;

/// Simulated seconds that the plots show.
const SPAN: f64 = 60.0;
/// Least simulated seconds between two points.
const GAP: f64 = 0.05;
/// What is plotted: its name, its unit, and the least span of its axis.
const PLOTS: [(&str, &str, f64); 4] = [("x", "m", 1.0), ("y", "m", 1.0), ("θ", "°", 20.0), ("speed", "m/s", 0.5)];
/// The heading among them.
const THETA: usize = 2;

/// Where a robot was during the last minute.
#[derive(Clone, Debug, Default)]
pub struct History {
    of: Option<(u64, u32)>,
    /// Simulated seconds, then what [`PLOTS`] names.
    points: VecDeque<[f64; 5]>,
}

impl History {
    /// Takes a frame; begins anew if the robot or the run is another one, or time went back.
    pub fn push(&mut self, frame: &Frame<'_>, robot: u32) {
        let (row, now) = (robot as usize, frame.sim_time().as_secs_f64());
        let of = Some((frame.run_id(), robot));
        let last = self.points.back().map_or(f64::NEG_INFINITY, |point| point[0]);
        if self.of != of || now < last {
            *self = Self { of, points: VecDeque::new() };
        } else if now < last + GAP {
            return;
        }
        if frame.state_of(row) == RobotState::Absent {
            return;
        }
        let values = [frame.x()[row], frame.y()[row], frame.theta()[row].to_degrees(), frame.speed()[row]];
        let [x, y, theta, speed] = values.map(f64::from);
        self.points.push_back([now, x, y, theta, speed]);
        while self.points.front().is_some_and(|point| point[0] < now - SPAN) {
            self.points.pop_front();
        }
    }

    /// The least and the largest value of one plot, at least `span` apart.
    fn range(&self, which: usize, span: f64) -> [f64; 2] {
        let values = self.points.iter().map(|point| point[which + 1]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).max(span / 2.0));
        if low <= high { [middle - half, middle + half] } else { [0.0, span] }
    }

    /// Lines of one plot: seconds before now, and the value. Where an angle goes on at the other end of its range, a new
    /// line begins.
    fn series(&self, which: usize) -> Vec<PlotPoints<'static>> {
        let now = self.points.back().map_or(0.0, |point| point[0]);
        let points: Vec<_> = self.points.iter().map(|point| [point[0] - now, point[which + 1]]).collect();
        let goes_on = |a: &[f64; 2], b: &[f64; 2]| which != THETA || (a[1] - b[1]).abs() < 180.0;
        points.chunk_by(goes_on).map(|part| PlotPoints::from(part.to_vec())).collect()
    }
}

impl Interface {
    pub(super) fn selection(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        match self.selected {
            Some(Thing::Robot(id)) => self.robot(ui, facts, id),
            Some(Thing::Edge(index)) => self.edge(ui, facts, index),
            Some(Thing::Node(index)) => self.node(ui, facts, index),
            None => {
                ui.label(style::faint(ui, self.settings.theme(), "Click a robot, an edge or a node."));
            }
        }
    }

    fn robot(&mut self, ui: &mut Ui, facts: &Facts<'_>, id: u32) {
        let (theme, tones) = (self.settings.theme(), self.tones());
        ui.label(RichText::new(format!("Robot {id}")).size(20.0));
        self.others(ui);
        let row = id as usize;
        let Some(frame) = facts.frame.filter(|frame| frame.state_of(row) != RobotState::Absent) else {
            ui.label(style::faint(ui, theme, "is not in the fleet now"));
            return;
        };
        let state = frame.state_of(row);
        ui.horizontal(|ui| {
            dot(ui, state_colour(state, &tones), RichText::new(state_name(state)));
            let kind = facts.kinds.and_then(|kinds| kinds.get(row)).and_then(|kind| facts.types.get(*kind as usize));
            ui.label(style::faint(ui, theme, kind.map_or("", |kind| kind.name())));
        });
        self.robot_buttons(ui, facts, id);
        heading(ui, theme, "pose");
        let offset = self.settings.offset;
        line(ui, theme, "x", format!("{:.3} m", frame.x()[row] + offset[0]));
        line(ui, theme, "y", format!("{:.3} m", frame.y()[row] + offset[1]));
        line(ui, theme, "θ", format!("{:.2}°", frame.theta()[row].to_degrees()));
        line(ui, theme, "speed", format!("{:.3} m/s", frame.speed()[row]));
        heading(ui, theme, "on the graph");
        self.place_on_graph(ui, facts, &frame, row);
        self.route(ui, facts);
        self.robot_collisions(ui, facts, id);
        if !facts.values.is_empty() {
            heading(ui, theme, "columns");
            for (name, value) in facts.values {
                line(ui, theme, &name.to_string(), format!("{value:.3}"));
            }
        }
        heading(ui, theme, "last minute");
        for (which, (name, unit, span)) in PLOTS.into_iter().enumerate() {
            self.plot(ui, which, name, unit, span);
        }
    }

    /// The robots that are selected beside the one that is shown: a click shows one of them.
    fn others(&mut self, ui: &mut Ui) {
        let theme = self.settings.theme();
        let mut clicked = None;
        if !self.beside.is_empty() {
            ui.horizontal_wrapped(|ui| {
                ui.label(style::faint(ui, theme, "and"));
                for id in &self.beside {
                    clicked = ui.link(id.to_string()).clicked().then_some(*id).or(clicked);
                }
            });
        }
        if let (Some(id), Some(Thing::Robot(shown))) = (clicked, self.selected) {
            self.beside.retain(|robot| *robot != id);
            self.beside.insert(0, shown);
            self.selected = Some(Thing::Robot(id));
        }
    }

    fn robot_buttons(&mut self, ui: &mut Ui, facts: &Facts<'_>, id: u32) {
        ui.horizontal(|ui| {
            if ui.button("Fly there").on_hover_text("J").clicked() {
                self.fly_to_selected(facts);
            }
            let followed = self.rig.followed().filter(|(robot, _)| *robot == id).map(|(_, how)| how);
            for (how, name) in [(Follow::Behind, "Behind"), (Follow::Above, "Above")] {
                if ui.selectable_label(followed == Some(how), name).on_hover_text("F").clicked() {
                    self.rig.follow((followed != Some(how)).then_some((id, how)));
                }
            }
        });
    }

    fn place_on_graph(&mut self, ui: &mut Ui, facts: &Facts<'_>, frame: &Frame<'_>, row: usize) {
        let (theme, index) = (self.settings.theme(), frame.edge()[row]);
        let Some(edge) = facts.edges.get(index as usize).filter(|_| index != NO_EDGE) else {
            line(ui, theme, "edge", "none");
            return;
        };
        line(ui, theme, "edge", edge.id.to_string());
        let ids = [edge.origin, edge.destination].map(|node| facts.nodes.get(node as usize).map_or(0, |node| node.id));
        line(ui, theme, "from, to", format!("{} → {}", ids[0], ids[1]));
        line(ui, theme, "driven", format!("{:.2} of {:.2} m", frame.s()[row], edge.length));
        if ui.link("show the edge").clicked() {
            self.select(Some(Thing::Edge(index)));
        }
    }

    fn route(&self, ui: &mut Ui, facts: &Facts<'_>) {
        let (Some(route), theme) = (facts.route, self.settings.theme()) else { return };
        heading(ui, theme, "route");
        if route == Remaining::default() {
            ui.label(style::faint(ui, theme, "nothing to drive"));
            return;
        }
        for (name, way) in [("released", route.released), ("planned", route.planned)] {
            let noun = if way.edges == 1 { "edge" } else { "edges" };
            let more = if way.is_partial { "> " } else { "" };
            line(ui, theme, name, format!("{} {noun}, {more}{:.1} m", way.edges, way.metres));
        }
    }

    fn robot_collisions(&mut self, ui: &mut Ui, facts: &Facts<'_>, id: u32) {
        let Some(contacts) = facts.contacts else { return };
        let (theme, tones) = (self.settings.theme(), self.tones());
        heading(ui, theme, "collisions");
        let mine = contacts.pairs.iter().filter(|pair| pair.robots.contains(&id)).take(6);
        let mut next = None;
        let mut none = true;
        for pair in mine {
            none = false;
            let other = if pair.robots[0] == id { pair.robots[1] } else { pair.robots[0] };
            let touching = pair.level == ContactLevel::Touching as u32;
            let (word, colour) = if touching { ("touches", tones.bad) } else { ("may touch", tones.warn) };
            ui.horizontal(|ui| {
                ui.label(RichText::new(word).color(colour));
                if ui.link(format!("robot {other}")).clicked() {
                    next = Some(other);
                }
                ui.label(style::faint(ui, theme, format!("{:.2} m/s", pair.relative_speed)));
            });
        }
        if none {
            ui.label(style::faint(ui, theme, "none now"));
        }
        if let Some(other) = next {
            self.select(Some(Thing::Robot(other)));
        }
    }

    fn plot(&self, ui: &mut Ui, which: usize, name: &str, unit: &str, span: f64) {
        let (tones, [low, high]) = (self.tones(), self.history.range(which, span));
        ui.label(style::faint(ui, self.settings.theme(), format!("{name} [{unit}]")));
        Plot::new(("plot", which))
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
            .show(ui, |plot| {
                for part in self.history.series(which) {
                    plot.line(Line::new(name, part).color(tones.accent).width(1.5));
                }
            });
    }

    fn edge(&mut self, ui: &mut Ui, facts: &Facts<'_>, index: u32) {
        let theme = self.settings.theme();
        let Some(edge) = facts.edges.get(index as usize) else {
            ui.label(style::faint(ui, theme, "this edge is gone"));
            return;
        };
        ui.label(RichText::new(format!("Edge {}", edge.id)).size(20.0));
        line(ui, theme, "length", format!("{:.3} m", edge.length));
        line(ui, theme, "forward", format!("{:.2} m/s", edge.velocity_forward));
        let backwards = edge.velocity_backwards;
        line(
            ui,
            theme,
            "in reverse",
            if backwards > 0.0 { format!("{backwards:.2} m/s") } else { "not allowed".into() },
        );
        heading(ui, theme, "nodes");
        for (word, node) in [("from", edge.origin), ("to", edge.destination)] {
            let Some(record) = facts.nodes.get(node as usize) else { continue };
            ui.horizontal(|ui| {
                ui.label(style::faint(ui, theme, word));
                if ui.link(format!("node {}", record.id)).clicked() {
                    self.select(Some(Thing::Node(node)));
                }
            });
        }
    }

    fn node(&mut self, ui: &mut Ui, facts: &Facts<'_>, index: u32) {
        let theme = self.settings.theme();
        let Some(node) = facts.nodes.get(index as usize) else {
            ui.label(style::faint(ui, theme, "this node is gone"));
            return;
        };
        ui.label(RichText::new(format!("Node {}", node.id)).size(20.0));
        let offset = self.settings.offset;
        line(ui, theme, "x", format!("{:.3} m", node.x + offset[0]));
        line(ui, theme, "y", format!("{:.3} m", node.y + offset[1]));
        line(ui, theme, "θ", format!("{:.2}°", node.theta.to_degrees()));
        heading(ui, theme, "edges");
        let touching =
            facts.edges.iter().enumerate().filter(|(_, edge)| [edge.origin, edge.destination].contains(&index));
        for (i, edge) in touching.take(32) {
            let word = if edge.origin == index { "out" } else { "in" };
            ui.horizontal(|ui| {
                ui.label(style::faint(ui, theme, word));
                if ui.link(format!("edge {}", edge.id)).clicked() {
                    self.select(Some(Thing::Edge(i as u32)));
                }
            });
        }
    }
}
