//! Measures how good the collision checker's predictions are: against what happened then, on a real
//! engine.
//!
//!     cargo bench -p regatta-bench --features benches --bench prediction -- \
//!         [--scenario FILE] [--seconds N] [--checker OPTION]...
//!
//! An engine and a checker run in lockstep, each in a process of its own. A pair of robots is
//! *predicted* at a tick if the checker considers it possible and it doesn't touch yet; a
//! prediction *comes true* if the pair begins to touch within the horizon. Precision is the part of
//! the predictions that came true, recall the part of what came true that was predicted.

mod intervals;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use regatta_engine::engine::{Engine, Options};
use regatta_plugin::producer::{LockstepOptions, Speed};
use regatta_plugin::{ContactEventReader, Error, FleetName, Participant, Result, Termination};
use regatta_scenario::{Overrides, Scenario};

use intervals::Pairs;

/// The checker's horizon, in seconds.
const HORIZON: f64 = 2.0;
/// The environment variable that tells a child process what it is.
const ROLE: &str = "REGATTA_BENCH_ROLE";
/// The name of the checker in lockstep.
const CHECKER: &str = "collision";

fn main() -> Result {
    let args: Vec<_> = std::env::args().skip(1).collect();
    let value = |option: &str| {
        let at = args.iter().position(|arg| arg == option)?;
        args.get(at + 1).cloned()
    };
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs/warehouse-1000.yaml");
    let scenario = value("--scenario").map_or(shipped, PathBuf::from);
    let seconds: f64 = value("--seconds").map_or(Ok(60.0), |seconds| seconds.parse())?;
    match (std::env::var(ROLE), value("--fleet")) {
        (Ok(role), Some(fleet)) if role == "engine" => engine(&scenario, &fleet.parse()?, seconds),
        (Ok(_), Some(_)) => {
            regatta_collision::run_from(std::iter::once(CHECKER.to_owned()).chain(args))
        }
        _ => judge(&scenario, seconds, &args),
    }
}

fn engine(scenario: &Path, fleet: &FleetName, seconds: f64) -> Result {
    let scenario = Scenario::read(scenario, &Overrides::default()).map_err(Error::new)?;
    let ticks = (seconds / scenario.tick_period.as_secs_f64()) as u64;
    let lockstep =
        LockstepOptions { names: vec![CHECKER.to_owned()], timeout: Duration::from_secs(60) };
    let options = Options {
        fleet: fleet.clone(),
        speed: Speed::Max,
        ticks: Some(ticks),
        lockstep,
        ..Options::default()
    };
    let termination = Termination::watch()?;
    Engine::new(scenario, options)
        .and_then(|mut engine| engine.run(&termination))
        .map_err(Error::new)?;
    Ok(())
}

/// Starts the two others, collects the checker's events, and prints what they show.
fn judge(scenario: &Path, seconds: f64, args: &[String]) -> Result {
    let tick_secs = Scenario::read(scenario, &Overrides::default())
        .map_err(Error::new)?
        .tick_period
        .as_secs_f64();
    let fleet: FleetName = format!("bench-prediction-{}", std::process::id()).parse()?;
    let participant = Participant::join(&fleet, "judge")?;
    let mut events = ContactEventReader::open_on(&participant)?;
    let mut checker_args =
        vec!["--margin".to_owned(), "0".to_owned(), "--horizon".to_owned(), HORIZON.to_string()];
    let extra = args.windows(2).filter(|pair| pair[0] == "--checker").map(|pair| pair[1].clone());
    checker_args.extend(extra);
    let mut checker = start("checker", &fleet, &checker_args)?;
    let path = scenario.display().to_string();
    let mut engine = start(
        "engine",
        &fleet,
        &["--scenario".into(), path, "--seconds".into(), seconds.to_string()],
    )?;
    let mut pairs = Pairs::default();
    loop {
        let ended = engine.try_wait()?;
        events.take(|tick| {
            tick.records.iter().for_each(|event| pairs.note(event));
            Ok::<_, Error>(())
        })?;
        if ended.is_some() {
            break;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    checker.kill()?;
    checker.wait()?;
    if events.lost() > 0 {
        return Err(Error::new(format_args!("{} ticks of events were lost", events.lost())));
    }
    let score = pairs.score((seconds / tick_secs) as u64, (HORIZON / tick_secs).round() as u64);
    println!("{}, {seconds} s, horizon {HORIZON} s\n{score}", scenario.display());
    Ok(())
}

fn start(role: &str, fleet: &FleetName, args: &[String]) -> Result<Child> {
    let mut command = Command::new(std::env::current_exe()?);
    command.env(ROLE, role).args(["--fleet", fleet.as_str()]).args(args).stdin(Stdio::null());
    Ok(command.spawn()?)
}
