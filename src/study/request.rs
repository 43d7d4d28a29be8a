//! The plan of a study, from a command line and a study file.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::ValueEnum;
use regatta_base::file;
use regatta_fleet_manager::PlannerKind;
use regatta_layout::{MAX_FILE_BYTES, ReadOptions};
use regatta_orders::Load;
use regatta_scenario::document;
use regatta_study::certificate::most_robots;
use regatta_study::job::{Manager, content_hash};
use regatta_study::plan::{
    Axis, Day, FLEET_MANAGER, Input, Plan, Precision, Question, Robots, RunTime, Setting,
    StudyFile, Variant, is_study,
};
use serde_json::{Value, json};

use super::StudyArgs;
use crate::arguments::Time;
use crate::day::{DayArgs, Resample, places, read_orders_of_load};
use crate::failure::Failure;
use crate::scenario::wanted_warnings;
use crate::{trust, version};

/// The shortest and the longest run, in seconds.
const RUN_SECS: std::ops::RangeInclusive<u64> = 120..=7 * 24 * 3600;
const DEFAULT_SECS: u64 = 1800;
const DEFAULT_RELIEFS: usize = 6;
/// The largest number of robots that is tried if none is asked for.
const MOST_ROBOTS: u32 = 1000;

/// Makes the plan of the command line, and of the study file if there is one.
pub fn plan(args: &StudyArgs) -> Result<Plan, Failure> {
    let path = &args.plant;
    let text = text(path)?;
    let file: Option<StudyFile> = if is_study(&text) { Some(document(&text, path)?) } else { None };
    let plant = match &file {
        Some(file) => path.parent().unwrap_or(Path::new("")).join(&file.plant),
        None => path.clone(),
    };
    let options = args.layout.options();
    let mut precision =
        file.as_ref().map_or_else(|| Ok(Precision::default()), StudyFile::precision)?;
    if let Some((least, most)) = args.seeds {
        (precision.least_seeds, precision.most_seeds) = (least, most);
    }
    let title = file.as_ref().and_then(|file| file.title.clone()).unwrap_or_else(|| title(&plant));
    let robots = args.robots.clone().or_else(|| file.as_ref()?.robots.clone());
    let question = question(args, file.as_ref());
    // Runs of a day take long: those of reliefs are asked for.
    let default_reliefs = if question == Question::Knee { DEFAULT_RELIEFS } else { 0 };
    let reliefs = args.reliefs.or_else(|| file.as_ref()?.reliefs).unwrap_or(default_reliefs);
    let mut axes = file.as_ref().map_or_else(|| Ok(Vec::new()), StudyFile::axes)?;
    // The command line overrides the file.
    axes.retain(|axis| args.vary.iter().all(|other| other.setting != axis.setting));
    trust::require(&path.display().to_string(), path.parent(), &programs(&axes), args.trust)?;
    axes.extend(args.vary.iter().cloned());
    let base = Variant::read(&plant, &options)?;
    let day_args = day_args(args, file.as_ref(), &base, &axes)?;
    let day = day_args.day()?;
    let (base, mut files) = with_orders(base, day.as_ref())?;
    files.extend(day_args.orders.clone());
    let variants = variants(base, &checked(axes)?, args, &options)?;
    let inputs = inputs(path, &files, &variants)?;
    for variant in &variants {
        day_args.check(variant)?;
        check_load(variant)?;
    }
    Ok(Plan {
        title,
        robots: robots.unwrap_or_else(|| default_robots(&question, &variants)),
        question,
        precision,
        time: RunTime { secs: secs(args, file.as_ref(), day.as_ref())?, rate_hz: args.rate },
        reliefs,
        inputs,
        prices: file.and_then(|file| file.prices),
        program: version::short(),
        variants,
    })
}

/// Returns the text of a plant or of a study file.
pub fn text(path: &Path) -> Result<String, Failure> {
    let text = file::read(path, MAX_FILE_BYTES)
        .map_err(|error| format!("{}: can't read: {error}; check the path", path.display()))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

/// Returns the files that the study is made of: the study file or the plant, those of the variants,
/// and the orders.
fn inputs(path: &Path, orders: &[PathBuf], variants: &[Variant]) -> Result<Vec<Input>, Failure> {
    let mut paths = vec![path];
    paths.extend(variants.iter().map(|variant| variant.file.as_path()));
    paths.extend(orders.iter().map(PathBuf::as_path));
    let mut inputs: Vec<Input> = Vec::new();
    for path in paths {
        let bytes = file::read(path, MAX_FILE_BYTES)
            .map_err(|error| format!("{}: can't read: {error}; check the path", path.display()))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let input = Input { name, hash: content_hash(&bytes) };
        if !inputs.contains(&input) {
            inputs.push(input);
        }
    }
    Ok(inputs)
}

fn question(args: &StudyArgs, file: Option<&StudyFile>) -> Question {
    let of_file = file.map(|file| file.targets.clone()).unwrap_or_default();
    match if args.target.is_empty() { of_file } else { args.target.clone() } {
        targets if targets.is_empty() => Question::Knee,
        targets => Question::Least(targets),
    }
}

/// Returns the options of the day, with those of the study file for what the command line lacks. A
/// load that is a file of orders is a day, too.
fn day_args(
    args: &StudyArgs,
    file: Option<&StudyFile>,
    base: &Variant,
    axes: &[Axis],
) -> Result<DayArgs, Failure> {
    let mut day = args.day.clone();
    if let Some(file) = file {
        let folder = args.plant.parent().unwrap_or(Path::new(""));
        day.orders = day.orders.or_else(|| Some(folder.join(file.orders.as_ref()?)));
        day.scale = day.scale.or(file.scale);
        if let (None, Some(value)) = (day.resample, &file.resample) {
            let resample = plain(value).parse::<Resample>();
            day.resample = Some(resample.map_err(|error| format!("resample: {error}"))?);
        }
    }
    let varies_load = axes.iter().any(|axis| axis.setting == Setting::Load);
    match (varies_load, day.orders.is_some()) {
        (true, true) => Err("load: --orders replaces it: give only one of the two".into()),
        (true, false) => Ok(day),
        (false, _) => day.or_of_load(base),
    }
}

/// Returns the plant with the orders of a day if there is one, or else with those of the files that
/// its load names, and these files.
fn with_orders(mut base: Variant, day: Option<&Day>) -> Result<(Variant, Vec<PathBuf>), Failure> {
    match day {
        Some(day) => Ok((base.with_day(&Arc::new(day.clone()))?, Vec::new())),
        None => {
            let files = read_orders_of_load(&mut base)?;
            Ok((base, files))
        }
    }
}

/// Checks that Regatta's fleet manager can carry out the load of a variant: a run would fail.
fn check_load(variant: &Variant) -> Result<(), Failure> {
    let Manager::BuiltIn(_) = &variant.manager else { return Ok(()) };
    let Some(load) = variant.load_entry() else { return Ok(()) };
    let text = match variant.is_day() {
        // Its orders were checked.
        true => json!({ "load": load.without_generators() }).to_string(),
        false => json!({ "load": load }).to_string(),
    };
    let with = match &*variant.name {
        "" => String::new(),
        name => format!("with {name}: "),
    };
    let file = variant.file.display();
    Load::parse(&text, &places(&variant.graph))
        .map(drop)
        .map_err(|error| format!("{with}{file}: load: {}", error.reason).into())
}

/// Returns the numbers of robots that are tried if none are asked for.
fn default_robots(question: &Question, variants: &[Variant]) -> Robots {
    let mut most = None;
    if *question != Question::Knee {
        most = variants.iter().map(most_robots).max().flatten();
    }
    Robots::Range(1, most.unwrap_or(MOST_ROBOTS).min(MOST_ROBOTS))
}

/// Returns the managers of a study file that are programs.
fn programs(axes: &[Axis]) -> Vec<String> {
    let managers = axes.iter().filter(|axis| axis.setting == Setting::Manager);
    let commands = managers.flat_map(|axis| &axis.values).filter_map(Value::as_str);
    commands.filter(|command| *command != FLEET_MANAGER).map(str::to_owned).collect()
}

/// Returns the settings in the order in which they are applied: the layout first, which others
/// change.
fn checked(mut axes: Vec<Axis>) -> Result<Vec<Axis>, Failure> {
    axes.sort_by_key(|axis| axis.setting != Setting::Layout);
    for (index, Axis { setting, values }) in axes.iter().enumerate() {
        if axes[..index].iter().any(|other| other.setting == *setting) {
            return Err(
                format!("{setting} is varied twice: give all its values in one list").into()
            );
        }
        if *setting == Setting::Planner {
            for name in values.iter().filter_map(Value::as_str) {
                check_planner(name)?;
            }
        }
    }
    Ok(axes)
}

fn check_planner(name: &str) -> Result<(), Failure> {
    if PlannerKind::from_str(name, false).is_ok() {
        return Ok(());
    }
    let known: Vec<String> = PlannerKind::value_variants()
        .iter()
        .filter_map(ValueEnum::to_possible_value)
        .map(|value| value.get_name().to_owned())
        .collect();
    Err(format!("planner: unknown planner '{name}': there are {}", known.join(", ")).into())
}

/// Returns the name of a plant.
pub fn title(plant: &Path) -> String {
    let name = plant.file_name().unwrap_or_default().to_string_lossy();
    name.split('.').next().filter(|stem| !stem.is_empty()).unwrap_or("plant").to_owned()
}

fn secs(args: &StudyArgs, file: Option<&StudyFile>, day: Option<&Day>) -> Result<u64, Failure> {
    let of_file = file.and_then(|file| file.duration.as_ref());
    let secs = match (args.duration, of_file) {
        (Some(time), _) => time.0.as_secs(),
        (None, Some(value)) => {
            let time = plain(value).parse::<Time>();
            time.map_err(|error| format!("duration: {error}"))?.0.as_secs()
        }
        (None, None) => day.map_or(DEFAULT_SECS, limit_secs),
    };
    if RUN_SECS.contains(&secs) {
        Ok(secs)
    } else {
        Err("the duration of a run: give 2 minutes to 7 days".into())
    }
}

/// Returns the time at which a day ends at the latest: an hour after its last order, in whole
/// minutes.
fn limit_secs(day: &Day) -> u64 {
    (day.end_secs() + 3600).next_multiple_of(60)
}

/// Returns every combination of the axes' values, then those of a manager and the bound.
fn variants(
    base: Variant,
    axes: &[Axis],
    args: &StudyArgs,
    options: &ReadOptions,
) -> Result<Vec<Variant>, Failure> {
    let mut variants = vec![base];
    for Axis { setting, values } in axes {
        let mut combined = Vec::new();
        for variant in &variants {
            for value in values {
                let separator = if variant.name.is_empty() { "" } else { ", " };
                let name = format!("{}{separator}{}", variant.name, words(*setting, value, values));
                let with = variant.clone().with(*setting, value, options);
                let mut with = with.map_err(|error| error.with_name(&name))?;
                with.name = name;
                combined.push(with);
            }
        }
        variants = combined;
    }
    if let Some(command) = &args.manager {
        let mut own =
            variants[0].clone().with(Setting::Manager, &command.as_str().into(), options)?;
        own.name = name_of(command);
        name_first(&mut variants, "ours");
        variants.push(own);
    }
    if args.bound || args.manager.is_some() {
        let mut bound = variants[0].clone().bound();
        bound.name = match axes {
            [] => "bound".to_owned(),
            // The bounds of other values may be others.
            _ => format!("bound of {}", variants[0].name),
        };
        name_first(&mut variants, "as it is");
        variants.push(bound);
    }
    for variant in &variants {
        variant.check(args.rate)?;
    }
    for warning in left_out(&variants).into_iter().chain(warnings(&variants)) {
        regatta_plugin::tell!("{warning}");
    }
    Ok(variants)
}

/// Returns a warning for each part of a layout that takes no part, with the variant's name if it
/// takes part in another variant.
fn left_out(variants: &[Variant]) -> BTreeSet<String> {
    let mut warnings = BTreeSet::new();
    for Variant { name, file, left_out, .. } in variants {
        for part in left_out {
            let is_general = variants.iter().all(|other| other.left_out.contains(part));
            let with = if is_general { String::new() } else { format!(" with {name}") };
            warnings.insert(format!("{}: warning: left out{with}: {part}", file.display()));
        }
    }
    warnings
}

/// Returns the warnings about the layouts and scenarios of variants that the user wants, each once.
fn warnings(variants: &[Variant]) -> Vec<String> {
    let mut told = Vec::new();
    for line in variants.iter().flat_map(|variant| variant.warnings.told(wanted_warnings())) {
        if !told.contains(&line) {
            told.push(line);
        }
    }
    told
}

/// Names the first variant, unless it has a name.
fn name_first(variants: &mut [Variant], name: &str) {
    if variants[0].name.is_empty() {
        variants[0].name = name.to_owned();
    }
}

/// Returns a value as a text, without the quotation marks of JSON.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// The value of a setting in words, told from its other values.
fn words(setting: Setting, value: &Value, values: &[Value]) -> String {
    let value = plain(value);
    match setting {
        Setting::Layout => {
            let name = title(Path::new(&value));
            let same = values.iter().filter(|other| title(Path::new(&plain(other))) == name);
            if same.count() > 1 { value } else { name }
        }
        _ => format!("{} {value}", setting.name().replace('_', " ")),
    }
}

/// The last word of a command that isn't an option: the program, or the script that it runs.
fn name_of(command: &str) -> String {
    let words = command.split_whitespace().take_while(|word| !word.starts_with('-'));
    let word = words.last().unwrap_or(command);
    Path::new(word)
        .file_name()
        .map_or_else(|| word.to_owned(), |name| name.to_string_lossy().into_owned())
}
