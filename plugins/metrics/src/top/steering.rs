//! Keys that steer the fleet: carried out on a thread of their own, because an engine that is stopped doesn't answer.

use std::io;
use std::sync::mpsc::{Receiver, Sender, SyncSender, TryRecvError, channel, sync_channel};
use std::thread;
use std::time::Duration;

use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::frame::ClockState;
use regatta_plugin::{Control, ControlError, FleetName, Participant};

/// How long to wait for the engine's answer.
const PATIENCE: Duration = Duration::from_secs(1);

/// Commands that wait for their turn. More are dropped: a key is held down.
const WAITING: usize = 4;

/// Speeds that the keys go through, in simulated seconds per wall second.
const SPEEDS: [f32; 16] =
    [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];

/// What a key asks of the engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Pause if the clock runs, else resume.
    PauseOrResume,
    /// Pause, and advance by one tick.
    Step,
    /// The next higher speed.
    Faster,
    /// The next lower speed.
    Slower,
    /// As fast as the machine can.
    FullSpeed,
    /// A simulated second per wall second.
    RealTime,
}

/// What came of a command, for the last line of the screen.
pub type Outcome = Result<String, String>;

/// The thread that carries out commands.
#[derive(Debug)]
pub struct Steering {
    commands: SyncSender<Command>,
    outcomes: Receiver<Outcome>,
}

impl Steering {
    /// Starts the thread. It ends when this is dropped.
    ///
    /// # Errors
    /// If there can be no thread.
    pub fn start(fleet: &FleetName) -> io::Result<Self> {
        let (commands, orders) = sync_channel(WAITING);
        let (replies, outcomes) = channel();
        let fleet = fleet.clone();
        thread::Builder::new().name("steering".to_owned()).spawn(move || carry_out_all(&fleet, &orders, &replies))?;
        Ok(Self { commands, outcomes })
    }

    /// Asks for a command. Returns at once.
    pub fn ask(&self, command: Command) {
        // Full: those before it have not been answered either, and their outcome will tell why.
        let _ = self.commands.try_send(command);
    }

    /// The newest outcome since the last call.
    pub fn outcome(&self) -> Option<Outcome> {
        let mut newest = None;
        loop {
            match self.outcomes.try_recv() {
                Ok(outcome) => newest = Some(outcome),
                Err(TryRecvError::Empty | TryRecvError::Disconnected) => return newest,
            }
        }
    }
}

fn carry_out_all(fleet: &FleetName, commands: &Receiver<Command>, outcomes: &Sender<Outcome>) {
    // Opened with the first command: most who look don't steer.
    let mut control = None;
    for command in commands {
        let outcome = open(&mut control, fleet).and_then(|control| match carry_out(command, control) {
            Ok(status) => Ok(describe(command, &status)),
            Err(error) => Err(error.to_string()),
        });
        if outcomes.send(outcome).is_err() {
            return;
        }
    }
}

fn open<'a>(control: &'a mut Option<Control>, fleet: &FleetName) -> Result<&'a mut Control, String> {
    match control {
        Some(control) => Ok(control),
        None => {
            // By the name that the process goes by already.
            let opened = Participant::join(fleet, super::NAME).and_then(|place| Control::open_on(&place));
            Ok(control.insert(opened.map_err(|error| error.to_string())?))
        }
    }
}

fn carry_out(command: Command, control: &mut Control) -> Result<ControlResponse, ControlError> {
    let status = |control: &mut Control| control.request(ControlRequest::new(ControlKind::Status), PATIENCE);
    let request = match command {
        Command::PauseOrResume if is_running(&status(control)?) => ControlRequest::new(ControlKind::Pause),
        Command::PauseOrResume => ControlRequest::new(ControlKind::Resume),
        Command::Step => ControlRequest { count: 1, ..ControlRequest::new(ControlKind::Step) },
        Command::Faster => speed(faster(status(control)?.speed)),
        Command::Slower => speed(slower(status(control)?.speed)),
        Command::FullSpeed => speed(f32::INFINITY),
        Command::RealTime => speed(1.0),
    };
    control.request(request, PATIENCE)
}

fn speed(speed: f32) -> ControlRequest {
    ControlRequest { speed, ..ControlRequest::new(ControlKind::Speed) }
}

fn is_running(status: &ControlResponse) -> bool {
    status.clock == ClockState::Running as u32
}

/// The next speed above; full speed above the highest.
fn faster(speed: f32) -> f32 {
    // A bit above, so that 0.1 as the engine holds it doesn't count as less than 0.1.
    SPEEDS.into_iter().find(|&rung| rung > speed * 1.001).unwrap_or(f32::INFINITY)
}

/// The next speed below; the lowest stays.
fn slower(speed: f32) -> f32 {
    SPEEDS.into_iter().rev().find(|&rung| rung < speed * 0.999).unwrap_or(SPEEDS[0])
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
    fn speeds_go_up_and_down_rung_by_rung() {
        let up: Vec<_> = std::iter::successors(Some(0.001_f32), |&s| (s < f32::INFINITY).then(|| faster(s))).collect();
        assert_eq!(up[1..up.len() - 1], SPEEDS);
        let down: Vec<_> =
            std::iter::successors(Some(f32::INFINITY), |&s| (s > SPEEDS[0]).then(|| slower(s))).collect();
        assert_eq!(down[1..], SPEEDS.into_iter().rev().collect::<Vec<_>>());
        assert_eq!((faster(3.0), slower(3.0), slower(0.001)), (5.0, 2.0, 0.01));
    }

    #[test]
    fn without_an_engine_each_command_says_so() {
        let fleet: FleetName = format!("unit-metrics-steering-{}", std::process::id()).parse().expect("a name");
        let steering = Steering::start(&fleet).expect("a thread");
        for command in [Command::PauseOrResume, Command::Faster] {
            steering.ask(command);
            let outcome = std::iter::repeat_with(|| {
                thread::sleep(Duration::from_millis(5));
                steering.outcome()
            });
            let outcome = outcome.take(10_000).flatten().next().expect("an outcome");
            assert!(outcome.expect_err("no engine").contains("no engine"));
        }
    }
}
