//! `regatta report scaling`: the dissertation's tables 5.5 to 5.7 (does the size of the fleet
//! change how fast robots move?), and the cost of a tick for up to a million robots.

use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant, SystemTime};

use clap::Args;
use regatta_layout::generate::Warehouse;
use regatta_plugin::producer::Speed;
use regatta_scenario::RobotCount;

use super::folder_with_porto;
use super::published::{DURATIONS, FLEET_SIZES};
use crate::engine::parse_threads;
use crate::experiment::plot::{self, Chart, Scale, Series};
use crate::experiment::report::{Output, Report, environment};
use crate::experiment::{Experiment, all_idle, seconds_parser, temporary_folder, write};
use crate::failure::Failure;
use crate::program::Program;
use crate::progress::Progress;

/// The loads beyond the dissertation's fleet sizes: number of robots, ticks per second.
const LOADS: &[(u32, u32)] =
    &[(1_000, 100), (10_000, 100), (100_000, 60), (100_000, 500), (1_000_000, 60)];
/// The warehouse of these loads: 9,898 edges.
const LARGE_WAREHOUSE: Warehouse = Warehouse { aisles: 60, rows: 12, bays: 4 };
/// The time before a load is measured, in which memory pages are touched and caches warm up.
const WARM_UP: Duration = Duration::from_secs(2);

#[derive(Args)]
pub struct ScalingArgs {
    #[command(flatten)]
    output: Output,
    /// Speed at which the dissertation's routes are driven; 1 is real time, which takes three
    /// minutes.
    #[arg(long, default_value = "1", value_parser = parse_factor)]
    speed: f32,
    /// Seconds for which each larger fleet is measured.
    #[arg(long, default_value_t = 10, value_parser = seconds_parser())]
    secs: u64,
    /// Threads of the engine for the larger fleets.
    #[arg(long, default_value = "1", value_parser = parse_threads)]
    threads: usize,
    /// Number of robots of the largest fleet; at least 1.
    #[arg(long, default_value = "1M", value_parser = parse_robots)]
    max_robots: u32,
}

/// Parses a speed at which wall time can be compared: not as fast as possible.
fn parse_factor(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(Speed::Factor(factor)) => Ok(factor),
        _ => Err("give a factor from 0.001 to 1000".to_owned()),
    }
}

fn parse_robots(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(RobotCount(robots @ 1..)) => Ok(robots),
        _ => Err("give at least 1 robot: 500, 10k, 1M".to_owned()),
    }
}

/// The time until all robots of a fleet have driven a route.
struct RouteTime {
    simulated_secs: f64,
    /// Wall time times speed: the wall time of the same drive at speed 1.
    wall_secs: f64,
}

/// The cost of a large fleet.
struct Cost {
    robots: u32,
    rate_hz: u32,
    tick_cost_p50_ms: f64,
    tick_cost_p99_ms: f64,
    ticks: u64,
    late_ticks: u64,
    real_time_factor: f32,
    bytes_per_robot: f64,
    frames_read: u64,
    frame_age_p50_us: f64,
    frame_age_p99_us: f64,
}

pub fn run(args: &ScalingArgs) -> Result<ExitCode, Failure> {
    args.output.check("scaling")?;
    let loads = loads(args.max_robots);
    let steps = DURATIONS.len() * FLEET_SIZES.len() + 1 + loads.len();
    let progress = Progress::start("starting", steps as u64);
    let program = Program::this()?;
    let times = route_times(&program, args.speed, &progress)?;
    let costs = costs(&program, &loads, args, &progress)?;
    drop(progress);
    let (line, machine) = environment(&program);
    args.output.write(&Report {
        name: "scaling",
        markdown: markdown(&times, &costs, &line),
        json: json(&times, &costs, args, machine),
        plot: Some(plot(&times, &costs)?),
    })?;
    Ok(ExitCode::SUCCESS)
}

/// Returns the loads of up to `max_robots` robots; at least one.
fn loads(max_robots: u32) -> Vec<(u32, u32)> {
    let mut loads: Vec<_> =
        LOADS.iter().copied().filter(|(robots, _)| *robots <= max_robots).collect();
    if loads.is_empty() {
        loads.push((max_robots, LOADS[0].1));
    }
    loads
}

/// Measures every route of the tables with every fleet size.
fn route_times(
    program: &Program,
    speed: f32,
    progress: &Progress,
) -> Result<Vec<Vec<RouteTime>>, Failure> {
    let folder = folder_with_porto()?;
    let mut times = Vec::new();
    for row in DURATIONS {
        let mut row_times = Vec::new();
        for robots in FLEET_SIZES {
            progress.set_current(format!("driving route {:?} with {robots} robots", row.route));
            row_times.push(route_time(program, folder.path(), row.route, robots, speed)?);
            progress.step("next");
        }
        times.push(row_times);
    }
    Ok(times)
}

fn route_time(
    program: &Program,
    folder: &Path,
    route: &[u32],
    robots: u32,
    speed: f32,
) -> Result<RouteTime, Failure> {
    let scenario = folder.join("scaling.yaml");
    write(
        &scenario,
        &format!("graph: porto.yaml\nrate: 100\nrobots: [{{count: {robots}, route: {route:?}}}]\n"),
    )?;
    let mut experiment =
        Experiment::start(program, "finish", &scenario, &["--speed".into(), speed.to_string()])?;
    let mut first = None;
    let mut time = RouteTime { simulated_secs: 0.0, wall_secs: 0.0 };
    experiment.watch(Duration::from_secs(600), |frame| {
        let now = frame.sim_time().as_secs_f64();
        let (start, start_time) = *first.get_or_insert((Instant::now(), now));
        time.simulated_secs = now;
        // The reader may have joined a few ticks late. Those ticks took their nominal time, or were
        // counted as late ticks.
        time.wall_secs = start.elapsed().as_secs_f64() * f64::from(speed) + start_time;
        all_idle(frame)
    })?;
    experiment.finish()?;
    Ok(time)
}

fn costs(
    program: &Program,
    loads: &[(u32, u32)],
    args: &ScalingArgs,
    progress: &Progress,
) -> Result<Vec<Cost>, Failure> {
    let folder = temporary_folder()?;
    write(&folder.path().join("warehouse.yaml"), &LARGE_WAREHOUSE.generate()?)?;
    let scenario = folder.path().join("load.yaml");
    write(&scenario, "graph: warehouse.yaml\nseed: 1\nrobots: [{count: 1, routes: random}]\n")?;
    let empty_bytes = cost(program, &scenario, (1, 100), args, 0, progress)?.bytes_per_robot as u64;
    let costs =
        loads.iter().map(|&load| cost(program, &scenario, load, args, empty_bytes, progress));
    costs.collect()
}

/// Measures one fleet; `empty_bytes` is the resident memory of an engine with a single robot.
fn cost(
    program: &Program,
    scenario: &Path,
    (robots, rate_hz): (u32, u32),
    args: &ScalingArgs,
    empty_bytes: u64,
    progress: &Progress,
) -> Result<Cost, Failure> {
    progress.set_current(format!("measuring {robots} robots at {rate_hz} Hz"));
    let options = [
        ("robots", robots.to_string()),
        ("rate", rate_hz.to_string()),
        ("threads", args.threads.to_string()),
    ];
    let options: Vec<_> =
        options.into_iter().flat_map(|(name, value)| [format!("--{name}"), value]).collect();
    let mut experiment = Experiment::start(program, "load", scenario, &options)?;
    read_for(&mut experiment, WARM_UP)?;
    let before = experiment.status()?;
    let mut ages = read_for(&mut experiment, Duration::from_secs(args.secs))?;
    let after = experiment.status()?;
    experiment.finish()?;
    progress.step("next");
    ages.sort_by(f64::total_cmp);
    let percentile =
        |part: f64| ages.get((ages.len() as f64 * part) as usize).copied().unwrap_or(f64::NAN);
    Ok(Cost {
        robots,
        rate_hz,
        tick_cost_p50_ms: after.tick_cost_p50_nanos as f64 * 1e-6,
        tick_cost_p99_ms: after.tick_cost_p99_nanos as f64 * 1e-6,
        ticks: after.tick - before.tick,
        late_ticks: after.late_ticks - before.late_ticks,
        real_time_factor: after.real_time_factor,
        bytes_per_robot: after.resident_bytes.saturating_sub(empty_bytes) as f64
            / f64::from(robots),
        frames_read: ages.len() as u64,
        frame_age_p50_us: percentile(0.5),
        frame_age_p99_us: percentile(0.99),
    })
}

/// Reads each frame as it arrives, and returns the ages of the frames in microseconds from the send
/// to the first access.
fn read_for(experiment: &mut Experiment, time: Duration) -> Result<Vec<f64>, Failure> {
    let end = Instant::now() + time;
    let mut ages = Vec::new();
    let mut touched = 0.0;
    experiment.watch(time + Duration::from_secs(60), |frame| {
        touched += frame.x().last().copied().unwrap_or(0.0);
        let now = SystemTime::now()
            .duration_since(SystemTime::UNIX_EPOCH)
            .map_or(0, |time| time.as_nanos() as u64);
        ages.push(now.saturating_sub(frame.header().wall_time_nanos) as f64 * 1e-3);
        Instant::now() >= end
    })?;
    std::hint::black_box(touched);
    Ok(ages)
}

/// Draws the durations over the fleet size on the left, and the cost of a tick over the fleet size
/// on the right.
fn plot(times: &[Vec<RouteTime>], costs: &[Cost]) -> Result<String, Failure> {
    plot::side_by_side(
        &Chart {
            caption: "Time for all robots to finish a route",
            x: "robots",
            y: "time over that of one robot",
            scale: Scale::Linear,
            series: duration_series(times),
        },
        &Chart {
            caption: "Cost of a tick",
            x: "robots",
            y: "milliseconds",
            scale: Scale::Logarithmic,
            series: cost_series(costs),
        },
    )
}

fn duration_series(times: &[Vec<RouteTime>]) -> Vec<Series> {
    let mut durations = Vec::new();
    for (row, times) in DURATIONS.iter().zip(times) {
        let ours: Vec<_> = times.iter().map(|time| time.wall_secs).collect();
        durations.push(Series {
            name: format!("{:?}, dissertation", row.route),
            points: relative_durations(&row.secs),
        });
        durations.push(Series {
            name: format!("{:?}, Regatta", row.route),
            points: relative_durations(&ours),
        });
    }
    durations
}

/// Returns the durations of fleets of [`FLEET_SIZES`] relative to that of one robot.
fn relative_durations(secs: &[f64]) -> Vec<(f64, f64)> {
    FLEET_SIZES.iter().zip(secs).map(|(&n, s)| (f64::from(n), s / secs[0])).collect()
}

fn cost_series(costs: &[Cost]) -> Vec<Series> {
    let (mut median, mut p99) = (Vec::new(), Vec::new());
    for cost in costs.iter().filter(|cost| cost.rate_hz <= 100) {
        median.push((f64::from(cost.robots), cost.tick_cost_p50_ms));
        p99.push((f64::from(cost.robots), cost.tick_cost_p99_ms));
    }
    vec![
        Series { name: "median".into(), points: median },
        Series { name: "p99".into(), points: p99 },
    ]
}

fn markdown(times: &[Vec<RouteTime>], costs: &[Cost], environment: &str) -> String {
    let mut text = format!(
        "# Scaling: from one robot to a million\n\n{environment}\n\n## The dissertation's tables \
         5.5 to 5.7\n\n\
         Seconds of wall time until all robots have driven the route (in brackets the \
         dissertation's).\n\n\
         | route | 1 robot | 10 | 20 | 30 | 30 over 1 |\n|---|---|---|---|---|---|\n"
    );
    for (row, times) in DURATIONS.iter().zip(times) {
        let cells = times
            .iter()
            .zip(row.secs)
            .map(|(time, published)| format!("{:.2} ({published})", time.wall_secs));
        let ratio = times[3].wall_secs / times[0].wall_secs;
        let published = row.secs[3] / row.secs[0];
        let cells = cells.collect::<Vec<_>>().join(" | ");
        let _ = writeln!(text, "| {:?} | {cells} | {ratio:.3} ({published:.2}) |", row.route);
    }
    text.push_str(
        "\n## Larger fleets\n\nRandom routes on a generated warehouse, one reader attached. A \
         tick is late when it ends after\n\
         the next one is due. Memory is the resident memory above that of an engine with one \
         robot, frames included. The age\n\
         of a frame is the time from the engine's send to the reader's first access.\n\n\
         | robots | ticks/s | tick p50 | tick p99 | late | real-time factor | bytes per robot | \
         frames read | age p50 | age p99 |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for cost in costs {
        let _ = writeln!(
            text,
            "| {} | {} | {:.3} ms | {:.3} ms | {} of {} ({:.2} %) | {:.2} | {:.0} | {} | {:.0} µs \
             | {:.0} µs |",
            cost.robots,
            cost.rate_hz,
            cost.tick_cost_p50_ms,
            cost.tick_cost_p99_ms,
            cost.late_ticks,
            cost.ticks,
            cost.late_ticks as f64 / cost.ticks as f64 * 100.0,
            cost.real_time_factor,
            cost.bytes_per_robot,
            cost.frames_read,
            cost.frame_age_p50_us,
            cost.frame_age_p99_us,
        );
    }
    text.push_str("\n![Scaling](scaling.svg)\n");
    text
}

fn json(
    times: &[Vec<RouteTime>],
    costs: &[Cost],
    args: &ScalingArgs,
    machine: serde_json::Value,
) -> serde_json::Value {
    let tables: Vec<_> = DURATIONS
        .iter()
        .zip(times)
        .map(|(row, times)| {
            let fleets = times.iter().zip(&FLEET_SIZES).map(|(time, robots)| {
                serde_json::json!({
                    "robots": robots, "simulated_secs": time.simulated_secs,
                    "wall_secs": time.wall_secs,
                })
            });
            let fleets: Vec<_> = fleets.collect();
            serde_json::json!({"route": row.route, "fleets": fleets, "dissertation_secs": row.secs})
        })
        .collect();
    let loads: Vec<_> = costs
        .iter()
        .map(|cost| {
            serde_json::json!({
                "robots": cost.robots, "rate_hz": cost.rate_hz,
                "tick_cost_p50_ms": cost.tick_cost_p50_ms,
                "tick_cost_p99_ms": cost.tick_cost_p99_ms,
                "ticks": cost.ticks, "late_ticks": cost.late_ticks,
                "real_time_factor": cost.real_time_factor,
                "bytes_per_robot": cost.bytes_per_robot, "frames_read": cost.frames_read,
                "frame_age_p50_us": cost.frame_age_p50_us,
                "frame_age_p99_us": cost.frame_age_p99_us,
            })
        })
        .collect();
    serde_json::json!({
        "machine": machine, "speed": args.speed, "threads": args.threads, "tables": tables,
        "loads": loads,
    })
}
