//! The robots on a selected edge or at a selected node, and the values of columns in words.

use egui::Ui;
use glam::Vec2;
use regatta_plugin::ColumnName;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::NodeRecord;

use super::robot_spots;
use super::state::Interface;
use super::style::{self, heading, thousands};
use super::view_model::{Item, ViewModel};
use crate::palette::{Colouring, Scale, Theme};

/// The most robots that are listed.
const LISTED: usize = 12;

impl Interface {
    /// Lists the robots on an edge.
    pub(super) fn robots_on_edge(&mut self, ui: &mut Ui, model: &ViewModel<'_>, index: u32) {
        let Some(frame) = model.frame else { return };
        let rows = frame.edge().iter().enumerate().filter(|(_, edge)| **edge == index);
        let ids: Vec<u32> = rows.map(|(row, _)| row as u32).collect();
        self.list_robots(ui, model, "robots on it", ids);
    }

    /// Lists the robots that stand over a node.
    pub(super) fn robots_at_node(&mut self, ui: &mut Ui, model: &ViewModel<'_>, node: &NodeRecord) {
        let Some(frame) = model.frame else { return };
        let (place, radius) = (Vec2::new(node.x, node.y), robot_spots::radius(&model.world));
        let is_over = |x: f32, y: f32| Vec2::new(x, y).distance_squared(place) <= radius * radius;
        let rows = frame.x().iter().zip(frame.y()).enumerate().filter(|(_, (x, y))| is_over(**x, **y));
        let ids: Vec<u32> = rows.map(|(row, _)| row as u32).collect();
        self.list_robots(ui, model, "robots over it", ids);
    }

    fn list_robots(&mut self, ui: &mut Ui, model: &ViewModel<'_>, title: &str, mut ids: Vec<u32>) {
        let (Some(frame), theme) = (model.frame, self.settings.theme()) else { return };
        ids.retain(|id| frame.state_of(*id as usize) != RobotState::Absent);
        heading(ui, theme, &format!("{title}: {}", thousands(ids.len() as u64)));
        let mut clicked = None;
        for id in ids.iter().take(LISTED) {
            ui.horizontal(|ui| {
                clicked = ui.link(format!("robot {id}")).clicked().then_some(*id).or(clicked);
                let (state, speed) = (frame.state_of(*id as usize).name(), frame.speed()[*id as usize]);
                ui.label(style::faint(ui, theme, format!("{state}, {speed:.2} m/s")));
            });
        }
        if ids.len() > LISTED {
            ui.label(style::faint(ui, theme, format!("and {} more", ids.len() - LISTED)));
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
        Scale::Categories(names) if value.is_finite() && value >= 0.0 => {
            names.get(value.round() as usize).map_or_else(|| format!("{value:.3}"), |(name, _)| name.clone())
        }
        _ => format!("{value:.3}"),
    }
}
