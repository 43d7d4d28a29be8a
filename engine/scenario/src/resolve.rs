//! Resolves the names in a scenario file and validates its values.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use regatta_layout::model::components::Components;
use regatta_layout::{NodeIndex, Role, RouteGraph};

use super::explain::did_you_mean;
use super::facilities::{lacking_places, override_facilities};
use super::names::Names;
use super::places;
use super::robot_type::robot_types;
use super::yaml::{
    Disturbances, Key, LegKey, NodeEntry, PluginCommand, PluginEntry, RobotGroupEntry, RoutesEntry,
    ScenarioFile,
};
use super::{
    MAX_ROBOTS, Overrides, Repeat, RobotCount, RobotGroup, RobotType, Scenario, ScenarioError,
    Source, Start, Warnings,
};

/// The range of ticks per simulated second.
const RATES: RangeInclusive<f64> = 1.0..=20_000.0;

/// The longest warm-up, in simulated seconds.
const MAX_WARM_UP_SECS: f64 = 86_400.0;

/// Resolves the names in `file`, which was read from `source`, and checks its values. Warnings
/// about the graph are left out.
///
/// # Errors
/// If a value is invalid; the message names the entry.
pub(super) fn resolve(
    file: ScenarioFile,
    source: Source,
    mut graph: RouteGraph,
    overrides: &Overrides,
) -> Result<Scenario, ScenarioError> {
    let rate = overrides.rate.unwrap_or(file.rate);
    let publish_rate = overrides.publish_rate.or(file.publish_rate).unwrap_or(rate);
    let (tick_period, ticks_per_frame) =
        clock(rate, publish_rate).map_err(|message| source.invalid("rate", message))?;
    let warm_up = warm_up(file.warm_up).map_err(|message| source.invalid("warm_up", message))?;
    let robot_types =
        robot_types(file.robot_types).map_err(|message| source.invalid("robot_types", message))?;
    override_nodes(file.nodes, &mut graph)
        .map_err(|(place, message)| source.invalid(&place, message))?;
    // The warnings of the layout have those of its own capacities.
    let lacking_before = lacking_places(&graph);
    let graph = override_facilities(file.doors, file.lifts, graph)
        .map_err(|(place, message)| source.invalid(&place, message))?;
    let groups = groups(file.robots, &graph, &robot_types)
        .map_err(|(place, message)| source.invalid(&place, message))?;
    check_disturbances(&file.disturbances)
        .map_err(|message| source.invalid("disturbances", message))?;
    let plugins = plugins(file.plugins, &source.path);
    check_plugins(&plugins).map_err(|message| source.invalid("plugins", message))?;

    let warnings = [
        uneven_rate(rate, publish_rate, ticks_per_frame),
        places::no_way_out(&groups, &graph),
        places::cut_off(&groups, &graph),
        larger_unused_type(&groups, &robot_types),
        no_charger(&groups, &robot_types, &graph),
    ];
    let of_scenario = warnings
        .into_iter()
        .flatten()
        .chain(lacking_places(&graph).difference(&lacking_before).cloned())
        .map(|message| format!("{}: warning: {message}", source.path.display()))
        .collect();

    Ok(Scenario {
        graph: Arc::new(graph),
        tick_period,
        ticks_per_frame,
        seed: overrides.seed.unwrap_or(file.seed),
        warm_up,
        robot_types,
        groups,
        disturbances: file.disturbances,
        plugins,
        viewer: file.viewer,
        source,
        warnings: Warnings { of_scenario, ..Warnings::default() },
        assumptions: Vec::new(),
        is_default: false,
    })
}

/// Returns the tick period and the number of ticks per frame.
fn clock(rate: f64, publish_rate: f64) -> Result<(Duration, u32), String> {
    if !RATES.contains(&rate) {
        return Err(format!("{rate} ticks per second is out of range: give 1 to 20000"));
    }
    let ticks_per_frame = (rate / publish_rate).round();
    if !(publish_rate > 0.0 && publish_rate <= rate && (1.0..=1e6).contains(&ticks_per_frame)) {
        return Err(format!(
            "publish_rate {publish_rate} must be above 0 and not above the rate of {rate}"
        ));
    }
    Ok((Duration::from_nanos((1e9 / rate).round() as u64), ticks_per_frame as u32))
}

/// Returns the time of a warm-up in seconds.
fn warm_up(secs: f64) -> Result<Duration, String> {
    if !(0.0..=MAX_WARM_UP_SECS).contains(&secs) {
        return Err(format!("{secs} s is out of range: give 0 to {MAX_WARM_UP_SECS} s"));
    }
    Ok(Duration::from_secs_f64(secs))
}

/// Returns a warning if frames can't be published at exactly `publish_rate`.
fn uneven_rate(rate: f64, publish_rate: f64, ticks_per_frame: u32) -> Option<String> {
    let exact_rate = rate / f64::from(ticks_per_frame);
    ((publish_rate - exact_rate).abs() > 1e-6 * publish_rate).then(|| {
        format!(
            "publish_rate {publish_rate} doesn't divide the rate of {rate}: {exact_rate:.3} frames \
             per second are published"
        )
    })
}

/// Returns a warning if robots have batteries, and the layout has no charger for them.
fn no_charger(
    groups: &[RobotGroup],
    robot_types: &[RobotType],
    graph: &RouteGraph,
) -> Option<String> {
    let mut used = groups.iter().map(|group| &robot_types[usize::from(group.robot_type)]);
    let kind = used.find(|kind| kind.battery.is_some())?;
    let components = Components::strong(graph);
    let main = components.main(graph);
    let mut nodes = graph.purposes().into_iter().zip(&components.of_node);
    let has_charger = nodes.any(|(role, part)| role == Role::Charge && *part == main);
    (!has_charger).then(|| {
        format!(
            "robots of the type `{}` have batteries, and no charger is in the main part \
             of the layout: they stop when they are flat; give nodes the role `charge`",
            kind.name
        )
    })
}

/// Returns a warning if a robot type that no robot has is larger than those of the robots.
fn larger_unused_type(groups: &[RobotGroup], robot_types: &[RobotType]) -> Option<String> {
    let used: BTreeSet<u16> = groups.iter().map(|group| group.robot_type).collect();
    let largest = |size: fn(&RobotType) -> f32| {
        used.iter().map(|index| size(&robot_types[usize::from(*index)])).fold(0.0, f32::max)
    };
    let (length, width) = (largest(|kind| kind.length), largest(|kind| kind.width));
    let is_larger = |kind: &RobotType| kind.length > length || kind.width > width;
    let mut unused = (0..).zip(robot_types).filter(|(index, _)| !used.contains(index));
    let (_, kind) = unused.find(|(_, kind)| !used.is_empty() && is_larger(kind))?;
    Some(format!(
        "no robot has the type `{}`, and a fleet manager keeps room for the largest type: \
         remove it, unless robots of it are added later",
        kind.name
    ))
}

/// Gives nodes the roles and names of the scenario. On an error, returns the invalid entry and the
/// message.
fn override_nodes(
    entries: BTreeMap<Key, NodeEntry>,
    graph: &mut RouteGraph,
) -> Result<(), (String, String)> {
    let names = Names::new(graph);
    let mut changes = Vec::with_capacity(entries.len());
    for (key, entry) in entries {
        let change = change(&names, &key, entry);
        changes.push(change.map_err(|message| (format!("nodes, {key}"), message))?);
    }
    for (node, role, name) in changes {
        graph.override_node(node, role, name.as_deref());
    }
    Ok(())
}

/// Returns a node with its role and its name, if they change.
fn change(
    names: &Names<'_>,
    key: &Key,
    NodeEntry { role, name }: NodeEntry,
) -> Result<(NodeIndex, Option<Role>, Option<String>), String> {
    let node = names.node(key)?;
    let role = role.as_deref().map(str::parse::<Role>).transpose();
    Ok((node, role.map_err(|error| error.to_string())?, name))
}

/// Returns the groups of robots, or the invalid entry and the error message.
fn groups(
    entries: Vec<RobotGroupEntry>,
    graph: &RouteGraph,
    robot_types: &[RobotType],
) -> Result<Vec<RobotGroup>, (String, String)> {
    let mut groups = Vec::with_capacity(entries.len());
    let names = Names::new(graph);
    for (number, entry) in (1..).zip(entries) {
        let group = group(entry, graph, &names, robot_types);
        groups.push(group.map_err(|message| (format!("robots, entry {number}"), message))?);
    }
    let robots: u64 = groups.iter().map(|group: &RobotGroup| u64::from(group.count)).sum();
    if robots == 0 || robots > u64::from(MAX_ROBOTS) {
        return Err((
            "robots".into(),
            format!("{robots} robots; give at least one and at most {MAX_ROBOTS}"),
        ));
    }
    Ok(groups)
}

fn check_disturbances(disturbances: &Disturbances) -> Result<(), String> {
    let Disturbances { stalls, breakdowns, speed_variation } = disturbances;
    let repair_secs = breakdowns.and_then(|breakdowns| breakdowns.repair_secs);
    let values = [
        ("stalls, per_hour", stalls.map(|stalls| stalls.per_hour), 1e-6..=36_000.0),
        ("stalls, mean_secs", stalls.map(|stalls| stalls.mean_secs), 0.001..=1e6),
        ("stalls, share", stalls.map(|stalls| stalls.share), 0.0..=1.0),
        ("breakdowns, per_hour", breakdowns.map(|breakdowns| breakdowns.per_hour), 1e-6..=36_000.0),
        ("breakdowns, repair_secs", repair_secs, 0.001..=1e9),
        ("speed_variation", Some(f64::from(*speed_variation)), 0.0..=0.9),
    ];
    for (name, value, range) in values {
        if let Some(value) = value.filter(|value| !range.contains(value)) {
            return Err(format!("{name} is {value}; give {} to {}", range.start(), range.end()));
        }
    }
    Ok(())
}

fn group(
    entry: RobotGroupEntry,
    graph: &RouteGraph,
    names: &Names<'_>,
    robot_types: &[RobotType],
) -> Result<RobotGroup, String> {
    let robot_type = match &entry.robot_type {
        None => 0,
        Some(name) => {
            robot_types.iter().position(|robot_type| robot_type.name == *name).ok_or_else(|| {
                let names = robot_types.iter().map(|robot_type| robot_type.name.as_str());
                format!(
                    "no robot type is called '{name}'; list it under robot_types{}",
                    did_you_mean(name, names)
                )
            })?
        }
    };
    let RobotCount(count) = entry.count;
    if count == 0 {
        return Err("count is 0; remove the entry".into());
    }
    let start = match (&entry.route, entry.routes, &entry.node) {
        (Some(route), None, None) => {
            route_start(route, entry.repeat.unwrap_or(Repeat::Once), graph, names)?
        }
        (None, Some(RoutesEntry::Random), None) => Start::Random,
        (None, Some(RoutesEntry::None), None) => Start::Standing,
        (None, None, Some(node)) => Start::Node(names.node(node)?),
        _ => {
            return Err(
                "give one of: route (a list of edges), routes: random or none, node (an id or a \
                 name)"
                    .into(),
            );
        }
    };
    Ok(RobotGroup { count, robot_type: robot_type as u16, start })
}

fn route_start(
    route: &[LegKey],
    repeat: Repeat,
    graph: &RouteGraph,
    names: &Names<'_>,
) -> Result<Start, String> {
    let legs = route.iter().map(|key| names.leg(key)).collect::<Result<Vec<_>, _>>()?;
    let (Some(&first), Some(&last)) = (legs.first(), legs.last()) else {
        return Err("route is empty; list at least one edge".into());
    };
    for (keys, pair) in route.windows(2).zip(legs.windows(2)) {
        let (end, start) = (graph.leg_end(pair[0]), graph.leg_start(pair[1]));
        if end != start {
            let (end, start) = (graph.node(end).id, graph.node(start).id);
            return Err(format!(
                "edge {} ends at node {end}, but edge {} starts at node {start}",
                keys[0], keys[1]
            ));
        }
    }
    let repeat = match repeat {
        Repeat::Once => Repeat::Once,
        Repeat::Loop if graph.leg_end(last) == graph.leg_start(first) => Repeat::Loop,
        Repeat::Loop => {
            let (end, start) =
                (graph.node(graph.leg_end(last)).id, graph.node(graph.leg_start(first)).id);
            return Err(format!(
                "repeat: loop, but the route ends at node {end} and starts at node {start}"
            ));
        }
    };
    Ok(Start::Route { legs: legs.into(), repeat })
}

/// Returns the plugins' command lines. Programs with a slash in their name are resolved relative to
/// the scenario's folder, as a shell in that folder would.
fn plugins(entries: Vec<PluginEntry>, path: &Path) -> Vec<PluginCommand> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut plugins = Vec::with_capacity(entries.len());
    for entry in entries {
        let mut plugin = match entry {
            PluginEntry::Name(name) => PluginCommand { name, ..PluginCommand::default() },
            PluginEntry::Detailed(plugin) => plugin,
        };
        match plugin.command.first_mut() {
            Some(program) if program.contains('/') => {
                *program = folder.join(&*program).to_string_lossy().into_owned();
            }
            _ => {}
        }
        plugins.push(plugin);
    }
    plugins
}

/// The longest name of a plugin, in bytes.
const MAX_NAME_BYTES: usize = 64;

/// Checks the name of a plugin. It becomes part of the names of services, so that the rule is that
/// of the contract's names.
fn check_name(name: &str) -> Result<(), String> {
    if name.is_empty() {
        return Err(format!(
            "a name can't be empty; give it 1 to {MAX_NAME_BYTES} letters, digits, '-', '_' or '.'"
        ));
    }
    if name.len() > MAX_NAME_BYTES {
        let bytes = name.len();
        return Err(format!(
            "the name is {bytes} bytes long; at most {MAX_NAME_BYTES} are allowed"
        ));
    }
    match name.chars().find(|c| !c.is_ascii_alphanumeric() && !"-_.".contains(*c)) {
        Some(character) => Err(format!(
            "{character:?} in the name {name:?} is not allowed; use letters (a-z, A-Z), digits, \
             '-', '_' and '.'"
        )),
        None => Ok(()),
    }
}

/// The most plugins of a scenario, which are compared with each other. A fleet has less room.
const MOST_PLUGINS: usize = 100;

/// Checks the number and the names of plugins, that they come after plugins of the scenario, and
/// that their order has no cycle.
fn check_plugins(plugins: &[PluginCommand]) -> Result<(), String> {
    let counts = plugins.iter().map(|plugin| plugin.after.len());
    if counts.chain([plugins.len()]).any(|count| count > MOST_PLUGINS) {
        return Err(format!("more than {MOST_PLUGINS} names of plugins: remove some"));
    }
    for (number, plugin) in (1..).zip(plugins) {
        check_name(&plugin.name).map_err(|message| format!("entry {number}: {message}"))?;
    }
    for plugin in plugins {
        for name in &plugin.after {
            if plugins.iter().any(|other| other.name == *name) {
                continue;
            }
            let names = plugins.iter().map(|other| other.name.as_str());
            let suggestion = did_you_mean(name, names.filter(|other| *other != plugin.name));
            return Err(format!(
                "{} comes after {name}, which is not among the plugins: add it{suggestion}",
                plugin.name
            ));
        }
    }
    check_order(plugins)
}

/// Checks that the order of plugins has no cycle.
fn check_order(plugins: &[PluginCommand]) -> Result<(), String> {
    // Remove those whose predecessors are gone; those that can't be removed form a cycle.
    let mut left: Vec<_> = plugins.iter().collect();
    while !left.is_empty() {
        let mut waiting = left.clone();
        waiting.retain(|plugin| left.iter().any(|other| plugin.after.contains(&other.name)));
        if waiting.len() == left.len() {
            let names: Vec<_> = waiting.iter().map(|plugin| plugin.name.as_str()).collect();
            return Err(format!(
                "{} come after each other: remove one `after` of the cycle",
                names.join(" and ")
            ));
        }
        left = waiting;
    }
    Ok(())
}
