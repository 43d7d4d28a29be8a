//! How things are drawn: colours, layers, floor, offset, trails.

use egui::{DragValue, Slider, Ui};

use super::Interface;
use super::facts::Facts;
use super::style::heading;
use crate::palette::Colouring;

impl Interface {
    pub(super) fn look(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        let theme = self.settings.theme();
        heading(ui, theme, "colour of the robots");
        self.colour_choice(ui, facts);
        ui.horizontal(|ui| {
            ui.selectable_value(&mut self.settings.light, false, "Dark");
            ui.selectable_value(&mut self.settings.light, true, "Light");
        });
        heading(ui, theme, "layers");
        let settings = &mut self.settings;
        ui.checkbox(&mut settings.edges, "edges");
        ui.checkbox(&mut settings.nodes, "nodes");
        ui.checkbox(&mut settings.grid, "grid");
        ui.checkbox(&mut settings.shadows, "shadows");
        heading(ui, theme, "trails");
        ui.add(Slider::new(&mut settings.trails, 0..=4096).logarithmic(true).text("points"));
        heading(ui, theme, "floor");
        let mut sized = settings.floor.is_some();
        ui.checkbox(&mut sized, "of a size, around the origin");
        if sized != settings.floor.is_some() {
            let size = facts.bounds.high - facts.bounds.low;
            settings.floor = sized.then(|| (size.ceil() + 10.0).to_array());
        }
        if let Some(size) = &mut settings.floor {
            ui.horizontal(|ui| {
                for (metres, name) in size.iter_mut().zip(["width ", "depth "]) {
                    ui.add(DragValue::new(metres).range(1.0..=1e6).speed(0.5).prefix(name).suffix(" m"));
                }
            });
        }
        heading(ui, theme, "offset of all positions");
        ui.horizontal(|ui| {
            for (metres, name) in settings.offset.iter_mut().zip(["x ", "y "]) {
                ui.add(DragValue::new(metres).range(-1e6..=1e6).speed(0.1).prefix(name).suffix(" m"));
            }
        });
        heading(ui, theme, "interface");
        let percent = |scale: f32| format!("{:.0} %", scale * 100.0);
        egui::ComboBox::from_id_salt("scale").selected_text(percent(settings.scale)).show_ui(ui, |ui| {
            for scale in [0.75, 0.9, 1.0, 1.15, 1.3, 1.5, 2.0] {
                ui.selectable_value(&mut settings.scale, scale, percent(scale));
            }
        });
    }

    /// The choice of what the robots' colours tell.
    pub(super) fn colour_choice(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        egui::ComboBox::from_id_salt("colour").selected_text(&self.settings.colour).width(110.0).show_ui(ui, |ui| {
            for name in colourings(facts) {
                ui.selectable_value(&mut self.settings.colour, name.clone(), name);
            }
        });
    }

    /// Takes the next of the colourings.
    pub(super) fn next_colouring(&mut self, facts: &Facts<'_>) {
        let all = colourings(facts);
        let now = all.iter().position(|name| *name == self.settings.colour).map_or(0, |now| now + 1);
        self.settings.colour = all[now % all.len()].clone();
    }
}

/// All that robots can be coloured by.
fn colourings(facts: &Facts<'_>) -> Vec<String> {
    let own = [Colouring::default(), Colouring::State, Colouring::Speed, Colouring::Type].map(|own| own.to_string());
    let columns = facts.columns.iter().map(ToString::to_string);
    let columns: Vec<_> = columns.filter(|name| !own.contains(name)).collect();
    own.into_iter().chain(columns).collect()
}
