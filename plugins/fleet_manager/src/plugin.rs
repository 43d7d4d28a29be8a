//! The plugin: frames in, commands and the order log out.

use std::collections::BTreeMap;
#[cfg(feature = "shared-memory")]
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use regatta_base::{grouped, thousands};
use regatta_plugin::column::{BATTERY, TYPE};
use regatta_plugin::command::RouteLeg;
use regatta_plugin::event::{BASE_WANTED, EventKind};
use regatta_plugin::frame::RobotState;
use regatta_plugin::manager::{ManagerAnswer, ManagerResponse};
use regatta_plugin::order::OrderRecord;
use regatta_plugin::ports::orders::OrderPublisher;
use regatta_plugin::{
    ClosureReader, ColumnReader, CommandError, Commands, Error, Events, Frame, LOAD_VARIABLE,
    ManagerServer, OpenError, Options, Ownership, Participant, Plugin, Rate, Result, World, tell,
};

use crate::charging::{Charging, ChargingSettings};
use crate::columns::ManagerColumns;
use crate::facilities::{Ask, Facilities, FacilityCommand};
use crate::manager::Manager;
use crate::order_log::OrderLog;
pub use crate::planner::PlannerKind;
use crate::planner::{Backstop, BackstopSettings, Planner};
use crate::rehearsal::Rehearsal;
use crate::roads::{Leg, Roads, default_cache_folder};
use crate::run_figures::{Doing, RunFigures};
use crate::steering::{Command, Settings};
use crate::traffic::BaseEnds;
use crate::work::Work;
use regatta_orders::{InTurn, OrderPool, OrderSettings, Places, StorageFill};

/// Makes a planner for the roads of a world.
type PlannerFactory = Box<dyn FnMut(&Roads) -> Box<dyn Planner>>;

/// The groups of options in the help.
const PLANNING: &str = "Planning";
const WEB: &str = "Web API";
const OUTPUT: &str = "Output";

/// The command line of `regatta plugin fleet-manager`.
#[derive(Clone, Debug, Parser)]
#[command(about = "Carry out transport orders, with robots that never touch each other")]
pub struct Cli {
    /// The orders.
    #[command(flatten)]
    pub orders: OrderSettings,
    /// Keep the computed roads of large worlds in this folder, so that the next start is faster
    /// [default: the user's cache folder]
    #[arg(long, value_name = "FOLDER", help_heading = PLANNING)]
    pub cache: Option<PathBuf>,
    /// Compute the roads of large worlds at each start
    #[arg(long, conflicts_with = "cache", help_heading = PLANNING)]
    pub no_cache: bool,
    /// Planner that chooses the routes of robots
    #[arg(long, value_name = "NAME", value_enum, default_value_t, help_heading = PLANNING)]
    pub planner: PlannerKind,
    /// Release only whole edges, for robots that stop only at nodes
    #[arg(long, help_heading = PLANNING)]
    pub whole_edges: bool,
    /// Seconds from a frame until a command that answers it takes effect
    #[arg(long, value_name = "SECONDS", value_parser = latency, help_heading = PLANNING)]
    pub latency: Option<f32>,
    /// Let robots drive through each other: an upper bound for any fleet manager
    #[arg(long, hide = true)]
    pub no_conflicts: bool,
    /// Give orders to robots in turn, wherever they are, so that an endless load sends each robot
    /// to random nodes
    #[arg(long, hide = true)]
    pub in_turn: bool,
    /// Serve no orders over HTTP, not even at a Unix socket of this user
    #[arg(long, conflicts_with = "http", help_heading = WEB)]
    pub no_http: bool,
    /// At the end, write the figures to this file as JSON
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub json: Option<PathBuf>,
    /// At the end, print the figures
    #[arg(long, help_heading = OUTPUT)]
    pub summary: bool,
    /// Options of every plugin.
    #[command(flatten)]
    pub options: Options,
}

fn latency(text: &str) -> Result<f32, String> {
    let seconds = text.parse().ok().filter(|seconds| (0.0..=60.0).contains(seconds));
    seconds.ok_or_else(|| "give seconds, from 0 to 60".to_owned())
}

impl Cli {
    /// The places where bases may end.
    fn ends(&self) -> BaseEnds {
        if self.whole_edges { BaseEnds::Nodes } else { BaseEnds::Anywhere }
    }

    /// The settings of steering, with those of the command line.
    fn steering(&self, settings: Settings) -> Settings {
        let latency_secs = self.latency.unwrap_or(settings.latency_secs);
        Settings { conflicts: !self.no_conflicts, ends: self.ends(), latency_secs, ..settings }
    }
}

/// Runs the plugin with a command line, whose first argument is the name of the program.
///
/// # Errors
/// Fails if an option is invalid, a file can't be used, the fleet has a manager already, or as
/// [`regatta_plugin::run`] does.
#[cfg(feature = "shared-memory")]
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    run(args, None)
}

/// Returns the plugin of a command line, to run it beside others in one process.
///
/// # Errors
/// Fails if an option is invalid, or a file can't be read.
pub fn plugin(cli: Cli) -> Result<impl Plugin> {
    let manager = FleetManager::new(cli, None);
    manager.order_settings().check()?;
    Ok(manager)
}

/// As [`run_from`], with a planner of your own instead of one that the command line names. A new
/// planner is made for each world.
///
/// # Errors
/// As [`run_from`].
#[cfg(feature = "shared-memory")]
pub fn run_with<A, F, P>(args: impl IntoIterator<Item = A>, mut planner: F) -> Result
where
    A: Into<OsString> + Clone,
    F: FnMut(&Roads) -> P + 'static,
    P: Planner + 'static,
{
    run(args, Some(Box::new(move |roads: &Roads| Box::new(planner(roads)))))
}

#[cfg(feature = "shared-memory")]
fn run<A: Into<OsString> + Clone>(
    args: impl IntoIterator<Item = A>,
    planner: Option<PlannerFactory>,
) -> Result {
    regatta_kit::run_from(args, |mut cli: Cli| {
        #[cfg(feature = "http")]
        if !cli.no_http {
            cli.orders.serve_at_socket_of(&cli.options.fleet);
        }
        let manager = FleetManager::new(cli, planner);
        // An error is reported now, and not only when there is an engine.
        manager.order_settings().check()?;
        manager.cli.options.clone().run(manager, "fleet-manager")
    })
}

/// The plugin's ports in the fleet.
struct Ports {
    _ownership: Ownership,
    commands: Commands,
    orders: OrderPublisher,
    columns: ManagerColumns,
    types: ColumnReader,
    batteries: ColumnReader,
    closures: ClosureReader,
    requests: ManagerServer,
    work: Work,
}

/// The state between a new world and its first frame: the manager begins at the time of the frame.
struct Opening {
    roads: Arc<Roads>,
    places: Arc<Places>,
    run_id: u64,
    charging: Charging,
    facilities: Facilities,
}

/// The fleet manager.
struct FleetManager {
    cli: Cli,
    /// Makes a user's own planner.
    own_planner: Option<PlannerFactory>,
    ports: Option<Ports>,
    opening: Option<Opening>,
    manager: Option<Manager>,
    /// The run of the last world.
    run_id: u64,
    log: OrderLog,
    /// Robots by the tokens of commands that aren't answered yet.
    pending: BTreeMap<u64, u32>,
    figures: RunFigures,
    /// The activity of each robot of the last frame, by id.
    doing: Vec<Doing>,
    /// Whether the last frame belongs to the warm-up of the run.
    is_warm_up: bool,
    /// Whether it is a process of its own, whose messages reach the user.
    is_process: bool,
}

impl FleetManager {
    fn new(cli: Cli, own_planner: Option<PlannerFactory>) -> Self {
        Self {
            cli,
            own_planner,
            ports: None,
            opening: None,
            manager: None,
            run_id: 0,
            log: OrderLog::default(),
            pending: BTreeMap::new(),
            figures: RunFigures::default(),
            doing: Vec::new(),
            is_warm_up: false,
            is_process: false,
        }
    }

    fn order_settings(&self) -> OrderSettings {
        let settings = self.cli.orders.clone();
        let load = settings.load.or_else(|| std::env::var_os(LOAD_VARIABLE).map(PathBuf::from));
        OrderSettings { load, ..settings }
    }

    fn roads(&self, world: &World<'_>) -> Roads {
        let folder =
            self.cli.cache.clone().or_else(default_cache_folder).filter(|_| !self.cli.no_cache);
        let Some(folder) = folder else { return Roads::new(world) };
        let (roads, kept) = Roads::cached(world, &folder);
        if let Err(error) = kept {
            tell!("fleet-manager: {error}");
        }
        roads
    }

    /// Opens the pool of orders, and begins to manage the robots of a frame.
    fn begin(&mut self, opening: Opening, frame: &Frame<'_>) -> Result {
        let Opening { roads, places, run_id, charging, facilities } = opening;
        let now_secs = frame.sim_time().as_secs_f64();
        let mut orders = OrderPool::open(&self.order_settings(), places, run_id, now_secs)
            .map_err(|error| Error::new(format_args!("{error}")))?;
        if self.cli.in_turn {
            orders.set_assigner(InTurn);
        }
        self.log = OrderLog::new(orders.open_orders(), orders.places());
        if let Some(address) = orders.http_address() {
            let token = self.cli.orders.token_place();
            tell!("fleet-manager: orders at http://{address}, with the token of {token}");
        }
        let (planner, settings) = match &mut self.own_planner {
            Some(planner) => {
                let backstop = Backstop::new(planner(&roads), BackstopSettings::default());
                (Box::new(backstop) as Box<dyn Planner>, Settings::default())
            }
            None => self.planner(&roads, &orders, frame)?,
        };
        let settings = self.cli.steering(settings);
        let manager = Manager::new(roads, planner, settings, orders);
        self.manager = Some(manager.with_charging(charging).with_facilities(facilities));
        Ok(())
    }

    /// Makes the planner of the command line, and returns the settings of steering for it. The
    /// automatic choice is rehearsed.
    fn planner(
        &mut self,
        roads: &Arc<Roads>,
        orders: &OrderPool,
        frame: &Frame<'_>,
    ) -> Result<(Box<dyn Planner>, Settings)> {
        let is_in_turn = self.cli.in_turn;
        let make_orders = |number| {
            let mut orders = orders.for_rehearsal(number);
            if is_in_turn {
                orders.set_assigner(InTurn);
            }
            orders
        };
        let types = match &mut self.ports {
            Some(ports) => {
                ports.types.latest()?;
                ports.types.current()?.map_or(Vec::new(), |types| types.values.to_vec())
            }
            None => Vec::new(),
        };
        let columns = frame.columns();
        let rehearsal = Rehearsal::new(roads, &make_orders, &columns, &types)
            .beginning_at(frame.sim_time().as_secs_f64())
            .with_ends(self.cli.ends());
        let rehearsal = if self.is_process { rehearsal.telling() } else { rehearsal };
        let is_there = |state: &&u8| **state != RobotState::Absent as u8;
        let robots = columns.state.iter().filter(is_there).count();
        Ok(self.cli.planner.planner(roads, robots, Some(&rehearsal)))
    }

    /// At the end of a warm-up, the current rate of orders begins.
    fn note_warm_up(&mut self, frame: &Frame<'_>) {
        let was_warm_up = std::mem::replace(&mut self.is_warm_up, frame.header().is_warm_up());
        if let Some(manager) = self.manager.as_mut().filter(|_| was_warm_up && !self.is_warm_up) {
            manager.orders_mut().begin_rate(frame.sim_time().as_secs_f64());
        }
    }

    /// Collects the manager's commands to robots.
    fn collect(
        sender: &mut Commands,
        pending: &mut BTreeMap<u64, u32>,
        commands: &[Command],
        roads: &Roads,
    ) {
        for command in commands {
            let (token, robot) = match command {
                Command::Route { robot, legs } => {
                    let legs: Vec<RouteLeg> =
                        legs.iter().map(|leg| route_leg(*leg, roads).horizon()).collect();
                    (sender.extend(*robot, &legs), *robot)
                }
                Command::Release { robot, leg, metres } => {
                    (sender.release(*robot, route_leg(*leg, roads), *metres), *robot)
                }
                Command::Cancel { robot } => (sender.cancel(*robot), *robot),
            };
            pending.insert(token, robot);
        }
    }

    /// Sends the commands. Those that can't be sent now are sent with the next ones.
    fn send(sender: &mut Commands) -> Result {
        match sender.send() {
            Ok(())
            | Err(
                CommandError::Full { .. }
                | CommandError::NoEngine { .. }
                | CommandError::MemoryFull,
            ) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Answers the requests of other processes since the last call.
    fn answer(ports: &mut Ports, manager: Option<&mut Manager>, run_id: u64) -> Result {
        match manager {
            Some(manager) => ports.requests.answer(|request| manager.request(request, run_id))?,
            None => ports
                .requests
                .answer(|request| ManagerResponse::new(request, ManagerAnswer::NotReady, 0))?,
        }
        Ok(())
    }

    fn publish_orders(
        ports: &mut Ports,
        log: &mut OrderLog,
        figures: &mut RunFigures,
        manager: &mut Manager,
        frame: &Frame<'_>,
    ) -> Result {
        let places = manager.orders().places().clone();
        let events = manager.orders_mut().events().inspect(|event| figures.take(event));
        let records: Vec<OrderRecord> = events.map(|event| log.record(&event, &places)).collect();
        if !records.is_empty() || ports.orders.has_unsent() {
            ports.orders.publish(frame.run_id(), frame.tick(), 0, &records)?;
        }
        Ok(())
    }

    /// Prints and writes the figures of the run.
    fn report(&self) -> Result {
        let Some(manager) = &self.manager else { return Ok(()) };
        let (figures, run) = (manager.orders().figures(self.figures.now_secs), &self.figures);
        if self.cli.summary {
            let (mean, longest) = (run.mean_cycle_ms(), run.longest_cycle_ms());
            print!(
                "robots        {} for {} simulated seconds\n{}{}{}cycles        {mean:.2} ms on \
                 average, {longest:.1} ms at most\n",
                thousands(run.robots as u64),
                grouped(run.now_secs, 0),
                figures.table(),
                storage_lines(&manager.orders().storages()),
                run.table()
            );
        }
        if let Some(path) = &self.cli.json {
            let mut json = figures.json();
            json["run"] = run.json();
            let storages = manager.orders().storages();
            if !storages.is_empty() {
                json["storages"] = serde_json::to_value(storages).unwrap_or_default();
            }
            let text = format!("{json:#}\n");
            std::fs::write(path, text).map_err(|error| {
                Error::new(format_args!(
                    "can't write {} ({error}); choose another file with --json",
                    path.display()
                ))
            })?;
        }
        Ok(())
    }
}

impl Plugin for FleetManager {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        // First, so that no robot moves before others are told.
        let ownership = Ownership::claim(fleet).map_err(only_one)?;
        self.is_process = !fleet.is_local();
        self.ports = Some(Ports {
            _ownership: ownership,
            commands: Commands::open_on(fleet)?,
            orders: OrderPublisher::open_on(fleet).map_err(only_one)?,
            columns: ManagerColumns::open_on(fleet)?,
            types: ColumnReader::open_on(fleet, TYPE.name())?,
            batteries: ColumnReader::open_on(fleet, BATTERY.name())?,
            closures: ClosureReader::open_on(fleet)?,
            requests: ManagerServer::open_on(fleet)?,
            work: Work::open_on(fleet)?,
        });
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.report()?;
        // A store and an address are free again only when the pool that uses them is dropped.
        self.manager = None;
        self.pending.clear();
        self.run_id = world.run_id();
        let start = Instant::now();
        let roads = Arc::new(self.roads(world));
        let places = Arc::new(Places::of(world));
        let charging = Charging::new(world, ChargingSettings::default());
        let facilities = Facilities::new(world);
        self.opening =
            Some(Opening { roads, places, run_id: world.run_id(), charging, facilities });
        self.figures = RunFigures::begin(start.elapsed());
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        if let Some(opening) = self.opening.take() {
            let start = Instant::now();
            self.begin(opening, frame)?;
            self.figures.add_start(start.elapsed());
        }
        self.note_warm_up(frame);
        let (Some(ports), Some(manager)) = (&mut self.ports, &mut self.manager) else {
            return Ok(());
        };
        let start = Instant::now();
        Self::answer(ports, Some(manager), frame.run_id())?;
        ports.types.latest()?;
        let types = ports.types.current()?.map_or(&[][..], |types| types.values);
        ports.batteries.latest()?;
        let charges =
            ports.batteries.current()?.filter(|charges| charges.header.run_id == frame.run_id());
        let charges = charges.map_or(&[][..], |charges| charges.values);
        let (now_secs, columns) = (frame.sim_time().as_secs_f64(), frame.columns());
        let secs = now_secs - self.figures.now_secs;
        self.figures
            .see(now_secs, frame.len(), |robot| columns.state[robot] != RobotState::Absent as u8);
        let roads = manager.steering().roads().clone();
        ports.closures.take()?;
        manager.close_edges(ports.closures.closed(frame.run_id()));
        let commands = manager.cycle(now_secs, &columns, types, charges);
        Self::collect(&mut ports.commands, &mut self.pending, commands, &roads);
        for command in manager.request_facilities(now_secs) {
            request(&mut ports.commands, *command);
        }
        Self::send(&mut ports.commands)?;
        for warning in manager.take_warnings() {
            tell!("fleet-manager: warning: {warning}");
        }
        manager.show_vehicles(&columns, charges);
        manager.orders_mut().publish(now_secs);
        // If this manager is killed, the next one goes on from the store: records of what isn't in
        // there would contradict those of the next one.
        manager.orders().settle();
        let logged = Self::publish_orders(ports, &mut self.log, &mut self.figures, manager, frame);
        self.doing.clear();
        self.doing.extend((0..).zip(columns.speed).zip(columns.state).map(
            |((robot, speed), state)| manager.doing(robot, RobotState::from_number(*state), *speed),
        ));
        let present = self
            .doing
            .iter()
            .zip(columns.state)
            .filter(|(_, state)| **state != RobotState::Absent as u8);
        let present = present.map(|(doing, _)| *doing);
        self.figures.spend(secs.max(0.0), present.clone());
        // Full shared memory ends neither the work on orders nor their store.
        logged?;
        ports.columns.publish(frame, manager, &self.doing, start.elapsed())?;
        if ports.work.is_due(frame) {
            let orders = manager.orders().figures(now_secs);
            ports.work.publish(frame, &orders, &self.figures, present)?;
        }
        self.figures.end_cycle(start.elapsed());
        Ok(())
    }

    fn on_idle(&mut self, _has_producer: bool) -> Result {
        let Some(ports) = &mut self.ports else { return Ok(()) };
        ports.orders.update();
        ports.columns.update();
        ports.work.update();
        // The clock may be paused: requests are answered all the same.
        Self::answer(ports, self.manager.as_mut(), self.run_id)
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        let Some(manager) = &mut self.manager else { return Ok(()) };
        for event in events.records {
            match event.kind() {
                Some(EventKind::Accepted) => {
                    self.pending.remove(&event.token);
                }
                Some(EventKind::Refused) => {
                    if let Some(robot) = self.pending.remove(&event.token) {
                        manager.refuse(robot);
                    }
                }
                Some(EventKind::WaitingForRelease) if event.detail == BASE_WANTED => {
                    manager.lengthen_base(event.robot);
                }
                Some(EventKind::ActionFailed) => manager.fail_action(event.robot),
                _ => {}
            }
        }
        Ok(())
    }

    fn wants_events(&self) -> bool {
        true
    }

    fn rate(&self) -> Rate {
        Rate::PerSecond(10.0)
    }

    fn on_stop(&mut self) -> Result {
        self.report()
    }
}

/// Replaces the errors of a second manager: the process that owns the movement and writes the order
/// log is the first.
fn only_one(error: OpenError) -> Error {
    match error {
        OpenError::Owned { fleet, owner } | OpenError::Taken { fleet, owner, .. } => {
            Error::new(format_args!(
                "fleet '{fleet}' has a fleet manager already, {owner}; stop that one first"
            ))
        }
        error => error.into(),
    }
}

/// The places of storages at the end of a run, a line each.
fn storage_lines(storages: &[StorageFill]) -> String {
    let lines = storages.iter().map(|storage| format!("storage       {storage}\n"));
    lines.collect()
}

/// Adds a request of a door or a lift to the commands.
fn request(sender: &mut Commands, FacilityCommand { robot, ask }: FacilityCommand) {
    match ask {
        Ask::Door(edge) => sender.request_door(robot, edge),
        Ask::ReleaseDoor(edge) => sender.release_door(robot, edge),
        Ask::Lift(node) => sender.call_lift(robot, node),
        Ask::ReleaseLift(node) => sender.release_lift(robot, node),
    };
}

fn route_leg(leg: Leg, roads: &Roads) -> RouteLeg {
    let edge = roads.edge(leg.edge()).id;
    if leg.is_reverse() { RouteLeg::reverse(edge) } else { RouteLeg::forward(edge) }
}
