//! A run of a master in real time: engine, vehicles and validator as processes, the judge and the
//! meter on a connection of their own to the broker.

use std::collections::HashSet;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime};

use regatta_plugin::{Control, Termination};
use regatta_study::master::{MasterPlan, RawFigures};
use regatta_vda5050::broker::{Broker, Incoming, PASSWORD_VARIABLE, Session};
use regatta_vda5050::judge::{Judge, Protocol, Report, Seen};
use regatta_vda5050::message::Topic;
use regatta_vda5050::meter::{Answer, Figures, Meter};

use super::figures::raw;
use super::hand_over::{HandOver, HandedOver, Transport, Way};
use super::load::{Arrival, LiveLoad};
use super::site::Site;
use super::start;
use crate::day;
use crate::failure::Failure;
use crate::lockstep_run::{ENGINE, LockstepRun, POLL_INTERVAL};
use crate::program::Program;
use crate::vda5050::live::seconds;

const VEHICLES: &str = "vehicles";
const OBSERVERS: &str = "observers";
const MASTER: &str = "master";
const VALIDATOR: &str = "validator";
/// The files of the observers, of which only the validator's is used.
const FILES: [&str; 5] = ["traffic", "queues", "meter", "last", VALIDATOR];
/// The topics that are judged and measured.
const TOPICS: [Topic; 5] =
    [Topic::Order, Topic::InstantActions, Topic::State, Topic::Connection, Topic::Factsheet];
/// The longest time until all vehicles are there, and until the master's first order.
const START: Duration = Duration::from_secs(60);
/// The time after which an order that couldn't be handed over is tried again.
const RETRY: Duration = Duration::from_secs(1);
/// A master that owes bases has stopped if it sends no order for so many seconds, and for so many
/// times the longest that it has taken for a base.
const SILENCE_SECS: f64 = 10.0;
const SILENCE: f64 = 3.0;
/// The longest time that messages may wait in this process.
const MOST_LAG: Duration = Duration::from_secs(2);
/// The time in which the end of a broker is seen by all.
const NEWS: Duration = Duration::from_millis(300);
/// The least part of real time that the engine keeps up with.
const LEAST_SPEED: f64 = 0.95;

/// The reason why a run gives no figures.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The user ended it.
    #[error("interrupted")]
    Interrupted,
    /// It has failed, or its figures wouldn't be the master's.
    #[error("{0}")]
    Failed(String),
}

impl From<Failure> for RunError {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure.to_string())
    }
}

/// A run of a master.
#[derive(Clone, Copy)]
pub struct LiveRun<'a> {
    /// The study.
    pub plan: &'a MasterPlan,
    /// The broker, the vehicles and the commands.
    pub site: &'a Site<'a>,
    /// The number of vehicles.
    pub vehicles: u32,
    /// The number of the run, from 1, which is its seed.
    pub repeat: u64,
    /// The user's wish to end.
    pub termination: &'a Termination,
}

impl LiveRun<'_> {
    /// Does the run.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn measure(&self) -> Result<RawFigures, RunError> {
        let mut processes = LockstepRun::new("master", Program::this().map_err(Failure::from)?)?;
        let mut ear = Ear::new(self)?;
        self.start_vehicles(&mut processes)?;
        self.wait(&mut processes, &mut ear, START, |ear| {
            ear.meter.placed_vehicles() >= self.vehicles as usize
        })
        .map_err(|error| self.no_vehicles(error, &ear))?;
        if let Some(command) = self.site.master(self.vehicles) {
            processes.start(MASTER, &mut processes.logged(MASTER, command)?)?;
        }
        ear.start_load(self)?;
        self.wait(&mut processes, &mut ear, START, |ear| ear.has_order())
            .map_err(|error| self.no_order(error, &ear))?;
        let time = Duration::from_secs(self.plan.time.secs);
        match self.wait(&mut processes, &mut ear, time, |_| false) {
            Ok(()) | Err(Wait::Late) => {}
            Err(Wait::Over(error)) => return Err(error),
        }
        self.check_speed(&processes)?;
        let (figures, report) = ear.end();
        self.check(&figures)?;
        self.stop(processes).and_then(|validator| {
            Ok(raw(self.site, self.plan.time.secs as f64, figures, &report, &validator)?)
        })
    }

    fn start_vehicles(&self, processes: &mut LockstepRun) -> Result<(), Failure> {
        let scenario = self.write_scenario(processes)?;
        let mut engine = processes.command(ENGINE, &[ENGINE])?;
        processes.start(ENGINE, engine.arg(scenario))?;
        let mut observers = processes.command(OBSERVERS, &["study-observe"])?;
        for name in FILES {
            observers.arg(format!("--{name}")).arg(processes.json_file(name));
        }
        observers.arg("--ready").arg(processes.folder().join("ready"));
        processes.start(OBSERVERS, &mut observers)?;
        let mut vehicles = processes.command(VEHICLES, &["plugin", "vda5050"])?;
        vehicles.args(self.site.vehicle_args());
        vehicles.envs(self.site.password.as_ref().map(|password| (PASSWORD_VARIABLE, password)));
        processes.start(VEHICLES, &mut vehicles).map(drop)
    }

    fn write_scenario(&self, processes: &LockstepRun) -> Result<PathBuf, Failure> {
        let MasterPlan { variant, time, program, .. } = self.plan;
        let job = variant.job("layout.yaml", self.vehicles, self.repeat, *time, program);
        let mut scenario = serde_json::to_value(&job.scenario)?;
        scenario["robots"] = start::robots(variant, &job.scenario.robots, self.repeat)?;
        let path = processes.folder().join("scenario.yaml");
        fs::write(&path, scenario.to_string())?;
        fs::write(processes.folder().join("layout.yaml"), variant.layout_text())?;
        Ok(path)
    }

    /// Listens until something has happened.
    fn wait(
        &self,
        processes: &mut LockstepRun,
        ear: &mut Ear<'_>,
        time: Duration,
        is_over: impl Fn(&Ear<'_>) -> bool,
    ) -> Result<(), Wait> {
        let start = Instant::now();
        while !is_over(ear) {
            if self.termination.requested() {
                return Err(Wait::Over(RunError::Interrupted));
            }
            if let Err(failure) = is_whole(processes) {
                // A broker that is gone ends other programs, too: it is told first.
                std::thread::sleep(NEWS);
                ear.listen().map_err(Wait::Over)?;
                return Err(Wait::Over(failure.into()));
            }
            if start.elapsed() >= time {
                return Err(Wait::Late);
            }
            ear.listen().map_err(Wait::Over)?;
            std::thread::sleep(POLL_INTERVAL);
        }
        Ok(())
    }

    fn no_vehicles(&self, wait: Wait, ear: &Ear<'_>) -> RunError {
        match wait {
            Wait::Over(error) => error,
            Wait::Late => RunError::Failed(format!(
                "only {} of {} vehicles came to the broker within {} s: this machine or the broker \
                 is too slow",
                ear.meter.placed_vehicles(),
                self.vehicles,
                START.as_secs()
            )),
        }
    }

    fn no_order(&self, wait: Wait, ear: &Ear<'_>) -> RunError {
        let Wait::Late = wait else { return wait.into() };
        let secs = START.as_secs();
        let url = &self.site.url;
        RunError::Failed(match (&ear.refusal, ear.handed) {
            (Some(reason), 0) => {
                format!("no order could be handed to the master within {secs} s: {reason}")
            }
            (_, 0) => format!(
                "the master sent no order to a vehicle within {secs} s: connect it to {url}, and \
                 let it steer the vehicles of {}/+",
                self.site.vehicles.vehicle(0).trim_end_matches(|c| c != '/').trim_end_matches('/')
            ),
            (_, handed) => format!(
                "the master got {handed} orders, and sent none to a vehicle within {secs} s: check \
                 that it steers the vehicles at {url}"
            ),
        })
    }

    /// Checks that the engine has kept up with real time.
    fn check_speed(&self, processes: &LockstepRun) -> Result<(), RunError> {
        let status = Control::open(processes.fleet()).map_err(Failure::from)?.status();
        let factor = status.map_err(Failure::from)?.real_time_factor;
        if f64::from(factor) >= LEAST_SPEED {
            return Ok(());
        }
        Err(RunError::Failed(format!(
            "this machine is too slow for so many vehicles: they moved at {factor:.2} of real time"
        )))
    }

    /// Checks that the times are those of the master.
    fn check(&self, figures: &Figures) -> Result<(), RunError> {
        let most = self.plan.late_secs / 2.0;
        let mut delays = figures.delay_secs.clone();
        delays.sort_by(f32::total_cmp);
        let p99 = delays.get(delays.len().saturating_sub(1) * 99 / 100).copied().unwrap_or(0.0);
        if f64::from(p99) > most {
            return Err(RunError::Failed(format!(
                "states took up to {p99:.1} s to the broker and back (p99): this machine or the \
                 broker is too slow to tell the master's times"
            )));
        }
        let end = figures.first_order.unwrap_or(0.0) + self.plan.time.secs as f64;
        let silent = end - figures.last_order.unwrap_or(0.0);
        let came = figures.bases.iter().filter(|base| !base.answer.is_missing());
        let slowest = came.map(|base| base.secs).fold(0.0, f64::max);
        let owes = figures.bases.iter().filter(|base| base.answer == Answer::MissingFree).count();
        if owes > 0 && silent > SILENCE_SECS + SILENCE * slowest {
            return Err(RunError::Failed(format!(
                "the master sent its last order {silent:.0} s before the end, while {owes} vehicles \
                 waited for bases that were free: it has stopped"
            )));
        }
        Ok(())
    }

    /// Stops all processes, and returns the validator's report.
    fn stop(&self, mut processes: LockstepRun) -> Result<serde_json::Value, RunError> {
        let failures = processes.stop();
        // A master that is asked to end may do so as it likes.
        match failures.iter().find(|failure| !failure.starts_with(MASTER)) {
            Some(failure) => {
                let name = failure.split_whitespace().next().unwrap_or(ENGINE);
                Err(processes.failure(failure, name).into())
            }
            None => Ok(processes.json(VALIDATOR, OBSERVERS)?),
        }
    }
}

/// Checks that no process has ended.
fn is_whole(processes: &mut LockstepRun) -> Result<(), Failure> {
    match processes.engine_has_ended()? {
        true => Err("the engine has ended".into()),
        false => Ok(()),
    }
}

/// The end of a wait for something that hasn't happened.
enum Wait {
    /// Its time is over.
    Late,
    /// The run is over.
    Over(RunError),
}

impl From<Wait> for RunError {
    fn from(wait: Wait) -> Self {
        match wait {
            Wait::Over(error) => error,
            Wait::Late => Self::Failed("its time is over".to_owned()),
        }
    }
}

/// The part of a run that listens to the broker, and hands orders over.
struct Ear<'a> {
    site: &'a Site<'a>,
    broker: Option<Broker>,
    is_up: bool,
    /// The vehicles of the run: others of the broker are none of its business.
    vehicles: HashSet<String>,
    judge: Judge,
    report: Report,
    meter: Meter,
    load: Option<LiveLoad>,
    hand_over: Option<HandOver>,
    load_start: Instant,
    /// Transport orders that couldn't be handed over, with the time of the next try.
    again: Vec<(Instant, Transport)>,
    handed: u64,
    finished: usize,
    /// The reason of the last hand-over that failed.
    refusal: Option<String>,
    run: String,
}

impl<'a> Ear<'a> {
    fn new(run: &LiveRun<'a>) -> Result<Self, RunError> {
        let site = run.site;
        let mut broker = Broker::start(site.url.clone(), site.password.clone())
            .map_err(|error| RunError::Failed(format!("can't start a thread: {error}")))?;
        broker.connect(&Session {
            client_id: format!("regatta-study-{}", std::process::id()),
            will: None,
            topics: site.vehicles.topics(&TOPICS),
        });
        Ok(Self {
            site,
            broker: Some(broker),
            is_up: false,
            vehicles: (0..run.vehicles as usize)
                .map(|robot| site.vehicles.vehicle(robot))
                .collect(),
            judge: Judge::new(Protocol::Auto),
            report: Report::new(1),
            meter: Meter::new(site.places()),
            load: None,
            hand_over: None,
            load_start: Instant::now(),
            again: Vec::new(),
            handed: 0,
            finished: 0,
            refusal: None,
            run: format!("{}-{}", run.vehicles, run.repeat),
        })
    }

    fn has_order(&self) -> bool {
        self.meter.figures().first_order.is_some()
    }

    fn start_load(&mut self, run: &LiveRun<'_>) -> Result<(), Failure> {
        if self.site.way == Way::Own {
            return Ok(());
        }
        let places = day::places(&run.plan.variant.graph);
        self.load = Some(LiveLoad::new(run.plan, run.vehicles, run.repeat, places)?);
        let words = self.site.words(run.vehicles);
        let password = self.site.password.as_deref();
        self.hand_over = Some(HandOver::start(&self.site.way, &words, password));
        self.load_start = Instant::now();
        Ok(())
    }

    /// Takes what has come, and hands over what is due.
    fn listen(&mut self) -> Result<(), RunError> {
        while let Some(incoming) = self.broker.as_ref().and_then(Broker::take) {
            self.receive(incoming)?;
        }
        for finding in self.judge.pass(seconds(SystemTime::now())) {
            self.report.add(finding);
        }
        self.hand_orders_over();
        Ok(())
    }

    fn receive(&mut self, incoming: Incoming) -> Result<(), RunError> {
        let url = &self.site.url;
        match incoming {
            Incoming::Connected { .. } => self.is_up = true,
            Incoming::Lost { reason, .. } if self.is_up => {
                let text = format!("{url}: the connection was lost ({reason})");
                return Err(RunError::Failed(text));
            }
            Incoming::Lost { reason, .. } => {
                let advice = "start the broker, or give another address, user or password";
                let text = format!("{url}: can't connect ({reason}): {advice}");
                return Err(RunError::Failed(text));
            }
            Incoming::Message { topic, payload, time } => {
                if time.elapsed().is_ok_and(|lag| lag > MOST_LAG) {
                    let text = "this machine is too slow to judge so many messages".to_owned();
                    return Err(RunError::Failed(text));
                }
                self.take(&topic, &payload, seconds(time));
            }
        }
        Ok(())
    }

    fn take(&mut self, topic: &str, payload: &[u8], time: f64) {
        let vehicle = topic.rsplit_once('/').map_or("", |(vehicle, _)| vehicle);
        if !self.vehicles.contains(vehicle) {
            return;
        }
        let seen = Seen { time: Some(time), topic, payload, delivery: None };
        for finding in self.judge.take(&seen) {
            self.report.add(finding);
        }
        self.meter.take(topic, payload, time);
    }

    fn hand_orders_over(&mut self) {
        let (Some(load), Some(hand_over)) = (&mut self.load, &self.hand_over) else { return };
        let secs = self.load_start.elapsed().as_secs_f64();
        let finished = &self.meter.figures().finished;
        for order in finished.iter().skip(self.finished).filter_map(|order| order.number) {
            load.finish(order, secs);
        }
        self.finished = finished.len();
        for Arrival { number, nodes } in load.arrivals(secs) {
            hand_over.hand_over(Transport {
                number,
                id: format!("regatta-{}-{number}", self.run),
                stations: nodes.map(|node| self.site.station(node)),
                nodes: nodes.map(|node| self.site.node(node)),
            });
        }
        let now = Instant::now();
        for (_, transport) in self.again.extract_if(.., |(time, _)| *time <= now) {
            hand_over.hand_over(transport);
        }
        while let Some(HandedOver { transport, result }) = hand_over.take() {
            match result {
                Ok(time) => {
                    let [pick, drop] = &transport.nodes;
                    self.meter.hand_over(transport.number, pick, drop, seconds(time));
                    self.handed += 1;
                }
                Err(reason) => {
                    self.refusal = Some(reason);
                    self.again.push((now + RETRY, transport));
                }
            }
        }
    }

    /// Ends the connection, and returns the figures.
    fn end(mut self) -> (Figures, Report) {
        if let Some(broker) = self.broker.take() {
            broker.end();
        }
        (self.meter.end(seconds(SystemTime::now())), self.report)
    }
}
