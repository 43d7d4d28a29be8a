//! The robots on a selected edge or at a selected node, and the values of columns in words.

use egui::Ui;
use glam::Vec2;
use regatta_plugin::activity::Activity;
use regatta_plugin::{ColumnName, Frame};
use regatta_scene::palette::{Colouring, Scale, Theme};

use super::context::{PanelContext, Request};
use super::robot_spots;
use super::style::{self, heading};
use super::view_model::{Item, ViewModel};
use crate::jams::Presence;
use crate::text::thousands;

/// The robots at a place, in the shown frame. A thread watches places in the newest frame. The
/// robots in a frame of the past are counted here, once.
#[derive(Clone, Debug, Default)]
pub(super) struct PresenceCounter {
    counted: Option<(Counted, Presence)>,
}

/// A place in a frame of the past.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Counted {
    place: Item,
    run: u64,
    tick: u64,
}

impl PresenceCounter {
    /// Returns the robots over a node; `None` until they are counted.
    pub fn at_node(&mut self, model: &ViewModel<'_>, index: u32) -> Option<Presence> {
        if model.is_past() {
            let node = model.world.nodes().get(index as usize)?;
            let (place, radius) = (Vec2::new(node.x, node.y), robot_spots::radius(&model.world));
            return self
                .in_past(model, Item::Node(index), |frame| Presence::around(frame, place, radius));
        }
        let facts = model.jams.node.as_ref().filter(|facts| facts.node == index)?;
        Some(facts.present.clone())
    }

    /// Returns the robots on an edge; `None` until they are counted.
    pub fn on_edge(&mut self, model: &ViewModel<'_>, edge: u32) -> Option<Presence> {
        if model.is_past() {
            return self.in_past(model, Item::Edge(edge), |frame| Presence::on_edge(frame, edge));
        }
        Some(model.jams.edge(edge)?.present.clone())
    }

    fn in_past(
        &mut self,
        model: &ViewModel<'_>,
        place: Item,
        count: impl FnOnce(&Frame<'_>) -> Presence,
    ) -> Option<Presence> {
        let frame = model.frame?;
        let key = Counted { place, run: frame.run_id(), tick: frame.tick() };
        if self.counted.as_ref().is_none_or(|(counted, _)| *counted != key) {
            self.counted = Some((key, count(&frame)));
        }
        self.counted.as_ref().map(|(_, present)| present.clone())
    }
}

/// Lists the robots at a place; a click on one selects it.
pub(super) fn list_robots(
    context: &PanelContext<'_>,
    ui: &mut Ui,
    title: &str,
    present: Option<Presence>,
) {
    let (Some(frame), Some(present)) = (context.model.frame, present) else {
        return;
    };
    heading(ui, &format!("{title}: {}", thousands(present.robots.into())));
    let mut clicked = None;
    // The shown frame is newer than the watched one, and may have fewer robots.
    for id in present.listed.iter().filter(|id| (**id as usize) < frame.len()) {
        ui.horizontal(|ui| {
            clicked = ui.link(format!("robot {id}")).clicked().then_some(*id).or(clicked);
            let activity = context.model.activity(*id).map_or("absent", Activity::name);
            let speed = frame.speed()[*id as usize];
            ui.label(style::faint(ui, format!("{activity}, {speed:.2} m/s")));
        });
    }
    let rest = present.robots as usize - present.listed.len().min(present.robots as usize);
    if rest > 0 {
        ui.label(style::faint(ui, format!("and {} more", thousands(rest as u64))));
    }
    if let Some(id) = clicked {
        context.ask(Request::Select(Some(Item::Robot(id))));
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
