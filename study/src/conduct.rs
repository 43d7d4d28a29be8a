//! Conducts a study: asks sweeps for runs, has them done, and puts the answer together.

use std::collections::BTreeMap;

use crate::answer::{Answer, Bottleneck, Relief, bottlenecks};
use crate::job::{Job, JobId};
use crate::outcome::Measured;
use crate::plan::{Plan, PlanError, Variant, robots_in_words};
use crate::store::{Label, Store, StoreError};
use crate::sweep::{self, Curve, Fate, Known, Run, Step};
use crate::workers::{Report, Task, Workers, WorkersError};

/// Who watches a study.
pub trait Watcher {
    /// Whether the user wants it to end.
    fn is_interrupted(&self) -> bool;
    /// Called when a round of runs begins, with their number and that of the runs side by side.
    fn begin(&self, runs: usize, side_by_side: usize);
    /// Called when a run of the round has ended.
    fn end(&self);
    /// Called when a run has failed, with its failure.
    fn fail(&self, what: &str, failure: &str);
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
    AllFailed(String),
}

/// A study under way.
pub struct Conductor<'a> {
    plan: &'a Plan,
    store: &'a Store,
    workers: &'a mut dyn Workers,
    watcher: &'a dyn Watcher,
}

/// A variant with its layout's file, and what is known of its runs.
struct Site<'a> {
    variant: &'a Variant,
    layout: String,
    known: Known,
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
        let mut sites = plan
            .variants
            .iter()
            .map(|variant| self.site(variant))
            .collect::<Result<Vec<_>, _>>()?;
        let curves = self.sweep(&mut sites)?;
        let [first, ..] = &curves[..] else {
            return Err(StudyError::AllFailed("the plan has no variants".to_owned()));
        };
        let Some(knee) = first.knee else {
            let reason = first
                .failed
                .first()
                .map_or("nothing was carried: no order was finished", |(_, reason)| reason);
            return Err(StudyError::AllFailed(reason.to_owned()));
        };
        let (robots, seeds) = (first.points[knee].robots, first.points[knee].runs.len() as u64);
        self.complete(&mut sites, robots, seeds)?;
        let ids: Vec<JobId> = (1..=seeds).map(|seed| self.id(&sites[0], (robots, seed))).collect();
        let edges = self.store.edges(&ids);
        let mut found = bottlenecks(&plan.variants[0], &edges, plan.secs);
        self.relieve(&sites[0], &mut found, robots, seeds)?;
        let known: Vec<Known> = sites.into_iter().map(|site| site.known).collect();
        Ok(Answer::new(plan, &curves, &known, found, edges))
    }

    fn site<'v>(&self, variant: &'v Variant) -> Result<Site<'v>, StudyError> {
        let layout = self.store.keep_layout(&variant.layout_text())?;
        Ok(Site { variant, layout, known: Known::new() })
    }

    /// Sweeps all variants side by side, round by round.
    fn sweep(&mut self, sites: &mut [Site<'_>]) -> Result<Vec<Curve>, StudyError> {
        let (robots, precision) = (&self.plan.robots, &self.plan.precision);
        loop {
            let steps: Vec<Step> =
                sites.iter().map(|site| sweep::next(robots, precision, &site.known)).collect();
            let needs = |(site, step): (usize, &Step)| match step {
                Step::Needs(runs) => runs.iter().map(|run| (site, *run)).collect(),
                Step::Done(_) => Vec::new(),
            };
            let mut wanted: Vec<(usize, Run)> = steps.iter().enumerate().flat_map(needs).collect();
            if wanted.is_empty() {
                let curve =
                    |step| if let Step::Done(curve) = step { curve } else { Curve::default() };
                return Ok(steps.into_iter().map(curve).collect());
            }
            wanted.sort_by_key(|(_, (robots, seed))| (std::cmp::Reverse(*robots), *seed));
            self.round(sites, &wanted)?;
        }
    }

    /// Does the runs of the other variants that the first one has at its knee, to compare them.
    fn complete(
        &mut self,
        sites: &mut [Site<'_>],
        robots: u32,
        seeds: u64,
    ) -> Result<(), StudyError> {
        let runs =
            (1..sites.len()).flat_map(|site| (1..=seeds).map(move |seed| (site, (robots, seed))));
        let wanted: Vec<_> =
            runs.filter(|(site, run)| !sites[*site].known.contains_key(run)).collect();
        self.round(sites, &wanted)
    }

    /// Tries the relief of the worst bottlenecks.
    fn relieve(
        &mut self,
        base: &Site<'_>,
        found: &mut [Bottleneck],
        robots: u32,
        seeds: u64,
    ) -> Result<(), StudyError> {
        let tried: Vec<(usize, Variant)> = (found.iter().enumerate().take(self.plan.reliefs))
            .filter_map(|(index, bottleneck)| Some((index, bottleneck.relieved(base.variant)?)))
            .collect();
        let mut sites =
            tried.iter().map(|(_, variant)| self.site(variant)).collect::<Result<Vec<_>, _>>()?;
        let runs =
            (0..sites.len()).flat_map(|site| (1..=seeds).map(move |seed| (site, (robots, seed))));
        self.round(&mut sites, &runs.collect::<Vec<_>>())?;
        for ((index, _), site) in tried.iter().zip(&sites) {
            found[*index].relief = Relief::of(&base.known, &site.known, robots);
        }
        Ok(())
    }

    fn id(&self, site: &Site<'_>, (robots, seed): Run) -> JobId {
        self.job(site, (robots, seed)).id()
    }

    fn job(&self, site: &Site<'_>, (robots, seed): Run) -> Job {
        site.variant.job(
            &site.layout,
            robots,
            seed,
            (self.plan.secs, self.plan.rate_hz),
            &self.plan.program,
        )
    }

    /// Does runs of some sites, those that aren't done yet.
    fn round(&mut self, sites: &mut [Site<'_>], wanted: &[(usize, Run)]) -> Result<(), StudyError> {
        let mut tasks = Vec::new();
        let mut by_id: BTreeMap<JobId, Vec<(usize, Run)>> = BTreeMap::new();
        for &(site, run) in wanted {
            let job = self.job(&sites[site], run);
            let id = job.id();
            if let Some(measured) = self.finished(&sites[site], &id, run)? {
                sites[site].known.insert(run, Fate::Done(measured));
                continue;
            }
            // Two sites may want the same job: reliefs of neighbouring places, or settings that
            // change nothing.
            let wanting = by_id.entry(id.clone()).or_default();
            wanting.push((site, run));
            if wanting.len() > 1 {
                continue;
            }
            self.store.keep_job(&job)?;
            let (job, result) = (self.store.job_file(&id), self.store.result_file(&id));
            let layout = self.store.files().join(&sites[site].layout);
            tasks.push(Task { id, job, layout, result });
        }
        if !tasks.is_empty() {
            self.watcher.begin(tasks.len(), self.workers.size());
        }
        let (watcher, mut reports) = (self.watcher, Vec::new());
        let done = self.workers.run(&tasks, &|| watcher.is_interrupted(), &mut |report| {
            watcher.end();
            reports.push(report);
        });
        // Also those that ended before an interrupt.
        for Report { id, failure } in reports {
            let Some(&(first, run)) = by_id.get(&id).and_then(|wanting| wanting.first()) else {
                continue;
            };
            let fate = self.fate(&sites[first], &id, run, failure)?;
            for &(site, run) in by_id.get(&id).into_iter().flatten() {
                sites[site].known.insert(run, fate.clone());
            }
        }
        Ok(done?)
    }

    fn fate(
        &self,
        site: &Site<'_>,
        id: &JobId,
        run: Run,
        failure: Option<String>,
    ) -> Result<Fate, StudyError> {
        let failure = match failure {
            Some(failure) => failure,
            None => {
                match self.store.take_result(id, &label(site.variant, run, &self.command(id)))? {
                    Some(measured) => return Ok(Fate::Done(measured)),
                    None => "it left no result".to_owned(),
                }
            }
        };
        self.watcher.fail(&describe(site.variant, run), &failure);
        Ok(Fate::Failed(failure))
    }

    /// Returns the figures of a run that was done before.
    fn finished(
        &self,
        site: &Site<'_>,
        id: &JobId,
        run: Run,
    ) -> Result<Option<Measured>, StudyError> {
        if let Some(measured) = self.store.measured(id)? {
            return Ok(Some(measured));
        }
        Ok(self.store.take_result(id, &label(site.variant, run, &self.command(id)))?)
    }

    /// The command that repeats a run, in the study's folder.
    fn command(&self, id: &JobId) -> String {
        format!("regatta study-run jobs/{id}.json")
    }
}

fn label<'a>(variant: &'a Variant, (robots, seed): Run, command: &'a str) -> Label<'a> {
    Label { variant: &variant.name, robots, seed, command }
}

fn describe(variant: &Variant, (robots, seed): Run) -> String {
    let name = if variant.name.is_empty() { String::new() } else { format!(", {}", variant.name) };
    format!("{}, seed {seed}{name}", robots_in_words(robots))
}
