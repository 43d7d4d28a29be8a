//! The bar at the top: the fleet and the state of its engine, the panels, and the views of the
//! camera.

use egui::{Align, Button, FontId, Layout, Rect, Response, RichText, Role, Ui, WidgetInfo, vec2};

use super::context::{PanelContext, Request};
use super::icons::{self, Icon};
use super::keys::Command;
use super::settings::{LeftPanel, RightPanel, Settings};
use super::style::status_dot;

/// The least width of the window for all tabs and buttons side by side, in points; a narrower one
/// has menus.
const WIDE: f32 = 1220.0;
/// The least width at which the state of the engine is a text; below, it is a tooltip.
const WITH_STATE: f32 = 560.0;
/// The width of all tabs and buttons side by side, without the name and the state of the fleet, in
/// points.
const TABS: f32 = 1095.0;
/// The greatest count that a tab shows as a number.
const MAX_COUNT: usize = 99;

/// The facts that the bar shows beside those of its context.
#[derive(Clone, Copy)]
pub(super) struct TopBar<'a> {
    /// The open panels, and the theme.
    pub settings: &'a Settings,
    /// The number of unacknowledged alarms.
    pub alarms: usize,
    /// Whether something is measured.
    pub is_measuring: bool,
}

impl TopBar<'_> {
    /// Shows the bar.
    pub fn show(self, context: &PanelContext<'_>, ui: &mut Ui) {
        let room = ui.available_width();
        ui.horizontal_centered(|ui| {
            fleet_state(context, ui, room);
            ui.separator();
            if room >= WIDE {
                self.left_tabs(context, ui);
                ui.separator();
                self.camera_buttons(context, ui);
            } else {
                self.menus(context, ui);
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("?").on_hover_text("Keys and mouse (?)").clicked() {
                    context.ask(Request::Run(Command::Help));
                }
                let (icon, name) =
                    if self.settings.light { (Icon::Moon, "Dark") } else { (Icon::Sun, "Light") };
                let button = icons::button(ui, icon, name, vec2(26.0, 22.0));
                if button.on_hover_text(format!("{name} (L)")).clicked() {
                    context.ask(Request::Run(Command::Theme));
                }
                let text = "Open a layout, a scenario or a recording (Ctrl+O)";
                if ui.button("Open…").on_hover_text(text).clicked() {
                    context.ask(Request::Run(Command::Open));
                }
                if room >= WIDE {
                    ui.separator();
                    self.right_tabs(context, ui, true);
                }
            });
        });
    }

    /// Shows the menus of a narrow window.
    fn menus(self, context: &PanelContext<'_>, ui: &mut Ui) {
        let mut name = RichText::new("Panels");
        if touching(context) > 0 || self.alarms > 0 {
            name = name.color(context.colours.bad);
        }
        ui.menu_button(name, |ui| {
            self.left_tabs(context, ui);
            self.right_tabs(context, ui, false);
        });
        ui.menu_button("Camera", |ui| self.camera_buttons(context, ui));
    }

    fn left_tabs(self, context: &PanelContext<'_>, ui: &mut Ui) {
        let open = self.settings.left;
        let text = "The list of all robots (1)";
        tab(context, ui, open == Some(LeftPanel::Fleet), Command::Fleet, "Fleet", text);
        let text = "Pairs of robots that touch, or may touch (2)";
        let is_open = open == Some(LeftPanel::Collisions);
        let button = tab(context, ui, is_open, Command::Collisions, "Collisions", text);
        count(context, ui, &button, "Collisions", touching(context));
        let text = "The places that have cost the most time (7)";
        tab(context, ui, open == Some(LeftPanel::Spots), Command::Spots, "Hot spots", text);
        let text = "What happened, and alarms (9)";
        let button = tab(context, ui, open == Some(LeftPanel::Log), Command::Log, "Log", text);
        count(context, ui, &button, "Log", self.alarms);
        tab(context, ui, self.settings.plots, Command::Plots, "Plots", "Figures over time (8)");
    }

    /// Shows the tabs of the panels on the right; `reversed` if they are laid out from the right.
    fn right_tabs(self, context: &PanelContext<'_>, ui: &mut Ui, reversed: bool) {
        use {Command as C, RightPanel as P};
        let mut tabs = [
            (P::Selection, C::Selection, "Selection", "What is selected (3)"),
            (P::View, C::View, "View", "Colours, layers and files (4)"),
            (P::Performance, C::Performance, "Performance", "Rates and durations (5)"),
            (P::Connection, C::Connection, "Connection", "The engine and UDP (6)"),
        ];
        if reversed {
            tabs.reverse();
        }
        for (panel, command, name, text) in tabs {
            tab(context, ui, self.settings.right == Some(panel), command, name, text);
        }
    }

    fn camera_buttons(self, context: &PanelContext<'_>, ui: &mut Ui) {
        for (command, name, text) in [
            (Command::Fit, "Fit", "Fit everything into the picture (Home)"),
            (Command::Top, "Top", "View from above (T)"),
        ] {
            if ui.button(name).on_hover_text(text).clicked() {
                context.ask(Request::Run(command));
            }
        }
        let text = "An orthographic plan with footprints, coordinates and a scale (O)";
        tab(context, ui, context.camera.is_plan(), Command::Plan, "Plan", text);
        let text = "Distance between two places or robots, and clearance between robots (M)";
        tab(context, ui, self.is_measuring, Command::Measure, "Measure", text);
        let text = "Follow the selected robot: from behind, from above, off (F)";
        tab(context, ui, context.followed.is_some(), Command::Follow, "Follow", text);
    }
}

/// Shows the name and the state of the fleet in a bar of this width, in points.
fn fleet_state(context: &PanelContext<'_>, ui: &mut Ui, room: f32) {
    let (text, colour) = context.model.engine.text_and_colour(&context.colours);
    let font = FontId::proportional(12.0);
    let state = ui.painter().layout_no_wrap(text.to_owned(), font, colour).size().x;
    ui.scope(|ui| {
        ui.set_max_width(match room {
            wide if wide >= WIDE => (wide - TABS - state).clamp(60.0, 220.0),
            narrow if narrow >= WITH_STATE => 220.0,
            _ => 90.0,
        });
        let name = RichText::new(context.model.name()).strong().size(14.0);
        status_dot(ui, colour, name).on_hover_text(text);
    });
    if room >= WITH_STATE {
        ui.label(RichText::new(text).color(colour).size(12.0));
    }
}

/// The number of pairs of robots that touch.
fn touching(context: &PanelContext<'_>) -> usize {
    context.model.contacts.map_or(0, |contacts| contacts.header.touching as usize)
}

/// Shows a button that switches something on or off; `text` is its tooltip.
fn tab(
    context: &PanelContext<'_>,
    ui: &mut Ui,
    is_on: bool,
    command: Command,
    name: &str,
    text: &str,
) -> Response {
    let button = ui.add(Button::selectable(is_on, name)).on_hover_text(text);
    if button.clicked() {
        context.ask(Request::Run(command));
    }
    button
}

/// Shows a count over the corner of a button if it isn't 0. It takes no room of its own, so that
/// the buttons beside it stay in place.
fn count(context: &PanelContext<'_>, ui: &Ui, button: &Response, name: &str, count: usize) {
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
    ui.painter().rect_filled(badge, 6.0, context.colours.bad);
    ui.painter().galley(badge.center() - 0.5 * text.size(), text, on_colour);
}
