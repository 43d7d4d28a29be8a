//! What the keys do.

use egui::Context;
use regatta_plugin::frame::RobotState;

use super::Interface;
use super::facts::{Action, Facts, Thing};
use super::keys::{self, Deed};
use super::settings::{Left, Right};

impl Interface {
    pub(super) fn keys(&mut self, context: &Context, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        for deed in keys::pressed(context) {
            self.carry_out(deed, facts, actions);
        }
    }

    fn carry_out(&mut self, deed: Deed, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        match deed {
            Deed::Pause => actions.push(self.pause_or_resume(facts)),
            Deed::Step => actions.extend(self.step(facts)),
            Deed::Slower => actions.push(self.times_speed(facts, 0.5)),
            Deed::Faster => actions.push(self.times_speed(facts, 2.0)),
            Deed::FewerRobots => actions.push(self.times_robots(facts, 0.8)),
            Deed::MoreRobots => actions.push(self.times_robots(facts, 1.25)),
            Deed::Fit => self.rig.fit(facts.bounds, self.aspect),
            Deed::Top => self.rig.top(facts.bounds, self.aspect),
            Deed::Follow => self.follow_selected(),
            Deed::Fly => self.fly_to_selected(facts),
            Deed::Find => {
                self.settings.left = Some(Left::Fleet);
                self.list.find = true;
            }
            Deed::Next => self.select_neighbour(facts, true),
            Deed::Previous => self.select_neighbour(facts, false),
            // What leaves a text field does no more.
            Deed::Deselect if self.typing => {}
            Deed::Deselect => self.deselect(),
            Deed::Fleet => toggle(&mut self.settings.left, Left::Fleet),
            Deed::Collisions => toggle(&mut self.settings.left, Left::Collisions),
            Deed::Selection => toggle(&mut self.settings.right, Right::Selection),
            Deed::View => toggle(&mut self.settings.right, Right::View),
            Deed::Performance => toggle(&mut self.settings.right, Right::Performance),
            Deed::Connection => toggle(&mut self.settings.right, Right::Connection),
            Deed::Colour => self.next_colouring(facts),
            Deed::Theme => self.settings.light = !self.settings.light,
            Deed::Graph => {
                let shown = self.settings.edges || self.settings.nodes;
                (self.settings.edges, self.settings.nodes) = (!shown, !shown);
            }
            Deed::PageUp => self.page(-1.0),
            Deed::PageDown => self.page(1.0),
            Deed::Help => self.help = !self.help,
            Deed::FullScreen => actions.push(Action::FullScreen),
            Deed::Quit => actions.push(Action::Quit),
        }
    }

    fn page(&mut self, pages: f64) {
        match self.settings.left {
            Some(Left::Fleet) => self.list.scroll.page(pages),
            Some(Left::Collisions) => self.collision_scroll.page(pages),
            None => {}
        }
    }

    pub(super) fn follow_selected(&mut self) {
        match self.selected {
            Some(Thing::Robot(id)) => self.rig.cycle_follow(id),
            _ => self.tell("select a robot to follow"),
        }
    }

    fn deselect(&mut self) {
        if self.help {
            self.help = false;
        } else if self.selected.is_some() {
            self.select(None);
        } else {
            (self.settings.left, self.settings.right) = (None, None);
        }
        self.rig.follow_nobody();
    }

    /// Selects the robot with the next id, or the one before.
    fn select_neighbour(&mut self, facts: &Facts<'_>, next: bool) {
        let Some(frame) = facts.frame else { return };
        let now = match self.selected {
            Some(Thing::Robot(id)) => id as usize,
            _ if next => frame.len().wrapping_sub(1),
            _ => 0,
        };
        let step = if next { 1 } else { frame.len().saturating_sub(1) };
        let around = (1..=frame.len()).map(|i| (now + i * step) % frame.len().max(1));
        let Some(id) = around.into_iter().find(|id| frame.state_of(*id) != RobotState::Absent) else { return };
        self.select(Some(Thing::Robot(id as u32)));
        self.list.scroll.reveal(id);
    }
}

fn toggle<T: PartialEq>(open: &mut Option<T>, panel: T) {
    *open = if open.as_ref() == Some(&panel) { None } else { Some(panel) };
}
