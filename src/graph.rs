//! `regatta graph`: checks, describes, generates and draws route graphs.

mod check;
mod convert;
mod traffic;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use clap::{Args, Subcommand};
use regatta_layout::generate::{Grid, Warehouse};
use regatta_layout::model::info::Info;
use regatta_layout::traffic::{Certificate, RobotType};
use regatta_layout::{
    FileText, Format, GraphError, ReadOptions, RouteGraph, WRITTEN_FORMATS, draw,
};
use regatta_scenario::{Overrides, Scenario, is_scenario};

use self::traffic::TrafficArgs;
use crate::arguments::{LayoutArgs, one_of};
use crate::failure::Failure;
use crate::output::{Destination, Force, STANDARD_STREAM, show, write_file};
use crate::progress::Progress;

/// A subcommand of `regatta graph`.
#[derive(Debug, Subcommand)]
pub enum GraphCommand {
    /// List all problems of a route graph or a scenario; exit code 0 if it can be driven
    Check {
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        traffic: TrafficArgs,
        /// Write a corrected copy: angles in degrees, repeated edges and ends that nearly meet
        #[arg(long, value_name = "FILE", conflicts_with_all = ["json", "traffic"])]
        fix: Option<Destination>,
        #[command(flatten)]
        force: Force,
        #[command(flatten)]
        file: FileArgs,
    },
    /// Print counts, length, bounding box, speeds and components
    Info {
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        file: FileArgs,
    },
    /// Generate a route graph of any size
    #[command(arg_required_else_help = false)]
    Generate {
        #[command(subcommand)]
        generator: Generator,
    },
    /// Draw a map of a layout, or of a scenario's, as SVG or PNG
    Draw {
        /// SVG or PNG file to write; - for SVG on standard output
        #[arg(short, long, value_name = "FILE")]
        output: Destination,
        #[command(flatten)]
        traffic: TrafficArgs,
        #[command(flatten)]
        force: Force,
        #[command(flatten)]
        file: FileArgs,
    },
    /// Write a layout in another format: ours, LIF, Nav2 or openTCS
    Convert {
        /// File to write; - for standard output
        #[arg(short, long, value_name = "FILE")]
        output: Destination,
        /// Format to write; taken from the file ending (.yaml, .json, .geojson, .xml) if not given
        #[arg(long, value_name = "FORMAT")]
        #[arg(value_parser = one_of::<Format>(WRITTEN_FORMATS.iter().map(|format| format.name())))]
        to: Option<Format>,
        #[command(flatten)]
        force: Force,
        #[command(flatten)]
        file: FileArgs,
    },
    /// List the differences between two layouts; exit code 1 if there are any
    Diff {
        /// First layout
        #[arg(value_hint = clap::ValueHint::FilePath)]
        first: PathBuf,
        /// Second layout
        #[arg(value_hint = clap::ValueHint::FilePath)]
        second: PathBuf,
        #[command(flatten)]
        layout: LayoutArgs,
    },
}

/// A route graph file, and the options of reading it.
#[derive(Debug, Args)]
pub struct FileArgs {
    /// Route graph or layout file of any format; - for standard input
    #[arg(value_hint = clap::ValueHint::FilePath)]
    file: PathBuf,
    #[command(flatten)]
    layout: LayoutArgs,
}

/// A generator of route graphs, with its parameters.
#[derive(Debug, Subcommand)]
pub enum Generator {
    /// Generate a warehouse: pick aisles between racks, cross aisles and a ring road
    Warehouse {
        /// Number of pick aisles side by side
        #[arg(long, default_value_t = 12)]
        aisles: u32,
        /// Number of rows of racks, with a cross aisle between adjacent rows
        #[arg(long, default_value_t = 3)]
        rows: u32,
        /// Number of stops along an aisle in each row
        #[arg(long, default_value_t = 6)]
        bays: u32,
        /// Add chargers in bays beside the ring road
        #[arg(long)]
        chargers: bool,
        #[command(flatten)]
        output: Output,
    },
    /// Generate a grid of streets that all cross each other
    Grid {
        /// Number of streets to the north
        #[arg(long, default_value_t = 5)]
        columns: u32,
        /// Number of streets to the east
        #[arg(long, default_value_t = 5)]
        rows: u32,
        /// Distance between streets in metres
        #[arg(long, default_value_t = 20)]
        spacing: u32,
        /// Make the streets inside the two-way ring one-way
        #[arg(long)]
        one_way: bool,
        #[command(flatten)]
        output: Output,
    },
}

/// The destination of a generated graph.
#[derive(Debug, Args)]
pub struct Output {
    /// File to write; - for standard output
    #[arg(short, long, value_name = "FILE", default_value = STANDARD_STREAM)]
    output: Destination,
    #[command(flatten)]
    force: Force,
}

/// Runs `regatta graph`.
///
/// # Errors
/// Returns an error if a file can't be read or written, if a route graph is invalid, or if an
/// argument is out of range.
pub fn run(command: GraphCommand) -> Result<ExitCode, Failure> {
    match command {
        GraphCommand::Check { file, fix: Some(output), force, .. } => {
            convert::fix(&file, &output, force)?
        }
        GraphCommand::Check { file, json, traffic, .. } => {
            return check::run(&file, json, &traffic);
        }
        GraphCommand::Info { file, json } => info(&file, json)?,
        GraphCommand::Generate { generator } => generate(&generator)?,
        GraphCommand::Draw { file, output, traffic, force } => {
            draw(&file, &output, &traffic, force)?
        }
        GraphCommand::Convert { file, output, to, force } => {
            convert::run(&file, &output, to, force)?
        }
        GraphCommand::Diff { first, second, layout } => return diff(&first, &second, &layout),
    }
    Ok(ExitCode::SUCCESS)
}

fn info(file: &FileArgs, json: bool) -> Result<(), Failure> {
    let _progress = Progress::start(format!("reading {}", file.name()), 0);
    let info = Info::of(&file.read()?);
    match json {
        true => println!("{}", serde_json::to_string_pretty(&info)?),
        false => show(info),
    }
    Ok(())
}

fn generate(generator: &Generator) -> Result<(), Failure> {
    let (Generator::Warehouse { output, .. } | Generator::Grid { output, .. }) = generator;
    output.output.check(output.force)?;
    let progress = Progress::start("generating", 0);
    let text = match *generator {
        Generator::Warehouse { aisles, rows, bays, chargers: false, .. } => {
            Warehouse { aisles, rows, bays }.generate()?
        }
        Generator::Warehouse { aisles, rows, bays, chargers: true, .. } => {
            Warehouse { aisles, rows, bays }.generate_with_chargers()?
        }
        Generator::Grid { columns, rows, spacing, one_way, .. } => {
            Grid { columns, rows, spacing, one_way }.generate()?
        }
    };
    drop(progress);
    output.output.write(&text, output.force)
}

fn draw(
    file: &FileArgs,
    output: &Destination,
    traffic: &TrafficArgs,
    force: Force,
) -> Result<(), Failure> {
    let png = match output {
        Destination::File(path) if has_ending(path, "png") => Some(path),
        Destination::File(path) if !has_ending(path, "svg") => {
            let advice = "a map is drawn as SVG or PNG; give a file that ends in .svg or .png";
            return Err(format!("{}: {advice}", path.display()).into());
        }
        _ => None,
    };
    output.check(force)?;
    let progress = Progress::start(format!("reading {}", file.name()), 0);
    let (graph, robot) = read_with_robot(file, traffic)?;
    progress.set_current("drawing");
    let map = match robot {
        None => draw::svg(&graph),
        Some(robot) => draw::svg_with_traffic(&graph, &Certificate::new(&graph, &robot)),
    };
    match png {
        None => output.write(&map, force),
        Some(path) => write_file(path, &regatta_record::png(&map)?, force),
    }
}

/// Reads a layout, or that of a scenario, and the robot that a certificate of it is wanted for, if
/// one is: of a scenario, that with the largest footprint.
fn read_with_robot(
    file: &FileArgs,
    traffic: &TrafficArgs,
) -> Result<(Arc<RouteGraph>, Option<RobotType>), Failure> {
    let (text, name) = (file.text()?, file.name());
    match regatta_layout::parse(&text, &name, &file.options()) {
        Ok((graph, _)) => {
            let robot = traffic.robot_on(&graph, &file.options())?;
            Ok((Arc::new(graph), robot))
        }
        Err(_) if is_scenario(&text) => {
            let overrides = Overrides { layout: file.options(), ..Overrides::default() };
            let scenario = Scenario::from_text(&text, Path::new(&name), &overrides)?;
            let robot = traffic.robots_of(&scenario)?.into_iter().next();
            Ok((scenario.graph, robot.map(|named| named.robot)))
        }
        Err(error) => Err(error.into()),
    }
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// Compares two layouts, each read with the options that its format has.
fn diff(first: &Path, second: &Path, layout: &LayoutArgs) -> Result<ExitCode, Failure> {
    let _progress = Progress::start("comparing", 0);
    let (first, _) = regatta_layout::read(first, &layout.options())?;
    let (second, _) = regatta_layout::read(second, &layout.options())?;
    let differences = regatta_layout::check::diff::diff(&first, &second);
    for difference in &differences {
        show(format_args!("{difference}\n"));
    }
    Ok(if differences.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl FileArgs {
    fn options(&self) -> ReadOptions {
        self.layout.options()
    }

    /// Returns the name of the file in messages.
    fn name(&self) -> String {
        match self.is_standard_input() {
            true => "standard input".to_owned(),
            false => self.file.display().to_string(),
        }
    }

    /// Returns the folder that paths in the file start from; `None` of standard input.
    fn folder(&self) -> Option<&Path> {
        match self.is_standard_input() {
            true => None,
            false => Some(self.file.parent().unwrap_or(Path::new(""))),
        }
    }

    fn is_standard_input(&self) -> bool {
        self.file == Path::new(STANDARD_STREAM)
    }

    fn text(&self) -> Result<FileText, GraphError> {
        if self.is_standard_input() {
            return regatta_layout::read_stream(std::io::stdin().lock(), &self.name());
        }
        regatta_layout::read_file(&self.file)
    }

    fn read(&self) -> Result<RouteGraph, Failure> {
        Ok(self.read_with_findings()?.0)
    }

    fn read_with_findings(&self) -> Result<(RouteGraph, regatta_layout::Findings), Failure> {
        let text = self.text()?;
        match regatta_layout::parse(&text, &self.name(), &self.options()) {
            Ok(read) => Ok(read),
            Err(_) if is_scenario(&text) => Err(format!(
                "{}: this is a scenario; give the route graph that it names",
                self.name()
            )
            .into()),
            Err(error) => Err(error.into()),
        }
    }
}
