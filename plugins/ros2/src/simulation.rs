//! The services of `simulation_interfaces`, as simulators of single robots have them, and `pause`.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::frame::ClockState;
use regatta_plugin::order::NO_ROBOT;
use regatta_plugin::{Control, ControlError, FleetName, tell};
use regex::Regex;
use ros2_client::{Message, RmwRequestId, Server};

use crate::link::{Link, LinkError, asked};
use crate::map::Map;
use crate::message::geometry::{Header, Vector3};
use crate::message::simulation::*;
use crate::options::{robot_name, robot_number};
use crate::poses::MAP;
use crate::snapshot::{Robot, Snapshot};
use crate::steering::{Refusal, Steering};

const PACKAGE: &str = "simulation_interfaces";
/// Robots, among the categories of entities.
const ROBOT: u8 = 1;
/// Kinds of [`Bounds`].
const NO_BOUNDS: u8 = 0;
const BOX: u8 = 1;
const SPHERE: u8 = 3;
/// The time that a robot's spawn or removal may take before it is answered: a paused fleet carries
/// commands out at its next tick.
const PATIENCE: Duration = Duration::from_secs(2);
/// The longest pattern of names, in bytes.
const MAX_PATTERN_BYTES: usize = 1_000;

/// The fleet, as a request sees it.
pub(crate) struct Fleet<'desk> {
    pub map: &'desk Map,
    pub snapshot: &'desk Snapshot,
    pub steering: &'desk mut Steering,
}

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

/// Steps on a thread of their own, as they may take long.
struct Steps {
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
    fn start(
        &mut self,
        request: RmwRequestId,
        steps: u64,
        control: &mut Control,
        fleet: &FleetName,
    ) -> std::result::Result<(), Result> {
        let failed = |reason: &str| Err(Result::failed(code::OPERATION_FAILED, reason));
        if self.is_stepping {
            return failed("steps of another request are being made");
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

    fn done(&mut self) -> Vec<(RmwRequestId, Result)> {
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

fn features() -> SimulatorFeatures {
    SimulatorFeatures {
        features: vec![
            feature::SPAWNING,
            feature::DELETING,
            feature::ENTITY_CATEGORIES,
            feature::ENTITY_BOUNDS_BOX,
            feature::ENTITY_STATE_GETTING,
            feature::SIMULATION_STATE_GETTING,
            feature::SIMULATION_STATE_SETTING,
            feature::SIMULATION_STATE_PAUSE,
            feature::STEP_SIMULATION_SINGLE,
            feature::STEP_SIMULATION_MULTIPLE,
        ],
        spawn_formats: Vec::new(),
        custom_info: "Regatta: the uri of a robot is the name of its type".to_owned(),
    }
}

/// The robots that filters admit.
fn entities(filters: &EntityFilters, snapshot: &Snapshot) -> GetEntitiesResponse {
    let is_admitted = match filter(filters) {
        Ok(is_admitted) => is_admitted,
        Err(result) => return GetEntitiesResponse { result, entities: Vec::new() },
    };
    let robots = snapshot.robots.iter().filter(|robot| is_admitted(robot));
    let entities = robots.map(|robot| robot_name(robot.id)).collect();
    GetEntitiesResponse { result: Result::ok(), entities }
}

/// Returns a test of robots.
fn filter(filters: &EntityFilters) -> std::result::Result<impl Fn(&Robot) -> bool + '_, Result> {
    let unsupported = |reason: &str| Err(Result::failed(code::FEATURE_UNSUPPORTED, reason));
    let Bounds { r#type: kind, points } = &filters.bounds;
    match (*kind, points.len()) {
        _ if !filters.tags.tags.is_empty() => return unsupported("robots have no tags"),
        (NO_BOUNDS, _) | (BOX | SPHERE, 2) => {}
        _ => return unsupported("bounds are a box or a sphere, of two points"),
    }
    if filters.filter.len() > MAX_PATTERN_BYTES {
        return unsupported("the pattern of names is too long");
    }
    let pattern = match Regex::new(&filters.filter) {
        Ok(pattern) => (!filters.filter.is_empty()).then_some(pattern),
        Err(error) => return Err(Result::failed(code::OPERATION_FAILED, error)),
    };
    let categories = &filters.categories;
    let has_robots = categories.is_empty() || categories.iter().any(|it| it.category == ROBOT);
    Ok(move |robot: &Robot| {
        has_robots
            && is_within(robot, *kind, points)
            && pattern.as_ref().is_none_or(|pattern| pattern.is_match(&robot_name(robot.id)))
    })
}

/// Whether a robot's position is within bounds, on the ground.
fn is_within(robot: &Robot, kind: u8, points: &[Vector3]) -> bool {
    let (Some(first), Some(second)) = (points.first(), points.get(1)) else { return true };
    let is_between =
        |at: f64, one: f64, other: f64| (one.min(other)..=one.max(other)).contains(&at);
    match kind {
        BOX => is_between(robot.x, first.x, second.x) && is_between(robot.y, first.y, second.y),
        SPHERE => (robot.x - first.x).hypot(robot.y - first.y) <= second.x,
        _ => true,
    }
}

/// The robot that is meant by a name.
fn find<'snapshot>(
    entity: &str,
    snapshot: &'snapshot Snapshot,
) -> std::result::Result<&'snapshot Robot, Result> {
    let robot = robot_number(entity).and_then(|robot| snapshot.robot(robot));
    robot.ok_or_else(|| {
        Result::failed(code::NOT_FOUND, format_args!("no robot is called '{entity}'"))
    })
}

fn entity_state(entity: &str, snapshot: &Snapshot) -> GetEntityStateResponse {
    match find(entity, snapshot) {
        Ok(robot) => GetEntityStateResponse {
            result: Result::ok(),
            state: EntityState {
                header: Header::new(&snapshot.stamp(), MAP),
                pose: robot.pose(),
                twist: robot.twist_on_map(),
                ..EntityState::default()
            },
        },
        Err(result) => GetEntityStateResponse { result, ..Default::default() },
    }
}

/// The type and the node of a robot to spawn.
fn robot_to_spawn(
    request: &SpawnEntityRequest,
    map: &Map,
) -> std::result::Result<(u32, u32), Result> {
    let SpawnEntityRequest { entity_resource: Resource { uri, resource_string }, .. } = request;
    if !request.allow_renaming {
        let reason = "robots are called robot_N; ask for it with allow_renaming";
        return Err(Result::failed(code::NAME_INVALID, reason));
    }
    if uri.is_empty() && !resource_string.is_empty() {
        let reason = "robots are spawned by the name of their type, as uri";
        return Err(Result::failed(code::UNSUPPORTED_FORMAT, reason));
    }
    let kind = match map.robot_types.iter().position(|name| name == uri) {
        Some(kind) => kind,
        None if uri.is_empty() => 0,
        None => {
            let known = map.robot_types.join(", ");
            let reason = format_args!("no robot type is called '{uri}'; there are {known}");
            return Err(Result::failed(code::UNSUPPORTED_FORMAT, reason));
        }
    };
    let mut pose = request.initial_pose.clone();
    if pose.header.frame_id == "world" {
        pose.header.frame_id.clear();
    }
    let place = map.goal(&pose).map_err(|error| Result::failed(code::INVALID_POSE, error))?;
    Ok((kind as u32, place.node))
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
            let reason = "a run can be paused, and not be ended from here";
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

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{NO_EDGE, RobotState};

    use super::*;

    fn snapshot() -> Snapshot {
        let robot = |id| Robot {
            id,
            x: f64::from(id),
            y: 0.0,
            theta: 0.0,
            speed: 0.0,
            edge: NO_EDGE,
            state: RobotState::Idle,
        };
        Snapshot { robots: (0..12).map(robot).collect(), ..Snapshot::default() }
    }

    fn names(filters: &EntityFilters) -> Vec<String> {
        entities(filters, &snapshot()).entities
    }

    #[test]
    fn entities_are_filtered() {
        assert_eq!(names(&EntityFilters::default()).len(), 12);
        let pattern =
            |filter: &str| EntityFilters { filter: filter.to_owned(), ..Default::default() };
        assert_eq!(names(&pattern("^robot_1[01]$")), ["robot_10", "robot_11"]);
        let wrong = entities(&pattern("("), &snapshot());
        assert_eq!((wrong.result.result, wrong.entities.len()), (code::OPERATION_FAILED, 0));
        let point = |x, y| Vector3 { x, y, z: 0.0 };
        let bounds = |r#type, points| EntityFilters {
            bounds: Bounds { r#type, points },
            ..Default::default()
        };
        assert_eq!(names(&bounds(SPHERE, vec![point(4.0, 0.0), point(1.5, 0.0)])).len(), 3);
        assert_eq!(names(&bounds(BOX, vec![point(9.0, 1.0), point(2.5, -1.0)])).len(), 7);
        let hull = entities(&bounds(2, vec![point(0.0, 0.0); 3]), &snapshot());
        assert_eq!(hull.result.result, code::FEATURE_UNSUPPORTED);
        let humans = EntityFilters {
            categories: vec![EntityCategory { category: 2 }],
            ..Default::default()
        };
        assert!(names(&humans).is_empty());
    }

    #[test]
    fn unknown_entities_are_not_found() {
        let found = entity_state("robot_3", &snapshot());
        assert_eq!((found.result.result, found.state.pose.position.x), (code::OK, 3.0));
        for name in ["robot_12", "robot_03", "", "\u{0}"] {
            let state = entity_state(name, &snapshot());
            assert_eq!(state.result.result, code::NOT_FOUND, "{name}");
        }
    }
}
