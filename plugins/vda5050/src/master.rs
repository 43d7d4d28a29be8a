//! A master: shows the vehicles that others have on a broker as a fleet, and tells them what the
//! manager of that fleet commands.
//!
//! ```text
//!   vehicles ◀── orders ── post ◀── talk ◀── course ◀── commands ── fleet manager
//!            ── states ──▶ vehicle ──▶ course ──▶ frames, events ──▶
//! ```
//!
//! It is a producer of the contract, so any manager steers the vehicles, and any reader watches
//! them. `course` is the way of a robot, `talk` what its vehicle was told of it; `trouble` has the
//! reasons for which others keep away from a vehicle. Only `post` and this file know a broker.

mod commands;
mod course;
mod options;
mod orders;
mod post;
mod producer;
mod roads;
mod talk;
#[cfg(test)]
mod tests;
mod trouble;
mod vehicle;

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

pub use options::{MasterOptions, VehiclesOptions};
use post::Post;
use regatta_plugin::command::CommandRecord;
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::order::NO_ROBOT;
use regatta_plugin::producer::{LockstepOptions, Session, Speed};
use regatta_plugin::world::WorldData;
use regatta_plugin::{
    Error, OrderReader, Participant, ProducerPorts, Result, RouteServer, Termination, tell,
};
use roads::Roads;
use rustc_hash::FxHashMap;
use vehicle::Vehicle;

use crate::broker::{self, Broker, BrokerUrl, Incoming};
use crate::message::{Connection, Factsheet, State, Topic, Visualization, decode};

/// The name of the producer in its fleet.
const NAME: &str = "vehicles";
/// The time for which vehicles are collected before the first frame, and after the last one that
/// came. Their robots are numbered by name.
const COLLECT: Duration = Duration::from_secs(2);
/// The longest time to wait for the first vehicle before the first frame.
const FIRST_VEHICLE: Duration = Duration::from_secs(20);

/// Shows the vehicles on a broker as a fleet, and steers them, until the process is asked to end.
///
/// # Errors
/// If the world has doors or lifts or no roads, the password can't be read, the fleet has another
/// producer, or shared memory fails. A broker that can't be reached is no error.
pub fn run(world: WorldData, options: &VehiclesOptions) -> Result {
    let termination = Termination::watch()?;
    let participant = Participant::join(&options.fleet, NAME)?;
    let ports = ProducerPorts::create_on(participant, 0)?;
    let mut master = Master::new(world, &options.master, ports.participant())?;
    let period = Duration::from_secs_f64(1.0 / options.rate);
    let mut session = Session::new(ports, period, Speed::default(), LockstepOptions::default());
    let result = session.run(&mut master, &termination);
    master.end();
    result
}

/// A master.
struct Master {
    options: MasterOptions,
    world: WorldData,
    roads: Roads,
    url: BrokerUrl,
    broker: Option<Broker>,
    link: usize,
    start: Instant,
    /// The vehicles by robot.
    vehicles: Vec<(Post, Vehicle)>,
    /// The number of vehicles that were ever met.
    met: usize,
    /// Vehicles that have no robot yet, by name.
    newcomers: BTreeMap<String, (Post, Vehicle)>,
    /// The time of the last newcomer.
    newest: Option<Instant>,
    robots: FxHashMap<String, usize>,
    is_full: bool,
    /// Vehicles that speak other versions of the standard, by name.
    refused: BTreeSet<String>,
    /// Edges that commands have closed, and those around loose vehicles.
    closed: BTreeSet<u32>,
    around: BTreeSet<u32>,
    /// The edges that were published last.
    published: BTreeSet<u32>,
    routes: RouteServer,
    orders: OrderReader,
    events: Vec<EventRecord>,
    command_log: Vec<CommandRecord>,
    is_connected: Option<bool>,
    run: String,
}

impl Master {
    fn new(world: WorldData, options: &MasterOptions, fleet: &Participant) -> Result<Self> {
        if world.edges.is_empty() {
            return Err(Error::new("the plant has no edges: vehicles are steered along edges"));
        }
        if !world.doors.is_empty() || !world.lifts.is_empty() {
            return Err(Error::new(
                "the plant has doors or lifts, which nobody moves for vehicles of VDA 5050; take \
                 them out of the layout",
            ));
        }
        let url = options.broker.clone().ok_or_else(|| Error::new("--vda5050 is missing"))?;
        let password = broker::password(options.password_file.as_deref())?;
        let mut broker = Broker::start(url.clone(), password)?;
        let client_id = format!("regatta-master-{}", std::process::id());
        let session = broker::Session { client_id, will: None, topics: options.topics() };
        let link = broker.connect(&session);
        Ok(Self {
            roads: Roads::of(&world.view(0, 0), &options.map_id),
            options: options.clone(),
            world,
            url,
            broker: Some(broker),
            link,
            start: Instant::now(),
            vehicles: Vec::new(),
            met: 0,
            newcomers: BTreeMap::new(),
            newest: None,
            robots: FxHashMap::default(),
            is_full: false,
            refused: BTreeSet::new(),
            closed: BTreeSet::new(),
            around: BTreeSet::new(),
            published: BTreeSet::new(),
            routes: RouteServer::open_on(fleet)?,
            orders: OrderReader::open_on(fleet)?,
            events: Vec::new(),
            command_log: Vec::new(),
            is_connected: None,
            run: String::new(),
        })
    }

    /// Seconds since the start.
    fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Takes what has come from the broker.
    fn listen(&mut self) {
        while let Some(incoming) = self.broker.as_ref().and_then(Broker::take) {
            match incoming {
                Incoming::Message { topic, payload, .. } => self.take_message(&topic, &payload),
                Incoming::Connected { .. } => {
                    let now = self.now();
                    self.vehicles.iter_mut().for_each(|(_, vehicle)| vehicle.hear(now));
                    if self.is_connected.replace(true) != Some(true) {
                        tell!("vehicles: connected to {}", self.url);
                    }
                }
                Incoming::Lost { reason, .. } => {
                    if self.is_connected.replace(false) != Some(false) {
                        let url = &self.url;
                        tell!("vehicles: no connection to {url} ({reason}); trying again");
                    }
                }
            }
        }
    }

    fn take_message(&mut self, topic: &str, payload: &[u8]) {
        let Some((name, kind)) = topic.rsplit_once('/') else { return };
        let Some(kind) = Topic::ALL.into_iter().find(|topic| topic.name() == kind) else { return };
        let now = self.now();
        let Some(place) = self.place(name, kind) else { return };
        let limits = self.options.limits();
        let Self { vehicles, newcomers, roads, world, .. } = self;
        let entry = match place {
            Some(robot) => vehicles.get_mut(robot),
            None => newcomers.get_mut(name),
        };
        let Some((post, vehicle)) = entry else { return };
        // A message that can't be read is left out: it isn't for a master to answer.
        match kind {
            Topic::Connection => {
                let Ok(connection) = decode::<Connection>(payload) else { return };
                post.learn(&connection.header);
                vehicle.take_connection(&connection, now);
                if !vehicle.is_known() && !vehicle.is_online() {
                    newcomers.remove(name);
                }
            }
            Topic::State => {
                let Ok(state) = decode::<State>(payload) else { return };
                post.learn(&state.header);
                if post.learn_spelling(&state.errors) {
                    tell!(
                        "vehicles: from now on, {name} gets instant actions as version 1.1 spells \
                         them"
                    );
                }
                vehicle.take_state(state, roads, limits, now);
            }
            Topic::Visualization => {
                let Ok(Visualization { mobile_robot_position, velocity, .. }) = decode(payload)
                else {
                    return;
                };
                vehicle.take_position(mobile_robot_position, velocity, roads, now);
            }
            Topic::Factsheet => {
                let Ok(factsheet) = decode::<Factsheet>(payload) else { return };
                vehicle.take_factsheet(&factsheet, |length, width| find_type(world, length, width));
            }
            Topic::Order | Topic::InstantActions => {}
        }
    }

    /// Finds the robot of a vehicle by its name: the inner value is `None` for a newcomer. A vehicle
    /// begins with its connection or its state.
    fn place(&mut self, name: &str, kind: Topic) -> Option<Option<usize>> {
        if let Some(robot) = self.robots.get(name) {
            return Some(Some(*robot));
        }
        if self.newcomers.contains_key(name) {
            return Some(None);
        }
        if !matches!(kind, Topic::Connection | Topic::State) || self.refused.contains(name) {
            return None;
        }
        let count = self.vehicles.len() + self.newcomers.len();
        if count + self.refused.len() >= self.options.most_vehicles {
            if !std::mem::replace(&mut self.is_full, true) {
                let most = self.options.most_vehicles;
                tell!("vehicles: there are more than {most} vehicles; the others are ignored");
            }
            return None;
        }
        let Some(post) = Post::new(name) else {
            tell!("vehicles: {name} is ignored: it speaks none of VDA 5050 2.0, 2.1 and 3.0");
            self.refused.insert(name.to_owned());
            return None;
        };
        let vehicle = Vehicle::new(format!("{}-{}", self.run, self.met));
        self.met += 1;
        self.newcomers.insert(name.to_owned(), (post, vehicle));
        self.newest = Some(Instant::now());
        Some(None)
    }

    /// Gives newcomers that have told their states robots, by name, when none has come for a while.
    fn admit(&mut self) {
        if self.newest.is_none_or(|newest| newest.elapsed() < COLLECT) {
            return;
        }
        let (known, others) =
            std::mem::take(&mut self.newcomers).into_iter().partition(|(_, it)| it.1.is_known());
        self.newcomers = others;
        let known: BTreeMap<String, (Post, Vehicle)> = known;
        for (name, entry) in known {
            let robot = self.vehicles.len();
            tell!("vehicles: {name} is robot {robot} (VDA 5050 {})", entry.0.version());
            self.robots.insert(name, robot);
            self.vehicles.push(entry);
            self.events.push(EventRecord {
                kind: EventKind::Spawned as u32,
                robot: robot as u32,
                ..EventRecord::default()
            });
        }
    }

    /// Whether vehicles are still being collected for the first frame.
    fn is_collecting(&self) -> bool {
        match self.newest {
            None => self.start.elapsed() < FIRST_VEHICLE,
            Some(newest) => newest.elapsed() < COLLECT,
        }
    }

    /// Closes an edge, or opens it.
    fn set_closed(&mut self, edge: u32, is_closed: bool) {
        match is_closed {
            true => self.closed.insert(edge),
            false => self.closed.remove(&edge),
        };
    }

    fn is_closed(&self, edge: u32) -> bool {
        self.closed.contains(&edge) || self.around.contains(&edge)
    }

    /// Closes the edges around vehicles that may be elsewhere than on their ways.
    fn close_around(&mut self) {
        let sizes = self.world.robot_types.iter().map(|kind| kind.length.hypot(kind.width));
        let apart = f64::from(sizes.fold(0.0, f32::max));
        let loose = self.vehicles.iter().filter_map(|(_, vehicle)| vehicle.loose_at());
        self.around = loose.flat_map(|position| self.roads.edges_near(position, apart)).collect();
    }

    /// Looks after all vehicles, tells the user their news, and tells them what is to be told.
    fn serve(&mut self) {
        let (now, limits) = (self.now(), self.options.limits());
        let closed: BTreeSet<u32> = self.closed.union(&self.around).copied().collect();
        let Self { vehicles, newcomers, broker, roads, link, events, .. } = self;
        let Some(broker) = broker else { return };
        // Without a broker nothing is known of them.
        let is_up = broker.is_up(*link);
        let everyone = newcomers.values_mut().chain(vehicles.iter_mut());
        for (post, vehicle) in everyone.filter(|_| is_up) {
            if let Some(question) = vehicle.ask(now) {
                post.send(question, broker, *link);
            }
        }
        for (robot, (post, vehicle)) in vehicles.iter_mut().enumerate() {
            if is_up {
                vehicle.look(limits, now);
            }
            if is_up && let Some(saying) = vehicle.say(roads, |edge| closed.contains(&edge), now) {
                post.send(saying, broker, *link);
            }
            for line in vehicle.take_lines() {
                tell!("vehicles: robot {robot} ({}): {line}", post.name());
            }
            let robot = robot as u32;
            events.extend(vehicle.take_events().into_iter().map(|it| EventRecord { robot, ..it }));
        }
    }

    /// Returns the events of edges that were closed and opened since the last call.
    fn note_closures(&mut self) -> bool {
        let closed: BTreeSet<u32> = self.closed.union(&self.around).copied().collect();
        let before = std::mem::replace(&mut self.published, closed);
        let event = |edge: &u32, kind: EventKind| EventRecord {
            kind: kind as u32,
            robot: NO_ROBOT,
            id: self.world.edges[*edge as usize].id,
            ..EventRecord::default()
        };
        let after = &self.published;
        self.events.extend(after.difference(&before).map(|it| event(it, EventKind::EdgeClosed)));
        self.events.extend(before.difference(after).map(|it| event(it, EventKind::EdgeOpened)));
        before != *after
    }

    fn end(&mut self) {
        if let Some(broker) = self.broker.take() {
            broker.end();
        }
    }
}

/// The first robot type that is as large as a vehicle, by its index.
fn find_type(world: &WorldData, length: f64, width: f64) -> Option<usize> {
    /// Metres by which a factsheet may be rounded.
    const ROUNDING: f64 = 0.01;
    world.robot_types.iter().position(|kind| {
        length <= f64::from(kind.length) + ROUNDING && width <= f64::from(kind.width) + ROUNDING
    })
}
