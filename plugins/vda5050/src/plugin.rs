//! The plugin: frames and events in, commands out; messages of a broker in and out.

use std::ffi::OsString;
use std::time::{Duration, Instant};

use regatta_plugin::column::{BATTERY, TYPE};
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::frame::{NO_EDGE, RobotState};
use regatta_plugin::world::RobotTypeRecord;
use regatta_plugin::{
    ColumnReader, CommandError, Commands, Error, Events, Frame, Ownership, Participant, Plugin,
    Result, World, tell,
};
use rustc_hash::FxHashMap;

use crate::broker::{Broker, BrokerUrl, Incoming, Session};
use crate::client::{Client, Identity, Intervals, Now};
use crate::disturb::Fate;
use crate::factsheet::factsheet;
use crate::map::Map;
use crate::message::{ConnectionState, InstantActions, Order, Topic, decode};
use crate::options::Cli;
use crate::vehicle::{Command, Seen, Site};

/// Runs the plugin with a command line, whose first argument is the name of the program.
///
/// # Errors
/// Fails if an option is invalid, the fleet has another manager, or as [`regatta_plugin::run`]
/// does. A broker that can't be reached is no error: it is tried again.
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    regatta_kit::run_from(args, |cli: Cli| {
        let (broker, url) = cli.start_broker()?;
        cli.options.clone().run(Vehicles::new(cli, broker, url), "vda5050")
    })
}

/// The plugin's ports in the fleet.
struct Ports {
    _ownership: Ownership,
    commands: Commands,
    types: ColumnReader,
    batteries: ColumnReader,
}

/// The vehicles of a fleet.
struct Vehicles {
    cli: Cli,
    url: BrokerUrl,
    start: Instant,
    ports: Option<Ports>,
    broker: Option<Broker>,
    site: Site,
    origin: [f64; 2],
    robot_types: Vec<RobotTypeRecord>,
    run_id: u64,
    /// The vehicles by robot; `None` for ids that no robot has.
    clients: Vec<Option<Client>>,
    /// The types of the robots.
    types: Vec<usize>,
    /// Robots and kinds of messages by the topics that are listened to.
    topics: FxHashMap<String, (usize, Topic)>,
    /// The connection that all vehicles share, if they do.
    shared: Option<usize>,
    /// Robots by the tokens of commands that aren't answered yet.
    pending: FxHashMap<u64, (usize, Sent)>,
    connections: Connections,
}

/// A command that isn't answered yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sent {
    Route,
    Cancel,
    Other,
}

/// The last news of the connections that the user was told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Connections {
    #[default]
    Untold,
    Up,
    Lost,
}

impl Vehicles {
    fn new(cli: Cli, broker: Broker, url: BrokerUrl) -> Self {
        Self {
            cli,
            url,
            start: Instant::now(),
            ports: None,
            broker: Some(broker),
            site: Site::default(),
            origin: [0.0; 2],
            robot_types: Vec::new(),
            run_id: 0,
            clients: Vec::new(),
            types: Vec::new(),
            topics: FxHashMap::default(),
            shared: None,
            pending: FxHashMap::default(),
            connections: Connections::default(),
        }
    }

    fn now(&self) -> Now {
        Now::at(self.start.elapsed().as_secs_f64())
    }

    fn intervals(&self) -> Intervals {
        Intervals { state: self.cli.state_every, visualization: self.cli.visualization_every }
    }

    /// Connects the vehicles of robots that are new, and disconnects those of robots that have
    /// left.
    fn follow_robots(&mut self, frame: &Frame<'_>, now: &Now) {
        self.clients.resize_with(frame.len().max(self.clients.len()), || None);
        for robot in 0..self.clients.len() {
            let is_there = robot < frame.len() && frame.state_of(robot) != RobotState::Absent;
            match (&self.clients[robot], is_there) {
                (None, true) => self.join(robot, frame.len(), now),
                (Some(_), false) => self.leave(robot, now),
                _ => {}
            }
        }
    }

    fn join(&mut self, robot: usize, robots: usize, now: &Now) {
        let version = self.cli.version(robot);
        let identity = Identity {
            prefix: self.cli.prefix(version),
            manufacturer: self.cli.manufacturer.clone(),
            serial_number: self.cli.serial_number(robot),
            version,
        };
        let link = self.link(&identity, robots, now);
        let topics = identity.inputs().map(|(name, topic)| (name, (robot, topic)));
        self.topics.extend(topics);
        let phase = now.seconds + robot as f64 / robots as f64;
        let fate = Fate::new(&self.cli.disturbances(), robot);
        let client = Client::new(identity, fate, link, phase, self.intervals());
        self.clients[robot] = Some(client);
    }

    /// Returns the number of the connection of a vehicle.
    fn link(&mut self, identity: &Identity, robots: usize, now: &Now) -> usize {
        let Some(broker) = &mut self.broker else { return 0 };
        if robots <= self.cli.shared_above {
            return broker.connect(&identity.session(now));
        }
        *self.shared.get_or_insert_with(|| {
            let client_id = format!("{}-{}", self.cli.manufacturer, self.cli.options.fleet);
            broker.connect(&Session { client_id, will: None, topics: self.cli.shared_topics() })
        })
    }

    fn leave(&mut self, robot: usize, now: &Now) {
        let (Some(mut client), Some(broker)) = (self.clients[robot].take(), &self.broker) else {
            return;
        };
        client.publish_connection(ConnectionState::Offline, now, broker);
        for (topic, _) in client.identity().inputs() {
            self.topics.remove(&topic);
        }
        if self.shared.is_none() {
            broker.disconnect(client.link());
        }
    }

    /// Takes what has come from the broker.
    fn take_messages(&mut self, now: &Now) {
        while let Some(incoming) = self.broker.as_ref().and_then(Broker::take) {
            match incoming {
                Incoming::Message { topic, payload, .. } => self.take_message(&topic, &payload),
                Incoming::Connected { link } => self.greet(link, now),
                Incoming::Lost { reason, .. } => self.tell_lost(&reason),
            }
        }
    }

    fn take_message(&mut self, topic: &str, payload: &[u8]) {
        let Some(&(robot, kind)) = self.topics.get(topic) else { return };
        let Some(Some(client)) = self.clients.get_mut(robot) else { return };
        let vehicle = &mut client.vehicle;
        match kind {
            Topic::Order => match decode::<Order>(payload) {
                Ok(order) => vehicle.take_order(order, &self.site),
                Err(error) => vehicle.take_broken(kind.name(), &error),
            },
            _ => match decode::<InstantActions>(payload) {
                Ok(actions) => vehicle.take_instant_actions(actions, &self.site),
                Err(error) => vehicle.take_broken(kind.name(), &error),
            },
        }
    }

    /// Publishes what a master wants of a vehicle that comes online.
    fn greet(&mut self, link: usize, now: &Now) {
        if self.connections != Connections::Up {
            tell!("vda5050: vehicles connect to {}", self.url);
            self.connections = Connections::Up;
        }
        for robot in 0..self.clients.len() {
            let on_link = self.clients[robot].as_ref().is_some_and(|it| it.link() == link);
            if on_link {
                self.greet_for(robot, now);
            }
        }
    }

    fn greet_for(&mut self, robot: usize, now: &Now) {
        let factsheet = self.factsheet(robot);
        let (Some(Some(client)), Some(broker)) = (self.clients.get_mut(robot), &self.broker) else {
            return;
        };
        client.publish_connection(ConnectionState::Online, now, broker);
        client.publish_factsheet(factsheet, now, broker);
        client.publish_state(self.cli.state_every, now, &self.site, broker);
    }

    fn factsheet(&self, robot: usize) -> crate::message::Factsheet {
        let kind = self.types.get(robot).copied().unwrap_or_default();
        let unknown = RobotTypeRecord::new("robot", 0.0, 0.0);
        let kind = self.robot_types.get(kind).unwrap_or(&unknown);
        let catalogue = &self.site.catalogue;
        factsheet(kind, catalogue, self.intervals(), self.cli.version(robot))
    }

    fn tell_lost(&mut self, reason: &str) {
        if self.connections != Connections::Lost {
            tell!("vda5050: no connection to {} ({reason}); trying again", self.url);
            self.connections = Connections::Lost;
        }
    }

    /// Shows each vehicle its robot.
    fn see(&mut self, frame: &Frame<'_>) -> Result {
        let Some(ports) = &mut self.ports else { return Ok(()) };
        ports.types.latest()?;
        if let Some(types) = ports.types.current()? {
            self.types.clear();
            self.types.extend(types.values.iter().map(|kind| *kind as usize));
        }
        ports.batteries.latest()?;
        let charges = ports.batteries.current()?.map_or(&[][..], |charges| charges.values);
        let (columns, time) = (frame.columns(), frame.sim_time().as_secs_f64());
        for (robot, client) in self.clients.iter_mut().enumerate().take(frame.len()) {
            let Some(client) = client else { continue };
            let seen = Seen {
                time,
                x: self.origin[0] + f64::from(columns.x[robot]),
                y: self.origin[1] + f64::from(columns.y[robot]),
                theta: f64::from(columns.theta[robot]),
                speed: f64::from(columns.speed[robot]),
                s: f64::from(columns.s[robot]),
                edge: Some(columns.edge[robot]).filter(|edge| *edge != NO_EDGE),
                state: frame.state_of(robot),
                charge: charges.get(robot).map(|charge| f64::from(*charge)),
            };
            client.vehicle.see(seen, &self.site);
        }
        Ok(())
    }

    /// Does what the vehicles want: sends commands, and publishes states.
    fn serve(&mut self, now: &Now) -> Result {
        let intervals = self.intervals();
        for robot in 0..self.clients.len() {
            let Some(client) = &mut self.clients[robot] else { continue };
            let outbox = client.vehicle.take_outbox();
            if outbox.state || client.is_state_due(now) {
                let Some(broker) = &self.broker else { continue };
                client.publish_state(intervals.state, now, &self.site, broker);
            }
            if let Some(broker) = &self.broker {
                client.publish_position_if_due(intervals, now, &self.site, broker);
            }
            if let (Some(secs), None, Some(broker)) =
                (outbox.silence_secs, self.shared, &self.broker)
            {
                broker.cut(client.link(), Duration::from_secs_f64(secs));
            }
            for command in outbox.commands {
                self.command(robot, command);
            }
            if outbox.factsheet {
                self.answer_with_factsheet(robot, now);
            }
        }
        self.send_commands()
    }

    fn answer_with_factsheet(&mut self, robot: usize, now: &Now) {
        let factsheet = self.factsheet(robot);
        if let (Some(client), Some(broker)) = (&mut self.clients[robot], &self.broker) {
            client.publish_factsheet(factsheet, now, broker);
        }
    }

    fn command(&mut self, robot: usize, command: Command) {
        let Some(Ports { commands, .. }) = &mut self.ports else { return };
        let id = robot as u32;
        let (token, sent) = match command {
            Command::Extend(legs) => (commands.extend(id, &legs), Sent::Route),
            Command::Cancel => (commands.cancel(id), Sent::Cancel),
            Command::Hold => (commands.hold(id), Sent::Other),
            Command::Resume => (commands.resume(id), Sent::Other),
            Command::FinishEdge(leg) => {
                // With the route dropped, the rest of the edge is left.
                commands.assign(id, &[leg]);
                (commands.cancel(id), Sent::Other)
            }
        };
        self.pending.insert(token, (robot, sent));
    }

    fn send_commands(&mut self) -> Result {
        let Some(Ports { commands, .. }) = &mut self.ports else { return Ok(()) };
        match commands.send() {
            // Commands that can't be sent now are sent with the next ones.
            Ok(())
            | Err(
                CommandError::Full { .. }
                | CommandError::NoEngine { .. }
                | CommandError::MemoryFull,
            ) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    fn take_event(&mut self, event: &EventRecord) {
        let Some(kind) = event.kind() else { return };
        if kind == EventKind::ReachedNode {
            if let Some(Some(client)) = self.clients.get_mut(event.robot as usize) {
                client.vehicle.reached(event.id, &self.site);
            }
            return;
        }
        if !matches!(kind, EventKind::Accepted | EventKind::Refused) {
            return;
        }
        let Some((robot, sent)) = self.pending.remove(&event.token) else { return };
        let Some(Some(client)) = self.clients.get_mut(robot) else { return };
        match (sent, kind) {
            (Sent::Cancel, _) => client.vehicle.cancelled(),
            (Sent::Route, EventKind::Refused) => client.vehicle.refused(&refusal(event)),
            _ => {}
        }
    }
}

fn refusal(event: &EventRecord) -> String {
    let id = event.id;
    if event.detail == Refusal::EdgeClosed as u32 {
        format!("edge {id} is closed")
    } else if event.detail == Refusal::NotOwner as u32 {
        "another process moves the robots of this fleet".to_owned()
    } else {
        format!("edge {id} can't be driven from where the vehicle is")
    }
}

impl Plugin for Vehicles {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.ports = Some(Ports {
            _ownership: Ownership::claim(fleet)?,
            commands: Commands::open_on(fleet)?,
            types: ColumnReader::open_on(fleet, TYPE.name())?,
            batteries: ColumnReader::open_on(fleet, BATTERY.name())?,
        });
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.site = Site { map: Map::of(world, &self.cli.map_id), catalogue: self.cli.catalogue() };
        if self.site.map.nodes().is_empty() {
            return Err(Error::new("the fleet has no route graph; orders need one"));
        }
        self.origin = world.origin();
        self.robot_types = world.robot_types().to_vec();
        if std::mem::replace(&mut self.run_id, world.run_id()) != world.run_id() {
            self.clients.iter_mut().flatten().for_each(Client::restart);
            self.pending.clear();
        }
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        let now = self.now();
        self.follow_robots(frame, &now);
        self.see(frame)?;
        self.take_messages(&now);
        self.serve(&now)
    }

    fn on_idle(&mut self, _: bool) -> Result {
        let now = self.now();
        self.take_messages(&now);
        self.serve(&now)
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        events.records.iter().for_each(|event| self.take_event(event));
        Ok(())
    }

    fn wants_events(&self) -> bool {
        true
    }

    fn on_stop(&mut self) -> Result {
        let now = self.now();
        let Some(broker) = self.broker.take() else { return Ok(()) };
        for client in self.clients.iter_mut().flatten() {
            client.publish_connection(ConnectionState::Offline, &now, &broker);
        }
        broker.end();
        Ok(())
    }
}
