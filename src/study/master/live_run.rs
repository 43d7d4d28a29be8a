//! A run of a master in real time: engine, vehicles and validator as processes, the judge and the
//! meter on a connection of their own to the broker.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use regatta_plugin::{Control, Termination};
use regatta_study::master::{MasterPlan, RawFigures};
use regatta_vda5050::broker::PASSWORD_VARIABLE;
use regatta_vda5050::meter::{Answer, Figures};

use super::ear::Ear;
use super::figures::raw;
use super::site::Site;
use super::start;
use crate::failure::Failure;
use crate::lockstep_run::{ENGINE, LockstepRun, POLL_INTERVAL};
use crate::program::Program;

const VEHICLES: &str = "vehicles";
const OBSERVERS: &str = "observers";
const MASTER: &str = "master";
const VALIDATOR: &str = "validator";
/// The files of the observers, of which only the validator's is used.
const FILES: [&str; 5] = ["traffic", "queues", "meter", "states", VALIDATOR];
/// The longest time until all vehicles are there, and until the master's first order.
const START: Duration = Duration::from_secs(60);
/// The longest time until the first order of a master that has to be connected by hand.
const START_BY_HAND: Duration = Duration::from_mins(10);
/// A master that owes bases has stopped if it sends no order for so many seconds, and for so many
/// times the longest that it has taken for a base.
const SILENCE_SECS: f64 = 10.0;
const SILENCE: f64 = 3.0;
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
            ear.placed_vehicles() >= self.vehicles as usize
        })
        .map_err(|error| self.no_vehicles(error, &ear))?;
        if let Some(command) = self.site.master(self.vehicles) {
            processes.start(MASTER, &mut processes.logged(MASTER, command)?)?;
        }
        ear.start_load(self)?;
        self.wait(&mut processes, &mut ear, self.patience(), |ear| ear.has_order())
            .map_err(|error| self.no_order(error, &ear))?;
        let (time, start) = (Duration::from_secs(self.plan.time.secs), Moment::now(&processes)?);
        match self.wait(&mut processes, &mut ear, time, |_| false) {
            Ok(()) | Err(Wait::Late) => {}
            Err(Wait::Over(error)) => return Err(error),
        }
        self.check_speed(&processes, start)?;
        let (figures, report) = ear.end();
        self.check(&figures)?;
        self.stop(processes).and_then(|validator| {
            Ok(raw(self.site, self.plan.time.secs as f64, figures, &report, &validator)?)
        })
    }

    /// The longest time until the master's first order.
    fn patience(&self) -> Duration {
        let is_by_hand = self.site.manager.is_none() && self.site.vehicles.broker.is_none();
        if is_by_hand { START_BY_HAND } else { START }
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
                // So does a Ctrl-C.
                let is_interrupted = self.termination.requested();
                let error = if is_interrupted { RunError::Interrupted } else { failure.into() };
                return Err(Wait::Over(error));
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
                ear.placed_vehicles(),
                self.vehicles,
                START.as_secs()
            )),
        }
    }

    fn no_order(&self, wait: Wait, ear: &Ear<'_>) -> RunError {
        let Wait::Late = wait else { return wait.into() };
        let secs = self.patience().as_secs();
        let url = &self.site.url;
        RunError::Failed(match (ear.refusal(), ear.handed()) {
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

    /// Checks that the vehicles have moved in real time since a moment.
    fn check_speed(&self, processes: &LockstepRun, since: Moment) -> Result<(), RunError> {
        let now = Moment::now(processes)?;
        let wall = now.wall.duration_since(since.wall).as_secs_f64();
        let factor = (now.simulated_secs - since.simulated_secs) / wall;
        if factor >= LEAST_SPEED {
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
                 broker is too slow to measure the master's times"
            )));
        }
        let end = figures.first_order.unwrap_or(0.0) + self.plan.time.secs as f64;
        let silent = end - figures.last_order.unwrap_or(0.0);
        let came = figures.bases.iter().filter(|base| !base.answer.is_missing());
        let slowest = came.map(|base| base.secs).fold(0.0, f64::max);
        let owes = figures.bases.iter().filter(|base| base.answer == Answer::MissingFree).count();
        if owes > 0 && silent > SILENCE_SECS + SILENCE * slowest {
            return Err(RunError::Failed(format!(
                "the master sent its last order {silent:.0} s before the end, while {owes} \
                 vehicles waited for bases that were free: it has stopped"
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

/// The time of the fleet at a time on the clock.
#[derive(Clone, Copy)]
struct Moment {
    wall: Instant,
    simulated_secs: f64,
}

impl Moment {
    fn now(processes: &LockstepRun) -> Result<Self, RunError> {
        let control = Control::open(processes.fleet()).map_err(Failure::from);
        let status = control?.status().map_err(Failure::from)?;
        let simulated_secs = Duration::from_nanos(status.sim_time_nanos).as_secs_f64();
        Ok(Self { wall: Instant::now(), simulated_secs })
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
            Wait::Late => Self::Failed("the time of the run is over".to_owned()),
        }
    }
}
