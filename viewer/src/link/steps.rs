//! The thread that sends steps to the engine. A step is answered when it is done, which may take
//! arbitrarily long: other requests, a pause among them, must not wait for it.

use std::sync::mpsc::{Receiver, Sender};
use std::time::Duration;

use regatta_plugin::control::{ControlKind, ControlRequest};
use regatta_plugin::{Control, FleetName, Result};

use super::report::Report;

/// A message to the thread.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// Advance by a number of ticks.
    Forward(u64),
    /// Forget the steps that were not sent yet: another request has ended the stepping.
    End,
}

impl Step {
    /// Returns the effect of a request on steps, if it has one.
    pub fn of(request: &ControlRequest) -> Option<Self> {
        match request.kind()? {
            ControlKind::Step => Some(Self::Forward(request.count)),
            ControlKind::Pause | ControlKind::Resume | ControlKind::Seek => Some(Self::End),
            ControlKind::Status | ControlKind::Speed | ControlKind::Robots => None,
        }
    }
}

/// Sends steps until the sender is dropped and the engine has answered, which may take arbitrarily
/// long.
pub fn run(fleet: &FleetName, requested: &Receiver<Step>, report: &Sender<Report>) -> Result {
    let mut control = None;
    while let Ok(first) = requested.recv() {
        // Steps that were requested during the last one are sent as one.
        let ticks = std::iter::once(first).chain(requested.try_iter()).fold(0, add);
        if ticks == 0 {
            continue;
        }
        let control = match &mut control {
            Some(control) => control,
            none => none.insert(Control::open(fleet)?),
        };
        let request = ControlRequest { count: ticks, ..ControlRequest::new(ControlKind::Step) };
        let answer = control.request(request, Duration::MAX);
        if report.send(Report::of_answer(answer, true)).is_err() {
            break;
        }
    }
    Ok(())
}

fn add(ticks: u64, step: Step) -> u64 {
    match step {
        Step::Forward(more) => ticks.saturating_add(more),
        Step::End => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_wait_are_added_up_until_another_request_ends_them() {
        use Step::{End, Forward};
        assert_eq!(
            [Forward(1), Forward(2), End, Forward(3), Forward(4)].into_iter().fold(0, add),
            7
        );
        assert_eq!([Forward(1), End].into_iter().fold(0, add), 0);
    }
}
