//! Conducts a study: asks sweeps for runs, gives them to workers, and puts the answer together.

mod reliefs;

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::ops::Range;

use crate::answer::{Answer, Chosen, PeaksAnswer, TimeAnswer};
use crate::bottleneck::bottlenecks;
use crate::job::{Ending, Job, JobId};
use crate::outcome::Measured;
use crate::plan::{Plan, PlanError, Question, Variant, robots_in_words};
use crate::store::{Label, Store, StoreError};
use crate::sweep::{self, Curve, Known, Point, Run, RunResult, Step};
use crate::workers::{Report, RunFailure, Task, Workers, WorkersError};

/// The part of the robots' time from which on waiting may be the reason for late orders.
const MUCH_WAITING: f64 = 0.1;

/// The observer of a study.
pub trait Watcher {
    /// Whether the user wants it to end.
    fn is_interrupted(&self) -> bool;
    /// Called when a round of runs begins.
    fn begin(&self, round: Round);
    /// Called when a run of the round has ended.
    fn end(&self);
    /// Called when a run has failed, with a description of it and its failure.
    fn fail(&self, run: &str, failure: &RunFailure);
    /// Called when a file of the study's folder isn't used as it is, with its path and the reason.
    fn doubt(&self, line: &str);
}

/// A round of runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Round {
    /// The number of runs.
    pub runs: usize,
    /// The number of runs side by side.
    pub side_by_side: usize,
    /// The number of runs that are expected after this round; `None` as long as nothing is known.
    pub later: Option<usize>,
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
        Self { plan, store, workers, watcher }
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
                self.round(&mut experiments, &others, Some(plan.reliefs * seeds.len()))?;
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
            let later = self.later(experiments, wanted.len());
            self.round(experiments, &wanted, later)?;
        }
    }

    /// Returns the number of runs that are expected after a round of the sweep: those of all
    /// sweeps, and those that try reliefs.
    fn later(&self, experiments: &[Experiment<'_>], runs: usize) -> Option<usize> {
        let Plan { question, robots, precision, .. } = self.plan;
        let mut all = self.plan.reliefs * precision.least_seeds as usize;
        for experiment in experiments {
            all += sweep::outlook(question, robots, precision, &experiment.known)?;
        }
        Some(all.saturating_sub(runs))
    }

    fn job(&self, experiment: &Experiment<'_>, (robots, seed): Run) -> Job {
        let Plan { time, program, .. } = self.plan;
        experiment.variant.job(&experiment.layout, robots, seed, *time, program)
    }

    /// Does runs of some experiments, except those that were done before. `later` is the number of
    /// runs that are expected afterwards.
    fn round(
        &mut self,
        experiments: &mut [Experiment<'_>],
        wanted: &[Wanted],
        later: Option<usize>,
    ) -> Result<(), StudyError> {
        let mut tasks = Vec::new();
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
            tasks.push(Task { id, job, layout, result });
        }
        self.tell_doubts();
        if !tasks.is_empty() {
            let side_by_side = self.workers.size();
            self.watcher.begin(Round { runs: tasks.len(), side_by_side, later });
        }
        let (watcher, mut reports) = (self.watcher, Vec::new());
        let done = self.workers.run(&tasks, &|| watcher.is_interrupted(), &mut |report| {
            watcher.end();
            reports.push(report);
        });
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

/// Returns the mean number of robots that wait at a point.
fn waiting_robots(point: &Point) -> f64 {
    let share = point.interval(|run| Some(run.waiting)).map_or(0.0, |waiting| waiting.mean);
    share * f64::from(point.robots)
}

fn describe(variant: &Variant, (robots, seed): Run) -> String {
    let name = if variant.name.is_empty() { String::new() } else { format!(", {}", variant.name) };
    format!("{}, seed {seed}{name}", robots_in_words(robots))
}
