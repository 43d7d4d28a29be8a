//! The times of doors and lifts that a scenario gives instead of those of its graph.

use std::collections::{BTreeMap, BTreeSet};

use regatta_layout::model::facilities::MAX_FACILITY_SECS;
use regatta_layout::{Door, DoorTimes, Lift, RouteGraph};

use super::explain::did_you_mean;
use super::yaml::{DoorEntry, Key, LiftEntry};

/// Gives doors and lifts the times and capacities of a scenario. On an error, returns the invalid
/// entry and the message.
pub(super) fn override_facilities(
    doors: BTreeMap<Key, DoorEntry>,
    lifts: BTreeMap<Key, LiftEntry>,
    graph: RouteGraph,
) -> Result<RouteGraph, (String, String)> {
    if doors.is_empty() && lifts.is_empty() {
        return Ok(graph);
    }
    let (mut changed_doors, mut changed_lifts) = (graph.doors().to_vec(), graph.lifts().to_vec());
    for (key, entry) in doors {
        let changed = find(&mut changed_doors, "door", &key, |door| &door.name)
            .and_then(|door| change_door(door, entry));
        changed.map_err(|message| (format!("doors, {key}"), message))?;
    }
    for (key, entry) in lifts {
        let changed = find(&mut changed_lifts, "lift", &key, |lift| &lift.name)
            .and_then(|lift| change_lift(lift, entry));
        changed.map_err(|message| (format!("lifts, {key}"), message))?;
    }
    Ok(graph.with_facilities(changed_doors, changed_lifts))
}

/// Returns a warning for each lift that lacks nodes for its capacity, as a scenario or a file has
/// it.
pub(super) fn lacking_places(graph: &RouteGraph) -> BTreeSet<String> {
    let lacking = graph
        .lifts()
        .iter()
        .filter_map(|lift| Some(format!("lifts, {}: it {}", lift.name, lift.lack_of_places()?)));
    lacking.collect()
}

/// Returns the door or the lift with a name.
fn find<'list, T>(
    list: &'list mut [T],
    kind: &str,
    key: &Key,
    name: fn(&T) -> &str,
) -> Result<&'list mut T, String> {
    let wanted = key.to_string();
    match list.iter().position(|item| name(item) == wanted) {
        Some(index) => Ok(&mut list[index]),
        None => {
            let hint = did_you_mean(&wanted, list.iter().map(name));
            Err(format!("the layout has no {kind} of that name{hint}"))
        }
    }
}

fn change_door(door: &mut Door, entry: DoorEntry) -> Result<(), String> {
    change_times(&mut door.times, entry.opening_secs, entry.closing_secs)
}

fn change_lift(lift: &mut Lift, entry: LiftEntry) -> Result<(), String> {
    change_times(&mut lift.door_times, entry.opening_secs, entry.closing_secs)?;
    if let Some(secs) = entry.level_secs {
        if secs <= 0.0 {
            return Err(format!("level_secs is {secs}; give more than 0"));
        }
        lift.level_secs = checked("level_secs", secs)?;
    }
    lift.capacity = entry.capacity.unwrap_or(lift.capacity);
    if let Some(home) = entry.home {
        let levels = || lift.levels.iter().map(|level| &*level.name);
        let found = levels().position(|level| level == home);
        let hint = did_you_mean(&home, levels());
        lift.home =
            found.ok_or_else(|| format!("home is '{home}', which it doesn't serve{hint}"))?;
    }
    Ok(())
}

fn change_times(
    times: &mut DoorTimes,
    opening_secs: Option<f64>,
    closing_secs: Option<f64>,
) -> Result<(), String> {
    if let Some(secs) = opening_secs {
        times.opening_secs = checked("opening_secs", secs)?;
    }
    if let Some(secs) = closing_secs {
        times.closing_secs = checked("closing_secs", secs)?;
    }
    Ok(())
}

fn checked(key: &str, secs: f64) -> Result<f64, String> {
    match (0.0..=MAX_FACILITY_SECS).contains(&secs) {
        true => Ok(secs),
        false => Err(format!("{key} is {secs}; give 0 to {MAX_FACILITY_SECS}")),
    }
}
