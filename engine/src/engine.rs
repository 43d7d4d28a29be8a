//! A tick of the engine: take commands → step → publish.

mod disturbances;
mod footprint;
mod options;
mod population;
mod producer;
mod routes;
mod standing;
mod zone_room;

use std::sync::Arc;

use regatta_plugin::command::{Authority, CommandRecord};
use regatta_plugin::producer::Session;
use regatta_plugin::{FrameLoan, LocalFleet, Participant, ProducerPorts, RouteServer, services};

use crate::arc_length;
use crate::digest::Digest;
use crate::fleet::{EventBuffer, Fleet, FleetConfig, check_size};
use disturbances::Schedule;
pub use options::{EngineError, Options, PlacesTaken, Summary, WarmUp};
pub use population::{scenario_world, world};
use regatta_motion::Isa;
use regatta_motion::Tracks;
use regatta_scenario::{MAX_ROBOTS, Scenario};

/// The largest number of events that one tick publishes; the rest is counted.
const MAX_EVENTS: usize = 1 << 18;

/// One fleet, from its first frame to its last.
pub struct Engine {
    session: Session,
    simulation: Simulation,
}

/// The engine as a producer. This type computes everything that the engine publishes.
struct Simulation {
    scenario: Scenario,
    fleet: Fleet,
    routes: RouteServer,
    events: EventBuffer,
    /// The robot types that the column `type` last published.
    robot_types: Vec<u16>,
    tracks: Arc<Tracks>,
    commands: Vec<(u64, Authority, Vec<CommandRecord>)>,
    /// The commands of this tick, if a process reads the command log.
    command_log: Vec<CommandRecord>,
    /// The number of closures and openings when the closed edges were last published.
    closures_published: u64,
    /// The number of changes of doors and lifts when their states were last published.
    facilities_published: u64,
    /// Ticks with events since readers were last woken.
    unannounced_ticks: usize,
    last_tick: Option<u64>,
    digest: Option<Digest>,
    disturbances: Schedule,
    /// The tick from which on the column `battery` is published again.
    batteries_due: u64,
}

impl Engine {
    /// Compiles the scenario, opens the fleet's services and places the robots.
    ///
    /// # Errors
    /// If another producer of that fleet runs, shared memory can't be used, or the options don't
    /// fit the scenario or the machine.
    pub fn new(scenario: Scenario, mut options: Options) -> Result<Self, EngineError> {
        let lockstep = std::mem::take(&mut options.lockstep);
        let (speed, tick_period) = (options.speed, scenario.tick_period);
        let WarmUp { duration, plugins } = std::mem::take(&mut options.warm_up);
        let is_warm = !duration.is_zero() && !plugins.is_empty();
        let is_lockstep = !lockstep.names.is_empty() || is_warm;
        let participant = Participant::join(&options.fleet, NAME)?;
        let (ports, simulation) = open(scenario, &options, participant, is_lockstep)?;
        let session = Session::new(ports, tick_period, speed, lockstep);
        Ok(Self { session: session.warmed_up(duration, &plugins), simulation })
    }

    /// As [`new`](Self::new), in a local fleet: a driver calls [`begin`](Self::begin),
    /// [`advance`](Self::advance) and [`end`](Self::end), and its readers after each frame. The
    /// name of the fleet, the speed and the lockstep of the options don't count.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn driven(
        scenario: Scenario,
        options: &Options,
        fleet: &LocalFleet,
    ) -> Result<Self, EngineError> {
        let tick_period = scenario.tick_period;
        let (ports, simulation) = open(scenario, options, fleet.join(NAME), true)?;
        Ok(Self { session: Session::driven(ports, tick_period), simulation })
    }

    /// Runs until the requested number of ticks is made or the process is asked to end.
    ///
    /// # Errors
    /// If shared memory fails, or a plugin in lockstep doesn't finish a tick in time.
    #[cfg(feature = "shared-memory")]
    pub fn run(
        &mut self,
        termination: &regatta_plugin::Termination,
    ) -> Result<Summary, EngineError> {
        self.session.run(&mut self.simulation, termination)?;
        Ok(self.summary())
    }

    /// Publishes the world and the first frame.
    ///
    /// # Errors
    /// If a port fails.
    pub fn begin(&mut self) -> Result<(), EngineError> {
        self.session.begin(&mut self.simulation)
    }

    /// Makes a tick. Returns `false` after the last one.
    ///
    /// # Errors
    /// If a port fails.
    pub fn advance(&mut self) -> Result<bool, EngineError> {
        self.session.advance(&mut self.simulation)
    }

    /// Publishes the last frame again, as the end of the run.
    ///
    /// # Errors
    /// If a port fails.
    pub fn end(&mut self) -> Result<Summary, EngineError> {
        self.session.end(&mut self.simulation)?;
        Ok(self.summary())
    }

    fn summary(&self) -> Summary {
        let Self { session, simulation } = self;
        Summary {
            ticks: session.tick(),
            sim_time: session.sim_time(),
            wall_time: session.wall_time(),
            late_ticks: session.late_ticks(),
            digest: simulation.digest.as_ref().map(Digest::value),
        }
    }
}

/// The name of the engine in its fleet.
const NAME: &str = "engine";

/// Opens the engine's services and places the robots.
fn open(
    scenario: Scenario,
    options: &Options,
    participant: Participant,
    is_lockstep: bool,
) -> Result<(ProducerPorts, Simulation), EngineError> {
    let robots = options.robots.unwrap_or_else(|| scenario.robots());
    if robots > MAX_ROBOTS {
        return Err(EngineError::TooManyRobots(robots));
    }
    let ticks_per_frame = scenario.ticks_per_frame;
    if is_lockstep && ticks_per_frame as usize > services::EVENT_BUFFER {
        return Err(EngineError::TooFewFrames(ticks_per_frame));
    }
    let ports = ProducerPorts::create_on(participant, robots as usize)?;
    check_size(&scenario.graph)?;
    let tracks = Arc::new(arc_length::compile(&scenario.graph));
    let config = FleetConfig {
        types: scenario.robot_types.clone(),
        tick_period: scenario.tick_period,
        seed: scenario.seed,
        isa: options.isa.unwrap_or_else(Isa::detect),
        threads: options.threads,
        most_robots: MAX_ROBOTS,
    };
    let mut fleet = Fleet::new(scenario.graph.clone(), tracks.clone(), config)?;
    fleet.vary_speeds(scenario.disturbances.speed_variation, scenario.seed);
    let disturbances = Schedule::new(&scenario.disturbances, scenario.seed, scenario.tick_period);
    let routes = RouteServer::open_on(ports.participant())?;
    let mut simulation = Simulation {
        events: EventBuffer::new(MAX_EVENTS),
        robot_types: Vec::new(),
        tracks,
        commands: Vec::new(),
        command_log: Vec::new(),
        closures_published: 0,
        facilities_published: 0,
        unannounced_ticks: 0,
        last_tick: options.ticks,
        digest: options.digest.then(Digest::default),
        disturbances,
        batteries_due: 0,
        scenario,
        fleet,
        routes,
    };
    // The first frame shows these robots. Events of them would reach only readers that
    // happen to be there by now.
    simulation.events.set_wanted(false);
    simulation.place_robots(robots)?;
    Ok((ports, simulation))
}

impl Simulation {
    /// Whether a tick has a frame.
    fn has_frame(&self, tick: u64) -> bool {
        tick.is_multiple_of(u64::from(self.scenario.ticks_per_frame))
    }

    /// Applies the commands that came since the last tick; in lockstep by sender, so that the order
    /// in which processes were scheduled doesn't matter.
    fn take_commands(&mut self, session: &mut Session) -> Result<(), EngineError> {
        let is_lockstep = session.is_lockstep();
        let ports = session.ports();
        let is_logged = ports.has_command_log_readers();
        let mut has_commands = false;
        if is_lockstep {
            let mut commands = std::mem::take(&mut self.commands);
            ports.take_commands(|header, authority, records| {
                commands.push((header.sender, authority, records.to_vec()));
            })?;
            commands.sort_by_key(|(sender, ..)| *sender);
            for (_, authority, records) in commands.drain(..) {
                self.apply(&records, authority, is_logged);
                has_commands = true;
            }
            self.commands = commands;
        } else {
            ports.take_commands(|_, authority, records| {
                self.apply(records, authority, is_logged);
                has_commands = true;
            })?;
        }
        let were_left_out = self.robot_types.is_empty();
        if (has_commands || were_left_out) && self.fleet.robot_types() != self.robot_types {
            self.publish_types(session)?;
        }
        Ok(())
    }

    fn apply(&mut self, records: &[CommandRecord], authority: Authority, is_logged: bool) {
        self.fleet.apply_of(authority, records, &mut self.events);
        if is_logged {
            self.command_log.extend_from_slice(records);
        }
    }

    /// Publishes the events, the closures and the command log of the current tick.
    fn publish_events(&mut self, session: &mut Session) -> Result<(), EngineError> {
        let tick = session.tick();
        let ports = session.ports();
        if !self.events.records().is_empty() {
            let published =
                ports.publish_events(tick, self.events.dropped(), self.events.records());
            session.unless_full(published)?;
            self.events.clear();
            self.unannounced_ticks += 1;
        }
        self.publish_closures(session)?;
        self.publish_facilities(session)?;
        if !self.command_log.is_empty() {
            let published = session.ports().publish_command_log(tick, &self.command_log);
            session.unless_full(published)?;
            self.command_log.clear();
        }
        Ok(())
    }

    /// Publishes the closed edges if they have changed.
    fn publish_closures(&mut self, session: &mut Session) -> Result<(), EngineError> {
        if self.closures_published != self.fleet.closure_changes() {
            self.closures_published = self.fleet.closure_changes();
            let tick = session.tick();
            let published = session.ports().publish_closures(tick, &self.fleet.closed_edges());
            session.unless_full(published)?;
        }
        Ok(())
    }

    /// Publishes the states of doors and lifts if they have changed.
    fn publish_facilities(&mut self, session: &mut Session) -> Result<(), EngineError> {
        if self.facilities_published != self.fleet.facility_changes() {
            self.facilities_published = self.fleet.facility_changes();
            let tick = session.tick();
            let states = self.fleet.facility_states();
            let published = session.ports().publish_facilities(tick, states);
            session.unless_full(published)?;
        }
        Ok(())
    }

    /// Wakes readers between two frames before their events overflow.
    fn announce_events(&mut self, session: &mut Session) {
        if self.unannounced_ticks >= services::EVENT_WAKE {
            session.ports().notify();
            self.unannounced_ticks = 0;
        }
    }

    fn send(
        &mut self,
        session: &mut Session,
        mut frame: FrameLoan,
        digested: bool,
    ) -> Result<(), EngineError> {
        if let Some(digest) = self.digest.as_mut().filter(|_| digested) {
            digest.frame(session.tick(), self.fleet.robots(), &frame.columns_mut());
        }
        session.send(frame)?;
        self.unannounced_ticks = 0;
        Ok(())
    }

    /// Loans the frame of this tick, if it has one and shared memory has room for it.
    fn loan_if_due(&self, session: &mut Session) -> Result<Option<FrameLoan>, EngineError> {
        if self.has_frame(session.tick()) { self.loan(session) } else { Ok(None) }
    }

    /// Loans a frame. With a digest, full memory is an error, because a digest needs all frames.
    fn loan(&self, session: &mut Session) -> Result<Option<FrameLoan>, EngineError> {
        let robots = self.fleet.robots();
        Ok(match self.digest {
            Some(_) => Some(session.loan(robots)?),
            None => session.loan_unless_full(robots)?,
        })
    }

    /// Publishes the poses as they are.
    fn write_frame(&mut self, session: &mut Session, digested: bool) -> Result<(), EngineError> {
        let Some(mut frame) = self.loan(session)? else { return Ok(()) };
        self.fleet.write(frame.columns_mut());
        self.send(session, frame, digested)
    }
}
