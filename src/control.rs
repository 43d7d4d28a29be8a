//! `regatta pause`, `resume`, `step`, `speed`, `seek`, `robots` and `status`: requests to the
//! control service of a running fleet.

use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::producer::Speed;
use regatta_plugin::{Control, ControlError, FleetName};

use crate::failure::Failure;

/// The fleet that a command is sent to.
#[derive(Args)]
pub struct Target {
    /// Name of the fleet.
    #[arg(long, default_value_t)]
    pub fleet: FleetName,
}

pub fn pause(target: &Target) -> Result<ExitCode, Failure> {
    send(target, Control::pause)
}

pub fn resume(target: &Target) -> Result<ExitCode, Failure> {
    send(target, Control::resume)
}

pub fn step(ticks: u64, target: &Target) -> Result<ExitCode, Failure> {
    send(target, |control| control.step(ticks))
}

pub fn speed(speed: Speed, target: &Target) -> Result<ExitCode, Failure> {
    send(target, |control| control.speed(speed.as_f32()))
}

pub fn seek(time: Duration, target: &Target) -> Result<ExitCode, Failure> {
    send(target, |control| control.seek(time))
}

pub fn robots(robots: u32, target: &Target) -> Result<ExitCode, Failure> {
    send(target, |control| control.robots(robots))
}

pub fn status(json: bool, target: &Target) -> Result<ExitCode, Failure> {
    let status = Control::open(&target.fleet)?.status()?;
    println!("{}", if json { status_json(&status) } else { status_line(&status) });
    Ok(ExitCode::SUCCESS)
}

/// Sends a request and prints the status that answers it.
fn send(
    target: &Target,
    request: impl FnOnce(&mut Control) -> Result<ControlResponse, ControlError>,
) -> Result<ExitCode, Failure> {
    let status = request(&mut Control::open(&target.fleet)?)?;
    println!("{}", status_line(&status));
    Ok(ExitCode::SUCCESS)
}

/// Formats the status of a fleet in one line.
pub fn status_line(status: &ControlResponse) -> String {
    let [idle, driving, waiting, held, faulted, turning, stalled, broken] = status.robots_by_state;
    let clock = match status.clock {
        1 => "  paused",
        _ => "",
    };
    format!(
        "t {:.2} s{clock}  rtf {:.2}  robots {} (driving {driving}, turning {turning}, idle {idle}, \
         waiting {waiting}, held {held}, stalled {stalled}, broken {broken}, faulted {faulted})  tick p50 {:.3} ms p99 {:.3} ms  late {}",
        status.sim_time_nanos as f64 * 1e-9,
        status.real_time_factor,
        status.robots,
        status.tick_cost_p50_nanos as f64 * 1e-6,
        status.tick_cost_p99_nanos as f64 * 1e-6,
        status.late_ticks,
    )
}

/// Formats the status of a fleet as JSON.
pub fn status_json(status: &ControlResponse) -> String {
    let [idle, driving, waiting, held, faulted, turning, stalled, broken] = status.robots_by_state;
    let speed = if status.speed.is_finite() {
        serde_json::json!(status.speed)
    } else {
        serde_json::json!("max")
    };
    serde_json::json!({
        "run_id": format!("{:016x}", status.run_id),
        "pid": status.pid,
        "tick": status.tick,
        "sim_time_secs": status.sim_time_nanos as f64 * 1e-9,
        "wall_time_secs": status.wall_time_nanos as f64 * 1e-9,
        "clock": if status.clock == 1 { "paused" } else { "running" },
        "speed": speed,
        "real_time_factor": status.real_time_factor,
        "robots": status.robots,
        "robots_by_state": {
            "idle": idle, "driving": driving, "waiting": waiting, "held": held, "faulted": faulted,
            "turning": turning, "stalled": stalled, "broken": broken,
        },
        "late_ticks": status.late_ticks,
        "tick_cost_p50_secs": status.tick_cost_p50_nanos as f64 * 1e-9,
        "tick_cost_p99_secs": status.tick_cost_p99_nanos as f64 * 1e-9,
        "resident_bytes": status.resident_bytes,
    })
    .to_string()
}
