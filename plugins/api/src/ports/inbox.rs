//! The producer's side of commands and of the control service.

use super::ask::{Request, Responder};
use super::error::{OpenError, ReadError};
use super::ownership::OwnerWatch;
use super::services;
use crate::process::join::Participant;
use crate::records::command::{Authority, CommandHeader, CommandRecord};
use crate::records::control::{ControlRequest, ControlResponse};
use crate::transport::Subscriber;

/// Takes the commands of all senders.
pub(super) struct CommandInbox {
    samples: Subscriber<CommandRecord, CommandHeader>,
    owner: OwnerWatch,
}

impl CommandInbox {
    pub(super) fn open(participant: &Participant) -> Result<Self, OpenError> {
        let (service, buffer) = (&services::COMMANDS, services::COMMAND_BUFFER);
        Ok(Self {
            samples: Subscriber::open(service, service.name, participant, buffer)?,
            owner: OwnerWatch::open(participant)?,
        })
    }

    /// The process that owns the movement of the robots, for users.
    pub(super) fn owner(&mut self) -> Option<&str> {
        self.owner.name()
    }

    /// Passes all commands that have arrived to `each`, sample by sample, with those that their
    /// sender may give.
    pub(super) fn take(
        &mut self,
        mut each: impl FnMut(&CommandHeader, Authority, &[CommandRecord]),
    ) -> Result<(), ReadError> {
        // Bounded, so that a sender that never stops can't keep a tick from ending.
        for _ in 0..services::COMMAND_BUFFER * services::MAX_COMMAND_SENDERS {
            let Some(sample) = self.samples.receive()? else { break };
            let authority = self.owner.authority(&self.samples, &sample);
            each(sample.header(), authority, sample.records());
        }
        Ok(())
    }
}

/// Takes control requests, and keeps them until they are answered.
pub(super) struct RequestInbox {
    server: Responder<ControlRequest, ControlResponse>,
    /// Unanswered requests by their tickets.
    waiting: Vec<(u64, Request<ControlRequest, ControlResponse>)>,
    last_ticket: u64,
}

impl RequestInbox {
    pub(super) fn open(participant: &Participant) -> Result<Self, OpenError> {
        let server = Responder::open(&services::CONTROL, participant)?;
        Ok(Self { server, waiting: Vec::new(), last_ticket: 0 })
    }

    /// Takes the oldest request that has arrived, with the ticket by which to answer it.
    pub(super) fn take(&mut self) -> Result<Option<(u64, ControlRequest)>, ReadError> {
        // A client that has gone away needs no answer.
        self.waiting.retain(|(_, request)| request.is_connected());
        let Some(request) = self.server.take()? else { return Ok(None) };
        self.last_ticket += 1;
        let payload = *request.payload();
        self.waiting.push((self.last_ticket, request));
        Ok(Some((self.last_ticket, payload)))
    }

    /// Answers a request, if it still waits.
    pub(super) fn answer(&mut self, ticket: u64, response: ControlResponse) {
        for (_, request) in self.waiting.extract_if(.., |(waiting, _)| *waiting == ticket) {
            request.answer(response);
        }
    }
}
