//! The user interface over the picture of the fleet: panels, keyboard and mouse. It shows a
//! [`ViewModel`], holds the user's choices and returns [`Action`]s. It draws with egui and depends
//! neither on windows nor on graphics cards, so that tests drive it as it is.
//!
//! Each panel is a struct that owns its state, in a file of its own. It reads a `PanelContext` and
//! makes `Request`s, which [`Interface`] carries out.

pub mod banner;
pub mod camera_controller;
pub mod cameras;
mod collisions;
pub mod commands;
mod connection;
mod context;
pub mod edge_finder;
mod edge_hover;
mod filter;
mod fleet_list;
pub mod footprint;
pub mod heat;
mod help;
mod history;
pub mod hottest;
mod icons;
pub mod jams;
mod keyed;
mod keys;
pub mod labels;
pub mod legend;
pub mod levels;
pub mod log;
mod log_panel;
pub mod measure;
mod menu;
mod minimap;
mod notes;
pub mod orders;
pub mod overlay;
pub mod performance;
pub mod placement;
mod places;
pub mod plan;
mod plots;
mod pointer_input;
pub mod pose;
mod ramp;
pub mod robot_filter;
pub mod robot_spots;
pub mod rows;
mod search;
mod selection;
pub mod settings;
mod shortcuts;
mod spots;
mod state;
mod strip;
pub mod style;
pub mod symbols;
pub mod text;
mod timeline;
mod top_bar;
pub mod transport;
mod undo;
mod view;
mod view_cube;
pub mod view_model;
mod virtual_list;
mod work;

use egui::{CentralPanel, Panel, Pos2, Rect, ScrollArea, Ui, UiBuilder};
use regatta_scene::camera::Window;

use context::PanelContext;
pub use context::Selection;
use legend::LegendRoom;
use levels::PictureArea;
use settings::{LeftPanel, RightPanel};
pub use state::Interface;
use top_bar::TopBar;
use view_model::{Action, ViewModel};

/// The least width of a window with a panel on either side, in points.
const TWO_PANELS: f32 = 900.0;

/// The least width of a window that has room for panels on both sides, in points. In a narrower
/// one, two open panels share the left side, so that most of the window is for the plant.
const BOTH_SIDES: f32 = 1400.0;

/// The least width of a window in which the panel on the left opens wide, in points.
const ALL_COLUMNS: f32 = 1500.0;

/// The least distance in points of a selected item from the end of what is in sight.
const IN_SIGHT: f32 = 40.0;

/// The least heights of a panel on a side, of the plots, and of the picture over them, in points.
const LOWEST_PANEL: f32 = 180.0;
const LOWEST_PLOTS: f32 = 55.0;
const LOWEST_PICTURE: f32 = 20.0;

/// The heights at which plots open in a low window without other panels, and in a high one, in
/// points.
const LOW_PLOTS: f32 = 110.0;
/// The margin over and under plots that are as low as they can be, in points.
const LOW_MARGIN: i8 = 3;
const HIGH_PLOTS: f32 = 150.0;

/// The height of a window below which plots open low, and as low as they can be beside a panel, in
/// points.
const LOW: f32 = 900.0;

impl Interface {
    /// Shows everything and handles keyboard and mouse. Returns where the picture of the fleet is,
    /// in points, and the actions that the caller carries out.
    pub fn show(&mut self, ui: &mut Ui, model: &ViewModel<'_>) -> (Rect, Vec<Action>) {
        let (mut actions, level) = (Vec::new(), self.level().map(str::to_owned));
        self.shortcuts(ui.ctx(), model, &mut actions);
        // After the keys, so that no picture is half in the one and half in the other theme.
        self.apply_style(ui);
        self.last.typing = ui.ctx().egui_wants_keyboard_input();
        if let Some(frame) = model.frame {
            self.selection_panel.record(&frame, self.selection.robot());
        }
        if std::mem::take(&mut self.levels.is_refiltered) {
            actions.push(Action::Filter(self.filter.clone()));
        }
        ui.ctx().accesskit_node_builder(egui::accesskit_root_id(), |node| {
            node.set_label(format!("Regatta: {}", model.fleet));
        });
        let frame = style::panel(self.settings.theme());
        Panel::top("top").exact_size(42.0).resizable(false).frame(frame).show(ui, |ui| {
            self.present(model, &mut actions, |interface, context| {
                let bar = TopBar {
                    settings: &interface.settings,
                    alarms: interface.log.log.unacknowledged(),
                    is_measuring: interface.measuring.is_some(),
                };
                bar.show(context, ui);
            });
        });
        self.strip(ui, model, &mut actions);
        Panel::bottom("bottom").exact_size(48.0).resizable(false).frame(frame).show(ui, |ui| {
            self.present(model, &mut actions, |interface, context| {
                let shows_past = interface.timeline.shows_past;
                interface.transport.show(context, shows_past, ui);
            });
        });
        // The picture continues under the panels, so that it doesn't move when one is opened.
        let picture = ui.available_rect_before_wrap();
        if model.recording().is_some() || model.timeline.is_some() && self.timeline.shows_past {
            Panel::bottom("timeline")
                .exact_size(timeline::HEIGHT)
                .resizable(false)
                .frame(frame)
                .show(ui, |ui| {
                    self.present(model, &mut actions, |interface, context| {
                        interface.timeline.show(context, ui);
                    });
                });
        }
        self.leave_room(ui.available_height());
        self.plot_panel(ui, model, &mut actions);
        self.panels(ui, model, &mut actions);
        let shown = CentralPanel::no_frame().show(ui, |ui| {
            let area = self.area(ui, picture, ui.max_rect(), model.bounds);
            let (camera, is_measuring) = (&mut self.camera_controller, self.measuring.is_some());
            (area, self.pointer.handle(ui, area, camera, is_measuring, &mut actions))
        });
        let (area, pointer) = shown.inner;
        // Before the elements over the picture, so that they are drawn with the picture's camera.
        self.move_camera(ui, area, model);
        self.last.camera = self.camera_controller.camera();
        let legend = self.last.legend;
        self.present(model, &mut actions, |interface, context| {
            interface.over_picture(context, ui.ctx(), area, pointer);
        });
        if let Some(message) = self.undo.remember(&actions, model) {
            self.notify(message);
        }
        actions.append(&mut self.undoing);
        let has_moved = self.camera_controller.camera() != self.last.camera;
        if self.level() != level.as_deref() || has_moved || self.last.legend != legend {
            ui.ctx().request_repaint();
        }
        (area.picture, self.timely(level.as_deref(), actions))
    }

    /// Shows the figures of the fleet's work, if it has a manager and there is room.
    fn strip(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        if !strip::is_shown(model) || ui.ctx().content_rect().height() < strip::LEAST_WINDOW {
            return;
        }
        let frame =
            style::panel(self.settings.theme()).inner_margin(egui::Margin::symmetric(12, 2));
        Panel::top("strip").exact_size(strip::HEIGHT).resizable(false).frame(frame).show(
            ui,
            |ui| {
                self.present(model, actions, |_, context| strip::show(context, ui));
            },
        );
    }

    /// Shows everything that floats over the picture. `pointer` is the place of the pointer over
    /// it.
    fn over_picture(
        &mut self,
        context: &PanelContext<'_>,
        ctx: &egui::Context,
        area: PictureArea,
        pointer: Option<Pos2>,
    ) {
        let can_hover = self.settings.edges && !self.menu.is_open() && self.measuring.is_none();
        let heat = self.settings.heat.then_some(self.settings.heat_of);
        self.edge_hover.show(context, ctx, area, pointer.filter(|_| can_hover), heat);
        self.overlay(context, ctx, area);
        self.menu.show(context, ctx, area.whole);
        self.help.show(context, ctx);
    }

    /// In a low window, plots that open close the panels beside them, and the other way round.
    fn leave_room(&mut self, height: f32) {
        let open = &mut self.settings;
        if height < LOWEST_PANEL + LOWEST_PLOTS
            && open.plots
            && (open.left.is_some() || open.right.is_some())
        {
            match self.last.plots {
                true => open.plots = false,
                false => (open.left, open.right) = (None, None),
            }
        }
        self.last.plots = self.settings.plots;
    }

    /// Shows the open panels, both on the left in a window of medium width. In a narrow or low
    /// one, a panel that opens closes the other one.
    fn panels(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let room = ui.available_size();
        let open = &mut self.settings;
        let is_shared = room.x < BOTH_SIDES && open.left.is_some() && open.right.is_some();
        let is_too_small = room.x < TWO_PANELS || room.y < 2.0 * LOWEST_PANEL;
        if is_shared && is_too_small {
            match open.left == self.last.left {
                true => open.left = None,
                false => open.right = None,
            }
        }
        self.last.left = open.left;
        let shared = self.settings.right.filter(|_| is_shared && !is_too_small);
        self.left_panel(ui, room.x, shared, model, actions);
        if shared.is_none() {
            self.right_panel(ui, room.x, model, actions);
        }
    }

    fn apply_style(&mut self, ui: &Ui) {
        let wanted = (self.settings.theme(), self.settings.scale);
        if self.applied_style != Some(wanted) {
            style::apply(ui.ctx(), wanted.0);
            ui.ctx().set_zoom_factor(wanted.1);
            self.applied_style = Some(wanted);
        }
    }

    /// Advances flights and following, and fits everything into the picture until the user moves
    /// the camera.
    fn move_camera(&mut self, ui: &Ui, area: PictureArea, model: &ViewModel<'_>) {
        self.last.window = self.free_part(area).unwrap_or(self.last.window);
        let seconds = ui.input(|input| input.stable_dt).min(0.1);
        let robot = self.camera_controller.flies_to();
        let pose = robot.and_then(|robot| model.pose(robot, self.settings.offset));
        self.bring_in_sight(area, model);
        self.camera_controller.aim(pose.map(|pose| pose.place), self.last.window);
        self.camera_controller.advance(seconds.into(), model.followed);
        self.camera_controller.keep_fitted(model.bounds, self.last.window);
        if self.camera_controller.is_flying() {
            ui.ctx().request_repaint();
        }
    }

    /// Moves what was selected by a key or in a panel from under panels and the legend, or from
    /// outside of the picture.
    fn bring_in_sight(&mut self, area: PictureArea, model: &ViewModel<'_>) {
        let camera = &self.camera_controller;
        // A fitted camera shows it, as soon as it has made room for a panel that opens.
        let is_led = camera.is_flying() || camera.followed().is_some() || camera.is_fitted();
        if !std::mem::take(&mut self.last.reveals) || is_led {
            return;
        }
        let Some(place) = self.place_of_selected(model) else { return };
        let at = camera.camera().project(place.extend(0.0), area.size());
        let Window { low, high, .. } = self.last.window;
        let is_in_sight = at.is_some_and(|at| {
            let (low, high) = (low * area.size() + IN_SIGHT, high * area.size() - IN_SIGHT);
            at.cmpgt(low).all() && at.cmplt(high).all()
        });
        if !is_in_sight {
            self.camera_controller.show(self.selection.robot(), place);
        }
    }

    /// The part of the picture that is under no panel; `None` if there is nothing of either.
    fn free_part(&self, area: PictureArea) -> Option<Window> {
        let PictureArea { picture, visible, .. } = area;
        if !picture.is_positive() || !visible.is_positive() {
            return None;
        }
        let size = glam::Vec2::new(picture.width(), picture.height());
        // Nothing of the fleet is to lie under the legend. Levels side by side lie beside it.
        let LegendRoom { left, below } = match self.parts().is_empty() {
            true => self.legend_room(visible.width()),
            false => LegendRoom::default(),
        };
        let [low, high] =
            [visible.min + egui::vec2(left, 0.0), visible.max - egui::vec2(0.0, below)]
                .map(|at| glam::Vec2::new(at.x - picture.left(), at.y - picture.top()) / size);
        Some(Window { aspect: picture.aspect_ratio(), low, high })
    }

    fn plot_panel(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        if self.settings.plots {
            let beside = if self.settings.left.is_some() || self.settings.right.is_some() {
                LOWEST_PANEL
            } else {
                LOWEST_PICTURE
            };
            let highest = (ui.available_height() - beside).clamp(0.0, 320.0);
            let sizes = LOWEST_PLOTS.min(highest)..=highest;
            let is_low = ui.ctx().content_rect().height() < LOW;
            // Each name keeps a size of its own: plots are high again when the others close.
            let (name, size) = match (is_low, beside == LOWEST_PANEL) {
                (true, true) => ("low plots", LOWEST_PLOTS),
                (true, false) => ("plots", LOW_PLOTS),
                (false, _) => ("plots", HIGH_PLOTS),
            };
            let panel = Panel::bottom(name).default_size(size).size_range(sizes).resizable(true);
            let margin = if size == LOWEST_PLOTS { LOW_MARGIN } else { style::PANEL_MARGIN as i8 };
            let frame = style::panel(self.settings.theme());
            let frame = frame.inner_margin(egui::Margin::symmetric(12, margin));
            panel.frame(frame).show(ui, |ui| {
                within(ui, |ui| {
                    self.present(model, actions, |interface, context| {
                        interface.plots.show(context, ui);
                    });
                })
            });
        }
    }

    /// Shows the panel on the left, over a `shared` one if there is one.
    fn left_panel(
        &mut self,
        ui: &mut Ui,
        room: f32,
        shared: Option<RightPanel>,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let Some(open) = self.settings.left else { return };
        // The list of robots has all its columns where there is room.
        let size = if room >= ALL_COLUMNS { 470.0 } else { 290.0 };
        let panel = Panel::left("left")
            .default_size(size)
            .size_range(270.0..=640.0_f32.min(room - 40.0).max(270.0));
        panel.frame(style::panel(self.settings.theme())).show(ui, |ui| {
            within(ui, |ui| {
                if let Some(shared) = shared {
                    self.lower_panel(ui, shared, model, actions);
                }
                self.present(model, actions, |interface, context| match open {
                    LeftPanel::Fleet => interface.fleet.show(context, ui),
                    LeftPanel::Collisions => interface.collisions.show(context, ui),
                    LeftPanel::Spots => interface.spots.show(context, ui),
                    LeftPanel::Log => interface.log.show(context, ui),
                });
            });
        });
    }

    /// Shows a panel that belongs on the right below the one on the left.
    fn lower_panel(
        &mut self,
        ui: &mut Ui,
        open: RightPanel,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let room = ui.available_height();
        let sizes = LOWEST_PANEL.min(room / 2.0)..=(room - LOWEST_PANEL).max(room / 2.0);
        let panel = Panel::bottom("lower").default_size(room / 2.0).size_range(sizes);
        let margin = egui::Margin { top: style::PANEL_MARGIN as i8, ..egui::Margin::ZERO };
        panel.frame(egui::Frame::new().inner_margin(margin)).resizable(true).show(ui, |ui| {
            within(ui, |ui| self.scroll_right(ui, open, model, actions));
        });
    }

    fn right_panel(
        &mut self,
        ui: &mut Ui,
        room: f32,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let Some(open) = self.settings.right else { return };
        let panel = Panel::right("right")
            .default_size(280.0)
            .size_range(270.0..=460.0_f32.min(room - 40.0).max(270.0));
        panel.frame(style::panel(self.settings.theme())).show(ui, |ui| {
            within(ui, |ui| self.scroll_right(ui, open, model, actions));
        });
    }

    fn scroll_right(
        &mut self,
        ui: &mut Ui,
        open: RightPanel,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            self.present(model, actions, |interface, context| {
                interface.show_right(context, open, ui);
            });
        });
    }

    fn show_right(&mut self, context: &PanelContext<'_>, open: RightPanel, ui: &mut Ui) {
        let settings = &mut self.settings;
        match open {
            RightPanel::Selection => self.selection_panel.show(context, ui),
            RightPanel::View => {
                self.view.show(context, settings, &self.levels, &self.bookmarks, ui);
            }
            RightPanel::Performance => performance::show(context, ui),
            RightPanel::Connection => connection::show(context, &mut settings.udp, ui),
        }
    }
}

/// Shows the contents of a panel. They don't enlarge it, because it would cover the bars.
fn within(ui: &mut Ui, show: impl FnOnce(&mut Ui)) {
    let room = ui.available_rect_before_wrap();
    let mut inside = ui.new_child(UiBuilder::new().max_rect(room));
    inside.shrink_clip_rect(room.expand(style::PANEL_MARGIN));
    show(&mut inside);
    ui.expand_to_include_rect(room);
}
