//! The thread that sends requests to the engine and polls its status.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use regatta_plugin::control::{ControlKind, ControlRequest};
use regatta_plugin::{Control, ControlError, FleetName, Result};

use super::report::{Fact, Report};

/// The time between two polls of the engine's status.
const STATUS_EVERY: Duration = Duration::from_millis(250);
/// The timeout of a request.
const TIMEOUT: Duration = Duration::from_secs(2);

/// Sends requests until the link is dropped, and polls the status in between.
pub fn run(fleet: &FleetName, requested: &Receiver<ControlRequest>, report: &Sender<Report>) -> Result {
    let mut control = Control::open(fleet)?;
    let mut queue = VecDeque::new();
    loop {
        if queue.is_empty() {
            match requested.recv_timeout(STATUS_EVERY) {
                Ok(request) => queue.push_back(request),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
        }
        queue.extend(requested.try_iter());
        keep_newest(&mut queue);
        let request = queue.pop_front();
        let sent = request.unwrap_or(ControlRequest::new(ControlKind::Status));
        let found = match control.request(sent, TIMEOUT) {
            Ok(status) => Fact::Status(Some(Box::new(status))).into(),
            Err(ControlError::NoEngine { .. }) if request.is_none() => Fact::Status(None).into(),
            Err(ControlError::Gone { .. }) => Fact::Status(None).into(),
            Err(error) if request.is_some() => Report::Notice(error.to_string()),
            Err(error) => {
                tracing::debug!(%error, "polling the status");
                Fact::Status(None).into()
            }
        };
        if report.send(found).is_err() {
            return Ok(());
        }
    }
}

/// Removes requests for a speed or a number of robots that a later one supersedes: a slider sends many.
fn keep_newest(requests: &mut VecDeque<ControlRequest>) {
    let superseded = [ControlKind::Speed, ControlKind::Robots].map(|kind| kind as u32);
    let all: Vec<_> = requests.drain(..).collect();
    for (i, request) in all.iter().enumerate() {
        let has_later = all[i + 1..].iter().any(|later| later.kind == request.kind);
        if !(has_later && superseded.contains(&request.kind)) {
            requests.push_back(*request);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_last_speed_is_sent() {
        let speed = |speed| ControlRequest { speed, ..ControlRequest::new(ControlKind::Speed) };
        let (pause, step) = (ControlRequest::new(ControlKind::Pause), ControlRequest::new(ControlKind::Step));
        let mut requests = VecDeque::from([speed(1.0), pause, speed(2.0), step, step, speed(3.0)]);
        keep_newest(&mut requests);
        assert_eq!(requests, [pause, step, step, speed(3.0)]);
    }
}
