//! The commands of the keyboard shortcuts.

use egui::Context;
use regatta_plugin::frame::RobotState;

use super::keys::{self, Command};
use super::settings::{LeftPanel, RightPanel};
use super::state::Interface;
use super::view_model::{Action, Item, ViewModel};

impl Interface {
    pub(super) fn shortcuts(
        &mut self,
        context: &Context,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        // What was typed right after Ctrl+F is for the search field, which has the focus only now.
        if let Some(events) = self.late_input.take_if(|_| context.egui_wants_keyboard_input()) {
            context.input_mut(|input| drop(input.events.splice(0..0, events)));
        }
        for command in keys::pressed(context) {
            self.execute(context, command, model, actions);
        }
    }

    fn execute(
        &mut self,
        context: &Context,
        command: Command,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        match command {
            Command::Pause => actions.extend(self.pause_or_resume(model)),
            Command::Step => actions.extend(self.step(model)),
            Command::StepBack => self.step_back(model, actions),
            Command::NextMark => self.go_to_mark(model, true, actions),
            Command::PreviousMark => self.go_to_mark(model, false, actions),
            Command::Loop => self.cycle_loop(model),
            Command::Note => self.begin_note(model),
            Command::Past => self.toggle_past(actions),
            Command::Slower => actions.push(self.times_speed(model, 0.5)),
            Command::Faster => actions.push(self.times_speed(model, 2.0)),
            Command::FewerRobots => actions.extend(self.times_robots(model, 0.8)),
            Command::MoreRobots => actions.extend(self.times_robots(model, 1.25)),
            Command::Fit => self.camera_controller.fit(model.bounds, self.window),
            Command::Top => self.camera_controller.top(model.bounds, self.window),
            Command::Follow => self.follow_selected(),
            Command::Fly => self.fly_to_selected(model),
            Command::Find => {
                self.settings.left = Some(LeftPanel::Fleet);
                self.fleet_list.request_focus = true;
                self.late_input = Some(keys::take_input_after_find(context));
                context.request_repaint();
            }
            Command::Next => self.select_neighbour(model, true),
            Command::Previous => self.select_neighbour(model, false),
            // The key has only left a text field.
            Command::Deselect if self.typing => {}
            Command::Deselect => self.deselect(),
            Command::Fleet => toggle(&mut self.settings.left, LeftPanel::Fleet),
            Command::Collisions => toggle(&mut self.settings.left, LeftPanel::Collisions),
            Command::Spots => toggle(&mut self.settings.left, LeftPanel::Spots),
            Command::Log => toggle(&mut self.settings.left, LeftPanel::Log),
            Command::Plots => self.settings.plots = !self.settings.plots,
            Command::Selection => toggle(&mut self.settings.right, RightPanel::Selection),
            Command::View => toggle(&mut self.settings.right, RightPanel::View),
            Command::Performance => toggle(&mut self.settings.right, RightPanel::Performance),
            Command::Connection => toggle(&mut self.settings.right, RightPanel::Connection),
            Command::Colour => self.next_colouring(model),
            Command::Theme => self.settings.light = !self.settings.light,
            Command::Graph => {
                let is_shown = self.settings.edges || self.settings.nodes;
                (self.settings.edges, self.settings.nodes) = (!is_shown, !is_shown);
            }
            Command::Plans => self.settings.plans = !self.settings.plans,
            Command::Waits => self.settings.waits = !self.settings.waits,
            Command::RobotIds => self.settings.robot_ids = !self.settings.robot_ids,
            Command::Plan => self.camera_controller.toggle_plan(),
            Command::Minimap => self.settings.minimap = !self.settings.minimap,
            Command::Measure => self.toggle_measuring(),
            Command::Density => self.settings.density = !self.settings.density,
            Command::Heat => self.settings.heat = !self.settings.heat,
            Command::NextFigure => self.next_figure(),
            Command::PageUp => self.page(-1.0),
            Command::PageDown => self.page(1.0),
            Command::Help => self.help = !self.help,
            Command::FullScreen => actions.push(Action::FullScreen),
            Command::Quit => actions.push(Action::Quit),
        }
    }

    fn page(&mut self, pages: f64) {
        match self.settings.left {
            Some(LeftPanel::Fleet) => self.fleet_list.list.page(pages),
            Some(LeftPanel::Collisions) => self.collision_list.page(pages),
            Some(LeftPanel::Spots) => self.spot_list.page(pages),
            Some(LeftPanel::Log) => self.log_panel.list.page(pages),
            None => {}
        }
    }

    pub(super) fn follow_selected(&mut self) {
        match self.selected {
            Some(Item::Robot(id)) => self.camera_controller.cycle_follow(id),
            _ => self.notify("select a robot to follow"),
        }
    }

    fn deselect(&mut self) {
        if self.close_menu() {
            return;
        }
        if self.help {
            self.help = false;
        } else if self.measuring.is_some() {
            self.measuring = None;
        } else if self.selected.is_some() || self.marked.is_some() {
            self.select(None);
            self.marked = None;
        } else {
            (self.settings.left, self.settings.right) = (None, None);
        }
        self.camera_controller.stop_following();
    }

    /// Selects the robot with the next or the previous id, and wraps round at the ends.
    fn select_neighbour(&mut self, model: &ViewModel<'_>, next: bool) {
        let Some(frame) = model.frame else { return };
        let now = match self.selected {
            Some(Item::Robot(id)) => id as usize,
            _ if next => frame.len().wrapping_sub(1),
            _ => 0,
        };
        let step = if next { 1 } else { frame.len().saturating_sub(1) };
        let around = (1..=frame.len()).map(|i| (now + i * step) % frame.len().max(1));
        let Some(id) = around.into_iter().find(|id| frame.state_of(*id) != RobotState::Absent)
        else {
            return;
        };
        self.select(Some(Item::Robot(id as u32)));
        self.fleet_list.list.reveal(id);
    }
}

fn toggle<T: PartialEq>(open: &mut Option<T>, panel: T) {
    *open = if open.as_ref() == Some(&panel) { None } else { Some(panel) };
}
