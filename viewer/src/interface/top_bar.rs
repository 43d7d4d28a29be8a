//! The bar at the top: the fleet and the state of its engine, the panels, and the views of the camera.

use egui::{Align, Button, Layout, RichText, Ui, vec2};

use super::icons::{self, Icon};
use super::settings::{LeftPanel, RightPanel};
use super::state::Interface;
use super::style::status_dot;
use super::view_model::ViewModel;

impl Interface {
    pub(super) fn top_bar(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let colours = self.colours();
        ui.horizontal_centered(|ui| {
            let (text, colour) = model.engine.text_and_colour(&colours);
            status_dot(ui, colour, RichText::new(model.fleet).strong().size(14.0));
            ui.label(RichText::new(text).color(colour).size(12.0));
            ui.separator();
            let touching = model.contacts.map_or(0, |contacts| contacts.header.touching);
            // Red is unreadable on the colour of an open tab.
            let is_open = self.settings.left == Some(LeftPanel::Collisions);
            let collisions = match (touching, is_open) {
                (0, _) => "Collisions".into(),
                (_, true) => RichText::new(format!("Collisions {touching}")),
                (_, false) => RichText::new(format!("Collisions {touching}")).color(colours.bad),
            };
            let panels = [
                (LeftPanel::Fleet, "Fleet".into(), "1"),
                (LeftPanel::Collisions, collisions, "2"),
                (LeftPanel::Spots, "Hot spots".into(), "7"),
            ];
            for (panel, name, key) in panels {
                tab(ui, &mut self.settings.left, panel, name, key);
            }
            if ui.add(Button::selectable(self.settings.plots, "Plots")).on_hover_text("Key 8").clicked() {
                self.settings.plots = !self.settings.plots;
            }
            ui.separator();
            self.camera_buttons(ui, model);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("?").on_hover_text("Keys and mouse (?)").clicked() {
                    self.help = !self.help;
                }
                let (icon, name) = if self.settings.light { (Icon::Moon, "Dark") } else { (Icon::Sun, "Light") };
                if icons::button(ui, icon, name, vec2(26.0, 22.0)).on_hover_text(format!("{name} (L)")).clicked() {
                    self.settings.light = !self.settings.light;
                }
                ui.separator();
                let panels = [
                    (RightPanel::Connection, "Connection", "6"),
                    (RightPanel::Performance, "Performance", "5"),
                    (RightPanel::View, "View", "4"),
                    (RightPanel::Selection, "Selection", "3"),
                ];
                for (panel, name, key) in panels {
                    tab(ui, &mut self.settings.right, panel, name.into(), key);
                }
            });
        });
    }

    fn camera_buttons(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        if ui.button("Fit").on_hover_text("Fit everything into the picture (Home)").clicked() {
            self.camera_controller.fit(model.bounds, self.aspect);
        }
        if ui.button("Top").on_hover_text("View from above (T)").clicked() {
            self.camera_controller.top(model.bounds, self.aspect);
        }
        let is_following = self.camera_controller.followed().is_some();
        let text = "Follow the selected robot: from behind, from above, off (F)";
        if ui.add(Button::selectable(is_following, "Follow")).on_hover_text(text).clicked() {
            self.follow_selected();
        }
    }
}

/// Shows a button that opens or closes a panel; `key` is its keyboard shortcut.
fn tab<T: PartialEq>(ui: &mut Ui, open: &mut Option<T>, panel: T, name: RichText, key: &str) {
    let is_open = open.as_ref() == Some(&panel);
    if ui.add(Button::selectable(is_open, name)).on_hover_text(format!("Key {key}")).clicked() {
        *open = (!is_open).then_some(panel);
    }
}
