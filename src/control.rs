//! `regatta pause`, `resume`, `step`, `speed`, `seek`, `robots` and `status`: requests to the
//! control service of a running fleet.

use clap::Args;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::frame::{ClockState, RobotState};
use regatta_plugin::{Control, ControlError, FleetName};
use serde_json::{Value, json};

use crate::activities::{Activities, RobotCounts};
use crate::facilities::{Facility, facilities};
use crate::failure::Failure;
use crate::output::show;
use crate::processes::{self, processes};

/// The fleet that a command is sent to.
#[derive(Args)]
pub struct Target {
    /// Name of the fleet.
    #[arg(long, default_value_t)]
    pub fleet: FleetName,
}

/// Prints the status of a fleet.
pub fn status(json: bool, target: &Target) -> Result<(), Failure> {
    let status = Control::open(&target.fleet)?.status()?;
    let facilities = facilities(&target.fleet)?;
    let processes = processes(&target.fleet)?;
    let activities = Activities::join(&target.fleet)?.wait_for_run(status.run_id)?;
    if json {
        let mut value = status_json(&status, activities);
        if !facilities.is_empty() {
            value["facilities"] = facilities.iter().map(Facility::json).collect();
        }
        value["processes"] = processes.iter().map(processes::to_json).collect();
        println!("{value}");
        return Ok(());
    }
    println!("{}", status_line(&status, activities));
    for facility in &facilities {
        show(facility.line() + "\n");
    }
    show(processes::lines(&processes));
    Ok(())
}

/// Sends a request and prints the status that answers it.
pub fn send(
    target: &Target,
    request: impl FnOnce(&mut Control) -> Result<ControlResponse, ControlError>,
) -> Result<(), Failure> {
    let status = request(&mut Control::open(&target.fleet)?)?;
    let activities = Activities::join(&target.fleet)?.wait_for_run(status.run_id)?;
    println!("{}", status_line(&status, activities));
    Ok(())
}

/// Whether the clock of a fleet is paused.
pub fn is_paused(status: &ControlResponse) -> bool {
    status.clock == ClockState::Paused as u32
}

/// Whether a fleet is in its warm-up.
pub fn is_warming_up(status: &ControlResponse) -> bool {
    status.clock == ClockState::WarmingUp as u32
}

/// The state of a clock in words.
fn clock_word(status: &ControlResponse) -> &'static str {
    match status.clock {
        clock if clock == ClockState::Paused as u32 => "paused",
        clock if clock == ClockState::WarmingUp as u32 => "warming up",
        _ => "running",
    }
}

/// Formats the status of a fleet in one line: with the activities of its robots if they are known,
/// else with their states.
pub fn status_line(status: &ControlResponse, activities: Option<RobotCounts>) -> String {
    let robots = activities.map_or_else(|| states(status), |robots| robots.in_words());
    let clock = match clock_word(status) {
        "running" => String::new(),
        word => format!("  {word}"),
    };
    let owner = status.owner().map_or_else(String::new, |owner| format!("  moved by {owner}"));
    format!(
        "t {:.2} s{clock}  rtf {:.2}  robots {} ({robots})  tick p50 {:.3} ms p99 {:.3} ms  late {}",
        status.sim_time_nanos as f64 * 1e-9,
        status.real_time_factor,
        status.robots,
        status.tick_cost_p50_nanos as f64 * 1e-6,
        status.tick_cost_p99_nanos as f64 * 1e-6,
        status.late_ticks,
    ) + &owner
}

/// Formats the line of a second of a run, which fits into a terminal of 80 columns: the costs of
/// ticks and the owner are in [`status_line`].
pub fn run_line(status: &ControlResponse, activities: Option<RobotCounts>) -> String {
    let robots = activities.map_or_else(|| states(status), |robots| robots.in_words());
    let clock = if is_paused(status) { "  paused" } else { "" };
    format!(
        "t {:.2} s{clock}  rtf {:.2}  robots {} ({robots})  late {}",
        status.sim_time_nanos as f64 * 1e-9,
        status.real_time_factor,
        status.robots,
        status.late_ticks,
    )
}

/// Formats the states of any robots: `idle 3, driving 12`.
fn states(status: &ControlResponse) -> String {
    let mut words = Vec::new();
    for (number, robots) in (0..).zip(status.robots_by_state) {
        if robots > 0 {
            words.push(format!("{} {robots}", RobotState::from_number(number).name()));
        }
    }
    words.join(", ")
}

/// Returns the status of a fleet as JSON, with the activities of its robots if they are known.
pub fn status_json(status: &ControlResponse, activities: Option<RobotCounts>) -> Value {
    let mut value = status_value(status);
    if let Some(robots) = activities {
        value["robots_by_activity"] = robots.to_json();
    }
    value
}

fn status_value(status: &ControlResponse) -> Value {
    let [idle, driving, waiting, held, faulted, turning, stalled, broken] = status.robots_by_state;
    let speed = if status.speed.is_finite() { json!(status.speed) } else { json!("max") };
    json!({
        "run_id": format!("{:016x}", status.run_id),
        "pid": status.pid,
        "owner": status.owner(),
        "tick": status.tick,
        "sim_time_secs": status.sim_time_nanos as f64 * 1e-9,
        "wall_time_secs": status.wall_time_nanos as f64 * 1e-9,
        "clock": clock_word(status),
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
}
