//! `regatta command`: sends one command to a running fleet, and waits for the answer.

use std::time::Duration;

use clap::{Args, Subcommand};
use regatta_kit::{Dispatcher, find_edge, find_leg, find_node};
use regatta_plugin::command::RouteLeg;
use regatta_plugin::event::EventRecord;
use regatta_plugin::manager::{ManagerAnswer, ManagerResponse};
use regatta_plugin::order::NO_ROBOT;
use regatta_plugin::{Commands, ManagerClient};

use crate::control::Target;
use crate::facilities::{door_edge, lift_node};
use crate::failure::Failure;

/// The time within which a running fleet answers.
const TIMEOUT: Duration = Duration::from_secs(5);

#[derive(Subcommand)]
/// The subcommands of `regatta command`.
pub enum RobotCommand {
    /// Give a robot a new route: the fastest one to a node, or along listed edges.
    Assign {
        #[command(flatten)]
        robot: Robot,
        /// Node to drive to, by id or name.
        #[arg(required_unless_present = "edges", conflicts_with = "edges")]
        node: Option<String>,
        #[command(flatten)]
        edges: Edges,
        /// Allow reverse gear on the route to a node.
        #[arg(long)]
        reverse: bool,
    },
    /// Add edges to a robot's released base; they replace its horizon.
    Extend {
        #[command(flatten)]
        robot: Robot,
        #[command(flatten)]
        edges: Edges,
    },
    /// Release the horizon of a robot, up to a number of metres along an edge.
    #[command(allow_negative_numbers = true)]
    Release {
        #[command(flatten)]
        robot: Robot,
        /// Edge of the route, by id, name or its nodes as FROM..TO; `-EDGE` in reverse gear.
        edge: String,
        /// Metres from where the robot enters the edge; inf for all of it.
        metres: f32,
    },
    /// Make a robot brake, and keep it standing until it is resumed.
    Hold(Robot),
    /// Let a held robot continue.
    Resume(Robot),
    /// Drop a robot's route beyond its current edge.
    Cancel(Robot),
    /// Remove a robot from the fleet.
    Remove(Robot),
    /// Make a robot break down.
    Break(Robot),
    /// Repair a robot that is broken.
    Repair(Robot),
    /// Close an edge: no robot enters it, robots on it leave it, and no new route leads along it.
    Close(Edge),
    /// Open a closed edge again.
    Open(Edge),
    /// Open a door, and keep it open for ten seconds.
    Door {
        /// Door, by name.
        door: String,
        /// End the request instead.
        #[arg(long)]
        release: bool,
        #[command(flatten)]
        target: Target,
    },
    /// Call a lift to a level, where it stays for at least ten seconds.
    Lift {
        /// Lift, by name.
        lift: String,
        /// Level, by name.
        level: String,
        /// End the call instead.
        #[arg(long)]
        release: bool,
        #[command(flatten)]
        target: Target,
    },
    /// Ask the fleet manager to send a robot to a node; a robot with a load finishes its order
    /// first.
    Send {
        #[command(flatten)]
        robot: Robot,
        /// Node to drive to, by id or name.
        node: String,
    },
    /// Ask the fleet manager to cancel a `send`, so that the robot gets orders again.
    Recall(Robot),
    /// Add a robot, on a node or on an edge.
    Spawn {
        /// Node to stand on, by id or name.
        #[arg(required_unless_present = "edge", conflicts_with = "edge")]
        node: Option<String>,
        /// Edge to stand on, by id, name or its nodes as FROM..TO.
        #[arg(long)]
        edge: Option<String>,
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

impl From<RobotsCommand> for RobotCommand {
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

/// An edge of a fleet's route graph.
#[derive(Args)]
pub struct Edge {
    /// Edge, by id, name or its nodes as FROM..TO.
    edge: String,
    #[command(flatten)]
    target: Target,
}

/// The edges of a route.
#[derive(Args)]
pub struct Edges {
    /// Edges in order, with commas between them, by id, name or their nodes as FROM..TO; `-EDGE` in
    /// reverse gear.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    edges: Vec<String>,
}

impl Edges {
    /// Returns the legs on the edges of a fleet.
    fn legs(&self, fleet: &Dispatcher) -> Result<Vec<RouteLeg>, Failure> {
        let legs = self.edges.iter().map(|edge| leg(fleet, edge));
        legs.collect()
    }
}

/// Runs `regatta command`.
pub fn run(command: RobotCommand) -> Result<(), Failure> {
    match command {
        RobotCommand::Assign { robot: Robot { robot, target }, node, edges, reverse } => {
            let mut fleet = join(&target)?;
            print_event(&match node {
                Some(node) => fleet.send_to(robot, |world| find_node(world, &node), reverse)?,
                None => {
                    let legs = edges.legs(&fleet)?;
                    fleet.send(|commands| commands.assign(robot, &legs))?
                }
            });
        }
        RobotCommand::Extend { robot, edges } => {
            let legs = edges.legs(&join(&robot.target)?)?;
            send(&robot, |commands, id| commands.extend(id, &legs))?;
        }
        RobotCommand::Release { robot, edge, metres } => {
            let leg = leg(&join(&robot.target)?, &edge)?;
            send(&robot, |commands, id| commands.release(id, leg, metres))?;
        }
        RobotCommand::Hold(robot) => send(&robot, Commands::hold)?,
        RobotCommand::Resume(robot) => send(&robot, Commands::resume)?,
        RobotCommand::Cancel(robot) => send(&robot, Commands::cancel)?,
        RobotCommand::Remove(robot) => send(&robot, Commands::remove)?,
        RobotCommand::Break(robot) => send(&robot, Commands::break_down)?,
        RobotCommand::Repair(robot) => send(&robot, Commands::repair)?,
        RobotCommand::Close(Edge { edge, target }) => {
            let mut fleet = join(&target)?;
            let edge = edge_id(&fleet, &edge)?;
            print_event(&fleet.send(|commands| commands.close_edge(edge))?);
        }
        RobotCommand::Open(Edge { edge, target }) => {
            let mut fleet = join(&target)?;
            let edge = edge_id(&fleet, &edge)?;
            print_event(&fleet.send(|commands| commands.open_edge(edge))?);
        }
        RobotCommand::Door { door, release, target } => {
            let mut fleet = join(&target)?;
            let edge = fleet.world(|world| door_edge(world, &door))??;
            print_event(&fleet.send(|commands| match release {
                true => commands.release_door(NO_ROBOT, edge),
                false => commands.request_door(NO_ROBOT, edge),
            })?);
        }
        RobotCommand::Lift { lift, level, release, target } => {
            let mut fleet = join(&target)?;
            let node = fleet.world(|world| lift_node(world, &lift, &level))??;
            print_event(&fleet.send(|commands| match release {
                true => commands.release_lift(NO_ROBOT, node),
                false => commands.call_lift(NO_ROBOT, node),
            })?);
        }
        RobotCommand::Send { robot: Robot { robot, target }, node } => {
            let node = node_id(&join(&target)?, &node)?;
            print_response(&ManagerClient::open(&target.fleet)?.send(robot, node)?);
        }
        RobotCommand::Recall(Robot { robot, target }) => {
            print_response(&ManagerClient::open(&target.fleet)?.recall(robot)?);
        }
        RobotCommand::Spawn { node, edge, at, robot_type, target } => {
            let mut fleet = join(&target)?;
            let robot_type = robot_type_index(&fleet, robot_type.as_deref())?;
            print_event(&match edge {
                Some(edge) => {
                    let edge = edge_id(&fleet, &edge)?;
                    fleet.send(|commands| commands.spawn_on_edge(robot_type, edge, at))?
                }
                None => {
                    let node = node_id(&fleet, &node.unwrap_or_default())?;
                    fleet.send(|commands| commands.spawn_at_node(robot_type, node))?
                }
            });
        }
    }
    Ok(())
}

fn send(robot: &Robot, command: impl FnOnce(&mut Commands, u32) -> u64) -> Result<(), Failure> {
    print_event(&join(&robot.target)?.send(|commands| command(commands, robot.robot))?);
    Ok(())
}

/// Returns the id of a node, by its id or name.
fn node_id(fleet: &Dispatcher, node: &str) -> Result<u32, Failure> {
    fleet.world(|world| Ok::<_, Failure>(world.nodes()[find_node(world, node)?].id))?
}

/// Returns the id of an edge, by its id, its name or its nodes.
fn edge_id(fleet: &Dispatcher, edge: &str) -> Result<u32, Failure> {
    Ok(fleet.world(|world| find_edge(world, edge))??)
}

/// Returns the leg on an edge; `-` before the edge is reverse gear.
fn leg(fleet: &Dispatcher, edge: &str) -> Result<RouteLeg, Failure> {
    Ok(fleet.world(|world| find_leg(world, edge))??)
}

fn join(target: &Target) -> Result<Dispatcher, Failure> {
    Ok(Dispatcher::join(&target.fleet, &format!("command-{}", std::process::id()), TIMEOUT)?)
}

/// Prints the fleet manager's answer.
fn print_response(response: &ManagerResponse) {
    match response.answer() {
        Some(ManagerAnswer::Later) => println!("accepted: when the robot has finished its order"),
        _ => println!("accepted"),
    }
}

/// Prints the answer to a command.
fn print_event(answer: &EventRecord) {
    match answer.robot {
        NO_ROBOT => println!("accepted"),
        robot => println!("accepted: robot {robot}"),
    }
}

/// Returns the index of a robot type by its name, or 0 without a name.
fn robot_type_index(fleet: &Dispatcher, name: Option<&str>) -> Result<u32, Failure> {
    let Some(name) = name else { return Ok(0) };
    fleet.world(|world| {
        let names: Vec<_> = world.robot_types().iter().map(|known| known.name()).collect();
        match names.iter().position(|other| *other == name) {
            Some(index) => Ok(index as u32),
            None => {
                let known = names.join(", ");
                Err(format!("no robot type is called '{name}'; there are {known}").into())
            }
        }
    })?
}
