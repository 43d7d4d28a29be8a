//! The collisions panel: the number of pairs, their robots and places.

use egui::{Align2, FontId, RichText, Ui, pos2};
use glam::Vec2;
use regatta_plugin::contact::{ContactLevel, ContactRecord};

use super::state::Interface;
use super::style;
use super::view_model::{Item, ViewModel};
use super::virtual_list::clickable;
use crate::text::thousands;

impl Interface {
    pub(super) fn collisions(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let (theme, colours) = (self.settings.theme(), self.colours());
        let Some(contacts) = model.contacts else {
            ui.label("No collision checker is running.");
            ui.label(style::faint(
                ui,
                theme,
                "Add the collision plugin to the scenario, or start it with:",
            ));
            let command = format!("regatta plugin collision --fleet {}", model.fleet);
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
                ui.label(style::faint(ui, theme, format!("{name}, {} in total", thousands(total))));
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
            ui.label(style::faint(ui, theme, "no touching or possible pairs now"));
            return;
        }
        ui.add_space(4.0);
        let selected = self.robots();
        let mut clicked = None;
        self.collision_list.show(
            ui,
            "collisions",
            &colours,
            contacts.pairs.len(),
            |ui, rect, row| {
                let pair = &contacts.pairs[row];
                let is_selected = pair.robots.iter().any(|robot| selected.contains(robot));
                let response =
                    clickable(ui, rect, row as u32, is_selected, &colours, || name(pair));
                if response.clicked() {
                    clicked = Some(*pair);
                }
                let touching = pair.level == ContactLevel::Touching as u32;
                let colour = if touching { colours.bad } else { colours.warn };
                ui.painter().circle_filled(pos2(rect.left() + 6.0, rect.center().y), 3.5, colour);
                let [a, b] = pair.robots;
                let write = |x: f32, align, text: String, colour| {
                    ui.painter().text(
                        pos2(x, rect.center().y),
                        align,
                        text,
                        FontId::monospace(12.0),
                        colour,
                    );
                };
                write(rect.left() + 16.0, Align2::LEFT_CENTER, format!("{a} · {b}"), colours.text);
                let place = format!("{:.1}, {:.1}", pair.x, pair.y);
                write(rect.right() - 6.0, Align2::RIGHT_CENTER, place, colours.faint);
            },
        );
        if let Some(pair) = clicked {
            let [a, b] = pair.robots.map(Item::Robot);
            self.select(Some(b));
            self.toggle_selected(a);
            self.camera_controller
                .fly_to(Vec2::new(pair.x, pair.y) + Vec2::from(self.settings.offset));
        }
    }
}

fn name(pair: &ContactRecord) -> String {
    let level = if pair.level == ContactLevel::Touching as u32 { "touching" } else { "possible" };
    format!("robots {} and {} {level}", pair.robots[0], pair.robots[1])
}
