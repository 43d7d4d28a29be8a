//! `regatta mirror receive`: a producer whose fleet is on another host.

mod mailbox;
mod peer;
mod stage;

use std::sync::Arc;
use std::time::{Duration, Instant};

use regatta_plugin::command::{Authority, CommandKind, CommandRecord};
use regatta_plugin::control::ControlResponse;
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::{Participant, ProducerPorts, Result, Termination};

use crate::link::{Link, LinkError};
use crate::options::ReceiveArgs;
use crate::wire::encode_commands;
use mailbox::{Mail, Mailbox};
use peer::Peer;
use stage::Stage;

/// The longest wait between two looks at commands and requests of this host.
const POLL: Duration = Duration::from_millis(5);
/// The time without a frame after which the user is told.
const SILENCE: Duration = Duration::from_secs(3);

/// Writes a fleet of another host until Ctrl-C.
pub fn run(args: &ReceiveArgs) -> Result {
    let termination = Termination::watch()?;
    if args.link.connect.is_empty() && args.link.listen.is_empty() && args.link.config.is_none() {
        return Err(LinkError::Nowhere.into());
    }
    let link = Link::open(&args.link, None)?;
    let fleet = args.fleet.as_ref().unwrap_or(&args.from);
    let ports = ProducerPorts::create_on(Participant::join(fleet, "mirror-receive")?, 0)?;
    let mailbox = Arc::new(Mailbox::default());
    let peer = Peer::open(&link.session, &args.from, args.encoding, &mailbox)?;
    regatta_plugin::tell!(
        "mirror: fleet '{}' of {:?} is fleet '{fleet}' here; listening on {}",
        args.from,
        args.link.connect,
        link.listens
    );
    let stage = Stage::new(ports, args.encoding);
    let mut receiver = Receiver { stage, peer, last: Instant::now(), is_silent: false };
    while !termination.requested() {
        receiver.advance(mailbox.take(POLL))?;
    }
    regatta_plugin::tell!("mirror: {}", receiver.stage.figures.summary());
    if args.json {
        println!("{}", receiver.stage.figures.json(receiver.stage.grievances.count));
    }
    Ok(())
}

struct Receiver {
    stage: Stage,
    peer: Peer,
    /// The time of the last frame.
    last: Instant,
    is_silent: bool,
}

impl Receiver {
    /// Publishes what has arrived, in the order of the contract, and passes on what this host asks.
    fn advance(&mut self, mail: Mail) -> Result {
        self.watch(mail.frame.is_some());
        if let Some(world) = &mail.world {
            self.stage.world(world, &self.peer)?;
        }
        let mut lost = mail.events_lost;
        for events in &mail.events {
            self.stage.events(events, std::mem::take(&mut lost))?;
        }
        for (name, values) in mail.columns {
            self.stage.column(name, &values)?;
        }
        if let Some(frame) = &mail.frame {
            self.stage.frame(frame, &self.peer)?;
        }
        for (ticket, response) in mail.answers {
            let response = self.localize(response);
            self.stage.ports.answer(ticket, response);
        }
        self.pass_on_commands()?;
        while let Some((ticket, request)) = self.stage.ports.take_request()? {
            self.peer.ask_control(ticket, &request);
        }
        self.stage.ports.update();
        Ok(())
    }

    /// Tells when frames stop and when they come again.
    fn watch(&mut self, has_frame: bool) {
        if has_frame {
            self.last = Instant::now();
            if std::mem::take(&mut self.is_silent) {
                regatta_plugin::tell!("mirror: frames arrive again");
            }
        } else if !self.is_silent && self.last.elapsed() > SILENCE {
            self.is_silent = true;
            regatta_plugin::tell!("mirror: no frames arrive; waiting for the other host");
        }
    }

    /// Returns an answer about the fleet on this host: its run, and the process that writes it.
    fn localize(&self, response: ControlResponse) -> ControlResponse {
        ControlResponse { run_id: self.stage.ports.run_id(), pid: std::process::id(), ..response }
    }

    fn pass_on_commands(&mut self) -> Result {
        let mut samples = Vec::new();
        self.stage.ports.take_commands(|_, authority, records| {
            samples.push((authority, records.to_vec()));
        })?;
        let mut refused = Vec::new();
        for (authority, records) in samples {
            let allowed = allow(authority, records, &mut refused);
            if !allowed.is_empty() && self.peer.send_commands(encode_commands(&allowed)).is_err() {
                refused.extend(refusals(&allowed, Refusal::NotSteerable));
            }
        }
        Ok(self.stage.answers(&refused)?)
    }
}

/// Returns the commands that their sender may give; the others are refused.
fn allow(
    authority: Authority,
    mut records: Vec<CommandRecord>,
    refused: &mut Vec<EventRecord>,
) -> Vec<CommandRecord> {
    if authority == Authority::Full {
        return records;
    }
    let mut is_refused = false;
    let others = records.extract_if(.., |record| {
        if record.kind != CommandKind::Leg as u32 {
            is_refused = CommandKind::from_number(record.kind).is_some_and(CommandKind::moves);
        }
        is_refused
    });
    let others: Vec<_> = others.collect();
    refused.extend(refusals(&others, Refusal::NotOwner));
    records
}

/// Returns an event for each command, without legs.
fn refusals(records: &[CommandRecord], reason: Refusal) -> impl Iterator<Item = EventRecord> {
    let commands = records.iter().filter(|record| record.kind != CommandKind::Leg as u32);
    commands.map(move |command| EventRecord {
        token: command.token,
        kind: EventKind::Refused as u32,
        robot: command.robot,
        id: command.id,
        detail: reason as u32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn movement_belongs_to_its_owner() {
        let record = |kind: CommandKind, token| CommandRecord {
            kind: kind as u32,
            token,
            ..CommandRecord::default()
        };
        let records = vec![
            record(CommandKind::Assign, 1),
            record(CommandKind::Leg, 1),
            record(CommandKind::Hold, 2),
        ];
        let mut refused = Vec::new();
        assert_eq!(allow(Authority::Full, records.clone(), &mut refused), records);
        assert_eq!(refused, []);
        let allowed = allow(Authority::WithoutMovement, records.clone(), &mut refused);
        assert_eq!(allowed, records[2..]);
        let answers: Vec<_> = refused.iter().map(|event| (event.token, event.detail)).collect();
        assert_eq!(answers, [(1, Refusal::NotOwner as u32)]);
    }
}
