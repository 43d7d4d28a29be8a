//! `regatta order`: sends one order to a robot of a running fleet, and waits for the answer.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::{Args, Subcommand};
use regatta_plugin::event::{EventKind, EventRecord, Refusal};
use regatta_plugin::order::RouteLeg;
use regatta_plugin::{EventReader, Orders, Participant, ReadError, WorldReader};

use crate::control::Target;
use crate::failure::Failure;
use crate::way::{find_node, way_to};

/// The time within which a running fleet answers.
const TIMEOUT: Duration = Duration::from_secs(5);

#[derive(Subcommand)]
pub enum OrderCommand {
    /// Give a robot a new route: the fastest one to a node, or along listed edges.
    Assign {
        #[command(flatten)]
        robot: Robot,
        /// Node to drive to, by id or name.
        #[arg(required_unless_present = "edges", conflicts_with = "edges")]
        node: Option<String>,
        #[command(flatten)]
        edges: Edges,
        /// Allow the way to a node to use reverse gear.
        #[arg(long)]
        reverse: bool,
    },
    /// Append edges to what a robot may drive, in place of what it plans.
    Extend {
        #[command(flatten)]
        robot: Robot,
        #[command(flatten)]
        edges: Edges,
    },
    /// Release what a robot plans, up to a number of metres along an edge.
    #[command(allow_negative_numbers = true)]
    Release {
        #[command(flatten)]
        robot: Robot,
        /// Edge of the route, `-ID` in reverse gear.
        #[arg(value_parser = leg)]
        edge: RouteLeg,
        /// Metres from where the robot enters the edge; inf for all of it.
        metres: f32,
    },
    /// Make a robot brake and stand.
    Hold(Robot),
    /// End a hold.
    Resume(Robot),
    /// Drop a robot's route beyond its current edge.
    Cancel(Robot),
    /// Remove a robot from the fleet.
    Remove(Robot),
    /// Make a robot break down.
    Break(Robot),
    /// Repair a robot that is broken.
    Repair(Robot),
    /// Add a robot, on a node or on an edge.
    Spawn {
        /// Node to stand on, by id or name.
        #[arg(required_unless_present = "edge", conflicts_with = "edge")]
        node: Option<String>,
        /// Edge to stand on, by id.
        #[arg(long)]
        edge: Option<u32>,
        /// Metres from the edge's origin.
        #[arg(long, default_value_t = 0.0, requires = "edge")]
        at: f32,
        /// Name of the robot type; the first by default.
        #[arg(long = "type")]
        robot_type: Option<String>,
        #[command(flatten)]
        target: Target,
    },
}

/// The commands of `regatta robots`.
#[derive(Subcommand)]
pub enum RobotsCommand {
    /// Make a robot break down.
    Break(Robot),
    /// Repair a robot that is broken.
    Repair(Robot),
}

impl From<RobotsCommand> for OrderCommand {
    fn from(command: RobotsCommand) -> Self {
        match command {
            RobotsCommand::Break(robot) => Self::Break(robot),
            RobotsCommand::Repair(robot) => Self::Repair(robot),
        }
    }
}

/// A robot of a fleet.
#[derive(Args)]
pub struct Robot {
    /// Robot, by id.
    robot: u32,
    #[command(flatten)]
    target: Target,
}

/// The edges of a route.
#[derive(Args)]
pub struct Edges {
    /// Edges in order, with commas between them; `-ID` in reverse gear.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, value_parser = leg)]
    edges: Vec<RouteLeg>,
}

pub fn run(command: OrderCommand) -> Result<ExitCode, Failure> {
    match command {
        OrderCommand::Assign { robot: Robot { robot, target }, node, edges, reverse } => {
            let fleet = Fleet::join(&target)?;
            let legs = match node {
                Some(node) => fleet.way(robot, &node, reverse)?,
                None => edges.edges,
            };
            fleet.send(|orders| orders.assign(robot, &legs))
        }
        OrderCommand::Extend { robot, edges } => send(&robot, |orders, id| orders.extend(id, &edges.edges)),
        OrderCommand::Release { robot, edge, metres } => send(&robot, |orders, id| orders.release(id, edge, metres)),
        OrderCommand::Hold(robot) => send(&robot, Orders::hold),
        OrderCommand::Resume(robot) => send(&robot, Orders::resume),
        OrderCommand::Cancel(robot) => send(&robot, Orders::cancel),
        OrderCommand::Remove(robot) => send(&robot, Orders::remove),
        OrderCommand::Break(robot) => send(&robot, Orders::break_down),
        OrderCommand::Repair(robot) => send(&robot, Orders::repair),
        OrderCommand::Spawn { node, edge, at, robot_type, target } => {
            let fleet = Fleet::join(&target)?;
            let robot_type = fleet.robot_type(robot_type.as_deref())?;
            match (node, edge) {
                (_, Some(edge)) => fleet.send(|orders| orders.spawn_on_edge(robot_type, edge, at)),
                (node, None) => {
                    let node = fleet.node_id(&node.unwrap_or_default())?;
                    fleet.send(|orders| orders.spawn_at_node(robot_type, node))
                }
            }
        }
    }
}

fn send(robot: &Robot, order: impl FnOnce(&mut Orders, u32) -> u64) -> Result<ExitCode, Failure> {
    Fleet::join(&robot.target)?.send(|orders| order(orders, robot.robot))
}

/// Parses an edge of a route.
fn leg(text: &str) -> Result<RouteLeg, String> {
    let (digits, leg): (_, fn(u32) -> RouteLeg) = match text.trim().strip_prefix('-') {
        Some(digits) => (digits, RouteLeg::reverse),
        None => (text.trim(), RouteLeg::forward),
    };
    digits.parse().map(leg).map_err(|_| "give the id of an edge, or -ID to drive it in reverse gear".to_owned())
}

/// A fleet that orders are sent to.
struct Fleet {
    participant: Participant,
    events: EventReader,
    orders: Orders,
}

impl Fleet {
    fn join(target: &Target) -> Result<Self, Failure> {
        let participant = Participant::join(&target.fleet, &format!("order-{}", std::process::id()))?;
        let events = EventReader::open_on(&participant)?;
        let orders = Orders::open_on(&participant)?;
        Ok(Self { participant, events, orders })
    }

    /// Sends an order, and prints the answer to it.
    fn send(mut self, order: impl FnOnce(&mut Orders) -> u64) -> Result<ExitCode, Failure> {
        let token = order(&mut self.orders);
        self.orders.send()?;
        let answer = self.answer(token)?;
        match answer.kind() {
            Some(EventKind::Accepted) => println!("accepted: robot {}", answer.robot),
            _ => return Err(refused(&answer).into()),
        }
        Ok(ExitCode::SUCCESS)
    }

    fn answer(&mut self, token: u64) -> Result<EventRecord, Failure> {
        let is_answer = |event: &&EventRecord| {
            event.token == token && matches!(event.kind(), Some(EventKind::Accepted | EventKind::Refused))
        };
        let start = Instant::now();
        while start.elapsed() < TIMEOUT {
            let mut answer = None;
            self.events.take(|tick| {
                answer = answer.or(tick.records.iter().find(is_answer).copied());
                Ok::<_, ReadError>(())
            })?;
            if let Some(answer) = answer {
                return Ok(answer);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        Err(format!(
            "the fleet has not answered within {} s; is it paused? It takes the order at its next tick",
            TIMEOUT.as_secs()
        )
        .into())
    }

    /// Calls `read` with the world.
    fn world<T>(&self, read: impl FnOnce(&regatta_plugin::World<'_>) -> Result<T, Failure>) -> Result<T, Failure> {
        let mut worlds = WorldReader::open_on(&self.participant)?;
        let start = Instant::now();
        loop {
            if let Some(world) = worlds.latest()? {
                return read(&world);
            }
            if start.elapsed() > TIMEOUT {
                return Err(format!("fleet '{}' has no world; is it running?", self.participant.fleet()).into());
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn way(&self, robot: u32, node: &str, reverse: bool) -> Result<Vec<RouteLeg>, Failure> {
        self.world(|world| way_to(&self.participant, world, robot, node, reverse))
    }

    fn node_id(&self, node: &str) -> Result<u32, Failure> {
        self.world(|world| Ok(world.nodes()[find_node(world, node)?].id))
    }

    fn robot_type(&self, name: Option<&str>) -> Result<u32, Failure> {
        let Some(name) = name else { return Ok(0) };
        self.world(|world| {
            let types = world.robot_types().iter().map(|robot_type| robot_type.name().to_owned());
            let names: Vec<_> = types.collect();
            let found = names.iter().position(|other| other == name);
            let unknown = || format!("no robot type is called '{name}'; there are {}", names.join(", "));
            Ok(found.ok_or_else(unknown)? as u32)
        })
    }
}

/// Says why an order was refused.
fn refused(answer: &EventRecord) -> String {
    use Refusal::*;
    let id = answer.id;
    let reasons = [
        (UnknownRobot, format!("there is no robot {id}")),
        (UnknownEdge, format!("there is no edge {id}")),
        (UnknownNode, format!("there is no node {id}")),
        (UnknownRobotType, format!("there is no robot type {id}")),
        (NotConnected, format!("edge {id} doesn't start where the route before it, or the robot's edge, ends")),
        (NoReverse, format!("edge {id} can't be driven in reverse gear")),
        (MalformedRoute, "the route has no edges".to_owned()),
        (DistanceOutOfRange, format!("the distance is not on edge {id}")),
        (FleetFull, "the fleet has reached its maximum size".to_owned()),
        (MalformedOrder, "the order is malformed".to_owned()),
        (NotSteerable, "this producer takes no orders; an engine does".to_owned()),
        (NotAhead, format!("edge {id} is not ahead in the robot's plan, or is released already")),
    ];
    let reason = reasons.into_iter().find(|(reason, _)| *reason as u32 == answer.detail);
    format!("refused: {}", reason.map_or_else(|| format!("reason {}", answer.detail), |(_, text)| text))
}
