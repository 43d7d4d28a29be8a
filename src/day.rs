//! The options of commands that replay the orders of a day.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use clap::Args;
use regatta_layout::RouteGraph;
use regatta_orders::{FileTime, Places, TimedDraft, check_orders, read_orders, read_table, to_csv};
use regatta_plugin::tell;
use regatta_scenario::Scenario;
use regatta_study::plan::{Day, DayClock, Load, Variant};
use serde::Deserialize;
use serde_json::json;

use crate::arguments::Time;
use crate::failure::Failure;

/// The block of which days of a study are drawn, unless another one is given, in seconds.
const BLOCK_SECS: f64 = 1800.0;
/// Seconds of a day.
const DAY_SECS: f64 = 86_400.0;

/// The orders of a day.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Orders of a day")]
pub struct DayArgs {
    /// File with orders and their times (CSV, XLSX, Parquet or YAML); replaces the load
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    pub orders: Option<PathBuf>,
    /// Factor for the number of orders of the file, such as 1.2
    #[arg(long, value_name = "FACTOR")]
    pub scale: Option<f64>,
    /// Time by which all orders are delayed
    #[arg(long, value_name = "TIME")]
    pub shift: Option<Time>,
    /// Draw the day of each seed from blocks of this length; `none` uses the day as it is [default:
    /// none, in a study 30min]
    #[arg(long, value_name = "TIME")]
    pub resample: Option<Resample>,
}

/// The part of a scenario with its load.
#[derive(Deserialize)]
struct WithLoad {
    load: Option<Load>,
}

/// The way to the day of a seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resample {
    /// Each seed has the day as it is.
    None,
    /// Each seed has a day that is drawn from blocks of this time.
    Blocks(Time),
}

impl FromStr for Resample {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "none" => Ok(Self::None),
            _ => text.parse().map(Self::Blocks).map_err(|error| format!("{error}; or none")),
        }
    }
}

impl Resample {
    fn secs(self) -> Option<f64> {
        match self {
            Self::None => None,
            Self::Blocks(time) => Some(time.0.as_secs_f64()),
        }
    }
}

impl DayArgs {
    fn shift_secs(&self) -> f64 {
        self.shift.map_or(0.0, |time| time.0.as_secs_f64())
    }

    /// Returns the day as a load that the fleet manager reads, with what a scenario's load says of
    /// stops, stations and storages; `None` if there is no file.
    ///
    /// # Errors
    /// If the path of the file can't be made absolute, or an option needs the file.
    pub fn load(&self, scenario: &Scenario) -> Result<Option<String>, Failure> {
        let Some(path) = &self.orders else { return self.without_orders() };
        let given = scenario.source.sections::<WithLoad>()?.load.filter(|_| !scenario.is_default);
        let mut load = json!(given.as_ref().map(Load::without_orders).unwrap_or_default());
        load["orders"] = json!(std::path::absolute(path)?);
        load["shift"] = self.shift_secs().into();
        if let Some(scale) = self.scale {
            load["scale"] = scale.into();
        }
        if let Some(secs) = self.resample.and_then(Resample::secs) {
            load["resample"] = secs.into();
        }
        Ok(Some(json!({ "load": load }).to_string()))
    }

    /// Returns the options with those of a load of a plant that is a file of orders and nothing
    /// else, if there is no other file.
    ///
    /// # Errors
    /// If a number of the load is wrong.
    pub fn or_of_load(self, variant: &Variant) -> Result<Self, Failure> {
        let load = variant.load_entry().filter(|_| self.orders.is_none());
        let Some(part) = load.and_then(Load::only_file) else { return Ok(self) };
        let of_part = self.or_of_part(part, folder(&variant.file));
        of_part.map_err(|reason| format!("{}: load: {reason}", variant.file.display()).into())
    }

    fn or_of_part(mut self, part: &Load, folder: &Path) -> Result<Self, String> {
        self.orders = part.file_of_orders().map(|file| folder.join(file));
        self.scale = self.scale.or(number(part, "scale")?);
        self.shift = self.shift.or(time(part, "shift")?);
        self.resample = self.resample.or(time(part, "resample")?.map(Resample::Blocks));
        Ok(self)
    }

    fn without_orders<T>(&self) -> Result<Option<T>, Failure> {
        if self.scale.is_some() || self.shift.is_some() || self.resample.is_some() {
            return Err("--scale, --shift and --resample are for a day: give its --orders".into());
        }
        Ok(None)
    }

    /// Reads the day for a study; `None` if there is no file.
    ///
    /// # Errors
    /// If the file can't be read or is wrong, or an option needs the file.
    pub fn day(&self) -> Result<Option<Day>, Failure> {
        let Some(path) = &self.orders else { return self.without_orders() };
        let table = read_table(path)?;
        if let Some(line) = table.midnight_line {
            let path = path.display();
            tell!("study: {path}: from line {line} on, times are of the next day");
        }
        if table.hidden_rows > 0 {
            let (path, rows) = (path.display(), table.hidden_rows);
            tell!("study: {path}: {rows} hidden rows of the workbook are read as all others");
        }
        for note in &table.notes {
            tell!("study: {}: {note}", path.display());
        }
        let clock = table.begin.and_then(clock);
        let orders = table.into_orders().map_err(|error| of_file(path, &error.to_string()))?;
        let Some(last_secs) = orders.iter().map(|order| order.secs).reduce(f64::max) else {
            return Err(format!("{}: there are no orders in it", path.display()).into());
        };
        let block_secs = self.resample.map_or(Some(BLOCK_SECS), Resample::secs);
        Ok(Some(Day {
            file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            timetable: to_csv(&orders),
            stops: stops(&orders),
            orders: orders.len(),
            has_dwell: has_dwell(&orders),
            clock,
            last_secs,
            scale: self.scale.unwrap_or(1.0),
            shift_secs: self.shift_secs(),
            block_secs,
        }))
    }

    /// Checks that a plant has the stations and the storages of the file.
    ///
    /// # Errors
    /// If it hasn't, or the file is wrong.
    pub fn check(&self, variant: &Variant) -> Result<(), Failure> {
        let Some(path) = &self.orders else { return Ok(()) };
        let (places, load) = (places(&variant.graph), json!({ "load": variant.load_entry() }));
        let places = regatta_orders::Load::places(&load.to_string(), &places)
            .map_err(|error| format!("{}: load: {}", variant.file.display(), error.reason))?;
        let checked = check_orders(&read_orders(path)?, &places);
        checked.map(drop).map_err(|error| of_file(path, &error.to_string()))
    }
}

/// Puts the orders of files that a plant's load names beside other generators into the load.
/// Returns the files.
///
/// # Errors
/// If a file can't be read or is wrong.
pub fn read_orders_of_load(variant: &mut Variant) -> Result<Vec<PathBuf>, Failure> {
    let folder = folder(&variant.file).to_owned();
    let Some(load) = variant.load_entry_mut() else { return Ok(Vec::new()) };
    let mut files = Vec::new();
    for part in load.generators.iter_mut().flatten() {
        let Some(file) = part.file_of_orders() else { continue };
        let path = folder.join(file);
        let orders = read_table(&path)?.into_orders();
        part.set_timetable(to_csv(&orders.map_err(|error| of_file(&path, &error.to_string()))?));
        files.push(path);
    }
    Ok(files)
}

fn folder(file: &Path) -> &Path {
    file.parent().unwrap_or(Path::new(""))
}

/// Returns a number of a load.
fn number(load: &Load, key: &str) -> Result<Option<f64>, String> {
    let Some(value) = load.rest.get(key) else { return Ok(None) };
    let number = value.as_f64().filter(|number| *number >= 0.0);
    number.map(Some).ok_or_else(|| format!("{key}: {value}: give a number of at least 0"))
}

/// Returns a number of a load that is a time in seconds.
fn time(load: &Load, key: &str) -> Result<Option<Time>, String> {
    let Some(secs) = number(load, key)? else { return Ok(None) };
    let time = Duration::try_from_secs_f64(secs);
    time.map(|time| Some(Time(time))).map_err(|error| format!("{key}: {secs}: {error}"))
}

/// Returns the time of day at which a day begins; `None` if its times are those of the simulation.
fn clock(begin: FileTime) -> Option<DayClock> {
    let is_utc = match begin {
        FileTime::Secs(_) => return None,
        FileTime::Clock(_) | FileTime::Local(_) => false,
        FileTime::Instant(_) => true,
    };
    Some(DayClock { begin_secs: begin.secs().rem_euclid(DAY_SECS), is_utc })
}

fn of_file(path: &Path, reason: &str) -> Failure {
    let path = path.display();
    format!("{path}, {reason}; `regatta orders check {path} --plant PLANT` shows all such rows")
        .into()
}

/// Whether any stop has a time that a robot spends there.
pub fn has_dwell(orders: &[TimedDraft]) -> bool {
    let stops = orders.iter().flat_map(|order| &order.draft.destinations);
    stops.into_iter().any(|stop| stop.dwell > 0.0)
}

/// Returns the names of all stops.
fn stops(orders: &[TimedDraft]) -> BTreeSet<String> {
    let stops = orders.iter().flat_map(|order| &order.draft.destinations);
    stops.map(|stop| stop.location_name.to_string()).collect()
}

/// Returns the places of a layout that orders may name, as a fleet manager knows them. Its robots
/// aren't known: orders may be for any robot types.
pub fn places(graph: &RouteGraph) -> Places {
    Places::of(&regatta_engine::engine::world(graph).view(0, 0)).without_robot_types()
}
