//! The user interface over the picture of the fleet: panels, keyboard and mouse. It shows a [`ViewModel`], holds the
//! user's choices and returns [`Action`]s. It draws with egui and depends neither on windows nor on graphics cards, so
//! that tests drive it as it is.
//!
//! Each panel is a file with an `impl Interface` block; the fields of [`Interface`] are in `state.rs`.

pub mod camera_controller;
mod collisions;
mod connection;
mod filter;
mod fleet_list;
pub mod heat;
mod help;
mod history;
mod icons;
mod keys;
pub mod labels;
pub mod overlay;
mod performance;
mod plots;
mod pointer_input;
pub mod pose;
mod ramp;
pub mod rows;
mod selection;
pub mod settings;
mod shortcuts;
mod spots;
mod state;
pub mod style;
pub mod symbols;
pub mod timing;
mod top_bar;
mod transport;
mod view;
pub mod view_model;
mod virtual_list;
mod work;

use egui::{CentralPanel, Panel, Rect, ScrollArea, Ui};

use settings::{LeftPanel, RightPanel};
pub use state::Interface;
use view_model::{Action, Item, ViewModel};

impl Interface {
    /// Shows everything and handles keyboard and mouse. Returns where the picture of the fleet is, in points, and the
    /// actions that the caller carries out.
    pub fn show(&mut self, ui: &mut Ui, model: &ViewModel<'_>) -> (Rect, Vec<Action>) {
        let mut actions = Vec::new();
        self.apply_style(ui);
        self.shortcuts(ui.ctx(), model, &mut actions);
        self.typing = ui.ctx().egui_wants_keyboard_input();
        self.record_history(model);
        let frame = style::panel(self.settings.theme());
        Panel::top("top").exact_size(42.0).resizable(false).frame(frame).show(ui, |ui| self.top_bar(ui, model));
        Panel::bottom("bottom")
            .exact_size(48.0)
            .resizable(false)
            .frame(frame)
            .show(ui, |ui| self.transport(ui, model, &mut actions));
        self.plot_panel(ui, model, &mut actions);
        self.left_panel(ui, model, &mut actions);
        self.right_panel(ui, model, &mut actions);
        let picture = CentralPanel::no_frame()
            .show(ui, |ui| {
                let picture = ui.max_rect();
                self.pointer_input(ui, picture, &mut actions);
                picture
            })
            .inner;
        self.overlay(ui.ctx(), picture, model);
        self.help(ui.ctx());
        self.move_camera(ui, picture, model);
        (picture, actions)
    }

    fn apply_style(&mut self, ui: &Ui) {
        let wanted = (self.settings.theme(), self.settings.scale);
        if self.applied_style != Some(wanted) {
            style::apply(ui.ctx(), wanted.0);
            ui.ctx().set_zoom_factor(wanted.1);
            self.applied_style = Some(wanted);
        }
    }

    /// Advances flights and following, and fits everything into the picture until the user moves the camera.
    fn move_camera(&mut self, ui: &Ui, picture: Rect, model: &ViewModel<'_>) {
        let seconds = ui.input(|input| input.stable_dt).min(0.1);
        self.camera_controller.advance(seconds.into(), model.followed);
        if picture.is_positive() {
            self.camera_controller.keep_fitted(model.bounds, picture.aspect_ratio());
            self.aspect = picture.aspect_ratio();
        }
        if self.camera_controller.is_flying() {
            ui.ctx().request_repaint();
        }
    }

    fn record_history(&mut self, model: &ViewModel<'_>) {
        if let (Some(Item::Robot(id)), Some(frame)) = (self.selected, model.frame) {
            self.history.push(&frame, id);
        }
    }

    fn plot_panel(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        if self.settings.plots {
            let panel = Panel::bottom("plots").default_size(150.0).size_range(110.0..=320.0).resizable(true);
            panel.frame(style::panel(self.settings.theme())).show(ui, |ui| self.plots(ui, model, actions));
        }
    }

    fn left_panel(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let Some(open) = self.settings.left else { return };
        let panel = Panel::left("left").default_size(290.0).size_range(270.0..=460.0);
        panel.frame(style::panel(self.settings.theme())).show(ui, |ui| match open {
            LeftPanel::Fleet => self.fleet_list(ui, model, actions),
            LeftPanel::Collisions => self.collisions(ui, model),
            LeftPanel::Spots => self.hot_spots(ui, model, actions),
        });
    }

    fn right_panel(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let Some(open) = self.settings.right else { return };
        let panel = Panel::right("right").default_size(280.0).size_range(220.0..=460.0);
        panel.frame(style::panel(self.settings.theme())).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| match open {
                RightPanel::Selection => self.selection(ui, model),
                RightPanel::View => self.view(ui, model),
                RightPanel::Performance => self.performance(ui, model),
                RightPanel::Connection => self.connection(ui, model, actions),
            });
        });
    }
}
