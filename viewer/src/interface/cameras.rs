//! The part of the view panel about cameras: those that the scenario names, and the plan as a file;
//! and where the floor picture is placed.

use egui::{DragValue, Ui};

use super::state::Interface;
use super::style::{faint, heading};
use super::view_model::{Action, ViewModel};
use crate::options::CameraOption;

impl Interface {
    /// Shows the named cameras, and buttons that copy this camera and write the plan.
    pub(super) fn cameras(
        &mut self,
        ui: &mut Ui,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let theme = self.settings.theme();
        heading(ui, theme, "cameras");
        let mut wanted = None;
        ui.horizontal_wrapped(|ui| {
            for bookmark in &self.bookmarks {
                if ui.button(&bookmark.name).clicked() {
                    wanted = Some(bookmark.clone());
                }
            }
        });
        if self.bookmarks.is_empty() {
            ui.label(faint(ui, theme, "none named; add them to the scenario as `cameras`"));
        }
        ui.horizontal_wrapped(|ui| {
            let text = "Copies a line for `cameras` of the scenario";
            if ui.button("Copy this camera").on_hover_text(text).clicked() {
                ui.ctx().copy_text(CameraOption::entry(&self.camera_controller.camera()));
                self.notify(
                    "the camera is in the clipboard, as a line for `cameras` of the scenario",
                );
            }
            if ui
                .button("Plan as SVG")
                .on_hover_text("Writes a plan with its scale into the current folder")
                .clicked()
            {
                actions.push(Action::WriteSvg);
            }
        });
        if let Some(bookmark) = wanted {
            // Of everything, the part of the picture that no panel covers shows all.
            let camera = bookmark.view.camera(model.bounds, self.window);
            self.camera_controller.fly_to_camera(camera);
        }
    }

    /// Shows where the floor picture is placed.
    pub(super) fn floor_place(&mut self, ui: &mut Ui) {
        if self.settings.floor_image.is_empty() {
            return;
        }
        let mut is_placed = self.settings.floor_at.is_some();
        ui.checkbox(&mut is_placed, "placed by origin and resolution");
        if is_placed != self.settings.floor_at.is_some() {
            self.settings.floor_at = is_placed.then_some([0.0, 0.0, 0.05, 0.0]);
        }
        let Some(at) = &mut self.settings.floor_at else { return };
        ui.horizontal_wrapped(|ui| {
            let [x, y, resolution, yaw] = at;
            for (metres, name) in [(x, "x "), (y, "y ")] {
                ui.add(
                    DragValue::new(metres).range(-1e6..=1e6).speed(0.05).prefix(name).suffix(" m"),
                );
            }
            ui.add(
                DragValue::new(resolution)
                    .range(1e-4..=100.0)
                    .speed(0.001)
                    .max_decimals(4)
                    .suffix(" m/pixel"),
            );
            ui.add(DragValue::new(yaw).range(-360.0..=360.0).speed(0.5).prefix("yaw ").suffix("°"));
        });
    }
}
