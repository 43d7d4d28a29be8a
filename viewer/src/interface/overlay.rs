//! What floats over the picture: the legend, where the camera is, messages, and what is waited for.

use egui::{Align2, Area, Context, Id, Order, Rect, RichText, Sense, Ui, pos2, vec2};

use super::facts::{Engine, Facts};
use super::{Interface, NOTICE, style};
use crate::palette::Scale;

/// From the edge of the picture, in points.
const MARGIN: f32 = 10.0;

impl Interface {
    pub(super) fn overlay(&mut self, context: &Context, picture: Rect, facts: &Facts<'_>) {
        if facts.engine == Engine::Awaited {
            self.waiting(context, picture, facts);
        } else {
            self.legend(context, picture, facts);
            self.coordinates(context, picture);
        }
        self.messages(context, picture);
    }

    /// Something over the picture, with one of its corners or edges in the same one of the picture.
    fn float(&self, context: &Context, picture: Rect, name: &str, place: Align2, show: impl FnOnce(&mut Ui)) {
        let inside = picture.shrink(MARGIN);
        if !inside.is_positive() {
            return;
        }
        let at = place.pos_in_rect(&inside);
        Area::new(Id::unique(name)).order(Order::Background).pivot(place).fixed_pos(at).interactable(false).show(
            context,
            |ui| {
                style::floating(self.settings.theme()).show(ui, show);
            },
        );
    }

    fn legend(&self, context: &Context, picture: Rect, facts: &Facts<'_>) {
        let (theme, tones) = (self.settings.theme(), self.tones());
        self.float(context, picture, "legend", Align2::LEFT_BOTTOM, |ui| {
            ui.spacing_mut().item_spacing.y = 4.0;
            ui.label(RichText::new(&facts.legend.title).strong());
            match &facts.legend.scale {
                Scale::Categories(names) => {
                    for (name, colour) in names {
                        ui.horizontal(|ui| {
                            let (dot, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                            ui.painter().rect_filled(dot, 3.0, style::of(*colour));
                            ui.label(style::faint(ui, theme, name));
                        });
                    }
                }
                Scale::Ramp { low, high, unit } => {
                    let (ramp, _) = ui.allocate_exact_size(vec2(140.0, 10.0), Sense::hover());
                    let colours = facts.legend.scale.colours(theme);
                    let width = ramp.width() / colours.len() as f32;
                    for (i, colour) in colours.into_iter().enumerate() {
                        let left = ramp.left() + i as f32 * width;
                        let part = Rect::from_min_size(pos2(left, ramp.top()), vec2(width + 0.5, ramp.height()));
                        ui.painter().rect_filled(part, 0.0, style::of(colour));
                    }
                    let middle = (low + high) / 2.0;
                    ui.label(
                        RichText::new(format!("{low:.4}   {middle:.4}   {high:.4} {unit}"))
                            .size(11.0)
                            .color(tones.faint),
                    );
                }
            }
        });
    }

    fn coordinates(&self, context: &Context, picture: Rect) {
        let (eye, camera) = (self.rig.camera().eye(), self.rig.camera());
        let text = format!(
            "camera  {:.1}  {:.1}  {:.1} m   {:.0}°  {:.0}°",
            eye.x,
            eye.y,
            eye.z,
            camera.yaw.to_degrees(),
            camera.pitch.to_degrees()
        );
        self.float(context, picture, "camera", Align2::RIGHT_BOTTOM, |ui| {
            let text = RichText::new(text).monospace().size(11.0).color(self.tones().faint);
            ui.add(egui::Label::new(text).extend());
        });
    }

    fn waiting(&self, context: &Context, picture: Rect, facts: &Facts<'_>) {
        let (theme, tones) = (self.settings.theme(), self.tones());
        self.float(context, picture, "waiting", Align2::CENTER_CENTER, |ui| {
            ui.set_max_width(360.0);
            ui.vertical_centered(|ui| {
                ui.add_space(10.0);
                ui.spinner();
                ui.add_space(6.0);
                ui.label(RichText::new(format!("Waiting for fleet '{}'", facts.fleet)).size(18.0));
                ui.label(style::faint(ui, theme, "It is shown as soon as an engine runs. To start one:"));
                let name = if facts.fleet == "default" { String::new() } else { format!(" --fleet {}", facts.fleet) };
                ui.label(RichText::new(format!("regatta run{name}")).monospace().color(tones.accent));
                ui.add_space(10.0);
            });
        });
    }

    fn messages(&mut self, context: &Context, picture: Rect) {
        let now = context.input(|input| input.time);
        for (_, until) in &mut self.notices {
            until.get_or_insert(now + NOTICE);
        }
        self.notices.retain(|(_, until)| until.is_none_or(|until| until > now));
        let Some(next) = self.notices.iter().filter_map(|(_, until)| *until).reduce(f64::min) else { return };
        context.request_repaint_after_secs((next - now) as f32);
        self.float(context, picture, "messages", Align2::CENTER_TOP, |ui| {
            ui.set_max_width((picture.width() - 4.0 * MARGIN).clamp(120.0, 620.0));
            for (text, _) in &self.notices {
                ui.label(RichText::new(text).color(self.tones().text));
            }
        });
    }
}
