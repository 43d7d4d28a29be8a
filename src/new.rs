//! `regatta new`: makes a folder with everything to run a layout.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use regatta_engine::graph::{self, RouteGraph};
use regatta_engine::scenario::made_up_scenario;

use crate::arguments::LayoutArgs;
use crate::failure::Failure;
use crate::output::{Force, check_file, write_file};

#[derive(Args)]
pub struct NewArgs {
    /// Layout of any format
    #[arg(value_hint = clap::ValueHint::FilePath)]
    plant: PathBuf,
    /// Folder to make; the name of the layout without its ending if not given
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    layout: LayoutArgs,
    #[command(flatten)]
    force: Force,
}

/// Runs `regatta new`.
///
/// # Errors
/// Returns an error if the layout can't be read or has errors, or if the folder has such files already.
pub fn run(args: &NewArgs) -> Result<(), Failure> {
    let options = args.layout.options();
    let (graph, findings) = graph::read(&args.plant, &options)?;
    let name = args.plant.file_name().ok_or("give the path of a layout file")?.to_string_lossy().into_owned();
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(stem(&name)));
    let files = [
        ("scenario.yaml", made_up_scenario(&graph, &name, &options).into_bytes()),
        ("README.md", readme(&name, &graph).into_bytes()),
    ];
    let copies = std::iter::once(args.plant.clone()).chain(graph::format::companions(&args.plant));
    let copies: Vec<_> = copies.filter_map(|from| Some((folder.join(from.file_name()?), from))).collect();
    let is_new = |path: &Path| check_file(path, args.force).map(|_| ());
    files.iter().try_for_each(|(name, _)| is_new(&folder.join(name)))?;
    copies.iter().try_for_each(|(to, _)| is_new(to))?;

    let unwritable = |path: &Path, error| format!("{}: can't write: {error}", path.display());
    fs::create_dir_all(&folder).map_err(|error| unwritable(&folder, error))?;
    for (to, from) in &copies {
        let bytes = fs::read(from).map_err(|error| format!("{}: can't read: {error}", from.display()))?;
        write_file(to, &bytes, args.force)?;
    }
    for (name, bytes) in &files {
        write_file(&folder.join(name), bytes, args.force)?;
    }
    print_summary(&folder, &graph, findings.warnings());
    Ok(())
}

/// Returns the name of a file without its ending, and without that of its format in names such as `plant.lif.json`.
fn stem(name: &str) -> &str {
    name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("plant")
}

fn print_summary(folder: &Path, graph: &RouteGraph, warnings: usize) {
    let (edges, nodes, stations) = (graph.edges().len(), graph.nodes().len(), graph.stations().len());
    let folder = folder.display();
    println!(
        "{folder}: {edges} edges, {nodes} nodes, {stations} stations; {warnings} warnings (`regatta graph check` lists them)"
    );
    println!("regatta run {folder}/scenario.yaml");
}

fn readme(name: &str, graph: &RouteGraph) -> String {
    format!(
        "# {name}\n\n\
         A layout of {} edges, {} nodes and {} stations, and a scenario for it.\n\n\
         ```console\n\
         $ regatta run scenario.yaml                # robots on random routes, with the collision checker\n\
         $ regatta graph check {name}     # what of the layout wasn't understood, and what can't be driven\n\
         $ regatta graph draw {name} -o map.svg\n\
         ```\n\n\
         `scenario.yaml` has the robot types (size, speed, acceleration, rotation) and the number of robots: change them to\n\
         those of your plant.\n",
        graph.edges().len(),
        graph.nodes().len(),
        graph.stations().len(),
    )
}
