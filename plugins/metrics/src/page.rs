//! The exporter's page: a snapshot in the text format of Prometheus.
//!
//! Names follow `promtool check metrics`: the prefix `regatta_`, base units at the end, `_total` for counters. Unknown
//! values, such as the robots of a fleet without an engine, are left out rather than 0.

use prometheus::TextEncoder;
use prometheus::proto::{Bucket, Counter, Gauge, Histogram, LabelPair, Metric, MetricFamily, MetricType};
use regatta_plugin::frame::ClockState;

use crate::csv_file::RowCounts;
use crate::histogram::{self, BOUNDS};
use crate::snapshot::{Collisions, Process, Run, Snapshot, Totals};
use crate::state_counts::STATE_NAMES;

/// The `Content-Type` of the page.
pub const CONTENT_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// Formats the page. `rows` are the counts of the CSV file, if there is one.
pub fn page(snapshot: &Snapshot, rows: Option<RowCounts>) -> String {
    let mut page = Page { fleet: snapshot.fleet.to_string(), families: Vec::new() };
    page.one("regatta_up", "Whether the fleet has a producer: 1 or 0.", snapshot.run.is_some());
    page.totals(&snapshot.totals);
    if let Some(run) = &snapshot.run {
        page.run(run);
        page.collisions(&snapshot.collisions, run);
    }
    page.processes(&snapshot.processes);
    if let Some(rows) = rows {
        page.one("regatta_csv_rows_written_total", "Rows written to the CSV file.", rows.written);
        page.one("regatta_csv_rows_lost_total", "Rows that could not be written to the CSV file.", rows.lost);
    }
    // Encoding fails only for families without a name or a metric, of which there are none.
    TextEncoder::new().encode_to_string(&page.families).unwrap_or_default()
}

/// The page under construction. Every sample has the fleet's name as a label.
struct Page {
    fleet: String,
    families: Vec<MetricFamily>,
}

/// A number that a sample can have. Counts are exact below 2⁵³.
trait Number: Copy {
    fn value(self) -> f64;
}

impl Number for u64 {
    fn value(self) -> f64 {
        self as f64
    }
}

impl Number for f64 {
    fn value(self) -> f64 {
        self
    }
}

impl Number for bool {
    fn value(self) -> f64 {
        f64::from(u8::from(self))
    }
}

impl Page {
    fn totals(&mut self, totals: &Totals) {
        self.one("regatta_frames_read_total", "Frames that this exporter has read.", totals.frames_read);
        let help =
            "Frames that were published but not read by this exporter, because it was too slow or didn't request them.";
        self.one("regatta_frames_skipped_total", help, totals.frames_skipped);
        self.one("regatta_read_errors_total", "Messages that could not be read.", totals.read_errors);
        let help = "Distance that all robots together have driven, in metres.";
        self.one("regatta_driven_metres_total", help, totals.driven_metres);
        self.histogram("regatta_tick_cost_seconds", "Time that the work of a tick took.", &totals.tick_cost);
        let help = "Deviation of the wall time from frame to frame from the tick period at the wanted speed.";
        self.histogram("regatta_tick_jitter_seconds", help, &totals.jitter);
        let help = "Time from publishing a frame to reading it in this exporter.";
        self.histogram("regatta_frame_age_seconds", help, &totals.frame_age);
    }

    fn run(&mut self, run: &Run) {
        self.one("regatta_ticks_total", "Ticks since the start of the run.", run.tick);
        let help = "Ticks that ended after their deadline, since the start of the run.";
        self.one("regatta_late_ticks_total", help, run.late_ticks);
        let help = "Simulated time since the start of the run.";
        self.one("regatta_simulated_seconds_total", help, run.sim_time.as_secs_f64());
        let help = "Time at which the newest frame was published, in seconds since the Unix epoch.";
        self.one("regatta_last_frame_timestamp_seconds", help, run.wall_time.as_secs_f64());
        self.one("regatta_paused", "Whether the clock is paused or stopped: 1 or 0.", run.clock != ClockState::Running);
        self.one("regatta_tick_period_seconds", "Simulated time of one tick.", run.tick_period.as_secs_f64());
        let help = "Wanted simulated seconds per wall second.";
        self.one("regatta_wanted_speed_ratio", help, f64::from(run.speed));
        if let Some(factor) = run.real_time_factor {
            let help = "Simulated seconds per wall second, over about the last second.";
            self.one("regatta_real_time_ratio", help, factor);
        }
        let states =
            STATE_NAMES.into_iter().zip(run.state_counts.by_state).map(|(name, count)| ([("state", name)], count));
        self.each("regatta_robots", "Robots by state.", states);
        let help = "Mean speed of all robots, in metres per second of simulated time.";
        self.one("regatta_mean_speed_metres_per_second", help, run.state_counts.mean_speed());
    }

    fn collisions(&mut self, collisions: &Collisions, run: &Run) {
        if let Some(robots) = collisions.robots {
            let help = "Robots that touch or may touch another.";
            self.each("regatta_collision_robots", help, by_level(robots.possible, robots.touching));
        }
        if let Some(pairs) = collisions.pairs {
            let help = "Pairs of robots that touch or may touch.";
            self.each("regatta_collision_pairs", help, by_level(pairs.possible.into(), pairs.touching.into()));
            let help = "Number of times that two robots began to touch, or to be a possible collision.";
            self.each("regatta_collisions_total", help, by_level(pairs.possible_ever, pairs.touching_ever));
            let help = "Frames that the collision checker was too slow for.";
            self.one("regatta_collision_frames_skipped_total", help, pairs.frames_skipped);
            let help = "Whether there are more pairs than the collision checker examines: 1 or 0.";
            self.one("regatta_collision_capped", help, pairs.capped != 0);
        }
        if let Some(tick) = collisions.tick() {
            let help = "Simulated time from the frame that was last checked for collisions to the newest frame.";
            let lag = run.tick.saturating_sub(tick) as f64 * run.tick_period.as_secs_f64();
            self.one("regatta_collision_lag_seconds", help, lag);
        }
    }

    fn processes(&mut self, processes: &[Process]) {
        let pids: Vec<_> = processes.iter().map(|process| process.pid.to_string()).collect();
        let each = |value: fn(&Process) -> f64| {
            processes.iter().zip(&pids).map(move |(p, pid)| ([("name", &*p.name), ("pid", &**pid)], value(p)))
        };
        let help = "Resident memory of a process of the fleet, including the shared memory that it uses.";
        self.each("regatta_process_resident_memory_bytes", help, each(|process| process.resident_bytes as f64));
        let help = "Memory in the shared-memory segments that a process of the fleet owns.";
        self.each("regatta_process_shared_memory_bytes", help, each(|process| process.shared_bytes as f64));
        let help = "Processor time of a process of the fleet since its start.";
        self.each("regatta_process_cpu_seconds_total", help, each(|process| process.cpu_seconds));
    }

    fn one(&mut self, name: &str, help: &str, value: impl Number) {
        self.each(name, help, [([], value)]);
    }

    /// Adds a family of samples that differ in their labels. Names that end in `_total` are counters, all others
    /// gauges.
    fn each<'a, const LABELS: usize>(
        &mut self,
        name: &str,
        help: &str,
        samples: impl IntoIterator<Item = ([(&'a str, &'a str); LABELS], impl Number)>,
    ) {
        let is_counter = name.ends_with("_total");
        let metric_type = if is_counter { MetricType::COUNTER } else { MetricType::GAUGE };
        let metric = |(labels, value): ([_; LABELS], _)| {
            let metric = if is_counter { counter(value) } else { gauge(value) };
            self.labelled(metric, &labels)
        };
        let metrics = samples.into_iter().map(metric).collect();
        self.family(name, help, metric_type, metrics);
    }

    fn histogram(&mut self, name: &str, help: &str, times: &histogram::Histogram) {
        let mut cumulative = 0;
        let buckets = BOUNDS.iter().zip(times.buckets).map(|(&bound, count)| {
            cumulative += count;
            let mut bucket = Bucket::default();
            bucket.set_upper_bound(bound);
            bucket.set_cumulative_count(cumulative);
            bucket
        });
        let mut histogram = Histogram::default();
        histogram.set_bucket(buckets.collect());
        histogram.set_sample_count(times.count);
        histogram.set_sample_sum(times.sum);
        let mut metric = Metric::default();
        metric.set_histogram(histogram);
        self.family(name, help, MetricType::HISTOGRAM, vec![self.labelled(metric, &[])]);
    }

    fn labelled(&self, mut metric: Metric, labels: &[(&str, &str)]) -> Metric {
        let pair = |(name, value): (&str, &str)| {
            let mut pair = LabelPair::default();
            pair.set_name(name.to_owned());
            pair.set_value(value.to_owned());
            pair
        };
        metric.set_label([("fleet", &*self.fleet)].into_iter().chain(labels.iter().copied()).map(pair).collect());
        metric
    }

    /// Adds a family, unless it has no samples, which would violate the format.
    fn family(&mut self, name: &str, help: &str, metric_type: MetricType, metrics: Vec<Metric>) {
        if !metrics.is_empty() {
            let mut family = MetricFamily::default();
            family.set_name(name.to_owned());
            family.set_help(help.to_owned());
            family.set_field_type(metric_type);
            family.set_metric(metrics);
            self.families.push(family);
        }
    }
}

fn by_level(possible: u64, touching: u64) -> [([(&'static str, &'static str); 1], u64); 2] {
    [([("level", "possible")], possible), ([("level", "touching")], touching)]
}

fn counter(value: impl Number) -> Metric {
    let mut counter = Counter::default();
    counter.set_value(value.value());
    let mut metric = Metric::default();
    metric.set_counter(counter);
    metric
}

fn gauge(value: impl Number) -> Metric {
    let mut gauge = Gauge::default();
    gauge.set_value(value.value());
    Metric::from_gauge(gauge)
}

#[cfg(test)]
mod tests;
