//! Tables 5.5 to 5.7, and on to a million: does the fleet's size change how fast robots move, and what does
//! a tick cost?

use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant, SystemTime};

use clap::Args;
use regatta_engine::graph::generate::Warehouse;

use super::experiment::{Experiment, all_idle, folder_with_porto};
use super::published::{DURATIONS, FLEET_SIZES};
use super::{Output, circumstances, plot, write};
use crate::Failure;

/// Fleet sizes beyond the dissertation's, each with its ticks per second.
const LOADS: &[(u32, u32)] = &[(1_000, 100), (10_000, 100), (100_000, 60), (100_000, 500), (1_000_000, 60)];
/// Where they drive: 9,898 edges.
const LARGE_WAREHOUSE: Warehouse = Warehouse { aisles: 60, rows: 12, bays: 4 };
/// Before a load is measured: pages are touched, caches warm.
const WARM_UP: Duration = Duration::from_secs(2);

#[derive(Args)]
pub struct ScalingArgs {
    #[command(flatten)]
    output: Output,
    /// Speed at which the dissertation's routes are driven; 1 is real time and takes three minutes.
    #[arg(long, default_value_t = 1.0)]
    speed: f32,
    /// Seconds that each larger fleet is measured for.
    #[arg(long, default_value_t = 10)]
    secs: u64,
    /// Threads of the engine for the larger fleets.
    #[arg(long, default_value_t = 1)]
    threads: u32,
    /// Largest fleet to try.
    #[arg(long, default_value_t = 1_000_000)]
    max_robots: u32,
}

/// How long a fleet took for a route.
struct Finish {
    simulated_secs: f64,
    /// Wall time times speed: what a watch beside the simulation would have shown.
    wall_secs: f64,
}

/// What a large fleet cost.
struct Load {
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
    let finishes = finishes(args.speed)?;
    let loads = loads(args)?;
    let (line, machine) = circumstances();
    let (durations, costs) = series(&finishes, &loads);
    plot::scaling(&args.output.file("scaling.svg")?, &durations, &costs)?;
    args.output.write("scaling", &markdown(&finishes, &loads, &line), &json(&finishes, &loads, args, machine))?;
    Ok(ExitCode::SUCCESS)
}

/// Every route of the tables, with every fleet size.
fn finishes(speed: f32) -> Result<Vec<Vec<Finish>>, Failure> {
    let folder = folder_with_porto()?;
    let all_sizes = |route| FLEET_SIZES.iter().map(|&robots| finish(folder.path(), route, robots, speed)).collect();
    DURATIONS.iter().map(|row| all_sizes(row.route)).collect()
}

fn finish(folder: &Path, route: &[u32], robots: u32, speed: f32) -> Result<Finish, Failure> {
    let scenario = folder.join("scaling.yaml");
    write(&scenario, &format!("graph: porto.yaml\nrate: 100\nrobots: [{{count: {robots}, route: {route:?}}}]\n"))?;
    let mut experiment = Experiment::start("finish", &scenario, &["--speed".into(), speed.to_string()])?;
    let mut first = None;
    let mut finish = Finish { simulated_secs: 0.0, wall_secs: 0.0 };
    experiment.watch(Duration::from_secs(600), |frame| {
        let now = frame.sim_time().as_secs_f64();
        let (start, start_time) = *first.get_or_insert((Instant::now(), now));
        finish.simulated_secs = now;
        // The reader may have joined a few ticks late: those passed at the wanted speed or are late ticks.
        finish.wall_secs = start.elapsed().as_secs_f64() * f64::from(speed) + start_time;
        all_idle(frame)
    })?;
    experiment.finish()?;
    Ok(finish)
}

fn loads(args: &ScalingArgs) -> Result<Vec<Load>, Failure> {
    let folder = tempfile::tempdir().map_err(|error| format!("can't make a temporary folder: {error}"))?;
    write(&folder.path().join("warehouse.yaml"), &LARGE_WAREHOUSE.generate()?)?;
    let scenario = folder.path().join("load.yaml");
    write(&scenario, "graph: warehouse.yaml\nseed: 1\nrobots: [{count: 1, routes: random}]\n")?;
    let one = load(&scenario, (1, 100), args, 0)?;
    let empty_bytes = one.bytes_per_robot as u64;
    let wanted = LOADS.iter().filter(|(robots, _)| *robots <= args.max_robots);
    wanted.map(|&size| load(&scenario, size, args, empty_bytes)).collect()
}

/// Measures one fleet; `empty_bytes` is the resident memory of an engine with a single robot.
fn load(scenario: &Path, (robots, rate_hz): (u32, u32), args: &ScalingArgs, empty_bytes: u64) -> Result<Load, Failure> {
    let options = [("robots", robots), ("rate", rate_hz), ("threads", args.threads)];
    let options: Vec<_> = options.iter().flat_map(|(name, value)| [format!("--{name}"), value.to_string()]).collect();
    let mut experiment = Experiment::start("load", scenario, &options)?;
    read_for(&mut experiment, WARM_UP)?;
    let before = experiment.status()?;
    let mut ages = read_for(&mut experiment, Duration::from_secs(args.secs))?;
    let after = experiment.status()?;
    experiment.finish()?;
    ages.sort_by(f64::total_cmp);
    let percentile = |part: f64| ages.get((ages.len() as f64 * part) as usize).copied().unwrap_or(f64::NAN);
    Ok(Load {
        robots,
        rate_hz,
        tick_cost_p50_ms: after.tick_cost_p50_nanos as f64 * 1e-6,
        tick_cost_p99_ms: after.tick_cost_p99_nanos as f64 * 1e-6,
        ticks: after.tick - before.tick,
        late_ticks: after.late_ticks - before.late_ticks,
        real_time_factor: after.real_time_factor,
        bytes_per_robot: after.resident_bytes.saturating_sub(empty_bytes) as f64 / f64::from(robots),
        frames_read: ages.len() as u64,
        frame_age_p50_us: percentile(0.5),
        frame_age_p99_us: percentile(0.99),
    })
}

/// Reads frames as they come; their ages in microseconds from send to first access.
fn read_for(experiment: &mut Experiment, time: Duration) -> Result<Vec<f64>, Failure> {
    let end = Instant::now() + time;
    let mut ages = Vec::new();
    let mut touched = 0.0;
    experiment.watch(time + Duration::from_secs(60), |frame| {
        touched += frame.x().last().copied().unwrap_or(0.0);
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64);
        ages.push(now.saturating_sub(frame.header().wall_time_nanos) as f64 * 1e-3);
        Instant::now() >= end
    })?;
    std::hint::black_box(touched);
    Ok(ages)
}

fn series(finishes: &[Vec<Finish>], loads: &[Load]) -> (Vec<plot::Series>, Vec<plot::Series>) {
    let mut durations = Vec::new();
    for (row, finishes) in DURATIONS.iter().zip(finishes) {
        let over_one = |secs: &[f64]| FLEET_SIZES.iter().zip(secs).map(|(&n, s)| (f64::from(n), s / secs[0])).collect();
        let ours: Vec<_> = finishes.iter().map(|finish| finish.wall_secs).collect();
        durations.push(plot::Series { name: format!("dissertation {:?}", row.route), points: over_one(&row.secs) });
        durations.push(plot::Series { name: format!("Regatta {:?}", row.route), points: over_one(&ours) });
    }
    let point = |load: &Load, cost: f64| (f64::from(load.robots).log10(), cost.log10());
    let sixty: Vec<_> = loads.iter().filter(|load| load.rate_hz <= 100).collect();
    let costs = vec![
        plot::Series {
            name: "median".into(),
            points: sixty.iter().map(|load| point(load, load.tick_cost_p50_ms)).collect(),
        },
        plot::Series {
            name: "p99".into(),
            points: sixty.iter().map(|load| point(load, load.tick_cost_p99_ms)).collect(),
        },
    ];
    (durations, costs)
}

fn markdown(finishes: &[Vec<Finish>], loads: &[Load], circumstances: &str) -> String {
    let mut text = format!(
        "# Scaling: from one robot to a million\n\n{circumstances}\n\n## The dissertation's tables 5.5 to 5.7\n\n\
         Seconds of wall time until all robots have driven the route (in brackets the dissertation's).\n\n\
         | route | 1 robot | 10 | 20 | 30 | 30 over 1 |\n|---|---|---|---|---|---|\n"
    );
    for (row, finishes) in DURATIONS.iter().zip(finishes) {
        let cells =
            finishes.iter().zip(row.secs).map(|(finish, published)| format!("{:.2} ({published})", finish.wall_secs));
        let ratio = finishes[3].wall_secs / finishes[0].wall_secs;
        let published = row.secs[3] / row.secs[0];
        let cells = cells.collect::<Vec<_>>().join(" | ");
        let _ = writeln!(text, "| {:?} | {cells} | {ratio:.3} ({published:.2}) |", row.route);
    }
    text.push_str(
        "\n## Larger fleets\n\nRandom routes on a generated warehouse, one reader attached. A tick is late when it ends after\n\
         the next one is due. Memory is resident memory above that of an engine with one robot, frames included. Age is\n\
         from the engine's send to the reader's first access.\n\n\
         | robots | ticks/s | tick p50 | tick p99 | late | real-time factor | bytes a robot | frames read | age p50 | age p99 |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for load in loads {
        let _ = writeln!(
            text,
            "| {} | {} | {:.3} ms | {:.3} ms | {} of {} ({:.2} %) | {:.2} | {:.0} | {} | {:.0} µs | {:.0} µs |",
            load.robots,
            load.rate_hz,
            load.tick_cost_p50_ms,
            load.tick_cost_p99_ms,
            load.late_ticks,
            load.ticks,
            load.late_ticks as f64 / load.ticks as f64 * 100.0,
            load.real_time_factor,
            load.bytes_per_robot,
            load.frames_read,
            load.frame_age_p50_us,
            load.frame_age_p99_us,
        );
    }
    text.push_str("\n![Scaling](scaling.svg)\n");
    text
}

fn json(finishes: &[Vec<Finish>], loads: &[Load], args: &ScalingArgs, machine: serde_json::Value) -> serde_json::Value {
    let finish = |(finish, robots): (&Finish, &u32)| serde_json::json!({"robots": robots, "simulated_secs": finish.simulated_secs, "wall_secs": finish.wall_secs});
    let tables: Vec<_> = DURATIONS
        .iter()
        .zip(finishes)
        .map(|(row, finishes)| {
            let fleets: Vec<_> = finishes.iter().zip(&FLEET_SIZES).map(finish).collect();
            serde_json::json!({"route": row.route, "fleets": fleets, "dissertation_secs": row.secs})
        })
        .collect();
    let loads: Vec<_> = loads
        .iter()
        .map(|load| {
            serde_json::json!({
                "robots": load.robots, "rate_hz": load.rate_hz,
                "tick_cost_p50_ms": load.tick_cost_p50_ms, "tick_cost_p99_ms": load.tick_cost_p99_ms,
                "ticks": load.ticks, "late_ticks": load.late_ticks, "real_time_factor": load.real_time_factor,
                "bytes_per_robot": load.bytes_per_robot, "frames_read": load.frames_read,
                "frame_age_p50_us": load.frame_age_p50_us, "frame_age_p99_us": load.frame_age_p99_us,
            })
        })
        .collect();
    serde_json::json!({"machine": machine, "speed": args.speed, "threads": args.threads, "tables": tables, "loads": loads})
}
