//! The robots on a selected edge or at a selected node, and the values of columns in words.

use egui::Ui;
use glam::Vec2;
use regatta_plugin::ColumnName;
use regatta_plugin::world::NodeRecord;
use regatta_scene::palette::{Colouring, Scale, Theme};

use super::robot_spots;
use super::state::Interface;
use super::style::{self, heading};
use super::view_model::{Item, ViewModel};
use crate::jams::Presence;
use crate::text::thousands;

/// The robots at a place in a frame of the past, which no thread watches: the place, the run and
/// the tick.
pub(super) type PastPresence = Option<((Item, u64, u64), Presence)>;

impl Interface {
    /// The edges and the node whose robots are shown, by their indices in the world.
    pub fn watched_places(&self) -> (Vec<u32>, Option<u32>) {
        let (edge, node) = match self.selected {
            Some(Item::Edge(edge)) => (Some(edge), None),
            Some(Item::Node(node)) => (None, Some(node)),
            _ => (None, None),
        };
        let hovered = self.edge_hover.edge().filter(|hovered| Some(*hovered) != edge);
        (edge.into_iter().chain(hovered).collect(), node)
    }

    /// Lists the robots on an edge.
    pub(super) fn robots_on_edge(&mut self, ui: &mut Ui, model: &ViewModel<'_>, index: u32) {
        let present = self.present_on_edge(model, index);
        self.list_robots(ui, model, "robots on it", present);
    }

    /// Lists the robots that stand over a node.
    pub(super) fn robots_at_node(
        &mut self,
        ui: &mut Ui,
        model: &ViewModel<'_>,
        index: u32,
        node: &NodeRecord,
    ) {
        let present = if model.is_past() {
            let (place, radius) = (Vec2::new(node.x, node.y), robot_spots::radius(&model.world));
            self.in_past(model, Item::Node(index), |frame| Presence::around(frame, place, radius))
        } else {
            model
                .jams
                .node
                .as_ref()
                .filter(|facts| facts.node == index)
                .map(|facts| facts.present.clone())
        };
        self.list_robots(ui, model, "robots over it", present);
    }

    /// The robots on an edge in the shown frame; `None` until they are counted.
    pub(super) fn present_on_edge(&mut self, model: &ViewModel<'_>, edge: u32) -> Option<Presence> {
        if model.is_past() {
            self.in_past(model, Item::Edge(edge), |frame| Presence::on_edge(frame, edge))
        } else {
            model.jams.edge(edge).map(|facts| facts.present.clone())
        }
    }

    /// Looks at all robots of a frame of the past, once.
    fn in_past(
        &mut self,
        model: &ViewModel<'_>,
        item: Item,
        look: impl FnOnce(&regatta_plugin::Frame<'_>) -> Presence,
    ) -> Option<Presence> {
        let frame = model.frame?;
        let key = (item, frame.run_id(), frame.tick());
        if self.past_presence.as_ref().is_none_or(|(known, _)| *known != key) {
            self.past_presence = Some((key, look(&frame)));
        }
        self.past_presence.as_ref().map(|(_, present)| present.clone())
    }

    fn list_robots(
        &mut self,
        ui: &mut Ui,
        model: &ViewModel<'_>,
        title: &str,
        present: Option<Presence>,
    ) {
        let (Some(frame), Some(present), theme) = (model.frame, present, self.settings.theme())
        else {
            return;
        };
        heading(ui, theme, &format!("{title}: {}", thousands(present.robots.into())));
        let mut clicked = None;
        // The shown frame is newer than the one that was looked at, and may have fewer robots.
        for id in present.listed.iter().filter(|id| (**id as usize) < frame.len()) {
            ui.horizontal(|ui| {
                clicked = ui.link(format!("robot {id}")).clicked().then_some(*id).or(clicked);
                let (state, speed) =
                    (frame.state_of(*id as usize).name(), frame.speed()[*id as usize]);
                ui.label(style::faint(ui, theme, format!("{state}, {speed:.2} m/s")));
            });
        }
        let rest = present.robots as usize - present.listed.len().min(present.robots as usize);
        if rest > 0 {
            ui.label(style::faint(ui, theme, format!("and {rest} more")));
        }
        if let Some(id) = clicked {
            self.select(Some(Item::Robot(id)));
        }
    }
}

/// Returns a column's value, in words if its values are categories.
pub(super) fn value_text(column: &ColumnName, value: f32, theme: Theme) -> String {
    let legend = Colouring::Column(column.clone()).legend(theme, &[], None);
    match legend.scale {
        Scale::Categories(names) if value.is_finite() && value >= 0.0 => names
            .get(value.round() as usize)
            .map_or_else(|| format!("{value:.3}"), |(name, _)| name.clone()),
        _ => format!("{value:.3}"),
    }
}
