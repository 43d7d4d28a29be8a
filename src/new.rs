//! `regatta new`: makes a folder with everything to run a layout.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use regatta_base::file;
use regatta_layout::traffic::{Certificate, MainPart, RobotType};
use regatta_layout::{FindingKind, Findings, NodeIndex, ReadOptions, Role, RouteGraph};
use regatta_scenario::{Warnings, default_scenario, limits};

use crate::arguments::LayoutArgs;
use crate::failure::Failure;
use crate::output::{Force, check_file, quoted, unwritable, with_plural, write_file};
use crate::scenario::wanted_warnings;
use crate::trust;

/// The most edges of a layout whose traffic is examined, which takes some seconds then.
const MOST_EXAMINED: usize = 150_000;
/// The size of the largest file that is copied: a layout, or the picture of a map.
const MAX_COPY_BYTES: u64 = 1 << 30;
/// The largest number of remarks about one topic.
const MOST_REMARKS: usize = 3;

#[derive(Args)]
pub struct NewArgs {
    /// Layout of any format
    #[arg(value_hint = clap::ValueHint::FilePath)]
    plant: PathBuf,
    /// Folder to create; the name of the layout without its ending if not given
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    layout: LayoutArgs,
}

/// Runs `regatta new`.
///
/// # Errors
/// Returns an error if the layout can't be read or has errors, or if the folder has such files
/// already.
pub fn run(args: &NewArgs) -> Result<(), Failure> {
    let (graph, findings) = regatta_layout::read(&args.plant, &args.layout.options())?;
    // In the folder, the background lies beside the layout.
    let background = args.layout.background.as_deref().and_then(Path::file_name).map(PathBuf::from);
    let layout = LayoutArgs { background, ..args.layout.clone() };
    let options = layout.options();
    let name = args
        .plant
        .file_name()
        .ok_or("give the path of a layout file")?
        .to_string_lossy()
        .into_owned();
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(stem(&name)));
    let files = [
        ("scenario.yaml", default_scenario(&graph, &name, &options).into_bytes()),
        ("README.md", readme(&name, &layout, &graph).into_bytes()),
    ];
    let with_companions =
        |path: &Path| std::iter::once(path.to_owned()).chain(regatta_layout::companions(path));
    let copies = std::iter::once(&args.plant)
        .chain(&args.layout.background)
        .flat_map(|path| with_companions(path));
    let copies: BTreeMap<_, _> =
        copies.filter_map(|from| Some((folder.join(from.file_name()?), from))).collect();
    for (name, _) in &files {
        check_file(&folder.join(name), args.force)?;
    }
    for to in copies.keys() {
        check_file(to, args.force)?;
    }
    let is_new = !folder.exists();
    fs::create_dir_all(&folder).map_err(|error| unwritable(&folder, &error))?;
    for (to, from) in &copies {
        let bytes = file::read(from, MAX_COPY_BYTES)
            .map_err(|error| format!("{}: can't read: {error}; check the path", from.display()))?;
        write_file(to, &bytes, args.force)?;
    }
    for (name, bytes) in &files {
        write_file(&folder.join(name), bytes, args.force)?;
    }
    if is_new {
        // A user who can't be remembered is asked.
        let _ = trust::remember(&folder);
    }
    print_summary(&folder, &graph, findings);
    Ok(())
}

/// Returns the name of a file without its ending, and without that of its format in names such as
/// `plant.lif.json`.
fn stem(name: &str) -> &str {
    name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("plant")
}

fn print_summary(folder: &Path, graph: &RouteGraph, findings: Findings) {
    let folder = folder.display();
    let count = with_plural(findings.warnings(), "warning");
    println!("{folder}: {}; {count}", counts(graph));
    let of_scenario =
        limits(graph).into_iter().map(|limit| format!("{folder}: warning: {limit}")).collect();
    // The robots of the new scenario turn on the spot.
    let of_layout = findings.without(FindingKind::TurnsAtNodes);
    let warnings = Warnings { of_scenario, of_layout };
    for line in warnings.told(wanted_warnings()) {
        println!("{line}");
    }
    println!("regatta run {folder}/scenario.yaml");
}

fn counts(graph: &RouteGraph) -> String {
    let edges = with_plural(graph.edges().len(), "edge");
    let nodes = with_plural(graph.nodes().len(), "node");
    format!("{edges}, {nodes}, {}", with_plural(stations(graph), "station"))
}

/// The number of stations, and of nodes with a role that are no station's.
fn stations(graph: &RouteGraph) -> usize {
    let of_stations: BTreeSet<_> =
        graph.stations().iter().flat_map(|station| &station.nodes).copied().collect();
    let nodes = (0..).map(NodeIndex).zip(graph.nodes());
    let alone =
        nodes.filter(|(index, node)| node.role != Role::None && !of_stations.contains(index));
    graph.stations().len() + alone.count()
}

fn readme(name: &str, layout: &LayoutArgs, graph: &RouteGraph) -> String {
    let words = std::iter::once(name.to_owned()).chain(layout.to_args());
    let plant = words.map(|word| quoted(&word)).collect::<Vec<_>>().join(" ");
    let (fleet, load, stops) = match MainPart::of(graph) {
        Some(_) => (
            "a fleet that carries made-up orders",
            "the number of robots and the load",
            "Robots spend 5 to 15 s at each stop, by `dwell` of the load. `regatta study` of the \
             layout alone assumes\nno time at stops; give it `scenario.yaml`, or `--vary dwell=10`.\n",
        ),
        None => ("robots on random routes, without a manager", "and the number of robots", ""),
    };
    format!(
        "# {name}\n\n\
         A layout of {}, and a scenario for it.\n\n\
         ```console\n\
         $ regatta run scenario.yaml                # {fleet}\n\
         $ regatta graph check {plant} --traffic     # what can't be read, and what robots can't \
         do\n\
         $ regatta graph draw {plant} -o map.svg\n\
         ```\n\n\
         `scenario.yaml` has the robot types (size, speed, acceleration, rotation), {load}:\n\
         change them to those of your plant.\n{stops}{}",
        counts(graph),
        allowed(graph, &layout.options())
    )
}

/// Returns a section on what the layout allows robots.
fn allowed(graph: &RouteGraph, options: &ReadOptions) -> String {
    if graph.edges().len() > MOST_EXAMINED {
        return String::new();
    }
    let robot = RobotType::of_layout(graph, options);
    let certificate = Certificate::new(graph, &robot);
    let mut text = format!("\n## What the layout allows {}\n\n", robot.in_words());
    for sentence in certificate.sentences(graph, MOST_REMARKS) {
        text += &format!("- {sentence}\n");
    }
    text
}
