//! Resolves the names in a scenario file and validates its values.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use regatta_layout::{Gear, Leg, Node, NodeIndex, Role, RouteGraph};

use super::battery::battery;
use super::suggest::did_you_mean;
use super::yaml::{
    Disturbances, LegName, NodeEntry, NodeKey, PluginCommand, PluginEntry, RobotGroupEntry,
    RobotTypeEntry, RoutesEntry, ScenarioFile,
};
use super::{
    MAX_ROBOTS, Overrides, Repeat, RobotCount, RobotGroup, RobotType, Scenario, ScenarioError,
    Shape, Source, Start,
};

/// The range of ticks per simulated second.
const RATES: RangeInclusive<f64> = 1.0..=20_000.0;
/// The range of a robot's length and width in metres: the collision checker's largest robot is as
/// long.
const SIZES: RangeInclusive<f32> = 0.001..=1000.0;
/// The range of a robot's largest speed in metres per second.
const SPEEDS: RangeInclusive<f32> = 0.001..=1000.0;
/// The range of a robot's largest acceleration in metres per second squared. With less, a robot
/// would need minutes to get going, and the engine would look thousands of edges ahead for places
/// to brake at.
const ACCELERATIONS: RangeInclusive<f32> = 0.001..=1e6;
/// Radians per second, and radians per second squared.
const ROTATIONS: RangeInclusive<f32> = 0.001..=1000.0;

/// Resolves the names in `file`, which was read from `source`, and checks its values. `warnings` are
/// those about the graph.
///
/// # Errors
/// If a value is invalid; the message names the entry.
pub(super) fn resolve(
    file: ScenarioFile,
    source: Source,
    mut graph: RouteGraph,
    mut warnings: Vec<String>,
    overrides: &Overrides,
) -> Result<Scenario, ScenarioError> {
    let rate = overrides.rate.unwrap_or(file.rate);
    let publish_rate = overrides.publish_rate.or(file.publish_rate).unwrap_or(rate);
    let (tick_period, ticks_per_frame) =
        clock(rate, publish_rate).map_err(|message| source.invalid("rate", message))?;
    let robot_types =
        robot_types(file.robot_types).map_err(|message| source.invalid("robot_types", message))?;
    override_nodes(file.nodes, &mut graph)
        .map_err(|(place, message)| source.invalid(&place, message))?;
    let groups = groups(file.robots, &graph, &robot_types)
        .map_err(|(place, message)| source.invalid(&place, message))?;
    check_disturbances(&file.disturbances)
        .map_err(|message| source.invalid("disturbances", message))?;
    let plugins = plugins(file.plugins, &source.path);
    check_names(&plugins)
        .and_then(|()| check_order(&plugins))
        .map_err(|message| source.invalid("plugins", message))?;

    let more_warnings =
        [uneven_rate(rate, publish_rate, ticks_per_frame), dead_end(&groups, &graph)];
    warnings.extend(
        more_warnings
            .into_iter()
            .flatten()
            .map(|message| format!("{}: {message}", source.path.display())),
    );

    Ok(Scenario {
        graph: Arc::new(graph),
        tick_period,
        ticks_per_frame,
        seed: overrides.seed.unwrap_or(file.seed),
        robot_types,
        groups,
        disturbances: file.disturbances,
        plugins,
        viewer: file.viewer,
        source,
        warnings,
        is_made_up: false,
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

/// Returns a warning if frames can't be published at exactly `publish_rate`.
fn uneven_rate(rate: f64, publish_rate: f64, ticks_per_frame: u32) -> Option<String> {
    let exact_rate = rate / f64::from(ticks_per_frame);
    ((publish_rate - exact_rate).abs() > 1e-6 * publish_rate).then(|| {
        format!(
            "publish_rate {publish_rate} doesn't divide the rate of {rate}: {exact_rate:.3} frames per second are \
             published"
        )
    })
}

fn robot_types(entries: Vec<RobotTypeEntry>) -> Result<Vec<RobotType>, String> {
    let mut robot_types = entries.into_iter().map(robot_type).collect::<Result<Vec<_>, _>>()?;
    let names: BTreeSet<_> = robot_types.iter().map(|robot_type| &robot_type.name).collect();
    if names.len() < robot_types.len() || robot_types.len() > usize::from(u16::MAX) {
        return Err(format!("give each robot type a unique name, and list at most {}", u16::MAX));
    }
    if robot_types.is_empty() {
        robot_types.push(default_robot_type());
    }
    Ok(robot_types)
}

/// Gives nodes the roles and names of the scenario. On an error, returns the invalid entry and the
/// message.
fn override_nodes(
    entries: BTreeMap<NodeKey, NodeEntry>,
    graph: &mut RouteGraph,
) -> Result<(), (String, String)> {
    for (NodeKey(key), NodeEntry { role, name }) in entries {
        let invalid = |message| (format!("nodes, {key}"), message);
        let node = node_by_key(&key, graph).map_err(invalid)?;
        let role = role
            .map(|role| role.parse::<Role>())
            .transpose()
            .map_err(|error| invalid(error.to_string()))?;
        graph.override_node(node, role, name.as_deref());
    }
    Ok(())
}

/// Returns the node with an id or, if there is none, with a name.
fn node_by_key(key: &str, graph: &RouteGraph) -> Result<NodeIndex, String> {
    if let Some(node) = key.parse().ok().and_then(|id| graph.node_by_id(id)) {
        return Ok(node);
    }
    let mut named =
        (0..).map(NodeIndex).zip(graph.nodes()).filter(|(_, node)| node.name() == Some(key));
    match (named.next(), named.next()) {
        (Some((node, _)), None) => Ok(node),
        (Some(_), Some(_)) => Err(format!("several nodes are called '{key}'; give the id of one")),
        (None, _) => {
            let names = graph.nodes().iter().filter_map(Node::name);
            Err(format!("the graph has no node with this id or name{}", did_you_mean(key, names)))
        }
    }
}

/// Returns the groups of robots, or the invalid entry and the error message.
fn groups(
    entries: Vec<RobotGroupEntry>,
    graph: &RouteGraph,
    robot_types: &[RobotType],
) -> Result<Vec<RobotGroup>, (String, String)> {
    let mut groups = Vec::with_capacity(entries.len());
    for (number, entry) in (1..).zip(entries) {
        let group = group(entry, graph, robot_types);
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

/// Returns a warning if robots on random walks will stop at a dead end.
fn dead_end(groups: &[RobotGroup], graph: &RouteGraph) -> Option<String> {
    groups.iter().find(|group| matches!(group.start, Start::Random))?;
    // Random walks drive forwards only, so that a leg in reverse gear doesn't leave a dead end.
    let is_dead_end = |node| !graph.departures(node).iter().any(|leg| leg.gear == Gear::Forward);
    let (_, node) =
        (0..).map(NodeIndex).zip(graph.nodes()).find(|(index, _)| is_dead_end(*index))?;
    Some(format!(
        "robots on random walks will stop at dead ends such as node {}: add an edge that leaves it, or give the robots routes",
        node.id
    ))
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
    let bad = |(name, value, range): (&str, Option<f64>, RangeInclusive<f64>)| {
        let value = value.filter(|value| !range.contains(value))?;
        Some(format!("{name} is {value}; give {} to {}", range.start(), range.end()))
    };
    values.into_iter().find_map(bad).map_or(Ok(()), Err)
}

/// Returns the robot type of scenarios that list none.
fn default_robot_type() -> RobotType {
    RobotType {
        name: "amr".into(),
        shape: Shape::Rectangle,
        length: 0.9,
        width: 0.6,
        max_speed: f32::INFINITY,
        max_acceleration: f32::INFINITY,
        max_rotation_speed: 0.0,
        max_rotation_acceleration: f32::INFINITY,
        battery: None,
    }
}

fn robot_type(entry: RobotTypeEntry) -> Result<RobotType, String> {
    let in_range = |name: &str, unit: &str, value: f32, range: &RangeInclusive<f32>| {
        let (least, most) = (range.start(), range.end());
        let advice = || format!("{}: {name} is {value}; give {least} to {most} {unit}", entry.name);
        if range.contains(&value) { Ok(value) } else { Err(advice()) }
    };
    let limit = |name: &str, unit: &str, value: Option<f32>, range: &RangeInclusive<f32>| {
        value.map_or(Ok(f32::INFINITY), |value| in_range(name, unit, value, range))
    };
    let max_speed = limit("max_speed", "m/s", entry.max_speed, &SPEEDS)?;
    let max_acceleration =
        limit("max_acceleration", "m/s²", entry.max_acceleration, &ACCELERATIONS)?;
    let max_rotation_speed = match entry.max_rotation_speed {
        None => 0.0,
        Some(value) => in_range("max_rotation_speed", "rad/s", value, &ROTATIONS)?,
    };
    let max_rotation_acceleration =
        limit("max_rotation_acceleration", "rad/s²", entry.max_rotation_acceleration, &ROTATIONS)?;
    let length = in_range("length", "m", entry.length, &SIZES)?;
    let width = entry.width.map(|width| in_range("width", "m", width, &SIZES)).transpose()?;
    let (shape, width) = match (entry.shape, width) {
        (Shape::Rectangle, Some(width)) => (Shape::Rectangle, width),
        (Shape::Rectangle, None) => {
            return Err(format!("{}: width is missing (only a circle has none)", entry.name));
        }
        (Shape::Circle, None) => (Shape::Circle, length),
        (Shape::Circle, Some(width)) if width == length => (Shape::Circle, length),
        (Shape::Circle, Some(_)) => {
            return Err(format!(
                "{}: the length of a circle is its diameter; leave width out",
                entry.name
            ));
        }
    };
    let battery = entry
        .battery
        .map(battery)
        .transpose()
        .map_err(|message| format!("{}: {message}", entry.name))?;
    Ok(RobotType {
        name: entry.name,
        shape,
        length,
        width,
        max_speed,
        max_acceleration,
        max_rotation_speed,
        max_rotation_acceleration,
        battery,
    })
}

fn group(
    entry: RobotGroupEntry,
    graph: &RouteGraph,
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
    let start = match (&entry.route, entry.routes, entry.node) {
        (Some(route), None, None) => {
            route_start(route, entry.repeat.unwrap_or(Repeat::Once), graph)?
        }
        (None, Some(RoutesEntry::Random), None) => Start::Random,
        (None, Some(RoutesEntry::None), None) => Start::Standing,
        (None, None, Some(id)) => {
            Start::Node(graph.node_by_id(id).ok_or_else(|| format!("the graph has no node {id}"))?)
        }
        _ => {
            return Err(
                "give one of: route (a list of edges), routes: random or none, node (an id)".into(),
            );
        }
    };
    Ok(RobotGroup { count, robot_type: robot_type as u16, start })
}

fn route_start(route: &[LegName], repeat: Repeat, graph: &RouteGraph) -> Result<Start, String> {
    let legs = route.iter().map(|&name| leg(name, graph)).collect::<Result<Vec<_>, _>>()?;
    let (Some(&first), Some(&last)) = (legs.first(), legs.last()) else {
        return Err("route is empty; list at least one edge".into());
    };
    for (names, pair) in route.windows(2).zip(legs.windows(2)) {
        let (end, start) = (graph.leg_end(pair[0]), graph.leg_start(pair[1]));
        if end != start {
            let (end, start) = (graph.node(end).id, graph.node(start).id);
            return Err(format!(
                "edge {} ends at node {end}, but edge {} starts at node {start}",
                names[0], names[1]
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

fn leg(name: LegName, graph: &RouteGraph) -> Result<Leg, String> {
    let edge = graph
        .edge_by_id(name.edge_id)
        .ok_or_else(|| format!("the graph has no edge {}", name.edge_id))?;
    let gear = if name.reverse { Gear::Reverse } else { Gear::Forward };
    let leg = Leg { edge, gear };
    match graph.leg_speed(leg) {
        Some(_) => Ok(leg),
        None => Err(format!(
            "edge {} can't be driven in reverse gear: its VelocityBackwards is 0",
            name.edge_id
        )),
    }
}

/// Returns the plugins' command lines. Programs with a slash in their name are resolved relative to
/// the scenario's folder, as a shell in that folder would.
fn plugins(entries: Vec<PluginEntry>, path: &Path) -> Vec<PluginCommand> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let plugin = |entry| match entry {
        PluginEntry::Name(name) => {
            PluginCommand { name, command: vec![], args: vec![], after: vec![] }
        }
        PluginEntry::Detailed(mut plugin) => {
            if let Some(program) =
                plugin.command.first_mut().filter(|program| program.contains('/'))
            {
                *program = folder.join(&*program).to_string_lossy().into_owned();
            }
            plugin
        }
    };
    entries.into_iter().map(plugin).collect()
}

/// Checks the names of plugins: each is part of a name in shared memory, as that of a fleet is.
fn check_names(plugins: &[PluginCommand]) -> Result<(), String> {
    for (number, plugin) in (1..).zip(plugins) {
        check_name(&plugin.name).map_err(|message| format!("entry {number}: {message}"))?;
    }
    Ok(())
}

/// The longest name of a plugin, in bytes.
const MAX_NAME_BYTES: usize = 64;

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
            "{character:?} in the name {name:?} is not allowed; use letters (a-z, A-Z), digits, '-', '_' and '.'"
        )),
        None => Ok(()),
    }
}

/// Checks that plugins come after plugins of the scenario, and that their order has no cycle.
fn check_order(plugins: &[PluginCommand]) -> Result<(), String> {
    for plugin in plugins {
        if let Some(unknown) =
            plugin.after.iter().find(|name| plugins.iter().all(|other| other.name != **name))
        {
            let others =
                plugins.iter().map(|other| other.name.as_str()).filter(|name| *name != plugin.name);
            let suggestion = did_you_mean(unknown, others);
            return Err(format!(
                "{} comes after {unknown}, which is not among the plugins: add it{suggestion}",
                plugin.name
            ));
        }
    }
    // Remove those whose predecessors are gone; what can't be removed waits for itself.
    let mut left: Vec<_> = plugins.iter().collect();
    loop {
        let waits =
            |plugin: &&PluginCommand| left.iter().any(|other| plugin.after.contains(&other.name));
        let still: Vec<_> = left.iter().copied().filter(waits).collect();
        match still.len() {
            0 => return Ok(()),
            len if len == left.len() => {
                let names: Vec<_> = still.iter().map(|plugin| plugin.name.as_str()).collect();
                return Err(format!(
                    "{} come after each other: remove one `after` of the cycle",
                    names.join(" and ")
                ));
            }
            _ => left = still,
        }
    }
}
