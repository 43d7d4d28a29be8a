//! Elements that float over the picture: the legend, the camera's position, messages, and the note that no engine runs
//! yet.

use egui::{Align2, Area, Context, Id, Order, Rect, RichText, Sense, Ui, vec2};

use glam::Vec2;

use super::heat::HeatLegend;
use super::labels::Labels;
use super::ramp;
use super::state::Interface;
use super::style;
use super::symbols::Symbols;
use super::view_model::{EngineState, ViewModel};
use crate::palette::{Legend, Scale, Theme};

/// The distance from the edge of the picture, in points.
const MARGIN: f32 = 10.0;
/// Seconds for which a message is shown.
const MESSAGE_SECONDS: f64 = 8.0;

impl Interface {
    pub(super) fn overlay(&mut self, context: &Context, picture: Rect, model: &ViewModel<'_>) {
        if model.engine == EngineState::Awaited {
            self.waiting(context, picture, model);
        } else {
            if self.settings.ids {
                let offset = Vec2::from(self.settings.offset);
                model.labels.draw(context, picture, &self.camera_controller.camera(), offset, self.settings.theme());
                let place = |id| Some((id, model.pose(id, offset)?.place));
                let robots = self.robots().into_iter().filter_map(place);
                Labels::draw_robots(context, picture, &self.camera_controller.camera(), self.settings.theme(), robots);
            }
            let heat = self.settings.heat.then_some(HeatLegend { heat: self.settings.heat_of, facts: model.jams.heat });
            let symbols = Symbols {
                plans: self.settings.plans,
                waits: self.settings.waits,
                facts: model.plans,
                heat,
                density: model.density,
            };
            legend(context, picture, self.settings.theme(), model.legend, &symbols);
            self.draw_mark(context, picture);
            self.coordinates(context, picture);
        }
        self.messages(context, picture);
    }

    fn float(&self, context: &Context, picture: Rect, name: &str, place: Align2, show: impl FnOnce(&mut Ui)) {
        float(context, picture, self.settings.theme(), name, place, show);
    }

    fn coordinates(&self, context: &Context, picture: Rect) {
        let (eye, camera) = (self.camera_controller.camera().eye(), self.camera_controller.camera());
        let text = format!(
            "camera  {:.1}  {:.1}  {:.1} m   {:.0}°  {:.0}°",
            eye.x,
            eye.y,
            eye.z,
            camera.yaw.to_degrees(),
            camera.pitch.to_degrees()
        );
        self.float(context, picture, "camera", Align2::RIGHT_BOTTOM, |ui| {
            let text = RichText::new(text).monospace().size(11.0).color(self.colours().faint);
            ui.add(egui::Label::new(text).extend());
        });
    }

    fn waiting(&self, context: &Context, picture: Rect, model: &ViewModel<'_>) {
        let (theme, colours) = (self.settings.theme(), self.colours());
        self.float(context, picture, "waiting", Align2::CENTER_CENTER, |ui| {
            ui.set_max_width(360.0);
            ui.vertical_centered(|ui| {
                ui.add_space(10.0);
                ui.spinner();
                ui.add_space(6.0);
                ui.label(RichText::new(format!("Waiting for fleet '{}'", model.fleet)).size(18.0));
                ui.label(style::faint(ui, theme, "It appears as soon as an engine runs. Start one with:"));
                let name = if model.fleet == "default" { String::new() } else { format!(" --fleet {}", model.fleet) };
                ui.label(RichText::new(format!("regatta run{name}")).monospace().color(colours.accent));
                ui.add_space(10.0);
            });
        });
    }

    fn messages(&mut self, context: &Context, picture: Rect) {
        let now = context.input(|input| input.time);
        for message in &mut self.messages {
            message.until.get_or_insert(now + MESSAGE_SECONDS);
        }
        self.messages.retain(|message| message.until.is_none_or(|until| until > now));
        let Some(next) = self.messages.iter().filter_map(|message| message.until).reduce(f64::min) else { return };
        context.request_repaint_after_secs((next - now) as f32);
        self.float(context, picture, "messages", Align2::CENTER_TOP, |ui| {
            ui.set_max_width((picture.width() - 4.0 * MARGIN).clamp(120.0, 620.0));
            for message in &self.messages {
                ui.label(RichText::new(&message.text).color(self.colours().text));
            }
        });
    }
}

/// Shows an element in a corner, at an edge or in the centre of the picture.
fn float(context: &Context, picture: Rect, theme: Theme, name: &str, place: Align2, show: impl FnOnce(&mut Ui)) {
    let inside = picture.shrink(MARGIN);
    if !inside.is_positive() {
        return;
    }
    let area = Area::new(Id::unique(name)).order(Order::Background).interactable(false).fade_in(false);
    area.pivot(place).fixed_pos(place.pos_in_rect(&inside)).show(context, |ui| {
        style::floating(theme).show(ui, show);
    });
}

/// Shows the legend: the robots' colours, and the symbols of layers.
pub fn legend(context: &Context, picture: Rect, theme: Theme, legend: &Legend, symbols: &Symbols) {
    float(context, picture, theme, "legend", Align2::LEFT_BOTTOM, |ui| {
        ui.spacing_mut().item_spacing.y = 4.0;
        ui.label(RichText::new(&legend.title).strong());
        match &legend.scale {
            Scale::Categories(names) => {
                for (name, colour) in names {
                    ui.horizontal(|ui| {
                        let (dot, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                        ui.painter().rect_filled(dot, 3.0, style::color32(*colour));
                        ui.label(style::faint(ui, theme, name));
                    });
                }
            }
            Scale::Ramp { low, high, unit } => {
                ui.label(style::faint(ui, theme, *unit));
                ramp::show(ui, theme, &legend.scale.colours(theme), &ramp::numbers(*low, *high));
            }
        }
        symbols.show(ui, theme);
    });
}
