//! The collisions: how many, which robots, where.

use egui::{Align2, FontId, RichText, Ui, pos2};
use glam::Vec2;
use regatta_plugin::contact::{ContactLevel, ContactRecord};

use super::Interface;
use super::facts::{Facts, Thing};
use super::list::clickable;
use super::style::{self, thousands};

impl Interface {
    pub(super) fn collisions(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        let (theme, tones) = (self.settings.theme(), self.tones());
        let Some(contacts) = facts.contacts else {
            ui.label("Nobody looks for collisions.");
            ui.label(style::faint(ui, theme, "The plugin collision does: name it in the scenario, or start it by"));
            let command = format!("regatta plugin collision --fleet {}", facts.fleet);
            ui.label(RichText::new(command).monospace().color(tones.accent));
            return;
        };
        let header = contacts.header;
        ui.columns(2, |columns| {
            let counts = [
                ("touching", header.touching, header.touching_ever, tones.bad),
                ("possible", header.possible, header.possible_ever, tones.warn),
            ];
            for (ui, (name, now, ever, colour)) in columns.iter_mut().zip(counts) {
                let colour = if now > 0 { colour } else { tones.faint };
                ui.label(RichText::new(thousands(now.into())).size(26.0).color(colour));
                ui.label(style::faint(ui, theme, format!("{name}, {} ever", thousands(ever))));
            }
        });
        if header.capped != 0 {
            ui.label(RichText::new("too many pairs to look at: these are not all").color(tones.warn));
        }
        if contacts.pairs.is_empty() {
            ui.add_space(8.0);
            ui.label(style::faint(ui, theme, "no robot is near another now"));
            return;
        }
        ui.add_space(4.0);
        let selected = self.robots();
        let mut clicked = None;
        self.collision_scroll.show(ui, "collisions", &tones, contacts.pairs.len(), |ui, rect, row| {
            let pair = &contacts.pairs[row];
            let chosen = pair.robots.iter().any(|robot| selected.contains(robot));
            let response = clickable(ui, rect, row as u32, chosen, &tones, || name(pair));
            if response.clicked() {
                clicked = Some(*pair);
            }
            let touching = pair.level == ContactLevel::Touching as u32;
            let colour = if touching { tones.bad } else { tones.warn };
            ui.painter().circle_filled(pos2(rect.left() + 6.0, rect.center().y), 3.5, colour);
            let [a, b] = pair.robots;
            let write = |x: f32, align, text: String, colour| {
                ui.painter().text(pos2(x, rect.center().y), align, text, FontId::monospace(12.0), colour);
            };
            write(rect.left() + 16.0, Align2::LEFT_CENTER, format!("{a} · {b}"), tones.text);
            let place = format!("{:.1}, {:.1}", pair.x, pair.y);
            write(rect.right() - 6.0, Align2::RIGHT_CENTER, place, tones.faint);
        });
        if let Some(pair) = clicked {
            let [a, b] = pair.robots.map(Thing::Robot);
            self.select(Some(b));
            self.select_beside(a);
            self.rig.fly_to(Vec2::new(pair.x, pair.y) + Vec2::from(self.settings.offset));
        }
    }
}

fn name(pair: &ContactRecord) -> String {
    let level = if pair.level == ContactLevel::Touching as u32 { "touching" } else { "possible" };
    format!("robots {} and {} {level}", pair.robots[0], pair.robots[1])
}
