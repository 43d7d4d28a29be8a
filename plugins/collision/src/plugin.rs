//! The plugin: passes every frame to the detector, and publishes, logs and sums up the results.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Parser;
use regatta_plugin::column::{COLLISION, TYPE};
use regatta_plugin::contact::ContactHeader;
use regatta_plugin::frame::ClockState;
use regatta_plugin::{
    ColumnPublisher, ColumnReader, ContactPublisher, Frame, Options, Participant, Plugin, Rate,
    Result, World, tell,
};

use crate::criteria::Settings;
use crate::detector::{Detector, FrameInput};
use crate::log::ContactLog;
use crate::route_requests::RouteRequests;
use crate::skips::Skips;
use crate::totals;

/// The longest wait for the column `type` at the start of a run. After it, the run is read without
/// types.
const TYPES_WAIT: Duration = Duration::from_millis(500);

/// The command line of `regatta plugin collision`.
#[derive(Clone, Debug, Parser)]
#[command(about = "Find robots that collide, now or soon, and mark them in the column 'collision'")]
pub struct Cli {
    /// Distance below which two robots are a possible collision, in metres
    #[arg(long, value_name = "METRES", default_value_t = 0.2, allow_negative_numbers = true)]
    pub margin: f32,
    /// Seconds to look ahead: two robots that will touch within this time if both continue along
    /// their routes are a possible collision; 0 checks only the present
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0, allow_negative_numbers = true)]
    pub horizon: f32,
    /// Don't ask the engine for routes; assume that a robot may turn onto any edge
    #[arg(long)]
    pub no_routes: bool,
    /// Append a line to this file for each start and end of a contact or a warning
    #[arg(long, value_name = "FILE.csv")]
    pub log: Option<PathBuf>,
    /// At the end of a run, print totals, and the ten worst pairs, robots and edges
    #[arg(long)]
    pub summary: bool,
    /// Options of every plugin.
    #[command(flatten)]
    pub options: Options,
}

/// Runs the plugin with a command line, whose first argument is the name of the program.
///
/// # Errors
/// Fails if an option is invalid, if the log can't be written, or as [`regatta_plugin::run`] does,
/// for example because the fleet has such a plugin already.
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    regatta_kit::run_from(args, |cli: Cli| {
        cli.options.run(CollisionPlugin::new(&cli)?, "collision")
    })
}

/// Returns the plugin of a command line, to run it beside others in one process.
///
/// # Errors
/// Fails if an option is invalid, or if the log can't be written.
pub fn plugin(cli: &Cli) -> Result<impl Plugin + use<>> {
    CollisionPlugin::new(cli)
}

/// The plugin's ports in the fleet.
struct Ports {
    types: ColumnReader,
    column: ColumnPublisher,
    contacts: ContactPublisher,
    /// `None` if routes make no difference.
    routes: Option<RouteRequests>,
}

/// The collision plugin.
struct CollisionPlugin {
    detector: Detector,
    ports: Option<Ports>,
    log: Option<ContactLog>,
    summary: bool,
    asks_for_routes: bool,
    skips: Skips,
    /// Ids of the world's edges, by index.
    edges: Vec<u32>,
    /// Number of robot types in the world.
    robot_types: usize,
    /// Run of the last frame, and its simulated time in nanoseconds.
    last: Option<(u64, u64)>,
    reported: Reported,
}

/// Notices that were already printed in this run.
#[derive(Default)]
struct Reported {
    capped: bool,
    invalid_robots: bool,
    summary: bool,
}

impl CollisionPlugin {
    fn new(cli: &Cli) -> Result<Self> {
        let every_frame = cli.options.rate.is_none_or(|rate| rate == Rate::EveryFrame);
        Ok(Self {
            detector: Detector::new(Settings::new(cli.margin, cli.horizon)?),
            ports: None,
            log: cli.log.as_deref().map(ContactLog::open).transpose()?,
            summary: cli.summary,
            asks_for_routes: !cli.no_routes && cli.horizon > 0.0,
            skips: Skips::new(every_frame),
            edges: Vec::new(),
            robot_types: 0,
            last: None,
            reported: Reported::default(),
        })
    }

    /// Begins another run: prints the summary of the last one, and waits for the robots' types.
    fn begin_run(&mut self, frame: &Frame<'_>) -> Result {
        self.end_run();
        self.reported = Reported::default();
        if let Some(requests) = self.ports.as_mut().and_then(|ports| ports.routes.as_mut()) {
            requests.begin_run();
        }
        if self.robot_types <= 1 {
            // All robots have the same type, for example those of a UDP source whose robots are yet
            // to come.
            return Ok(());
        }
        let start = Instant::now();
        let Some(ports) = &mut self.ports else { return Ok(()) };
        while ports.types.latest()?.is_none()
            && ports.types.current()?.is_none_or(|old| old.header.run_id != frame.run_id())
        {
            if start.elapsed() > TYPES_WAIT {
                tell!(
                    "collision: no process publishes the column 'type': all robots are taken for \
                     the first robot type"
                );
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(())
    }

    fn end_run(&mut self) {
        let Some((_, nanos)) = self.last else { return };
        if self.summary && !std::mem::replace(&mut self.reported.summary, true) {
            print!("{}", totals::summarize(&self.detector, &self.edges, nanos));
        }
    }

    fn publish(&mut self, frame: &Frame<'_>) -> Result {
        let Self { detector, ports, log, edges, skips, .. } = self;
        let Some(ports) = ports else { return Ok(()) };
        let (all, pairs) = (detector.totals().all(), detector.contacts());
        ports.column.publish(frame, detector.levels())?;
        if !detector.events().is_empty() {
            ports.contacts.publish_events(frame.run_id(), frame.tick(), detector.events())?;
        }
        let header = ContactHeader {
            run_id: frame.run_id(),
            tick: frame.tick(),
            sim_time_nanos: frame.header().sim_time_nanos,
            touching_ever: all.contacts,
            possible_ever: all.warnings,
            frames_skipped: skips.count(),
            touching: detector.touching() as u32,
            possible: (pairs.len() - detector.touching()) as u32,
            capped: u32::from(detector.is_capped()),
            ..ContactHeader::default()
        };
        ports.contacts.publish(&header, pairs)?;
        if let Some(change) =
            log.as_mut().and_then(|log| log.add(frame.run_id(), detector.events(), edges))
        {
            tell!("collision: {change}");
        }
        Ok(())
    }

    /// Prints, once per run, limits of the results that the user should know.
    fn report_limits(&mut self) {
        if self.detector.is_capped() && !std::mem::replace(&mut self.reported.capped, true) {
            tell!("collision: too many robots are close together: not all pairs are checked");
        }
        let invalid_robots = self.detector.invalid_robots();
        if invalid_robots > 0 && !std::mem::replace(&mut self.reported.invalid_robots, true) {
            tell!(
                "collision: {invalid_robots} robots have an invalid pose or footprint and are not \
                 checked"
            );
        }
    }
}

impl Plugin for CollisionPlugin {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        let column = ColumnPublisher::open_on(fleet, COLLISION.name())?;
        let contacts = ContactPublisher::open_on(fleet)?;
        let routes = self.asks_for_routes.then(|| RouteRequests::open_on(fleet)).transpose()?;
        self.ports = Some(Ports {
            types: ColumnReader::open_on(fleet, TYPE.name())?,
            column,
            contacts,
            routes,
        });
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.detector.set_world(world);
        self.edges = world.edges().iter().map(|edge| edge.id).collect();
        self.robot_types = world.robot_types().len();
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        if self.last.is_none_or(|(run, _)| run != frame.run_id()) {
            self.begin_run(frame)?;
        }
        let began = Instant::now();
        if let Some(line) = self.skips.note(frame, began) {
            tell!("collision: {line}");
        }
        let Some(ports) = &mut self.ports else { return Ok(()) };
        ports.types.latest()?;
        let robot_types = ports.types.current()?.map_or(&[][..], |types| types.values);
        if let Some(requests) = &mut ports.routes {
            requests.receive(self.detector.routes_mut())?;
        }
        let (run_id, tick, sim_time_nanos) =
            (frame.run_id(), frame.tick(), frame.header().sim_time_nanos);
        self.detector.update(&FrameInput {
            run_id,
            tick,
            sim_time_nanos,
            columns: frame.columns(),
            robot_types,
        });
        if let Some(requests) = &mut ports.routes {
            requests.ask(self.detector.routes(), frame, self.detector.contacts());
        }
        self.publish(frame)?;
        self.skips.note_work(began.elapsed());
        self.report_limits();
        self.last = Some((run_id, sim_time_nanos));
        if frame.header().clock == ClockState::Stopped as u32 {
            self.end_run();
        }
        Ok(())
    }

    fn on_idle(&mut self, _has_producer: bool) -> Result {
        if let Some(ports) = &self.ports {
            ports.column.update();
            ports.contacts.update();
        }
        Ok(())
    }

    fn on_stop(&mut self) -> Result {
        self.end_run();
        if self.skips.count() > 0 {
            tell!(
                "collision: {} frames of the last run were skipped: {}",
                self.skips.count(),
                self.skips.reason()
            );
        }
        if let Some(log) = self.log.as_ref().filter(|log| log.lost() > 0) {
            tell!("collision: {} events are missing in {}", log.lost(), log.path().display());
        }
        Ok(())
    }
}
