//! The undo of commands to the fleet: each one that has an opposite can be taken back.

use regatta_plugin::control::{ControlKind, ControlRequest};

use super::view_model::{Action, ViewModel};
use crate::commands::UserCommand;
use crate::text::thousands;

/// The most steps that can be undone.
const MOST: usize = 100;

/// The actions that undo those of the user, the newest last.
#[derive(Clone, Debug, Default)]
pub(super) struct Undo(Vec<Vec<Action>>);

impl Undo {
    /// Remembers how to undo the actions of a picture: those of all selected robots are one step.
    /// Returns a message about those that break something.
    pub fn remember(&mut self, actions: &[Action], model: &ViewModel<'_>) -> Option<String> {
        let step: Vec<Action> =
            actions.iter().filter_map(|action| opposite(action, model)).collect();
        // A slider that is dragged changes the number of robots many times.
        let is_more_of_it =
            self.0.last().is_some_and(|last| sets_robots(last)) && sets_robots(&step);
        if !step.is_empty() && !is_more_of_it {
            self.0.push(step);
            let surplus = self.0.len().saturating_sub(MOST);
            self.0.drain(..surplus);
        }
        let harm = actions.iter().find_map(|action| harm_of(action, model))?;
        Some(format!("{harm}: Ctrl+Z undoes it"))
    }

    /// Takes the actions that undo the last step.
    pub fn take(&mut self) -> Option<Vec<Action>> {
        self.0.pop()
    }
}

fn sets_robots(step: &[Action]) -> bool {
    let kind = match step {
        [Action::Control(request)] => request.kind(),
        _ => None,
    };
    kind == Some(ControlKind::Robots)
}

/// Returns the action that undoes another one; `None` if there is none.
fn opposite(action: &Action, model: &ViewModel<'_>) -> Option<Action> {
    use UserCommand as U;
    Some(Action::Command(match *action {
        Action::Command(U::Hold(robot)) => U::Resume(robot),
        Action::Command(U::Resume(robot)) => U::Hold(robot),
        Action::Command(U::Break(robot)) => U::Repair(robot),
        Action::Command(U::SendByManager { robot, .. }) => U::Recall(robot),
        Action::Command(U::Close(edge)) => U::Open(edge),
        Action::Command(U::Open(edge)) => U::Close(edge),
        Action::Control(request) if request.kind() == Some(ControlKind::Robots) => {
            let count = u64::from(model.status?.robots);
            let before = ControlRequest { count, ..ControlRequest::new(ControlKind::Robots) };
            return (request.count != count).then_some(Action::Control(before));
        }
        _ => return None,
    }))
}

/// Returns the harm that an action does to the fleet, in words; `None` if it does none.
fn harm_of(action: &Action, model: &ViewModel<'_>) -> Option<String> {
    match action {
        Action::Command(command @ (UserCommand::Break(_) | UserCommand::Close(_))) => {
            Some(command.to_string())
        }
        Action::Control(request) if request.kind() == Some(ControlKind::Robots) => {
            let robots = u64::from(model.status?.robots);
            let removed = robots.saturating_sub(request.count);
            (removed > 0)
                .then(|| format!("remove {} of {} robots", thousands(removed), thousands(robots)))
        }
        _ => None,
    }
}
