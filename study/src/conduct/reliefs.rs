//! The reliefs of an answer: candidates, and their race.

use super::{Conductor, Experiment, StudyError, Wanted};
use crate::answer::Chosen;
use crate::plan::{Precision, Variant};
use crate::relief::race::{Race, Round, Standing};
use crate::relief::{Candidate, Measure, Relief, Reliefs, Site, candidates};
use crate::sweep::Point;

/// The most candidates that are looked at: of a large plant, most places are alike.
const LOOKED_AT: usize = 60;

impl Conductor<'_> {
    /// Tries the candidates for reliefs; `None` if none are asked for.
    pub(super) fn relieve(
        &mut self,
        base: &Experiment<'_>,
        point: &Point,
        chosen: &Chosen,
    ) -> Result<Option<Reliefs>, StudyError> {
        if self.plan.reliefs == 0 {
            return Ok(None);
        }
        let outcomes = self.store.outcomes(&self.ids(base, point));
        let Chosen { edges, bottlenecks, .. } = chosen;
        let site = Site::new(base.variant, point, edges, &outcomes, bottlenecks);
        let (mut field, mut variants, mut others) = (Vec::new(), Vec::new(), Vec::new());
        for candidate in candidates(&site).into_iter().take(LOOKED_AT) {
            if field.len() == self.plan.reliefs {
                others.push(candidate);
                continue;
            }
            let variant = candidate.applied(base.variant);
            let rate_hz = self.plan.time.rate_hz;
            if let Some(variant) = variant.filter(|variant| variant.check(rate_hz).is_ok()) {
                field.push(candidate);
                variants.push(variant);
            }
        }
        let measure = Measure::of(self.plan, base.variant, point);
        let mut reliefs = self.race(base, point.robots, measure, &field, &variants)?;
        reliefs.others = others;
        Ok(Some(reliefs))
    }

    /// Runs a race of candidates and their variants.
    fn race(
        &mut self,
        base: &Experiment<'_>,
        robots: u32,
        measure: Measure,
        field: &[Candidate],
        variants: &[Variant],
    ) -> Result<Reliefs, StudyError> {
        let mut experiments = self.experiments(std::iter::once(base.variant).chain(variants))?;
        experiments[0].known = base.known.clone();
        let Precision { least_seeds, most_seeds, .. } = self.plan.precision;
        loop {
            let race = Race {
                robots,
                measure,
                seeds: [least_seeds, most_seeds],
                base: &experiments[0].known,
                known: experiments[1..].iter().map(|experiment| &experiment.known).collect(),
            };
            let standings = match race.next() {
                Round::Over(standings) => standings,
                Round::Needs { base, candidates } => {
                    let mut wanted = Vec::new();
                    wanted.extend(base.into_iter().map(|run| Wanted { experiment: 0, run }));
                    wanted.extend(
                        candidates
                            .into_iter()
                            .map(|(index, run)| Wanted { experiment: index + 1, run }),
                    );
                    let later = vec![robots; race.outlook()];
                    self.round(&mut experiments, &wanted, Some(later))?;
                    continue;
                }
            };
            let mut tried = Vec::new();
            for (candidate, standing) in field.iter().zip(&standings) {
                tried.push(race.relief(tried.len(), candidate.clone(), standing));
            }
            let mean = |relief: &Relief| relief.gain.map_or(f64::NEG_INFINITY, |gain| gain.mean);
            tried.sort_by(|a, b| a.verdict.cmp(&b.verdict).then(mean(b).total_cmp(&mean(a))));
            let seeds = standings.iter().map(Standing::seeds).max().unwrap_or(least_seeds);
            let (base, figure) = (race.base_mean(seeds), measure.name());
            return Ok(Reliefs { robots, figure, base, tried, others: Vec::new(), measure });
        }
    }
}
