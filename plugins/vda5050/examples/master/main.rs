//! A small master of VDA 5050 2.0 for layouts in LIF, to try `regatta study --vda5050` with.
//!
//! Each vehicle gets one transport after the other, on the shortest way, and bases of a few edges
//! whose nodes no other vehicle has. While the node of a vehicle that is online isn't known, no
//! vehicle gets anything; one whose connection is broken keeps its nodes. The master takes
//! transports from the topic `transports` of its broker or by HTTP, or makes them itself. It
//! doesn't look ahead: on roads of both directions vehicles may block each other.
//!
//! Its faults can be chosen: above `--capacity` vehicles, each further one delays all that it
//! sends by `--delay` seconds, and with `--careless` it gives bases whoever is in them.

mod load;
mod roads;

use std::collections::{BTreeMap, VecDeque};
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

use clap::Parser;
use regatta_vda5050::broker::{self, Broker, BrokerUrl, Delivery, Incoming, Session};
use regatta_vda5050::message::{
    Action, BlockingType, Connection, ConnectionState, Edge, Header, Node, Order, State, Version,
    decode, encode, timestamp,
};

use load::{Load, Transport};
use roads::{Claims, Roads, Way};

type Result<T = (), E = Box<dyn std::error::Error + Send + Sync>> = std::result::Result<T, E>;

/// The topic with transports.
const TRANSPORTS: &str = "transports";

#[derive(Parser)]
struct Cli {
    /// Broker; the password of its user is in REGATTA_MQTT_PASSWORD
    broker: BrokerUrl,
    /// Layout in LIF
    layout: PathBuf,
    /// First levels of the topics of vehicles
    #[arg(long, default_value = "uagv/v2/regatta")]
    vehicles: String,
    /// Edges of a base
    #[arg(long, default_value_t = 2)]
    base: usize,
    /// Port of this machine at which transports are taken by HTTP
    #[arg(long)]
    http: Option<u16>,
    /// Make transports itself: as many as there are vehicles
    #[arg(long)]
    own_load: bool,
    /// Vehicles that it serves at once
    #[arg(long, default_value_t = usize::MAX)]
    capacity: usize,
    /// Seconds by which each further vehicle delays what it sends
    #[arg(long, default_value_t = 0.5)]
    delay: f64,
    /// Give bases whoever is in them
    #[arg(long)]
    careless: bool,
}

/// A vehicle and its transport.
#[derive(Default)]
struct Vehicle {
    header_id: u32,
    state: Option<State>,
    order: Option<Current>,
    /// The time at which the next message to it is sent.
    due: Option<Instant>,
}

/// The order that a vehicle carries out.
struct Current {
    id: String,
    update_id: u32,
    way: Way,
    stops: [Stop; 2],
    /// The nodes of the way that are released.
    released: usize,
}

/// A node of a way with an action.
struct Stop {
    place: usize,
    kind: &'static str,
}

struct Master {
    cli: Cli,
    roads: Roads,
    claims: Claims,
    vehicles: BTreeMap<String, Vehicle>,
    waiting: VecDeque<Transport>,
    broker: Broker,
    link: usize,
}

fn main() -> Result {
    let cli = Cli::parse();
    let roads = Roads::read(&cli.layout)?;
    let mut load = Load::new(cli.http, cli.own_load)?;
    let mut broker = Broker::start(cli.broker.clone(), broker::password(None)?)?;
    let [connections, states] =
        ["connection", "state"].map(|name| format!("{}/+/{name}", cli.vehicles));
    let topics = vec![connections, states, TRANSPORTS.to_owned()];
    let client_id = format!("example-master-{}", std::process::id());
    let link = broker.connect(&Session { client_id, will: None, topics });
    let (claims, vehicles) = (Claims::default(), BTreeMap::new());
    let mut master =
        Master { cli, roads, claims, vehicles, waiting: VecDeque::new(), broker, link };
    loop {
        master.listen()?;
        let open = master.open_transports();
        master.waiting.extend(load.take(&master.roads, master.vehicles.len().saturating_sub(open)));
        master.serve();
        std::thread::sleep(Duration::from_millis(2));
    }
}

impl Master {
    fn listen(&mut self) -> Result {
        while let Some(incoming) = self.broker.take() {
            match incoming {
                Incoming::Message { topic, payload, .. } if topic == TRANSPORTS => {
                    self.waiting.push_back(serde_json::from_slice(&payload)?);
                }
                Incoming::Message { topic, payload, .. } => {
                    let serial = topic.rsplit('/').nth(1).unwrap_or_default().to_owned();
                    if topic.ends_with("/connection") {
                        if let Ok(connection) = decode(&payload) {
                            self.take_connection(serial, &connection);
                        }
                    } else if let Ok(state) = decode(&payload) {
                        self.take_state(serial, state);
                    }
                }
                Incoming::Lost { reason, .. } => return Err(reason.into()),
                Incoming::Connected { .. } => {}
            }
        }
        Ok(())
    }

    fn open_transports(&self) -> usize {
        let carried = self.vehicles.values().filter(|vehicle| vehicle.order.is_some());
        carried.count() + self.waiting.len()
    }

    /// Notes a vehicle that has come, and forgets one that has left.
    fn take_connection(&mut self, serial: String, connection: &Connection) {
        match connection.connection_state {
            ConnectionState::Online => {
                self.vehicles.entry(serial).or_default();
            }
            ConnectionState::Offline => {
                self.claims.set(&serial, Vec::new());
                self.vehicles.remove(&serial);
            }
            // It still stands where it is.
            ConnectionState::Hibernating | ConnectionState::ConnectionBroken => {}
        }
    }

    fn take_state(&mut self, serial: String, state: State) {
        let vehicle = self.vehicles.entry(serial.clone()).or_default();
        // A vehicle without an order that had one is a new one of the same name.
        let is_new = state.order_id.is_empty()
            && vehicle.state.as_ref().is_some_and(|before| !before.order_id.is_empty());
        let is_over = |state: &State| {
            state.node_states.is_empty()
                && state.action_states.iter().all(|action| action.action_status.is_over())
        };
        let current = vehicle.order.as_ref().filter(|order| order.id == state.order_id);
        let is_done = current.is_some_and(|order| {
            is_over(&state)
                && order.released == order.way.nodes.len()
                && order.update_id == state.order_update_id
        });
        if is_new || is_done {
            vehicle.order = None;
        }
        let mut held = vec![state.last_node_id.clone()];
        if let Some(order) = &vehicle.order {
            let place =
                if order.id == state.order_id { state.last_node_sequence_id / 2 } else { 0 };
            held.extend(order.way.nodes[..order.released].iter().skip(place as usize).cloned());
        }
        self.claims.set(&serial, held);
        vehicle.state = Some(state);
    }

    /// Sends what is due, and plans what vehicles need.
    fn serve(&mut self) {
        // A vehicle whose node isn't known may stand at any.
        if !self.vehicles.values().all(Vehicle::is_placed) {
            return;
        }
        let excess = self.vehicles.len().saturating_sub(self.cli.capacity);
        let delay = Duration::from_secs_f64(self.cli.delay * excess as f64);
        let now = Instant::now();
        let serials: Vec<String> = self.vehicles.keys().cloned().collect();
        for serial in serials {
            let Some(vehicle) = self.vehicles.get_mut(&serial) else { continue };
            if !vehicle.wants() {
                continue;
            }
            if now >= *vehicle.due.get_or_insert(now + delay)
                && self.answer(&serial).is_some()
                && let Some(vehicle) = self.vehicles.get_mut(&serial)
            {
                vehicle.due = None;
            }
        }
    }

    /// Gives a vehicle a transport or a base, if there is one.
    fn answer(&mut self, serial: &str) -> Option<()> {
        let vehicle = self.vehicles.get(serial)?;
        if vehicle.order.is_none() {
            let here = vehicle.state.as_ref()?.last_node_id.clone();
            let transport = self.waiting.front()?;
            let to_pick = self.roads.way(&here, &transport.pick)?;
            let to_drop = self.roads.way(&transport.pick, &transport.drop)?;
            let transport = self.waiting.pop_front()?;
            let picks = Stop { place: to_pick.nodes.len() - 1, kind: "pick" };
            let way = to_pick.joined(to_drop);
            let drops = Stop { place: way.nodes.len() - 1, kind: "drop" };
            let id = format!("{}-{serial}", transport.id);
            let order = Current { id, update_id: 0, way, stops: [picks, drops], released: 1 };
            self.vehicles.get_mut(serial)?.order = Some(order);
            self.release(serial);
            return self.send(serial, 0);
        }
        let first = vehicle.order.as_ref()?.released - 1;
        if !self.release(serial) {
            return None;
        }
        self.vehicles.get_mut(serial)?.order.as_mut()?.update_id += 1;
        self.send(serial, first)
    }

    /// Releases the next nodes of a vehicle's way that are free. Returns whether there are any.
    fn release(&mut self, serial: &str) -> bool {
        let Some(order) = self.vehicles.get_mut(serial).and_then(|it| it.order.as_mut()) else {
            return false;
        };
        let before = order.released;
        let end = order.way.nodes.len().min(before + self.cli.base);
        while order.released < end {
            let node = &order.way.nodes[order.released];
            if !self.claims.claim(serial, node) && !self.cli.careless {
                break;
            }
            order.released += 1;
        }
        order.released > before
    }

    /// Sends the way of a vehicle from a node on.
    fn send(&mut self, serial: &str, first: usize) -> Option<()> {
        let vehicle = self.vehicles.get_mut(serial)?;
        vehicle.header_id += 1;
        let order = vehicle.order.as_ref()?;
        let manufacturer = self.cli.vehicles.rsplit('/').next().unwrap_or_default();
        let header = Header {
            header_id: vehicle.header_id,
            timestamp: timestamp(SystemTime::now()),
            version: Version::V2_0.number().to_owned(),
            manufacturer: manufacturer.to_owned(),
            serial_number: serial.to_owned(),
        };
        let message = encode(&order.message(header, first), Version::V2_0);
        let topic = format!("{}/{serial}/order", self.cli.vehicles);
        self.broker.publish(self.link, &topic, message, Delivery::Now);
        Some(())
    }
}

impl Vehicle {
    /// Whether its last node is known.
    fn is_placed(&self) -> bool {
        self.state.as_ref().is_some_and(|state| !state.last_node_id.is_empty())
    }

    /// Whether it needs a transport or a base, and has taken what was sent.
    fn wants(&self) -> bool {
        let Some(state) = &self.state else { return false };
        let Some(order) = &self.order else { return true };
        let has_taken = state.order_id == order.id && state.order_update_id == order.update_id;
        let has_more = order.released < order.way.nodes.len();
        let is_at_end = state.last_node_sequence_id as usize / 2 + 1 >= order.released;
        has_taken && has_more && (is_at_end || state.new_base_request == Some(true))
    }
}

impl Current {
    fn message(&self, header: Header, first: usize) -> Order {
        let nodes = self.way.nodes.iter().enumerate().skip(first);
        let nodes = nodes.map(|(place, id)| Node {
            node_id: id.clone(),
            sequence_id: 2 * place as u32,
            released: place < self.released,
            actions: self.actions(place),
            ..Node::default()
        });
        let edges = self.way.edges.iter().enumerate().skip(first);
        let edges = edges.map(|(place, id)| Edge {
            edge_id: id.clone(),
            sequence_id: 2 * place as u32 + 1,
            released: place + 1 < self.released,
            start_node_id: Some(self.way.nodes[place].clone()),
            end_node_id: Some(self.way.nodes[place + 1].clone()),
            ..Edge::default()
        });
        Order {
            header,
            order_id: self.id.clone(),
            order_update_id: self.update_id,
            nodes: nodes.collect(),
            edges: edges.collect(),
            ..Order::default()
        }
    }

    fn actions(&self, place: usize) -> Vec<Action> {
        let stops = self.stops.iter().filter(|stop| stop.place == place);
        let actions = stops.map(|stop| Action {
            action_type: stop.kind.to_owned(),
            action_id: format!("{}-{}", self.id, stop.kind),
            blocking_type: BlockingType::Hard,
            ..Action::default()
        });
        actions.collect()
    }
}
