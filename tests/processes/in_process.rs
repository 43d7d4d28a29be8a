//! A run in one process is that of processes in lockstep, bit for bit: frames, events, columns and
//! the order log.

use std::cell::Cell;
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Duration;

use clap::Parser;
use regatta_plugin::activity::Activity;
use regatta_plugin::column::{ACTIVITY, BATTERY, GOAL, TYPE, WAITS_FOR};
use regatta_plugin::frame::RobotState;
use regatta_plugin::{
    ColumnReader, Events, Frame, LOAD_VARIABLE, LocalPlugin, OrderReader, Participant, Plugin,
    ReadError, Reporter, Result, column_names,
};
use regatta_run::Run;
use regatta_scenario::{Overrides, Scenario};

use crate::fleet::{Process, eventually, graphs, regatta, unique};

/// The columns of the engine and of the fleet manager.
const COLUMNS: [&str; 5] =
    [ACTIVITY.name(), BATTERY.name(), GOAL.name(), TYPE.name(), WAITS_FOR.name()];

/// The data of a run that a plugin saw, as a hash for each kind of data.
#[derive(Debug, Default, PartialEq)]
struct Seen {
    frames: u64,
    events: u64,
    columns: [u64; COLUMNS.len()],
    orders: u64,
    /// Records of orders, so that a run without any is noticed.
    order_records: usize,
    /// The engine's digest.
    digest: String,
}

/// A plugin that hashes all that it sees.
#[derive(Default)]
struct Witness {
    ports: Option<(Vec<ColumnReader>, OrderReader)>,
    frames: DefaultHasher,
    events: DefaultHasher,
    columns: [DefaultHasher; COLUMNS.len()],
    orders: DefaultHasher,
    order_records: usize,
    /// Run and tick of the last frame.
    last: Rc<Cell<Option<(u64, u64)>>>,
}

impl Witness {
    /// Reads the columns and orders that have come. Which frame they come with may differ, but not
    /// their order.
    fn take(&mut self) -> Result {
        let Some((readers, log)) = &mut self.ports else { return Ok(()) };
        for (reader, hasher) in readers.iter_mut().zip(&mut self.columns) {
            while let Some(column) = reader.take_next()? {
                hasher.write_u64(column.header.tick);
                assert_eq!(column.missed, 0, "no sample is lost");
                column.values.iter().for_each(|value| hasher.write_u32(value.to_bits()));
            }
        }
        log.take(|tick| {
            assert_eq!(tick.missed, 0, "no record is lost");
            self.orders.write_u64(tick.header.tick);
            self.order_records += tick.records.len();
            self.orders.write(format!("{:?}", tick.records).as_bytes());
            Ok::<_, ReadError>(())
        })?;
        Ok(())
    }

    fn seen(self, digest: String) -> Seen {
        Seen {
            frames: self.frames.finish(),
            events: self.events.finish(),
            columns: self.columns.map(|hasher| hasher.finish()),
            orders: self.orders.finish(),
            order_records: self.order_records,
            digest,
        }
    }
}

impl Plugin for Witness {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        let readers = COLUMNS.map(|name| ColumnReader::open_for_all_on(fleet, name));
        let readers: Result<Vec<_>, _> = readers.into_iter().collect();
        self.ports = Some((readers?, OrderReader::open_on(fleet)?));
        Ok(())
    }

    fn wants_events(&self) -> bool {
        true
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        self.events.write_u64(events.header.tick);
        self.events.write(format!("{:?}", events.records).as_bytes());
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        self.last.set(Some((frame.run_id(), frame.tick())));
        self.frames.write_u64(frame.tick());
        for column in [frame.x(), frame.y(), frame.theta(), frame.speed(), frame.s()] {
            column.iter().for_each(|value| self.frames.write_u32(value.to_bits()));
        }
        self.frames.write(frame.state());
        self.take()
    }
}

const MANAGER: &str = "fleet-manager";
const WITNESS: &str = "witness";

/// The arguments of the scenario's fleet manager; `None` if it has none.
fn manager_args(scenario: &Scenario) -> Option<Vec<String>> {
    let manager = scenario.plugins.iter().find(|plugin| plugin.name == MANAGER)?;
    Some(manager.args.iter().filter(|arg| *arg != "--summary").cloned().collect())
}

fn in_one_process(path: &Path, ticks: u64) -> Seen {
    let scenario = Scenario::read(path, &Overrides::default()).expect("a scenario");
    let args = manager_args(&scenario);
    let mut witness = Witness::default();
    let mut run = Run::new(scenario).digested();
    if let Some(args) = args {
        let words =
            [MANAGER.to_owned(), "--no-cache".to_owned(), format!("--load={}", path.display())];
        let cli = regatta_fleet_manager::Cli::parse_from(words.into_iter().chain(args));
        run = run.with_named(MANAGER, &[], regatta_fleet_manager::plugin(cli).expect("a plugin"));
    }
    let run = run.with_named(WITNESS, &[MANAGER], &mut witness);
    let digest = run.for_ticks(ticks).expect("a run").digest.expect("a digest");
    witness.take().expect("readable");
    witness.seen(format!("{digest:032x}"))
}

fn in_processes(path: &Path, ticks: u64) -> Seen {
    let fleet = unique(&format!("homes-{}", path.file_stem().expect("a name").to_string_lossy()));
    let scenario = Scenario::read(path, &Overrides::default()).expect("a scenario");
    let args = manager_args(&scenario);
    let fleet_arg = format!("--fleet={fleet}");
    // Readers come before the engine: one that joins later may miss the columns of the first tick.
    let manager = args.as_ref().map(|args| {
        let mut command = regatta();
        command.args(["plugin", MANAGER, &fleet_arg, "--no-cache"]).args(args);
        Process::start(command.env(LOAD_VARIABLE, path))
    });
    if manager.is_some() {
        eventually("the manager reads batteries", || {
            column_names(&fleet).iter().any(|name| name.as_str() == BATTERY.name()).then_some(())
        });
    }
    let mut witness = Witness::default();
    let participant = Participant::join(&fleet, WITNESS).expect("joined");
    let reporter = Reporter::open_on(&participant).expect("opened");
    let last = Rc::clone(&witness.last);
    let mut plugin = LocalPlugin::start(&participant, &mut witness).expect("started");
    let mut engine = regatta();
    engine.arg("engine").arg(path).args([&fleet_arg, "--speed=max", "--digest"]);
    engine.arg(format!("--ticks={ticks}")).args(["--lockstep-timeout", "60"]);
    engine.args([format!("--lockstep={WITNESS}")]);
    engine.args(args.as_ref().map(|_| format!("--lockstep={MANAGER}")));
    let mut engine = Process::start(&mut engine);
    while engine.0.try_wait().expect("a status").is_none() {
        plugin.turn().expect("readable");
        if let Some((run_id, tick)) = last.take() {
            reporter.done(run_id, tick).expect("reported");
        }
        std::thread::sleep(Duration::from_micros(50));
    }
    drop(plugin);
    witness.take().expect("readable");
    drop(manager);
    let output = engine.finish();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    witness.seen(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Compares the two homes of a run, which must have orders if it has a manager.
fn compare(path: &Path, ticks: u64, has_orders: bool) {
    let (one, many) = (in_one_process(path, ticks), in_processes(path, ticks));
    assert_eq!(one, many, "{}", path.display());
    assert_eq!(one.order_records > 0, has_orders, "{}: {one:?}", path.display());
}

/// Compares the two homes of a run under the fleet manager on a layout.
fn compare_managed(layout: PathBuf, robots: u32) {
    let folder = tempfile::tempdir().expect("a folder");
    let name = layout.file_stem().expect("a name").to_string_lossy().replace('.', "-");
    let path = folder.path().join(format!("{name}.yaml"));
    let scenario = format!(
        "graph: {}\nrate: 10\nseed: 3\nrobots: [{{count: {robots}, routes: none}}]\n\
         load: {{seed: 3, per_hour: 600, dwell: {{min: 2, max: 5}}}}\nplugins: [{MANAGER}]\n",
        layout.display()
    );
    std::fs::write(&path, scenario).expect("written");
    compare(&path, 3000, true);
}

#[test]
fn robots_on_routes_of_the_scenario() {
    compare(&graphs("thirty.yaml"), 500, false);
}

#[test]
fn robots_on_random_routes() {
    compare(&graphs("warehouse-1000.yaml"), 300, false);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("square.yaml");
    let layout = graphs("square.yaml");
    let scenario =
        format!("graph: {}\nrate: 50\nrobots: [{{count: 4, routes: random}}]\n", layout.display());
    std::fs::write(&path, scenario).expect("written");
    compare(&path, 300, false);
}

#[test]
fn a_thousand_managed_robots() {
    compare(&graphs("warehouse-managed.yaml"), 1000, true);
}

#[test]
fn robots_that_charge() {
    compare(&graphs("warehouse-charging.yaml"), 2000, true);
}

#[test]
fn robots_that_pass_doors_and_ride_a_lift() {
    compare(&graphs("lift.yaml"), 6000, true);
}

#[test]
fn all_kinds_of_generators() {
    compare(&graphs("shift.yaml"), 12_000, true);
}

#[test]
fn storages_that_are_full_and_empty() {
    compare(&graphs("storage.yaml"), 12_000, true);
}

#[test]
fn managed_robots_on_layouts_of_others() {
    compare_managed(graphs("porto.yaml"), 4);
    compare_managed(graphs("imported/opentcs/PlantModelV004.sample.xml"), 4);
    compare_managed(graphs("imported/open-rmf/office/0.yaml"), 3);
    compare_managed(graphs("imported/open-rmf/hotel/0.yaml"), 3);
    compare_managed(graphs("imported/nav2/aws_graph.geojson"), 2);
}

/// A grid of which the fleet manager needs time to find ways for eight robots: they stand without
/// a route meanwhile, though they have orders.
const GRID: &str = "type octile\nheight 6\nwidth 8\nmap\nS.....E.\n.@.@@.@.\n.......E\n@@.@.@..\n\
                    S......E\n........\n";

/// A plugin that looks for robots that stand without a route and are said to drive to a stop.
#[derive(Default)]
struct Standers {
    activity: Option<ColumnReader>,
    /// By robot: for how many frames.
    frames: Vec<u32>,
    longest: u32,
}

impl Plugin for Standers {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.activity = Some(ColumnReader::open_for_all_on(fleet, ACTIVITY.name())?);
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        let Some(reader) = &mut self.activity else { return Ok(()) };
        self.frames.resize(frame.state().len(), 0);
        while let Some(column) = reader.take_next()? {
            for (robot, value) in column.values.iter().enumerate() {
                let is_on_its_way = matches!(
                    ACTIVITY.element(*value),
                    Some(Activity::Fetching | Activity::Carrying)
                );
                let stands = frame.state()[robot] == RobotState::Idle as u8;
                let frames = &mut self.frames[robot];
                *frames = if is_on_its_way && stands { *frames + 1 } else { 0 };
                self.longest = self.longest.max(*frames);
            }
        }
        Ok(())
    }
}

#[test]
fn a_robot_with_an_order_that_stands_without_a_route_is_waiting() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("grid.map"), GRID).expect("written");
    let path = folder.path().join("grid.yaml");
    let scenario = format!(
        "graph: grid.map\nrate: 10\nseed: 1\nrobots: [{{count: 8, routes: none}}]\n\
         load: {{seed: 1, endless: robots, dwell: {{min: 5, max: 15}}}}\nplugins: [{MANAGER}]\n"
    );
    std::fs::write(&path, scenario).expect("written");
    let scenario = Scenario::read(&path, &Overrides::default()).expect("a scenario");
    let words = [MANAGER.to_owned(), "--no-cache".to_owned(), "--in-turn".to_owned()];
    let load = format!("--load={}", path.display());
    let cli = regatta_fleet_manager::Cli::parse_from(words.into_iter().chain([load]));
    let manager = regatta_fleet_manager::plugin(cli).expect("a plugin");
    let mut standers = Standers::default();
    let run = Run::new(scenario).with_named(MANAGER, &[], manager);
    run.with_named("standers", &[MANAGER], &mut standers).for_ticks(6000).expect("a run");
    assert!(!standers.frames.is_empty(), "frames were seen");
    // From a cycle of the manager to the engine's answer.
    assert!(standers.longest <= 10, "{} ticks", standers.longest);
}
