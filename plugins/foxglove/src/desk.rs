//! The desk: carries out the wishes of clients, on a thread of its own, where it may wait for the
//! engine. Steps, which may take long, have a thread each time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use regatta_plugin::control::ControlResponse;
use regatta_plugin::frame::ClockState;
use regatta_plugin::{Control, ControlError, FleetName};
use serde_json::{Value, json};

use crate::outbox::Outbox;
use crate::parameters::Parameters;
use crate::protocol::response::{self, Level};
use crate::service::{Wish, speed_value};

/// The most wishes that wait.
const MOST_WAITING: usize = 64;

/// The error of a wish that isn't taken.
#[derive(Debug, thiserror::Error)]
#[error("too many requests are waiting; try again later")]
pub(crate) struct Busy;

/// The form of the answer.
#[derive(Clone, Debug)]
pub(crate) enum Reply {
    /// To the call of a service.
    Service { service: u32, call: u32 },
    /// To a change of parameters, with their values if it has an id.
    Parameters { names: Vec<String>, id: Option<String> },
}

/// The wish of a client, and the place where the answer goes.
struct Job {
    wishes: Vec<Wish>,
    reply: Reply,
    outbox: Arc<Outbox>,
}

/// The way to the desk's thread, which ends when all are dropped.
#[derive(Clone, Debug)]
pub(crate) struct Desk {
    jobs: SyncSender<Job>,
}

impl Desk {
    /// Starts the thread. It joins the fleet at the first wish.
    pub fn start(fleet: FleetName) -> std::io::Result<Self> {
        let (jobs, taken) = sync_channel(MOST_WAITING);
        let thread = std::thread::Builder::new().name("desk".to_owned());
        thread.spawn(move || {
            Attendant { fleet, control: None, is_stepping: Arc::default() }.serve(&taken);
        })?;
        Ok(Self { jobs })
    }

    /// Asks for something. The answer goes to the outbox.
    pub fn ask(&self, wishes: Vec<Wish>, reply: Reply, outbox: &Arc<Outbox>) -> Result<(), Busy> {
        let job = Job { wishes, reply, outbox: Arc::clone(outbox) };
        self.jobs.try_send(job).map_err(|_| Busy)
    }
}

/// The state of the desk's thread.
struct Attendant {
    fleet: FleetName,
    control: Option<Control>,
    is_stepping: Arc<AtomicBool>,
}

/// The outcome of a job: the state of the clock after it, or the reason of a refusal.
type Outcome = Result<ControlResponse, String>;

impl Attendant {
    fn serve(mut self, jobs: &Receiver<Job>) {
        for Job { wishes, reply, outbox } in jobs {
            match wishes[..] {
                [Wish::Step(ticks)] => self.step(ticks, reply, outbox),
                _ => answer(&reply, self.carry_out(&wishes), &outbox),
            }
        }
    }

    /// Carries out wishes, up to the first that is refused.
    fn carry_out(&mut self, wishes: &[Wish]) -> Outcome {
        let control = self.control().map_err(|error| error.to_string())?;
        let mut response = None;
        for wish in wishes {
            response = Some(carry_out(control, *wish).map_err(|error| error.to_string())?);
        }
        response.map_or_else(|| control.status().map_err(|error| error.to_string()), Ok)
    }

    fn control(&mut self) -> Result<&mut Control, regatta_plugin::OpenError> {
        match &mut self.control {
            Some(control) => Ok(control),
            none => Ok(none.insert(Control::open(&self.fleet)?)),
        }
    }

    /// Steps on another thread, and answers from there.
    fn step(&self, ticks: u64, reply: Reply, outbox: Arc<Outbox>) {
        if self.is_stepping.swap(true, Ordering::Relaxed) {
            let reason = "another request is stepping the fleet; try again later".to_owned();
            return answer(&reply, Err(reason), &outbox);
        }
        let (fleet, is_stepping) = (self.fleet.clone(), Arc::clone(&self.is_stepping));
        let thread = std::thread::Builder::new().name("step".to_owned()).spawn(move || {
            let opened = Control::open(&fleet).map_err(|error| error.to_string());
            let outcome = opened.and_then(|mut control| {
                carry_out(&mut control, Wish::Step(ticks)).map_err(|error| error.to_string())
            });
            is_stepping.store(false, Ordering::Relaxed);
            answer(&reply, outcome, &outbox);
        });
        if thread.is_err() {
            self.is_stepping.store(false, Ordering::Relaxed);
        }
    }
}

fn carry_out(control: &mut Control, wish: Wish) -> Result<ControlResponse, ControlError> {
    match wish {
        Wish::Pause => control.pause(),
        Wish::Resume => control.resume(),
        Wish::Step(ticks) => control.step(ticks),
        Wish::Speed(speed) => control.speed(speed),
        Wish::Robots(count) => control.robots(count),
    }
}

fn answer(reply: &Reply, outcome: Outcome, outbox: &Outbox) {
    match reply {
        Reply::Service { service, call } => {
            outbox.answer(response::call_answered(*service, *call, &service_answer(&outcome)));
        }
        Reply::Parameters { names, id } => match (outcome, id) {
            (Ok(status), Some(id)) => {
                let values = parameters(&status).named(names);
                outbox.answer(response::parameter_values(values, Some(id)));
            }
            (Ok(_), None) => {}
            (Err(reason), _) => outbox.status(Level::Error, &reason),
        },
    }
}

fn service_answer(outcome: &Outcome) -> Value {
    match outcome {
        Ok(status) => json!({
            "success": true,
            "message": "",
            "tick": status.tick,
            "paused": parameters(status).is_paused,
            "speed": speed_value(status.speed),
        }),
        Err(reason) => json!({"success": false, "message": reason}),
    }
}

fn parameters(status: &ControlResponse) -> Parameters {
    Parameters {
        is_paused: status.clock != ClockState::Running as u32,
        speed: status.speed,
        robots: status.robots,
    }
}
