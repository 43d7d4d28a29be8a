//! The readers of a study's run: traffic, queues, orders and findings. They count as one plugin, in
//! the process of the run or, as `regatta study-observe`, in one of their own. (In lockstep each
//! additional process costs some wake-ups a tick, which with small fleets would cost more than the
//! work of the readers.)

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser};
use regatta_meter::{Figures, Metering};
use regatta_plugin::column::WAITS_FOR;
use regatta_plugin::frame::RobotState;
use regatta_plugin::{
    ColumnReader, Error, Events, Frame, Options, Participant, Plugin, Rate, Result, World,
};
use regatta_study::outcome::{EdgeFigures, EdgeQueues, EdgeTraffic, FleetState, SeenStates};
use regatta_traffic::{QueueObserver, TrafficPlugin};
use regatta_validator::{Report, Settings, Validator};

use crate::failure::{Failure, plugin_failure};

#[derive(Args)]
pub struct ObserverArgs {
    /// File for the traffic on edges, as JSON
    #[arg(long, value_name = "FILE")]
    traffic: PathBuf,
    /// File for the places that robots wait for, as JSON
    #[arg(long, value_name = "FILE")]
    queues: PathBuf,
    /// File for the figures of the orders, as JSON
    #[arg(long, value_name = "FILE")]
    meter: PathBuf,
    /// File for the findings of the validator, as JSON; without it, nothing is judged
    #[arg(long, value_name = "FILE")]
    validator: Option<PathBuf>,
    /// File for the states of the fleet in which robots made no progress, and the last one, as JSON
    #[arg(long, value_name = "FILE")]
    states: PathBuf,
    /// File that is made when all are ready to read
    #[arg(long, value_name = "FILE")]
    ready: PathBuf,
    #[command(flatten)]
    options: Options,
}

/// Runs `regatta study-observe`.
pub fn run(args: &ObserverArgs) -> Result<ExitCode, Failure> {
    let observers = Observers::new(args.validator.is_some());
    let program = ObserverProgram { observers, args };
    args.options.run(program, "observers").map_err(plugin_failure)?;
    Ok(ExitCode::SUCCESS)
}

/// The readers of a run.
pub struct Observers {
    traffic: TrafficPlugin,
    queues: QueueObserver,
    meter: Metering,
    validator: Option<Validator>,
    waits_for: Option<ColumnReader>,
    /// By robot: metres east and north in the newest frame.
    places: Vec<[f32; 2]>,
    /// By robot: the index of its edge in the newest frame.
    edges: Vec<u32>,
    /// The ids of all edges of the world.
    edge_ids: Vec<u32>,
    /// The robots that are held, broken or faulted in the newest frame.
    out_of_service: Vec<u32>,
    /// The states in which stalls were found, with their simulated times in seconds.
    found: Vec<(f64, FleetState)>,
    /// The number of stalls that were found.
    stalls: u64,
}

/// The figures that the readers of a run have at its end.
pub struct Observed {
    /// The traffic on edges.
    pub traffic: EdgeFigures<EdgeTraffic>,
    /// The places that robots waited for.
    pub queues: EdgeFigures<EdgeQueues>,
    /// The figures of the orders.
    pub meter: Figures,
    /// The findings; `None` if nothing was judged.
    pub findings: Option<Report>,
    /// The states of the fleet that tell of its stalls.
    pub seen: SeenStates,
}

impl Observers {
    /// Creates the readers of a run, the validator among them if the run `is_judged`.
    pub fn new(is_judged: bool) -> Self {
        let traffic = regatta_traffic::Cli::parse_from(["traffic"]);
        Self {
            traffic: regatta_traffic::plugin(traffic),
            queues: QueueObserver::default(),
            meter: Metering::default(),
            validator: is_judged.then(|| Validator::new(Settings::default())),
            waits_for: None,
            places: Vec::new(),
            edges: Vec::new(),
            edge_ids: Vec::new(),
            out_of_service: Vec::new(),
            found: Vec::new(),
            stalls: 0,
        }
    }

    /// Keeps the traffic to itself, for a fleet whose traffic another plugin publishes.
    #[must_use]
    pub fn unpublished(self) -> Self {
        Self { traffic: self.traffic.unpublished(), ..self }
    }

    /// Returns the figures, and ends the judgement.
    pub fn observed(&mut self) -> Observed {
        let queues = self.queues.caused_secs();
        let queues = queues.map(|(edge, caused_secs)| EdgeQueues { edge, caused_secs });
        Observed {
            traffic: traffic(&self.traffic.run_report()),
            queues: EdgeFigures { edges: queues.collect() },
            meter: self.meter.figures(),
            findings: self.validator.as_mut().map(Validator::take_report),
            seen: SeenStates { last: self.state(), found: std::mem::take(&mut self.found) },
        }
    }

    /// Returns the state of the fleet in the newest frame.
    fn state(&mut self) -> FleetState {
        let ids = self.edges.iter().map(|edge| self.edge_ids.get(*edge as usize).copied());
        FleetState {
            edges: ids.collect::<Option<_>>().unwrap_or_default(),
            waits_for: self.waiting(),
            places: self.places.clone(),
            out_of_service: self.out_of_service.clone(),
        }
    }

    /// Keeps the state of a frame in which the validator has found a stall.
    fn keep_state(&mut self, frame: &Frame<'_>) {
        let stalls = self.validator.as_ref().map_or(0, Validator::stalls);
        let is_new = std::mem::replace(&mut self.stalls, stalls) < stalls;
        if is_new && self.found.len() < SeenStates::MOST {
            let secs = frame.header().sim_time_nanos as f64 * 1e-9;
            let state = self.state();
            self.found.push((secs, state));
        }
    }

    /// Returns the robots that robots wait for, as their manager published it last.
    fn waiting(&mut self) -> BTreeMap<u32, u32> {
        let Some(column) = &mut self.waits_for else { return BTreeMap::new() };
        // Without a manager that says it, nothing is known.
        let (Ok(_), Ok(Some(newest))) = (column.latest().map(drop), column.current()) else {
            return BTreeMap::new();
        };
        let robots = (0..).zip(newest.values);
        robots.filter_map(|(robot, value)| Some((robot, WAITS_FOR.element(*value)?))).collect()
    }

    fn readers(&mut self) -> impl Iterator<Item = &mut dyn Plugin> {
        let Self { traffic, queues, meter, validator, .. } = self;
        let readers: [&mut dyn Plugin; 3] = [traffic, queues, meter];
        readers.into_iter().chain(validator.as_mut().map(|validator| validator as &mut dyn Plugin))
    }
}

fn traffic(report: &regatta_traffic::Report<'_>) -> EdgeFigures<EdgeTraffic> {
    let rows = report.edges.iter().zip(report.figures);
    let edges = rows.map(|(edge, figures)| EdgeTraffic {
        edge: edge.id,
        waiting_secs: figures.waiting_secs.into(),
        entered_per_hour: figures.entered_per_hour.into(),
    });
    EdgeFigures { edges: edges.collect() }
}

impl Plugin for Observers {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.waits_for = Some(ColumnReader::open_on(fleet, WAITS_FOR.name())?);
        self.readers().try_for_each(|reader| reader.on_start(fleet))
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.edge_ids = world.edges().iter().map(|edge| edge.id).collect();
        self.readers().try_for_each(|reader| reader.on_world(world))
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.places.clear();
        self.places.extend(frame.x().iter().zip(frame.y()).map(|(x, y)| [*x, *y]));
        self.edges.clear();
        self.edges.extend_from_slice(frame.edge());
        self.out_of_service.clear();
        for (robot, state) in (0..).zip(frame.state()) {
            let state = RobotState::from_number(*state);
            if matches!(state, RobotState::Held | RobotState::Broken | RobotState::Faulted) {
                self.out_of_service.push(robot);
            }
        }
        self.readers().try_for_each(|reader| reader.on_frame(frame))?;
        self.keep_state(frame);
        Ok(())
    }

    fn on_idle(&mut self, has_producer: bool) -> Result {
        self.readers().try_for_each(|reader| reader.on_idle(has_producer))
    }

    fn wants_events(&self) -> bool {
        self.validator.is_some()
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        self.validator.as_mut().map_or(Ok(()), |validator| validator.on_events(events))
    }

    fn rate(&self) -> Rate {
        Rate::EveryFrame
    }

    fn on_stop(&mut self) -> Result {
        self.readers().try_for_each(|reader| reader.on_stop())
    }
}

/// The program: it writes the figures to files at the end.
struct ObserverProgram<'a> {
    observers: Observers,
    args: &'a ObserverArgs,
}

impl Plugin for ObserverProgram<'_> {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.observers.on_start(fleet)?;
        // From now on, nothing that a manager writes is lost.
        Ok(std::fs::write(&self.args.ready, "")?)
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        self.observers.on_world(world)
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.observers.on_frame(frame)
    }

    fn on_idle(&mut self, has_producer: bool) -> Result {
        self.observers.on_idle(has_producer)
    }

    fn wants_events(&self) -> bool {
        self.observers.wants_events()
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        self.observers.on_events(events)
    }

    fn on_stop(&mut self) -> Result {
        self.observers.on_stop()?;
        let Observed { traffic, queues, meter, findings, seen } = self.observers.observed();
        write(&self.args.states, serde_json::to_string(&seen)?)?;
        write(&self.args.traffic, serde_json::to_string(&traffic)?)?;
        write(&self.args.queues, serde_json::to_string(&queues)?)?;
        write(&self.args.meter, serde_json::to_string(&meter)?)?;
        if let (Some(path), Some(findings)) = (&self.args.validator, findings) {
            write(path, findings.to_json())?;
        }
        Ok(())
    }
}

fn write(path: &Path, text: String) -> Result {
    std::fs::write(path, text)
        .map_err(|error| Error::new(format_args!("can't write {} ({error})", path.display())))
}
