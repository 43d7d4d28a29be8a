//! Steps of a paused fleet.

use std::sync::mpsc::{Receiver, Sender, channel};

use regatta_plugin::frame::ClockState;
use regatta_plugin::{Control, ControlError, FleetName};
use ros2_client::RmwRequestId;

use crate::message::simulation::{Result, code};

/// Steps on a thread of their own, as they may take long.
pub(super) struct Steps {
    sender: Sender<(RmwRequestId, Result)>,
    receiver: Receiver<(RmwRequestId, Result)>,
    is_stepping: bool,
}

impl Default for Steps {
    fn default() -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver, is_stepping: false }
    }
}

impl Steps {
    pub fn start(
        &mut self,
        request: RmwRequestId,
        steps: u64,
        control: &mut Control,
        fleet: &FleetName,
    ) -> std::result::Result<(), Result> {
        let failed = |reason: &str| Err(Result::failed(code::OPERATION_FAILED, reason));
        if self.is_stepping {
            return failed("another request is stepping the fleet; try again later");
        }
        match control.status() {
            Ok(status) if status.clock == ClockState::Paused as u32 => {}
            Ok(_) => return failed("the simulation isn't paused"),
            Err(error) => return failed(&error.to_string()),
        }
        let (sender, fleet) = (self.sender.clone(), fleet.clone());
        let thread = std::thread::Builder::new().name("steps".to_owned()).spawn(move || {
            // Without a receiver the plugin has ended.
            let _ = sender.send((request, step(&fleet, steps)));
        });
        if let Err(error) = thread {
            return failed(&error.to_string());
        }
        self.is_stepping = true;
        Ok(())
    }

    pub fn done(&mut self) -> Vec<(RmwRequestId, Result)> {
        let done: Vec<_> = self.receiver.try_iter().collect();
        self.is_stepping &= done.is_empty();
        done
    }
}

fn step(fleet: &FleetName, steps: u64) -> Result {
    let opened = Control::open(fleet);
    let stepped = opened.map_err(|error| error.to_string()).and_then(|mut control| {
        control.step(steps).map_err(|error: ControlError| error.to_string())
    });
    match stepped {
        Ok(_) => Result::ok(),
        Err(reason) => Result::failed(code::OPERATION_FAILED, reason),
    }
}
