//! A row of the CSV file: a snapshot as comma-separated values.

use std::time::Duration;

use regatta_plugin::activity::Activity;

use crate::snapshot::{IntervalStats, Process, Run, Snapshot, Work};
use crate::state_counts::STATE_NAMES;
use crate::work::activity_key;

/// A row under construction: the names of its columns with their units, and the values; empty if
/// they are unknown.
#[derive(Default)]
struct Row {
    names: Vec<String>,
    texts: Vec<String>,
}

impl Row {
    fn add(&mut self, name: impl Into<String>, value: Option<impl ToString>) {
        self.names.push(name.into());
        self.texts.push(value.map(|value| value.to_string()).unwrap_or_default());
    }
}

/// Returns the names of all columns, as the first line of the file.
pub fn header() -> String {
    filled(Duration::ZERO, None, &IntervalStats::default()).names.join(",")
}

/// Returns the row at a time since the Unix epoch. Cells of unknown values are empty.
pub fn row(now: Duration, snapshot: &Snapshot, interval: &IntervalStats) -> String {
    filled(now, Some(snapshot), interval).texts.join(",")
}

/// Returns a row with all cells. Without a snapshot only their names matter.
fn filled(now: Duration, snapshot: Option<&Snapshot>, interval: &IntervalStats) -> Row {
    let mut row = Row::default();
    row.add("unix_time_seconds", Some(format!("{:.3}", now.as_secs_f64())));
    add_run(&mut row, snapshot.and_then(|snapshot| snapshot.run.as_ref()));
    let totals = snapshot.map(|snapshot| &snapshot.totals);
    row.add("driven_metres", totals.map(|totals| totals.driven_metres));
    row.add("frames_read", totals.map(|totals| totals.frames_read));
    row.add("frames_skipped", totals.map(|totals| totals.frames_skipped));
    for (name, stats) in [
        ("tick_cost", interval.tick_cost),
        ("tick_jitter", interval.jitter),
        ("frame_age", interval.frame_age),
    ] {
        let (mean, max) = stats.mean_and_max().unzip();
        row.add(format!("{name}_mean_seconds"), mean.map(seconds));
        row.add(format!("{name}_max_seconds"), max.map(seconds));
    }
    let robots = snapshot.and_then(|snapshot| snapshot.collisions.robots);
    let pairs = snapshot.and_then(|snapshot| snapshot.collisions.pairs);
    row.add("collision_robots_possible", robots.map(|robots| robots.possible));
    row.add("collision_robots_touching", robots.map(|robots| robots.touching));
    row.add("collision_pairs_possible", pairs.map(|pairs| pairs.possible));
    row.add("collision_pairs_touching", pairs.map(|pairs| pairs.touching));
    add_work(&mut row, snapshot.and_then(|snapshot| snapshot.work.as_ref()));
    let processes = snapshot.map(|snapshot| &snapshot.processes[..]);
    let cores = processes.map(|all| sum(all, |process| process.cpu_cores));
    row.add("processes", processes.map(<[_]>::len));
    row.add(
        "resident_memory_bytes",
        processes.map(|all| sum(all, |process| process.resident_bytes as f64)),
    );
    row.add("cpu_cores", cores.map(|cores| format!("{cores:.3}")));
    row
}

fn add_run(row: &mut Row, run: Option<&Run>) {
    row.add("run_id", run.map(|run| format!("{:016x}", run.run_id)));
    row.add("tick", run.map(|run| run.tick));
    row.add("simulated_seconds", run.map(|run| seconds(run.sim_time.as_secs_f64())));
    row.add("paused", run.map(|run| u8::from(!run.runs())));
    row.add("wanted_speed_ratio", run.map(|run| run.speed));
    row.add("real_time_ratio", run.and_then(|run| run.real_time_factor));
    row.add("late_ticks", run.map(|run| run.late_ticks));
    for (index, state) in STATE_NAMES.into_iter().enumerate() {
        row.add(format!("robots_{state}"), run.map(|run| run.state_counts.by_state[index]));
    }
    row.add("mean_speed_metres_per_second", run.map(|run| run.state_counts.mean_speed()));
}

fn add_work(row: &mut Row, work: Option<&Work>) {
    for activity in Activity::ALL {
        let robots = work.map(|work| work.robots[activity as usize]);
        row.add(format!("manager_robots_{}", activity_key(activity)), robots);
    }
    let orders = work.map(|work| &work.orders);
    row.add("orders_created", orders.map(|orders| orders.created));
    row.add("orders_finished", orders.map(|orders| orders.finished));
    row.add("orders_failed", orders.map(|orders| orders.failed));
    row.add("orders_cancelled", orders.map(|orders| orders.cancelled));
    row.add("orders_open", orders.and_then(|orders| orders.open));
    row.add("manager_utilisation_ratio", work.and_then(|work| work.effort.utilisation()));
    row.add("manager_loaded_metres", work.map(|work| work.effort.loaded_metres));
    row.add("manager_empty_metres", work.map(|work| work.effort.empty_metres));
    row.add("manager_cycle_mean_seconds", work.and_then(|work| work.cycle.mean()));
    let cycle = work.map(|work| work.cycle).filter(|cycle| cycle.count > 0);
    row.add("manager_cycle_max_seconds", cycle.map(|cycle| cycle.longest));
}

fn seconds(seconds: f64) -> String {
    format!("{seconds:.9}")
}

/// Adds up a figure of all processes. Unlike `Iterator::sum`, it returns 0, not -0, for none.
fn sum(processes: &[Process], value: fn(&Process) -> f64) -> f64 {
    processes.iter().map(value).fold(0.0, |sum, one| sum + one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn every_row_has_a_cell_for_each_column() {
        let names: Vec<_> = header().split(',').map(str::to_owned).collect();
        for snapshot in [testing::snapshot(), testing::without_engine()] {
            let row = row(Duration::from_millis(1_500), &snapshot, &IntervalStats::default());
            assert_eq!(row.split(',').count(), names.len(), "{row}");
            assert!(row.starts_with("1.500,"), "{row}");
        }
        let mut unique = names.clone();
        unique.sort();
        unique.dedup();
        assert_eq!(unique.len(), names.len(), "{names:?}");
    }

    #[test]
    fn cells_hold_the_values_of_the_snapshot() {
        let (snapshot, header) = (testing::snapshot(), header());
        let row = row(Duration::ZERO, &snapshot, &IntervalStats::default());
        let value = |name: &str| {
            header.split(',').zip(row.split(',')).find(|cell| cell.0 == name).expect(name).1
        };
        let run = snapshot.run.expect("a run");
        assert_eq!((value("run_id"), value("tick")), ("000000000000feed", &*run.tick.to_string()));
        assert_eq!(value("robots_driving"), run.state_counts.by_state[1].to_string());
        assert_eq!(value("late_ticks"), run.late_ticks.to_string());
        assert_eq!(value("tick_cost_max_seconds"), "", "nothing was measured");
        assert_eq!(
            (value("manager_robots_fetching"), value("orders_finished"), value("orders_open")),
            ("201", "4321", "58")
        );
        assert_eq!(value("processes"), snapshot.processes.len().to_string());
        let alone = Snapshot { processes: Vec::new(), ..testing::without_engine() };
        let row = super::row(Duration::ZERO, &alone, &IntervalStats::default());
        assert!(row.ends_with(",0,0,0.000"), "{row}");
    }
}
