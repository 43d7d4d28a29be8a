//! Figures over the last minute, the last ten minutes, and the run.

use std::collections::VecDeque;

use regatta_plugin::traffic::{EdgeTraffic, TRAFFIC_PERIODS};

use crate::tally::{BLOCK, Counts, Driving, EdgeCounts, Extra, Sum};

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
    counts: EdgeCounts,
}

impl Span {
    fn new(edges: usize) -> Self {
        Self { secs: 0.0, counts: EdgeCounts::new(edges) }
    }

    fn add(&mut self, other: &Self) {
        self.secs += other.secs;
        self.counts.add(&other.counts, 1.0);
    }

    fn clear(&mut self) {
        self.secs = 0.0;
        self.counts.clear();
    }
}

impl Counts {
    fn values(&self) -> [f32; VALUES] {
        let Driving { robots, entered, metres, waiting } = self.driving;
        let Extra { touching, released, planned } = self.extra;
        [robots, entered, metres, waiting, touching, released, planned]
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
    run: Run,
    /// By edge: the robots that have entered it in the last minute. Whole numbers are exact in any
    /// order, so they can be added and subtracted.
    entered: Vec<f32>,
}

/// All parts of the run that are over.
#[derive(Debug, Default)]
struct Run {
    secs: f64,
    /// By edge. A day of seconds is too long for single precision.
    values: Vec<[f64; VALUES]>,
}

impl Run {
    fn add(&mut self, part: &Span) {
        self.secs += part.secs;
        let blocks = self.values.chunks_mut(BLOCK).enumerate();
        for (block, sums) in blocks.filter(|(block, _)| part.counts.is_in_use(*block)) {
            for (row, sums) in sums.iter_mut().enumerate() {
                add_values(sums, &part.counts.get(block * BLOCK + row));
            }
        }
    }

    /// Writes the figures of all edges over the run and the part that isn't over yet.
    fn write(&self, figures: &mut [EdgeTraffic], limits: &[f32], secs: f64, part: &Span) {
        let edges = self.values.iter().zip(figures.iter_mut().zip(limits)).enumerate();
        for (edge, (sums, (figure, limit))) in edges {
            let mut sums = *sums;
            add_values(&mut sums, &part.counts.get(edge));
            *figure = traffic(sums, secs, *limit);
        }
    }
}

impl Periods {
    /// Begins a run on a number of edges.
    pub fn new(edges: usize) -> Self {
        Self {
            part: Span::new(edges),
            minute: (Span::new(edges), 0),
            run: Run { secs: 0.0, values: vec![[0.0; VALUES]; edges] },
            entered: vec![0.0; edges],
            ..Self::default()
        }
    }

    /// Adds the counts of a frame that lasted for some simulated seconds.
    pub fn add(&mut self, counts: &EdgeCounts, secs: f64) {
        self.part.secs += secs;
        self.part.counts.add(counts, secs as f32);
        self.count_entered(counts, 1.0);
        if self.part.secs >= PART_SECS {
            self.end_part();
        }
    }

    fn end_part(&mut self) {
        let mut next = self.forgotten_part().unwrap_or_else(|| Span::new(self.entered.len()));
        next.clear();
        let part = std::mem::replace(&mut self.part, next);
        self.run.add(&part);
        self.minute.0.add(&part);
        self.minute.1 += 1;
        self.parts.push_back(part);
        if self.minute.1 == PARTS {
            let next = Span::new(self.entered.len());
            let (minute, _) = std::mem::replace(&mut self.minute, (next, 0));
            self.minutes.push_back(minute);
            if self.minutes.len() > MINUTES {
                self.minutes.pop_front();
            }
        }
    }

    /// Takes the oldest part out of the last minute, so that its memory can be reused; `None` if
    /// there is room for another part.
    fn forgotten_part(&mut self) -> Option<Span> {
        if self.parts.len() < PARTS {
            return None;
        }
        let part = self.parts.pop_front()?;
        self.count_entered(&part.counts, -1.0);
        Some(part)
    }

    fn count_entered(&mut self, counts: &EdgeCounts, sign: f32) {
        for (block, counts) in counts.driving.in_use() {
            for (entered, counts) in self.entered[block * BLOCK..].iter_mut().zip(counts) {
                *entered += sign * counts.entered;
            }
        }
    }

    /// Returns the length of each period, in simulated seconds.
    pub fn secs(&self) -> [f64; TRAFFIC_PERIODS] {
        let [minute, ten_minutes] = [&self.parts, &self.minutes]
            .map(|spans| spans.iter().map(|span| span.secs).sum::<f64>() + self.part.secs);
        [minute, ten_minutes + self.minute.0.secs, self.run.secs + self.part.secs]
    }

    /// Returns the robots that entered an edge, per hour, over the last minute: the sum of
    /// [`EdgeTraffic::entered_per_hour`] over all edges, in their order.
    pub fn throughput(&self) -> f32 {
        let [minute_secs, ..] = self.secs();
        let entered = self.entered.iter().filter(|entered| **entered > 0.0);
        entered.fold(0.0, |sum, entered| sum + per_hour(f64::from(*entered), minute_secs))
    }

    /// Writes the figures of all edges for each period. `limits` are the speed limits of the edges,
    /// in metres per second.
    pub fn figures(&self, limits: &[f32], figures: &mut Vec<EdgeTraffic>) {
        let edges = limits.len().min(self.entered.len());
        figures.clear();
        figures.resize(TRAFFIC_PERIODS * edges, EdgeTraffic::default());
        let (minute, longer) = figures.split_at_mut(edges);
        let (ten_minutes, run) = longer.split_at_mut(edges);
        let [minute_secs, ten_minutes_secs, run_secs] = self.secs();
        self.write(minute, limits, minute_secs, self.parts.iter());
        let minutes = self.minutes.iter().chain([&self.minute.0]);
        self.write(ten_minutes, limits, ten_minutes_secs, minutes);
        self.run.write(run, limits, run_secs, &self.part);
    }

    /// Writes the figures of all edges over the part that isn't over yet and some spans, which are
    /// added up in this order. Those of edges without counts stay as they are.
    fn write<'a>(
        &'a self,
        figures: &mut [EdgeTraffic],
        limits: &[f32],
        secs: f64,
        spans: impl Iterator<Item = &'a Span> + Clone,
    ) {
        let (mut driving, mut extra) = (Vec::new(), Vec::new());
        let blocks = figures.chunks_mut(BLOCK).zip(limits.chunks(BLOCK));
        for (block, (figures, limits)) in blocks.enumerate() {
            let spans = [&self.part].into_iter().chain(spans.clone()).map(|span| &span.counts);
            driving.clear();
            driving.extend(spans.clone().filter_map(|counts| counts.driving.block(block)));
            extra.clear();
            extra.extend(spans.filter_map(|counts| counts.extra.block(block)));
            if driving.is_empty() && extra.is_empty() {
                continue;
            }
            for (row, (figure, limit)) in figures.iter_mut().zip(limits).enumerate() {
                let sums = Counts { driving: sum(&driving, row), extra: sum(&extra, row) };
                *figure = traffic(sums.values().map(f64::from), secs, *limit);
            }
        }
    }
}

/// Returns the sum of a row of some blocks, added up in their order.
fn sum<T: Sum>(blocks: &[&[T]], row: usize) -> T {
    let mut sum = T::default();
    for counts in blocks {
        sum.add(&counts[row], 1.0);
    }
    sum
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
        entered_per_hour: per_hour(entered, secs),
        relative_speed: over(metres, robots * f64::from(limit)),
        waiting_secs: waiting as f32,
        contact_secs: touching as f32,
        released: over(released, secs),
        planned: over(planned, secs),
    }
}

fn per_hour(value: f64, secs: f64) -> f32 {
    over(3600.0 * value, secs)
}

fn over(value: f64, by: f64) -> f32 {
    // Most values of most edges are zero, and a division takes longer than the comparison.
    if value != 0.0 && by > 0.0 { (value / by) as f32 } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn frame(robots: f32, entered: f32) -> Counts {
        let driving = Driving { robots, entered, metres: robots, waiting: 0.5 * robots };
        let extra = Extra { touching: 0.0, released: robots, planned: 2.0 * robots };
        Counts { driving, extra }
    }

    #[test]
    fn figures_are_means_and_sums_of_their_period() {
        let mut periods = Periods::new(1);
        let mut figures = Vec::new();
        // Ten minutes with one robot, then a minute and five seconds with three.
        (0..4800).for_each(|_| add(&mut periods, &[frame(1.0, 0.0)], 0.125));
        (0..520).for_each(|_| add(&mut periods, &[frame(3.0, 0.125)], 0.125));
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
        (0..18_000).for_each(|_| add(&mut periods, &[frame(0.0, 0.0)], 0.125));
        periods.figures(&[2.0], &mut figures);
        assert_eq!(
            (figures[0].occupancy, figures[1].waiting_secs, figures[0].relative_speed),
            (0.0, 0.0, 0.0)
        );
        assert!((figures[2].waiting_secs - 397.5).abs() < 0.5, "the run has not: {figures:?}");
    }

    fn add(periods: &mut Periods, counts: &[Counts], secs: f64) {
        let mut frame = EdgeCounts::new(counts.len());
        for (edge, counts) in counts.iter().enumerate() {
            *frame.driving.get_mut(edge).expect("an edge") = counts.driving;
            *frame.extra.get_mut(edge).expect("an edge") = counts.extra;
        }
        periods.add(&frame, secs);
    }

    proptest! {
        /// Whatever the lengths of frames are: the run is the sum of all, and shorter periods hold
        /// the newest of them.
        #[test]
        fn periods_hold_what_was_added(frames in prop::collection::vec((0.0_f32..5.0, 0.01_f64..20.0), 1..400)) {
            let mut periods = Periods::new(2);
            for (robots, secs) in &frames {
                add(&mut periods, &[Counts::default(), frame(*robots, 0.0)], *secs);
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
