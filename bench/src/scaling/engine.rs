//! The cost of a tick, as an engine process tells it.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use regatta::experiment::{Experiment, wait, write};
use regatta::failure::Failure;
use regatta::program::Program;
use regatta::supervisor::Supervisor;
use regatta_layout::generate::Warehouse;
use regatta_layout::{ReadOptions, parse};

use super::tables::{Line, Table};

/// The time before a fleet is measured, in which memory pages are touched and caches warm up.
const WARM_UP: Duration = Duration::from_secs(2);
/// The warehouse of fleets: 9,898 edges.
const USUAL: Warehouse = Warehouse { aisles: 60, rows: 12, bays: 4 };
/// The warehouses by which edges are varied, from some hundred to 250,000.
const WAREHOUSES: [Warehouse; 5] = [
    Warehouse { aisles: 6, rows: 2, bays: 2 },
    Warehouse { aisles: 16, rows: 4, bays: 4 },
    USUAL,
    Warehouse { aisles: 190, rows: 36, bays: 4 },
    Warehouse { aisles: 300, rows: 60, bays: 4 },
];
/// The fleet by which edges and readers are varied.
const ROBOTS: u32 = 100_000;
/// Ticks per second of fleets up to 10,000, a million, and more robots.
const RATES: [(u32, u32); 3] = [(10_000, 100), (1_000_000, 60), (u32::MAX, 5)];

/// A measurement of fleets on random routes of generated warehouses.
pub struct Bench<'a> {
    program: &'a Program,
    folder: &'a Path,
    usual: PathBuf,
    secs: u64,
}

/// A fleet whose tick is measured.
struct Fleet<'a> {
    scenario: &'a Path,
    robots: u32,
    rate_hz: u32,
    threads: usize,
    readers: u64,
}

/// The cost of a tick of a fleet.
#[derive(Clone, Copy, Debug)]
pub struct Cost {
    pub p50_ms: f64,
    pub p99_ms: f64,
    pub late_ticks: u64,
    pub ticks: u64,
    pub megabytes: f64,
}

impl<'a> Bench<'a> {
    /// Writes the usual warehouse into a folder. Each fleet is measured for some seconds.
    pub fn new(program: &'a Program, folder: &'a Path, secs: u64) -> Result<Self, Failure> {
        let (usual, _) = warehouse(folder, &USUAL)?;
        Ok(Self { program, folder, usual, secs })
    }

    fn cost(&self, fleet: &Fleet<'_>) -> Result<Cost, Failure> {
        let options = [
            ("--robots", fleet.robots.to_string()),
            ("--rate", fleet.rate_hz.to_string()),
            ("--threads", fleet.threads.to_string()),
        ];
        let options: Vec<_> =
            options.into_iter().flat_map(|(name, value)| [name.to_owned(), value]).collect();
        let mut experiment = Experiment::start(self.program, "scaling", fleet.scenario, &options)?;
        let mut readers = Supervisor::default();
        for _ in 0..fleet.readers {
            let mut reader = self.program.command();
            reader.args(["plugin", "hello", "--fleet", &experiment.fleet().to_string()]);
            readers.start("a reader", reader.stdout(Stdio::null()).stderr(Stdio::null()))?;
        }
        wait(WARM_UP)?;
        let before = experiment.status()?;
        wait(Duration::from_secs(self.secs))?;
        let after = experiment.status()?;
        if let Some(failure) = readers.stop().first() {
            return Err(failure.clone().into());
        }
        experiment.finish()?;
        Ok(Cost {
            p50_ms: after.tick_cost_p50_nanos as f64 * 1e-6,
            p99_ms: after.tick_cost_p99_nanos as f64 * 1e-6,
            late_ticks: after.late_ticks - before.late_ticks,
            ticks: after.tick - before.tick,
            megabytes: after.resident_bytes as f64 * 1e-6,
        })
    }
}

/// Writes a warehouse with a scenario, and returns the path of the scenario and the number of
/// edges.
fn warehouse(folder: &Path, warehouse: &Warehouse) -> Result<(PathBuf, u64), Failure> {
    let Warehouse { aisles, rows, bays } = warehouse;
    let name = format!("warehouse-{aisles}-{rows}-{bays}");
    let text = warehouse.generate()?;
    let (graph, _) = parse(&text, &name, &ReadOptions::default())
        .map_err(|error| format!("a generated warehouse is refused: {error}"))?;
    write(&folder.join(format!("{name}.yaml")), &text)?;
    let scenario = folder.join(format!("{name}-fleet.yaml"));
    let fleet = format!("graph: {name}.yaml\nseed: 1\nrobots: [{{count: 1, routes: random}}]\n");
    write(&scenario, &fleet)?;
    Ok((scenario, graph.edges().len() as u64))
}

/// Returns the ticks per second of a fleet.
fn rate_hz(robots: u32) -> u32 {
    RATES.iter().find(|(most, _)| robots <= *most).map_or(1, |(_, rate)| *rate)
}

/// Measures fleets of one robot and more, each ten times the one before, with one thread.
pub fn by_robots(bench: &Bench<'_>, most: u32) -> Result<Table, Failure> {
    let mut table = Table::of_ticks("Robots", "robots", "One thread, no reader.");
    for robots in (0..).map(|power| 10_u32.saturating_pow(power)).take_while(|count| *count <= most)
    {
        let fleet = Fleet {
            scenario: &bench.usual,
            robots,
            rate_hz: rate_hz(robots),
            threads: 1,
            readers: 0,
        };
        table.add(0, Line::of_tick(robots.into(), bench.cost(&fleet)?));
    }
    Ok(table)
}

/// Measures the largest fleet, and one of a tenth of its robots, with 1, 2, 4, … threads.
pub fn by_threads(bench: &Bench<'_>, robots: u32) -> Result<Table, Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut table = Table::of_ticks("Threads", "threads", "No reader.");
    for (number, robots) in [(robots / 10).max(1), robots].into_iter().enumerate() {
        table.name(number, format!("{robots} robots"));
        for threads in (0..).map(|power| 1 << power).take_while(|threads| *threads <= cores) {
            let fleet = Fleet {
                scenario: &bench.usual,
                robots,
                rate_hz: rate_hz(robots),
                threads,
                readers: 0,
            };
            table.add(number, Line::of_tick(threads as u64, bench.cost(&fleet)?));
        }
    }
    Ok(table)
}

/// Measures a fleet on warehouses of up to some number of edges.
pub fn by_edges(bench: &Bench<'_>, most: u64) -> Result<Table, Failure> {
    let mut table =
        Table::of_ticks("Edges", "edges", &format!("{ROBOTS} robots, one thread, no reader."));
    for size in &WAREHOUSES {
        let (scenario, edges) = warehouse(bench.folder, size)?;
        if edges > most {
            break;
        }
        let fleet = Fleet {
            scenario: &scenario,
            robots: ROBOTS,
            rate_hz: rate_hz(ROBOTS),
            threads: 1,
            readers: 0,
        };
        table.add(0, Line::of_tick(edges, bench.cost(&fleet)?));
    }
    Ok(table)
}

/// Measures a fleet with readers that read every frame, each in a process of its own.
pub fn by_readers(bench: &Bench<'_>, most: u64) -> Result<Table, Failure> {
    let note = format!(
        "{ROBOTS} robots, one thread; each reader is a process of `regatta plugin hello` that \
         reads every frame."
    );
    let mut table = Table::of_ticks("Readers", "readers", &note);
    for readers in [0, 1, 2, 4, 8, 16, 32, 60].into_iter().filter(|readers| *readers <= most) {
        let fleet = Fleet {
            scenario: &bench.usual,
            robots: ROBOTS,
            rate_hz: rate_hz(ROBOTS),
            threads: 1,
            readers,
        };
        table.add(0, Line::of_tick(readers, bench.cost(&fleet)?));
    }
    Ok(table)
}
