//! The exporter's page: a snapshot as metrics.
//!
//! Names follow `promtool check metrics`: the prefix `regatta_`, base units at the end, `_total`
//! for counters. Unknown values, such as the robots of a fleet without an engine, are left out
//! rather than 0.

use std::collections::BTreeMap;

use regatta_kit::RowCounts;
use regatta_plugin::activity::Activity;
use regatta_plugin::frame::CONTRACT_VERSION;
use regatta_plugin::traffic::EdgeTraffic;

use crate::exposition::{Exposition, Format};
use crate::snapshot::{Collisions, Jam, OrderFigures, Process, Run, Snapshot, Totals, Work};
use crate::state_counts::STATE_NAMES;
use crate::work::{Effort, activity_key};

/// The exporter's own state.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExporterState {
    /// Counts of the CSV file, if there is one.
    pub rows: Option<RowCounts>,
    /// Commit that the program was built from, if it is known.
    pub commit: Option<&'static str>,
}

/// Writes the page.
pub fn page(snapshot: &Snapshot, exporter: &ExporterState, format: Format) -> String {
    let mut page = Exposition::new(format, snapshot.fleet.as_str());
    page.one("regatta_up", "Whether the fleet has a producer: 1 or 0.", snapshot.run.is_some());
    add_build(&mut page, exporter.commit);
    add_totals(&mut page, &snapshot.totals);
    if let Some(run) = &snapshot.run {
        add_run(&mut page, run);
        add_collisions(&mut page, &snapshot.collisions, run);
    }
    if let Some(work) = &snapshot.work {
        add_robots_at_work(&mut page, work);
        add_effort(&mut page, work);
        add_orders(&mut page, &work.orders);
    }
    add_jams(&mut page, snapshot.jams.as_deref().unwrap_or_default());
    add_processes(&mut page, &snapshot.processes);
    if let Some(rows) = exporter.rows {
        page.one("regatta_csv_rows_written_total", "Rows written to the CSV file.", rows.written);
        page.one(
            "regatta_csv_rows_lost_total",
            "Rows that could not be written to the CSV file.",
            rows.lost,
        );
    }
    page.finish()
}

fn add_build(page: &mut Exposition<'_>, commit: Option<&str>) {
    let contract = CONTRACT_VERSION.to_string();
    let commit = commit.filter(|commit| !commit.is_empty()).unwrap_or("unknown");
    let labels =
        [("version", env!("CARGO_PKG_VERSION")), ("commit", commit), ("contract", &*contract)];
    page.each(
        "regatta_build_info",
        "Version of this exporter, its commit, and its contract.",
        [(labels, true)],
    );
}

fn add_totals(page: &mut Exposition<'_>, totals: &Totals) {
    page.one(
        "regatta_frames_read_total",
        "Frames that this exporter has read.",
        totals.frames_read,
    );
    let help = "Frames that were published but not read by this exporter, because it was too slow \
                or didn't request them.";
    page.one("regatta_frames_skipped_total", help, totals.frames_skipped);
    page.one("regatta_read_errors_total", "Messages that could not be read.", totals.read_errors);
    let help = "Distance that all robots together have driven, in metres.";
    page.one("regatta_driven_metres_total", help, totals.driven_metres);
    page.histogram(
        "regatta_tick_cost_seconds",
        "Time that the work of a tick took.",
        &totals.tick_cost,
    );
    let help =
        "Deviation of the wall time from frame to frame from the tick period at the wanted speed.";
    page.histogram("regatta_tick_jitter_seconds", help, &totals.jitter);
    let help = "Time from publishing a frame to reading it in this exporter.";
    page.histogram("regatta_frame_age_seconds", help, &totals.frame_age);
}

fn add_run(page: &mut Exposition<'_>, run: &Run) {
    page.one("regatta_ticks_total", "Ticks since the start of the run.", run.tick);
    let help = "Ticks that ended after their deadline, since the start of the run.";
    page.one("regatta_late_ticks_total", help, run.late_ticks);
    let help = "Simulated time since the start of the run.";
    page.one("regatta_simulated_seconds_total", help, run.sim_time.as_secs_f64());
    let help = "Time at which the newest frame was published, in seconds since the Unix epoch.";
    page.one("regatta_last_frame_timestamp_seconds", help, run.wall_time.as_secs_f64());
    page.one("regatta_paused", "Whether the clock is paused or stopped: 1 or 0.", !run.runs());
    page.one(
        "regatta_tick_period_seconds",
        "Simulated time of one tick.",
        run.tick_period.as_secs_f64(),
    );
    let help = "Wanted simulated seconds per wall second.";
    page.one("regatta_wanted_speed_ratio", help, f64::from(run.speed));
    if let Some(factor) = run.real_time_factor {
        let help = "Simulated seconds per wall second, over about the last second.";
        page.one("regatta_real_time_ratio", help, factor);
    }
    let states = STATE_NAMES
        .into_iter()
        .zip(run.state_counts.by_state)
        .map(|(name, count)| ([("state", name)], count));
    page.each("regatta_robots", "Robots by state.", states);
    let help = "Mean speed of all robots, in metres per second of simulated time.";
    page.one("regatta_mean_speed_metres_per_second", help, run.state_counts.mean_speed());
}

fn add_collisions(page: &mut Exposition<'_>, collisions: &Collisions, run: &Run) {
    if let Some(robots) = collisions.robots {
        let help = "Robots that touch or may touch another.";
        page.each("regatta_collision_robots", help, by_level(robots.possible, robots.touching));
    }
    if let Some(pairs) = collisions.pairs {
        let help = "Pairs of robots that touch or may touch.";
        page.each(
            "regatta_collision_pairs",
            help,
            by_level(pairs.possible.into(), pairs.touching.into()),
        );
        let help = "Number of times that two robots began to touch, or to be a possible collision.";
        page.each(
            "regatta_collisions_total",
            help,
            by_level(pairs.possible_ever, pairs.touching_ever),
        );
        let help = "Frames that the collision checker was too slow for.";
        page.one("regatta_collision_frames_skipped_total", help, pairs.frames_skipped);
        let help = "Whether there are more pairs than the collision checker examines: 1 or 0.";
        page.one("regatta_collision_capped", help, pairs.capped != 0);
    }
    if let Some(tick) = collisions.tick() {
        let help = "Simulated time from the frame that was last checked for collisions to the \
                    newest frame.";
        let lag = run.tick.saturating_sub(tick) as f64 * run.tick_period.as_secs_f64();
        page.one("regatta_collision_lag_seconds", help, lag);
    }
}

fn add_robots_at_work(page: &mut Exposition<'_>, work: &Work) {
    let keys = Activity::ALL.map(activity_key);
    let robots = keys.iter().zip(work.robots).map(|(key, robots)| ([("activity", &**key)], robots));
    page.each(
        "regatta_manager_robots",
        "Robots by activity, as the fleet manager sees it.",
        robots,
    );
}

fn add_effort(page: &mut Exposition<'_>, work: &Work) {
    let Effort { busy_secs, robot_secs, loaded_metres, empty_metres } = work.effort;
    let help = "Simulated time that robots had an order, in the run since this exporter reads it.";
    page.one("regatta_manager_busy_robot_seconds_total", help, busy_secs);
    page.one(
        "regatta_manager_robot_seconds_total",
        "Simulated time that robots were there, as above.",
        robot_secs,
    );
    let metres = [([("load", "loaded")], loaded_metres), ([("load", "empty")], empty_metres)];
    page.each(
        "regatta_manager_driven_metres_total",
        "Distance with a load and without, as above, in metres.",
        metres,
    );
    if work.cycle.count > 0 {
        let help = "Wall time that the fleet manager spent on a frame.";
        page.summary("regatta_manager_cycle_seconds", help, &work.cycle);
        page.one(
            "regatta_manager_longest_cycle_seconds",
            "The longest of these times.",
            work.cycle.longest,
        );
    }
}

fn add_orders(page: &mut Exposition<'_>, orders: &OrderFigures) {
    let help = "Transport orders that were created, in the run since this exporter reads it.";
    page.one("regatta_orders_created_total", help, orders.created);
    let outcomes =
        [("finished", orders.finished), ("failed", orders.failed), ("cancelled", orders.cancelled)];
    let outcomes = outcomes.map(|(outcome, orders)| ([("outcome", outcome)], orders));
    page.each(
        "regatta_orders_total",
        "Transport orders that are over, by outcome, as above.",
        outcomes,
    );
    if let Some(open) = orders.open {
        page.one("regatta_orders_open", "Transport orders that are not over.", open);
    }
    if let Some(rate) = orders.finished_per_second {
        let help = "Transport orders finished per second of simulated time, over its last hour.";
        page.one("regatta_orders_finished_per_second", help, rate);
    }
    let help =
        "Simulated time from the creation of a transport order to its end, of finished orders.";
    page.summary("regatta_order_service_seconds", help, &orders.service);
    let help =
        "Simulated time from the creation of a transport order to its first assignment to a robot.";
    page.summary("regatta_order_waiting_seconds", help, &orders.waiting);
    for (name, help, times) in [
        (
            "regatta_order_longest_service_seconds",
            "The longest of the service times.",
            &orders.service,
        ),
        (
            "regatta_order_longest_waiting_seconds",
            "The longest of the waiting times.",
            &orders.waiting,
        ),
    ] {
        if times.count > 0 {
            page.one(name, help, times.longest);
        }
    }
    let help = "Ticks whose records of orders are missing, in whole or in part.";
    page.one("regatta_order_log_gaps_total", help, orders.gaps);
}

/// Adds the edges with the longest waiting times.
fn add_jams(page: &mut Exposition<'_>, jams: &[Jam]) {
    let ids: Vec<String> = jams.iter().map(|jam| jam.edge.to_string()).collect();
    type Value = fn(&EdgeTraffic) -> f32;
    let figures: [(&str, &str, Value); 4] = [
        (
            "regatta_edge_waiting_seconds",
            "Time that robots waited on an edge in the last ten minutes, for the edges with the \
             longest times.",
            |figures| figures.waiting_secs,
        ),
        (
            "regatta_edge_entered_per_hour",
            "Robots that entered these edges per hour, in the last ten minutes.",
            |figures| figures.entered_per_hour,
        ),
        ("regatta_edge_robots", "Mean number of robots on these edges, as above.", |figures| {
            figures.occupancy
        }),
        (
            "regatta_edge_relative_speed_ratio",
            "Mean speed on these edges over their speed limits, as above.",
            |figures| figures.relative_speed,
        ),
    ];
    for (name, help, value) in figures {
        let samples = jams.iter().zip(&ids).map(|(jam, id)| {
            ([("edge", &**id), ("name", &*jam.name)], f64::from(value(&jam.figures)))
        });
        page.each(name, help, samples);
    }
}

/// The figures of all processes of a name.
#[derive(Default)]
struct ProcessGroup {
    resident_bytes: u64,
    shared_bytes: u64,
    cpu_seconds: f64,
}

fn add_processes(page: &mut Exposition<'_>, processes: &[Process]) {
    // Not by process id: a process that is restarted keeps its series.
    let mut groups = BTreeMap::<&str, ProcessGroup>::new();
    for process in processes {
        let group = groups.entry(&process.name).or_default();
        group.resident_bytes += process.resident_bytes;
        group.shared_bytes += process.shared_bytes;
        group.cpu_seconds = process.cpu_seconds;
    }
    let groups = groups.iter().map(|(name, group)| ([("name", *name)], group));
    let help = "Resident memory of the fleet's processes of a name, including the shared memory \
                that they use.";
    let resident = groups.clone().map(|(labels, group)| (labels, group.resident_bytes));
    page.each("regatta_process_resident_memory_bytes", help, resident);
    let help = "Memory in the shared-memory segments that the fleet's processes of a name own.";
    let shared = groups.clone().map(|(labels, group)| (labels, group.shared_bytes));
    page.each("regatta_process_shared_memory_bytes", help, shared);
    let help =
        "Processor time of the fleet's processes of a name, since the first of them started.";
    let cpu_seconds = groups.map(|(labels, group)| (labels, group.cpu_seconds));
    page.each("regatta_process_cpu_seconds_total", help, cpu_seconds);
}

fn by_level(possible: u64, touching: u64) -> [([(&'static str, &'static str); 1], u64); 2] {
    [([("level", "possible")], possible), ([("level", "touching")], touching)]
}

#[cfg(test)]
mod tests;
