//! The thread that sends the user's commands, and reports their answers.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use regatta_interface::commands::UserCommand;
use regatta_kit::{DispatchError, Dispatcher, WayError};
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::manager::{ManagerAnswer, ManagerResponse};
use regatta_plugin::{Commands, FleetName, ManagerClient, ManagerError, Result};

use super::Report;

/// The time between two looks for answers.
const POLL: Duration = Duration::from_millis(20);
/// The time after which the user is told that a command has no answer yet. The answer is shown
/// whenever it comes.
const PATIENCE: Duration = Duration::from_secs(2);
/// The longest wait for the world, before a robot is sent.
const WORLD: Duration = Duration::from_secs(2);

/// Sends commands until the link is dropped. The fleet is joined with the first one, and left when
/// all are answered.
pub fn run(
    fleet: &FleetName,
    requested: &Receiver<UserCommand>,
    report: &Sender<Report>,
) -> Result {
    while let Ok(first) = requested.recv() {
        let outcome = serve(fleet, first, requested, report);
        let outcome = outcome.map_err(|error| format!("can't give commands: {error}"));
        if outcome.is_err_and(|text| report.send(Report::Notice(text)).is_err()) {
            break;
        }
    }
    Ok(())
}

fn serve(
    fleet: &FleetName,
    first: UserCommand,
    requested: &Receiver<UserCommand>,
    report: &Sender<Report>,
) -> Result<(), DispatchError> {
    let dispatcher = Dispatcher::join(fleet, "viewer-commands", WORLD)?;
    let mut pending = PendingCommands {
        dispatcher,
        manager: ManagerClient::open(fleet)?,
        waiting: BTreeMap::new(),
    };
    let mut next = Some(first);
    loop {
        let commands = next.into_iter().chain(requested.try_iter());
        let mut told: Vec<Report> = commands.filter_map(|command| pending.give(command)).collect();
        told.extend(pending.answers()?.into_iter().map(Report::Notice));
        if told.into_iter().any(|told| report.send(told).is_err()) || pending.waiting.is_empty() {
            return Ok(());
        }
        next = match requested.recv_timeout(POLL) {
            Ok(command) => Some(command),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        };
    }
}

/// Commands that are being carried out.
struct PendingCommands {
    dispatcher: Dispatcher,
    manager: ManagerClient,
    /// By token: the command, when it was sent, and whether the user knows that it waits.
    waiting: BTreeMap<u64, (UserCommand, Instant, bool)>,
}

impl PendingCommands {
    /// Sends a command. Returns the fleet manager's answer, or the reason why the command can't be
    /// sent.
    fn give(&mut self, command: UserCommand) -> Option<Report> {
        match command {
            UserCommand::SendByManager { robot, node } => {
                Some(asked(command, self.manager.send(robot, node)))
            }
            UserCommand::Recall(robot) => Some(asked(command, self.manager.recall(robot))),
            _ => match self.send(command) {
                Ok(token) => {
                    self.waiting.insert(token, (command, Instant::now(), false));
                    None
                }
                Err(error) => Some(Report::Refused(command, format!("can't {command}: {error}"))),
            },
        }
    }

    fn send(&mut self, command: UserCommand) -> Result<u64, DispatchError> {
        let UserCommand::Send { robot, node } = command else {
            return Ok(self
                .dispatcher
                .give(|commands| collect(command, commands).unwrap_or_default())?);
        };
        let legs = self.dispatcher.way(
            robot,
            |world| {
                let found = world.nodes().iter().position(|other| other.id == node);
                found.ok_or_else(|| WayError::UnknownNode(node.to_string()))
            },
            false,
        )?;
        Ok(self.dispatcher.give(|commands| commands.assign(robot, &legs))?)
    }

    /// Returns notices of answers that have come, or are late.
    fn answers(&mut self) -> Result<Vec<String>, DispatchError> {
        let mut told = Vec::new();
        for answer in self.dispatcher.answers()? {
            if let Some((command, ..)) = self.waiting.remove(&answer.token) {
                told.push(self.text(command, answer));
            }
        }
        for (command, since, is_told) in
            self.waiting.values_mut().filter(|(_, since, _)| since.elapsed() > PATIENCE)
        {
            if !std::mem::replace(is_told, true) {
                let secs = since.elapsed().as_secs();
                told.push(format!(
                    "{command}: no answer for {secs} s; a paused fleet takes it at its next tick"
                ));
            }
        }
        Ok(told)
    }

    fn text(&self, command: UserCommand, answer: EventRecord) -> String {
        match answer.kind() {
            Some(EventKind::Accepted) => format!("accepted: {command}"),
            _ => format!("can't {command}: {}", self.dispatcher.refusal(answer)),
        }
    }
}

/// Collects the command, and returns its token; `None` for one that needs a way, or is for the
/// fleet manager.
fn collect(command: UserCommand, commands: &mut Commands) -> Option<u64> {
    Some(match command {
        UserCommand::Hold(robot) => commands.hold(robot),
        UserCommand::Resume(robot) => commands.resume(robot),
        UserCommand::Break(robot) => commands.break_down(robot),
        UserCommand::Repair(robot) => commands.repair(robot),
        UserCommand::Cancel(robot) => commands.cancel(robot),
        UserCommand::Close(edge) => commands.close_edge(edge),
        UserCommand::Open(edge) => commands.open_edge(edge),
        UserCommand::Send { .. } | UserCommand::SendByManager { .. } | UserCommand::Recall(_) => {
            return None;
        }
    })
}

/// Returns the report of the fleet manager's answer.
fn asked(command: UserCommand, answer: Result<ManagerResponse, ManagerError>) -> Report {
    match answer.map(|response| response.answer()) {
        Ok(Some(ManagerAnswer::Later)) => {
            Report::Notice(format!("accepted: {command}, when its order is finished"))
        }
        Ok(_) => Report::Notice(format!("accepted: {command}")),
        Err(error) => Report::Refused(command, format!("can't {command}: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use regatta_plugin::ProducerPorts;
    use regatta_plugin::command::{CommandKind, CommandRecord};
    use regatta_plugin::event::Refusal;

    use super::*;

    /// The command that no frame has told of a way for, and two that are answered by the test.
    #[test]
    fn answers_and_refusals_are_told() {
        let fleet: FleetName =
            format!("unit-viewer-commands-{}", std::process::id()).parse().expect("a name");
        let mut producer = ProducerPorts::create(&fleet, 1).expect("a producer");
        let ((request, requested), (report, reports)) = (mpsc::channel(), mpsc::channel());
        let thread = std::thread::spawn(move || {
            run(&fleet, &requested, &report).map_err(|error| error.to_string())
        });
        [UserCommand::Hold(4), UserCommand::Close(9)]
            .into_iter()
            .for_each(|command| request.send(command).expect("sent"));
        let mut taken: Vec<CommandRecord> = Vec::new();
        while taken.len() < 2 {
            producer.update();
            producer
                .take_commands(|_, _, records| taken.extend_from_slice(records))
                .expect("readable");
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(
            [taken[0].kind, taken[1].kind],
            [CommandKind::Hold, CommandKind::CloseEdge].map(|kind| kind as u32)
        );
        let answer = |command: &CommandRecord, kind: EventKind, detail| EventRecord {
            token: command.token,
            kind: kind as u32,
            id: command.id,
            detail,
            ..EventRecord::default()
        };
        let answers = [
            answer(&taken[0], EventKind::Accepted, 0),
            answer(&taken[1], EventKind::Refused, Refusal::UnknownEdge as u32),
        ];
        producer.publish_events(1, 0, &answers).expect("published");
        let told = [(); 2].map(|()| match reports.recv().expect("a report") {
            Report::Notice(text) => text,
            other => panic!("{other:?}"),
        });
        assert_eq!(
            told,
            ["accepted: hold robot 4", "can't close edge 9: refused: there is no edge 9"]
        );
        drop((request, reports));
        assert_eq!(thread.join().expect("no panic"), Ok(()));
    }
}
