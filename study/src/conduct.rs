//! Conducts a study: asks sweeps for runs, gives them to workers, and puts the answer together.

mod estimate;
mod reliefs;

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use crate::answer::{Answer, Chosen, PeaksAnswer, TimeAnswer};
use crate::bottleneck::bottlenecks;
use crate::job::{Ending, Job, JobId};
use crate::outcome::Measured;
use crate::plan::{Plan, PlanError, Precision, Question, Variant, robots_in_words};
use crate::store::{Label, Store, StoreError};
use crate::sweep::{self, Curve, Known, Point, Run, RunResult, Step};
use crate::workers::{Report, RunFailure, Task, Workers, WorkersError};

use estimate::RunTimes;

/// The part of the robots' time from which on waiting may be the reason for late orders.
const MUCH_WAITING: f64 = 0.1;

/// The observer of a study.
pub trait Watcher {
    /// Whether the user wants it to end.
    fn is_interrupted(&self) -> bool;
    /// Called when a round of runs begins, and when a run of it has ended.
    fn progress(&self, progress: &Progress);
    /// Called when a run has failed, with a description of it and its failure.
    fn fail(&self, run: &str, failure: &RunFailure);
    /// Called when a file of the study's folder isn't used as it is, with its path and the reason.
    fn doubt(&self, line: &str);
}

/// The progress of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The number of the round, from 1.
    pub round: u64,
    /// The number of runs of the round.
    pub runs: usize,
    /// The number of these that have ended.
    pub done: usize,
    /// The number of these that are under way.
    pub running: usize,
    /// The number of runs of all rounds that have ended.
    pub finished: u64,
    /// The number of runs that are expected after this round; `None` if that isn't known.
    pub later: Option<usize>,
    /// The time to the end of the study, or of the round if nothing is known of later ones; `None`
    /// until a run has ended.
    pub to_go: Option<Duration>,
}

/// The error of a study.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Its files can't be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Runs can't be done.
    #[error(transparent)]
    Workers(#[from] WorkersError),
    /// A variant can't be made.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// No run of the first variant has succeeded.
    #[error("no run has succeeded: {0}")]
    AllFailed(RunFailure),
}

/// A study under way.
pub struct Conductor<'a> {
    plan: &'a Plan,
    store: &'a Store,
    workers: &'a mut dyn Workers,
    watcher: &'a dyn Watcher,
    times: RunTimes,
    /// The number of rounds so far.
    rounds: u64,
    /// The number of runs that have ended.
    ended: u64,
}

/// A variant with its layout's file, and the known results of its runs.
struct Experiment<'a> {
    variant: &'a Variant,
    layout: String,
    known: Known,
}

/// A run of an experiment, by its index.
#[derive(Clone, Copy)]
struct Wanted {
    experiment: usize,
    run: Run,
}

impl<'a> Conductor<'a> {
    /// Makes a conductor.
    pub fn new(
        plan: &'a Plan,
        store: &'a Store,
        workers: &'a mut dyn Workers,
        watcher: &'a dyn Watcher,
    ) -> Self {
        Self { plan, store, workers, watcher, times: RunTimes::default(), rounds: 0, ended: 0 }
    }

    /// Does all runs that aren't done yet, and returns the answer.
    ///
    /// # Errors
    /// [`StudyError`]. Finished runs are kept in any case.
    pub fn conduct(&mut self) -> Result<Answer, StudyError> {
        let plan = self.plan;
        let mut experiments = self.experiments(&plan.variants)?;
        let curves = self.sweep(&mut experiments)?;
        let [first, ..] = &curves[..] else {
            let reason = "the plan has no variants".to_owned();
            return Err(StudyError::AllFailed(RunFailure::Failed(reason)));
        };
        if let (Some((_, reason)), true) = (first.failed.first(), first.points.is_empty()) {
            return Err(StudyError::AllFailed(reason.clone()));
        }
        let mut chosen = Chosen::default();
        if let Some(index) = first.chosen() {
            let point = &first.points[index];
            let (robots, seeds) = (point.robots, &*point.seeds);
            if plan.question == Question::Knee {
                // The other variants need the runs of the first one at its knee, to be compared
                // with it.
                let others = runs(1..experiments.len(), robots, seeds);
                let later = self.runs_of_reliefs(point.robots);
                self.round(&mut experiments, &others, Some(later))?;
            }
            chosen = self.look_at(&experiments[0], point);
            chosen.reliefs = self.relieve(&experiments[0], point, &chosen)?;
        }
        let mut places = Vec::new();
        for (experiment, curve) in experiments.iter().zip(&curves) {
            places.push(self.place(experiment, curve));
        }
        let known: Vec<Known> =
            experiments.into_iter().map(|experiment| experiment.known).collect();
        self.tell_doubts();
        Ok(Answer::new(plan, &curves, &known, &places, chosen))
    }

    /// Returns a point of an experiment in detail, without reliefs.
    fn look_at(&self, experiment: &Experiment<'_>, point: &Point) -> Chosen {
        let (variant, ids) = (experiment.variant, self.ids(experiment, point));
        let (edges, outcomes) = (self.store.edges(&ids), self.store.outcomes(&ids));
        let is_day = variant.ending() == Ending::AfterOrders;
        Chosen {
            bottlenecks: bottlenecks(variant, &edges, waiting_robots(point), self.plan.time.secs),
            edges,
            reliefs: None,
            time: TimeAnswer::new(&variant.graph, &outcomes),
            peaks: PeaksAnswer::new(point.robots, variant.clock(), &outcomes).filter(|_| is_day),
        }
    }

    /// Returns the jobs of the runs of a point.
    fn ids(&self, experiment: &Experiment<'_>, point: &Point) -> Vec<JobId> {
        let seeds = point.seeds.iter();
        seeds.map(|seed| self.job(experiment, (point.robots, *seed)).id()).collect()
    }

    /// Returns the place that robots wait for the most in the runs that miss a target, unless they
    /// hardly wait.
    fn place(&self, experiment: &Experiment<'_>, curve: &Curve) -> Option<String> {
        let point = &curve.points[curve.binding()?];
        let waiting = point.interval(|run| Some(run.waiting))?.mean;
        if waiting < MUCH_WAITING {
            return None;
        }
        let edges = self.store.edges(&self.ids(experiment, point));
        let waiting = waiting_robots(point);
        let found = bottlenecks(experiment.variant, &edges, waiting, self.plan.time.secs);
        Some(found.first()?.place())
    }

    fn experiments<'v>(
        &self,
        variants: impl IntoIterator<Item = &'v Variant>,
    ) -> Result<Vec<Experiment<'v>>, StudyError> {
        let mut experiments = Vec::new();
        for variant in variants {
            let layout = self.store.keep_layout(&variant.layout_text())?;
            experiments.push(Experiment { variant, layout, known: Known::new() });
        }
        Ok(experiments)
    }

    /// Sweeps all variants side by side, round by round.
    fn sweep(&mut self, experiments: &mut [Experiment<'_>]) -> Result<Vec<Curve>, StudyError> {
        loop {
            let mut wanted = Vec::new();
            let mut curves = Vec::new();
            for (index, experiment) in experiments.iter().enumerate() {
                let Plan { question, robots, precision, .. } = self.plan;
                match sweep::next(question, robots, precision, &experiment.known) {
                    Step::Done(curve) => curves.push(curve),
                    Step::Needs(runs) => {
                        wanted
                            .extend(runs.into_iter().map(|run| Wanted { experiment: index, run }));
                    }
                }
            }
            if wanted.is_empty() {
                return Ok(curves);
            }
            wanted.sort_by_key(|wanted| (Reverse(wanted.run.0), wanted.run.1));
            let later = self.later(experiments).unwrap_or_else(|| self.first_guess(&wanted));
            self.round(experiments, &wanted, Some(later))?;
        }
    }

    /// Returns the robots of the runs that are expected after the next round of the sweep: those of
    /// all sweeps, those that are compared with the first variant, and those that try reliefs.
    fn later(&self, experiments: &[Experiment<'_>]) -> Option<Vec<u32>> {
        let Plan { question, robots, precision, .. } = self.plan;
        let (mut later, mut chosen) = (Vec::new(), None);
        for experiment in experiments {
            let outlook = sweep::outlook(question, robots, precision, &experiment.known)?;
            later.extend(outlook.later.iter().map(|run| run.0));
            chosen = chosen.or(outlook.chosen);
        }
        if let Some(robots) = chosen {
            if *question == Question::Knee {
                let compared = (experiments.len() - 1) * precision.least_seeds as usize;
                later.extend(std::iter::repeat_n(robots, compared));
            }
            later.extend(self.runs_of_reliefs(robots));
        }
        Some(later)
    }

    /// Returns the robots of the runs that are expected after the first round, as long as no run has
    /// ended: as many as in the first round, and those that try reliefs.
    fn first_guess(&self, wanted: &[Wanted]) -> Vec<u32> {
        let mut later: Vec<u32> = wanted.iter().map(|wanted| wanted.run.0).collect();
        // They are sorted by the number of robots.
        if let Some(robots) = later.get(later.len() / 2).copied() {
            later.extend(self.runs_of_reliefs(robots));
        }
        later
    }

    /// Returns the robots of the runs that are expected to try reliefs, before any has been tried.
    fn runs_of_reliefs(&self, robots: u32) -> Vec<u32> {
        let Precision { least_seeds, most_seeds, .. } = self.plan.precision;
        let seeds = least_seeds.midpoint(most_seeds) as usize;
        vec![robots; self.plan.reliefs * seeds]
    }

    fn job(&self, experiment: &Experiment<'_>, (robots, seed): Run) -> Job {
        let Plan { time, program, .. } = self.plan;
        experiment.variant.job(&experiment.layout, robots, seed, *time, program)
    }

    /// Does runs of some experiments, except those that were done before. `later` are the robots of
    /// the runs that are expected afterwards.
    fn round(
        &mut self,
        experiments: &mut [Experiment<'_>],
        wanted: &[Wanted],
        later: Option<Vec<u32>>,
    ) -> Result<(), StudyError> {
        let mut tasks = Vec::new();
        let mut robots = BTreeMap::new();
        let mut by_id: BTreeMap<JobId, Vec<Wanted>> = BTreeMap::new();
        for &wanted in wanted {
            let experiment = &mut experiments[wanted.experiment];
            if experiment.known.contains_key(&wanted.run) {
                continue;
            }
            let job = self.job(experiment, wanted.run);
            let id = job.id();
            if let Some(measured) = self.finished(experiment.variant, &id, wanted.run)? {
                experiment.known.insert(wanted.run, Ok(measured));
                continue;
            }
            // Two experiments may want the same job: reliefs of neighbouring places, or settings
            // that change nothing.
            let wanting = by_id.entry(id.clone()).or_default();
            wanting.push(wanted);
            if wanting.len() > 1 {
                continue;
            }
            self.store.keep_job(&job)?;
            let (job, result) = (self.store.job_file(&id), self.store.result_file(&id));
            let layout = self.store.files().join(&experiment.layout);
            robots.insert(id.clone(), wanted.run.0);
            tasks.push(Task { id, job, layout, result });
        }
        self.tell_doubts();
        let (reports, done) = self.work(&tasks, robots, later.as_deref());
        // Also those that ended before an interrupt.
        for Report { id, failure, wall_secs } in reports {
            if let (None, Some(secs)) = (&failure, wall_secs) {
                self.store.note_time(&id, secs);
            }
            let Some(wanting) = by_id.get(&id) else { continue };
            let Some(first) = wanting.first() else { continue };
            let result =
                self.result(experiments[first.experiment].variant, &id, first.run, failure)?;
            for wanted in wanting {
                experiments[wanted.experiment].known.insert(wanted.run, result.clone());
            }
        }
        self.store.settle()?;
        Ok(done?)
    }

    /// Gives tasks to the workers; returns their reports. `robots` are those of each task.
    fn work(
        &mut self,
        tasks: &[Task],
        mut robots: BTreeMap<JobId, u32>,
        later: Option<&[u32]>,
    ) -> (Vec<Report>, Result<(), WorkersError>) {
        if tasks.is_empty() {
            return (Vec::new(), Ok(()));
        }
        let (watcher, side_by_side) = (self.watcher, self.workers.size());
        self.rounds += 1;
        let mut progress = Progress {
            round: self.rounds,
            runs: tasks.len(),
            done: 0,
            running: side_by_side.min(tasks.len()),
            finished: self.ended,
            later: later.map(<[u32]>::len),
            to_go: None,
        };
        progress.to_go = self.times.to_go(all_robots(&robots, later), side_by_side);
        watcher.progress(&progress);
        let (times, mut reports) = (&mut self.times, Vec::new());
        let done = self.workers.run(tasks, &|| watcher.is_interrupted(), &mut |report| {
            if let (Some(robots), Some(secs)) = (robots.remove(&report.id), report.wall_secs) {
                times.note(robots, secs);
            }
            progress.done += 1;
            progress.finished += 1;
            progress.running = side_by_side.min(tasks.len() - progress.done);
            progress.to_go = times.to_go(all_robots(&robots, later), side_by_side);
            watcher.progress(&progress);
            reports.push(report);
        });
        self.ended = progress.finished;
        (reports, done)
    }

    fn result(
        &self,
        variant: &Variant,
        id: &JobId,
        run: Run,
        failure: Option<RunFailure>,
    ) -> Result<RunResult, StudyError> {
        let failure = match failure {
            Some(failure) => failure,
            None => match self.take_result(variant, id, run)? {
                Some(measured) => return Ok(Ok(measured)),
                None => RunFailure::Failed("it left no result".to_owned()),
            },
        };
        self.watcher.fail(&describe(variant, run), &failure);
        Ok(Err(failure))
    }

    /// Returns the figures of a run that was done before.
    fn finished(
        &self,
        variant: &Variant,
        id: &JobId,
        (robots, seed): Run,
    ) -> Result<Option<Measured>, StudyError> {
        let command = &command(id);
        let label = Label { variant: &variant.name, robots, seed, command };
        Ok(self.store.finished(id, &label)?)
    }

    fn take_result(
        &self,
        variant: &Variant,
        id: &JobId,
        (robots, seed): Run,
    ) -> Result<Option<Measured>, StudyError> {
        let command = &command(id);
        let label = Label { variant: &variant.name, robots, seed, command };
        Ok(self.store.take_result(id, &label)?)
    }

    fn tell_doubts(&self) {
        for doubt in self.store.take_doubts() {
            self.watcher.doubt(&doubt);
        }
    }
}

/// Returns the command that repeats a run, in the study's folder.
fn command(id: &JobId) -> String {
    format!("regatta study-run jobs/{id}.json")
}

/// Returns the runs of some experiments with a number of robots and some seeds.
fn runs(experiments: Range<usize>, robots: u32, seeds: &[u64]) -> Vec<Wanted> {
    let mut runs = Vec::new();
    for experiment in experiments {
        runs.extend(seeds.iter().map(|&seed| Wanted { experiment, run: (robots, seed) }));
    }
    runs
}

/// Returns the robots of the runs of a round that haven't ended, and of later ones.
fn all_robots(left: &BTreeMap<JobId, u32>, later: Option<&[u32]>) -> Vec<u32> {
    left.values().chain(later.unwrap_or_default()).copied().collect()
}

/// Returns the mean number of robots that wait at a point.
fn waiting_robots(point: &Point) -> f64 {
    let share = point.interval(|run| Some(run.waiting)).map_or(0.0, |waiting| waiting.mean);
    share * f64::from(point.robots)
}

fn describe(variant: &Variant, (robots, seed): Run) -> String {
    let name = if variant.name.is_empty() { String::new() } else { format!(", {}", variant.name) };
    format!("{}, seed {seed}{name}", robots_in_words(robots))
}
