//! The commands of the keyboard shortcuts.

use regatta_plugin::frame::RobotState;

use super::context::PanelContext;
use super::keys::{self, Command};
use super::measure::Measuring;
use super::settings::{LeftPanel, RightPanel};
use super::state::Interface;
use super::view_model::{Action, Item, ViewModel};
use super::{heat, transport, view};

impl Interface {
    /// Carries out the commands of the pressed keys.
    pub(super) fn shortcuts(
        &mut self,
        ctx: &egui::Context,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        // The keys typed right after Ctrl+F are for the search field, which has the focus only now.
        if let Some(events) = self.late_input.take_if(|_| ctx.egui_wants_keyboard_input()) {
            ctx.input_mut(|input| drop(input.events.splice(0..0, events)));
        }
        for command in keys::pressed(ctx) {
            if command == Command::Find {
                self.late_input = Some(keys::take_input_after_find(ctx));
                ctx.request_repaint();
            }
            self.run(command, model, actions);
        }
    }

    /// Carries out a command.
    pub(super) fn run(
        &mut self,
        command: Command,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        self.present(model, actions, |interface, context| interface.execute(command, context));
    }

    fn execute(&mut self, command: Command, context: &PanelContext<'_>) {
        let (model, settings) = (context.model, &mut self.settings);
        match command {
            Command::Pause => transport::pause_or_resume(context),
            Command::Step => transport::step(context),
            Command::StepBack => self.timeline.step_back(context),
            Command::NextMark => self.timeline.go_to_mark(context, true),
            Command::PreviousMark => self.timeline.go_to_mark(context, false),
            Command::Loop => self.timeline.cycle_loop(context),
            Command::Note => self.timeline.begin_note(context),
            Command::Past => self.timeline.toggle_past(context),
            Command::Slower => transport::multiply_speed(context, 0.5),
            Command::Faster => transport::multiply_speed(context, 2.0),
            Command::FewerRobots => transport::multiply_robots(context, 0.8),
            Command::MoreRobots => transport::multiply_robots(context, 1.25),
            Command::Fit => self.camera_controller.fit(model.bounds, context.window),
            Command::Top => self.camera_controller.top(model.bounds, context.window),
            Command::Follow => self.follow_selected(),
            Command::Fly => self.fly_to_selected(model),
            Command::Find => {
                settings.left = Some(LeftPanel::Fleet);
                self.fleet.focus_search();
            }
            Command::Next => self.select_neighbour(model, true),
            Command::Previous => self.select_neighbour(model, false),
            // The key has only left a text field.
            Command::Deselect if self.last.typing => {}
            Command::Deselect => self.deselect(),
            Command::Fleet => toggle(&mut settings.left, LeftPanel::Fleet),
            Command::Collisions => toggle(&mut settings.left, LeftPanel::Collisions),
            Command::Spots => toggle(&mut settings.left, LeftPanel::Spots),
            Command::Log => toggle(&mut settings.left, LeftPanel::Log),
            Command::Plots => settings.plots = !settings.plots,
            Command::Selection => toggle(&mut settings.right, RightPanel::Selection),
            Command::View => toggle(&mut settings.right, RightPanel::View),
            Command::Performance => toggle(&mut settings.right, RightPanel::Performance),
            Command::Connection => toggle(&mut settings.right, RightPanel::Connection),
            Command::Colour => view::next_colouring(model, settings),
            Command::Theme => settings.light = !settings.light,
            Command::Graph => {
                let is_shown = settings.edges || settings.nodes;
                (settings.edges, settings.nodes) = (!is_shown, !is_shown);
            }
            Command::Plans => settings.plans = !settings.plans,
            Command::Waits => settings.waits = !settings.waits,
            Command::RobotIds => settings.robot_ids = !settings.robot_ids,
            Command::Plan => self.camera_controller.toggle_plan(),
            Command::Minimap => settings.minimap = !settings.minimap,
            Command::Measure => {
                self.measuring = match self.measuring {
                    Some(_) => None,
                    None => Some(Measuring::default()),
                }
            }
            Command::Density => settings.density = !settings.density,
            Command::Heat => settings.heat = !settings.heat,
            Command::NextFigure => heat::next_figure(settings),
            Command::PageUp => self.page(-1.0),
            Command::PageDown => self.page(1.0),
            Command::Help => self.help.is_open = !self.help.is_open,
            Command::Undo => match self.undo.take() {
                Some(mut step) => self.undoing.append(&mut step),
                None => self.notify("there is no command to undo"),
            },
            Command::Open => context.act(Action::Open),
            Command::Picture => context.act(Action::WritePicture),
            Command::FullScreen => context.act(Action::FullScreen),
            Command::Quit => context.act(Action::Quit),
        }
    }

    fn page(&mut self, pages: f64) {
        match self.settings.left {
            Some(LeftPanel::Fleet) => self.fleet.list.page(pages),
            Some(LeftPanel::Collisions) => self.collisions.list.page(pages),
            Some(LeftPanel::Spots) => self.spots.list.page(pages),
            Some(LeftPanel::Log) => self.log.list.page(pages),
            None => {}
        }
    }

    fn follow_selected(&mut self) {
        match self.selection.robot() {
            Some(id) => self.camera_controller.cycle_follow(id),
            None => self.notify("select a robot to follow"),
        }
    }

    fn deselect(&mut self) {
        if self.menu.close() {
            return;
        }
        if self.help.is_open {
            self.help.is_open = false;
        } else if self.measuring.is_some() {
            self.measuring = None;
        } else if self.spots.unmark() | self.selection.item.is_some() {
            self.select(None);
        } else {
            (self.settings.left, self.settings.right) = (None, None);
        }
        self.camera_controller.stop_following();
    }

    /// Selects the robot with the next or the previous id, and wraps round at the ends.
    fn select_neighbour(&mut self, model: &ViewModel<'_>, next: bool) {
        let Some(frame) = model.frame else { return };
        let now = match self.selection.robot() {
            Some(id) => id as usize,
            _ if next => frame.len().wrapping_sub(1),
            _ => 0,
        };
        let step = if next { 1 } else { frame.len().saturating_sub(1) };
        let around = (1..=frame.len()).map(|i| (now + i * step) % frame.len().max(1));
        let Some(id) = around.into_iter().find(|id| frame.state_of(*id) != RobotState::Absent)
        else {
            return;
        };
        self.select_in_sight(Some(Item::Robot(id as u32)));
        self.fleet.list.reveal(id);
    }
}

fn toggle<T: PartialEq>(open: &mut Option<T>, panel: T) {
    *open = if open.as_ref() == Some(&panel) { None } else { Some(panel) };
}
