//! Figures over the last minute, the last ten minutes, and the run.

use std::collections::VecDeque;

use regatta_plugin::traffic::{EdgeTraffic, TRAFFIC_PERIODS};

use crate::tally::Counts;

/// The last minute consists of parts of this length in seconds.
const PART_SECS: f64 = 10.0;
/// The number of parts in a minute.
const PARTS: usize = 6;
/// The number of values of [`Counts`].
const VALUES: usize = 7;
/// The number of minutes that are kept.
const MINUTES: usize = 10;

/// Counts of all edges, added up over some time.
#[derive(Clone, Debug, Default)]
struct Span {
    secs: f64,
    /// By edge.
    counts: Vec<Counts>,
}

impl Span {
    fn new(edges: usize) -> Self {
        Self { secs: 0.0, counts: vec![Counts::default(); edges] }
    }

    fn add(&mut self, other: &Self) {
        self.secs += other.secs;
        for (sum, counts) in self.counts.iter_mut().zip(&other.counts) {
            sum.add(counts, 1.0);
        }
    }
}

impl Counts {
    fn values(&self) -> [f32; VALUES] {
        [
            self.robots,
            self.entered,
            self.metres,
            self.waiting,
            self.touching,
            self.released,
            self.planned,
        ]
    }
}

/// Adds up the counts of frames.
#[derive(Debug, Default)]
pub struct Periods {
    /// The part that isn't over yet.
    part: Span,
    /// The last parts of a minute, oldest first.
    parts: VecDeque<Span>,
    /// The parts of the minute that isn't over yet, added up, and how many they are.
    minute: (Span, usize),
    /// The last minutes, oldest first.
    minutes: VecDeque<Span>,
    run_secs: f64,
    /// By edge: all parts of the run. A day of seconds is too long for single precision.
    run: Vec<[f64; VALUES]>,
}

impl Periods {
    /// Begins a run on a number of edges.
    pub fn new(edges: usize) -> Self {
        Self {
            part: Span::new(edges),
            minute: (Span::new(edges), 0),
            run: vec![[0.0; VALUES]; edges],
            ..Self::default()
        }
    }

    /// Adds the counts of a frame that lasted for some simulated seconds.
    pub fn add(&mut self, counts: &[Counts], secs: f64) {
        self.part.secs += secs;
        for (sum, counts) in self.part.counts.iter_mut().zip(counts) {
            sum.add(counts, secs as f32);
        }
        if self.part.secs >= PART_SECS {
            self.end_part();
        }
    }

    fn end_part(&mut self) {
        let edges = self.run.len();
        // The memory of the oldest part is reused.
        let mut next = if self.parts.len() < PARTS {
            Span::new(edges)
        } else {
            self.parts.pop_front().unwrap_or_default()
        };
        (next.secs, _) = (0.0, next.counts.fill(Counts::default()));
        let part = std::mem::replace(&mut self.part, next);
        self.run_secs += part.secs;
        for (sums, counts) in self.run.iter_mut().zip(&part.counts) {
            add_values(sums, counts);
        }
        self.minute.0.add(&part);
        self.minute.1 += 1;
        self.parts.push_back(part);
        if self.minute.1 == PARTS {
            let minute = std::mem::replace(&mut self.minute, (Span::new(edges), 0));
            self.minutes.push_back(minute.0);
            if self.minutes.len() > MINUTES {
                self.minutes.pop_front();
            }
        }
    }

    /// Returns the length of each period, in simulated seconds.
    pub fn secs(&self) -> [f64; TRAFFIC_PERIODS] {
        let [minute, ten_minutes] = [&self.parts, &self.minutes]
            .map(|spans| spans.iter().map(|span| span.secs).sum::<f64>() + self.part.secs);
        [minute, ten_minutes + self.minute.0.secs, self.run_secs + self.part.secs]
    }

    /// Writes the figures of all edges for each period. `limits` are the speed limits of the edges,
    /// in metres per second.
    pub fn figures(&self, limits: &[f32], figures: &mut Vec<EdgeTraffic>) {
        figures.clear();
        let [minute_secs, ten_minutes_secs, run_secs] = self.secs();
        let edges = limits.iter().enumerate().take(self.run.len());
        for (edge, &limit) in edges.clone() {
            figures.push(self.figure(self.parts.iter(), edge, minute_secs, limit));
        }
        for (edge, &limit) in edges.clone() {
            let spans = self.minutes.iter().chain([&self.minute.0]);
            figures.push(self.figure(spans, edge, ten_minutes_secs, limit));
        }
        for (edge, &limit) in edges {
            let mut sums = self.run[edge];
            add_values(&mut sums, &self.part.counts[edge]);
            figures.push(traffic(sums, run_secs, limit));
        }
    }

    /// Returns the figure of an edge over some spans and the part that isn't over yet.
    fn figure<'a>(
        &self,
        spans: impl Iterator<Item = &'a Span>,
        edge: usize,
        secs: f64,
        limit: f32,
    ) -> EdgeTraffic {
        let mut sum = self.part.counts[edge];
        for span in spans {
            sum.add(&span.counts[edge], 1.0);
        }
        traffic(sum.values().map(f64::from), secs, limit)
    }
}

fn add_values(sums: &mut [f64; VALUES], counts: &Counts) {
    for (sum, value) in sums.iter_mut().zip(counts.values()) {
        *sum += f64::from(value);
    }
}

fn traffic(
    [robots, entered, metres, waiting, touching, released, planned]: [f64; VALUES],
    secs: f64,
    limit: f32,
) -> EdgeTraffic {
    EdgeTraffic {
        occupancy: over(robots, secs),
        entered_per_hour: over(3600.0 * entered, secs),
        relative_speed: over(metres, robots * f64::from(limit)),
        waiting_secs: waiting as f32,
        contact_secs: touching as f32,
        released: over(released, secs),
        planned: over(planned, secs),
    }
}

fn over(value: f64, by: f64) -> f32 {
    if by > 0.0 { (value / by) as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn frame(robots: f32, entered: f32) -> Counts {
        let (released, planned) = (robots, 2.0 * robots);
        Counts {
            robots,
            entered,
            metres: robots,
            waiting: 0.5 * robots,
            touching: 0.0,
            released,
            planned,
        }
    }

    #[test]
    fn figures_are_means_and_sums_of_their_period() {
        let mut periods = Periods::new(1);
        let mut figures = Vec::new();
        // Ten minutes with one robot, then a minute and five seconds with three.
        (0..4800).for_each(|_| periods.add(&[frame(1.0, 0.0)], 0.125));
        (0..520).for_each(|_| periods.add(&[frame(3.0, 0.125)], 0.125));
        periods.figures(&[2.0], &mut figures);
        assert_eq!(periods.secs(), [65.0, 605.0, 665.0]);
        assert!((figures[0].occupancy - 3.0).abs() < 1e-3, "{figures:?}");
        assert!((figures[0].entered_per_hour - 3600.0).abs() < 5.0, "one a second: {figures:?}");
        assert!(
            (figures[0].released - 3.0).abs() < 1e-3 && (figures[0].planned - 6.0).abs() < 1e-3,
            "{figures:?}"
        );
        assert!(
            (figures[0].relative_speed - 0.5).abs() < 1e-3
                && (figures[0].waiting_secs - 97.5).abs() < 0.5
        );
        assert!((figures[2].occupancy - (600.0 + 195.0) / 665.0).abs() < 1e-3, "{figures:?}");
        // Half an hour later the minute and the ten minutes have forgotten them.
        (0..18_000).for_each(|_| periods.add(&[frame(0.0, 0.0)], 0.125));
        periods.figures(&[2.0], &mut figures);
        assert_eq!(
            (figures[0].occupancy, figures[1].waiting_secs, figures[0].relative_speed),
            (0.0, 0.0, 0.0)
        );
        assert!((figures[2].waiting_secs - 397.5).abs() < 0.5, "the run has not: {figures:?}");
    }

    proptest! {
        /// Whatever the lengths of frames are: the run is the sum of all, and shorter periods hold
        /// the newest of them.
        #[test]
        fn periods_hold_what_was_added(frames in prop::collection::vec((0.0_f32..5.0, 0.01_f64..20.0), 1..400)) {
            let mut periods = Periods::new(2);
            for (robots, secs) in &frames {
                periods.add(&[Counts::default(), frame(*robots, 0.0)], *secs);
            }
            let mut figures = Vec::new();
            periods.figures(&[1.0, 1.0], &mut figures);
            let [minute, ten, run] = periods.secs();
            let sum = |least: f64| {
                let mut rest = least;
                let newest = frames.iter().rev().take_while(|(_, secs)| { let is_in = rest > 1e-6; rest -= secs; is_in });
                newest.map(|(robots, secs)| f64::from(*robots) * 0.5 * secs).sum::<f64>()
            };
            for (period, secs) in [(0, minute), (1, ten), (2, run)] {
                let [nothing, edge] = [figures[2 * period], figures[2 * period + 1]];
                prop_assert_eq!(nothing, EdgeTraffic::default());
                let expected = sum(secs);
                prop_assert!((f64::from(edge.waiting_secs) - expected).abs() <= 1e-3 * expected.max(1.0), "{edge:?} {expected}");
            }
            prop_assert!(minute <= ten + 1e-9 && ten <= run + 1e-9);
        }
    }
}
