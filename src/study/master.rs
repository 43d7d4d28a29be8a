//! `regatta study --vda5050`: finds the number of vehicles that a master of VDA 5050 copes with, by
//! runs in real time on a broker.

mod ear;
mod figures;
mod hand_over;
mod http;
mod live_run;
mod load;
mod site;
mod start;
mod template;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use clap::Args;
use regatta_plugin::Termination;
use regatta_study::certificate::most_robots;
use regatta_study::master::{MasterAnswer, MasterPlan, MasterPoint, MasterRun, Verdict, sweep};
use regatta_study::page::{master_content, master_title, vehicles_in_words};
use regatta_study::plan::{Precision, Robots, RunTime, Variant, is_study};
use regatta_study::store::check_folder;
use regatta_vda5050::broker::BrokerUrl;

use self::hand_over::Way;
use self::live_run::{LiveRun, RunError};
use self::site::Site;
use super::{FOUND, StudyArgs, output, request};
use crate::arguments::Time;
use crate::day::{Resample, read_orders_of_load};
use crate::failure::{Failure, plugin_failure};
use crate::output::unwritable;
use crate::version;

/// The heading of the options in the help.
const HEADING: &str = "Master of VDA 5050";
/// The shortest and the longest run, in seconds.
const RUN_SECS: std::ops::RangeInclusive<u64> = 5..=24 * 3600;
const DEFAULT_SECS: u64 = 180;
/// The largest number of vehicles that is tried if none is asked for.
const MOST_VEHICLES: u32 = 1000;

/// The options of a study of a master.
#[derive(Args, Clone, Debug)]
pub struct MasterArgs {
    /// Find the number of vehicles that a VDA 5050 master copes with, in real time, on this MQTT
    /// broker or, without an address, on one that is started here. With --manager, each run starts
    /// the master; without it, the master must already be running
    #[arg(long, value_name = "mqtt://[USER@]HOST[:PORT]", num_args = 0..=1, help_heading = HEADING)]
    #[arg(
        conflicts_with_all = ["target", "seeds", "vary", "bound", "reliefs", "jobs", "processes"]
    )]
    #[arg(conflicts_with_all = ["on", "export_jobs", "record", "foreign_results"])]
    vda5050: Option<Option<BrokerUrl>>,
    /// Command that hands a transport order to the master, with {id}, {pick} and {drop}; without it
    /// and without --order-url, the master makes its own orders
    #[arg(long, value_name = "COMMAND", requires = "vda5050", help_heading = HEADING)]
    order_command: Option<String>,
    /// Address to which a transport order is sent by POST, with {id}, {pick} and {drop}
    #[arg(long, value_name = "http://HOST/PATH", requires = "vda5050", help_heading = HEADING)]
    #[arg(conflicts_with = "order_command")]
    order_url: Option<String>,
    /// Body of the request to --order-url
    #[arg(long, value_name = "JSON", requires = "order_url", help_heading = HEADING)]
    #[arg(default_value = r#"{"id": "{id}", "pick": "{pick}", "drop": "{drop}"}"#)]
    order_body: String,
    /// Header of the request to --order-url; may be repeated
    #[arg(long, value_name = "NAME: VALUE", requires = "order_url", help_heading = HEADING)]
    order_header: Vec<String>,
    /// Number of runs of each number of vehicles
    #[arg(long, value_name = "N", requires = "vda5050", help_heading = HEADING)]
    #[arg(default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=100))]
    repeats: u64,
    /// Time after which a base that the master could have sent is late
    #[arg(long, value_name = "TIME", requires = "vda5050", help_heading = HEADING)]
    #[arg(default_value = "1s")]
    late: Time,
    /// Options of `regatta plugin vda5050` for the vehicles, such as '--protocol 2.1 --anonymous'
    #[arg(long, value_name = "OPTIONS", requires = "vda5050", help_heading = HEADING)]
    #[arg(allow_hyphen_values = true)]
    vehicle_options: Option<String>,
}

impl MasterArgs {
    /// The broker of a study of a master, `None` in it for one that is started here; `None` for
    /// another study.
    pub fn broker(&self) -> Option<Option<&BrokerUrl>> {
        self.vda5050.as_ref().map(Option::as_ref)
    }

    fn way(&self) -> Result<Way, Failure> {
        if let Some(command) = &self.order_command {
            return Way::command(command);
        }
        match &self.order_url {
            Some(url) => Way::post(url, &self.order_body, &self.order_header),
            None => Ok(Way::Own),
        }
    }
}

/// Runs a study of a master.
///
/// # Errors
/// If the plant can't be studied, the broker can't be reached or started, or the page can't be
/// written.
pub fn run(args: &StudyArgs, broker: Option<&BrokerUrl>) -> Result<ExitCode, Failure> {
    let way = args.master.way()?;
    let browser = args.browser()?;
    let plan = plan(args, &way, broker)?;
    let folder = folder(args, &plan)?;
    let termination = Termination::watch().map_err(plugin_failure)?;
    let options = args.master.vehicle_options.as_deref().unwrap_or_default();
    let site = Site::new(&plan.variant, broker, options, args.manager.as_deref(), way)?;
    let (points, is_interrupted) = points(&plan, &site, &termination);
    let answer = MasterAnswer::new(&plan, points, is_interrupted);
    let blocks = master_content(&answer, &plan.variant);
    let json = serde_json::to_value(&answer)?;
    output::write_page(&json, &master_title(&answer), &blocks, &folder, browser.as_ref())?;
    Ok(if answer.is_good() { ExitCode::SUCCESS } else { ExitCode::from(FOUND) })
}

fn plan(args: &StudyArgs, way: &Way, broker: Option<&BrokerUrl>) -> Result<MasterPlan, Failure> {
    let plant = &args.plant;
    if is_study(&request::text(plant)?) {
        let file = plant.display();
        return Err(format!("{file}: a study file isn't for masters: give its plant").into());
    }
    let variant = variant(args, plant)?;
    let secs = args.duration.map_or(DEFAULT_SECS, |time| time.0.as_secs());
    if !RUN_SECS.contains(&secs) {
        return Err("the duration of a run of a master: give 5 seconds to 24 hours".into());
    }
    let time = RunTime { secs, rate_hz: args.rate };
    let most = most_robots(&variant).unwrap_or(MOST_VEHICLES).min(MOST_VEHICLES);
    let most = start::room(&variant, most).max(1);
    let master = match (&args.manager, broker) {
        (Some(command), _) => format!("`{command}`"),
        (None, Some(url)) => format!("a program at {url}"),
        (None, None) => "a program at the study's own broker".to_owned(),
    };
    let orders = match way {
        Way::Own => way.to_string(),
        Way::Command(_) | Way::Post { .. } => format!("{}, {way}", variant.load),
    };
    Ok(MasterPlan {
        title: request::title(plant),
        master,
        orders,
        is_load_endless: *way != Way::Own && variant.is_load_endless(),
        vehicles: args.robots.clone().unwrap_or(Robots::Range(1, most)),
        repeats: args.master.repeats,
        time,
        late_secs: args.master.late.0.as_secs_f64(),
        resolution: Precision::default().resolution,
        program: version::short(),
        variant,
    })
}

/// Reads the plant, with the orders of a day if there is one: as they are, unless it is asked for
/// days of their kind.
fn variant(args: &StudyArgs, plant: &Path) -> Result<Variant, Failure> {
    let mut variant = Variant::read(plant, &args.layout.options())?;
    let mut day_args = args.day.clone().or_of_load(&variant)?;
    if day_args.orders.is_some() {
        day_args.resample.get_or_insert(Resample::None);
    }
    if let Some(day) = day_args.day()? {
        variant = variant.with_day(&Arc::new(day))?;
        day_args.check(&variant)?;
    } else {
        read_orders_of_load(&mut variant)?;
    }
    variant.check(args.rate)?;
    for part in &variant.left_out {
        regatta_plugin::tell!("{}: warning: left out: {part}", plant.display());
    }
    Ok(variant)
}

/// Makes the folder of the study.
fn folder(args: &StudyArgs, plan: &MasterPlan) -> Result<PathBuf, Failure> {
    let default = || PathBuf::from(format!("study-{}", plan.title));
    let folder = args.output.clone().unwrap_or_else(default);
    std::fs::create_dir_all(&folder).map_err(|error| unwritable(&folder, &error))?;
    check_folder(&folder)?;
    Ok(folder)
}

/// Does runs until the answer is there, or the user ends it. Returns the points, and whether the
/// user has ended it.
fn points(
    plan: &MasterPlan,
    site: &Site<'_>,
    termination: &Termination,
) -> (Vec<MasterPoint>, bool) {
    let mut points: BTreeMap<u32, MasterPoint> = BTreeMap::new();
    loop {
        let known: BTreeMap<u32, Verdict> =
            points.iter().map(|(vehicles, point)| (*vehicles, point.verdict)).collect();
        let Some(vehicles) = sweep::next(&plan.vehicles, plan.resolution, &known) else {
            return (points.into_values().collect(), false);
        };
        let (runs, end) = repeats(plan, site, vehicles, termination);
        let is_interrupted = matches!(end, Err(RunError::Interrupted));
        // A point of which nothing was measured isn't told.
        if !is_interrupted || !runs.is_empty() {
            let failure = end.err().map(|error| error.to_string());
            let point =
                MasterPoint::new(vehicles, runs, failure, plan.late_secs, plan.is_load_endless);
            points.insert(vehicles, point);
        }
        if is_interrupted {
            return (points.into_values().collect(), true);
        }
    }
}

/// Does the runs of a number of vehicles, up to the first one that gives no figures.
fn repeats(
    plan: &MasterPlan,
    site: &Site<'_>,
    vehicles: u32,
    termination: &Termination,
) -> (Vec<MasterRun>, Result<(), RunError>) {
    let mut runs = Vec::new();
    for repeat in 1..=plan.repeats {
        let name = format!("{}, run {repeat} of {}", vehicles_in_words(vehicles), plan.repeats);
        regatta_plugin::tell!("study: {name}: {} s in real time", plan.time.secs);
        let live = LiveRun { plan, site, vehicles, repeat, termination };
        match live.measure() {
            Ok(raw) => runs.push(MasterRun::new(vehicles, repeat, raw, plan.late_secs)),
            Err(error) => {
                regatta_plugin::tell!("study: {name}: {error}");
                return (runs, Err(error));
            }
        }
    }
    (runs, Ok(()))
}
