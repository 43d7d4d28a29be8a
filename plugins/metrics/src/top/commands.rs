//! Commands that keys send to the engine, on a thread of their own because a stopped engine doesn't
//! answer.

use std::io;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::Duration;

use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::frame::ClockState;
use regatta_plugin::{Control, ControlError, FleetName, Participant};

/// The longest wait for the engine's answer.
const TIMEOUT: Duration = Duration::from_secs(1);

/// The largest number of queued commands. Further ones are dropped, for example while a key is held
/// down.
const MAX_QUEUED: usize = 4;

/// The speeds that the keys step through, in simulated seconds per wall second.
const SPEEDS: [f32; 16] =
    [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];

/// A command to the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Pause if the clock runs, else resume.
    PauseOrResume,
    /// Pause, and advance by one tick.
    Step,
    /// Set the next higher speed.
    Faster,
    /// Set the next lower speed.
    Slower,
    /// Run as fast as possible.
    FullSpeed,
    /// Run at one simulated second per wall second.
    RealTime,
}

/// The outcome of a command, for the last line of the screen.
pub type Outcome = Result<String, String>;

/// The queue of commands, which a thread carries out.
#[derive(Debug)]
pub struct CommandQueue {
    commands: SyncSender<Command>,
    outcomes: Receiver<Outcome>,
}

impl CommandQueue {
    /// Starts the thread. It ends when the queue is dropped.
    ///
    /// # Errors
    /// Fails if no thread can be started.
    pub fn start(fleet: &FleetName, participant: &'static str) -> io::Result<Self> {
        let (commands, queued) = sync_channel(MAX_QUEUED);
        let (replies, outcomes) = channel();
        let fleet = fleet.clone();
        thread::Builder::new()
            .name("commands".to_owned())
            .spawn(move || carry_out_all(&fleet, participant, &queued, &replies))?;
        Ok(Self { commands, outcomes })
    }

    /// Queues a command. Returns at once.
    pub fn send(&self, command: Command) {
        // If the queue is full, the commands in it have not been answered either, and their outcome
        // will say why.
        let _ = self.commands.try_send(command);
    }

    /// Returns the newest outcome since the last call.
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcomes.try_iter().last()
    }
}

fn carry_out_all(
    fleet: &FleetName,
    participant: &str,
    commands: &Receiver<Command>,
    outcomes: &Sender<Outcome>,
) {
    // Opened with the first command: most users only watch.
    let mut control = None;
    for command in commands {
        let outcome = open(&mut control, fleet, participant).and_then(|control| {
            match carry_out(command, control) {
                Ok(status) => Ok(describe(command, &status)),
                Err(error) => Err(error.to_string()),
            }
        });
        if outcomes.send(outcome).is_err() {
            return;
        }
    }
}

fn open<'a>(
    control: &'a mut Option<Control>,
    fleet: &FleetName,
    participant: &str,
) -> Result<&'a mut Control, String> {
    match control {
        Some(control) => Ok(control),
        None => {
            // Joins under the name that the process already uses.
            let opened = Participant::join(fleet, participant)
                .and_then(|participant| Control::open_on(&participant));
            Ok(control.insert(opened.map_err(|error| error.to_string())?))
        }
    }
}

fn carry_out(command: Command, control: &mut Control) -> Result<ControlResponse, ControlError> {
    let request = match command {
        Command::PauseOrResume if is_running(&status(control)?) => {
            ControlRequest::new(ControlKind::Pause)
        }
        Command::PauseOrResume => ControlRequest::new(ControlKind::Resume),
        Command::Step => ControlRequest { count: 1, ..ControlRequest::new(ControlKind::Step) },
        Command::Faster => speed(faster(status(control)?.speed)),
        Command::Slower => speed(slower(status(control)?.speed)),
        Command::FullSpeed => speed(f32::INFINITY),
        Command::RealTime => speed(1.0),
    };
    control.request(request, TIMEOUT)
}

fn status(control: &mut Control) -> Result<ControlResponse, ControlError> {
    control.request(ControlRequest::new(ControlKind::Status), TIMEOUT)
}

fn speed(speed: f32) -> ControlRequest {
    ControlRequest { speed, ..ControlRequest::new(ControlKind::Speed) }
}

fn is_running(status: &ControlResponse) -> bool {
    [ClockState::Running, ClockState::WarmingUp].iter().any(|state| status.clock == *state as u32)
}

/// Returns the next higher speed; full speed above the highest.
fn faster(speed: f32) -> f32 {
    // The tolerance keeps 0.1 in single precision from counting as less than 0.1.
    SPEEDS.into_iter().find(|&step| step > speed * 1.001).unwrap_or(f32::INFINITY)
}

/// Returns the next lower speed; the lowest stays.
fn slower(speed: f32) -> f32 {
    SPEEDS.into_iter().rev().find(|&step| step < speed * 0.999).unwrap_or(SPEEDS[0])
}

fn describe(command: Command, status: &ControlResponse) -> String {
    match command {
        Command::PauseOrResume if is_running(status) => "the clock runs".to_owned(),
        Command::PauseOrResume => format!("paused at tick {}", status.tick),
        Command::Step => format!("stepped to tick {}", status.tick),
        _ => format!("speed {}", super::format::speed(status.speed)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_go_up_and_down_step_by_step() {
        let up: Vec<_> =
            std::iter::successors(Some(0.001_f32), |&s| (s < f32::INFINITY).then(|| faster(s)))
                .collect();
        assert_eq!(up[1..up.len() - 1], SPEEDS);
        let down: Vec<_> =
            std::iter::successors(Some(f32::INFINITY), |&s| (s > SPEEDS[0]).then(|| slower(s)))
                .collect();
        assert_eq!(down[1..], SPEEDS.into_iter().rev().collect::<Vec<_>>());
        assert_eq!((faster(3.0), slower(3.0), slower(0.001)), (5.0, 2.0, 0.01));
    }

    #[test]
    fn each_command_reports_a_missing_engine() {
        let fleet: FleetName =
            format!("unit-metrics-commands-{}", std::process::id()).parse().expect("a name");
        let commands = CommandQueue::start(&fleet, "test").expect("a thread");
        for command in [Command::PauseOrResume, Command::Faster] {
            commands.send(command);
            let outcome = std::iter::repeat_with(|| {
                thread::sleep(Duration::from_millis(5));
                commands.outcome()
            });
            let outcome = outcome.take(10_000).flatten().next().expect("an outcome");
            assert!(outcome.expect_err("no engine").contains("no engine"));
        }
    }
}
