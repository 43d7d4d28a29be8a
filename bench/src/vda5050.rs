//! `regatta-bench vda5050`: a virtual fleet of VDA 5050 on a broker: the processor time of the
//! plugin, whether states come on time, and the time from an order to the first movement. The bar
//! for 1,000 vehicles is 30 % of a core, and 100 ms for 99 of 100 orders.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant, SystemTime};

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{Experiment, check_interrupt, seconds_parser, temporary_folder, write};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta::supervisor::Supervisor;
use regatta_base::random::Random;
use regatta_base::thousands;
use regatta_layout::generate::Warehouse;
use regatta_layout::{NodeIndex, ReadOptions, RouteGraph, parse};
use regatta_vda5050::broker::{Broker, BrokerUrl, Delivery, Incoming, Session};
use regatta_vda5050::message::{
    Edge, Header, Node, Order, State, Topic, Version, decode, encode, timestamp,
};
use serde_json::{Value, json};

use crate::reading::processor_secs_of;

/// A load.
struct Load {
    vehicles: u32,
    /// Vehicles above which all share one connection.
    shared_above: u32,
}

const LOADS: [Load; 3] = [
    Load { vehicles: 1_000, shared_above: 10_000 },
    Load { vehicles: 5_000, shared_above: 10_000 },
    Load { vehicles: 20_000, shared_above: 10_000 },
];
/// The warehouse in which the vehicles drive.
const WAREHOUSE: Warehouse = Warehouse { aisles: 96, rows: 72, bays: 6 };
const SCENARIO: &str = "vda5050.yaml";
const MANUFACTURER: &str = "regatta";
/// The time between two states without an event, as the plugin has it by default.
const STATE_SECS: f64 = 1.0;
/// A state that comes later than this after the last one is late, in seconds.
const LATE_SECS: f64 = 1.5;
/// Orders a second.
const ORDERS_HZ: f64 = 25.0;
/// The longest time until all vehicles stand at a node.
const LONGEST: Duration = Duration::from_secs(120);
/// The time between two looks for messages.
const POLL: Duration = Duration::from_micros(500);
/// The bars of the first load.
const CORES: f64 = 0.3;
const MOVEMENT_MILLIS: f64 = 100.0;

#[derive(Args)]
pub struct Vda5050Args {
    #[command(flatten)]
    output: Output,
    /// Seconds for which each load is measured.
    #[arg(long, default_value_t = 20, value_parser = seconds_parser())]
    secs: u64,
}

/// The figures of a load.
struct Figures {
    vehicles: u32,
    connections: u32,
    /// Processor time of the plugin by wall time.
    cores: f64,
    states_per_sec: f64,
    /// The part of the states that came late.
    late_states: f64,
    /// Milliseconds from an order to the first state in which the vehicle drives, from the
    /// smallest on.
    movements: Vec<f64>,
    orders: usize,
    late_ticks: u64,
}

impl Figures {
    fn movement(&self, part: f64) -> f64 {
        let last = self.movements.len().saturating_sub(1);
        self.movements.get((last as f64 * part).round() as usize).copied().unwrap_or(f64::NAN)
    }

    fn json(&self) -> Value {
        json!({
            "vehicles": self.vehicles, "connections": self.connections, "cores": self.cores,
            "states_per_sec": self.states_per_sec, "late_states": self.late_states,
            "orders": self.orders, "moved": self.movements.len(),
            "movement_p50_ms": self.movement(0.5), "movement_p99_ms": self.movement(0.99),
            "late_ticks": self.late_ticks,
        })
    }
}

pub fn run(program: &Program, args: &Vda5050Args) -> Result<ExitCode, Failure> {
    args.output.check("vda5050")?;
    let folder = temporary_folder()?;
    let yaml = WAREHOUSE.generate()?;
    write(&folder.path().join("warehouse.yaml"), &yaml)?;
    write(
        &folder.path().join(SCENARIO),
        "graph: warehouse.yaml\nseed: 1\nrate: 50\nrobots: [{count: 1, routes: none}]\n",
    )?;
    let (graph, _) = parse(&yaml, "warehouse", &ReadOptions::default())
        .map_err(|error| format!("the warehouse can't be read: {error}"))?;
    let ways = Ways::of(&graph);
    let time = Duration::from_secs(args.secs);
    let mut figures = Vec::new();
    for load in &LOADS {
        figures.push(measure(program, folder.path(), load, &ways, time)?);
    }
    let (line, machine) = environment(program);
    let loads: Vec<Value> = figures.iter().map(Figures::json).collect();
    let json = json!({"machine": machine, "secs": args.secs, "loads": loads});
    let markdown = markdown(&figures, &line);
    args.output.write(&Report { name: "vda5050", markdown, json, plot: None })?;
    Ok(ExitCode::SUCCESS)
}

/// The edges that leave each node, by the ids of orders.
struct Ways {
    by_origin: HashMap<String, Vec<Way>>,
}

/// An edge and its end.
struct Way {
    edge: String,
    end: String,
}

impl Ways {
    fn of(graph: &RouteGraph) -> Self {
        let mut by_origin: HashMap<String, Vec<Way>> = HashMap::new();
        for edge in graph.edges() {
            let id = edge.name().map_or_else(|| edge.id.to_string(), str::to_owned);
            let way = Way { edge: id, end: node_name(graph, edge.destination) };
            by_origin.entry(node_name(graph, edge.origin)).or_default().push(way);
        }
        Self { by_origin }
    }
}

/// The name of a node, or else its id.
fn node_name(graph: &RouteGraph, node: NodeIndex) -> String {
    let node = graph.node(node);
    node.name().map_or_else(|| node.id.to_string(), str::to_owned)
}

fn measure(
    program: &Program,
    folder: &Path,
    load: &Load,
    ways: &Ways,
    time: Duration,
) -> Result<Figures, Failure> {
    let mut processes = Supervisor::default();
    let port = TcpListener::bind("127.0.0.1:0")?.local_addr()?.port();
    let url = start_mosquitto(&mut processes, port)?;
    let options = ["--robots", &load.vehicles.to_string()].map(str::to_owned);
    let mut experiment = Experiment::start(program, "vda5050", &folder.join(SCENARIO), &options)?;
    let mut command = program.command();
    command.args(["plugin", "vda5050", "--broker", &url, "--shared-above"]);
    command.arg(load.shared_above.to_string()).arg("--fleet").arg(experiment.fleet().as_str());
    let pid = processes.start("vda5050", command.stderr(Stdio::null()))?;
    let mut master = Master::connect(&url)?;
    master.wait_for(load.vehicles as usize)?;
    let (late, cpu) = (experiment.status()?.late_ticks, processor_secs_of(pid)?);
    let started = Instant::now();
    master.order_for(time, ways)?;
    let secs = started.elapsed().as_secs_f64();
    let cores = (processor_secs_of(pid)? - cpu) / secs;
    let late_ticks = experiment.status()?.late_ticks - late;
    processes.stop();
    experiment.finish()?;
    master.movements.sort_by(f64::total_cmp);
    Ok(Figures {
        vehicles: load.vehicles,
        connections: if load.vehicles > load.shared_above { 1 } else { load.vehicles },
        cores,
        states_per_sec: master.states as f64 / secs,
        late_states: master.late_states as f64 / (master.states as f64).max(1.0),
        movements: master.movements,
        orders: master.orders,
        late_ticks,
    })
}

/// Starts Mosquitto on a port of this machine, and returns its address.
fn start_mosquitto(processes: &mut Supervisor, port: u16) -> Result<String, Failure> {
    let path = ["/usr/sbin/mosquitto", "/usr/local/sbin/mosquitto", "/opt/homebrew/sbin/mosquitto"]
        .into_iter()
        .find(|path| Path::new(path).exists())
        .unwrap_or("mosquitto");
    let mut command = Command::new(path);
    command.args(["-p", &port.to_string()]).stdout(Stdio::null()).stderr(Stdio::null());
    processes
        .start("mosquitto", &mut command)
        .map_err(|_| "Mosquitto isn't installed: it is the broker of this measurement")?;
    let started = Instant::now();
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        check_interrupt()?;
        if started.elapsed() > LONGEST {
            return Err("Mosquitto doesn't listen".into());
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    Ok(format!("mqtt://127.0.0.1:{port}"))
}

/// A master that sends each vehicle to a next node, one edge at a time.
struct Master {
    broker: Broker,
    link: usize,
    vehicles: HashMap<String, Vehicle>,
    /// The serial numbers in the order in which they were heard first.
    serials: Vec<String>,
    states: usize,
    late_states: usize,
    orders: usize,
    movements: Vec<f64>,
}

/// A vehicle as its master knows it.
struct Vehicle {
    heard: SystemTime,
    last_node: String,
    errand: Errand,
}

/// The order of a vehicle.
enum Errand {
    /// It may get one.
    None,
    /// It was sent, and the vehicle doesn't drive yet.
    Sent { order_id: String, at: SystemTime },
    /// The vehicle has driven.
    UnderWay,
}

impl Master {
    fn connect(url: &str) -> Result<Self, Failure> {
        let url: BrokerUrl = url.parse().map_err(|error| format!("{error}"))?;
        let mut broker = Broker::start(url, None)?;
        let states = format!("{}/+/{}", prefix(), Topic::State.name());
        let client_id = format!("regatta-bench-{}", std::process::id());
        let link = broker.connect(&Session { client_id, will: None, topics: vec![states] });
        Ok(Self {
            broker,
            link,
            vehicles: HashMap::new(),
            serials: Vec::new(),
            states: 0,
            late_states: 0,
            orders: 0,
            movements: Vec::new(),
        })
    }

    /// Waits until so many vehicles stand at a node.
    fn wait_for(&mut self, vehicles: usize) -> Result<(), Failure> {
        let started = Instant::now();
        loop {
            check_interrupt()?;
            self.take();
            let ready = self.vehicles.values().filter(|vehicle| !vehicle.last_node.is_empty());
            let ready = ready.count();
            if ready == vehicles {
                (self.states, self.late_states) = (0, 0);
                return Ok(());
            }
            if started.elapsed() > LONGEST {
                return Err(format!("{ready} of {vehicles} vehicles stand at a node").into());
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Sends orders for a time.
    fn order_for(&mut self, time: Duration, ways: &Ways) -> Result<(), Failure> {
        let (started, random) = (Instant::now(), Random::new(1));
        let (mut draw, mut sent) = (0, 0.0);
        while started.elapsed() < time {
            check_interrupt()?;
            self.take();
            while sent < started.elapsed().as_secs_f64() * ORDERS_HZ {
                sent += 1.0;
                draw += 1;
                let serial = self.serials[random.below(draw, self.serials.len())].clone();
                self.order(&serial, ways);
            }
            std::thread::sleep(POLL);
        }
        Ok(())
    }

    /// Sends a vehicle that stands to a next node.
    fn order(&mut self, serial: &str, ways: &Ways) {
        let Some(vehicle) = self.vehicles.get_mut(serial) else { return };
        let ways = ways.by_origin.get(&vehicle.last_node);
        let (Errand::None, Some(way)) = (&vehicle.errand, ways.and_then(|ways| ways.first()))
        else {
            return;
        };
        self.orders += 1;
        let (at, order_id) = (SystemTime::now(), format!("order-{}", self.orders));
        let order = order(serial, &order_id, &vehicle.last_node, way, at, self.orders as u32);
        let topic = format!("{}/{serial}/{}", prefix(), Topic::Order.name());
        self.broker.publish(self.link, &topic, encode(&order, Version::V2_0), Delivery::Now);
        vehicle.errand = Errand::Sent { order_id, at };
    }

    fn take(&mut self) {
        while let Some(incoming) = self.broker.take() {
            let Incoming::Message { payload, time, .. } = incoming else { continue };
            if let Ok(state) = decode::<State>(&payload) {
                self.take_state(&state, time);
            }
        }
    }

    fn take_state(&mut self, state: &State, time: SystemTime) {
        let serial = &state.header.serial_number;
        self.states += 1;
        let Some(vehicle) = self.vehicles.get_mut(serial) else {
            self.serials.push(serial.clone());
            let last_node = state.last_node_id.clone();
            let vehicle = Vehicle { heard: time, last_node, errand: Errand::None };
            self.vehicles.insert(serial.clone(), vehicle);
            return;
        };
        let secs = time.duration_since(vehicle.heard).map_or(0.0, |time| time.as_secs_f64());
        self.late_states += usize::from(secs > LATE_SECS * STATE_SECS);
        vehicle.heard = time;
        vehicle.last_node.clone_from(&state.last_node_id);
        match &vehicle.errand {
            Errand::Sent { order_id, at } if state.driving && *order_id == state.order_id => {
                let millis = time.duration_since(*at).map_or(0.0, |time| time.as_secs_f64() * 1e3);
                self.movements.push(millis);
                vehicle.errand = Errand::UnderWay;
            }
            Errand::UnderWay if !state.driving && state.node_states.is_empty() => {
                vehicle.errand = Errand::None;
            }
            _ => {}
        }
    }
}

/// The first levels of the topics of vehicles.
fn prefix() -> String {
    let version = Version::V2_0;
    format!("{}/{}/{MANUFACTURER}", version.interface(), version.level())
}

/// An order from a node along an edge.
fn order(
    serial: &str,
    order_id: &str,
    from: &str,
    way: &Way,
    at: SystemTime,
    header_id: u32,
) -> Order {
    let header = Header {
        header_id,
        timestamp: timestamp(at),
        version: Version::V2_0.number().to_owned(),
        manufacturer: MANUFACTURER.to_owned(),
        serial_number: serial.to_owned(),
    };
    let mut nodes = Vec::new();
    for (sequence_id, node_id) in [(0, from), (2, &way.end)] {
        let node_id = node_id.to_owned();
        nodes.push(Node { node_id, sequence_id, released: true, ..Node::default() });
    }
    let edge = Edge {
        edge_id: way.edge.clone(),
        sequence_id: 1,
        released: true,
        start_node_id: Some(from.to_owned()),
        end_node_id: Some(way.end.clone()),
        ..Edge::default()
    };
    Order { header, order_id: order_id.to_owned(), nodes, edges: vec![edge], ..Order::default() }
}

fn markdown(figures: &[Figures], environment: &str) -> String {
    let mut text = format!(
        "# VDA 5050: a virtual fleet on a broker\n\n{environment}\n\nEngine (50 ticks a second), \
         plugin, Mosquitto and a master are separate processes of this machine; each vehicle \
         publishes a state a second and a position five times a second. A state is late \
         {LATE_SECS} s after the last one. A core is one second of processor time per second of \
         wall time. Bars for 1,000 vehicles: {CORES} cores, {MOVEMENT_MILLIS:.0} ms for 99 of 100 \
         orders.\n\n\
         | vehicles | connections | plugin (cores) | states/s | late states | orders that moved | \
         order to movement p50, p99 (ms) | late ticks |\n|---|---|---|---|---|---|---|---|\n"
    );
    for load in figures {
        let _ = writeln!(
            text,
            "| {} | {} | {:.2} | {} | {:.2} % | {} of {} | {:.0}, {:.0} | {} |",
            thousands(load.vehicles.into()),
            thousands(load.connections.into()),
            load.cores,
            thousands(load.states_per_sec.round() as u64),
            load.late_states * 100.0,
            load.movements.len(),
            load.orders,
            load.movement(0.5),
            load.movement(0.99),
            load.late_ticks,
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn movements_are_percentiles() {
        let figures = Figures {
            vehicles: 1_000,
            connections: 1,
            cores: 0.25,
            states_per_sec: 1_040.2,
            late_states: 0.001,
            movements: (0..=100).map(f64::from).collect(),
            orders: 102,
            late_ticks: 0,
        };
        assert_eq!((figures.movement(0.5), figures.movement(0.99)), (50.0, 99.0));
        let row = "| 1,000 | 1 | 0.25 | 1,040 | 0.10 % | 101 of 102 | 50, 99 | 0 |";
        assert!(markdown(&[figures], "here").contains(row));
    }
}
