//! The collisions panel: the number of pairs, their robots and places.

use egui::{Align2, FontId, RichText, Ui, pos2};
use glam::Vec2;
use regatta_plugin::contact::{ContactLevel, ContactRecord};

use super::context::{PanelContext, Request};
use super::style;
use super::view_model::Item;
use super::virtual_list::{VirtualList, clickable};
use crate::text::thousands;

/// The collisions panel: the scroll position of the list.
#[derive(Debug, Default)]
pub(super) struct CollisionsPanel {
    pub list: VirtualList,
}

impl CollisionsPanel {
    /// Shows the panel.
    pub fn show(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let colours = context.colours;
        let Some(contacts) = context.model.contacts else {
            ui.label("No collision checker is running.");
            ui.label(style::faint(
                ui,
                "Add the collision plugin to the scenario, or start it with:",
            ));
            let command = format!("regatta plugin collision --fleet {}", context.model.fleet);
            ui.label(RichText::new(command).monospace().color(colours.accent));
            return;
        };
        let header = contacts.header;
        ui.columns(2, |columns| {
            let counts = [
                ("touching", header.touching, header.touching_ever, colours.bad),
                ("possible", header.possible, header.possible_ever, colours.warn),
            ];
            for (ui, (name, now, total, colour)) in columns.iter_mut().zip(counts) {
                let colour = if now > 0 { colour } else { colours.faint };
                ui.label(RichText::new(thousands(now.into())).size(26.0).color(colour));
                ui.label(style::faint(ui, format!("{name}, {} in total", thousands(total))));
            }
        });
        if header.capped != 0 {
            ui.label(
                RichText::new("too many pairs to check: the list is incomplete")
                    .color(colours.warn),
            );
        }
        if contacts.pairs.is_empty() {
            ui.add_space(8.0);
            ui.label(style::faint(ui, "no touching or possible pairs now"));
            return;
        }
        ui.add_space(4.0);
        let selected = context.selection.robots();
        let mut clicked = None;
        self.list.show(ui, "collisions", &colours, contacts.pairs.len(), |ui, rect, row| {
            let pair = &contacts.pairs[row];
            let is_selected = pair.robots.iter().any(|robot| selected.contains(robot));
            let response = clickable(ui, rect, row as u32, is_selected, &colours, || name(pair));
            if response.clicked() {
                clicked = Some(*pair);
            }
            let touching = pair.level == ContactLevel::Touching as u32;
            let colour = if touching { colours.bad } else { colours.warn };
            ui.painter().circle_filled(pos2(rect.left() + 6.0, rect.center().y), 3.5, colour);
            let [a, b] = pair.robots;
            let (painter, font) = (ui.painter(), FontId::monospace(12.0));
            let robots = format!("{a} · {b}");
            let left = pos2(rect.left() + 16.0, rect.center().y);
            painter.text(left, Align2::LEFT_CENTER, robots, font.clone(), colours.text);
            let place = format!("{:.1}, {:.1}", pair.x, pair.y);
            let right = pos2(rect.right() - 6.0, rect.center().y);
            painter.text(right, Align2::RIGHT_CENTER, place, font, colours.faint);
        });
        if let Some(pair) = clicked {
            let [a, b] = pair.robots.map(Item::Robot);
            context.ask(Request::Select(Some(b)));
            context.ask(Request::Toggle(a));
            context.ask(Request::FlyTo(Vec2::new(pair.x, pair.y) + context.offset));
        }
    }
}

fn name(pair: &ContactRecord) -> String {
    let level = if pair.level == ContactLevel::Touching as u32 { "touching" } else { "possible" };
    format!("robots {} and {} {level}", pair.robots[0], pair.robots[1])
}
