//! The plugin: frames in, the traffic on edges out.

use std::ffi::OsString;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Parser;
use regatta_plugin::column::COLLISION;
use regatta_plugin::traffic::{EdgeTraffic, TrafficHeader};
use regatta_plugin::{
    ColumnReader, Frame, Options, Participant, Plugin, Rate, Result, TrafficPublisher, World,
    visible,
};

use crate::history::PublishedHistory;
use crate::parquet_file;
use crate::periods::Periods;
use crate::report::{self, Edge, Report};
use crate::routes::RouteWatch;
use crate::tally::Tally;

/// The time between two publications, in simulated seconds.
const PUBLISH_SECS: f64 = 1.0;
/// The longest time that a frame covers, in simulated seconds at the speed 1. A longer gap doesn't
/// count.
const LONGEST_GAP_SECS: f64 = 10.0;

/// The command line of `regatta plugin traffic`.
#[derive(Clone, Debug, Parser)]
#[command(
    about = "Publish figures of each edge: occupancy, throughput, speed, waiting, contacts, routes"
)]
pub struct Cli {
    /// At the end, write the figures of all edges for the run to this file
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// At the end, write the figures of all edges for the run to this file as a table in Apache
    /// Parquet
    #[arg(long, value_name = "FILE.parquet")]
    pub parquet: Option<PathBuf>,
    /// At the end, write the figures of all edges for the run to this file as JSON
    #[arg(long, value_name = "FILE.json")]
    pub json: Option<PathBuf>,
    /// At the end, print the ten edges at which robots waited the longest
    #[arg(long)]
    pub summary: bool,
    /// Options of every plugin.
    #[command(flatten)]
    pub options: Options,
}

/// Runs the plugin with a command line, whose first argument is the name of the program.
///
/// # Errors
/// Fails if an option is invalid, a file can't be written, the fleet has such a plugin already, or
/// as [`regatta_plugin::run`] does.
pub fn run_from<A: Into<OsString> + Clone>(args: impl IntoIterator<Item = A>) -> Result {
    regatta_kit::run_from(args, |cli: Cli| {
        for file in [&cli.csv, &cli.parquet, &cli.json].into_iter().flatten() {
            report::check(file)?;
        }
        cli.options.clone().run(TrafficPlugin::new(cli), "traffic")
    })
}

/// Returns the plugin of a command line, to run it beside others in one process.
pub fn plugin(cli: Cli) -> TrafficPlugin {
    TrafficPlugin::new(cli)
}

/// The plugin's ports in the fleet.
struct Ports {
    /// `None` if the figures aren't published.
    traffic: Option<TrafficPublisher>,
    contacts: ColumnReader,
    history: History,
    participant: Participant,
    /// The routes of robots; `None` until the first frame that isn't in lockstep.
    routes: Option<RouteWatch>,
}

/// The history of the run. It is opened with the first frame: a replay, which knows that of its
/// whole recording, has opened its services by then.
enum History {
    Unopened,
    /// Another process publishes it, or nobody.
    Taken,
    Published(Box<PublishedHistory>),
}

impl History {
    /// Adds a frame, with the robots that enter an edge, per hour.
    fn add(
        &mut self,
        participant: &Participant,
        frame: &Frame<'_>,
        throughput: Option<f32>,
    ) -> Result {
        if let Self::Unopened = self {
            *self = PublishedHistory::open(participant)?
                .map_or(Self::Taken, |history| Self::Published(Box::new(history)));
        }
        match self {
            Self::Published(history) => history.add(frame, throughput),
            _ => Ok(()),
        }
    }

    /// Gives the history to readers that have joined since.
    fn update(&mut self) -> Result {
        if let Self::Published(history) = self {
            history.publish()?;
            history.update();
        }
        Ok(())
    }
}

/// The frame before.
#[derive(Clone, Copy)]
struct Before {
    run_id: u64,
    tick: u64,
    jumps: u64,
    sim_secs: f64,
}

/// The traffic plugin.
pub struct TrafficPlugin {
    cli: Cli,
    is_published: bool,
    ports: Option<Ports>,
    edges: Vec<Edge>,
    /// Speed limits of edges, in metres per second.
    limits: Vec<f32>,
    world_revision: u64,
    tally: Tally,
    periods: Periods,
    before: Option<Before>,
    next_publication_secs: f64,
    /// Whether figures are to be published.
    is_due: bool,
    /// The newest frame.
    newest: TrafficHeader,
    /// The robots that enter an edge, per hour, when figures were due last.
    throughput: Option<f32>,
    figures: Vec<EdgeTraffic>,
}

impl TrafficPlugin {
    fn new(cli: Cli) -> Self {
        Self {
            cli,
            is_published: true,
            ports: None,
            edges: Vec::new(),
            limits: Vec::new(),
            world_revision: 0,
            tally: Tally::default(),
            periods: Periods::default(),
            before: None,
            next_publication_secs: 0.0,
            is_due: false,
            newest: TrafficHeader::default(),
            throughput: None,
            figures: Vec::new(),
        }
    }

    /// Keeps the figures to itself, for a fleet that has such a plugin already.
    #[must_use]
    pub fn unpublished(self) -> Self {
        Self { is_published: false, ..self }
    }

    /// Resets the figures for another run, or another route graph.
    fn begin(&mut self) {
        self.tally.begin(self.limits.len());
        self.periods = Periods::new(self.limits.len());
        self.before = None;
        self.next_publication_secs = 0.0;
        self.is_due = false;
        self.throughput = None;
    }

    /// Returns the time that a frame covers in simulated seconds: 0 for the first frame, and after
    /// a jump or a long gap.
    fn secs_of(&mut self, frame: &Frame<'_>) -> f64 {
        let sim_secs = frame.sim_time().as_secs_f64();
        let now =
            Before { run_id: frame.run_id(), tick: frame.tick(), jumps: frame.jumps(), sim_secs };
        // A replay that jumps back resets the figures.
        if self.before.is_some_and(|before| before.run_id != now.run_id || before.tick > now.tick) {
            self.begin();
        }
        let Some(before) = self.before.replace(now) else { return 0.0 };
        if before.jumps != now.jumps {
            self.tally.forget_places();
            return 0.0;
        }
        let secs = sim_secs - before.sim_secs;
        // At a high speed, frames are read at the same rate, and stand for more time.
        let longest = LONGEST_GAP_SECS * f64::from(frame.header().speed.max(1.0));
        if secs > longest { 0.0 } else { secs }
    }

    /// Takes note of a frame that has been added. Figures are due once a simulated second.
    fn note(&mut self, frame: &Frame<'_>, has_contacts: bool, has_routes: bool) {
        self.newest = TrafficHeader {
            run_id: frame.run_id(),
            tick: frame.tick(),
            sim_time_nanos: frame.header().sim_time_nanos,
            world_revision: self.world_revision,
            has_contacts: has_contacts.into(),
            has_routes: has_routes.into(),
            ..TrafficHeader::default()
        };
        let sim_secs = frame.sim_time().as_secs_f64();
        if sim_secs >= self.next_publication_secs {
            self.next_publication_secs = sim_secs + PUBLISH_SECS;
            self.throughput = (!self.limits.is_empty()).then(|| self.periods.throughput());
            self.is_due = true;
        }
    }

    /// Publishes the figures if they are due. Without readers they stay due, so that the first one
    /// gets them at once.
    fn publish(&mut self) -> Result {
        let Some(Ports { traffic: Some(traffic), .. }) = &mut self.ports else { return Ok(()) };
        if !self.is_due || traffic.readers() == 0 {
            return Ok(());
        }
        self.is_due = false;
        self.periods.figures(&self.limits, &mut self.figures);
        let period_secs = self.periods.secs().map(|secs| secs as f32);
        let header = TrafficHeader { period_secs, ..self.newest };
        Ok(traffic.publish(&header, &self.figures)?)
    }

    /// Returns the figures of all edges for the run so far.
    pub fn run_report(&mut self) -> Report<'_> {
        self.periods.figures(&self.limits, &mut self.figures);
        let run = self.figures.len() - self.edges.len();
        Report { secs: self.periods.secs()[2], edges: &self.edges, figures: &self.figures[run..] }
    }

    /// Writes and prints the figures of the run.
    fn report(&mut self) -> Result {
        let cli = self.cli.clone();
        let report = self.run_report();
        if cli.summary {
            // A closed standard output isn't an error.
            let _ = write!(std::io::stdout(), "{}", visible(&report.summary()));
        }
        if let Some(path) = &cli.csv {
            report::write(path, &report.csv())?;
        }
        if let Some(path) = &cli.parquet {
            parquet_file::write(path, &report).map_err(|error| report::failed(path, &error))?;
        }
        if let Some(path) = &cli.json {
            report::write(path, &report.json())?;
        }
        Ok(())
    }
}

impl Plugin for TrafficPlugin {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        let contacts = ColumnReader::open_on(fleet, COLLISION.name())?;
        let (traffic, history) = match self.is_published {
            true => (Some(TrafficPublisher::open_on(fleet)?), History::Unopened),
            false => (None, History::Taken),
        };
        let participant = fleet.clone();
        self.ports = Some(Ports { traffic, contacts, history, participant, routes: None });
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.edges = report::edges(world);
        self.limits = world.edges().iter().map(|edge| edge.speed).collect();
        self.world_revision = world.revision();
        self.begin();
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        if frame.header().is_warm_up() {
            return Ok(());
        }
        let secs = self.secs_of(frame);
        let Some(ports) = &mut self.ports else { return Ok(()) };
        ports.contacts.latest()?;
        let contacts =
            ports.contacts.current()?.filter(|column| column.header.run_id == frame.run_id());
        let has_contacts = contacts.is_some();
        let mut counts =
            self.tally.count(&frame.columns(), contacts.map_or(&[][..], |column| column.values));
        // The arrival of answers doesn't repeat.
        let routes = if frame.header().lockstep == 0 {
            ports
                .routes
                .get_or_insert_with(|| RouteWatch::start(ports.participant.fleet()))
                .newest(frame.run_id())
        } else {
            None
        };
        let has_routes = routes.is_some();
        if let Some(routes) = routes {
            counts = self.tally.count_routes(&routes.edges);
        }
        self.periods.add(counts, secs);
        self.note(frame, has_contacts, has_routes);
        self.publish()?;
        let Some(ports) = &mut self.ports else { return Ok(()) };
        ports.history.add(&ports.participant, frame, self.throughput)
    }

    fn on_idle(&mut self, _has_producer: bool) -> Result {
        self.publish()?;
        let Some(ports) = &mut self.ports else { return Ok(()) };
        if let Some(traffic) = &mut ports.traffic {
            traffic.update();
        }
        ports.history.update()
    }

    fn rate(&self) -> Rate {
        Rate::PerSecond(10.0)
    }

    fn on_stop(&mut self) -> Result {
        self.report()
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::FrameHeader;

    use super::*;

    #[test]
    fn a_frame_stands_for_the_time_since_the_one_before_unless_a_jump_or_a_gap_lies_between() {
        let mut plugin = TrafficPlugin::new(Cli::parse_from(["traffic"]));
        let mut secs_of = |secs: f64, jumps, speed| {
            let (run_id, sim_time_nanos, tick) = (1, (secs * 1e9) as u64, (secs * 10.0) as u64);
            let header = FrameHeader {
                run_id,
                sim_time_nanos,
                tick,
                jumps,
                speed,
                ..FrameHeader::default()
            };
            plugin.secs_of(&Frame::new(&header, &[]).expect("a frame without robots"))
        };
        assert_eq!([secs_of(1.0, 1, 1.0), secs_of(1.5, 1, 1.0)], [0.0, 0.5]);
        assert_eq!([secs_of(4.5, 2, 1.0), secs_of(5.0, 2, 1.0)], [0.0, 0.5], "a jump");
        assert_eq!([secs_of(25.0, 2, 1.0), secs_of(26.0, 2, 1.0)], [0.0, 1.0], "a gap");
        assert_eq!(
            [secs_of(46.0, 2, 100.0), secs_of(96.0, 2, f32::INFINITY)],
            [20.0, 50.0],
            "high speeds"
        );
    }
}
