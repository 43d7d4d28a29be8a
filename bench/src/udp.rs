//! `regatta-bench udp`: the lines per second that arrive over UDP, and their cost. An engine,
//! `udp` and `udp-source` run as processes of their own, connected by the loopback interface.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

use clap::Args;
use regatta::experiment::report::{Output, Report, environment};
use regatta::experiment::{
    Experiment, check_interrupt, seconds_parser, temporary_folder, wait, write,
};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta::progress::Progress;
use regatta::supervisor::Supervisor;
use regatta_layout::generate::Warehouse;
use regatta_scenario::RobotCount;
use serde_json::{Value, json};

/// The loads: number of robots, frames per second. The first two are promised to arrive completely;
/// the others grow until lines are lost.
const LOADS: &[(u32, u32)] = &[
    (10_000, 50),
    (100_000, 10),
    (100_000, 20),
    (100_000, 50),
    (100_000, 100),
    (1_000_000, 2),
    (1_000_000, 10),
];
/// The warehouse in which the robots drive.
const WAREHOUSE: Warehouse = Warehouse { aisles: 24, rows: 18, bays: 6 };
const SCENARIO: &str = "udp.yaml";
/// The time that the last datagrams have to be received.
const DRAIN_TIME: Duration = Duration::from_millis(500);
/// The longest time until the receiver listens.
const START_TIMEOUT: Duration = Duration::from_secs(60);

#[derive(Args)]
pub struct UdpArgs {
    #[command(flatten)]
    output: Output,
    /// Seconds for which each load is measured.
    #[arg(long, default_value_t = 10, value_parser = seconds_parser())]
    secs: u64,
    /// Measure only a fleet of this many robots (needs --hz).
    #[arg(long, requires = "hz")]
    robots: Option<RobotCount>,
    /// Frames per second of that fleet.
    #[arg(long, requires = "robots", value_parser = clap::value_parser!(u32).range(1..=20_000))]
    hz: Option<u32>,
    /// Another option for `regatta plugin udp`, for example --udp-option=--pace=0.
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    udp_option: Vec<String>,
}

/// The figures that the sender and the receiver print at the end.
struct Figures {
    robots: u32,
    hz: u32,
    sender: Value,
    receiver: Value,
}

pub fn run(program: &Program, args: &UdpArgs) -> Result<ExitCode, Failure> {
    args.output.check("udp")?;
    let loads = args
        .robots
        .zip(args.hz)
        .map_or(LOADS.to_vec(), |(RobotCount(robots), hz)| vec![(robots, hz)]);
    let progress = Progress::start("starting", loads.len() as u64);
    let folder = temporary_folder()?;
    write(&folder.path().join("warehouse.yaml"), &WAREHOUSE.generate()?)?;
    write(
        &folder.path().join(SCENARIO),
        "graph: warehouse.yaml\nseed: 1\nrobots: [{count: 1, routes: random}]\n",
    )?;
    let figures = loads.into_iter().map(|load| {
        progress.set_current(format!("sending {} robots at {} Hz", load.0, load.1));
        measure(program, folder.path(), load, args).inspect(|_| progress.step("finishing"))
    });
    let figures = figures.collect::<Result<Vec<_>, _>>()?;
    drop(progress);
    let (line, machine) = environment(program);
    let loads: Vec<_> = figures
        .iter()
        .map(
            |f| json!({"robots": f.robots, "hz": f.hz, "sender": f.sender, "receiver": f.receiver}),
        )
        .collect();
    let json = json!({
        "machine": machine, "secs": args.secs, "udp_options": args.udp_option, "loads": loads,
    });
    args.output.write(&Report {
        name: "udp",
        markdown: markdown(&figures, &line),
        json,
        plot: None,
    })?;
    Ok(ExitCode::SUCCESS)
}

fn measure(
    program: &Program,
    folder: &Path,
    (robots, hz): (u32, u32),
    args: &UdpArgs,
) -> Result<Figures, Failure> {
    let options = [("robots", robots), ("rate", hz)];
    let options: Vec<_> =
        options.iter().flat_map(|(name, value)| [format!("--{name}"), value.to_string()]).collect();
    let experiment = Experiment::start(program, "udp", &folder.join(SCENARIO), &options)?;
    let fleet = experiment.reader.participant().fleet().to_string();

    let mut receiver = Supervisor::default();
    let [max_robots, rate] = [robots, hz].map(|number| number.to_string());
    let second = format!("{fleet}-source");
    let plugin = [
        "udp-source",
        "--listen",
        "0",
        "--max-robots",
        &max_robots,
        "--rate",
        &rate,
        "--fleet",
        &second,
    ];
    receiver.start("udp-source", &mut plugin_command(program, folder, &plugin)?)?;
    let to = listening_address(folder, &mut receiver)?;

    let mut sender = Supervisor::default();
    let plugin = ["udp", "--to", &to, "--rate", "all", "--fleet", &fleet];
    sender.start("udp", plugin_command(program, folder, &plugin)?.args(&args.udp_option))?;
    wait(Duration::from_secs(args.secs))?;
    let sender = stop(folder, "udp", sender)?;
    wait(DRAIN_TIME)?;
    let receiver = stop(folder, "udp-source", receiver)?;
    experiment.finish()?;
    Ok(Figures { robots, hz, sender, receiver })
}

/// Returns the command of a plugin that writes its final figures to `NAME.json` and its messages to
/// `NAME.log`.
fn plugin_command(program: &Program, folder: &Path, plugin: &[&str]) -> Result<Command, Failure> {
    let json = File::create(folder.join(format!("{}.json", plugin[0])))?;
    let log = File::create(folder.join(format!("{}.log", plugin[0])))?;
    let mut command = program.command();
    command.arg("plugin").args(plugin).arg("--json");
    command.stdin(Stdio::null()).stdout(json).stderr(log);
    Ok(command)
}

/// Waits until the receiver listens, and returns its address.
fn listening_address(folder: &Path, receiver: &mut Supervisor) -> Result<String, Failure> {
    let started = Instant::now();
    loop {
        check_interrupt()?;
        let log = fs::read_to_string(folder.join("udp-source.log"))?;
        // The last line may be incomplete.
        if let Some((line, _)) = log.split_once('\n')
            && let Some(address) =
                line.split("listening on ").nth(1).and_then(|rest| rest.split(' ').next())
        {
            return Ok(address.to_owned());
        }
        if !receiver.take_ended().is_empty() || started.elapsed() > START_TIMEOUT {
            return Err(format!("udp-source did not start: {}", log.trim()).into());
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Stops a plugin and returns the figures that it prints at its end.
fn stop(folder: &Path, name: &str, mut process: Supervisor) -> Result<Value, Failure> {
    let failures = process.stop();
    let text = fs::read_to_string(folder.join(format!("{name}.json")))?;
    serde_json::from_str(&text).map_err(|_| {
        let log = fs::read_to_string(folder.join(format!("{name}.log"))).unwrap_or_default();
        format!("{name} printed no figures: {} {}", failures.join(", "), log.trim()).into()
    })
}

fn markdown(figures: &[Figures], environment: &str) -> String {
    let mut text = format!(
        "# UDP: lines per second over loopback\n\n{environment}\n\n\
         The engine, `udp` and `udp-source` are separate processes. A core is one second of \
         processor time per second of wall time.\n\n\
         | robots | Hz | frames sent | lines sent/s | lines received | packets dropped | sender | \
         receiver | receiver's late frames |\n\
         |---|---|---|---|---|---|---|---|---|\n"
    );
    for Figures { robots, hz, sender, receiver } in figures {
        let (sent, received) = (number(sender, "lines"), number(receiver, "lines"));
        let _ = writeln!(
            text,
            "| {robots} | {hz} | {} of {:.0} | {:.0} | {received} of {sent} ({:.3} %) | {} | \
             {:.3} cores | {:.3} cores | {} of {} |",
            sender["frames"],
            number(sender, "wall_secs") * f64::from(*hz),
            sent / number(sender, "wall_secs"),
            received / sent * 100.0,
            receiver["dropped_packets"],
            cores(sender),
            cores(receiver),
            receiver["late_ticks"],
            receiver["frames"],
        );
    }
    text
}

fn number(side: &Value, key: &str) -> f64 {
    side[key].as_f64().unwrap_or(f64::NAN)
}

/// Returns the processor time of a side over its wall time.
fn cores(side: &Value) -> f64 {
    number(side, "cpu_secs") / number(side, "wall_secs")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn side(lines: u64) -> Value {
        json!({
            "lines": lines, "frames": 100, "wall_secs": 2.0, "cpu_secs": 0.5,
            "dropped_packets": 3, "late_ticks": 0,
        })
    }

    #[test]
    fn the_table_lists_losses() {
        let figures = Figures { robots: 10, hz: 50, sender: side(1000), receiver: side(990) };
        let text = markdown(&[figures], "here");
        assert!(
            text.contains(
                "| 10 | 50 | 100 of 100 | 500 | 990 of 1000 (99.000 %) | 3 | 0.250 cores |"
            ),
            "{text}"
        );
    }
}
