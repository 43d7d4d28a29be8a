//! Passes control requests and commands of other hosts to the fleet, each in a thread of its own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::{
    CONTROL_TIMEOUT, CommandError, Commands, Control, ControlError, FleetName, Participant, Result,
};
use zenoh::Wait;
use zenoh::handlers::FifoChannelHandler;
use zenoh::pubsub::Subscriber;
use zenoh::query::Query;
use zenoh::sample::Sample;

use super::Requests;
use crate::grievances::Grievances;
use crate::wire::{control_request, decode_commands, encode_control_response};

/// The time between two checks whether to stop.
const POLL: Duration = Duration::from_millis(100);

/// The longest wait for the end of a step: requests behind it wait as long.
const STEP_TIMEOUT: Duration = Duration::from_secs(60);

/// Answers control requests until it is to stop.
pub fn serve(fleet: &FleetName, requests: &Requests, stop: &AtomicBool) {
    let served = Control::open(fleet).map(|mut control| {
        let mut grievances = Grievances::default();
        while !stop.load(Ordering::Relaxed) {
            if let Ok(Some(query)) = requests.recv_timeout(POLL) {
                answer(&mut control, &query, &mut grievances);
            }
        }
    });
    if let Err(error) = served {
        regatta_plugin::tell!("mirror: control requests can't be answered: {error}");
    }
}

/// Answers a request: by the fleet's answer, or by an error in zenoh's own protocol.
fn answer(control: &mut Control, query: &Query, grievances: &mut Grievances) {
    let payload = query.payload().map(|payload| payload.to_bytes()).unwrap_or_default();
    // A peer that has gone away needs no answer.
    match control_request(&payload) {
        Ok(request) => {
            let response = encode_control_response(&carry_out(control, request));
            let _ = query.reply(query.key_expr().clone(), response).wait();
        }
        Err(error) => {
            grievances.note("a control request", error);
            let _ = query.reply_err(error.to_string()).wait();
        }
    }
}

fn carry_out(control: &mut Control, request: ControlRequest) -> ControlResponse {
    let is_step = request.kind() == Some(ControlKind::Step);
    let timeout = if is_step { STEP_TIMEOUT } else { CONTROL_TIMEOUT };
    match control.request(request, timeout) {
        Ok(response) => response,
        Err(ControlError::Refused { reason, .. }) => ControlResponse::default().refuse(&reason),
        Err(error) => ControlResponse::default().refuse(&error.to_string()),
    }
}

/// Passes commands to the fleet until it is to stop.
pub fn take_commands(
    fleet: &FleetName,
    samples: &Subscriber<FifoChannelHandler<Sample>>,
    stop: &AtomicBool,
) {
    if let Err(error) = try_take(fleet, samples, stop) {
        regatta_plugin::tell!("mirror: commands are no longer accepted: {error}");
    }
}

fn try_take(
    fleet: &FleetName,
    samples: &Subscriber<FifoChannelHandler<Sample>>,
    stop: &AtomicBool,
) -> Result {
    let mut commands = Commands::open_on(&Participant::join(fleet, "mirror-commands")?)?;
    let mut grievances = Grievances::default();
    let mut has_told = false;
    while !stop.load(Ordering::Relaxed) {
        let Ok(Some(sample)) = samples.recv_timeout(POLL) else { continue };
        let parsed = decode_commands(&sample.payload().to_bytes());
        let Some(records) = grievances.accept("a command", parsed) else { continue };
        commands.pass_on(&records);
        while let Err(error) = commands.send() {
            if !std::mem::replace(&mut has_told, true) {
                regatta_plugin::tell!("mirror: {error}");
            }
            // A paused engine takes none: the peer waits, too. Without an engine they are lost.
            if !matches!(error, CommandError::Full { .. }) || stop.load(Ordering::Relaxed) {
                commands.clear();
            }
            std::thread::sleep(POLL);
        }
    }
    Ok(())
}
