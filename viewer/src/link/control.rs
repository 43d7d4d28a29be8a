//! The threads that send requests and steps to the engine. A step is answered when it is done,
//! which may take arbitrarily long. Other requests, a pause among them, must not wait for it.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

use regatta_plugin::control::{ControlKind, ControlRequest};
use regatta_plugin::{Control, FleetName, Result};

use super::Report;

/// The time between two polls of the engine's status.
const STATUS_EVERY: Duration = Duration::from_millis(250);
/// The timeout of a request. Steps have none.
const TIMEOUT: Duration = Duration::from_secs(2);

/// Sends requests until the link is dropped, and polls the status in between.
pub fn run(
    fleet: &FleetName,
    requested: &Receiver<ControlRequest>,
    report: &Sender<Report>,
) -> Result {
    let mut control = Control::open(fleet)?;
    let (steps, _) = super::spawn("steps", fleet, report, run_steps)?;
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
        let step = request.as_ref().and_then(Step::of);
        if let Some(step) = step {
            // Fails only after the thread has reported its error.
            let _ = steps.send(step);
        }
        if matches!(step, Some(Step::Forward(_))) {
            continue;
        }
        let answer =
            control.request(request.unwrap_or(ControlRequest::new(ControlKind::Status)), TIMEOUT);
        if report.send(Report::of_answer(answer, request.is_some())).is_err() {
            return Ok(());
        }
    }
}

/// Removes requests for a speed, a number of robots or a time that a later one supersedes: a slider
/// sends many.
fn keep_newest(requests: &mut VecDeque<ControlRequest>) {
    let superseded =
        [ControlKind::Speed, ControlKind::Robots, ControlKind::Seek].map(|kind| kind as u32);
    let all: Vec<_> = requests.drain(..).collect();
    for (i, request) in all.iter().enumerate() {
        let has_later = all[i + 1..].iter().any(|later| later.kind == request.kind);
        if !(has_later && superseded.contains(&request.kind)) {
            requests.push_back(*request);
        }
    }
}

/// A message to the thread of steps.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// Advance by a number of ticks.
    Forward(u64),
    /// Forget the steps that were not sent yet: another request has ended the stepping.
    End,
}

impl Step {
    /// Returns the effect of a request on steps, if it has one.
    fn of(request: &ControlRequest) -> Option<Self> {
        match request.kind()? {
            ControlKind::Step => Some(Self::Forward(request.count)),
            ControlKind::Pause | ControlKind::Resume | ControlKind::Seek => Some(Self::End),
            ControlKind::Status | ControlKind::Speed | ControlKind::Robots => None,
        }
    }
}

/// Sends steps until the sender is dropped and the engine has answered, which may take arbitrarily
/// long.
fn run_steps(fleet: &FleetName, requested: &Receiver<Step>, report: &Sender<Report>) -> Result {
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
    use std::sync::mpsc;

    use regatta_plugin::ProducerPorts;
    use regatta_plugin::control::ControlResponse;

    use super::*;
    use crate::link::Fact;

    #[test]
    fn a_step_that_takes_long_is_awaited_while_the_status_is_polled() {
        let fleet: FleetName =
            format!("unit-viewer-step-{}", std::process::id()).parse().expect("a name");
        let mut producer = ProducerPorts::create(&fleet, 1).expect("a producer");
        let (request, requested) = mpsc::channel();
        let (report, reports) = mpsc::channel();
        let viewer = std::thread::spawn(move || {
            run(&fleet, &requested, &report).map_err(|error| error.to_string())
        });
        request
            .send(ControlRequest { count: 7, ..ControlRequest::new(ControlKind::Step) })
            .expect("sent");
        let (mut step, mut polls) = (None, 0);
        // The step is done only after three seconds or so of polls.
        while polls < 12 {
            let Some((ticket, asked)) = producer.take_request().expect("readable") else {
                std::thread::sleep(Duration::from_millis(1));
                continue;
            };
            if asked.kind() == Some(ControlKind::Step) {
                assert_eq!((step.replace(ticket), asked.count), (None, 7));
            } else {
                polls += u32::from(step.is_some());
                producer.answer(ticket, ControlResponse::default().accept());
            }
        }
        let done = ControlResponse { tick: 7, ..ControlResponse::default() }.accept();
        producer.answer(step.expect("a step"), done);
        loop {
            match reports.recv().expect("a report") {
                Report::Facts(Fact::Status(Some(status))) if status.tick == 7 => break,
                Report::Facts(Fact::Status(Some(_))) => {}
                other => panic!("{other:?}"),
            }
        }
        drop((request, reports));
        assert_eq!(viewer.join().expect("no panic"), Ok(()));
    }

    #[test]
    fn only_the_last_speed_is_sent() {
        let speed = |speed| ControlRequest { speed, ..ControlRequest::new(ControlKind::Speed) };
        let (pause, step) =
            (ControlRequest::new(ControlKind::Pause), ControlRequest::new(ControlKind::Step));
        let mut requests = VecDeque::from([speed(1.0), pause, speed(2.0), step, step, speed(3.0)]);
        keep_newest(&mut requests);
        assert_eq!(requests, [pause, step, step, speed(3.0)]);
    }

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
