//! The services of `simulation_interfaces`, as simulators of single robots have them, and `pause`.

mod entities;
mod steps;

use std::time::{Duration, Instant};

use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::frame::ClockState;
use regatta_plugin::order::NO_ROBOT;
use regatta_plugin::{Control, ControlError, FleetName, tell};
use ros2_client::{Message, RmwRequestId, Server};

use crate::desk::Fleet;
use crate::link::{Link, LinkError, asked};
use crate::message::simulation::*;
use crate::options::robot_name;
use crate::steering::Refusal;
use entities::{entities, entity_state, features, find, robot_to_spawn};
use steps::Steps;

const PACKAGE: &str = "simulation_interfaces";
/// The time that a robot's spawn or removal may take before it is answered: a paused fleet carries
/// commands out at its next tick.
const PATIENCE: Duration = Duration::from_secs(2);

/// The services.
pub(crate) struct Simulation {
    features: Server<Empty, GetSimulatorFeaturesResponse>,
    entities: Server<GetEntitiesRequest, GetEntitiesResponse>,
    entity_state: Server<EntityRequest, GetEntityStateResponse>,
    spawn: Server<SpawnEntityRequest, SpawnEntityResponse>,
    delete: Server<EntityRequest, ResultResponse>,
    get_state: Server<Empty, GetSimulationStateResponse>,
    set_state: Server<SetSimulationStateRequest, ResultResponse>,
    step: Server<StepSimulationRequest, ResultResponse>,
    pause: Server<SetBoolRequest, SetBoolResponse>,
    steps: Steps,
    waiting: Vec<Waiting>,
}

/// A command whose answer is a response.
struct Waiting {
    token: u64,
    request: RmwRequestId,
    asked: Instant,
    kind: Kind,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Spawn,
    Delete,
}

impl Simulation {
    pub fn open(link: &mut Link) -> std::result::Result<Self, LinkError> {
        let package = PACKAGE;
        Ok(Self {
            features: link.service("get_simulator_features", package, "GetSimulatorFeatures")?,
            entities: link.service("get_entities", package, "GetEntities")?,
            entity_state: link.service("get_entity_state", package, "GetEntityState")?,
            spawn: link.service("spawn_entity", package, "SpawnEntity")?,
            delete: link.service("delete_entity", package, "DeleteEntity")?,
            get_state: link.service("get_simulation_state", package, "GetSimulationState")?,
            set_state: link.service("set_simulation_state", package, "SetSimulationState")?,
            step: link.service("step_simulation", package, "StepSimulation")?,
            pause: link.service("pause", "std_srvs", "SetBool")?,
            steps: Steps::default(),
            waiting: Vec::new(),
        })
    }

    /// Answers the requests that have come.
    pub fn serve(&mut self, control: &mut Control, fleet: &mut Fleet<'_>) {
        answer(&self.features, |_| GetSimulatorFeaturesResponse { features: features() });
        answer(&self.entities, |request| entities(&request.filters, fleet.snapshot));
        answer(&self.entity_state, |request| entity_state(&request.entity, fleet.snapshot));
        answer(&self.get_state, |_| simulation_state(control));
        answer(&self.set_state, |request| ResultResponse {
            result: set_state(request.state.state, control),
        });
        answer(&self.pause, |request| pause(request.data, control));
        self.take_spawns(fleet);
        self.take_deletions(fleet);
        self.take_steps(control, fleet.steering.fleet());
        self.give_up_waiting();
    }

    fn take_spawns(&mut self, fleet: &mut Fleet<'_>) {
        for (request, spawn) in asked(&self.spawn) {
            let given = robot_to_spawn(&spawn, fleet.map).and_then(|(kind, node)| {
                let command =
                    |commands: &mut regatta_plugin::Commands| commands.spawn_at_node(kind, node);
                let given = fleet.steering.give(NO_ROBOT, command);
                given.map_err(|error| Result::failed(code::OPERATION_FAILED, error))
            });
            match given {
                Ok(token) => self.wait(token, request, Kind::Spawn),
                Err(result) => respond_spawn(&self.spawn, request, result, String::new()),
            }
        }
    }

    fn take_deletions(&mut self, fleet: &mut Fleet<'_>) {
        for (request, EntityRequest { entity }) in asked(&self.delete) {
            let given = find(&entity, fleet.snapshot).and_then(|robot| {
                let given = fleet.steering.give(robot.id, |commands| commands.remove(robot.id));
                given.map_err(|error| Result::failed(code::OPERATION_FAILED, error))
            });
            match given {
                Ok(token) => self.wait(token, request, Kind::Delete),
                Err(result) => respond(&self.delete, request, ResultResponse { result }),
            }
        }
    }

    fn wait(&mut self, token: u64, request: RmwRequestId, kind: Kind) {
        self.waiting.push(Waiting { token, request, asked: Instant::now(), kind });
    }

    /// Responds if an answer of the engine is to a command of these services, and returns whether
    /// it is.
    pub fn note(&mut self, answer: &EventRecord, refusal: Option<&Refusal>) -> bool {
        let place = self.waiting.iter().position(|waiting| waiting.token == answer.token);
        let Some(place) = place else { return false };
        let waiting = self.waiting.swap_remove(place);
        let result = match refusal {
            Some(refusal) => Result::failed(code::OPERATION_FAILED, &refusal.reason),
            None => Result::ok(),
        };
        let is_done = answer.kind() == Some(EventKind::Accepted);
        let name = if is_done { robot_name(answer.robot) } else { String::new() };
        self.finish(&waiting, result, name);
        true
    }

    fn finish(&self, waiting: &Waiting, result: Result, name: String) {
        match waiting.kind {
            Kind::Spawn => respond_spawn(&self.spawn, waiting.request, result, name),
            Kind::Delete => respond(&self.delete, waiting.request, ResultResponse { result }),
        }
    }

    fn give_up_waiting(&mut self) {
        let is_late = |waiting: &Waiting| waiting.asked.elapsed() > PATIENCE;
        let late: Vec<_> = self.waiting.extract_if(.., |waiting| is_late(waiting)).collect();
        for waiting in late {
            let reason = "the fleet is paused; it is done at the next tick";
            self.finish(&waiting, Result::failed(code::OPERATION_FAILED, reason), String::new());
        }
    }

    fn take_steps(&mut self, control: &mut Control, fleet: &FleetName) {
        for (request, StepSimulationRequest { steps }) in asked(&self.step) {
            if let Err(result) = self.steps.start(request, steps, control, fleet) {
                respond(&self.step, request, ResultResponse { result });
            }
        }
        for (request, result) in self.steps.done() {
            respond(&self.step, request, ResultResponse { result });
        }
    }
}

/// Answers all requests of a service at once.
fn answer<Q: Message + 'static, A: Message + 'static>(
    server: &Server<Q, A>,
    mut answer: impl FnMut(Q) -> A,
) {
    for (request, question) in asked(server) {
        respond(server, request, answer(question));
    }
}

fn respond<Q: Message + 'static, A: Message + 'static>(
    server: &Server<Q, A>,
    request: RmwRequestId,
    response: A,
) {
    if let Err(error) = server.send_response(request, response) {
        tell!("ros2: a response can't be sent: {error}");
    }
}

fn respond_spawn(
    server: &Server<SpawnEntityRequest, SpawnEntityResponse>,
    request: RmwRequestId,
    result: Result,
    entity_name: String,
) {
    respond(server, request, SpawnEntityResponse { result, entity_name });
}

fn simulation_state(control: &mut Control) -> GetSimulationStateResponse {
    let state = match control.status() {
        Ok(status) if status.clock == ClockState::Paused as u32 => state::PAUSED,
        Ok(_) => state::PLAYING,
        Err(ControlError::NoEngine { .. }) => state::NO_WORLD,
        Err(error) => {
            let result = Result::failed(code::OPERATION_FAILED, error);
            return GetSimulationStateResponse { result, ..Default::default() };
        }
    };
    GetSimulationStateResponse { state: SimulationState { state }, result: Result::ok() }
}

fn set_state(wanted: u8, control: &mut Control) -> Result {
    let now = simulation_state(control);
    if now.result.result != code::OK {
        return now.result;
    }
    let done = match (now.state.state, wanted) {
        (state::NO_WORLD, _) => {
            return Result::failed(code::INCORRECT_TRANSITION, "the fleet has no engine");
        }
        (now, wanted) if now == wanted => {
            return Result::failed(code::ALREADY_IN_TARGET_STATE, "");
        }
        (_, state::PLAYING) => control.resume(),
        (_, state::PAUSED) => control.pause(),
        (_, state::STOPPED | state::QUITTING) => {
            let reason = "a run can be paused, but not ended from here";
            return Result::failed(code::FEATURE_UNSUPPORTED, reason);
        }
        (_, other) => {
            let reason = format_args!("no state has the number {other}");
            return Result::failed(code::FEATURE_UNSUPPORTED, reason);
        }
    };
    match done {
        Ok(_) => Result::ok(),
        Err(error) => Result::failed(code::OPERATION_FAILED, error),
    }
}

fn pause(is_wanted: bool, control: &mut Control) -> SetBoolResponse {
    let done = if is_wanted { control.pause() } else { control.resume() };
    let message = done.as_ref().err().map(ToString::to_string).unwrap_or_default();
    SetBoolResponse { success: done.is_ok(), message }
}
