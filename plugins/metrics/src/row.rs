//! A row of the CSV file: a snapshot as comma-separated values.

use std::fmt::Write;
use std::time::Duration;

use regatta_plugin::activity::Activity;
use regatta_plugin::frame::ClockState;

use crate::histogram::DurationStats;
use crate::snapshot::{IntervalStats, Process, Run, Snapshot, Work};
use crate::state_counts::STATE_NAMES;
use crate::work::activity_key;

/// A cell of a row: its column's name with the unit, and its value if that is known.
struct Cell {
    name: String,
    text: Option<String>,
}

fn cell(name: &str, value: Option<impl ToString>) -> Cell {
    Cell { name: name.to_owned(), text: value.map(|value| value.to_string()) }
}

/// Returns the names of all columns, as the first line of the file.
pub fn header() -> String {
    let names: Vec<_> = cells(Duration::ZERO, None, &IntervalStats::default())
        .into_iter()
        .map(|cell| cell.name)
        .collect();
    names.join(",")
}

/// Returns the row at a time since the Unix epoch. Cells of unknown values are empty.
pub fn row(now: Duration, snapshot: &Snapshot, interval: &IntervalStats) -> String {
    let mut row = String::new();
    for (index, cell) in cells(now, Some(snapshot), interval).into_iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        // Writing to a string can't fail.
        let _ = write!(row, "{comma}{}", cell.text.unwrap_or_default());
    }
    row
}

/// Returns all cells of a row. Without a snapshot only their names matter.
fn cells(now: Duration, snapshot: Option<&Snapshot>, interval: &IntervalStats) -> Vec<Cell> {
    let mut cells = vec![cell("unix_time_seconds", Some(format!("{:.3}", now.as_secs_f64())))];
    cells.extend(run_cells(snapshot.and_then(|snapshot| snapshot.run.as_ref())));
    cells.extend(total_cells(snapshot));
    for (name, stats) in [
        ("tick_cost", interval.tick_cost),
        ("tick_jitter", interval.jitter),
        ("frame_age", interval.frame_age),
    ] {
        cells.extend(stats_cells(name, &stats));
    }
    cells.extend(collision_cells(snapshot));
    cells.extend(work_cells(snapshot.and_then(|snapshot| snapshot.work.as_ref())));
    cells.extend(process_cells(snapshot.map(|snapshot| &snapshot.processes[..])));
    cells
}

fn run_cells(run: Option<&Run>) -> Vec<Cell> {
    let seconds = |seconds: f64| format!("{seconds:.9}");
    let mut cells = vec![
        cell("run_id", run.map(|run| format!("{:016x}", run.run_id))),
        cell("tick", run.map(|run| run.tick)),
        cell("simulated_seconds", run.map(|run| seconds(run.sim_time.as_secs_f64()))),
        cell("paused", run.map(|run| u8::from(run.clock != ClockState::Running))),
        cell("wanted_speed_ratio", run.map(|run| run.speed)),
        cell("real_time_ratio", run.and_then(|run| run.real_time_factor)),
        cell("late_ticks", run.map(|run| run.late_ticks)),
    ];
    for (index, state) in STATE_NAMES.into_iter().enumerate() {
        cells.push(cell(
            &format!("robots_{state}"),
            run.map(|run| run.state_counts.by_state[index]),
        ));
    }
    cells.push(cell("mean_speed_metres_per_second", run.map(|run| run.state_counts.mean_speed())));
    cells
}

fn total_cells(snapshot: Option<&Snapshot>) -> Vec<Cell> {
    let totals = snapshot.map(|snapshot| &snapshot.totals);
    vec![
        cell("driven_metres", totals.map(|totals| totals.driven_metres)),
        cell("frames_read", totals.map(|totals| totals.frames_read)),
        cell("frames_skipped", totals.map(|totals| totals.frames_skipped)),
    ]
}

fn stats_cells(name: &str, stats: &DurationStats) -> [Cell; 2] {
    let seconds = |seconds: f64| format!("{seconds:.9}");
    let (mean, max) = stats.mean_and_max().unzip();
    [
        cell(&format!("{name}_mean_seconds"), mean.map(seconds)),
        cell(&format!("{name}_max_seconds"), max.map(seconds)),
    ]
}

fn collision_cells(snapshot: Option<&Snapshot>) -> Vec<Cell> {
    let robots = snapshot.and_then(|snapshot| snapshot.collisions.robots);
    let pairs = snapshot.and_then(|snapshot| snapshot.collisions.pairs);
    vec![
        cell("collision_robots_possible", robots.map(|robots| robots.possible)),
        cell("collision_robots_touching", robots.map(|robots| robots.touching)),
        cell("collision_pairs_possible", pairs.map(|pairs| pairs.possible)),
        cell("collision_pairs_touching", pairs.map(|pairs| pairs.touching)),
    ]
}

fn work_cells(work: Option<&Work>) -> Vec<Cell> {
    let activity = |activity: Activity| {
        let robots = work.map(|work| work.robots[activity as usize]);
        cell(&format!("manager_robots_{}", activity_key(activity)), robots)
    };
    let tasks = work.map(|work| &work.tasks);
    let mut cells = Activity::ALL.map(activity).into_iter().collect::<Vec<_>>();
    cells.extend([
        cell("tasks_created", tasks.map(|tasks| tasks.created)),
        cell("tasks_finished", tasks.map(|tasks| tasks.finished)),
        cell("tasks_failed", tasks.map(|tasks| tasks.failed)),
        cell("tasks_cancelled", tasks.map(|tasks| tasks.cancelled)),
        cell("tasks_open", tasks.and_then(|tasks| tasks.open)),
        cell("manager_utilisation_ratio", work.and_then(|work| work.effort.utilisation())),
        cell("manager_loaded_metres", work.map(|work| work.effort.loaded_metres)),
        cell("manager_empty_metres", work.map(|work| work.effort.empty_metres)),
        cell("manager_cycle_mean_seconds", work.and_then(|work| work.cycle.mean())),
        cell(
            "manager_cycle_max_seconds",
            work.filter(|work| work.cycle.count > 0).map(|work| work.cycle.longest),
        ),
    ]);
    cells
}

fn process_cells(processes: Option<&[Process]>) -> Vec<Cell> {
    // Not `sum`, which returns -0 for none.
    let sum = |value: fn(&Process) -> f64| {
        processes.map(|all| all.iter().map(value).fold(0.0, |sum, one| sum + one))
    };
    vec![
        cell("processes", processes.map(<[_]>::len)),
        cell("resident_memory_bytes", sum(|process| process.resident_bytes as f64)),
        cell("cpu_cores", sum(|process| process.cpu_cores).map(|cores| format!("{cores:.3}"))),
    ]
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
            (value("manager_robots_to_pick"), value("tasks_finished"), value("tasks_open")),
            ("201", "4321", "58")
        );
        assert_eq!(value("processes"), snapshot.processes.len().to_string());
        let alone = Snapshot { processes: Vec::new(), ..testing::without_engine() };
        let row = super::row(Duration::ZERO, &alone, &IntervalStats::default());
        assert!(row.ends_with(",0,0,0.000"), "{row}");
    }
}
