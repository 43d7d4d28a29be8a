//! The client's side of the control service.

use std::time::Duration;

use super::ask::{Asker, NoAnswer};
use super::error::{OpenError, RequestError};
use super::services;
use crate::process::join::Participant;
use crate::records::control::{ControlKind, ControlRequest, ControlResponse};
use crate::records::name::FleetName;

/// The error of a control request.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ControlError {
    /// The fleet has no engine.
    #[error(
        "fleet '{fleet}' has no engine; start one with `regatta run`, or name another fleet with \
         --fleet"
    )]
    NoEngine {
        /// The fleet.
        fleet: FleetName,
    },
    /// The engine refused the request.
    #[error("the engine of fleet '{fleet}' refused: {reason}")]
    Refused {
        /// The fleet.
        fleet: FleetName,
        /// The engine's reason.
        reason: String,
    },
    /// The engine hasn't answered.
    #[error(transparent)]
    Request(#[from] RequestError),
}

/// The time that requests wait for an answer, except steps, which take time of their own.
pub const TIMEOUT: Duration = Duration::from_secs(5);

/// Controls a fleet's engine. Each request waits for its answer, and returns the status after it.
///
/// ```no_run
/// use regatta_plugin::{Control, FleetName, Result};
///
/// # fn main() -> Result {
/// let mut control = Control::open(&FleetName::default())?;
/// control.pause()?;
/// let status = control.step(100)?;
/// println!("{} robots at tick {}", status.robots, status.tick);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Control {
    asker: Asker<ControlRequest, ControlResponse>,
}

impl Control {
    /// Opens the control service of a fleet, whether or not it has an engine yet.
    ///
    /// # Errors
    /// [`OpenError::OtherVersion`] if the fleet uses another contract, [`OpenError::Full`] if it
    /// has [`MAX_CONTROL_CLIENTS`](services::MAX_CONTROL_CLIENTS) clients, else
    /// [`OpenError::SharedMemory`].
    pub fn open(fleet: &FleetName) -> Result<Self, OpenError> {
        Self::open_on(&Participant::join(fleet, "control")?)
    }

    /// Opens the control service for a process that has joined the fleet.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn open_on(participant: &Participant) -> Result<Self, OpenError> {
        Ok(Self { asker: Asker::open(&services::CONTROL, participant)? })
    }

    /// Whether the fleet has an engine. One that was killed counts until another process joins the
    /// fleet.
    pub fn has_engine(&self) -> bool {
        self.asker.has_server()
    }

    /// Requests the status.
    pub fn status(&mut self) -> Result<ControlResponse, ControlError> {
        self.request(ControlRequest::new(ControlKind::Status), TIMEOUT)
    }

    /// Stops the clock.
    pub fn pause(&mut self) -> Result<ControlResponse, ControlError> {
        self.request(ControlRequest::new(ControlKind::Pause), TIMEOUT)
    }

    /// Starts the clock again.
    pub fn resume(&mut self) -> Result<ControlResponse, ControlError> {
        self.request(ControlRequest::new(ControlKind::Resume), TIMEOUT)
    }

    /// Pauses the clock and advances by `ticks`, at the requested speed. Returns when they are
    /// done, however long that takes. Refused if a pause, a resume or a seek ends the steps before.
    pub fn step(&mut self, ticks: u64) -> Result<ControlResponse, ControlError> {
        self.request(
            ControlRequest { count: ticks, ..ControlRequest::new(ControlKind::Step) },
            Duration::MAX,
        )
    }

    /// Changes the requested speed, in simulated seconds per wall second; `f32::INFINITY` for as
    /// fast as possible.
    pub fn speed(&mut self, speed: f32) -> Result<ControlResponse, ControlError> {
        self.request(ControlRequest { speed, ..ControlRequest::new(ControlKind::Speed) }, TIMEOUT)
    }

    /// Changes the number of robots.
    pub fn robots(&mut self, count: u32) -> Result<ControlResponse, ControlError> {
        self.request(
            ControlRequest { count: count.into(), ..ControlRequest::new(ControlKind::Robots) },
            TIMEOUT,
        )
    }

    /// Goes to a simulated time. A replay can do that; an engine refuses.
    pub fn seek(&mut self, sim_time: Duration) -> Result<ControlResponse, ControlError> {
        let count = u64::try_from(sim_time.as_nanos()).unwrap_or(u64::MAX);
        self.request(ControlRequest { count, ..ControlRequest::new(ControlKind::Seek) }, TIMEOUT)
    }

    /// Sends a request and waits for its answer.
    pub fn request(
        &mut self,
        request: ControlRequest,
        timeout: Duration,
    ) -> Result<ControlResponse, ControlError> {
        match self.asker.ask(request, timeout) {
            Ok(response) if response.accepted == 0 => Err(ControlError::Refused {
                fleet: self.asker.fleet().clone(),
                reason: response.reason().to_owned(),
            }),
            Ok(response) => Ok(response),
            Err(NoAnswer::NoServer) => {
                Err(ControlError::NoEngine { fleet: self.asker.fleet().clone() })
            }
            Err(NoAnswer::Failed(error)) => Err(error.into()),
        }
    }
}
