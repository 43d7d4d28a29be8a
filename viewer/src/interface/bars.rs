//! The bar at the top: which fleet, which panels, from where to look.

use egui::{Align, Button, Layout, RichText, Ui, vec2};

use super::Interface;
use super::facts::Facts;
use super::fleet_list::dot;
use super::icons::{self, Icon};
use super::settings::{Left, Right};

impl Interface {
    pub(super) fn top_bar(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        let tones = self.tones();
        ui.horizontal_centered(|ui| {
            let (words, colour) = facts.engine.words(&tones);
            dot(ui, colour, RichText::new(facts.fleet).strong().size(14.0));
            ui.label(RichText::new(words).color(colour).size(12.0));
            ui.separator();
            let touching = facts.contacts.map_or(0, |contacts| contacts.header.touching);
            // On the colour of an open tab, red can't be read.
            let is_open = self.settings.left == Some(Left::Collisions);
            let collisions = match (touching, is_open) {
                (0, _) => "Collisions".into(),
                (_, true) => RichText::new(format!("Collisions {touching}")),
                (_, false) => RichText::new(format!("Collisions {touching}")).color(tones.bad),
            };
            for (panel, name, key) in [(Left::Fleet, "Fleet".into(), "1"), (Left::Collisions, collisions, "2")] {
                tab(ui, &mut self.settings.left, panel, name, key);
            }
            ui.separator();
            self.views(ui, facts);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("?").on_hover_text("Keys (?)").clicked() {
                    self.help = !self.help;
                }
                let (icon, name) = if self.settings.light { (Icon::Moon, "Dark") } else { (Icon::Sun, "Light") };
                if icons::button(ui, icon, name, vec2(26.0, 22.0)).on_hover_text(format!("{name} (L)")).clicked() {
                    self.settings.light = !self.settings.light;
                }
                ui.separator();
                let panels = [
                    (Right::Connection, "Connection", "6"),
                    (Right::Performance, "Performance", "5"),
                    (Right::View, "View", "4"),
                    (Right::Selection, "Selection", "3"),
                ];
                for (panel, name, key) in panels {
                    tab(ui, &mut self.settings.right, panel, name.into(), key);
                }
            });
        });
    }

    fn views(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        if ui.button("Fit").on_hover_text("All in the picture (Home)").clicked() {
            self.rig.fit(facts.bounds, self.aspect);
        }
        if ui.button("Top").on_hover_text("From above (T)").clicked() {
            self.rig.top(facts.bounds, self.aspect);
        }
        let follows = self.rig.followed().is_some();
        let text = "Follow the selected robot: behind, above, not (F)";
        if ui.add(Button::selectable(follows, "Follow")).on_hover_text(text).clicked() {
            self.follow_selected();
        }
    }
}

fn tab<T: PartialEq>(ui: &mut Ui, open: &mut Option<T>, panel: T, name: RichText, key: &str) {
    let chosen = open.as_ref() == Some(&panel);
    if ui.add(Button::selectable(chosen, name)).on_hover_text(key).clicked() {
        *open = (!chosen).then_some(panel);
    }
}
