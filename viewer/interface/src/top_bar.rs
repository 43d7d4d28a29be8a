//! The bar at the top: the fleet and the state of its engine, the panels, and the views of the
//! camera.

use egui::{
    Align, Button, Color32, FontId, Layout, Rect, Response, RichText, Role, Ui, WidgetInfo, vec2,
};

use super::icons::{self, Icon};
use super::settings::{LeftPanel, RightPanel};
use super::state::Interface;
use super::style::status_dot;
use super::view_model::ViewModel;

/// The least width of the window for all tabs and buttons side by side, in points; a narrower one
/// has menus.
const WIDE: f32 = 1150.0;
/// The least width at which the state of the engine is a text; below, it is a tooltip.
const WITH_STATE: f32 = 560.0;
/// The width of all tabs and buttons side by side, without the name and the state of the fleet, in
/// points.
const TABS: f32 = 1030.0;
/// The greatest count that a tab shows as a number.
const MAX_COUNT: usize = 99;

impl Interface {
    pub(super) fn top_bar(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let colours = self.colours();
        let room = ui.available_width();
        ui.horizontal_centered(|ui| {
            let (text, colour) = model.engine.text_and_colour(&colours);
            let state = ui
                .painter()
                .layout_no_wrap(text.to_owned(), FontId::proportional(12.0), colour)
                .size()
                .x;
            ui.scope(|ui| {
                ui.set_max_width(match room {
                    wide if wide >= WIDE => (wide - TABS - state).clamp(60.0, 220.0),
                    narrow if narrow >= WITH_STATE => 220.0,
                    _ => 90.0,
                });
                status_dot(ui, colour, RichText::new(model.name()).strong().size(14.0))
                    .on_hover_text(text);
            });
            if room >= WITH_STATE {
                ui.label(RichText::new(text).color(colour).size(12.0));
            }
            ui.separator();
            if room >= WIDE {
                self.left_tabs(ui, model);
                ui.separator();
                self.camera_buttons(ui, model);
            } else {
                self.menus(ui, model);
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("?").on_hover_text("Keys and mouse (?)").clicked() {
                    self.help = !self.help;
                }
                let (icon, name) =
                    if self.settings.light { (Icon::Moon, "Dark") } else { (Icon::Sun, "Light") };
                if icons::button(ui, icon, name, vec2(26.0, 22.0))
                    .on_hover_text(format!("{name} (L)"))
                    .clicked()
                {
                    self.settings.light = !self.settings.light;
                }
                if room >= WIDE {
                    ui.separator();
                    self.right_tabs(ui, true);
                }
            });
        });
    }

    /// Shows the menus of a narrow window.
    fn menus(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let touching = model.contacts.map_or(0, |contacts| contacts.header.touching);
        let name = RichText::new("Panels");
        let name = if touching > 0 || self.log_panel.log.unacknowledged() > 0 {
            name.color(self.colours().bad)
        } else {
            name
        };
        ui.menu_button(name, |ui| {
            self.left_tabs(ui, model);
            self.right_tabs(ui, false);
        });
        ui.menu_button("Camera", |ui| self.camera_buttons(ui, model));
    }

    fn left_tabs(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        let touching = model.contacts.map_or(0, |contacts| contacts.header.touching);
        let alarms = self.log_panel.log.unacknowledged();
        let alarm = self.colours().bad;
        let open = &mut self.settings.left;
        tab(ui, open, LeftPanel::Fleet, "Fleet", "The list of all robots (1)");
        let text = "Pairs of robots that touch, or may touch (2)";
        tab_with_count(
            ui,
            open,
            LeftPanel::Collisions,
            "Collisions",
            text,
            (touching as usize, alarm),
        );
        tab(ui, open, LeftPanel::Spots, "Hot spots", "The places that have cost the most time (7)");
        tab_with_count(
            ui,
            open,
            LeftPanel::Log,
            "Log",
            "What happened, and alarms (9)",
            (alarms, alarm),
        );
        let plots = Button::selectable(self.settings.plots, "Plots");
        if ui.add(plots).on_hover_text("Figures over time (8)").clicked() {
            self.settings.plots = !self.settings.plots;
        }
    }

    /// Shows the tabs of the panels on the right; `reversed` if they are laid out from the right.
    fn right_tabs(&mut self, ui: &mut Ui, reversed: bool) {
        let mut panels = [
            (RightPanel::Selection, "Selection", "What is selected (3)"),
            (RightPanel::View, "View", "Colours, layers and files (4)"),
            (RightPanel::Performance, "Performance", "Rates and durations (5)"),
            (RightPanel::Connection, "Connection", "The engine and UDP (6)"),
        ];
        if reversed {
            panels.reverse();
        }
        for (panel, name, text) in panels {
            tab(ui, &mut self.settings.right, panel, name, text);
        }
    }

    fn camera_buttons(&mut self, ui: &mut Ui, model: &ViewModel<'_>) {
        if ui.button("Fit").on_hover_text("Fit everything into the picture (Home)").clicked() {
            self.camera_controller.fit(model.bounds, self.window);
        }
        if ui.button("Top").on_hover_text("View from above (T)").clicked() {
            self.camera_controller.top(model.bounds, self.window);
        }
        let is_plan = self.camera_controller.camera().is_plan();
        let text = "An orthographic plan with footprints, coordinates and a scale (O)";
        if ui.add(Button::selectable(is_plan, "Plan")).on_hover_text(text).clicked() {
            self.camera_controller.toggle_plan();
        }
        let text = "Distance between two places or robots, and clearance between robots (M)";
        if ui
            .add(Button::selectable(self.measuring.is_some(), "Measure"))
            .on_hover_text(text)
            .clicked()
        {
            self.toggle_measuring();
        }
        let is_following = self.camera_controller.followed().is_some();
        let text = "Follow the selected robot: from behind, from above, off (F)";
        if ui.add(Button::selectable(is_following, "Follow")).on_hover_text(text).clicked() {
            self.follow_selected();
        }
    }
}

/// Shows a button that opens or closes a panel; `text` is its tooltip.
fn tab<T: PartialEq>(
    ui: &mut Ui,
    open: &mut Option<T>,
    panel: T,
    name: &str,
    text: &str,
) -> Response {
    let is_open = open.as_ref() == Some(&panel);
    let button = ui.add(Button::selectable(is_open, name)).on_hover_text(text);
    if button.clicked() {
        *open = (!is_open).then_some(panel);
    }
    button
}

/// Like [`tab`], with a count over its corner if it isn't 0. The count takes no room of its own, so
/// that the buttons beside it stay where they are.
fn tab_with_count<T: PartialEq>(
    ui: &mut Ui,
    open: &mut Option<T>,
    panel: T,
    name: &str,
    text: &str,
    (count, colour): (usize, Color32),
) {
    let button = tab(ui, open, panel, name, text);
    if count == 0 {
        return;
    }
    let enabled = ui.is_enabled();
    button.widget_info(|| WidgetInfo::labeled(Role::Button, enabled, format!("{name} {count}")));
    let text = if count <= MAX_COUNT { count.to_string() } else { format!("{MAX_COUNT}+") };
    let on_colour = ui.visuals().panel_fill;
    let text = ui.painter().layout_no_wrap(text, FontId::proportional(9.0), on_colour);
    let size = vec2((text.size().x + 6.0).max(12.0), 12.0);
    let badge = Rect::from_center_size(button.rect.right_top() + vec2(-3.0, 1.0), size);
    ui.painter().rect_filled(badge, 6.0, colour);
    ui.painter().galley(badge.center() - 0.5 * text.size(), text, on_colour);
}
