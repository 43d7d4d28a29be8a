//! Storages: groups of places that are empty or full, of which an order gets one.
//!
//! ```yaml
//! load:
//!   storages:
//!     - name: rack
//!       at: {zone: rack}        # nodes, as in a generator's `from`; `R-*` is all such names
//!       full: 0.5               # share of the places that are full at the start; or nodes
//!       strategy: nearest       # or random, or zones
//!     - name: hall
//!       at: ["A*", "B*"]
//!       strategy: zones
//!       zones: [front, back]    # the zones of the layout that are used first, in this order
//! ```
//!
//! A drop at a storage takes an empty place, a pick a full one. All places of an order are chosen
//! at once, as soon as robots could have it: no robot ever stands somewhere with a load that has no
//! place. From then on they are reserved; they are full or empty when the robot has handled the
//! stop. An order for which there is no place waits, and holds none.

mod fill;

use regatta_base::yaml::{self, Fields, Node};
use regatta_plugin::world::Role;

pub(super) use self::fill::Storages;
pub use self::fill::{Lack, StorageFill};
use super::load::Groups;
use super::places::Places;

/// A group of places.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StorageSettings {
    pub(super) name: String,
    /// Its places, in the order of the text; at least one.
    places: Vec<StoragePlace>,
    full: InitialFill,
    strategy: Strategy,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct StoragePlace {
    /// Index in the world's nodes.
    node: u32,
    /// Places with a lower number are used first.
    rank: u32,
}

/// The places that are full at the start.
#[derive(Clone, Debug, PartialEq)]
enum InitialFill {
    /// This share, from 0 to 1, drawn by the seed of the load.
    Share(f64),
    /// These nodes.
    Nodes(Vec<u32>),
}

/// The choice among the places of the lowest rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::EnumString)]
#[strum(serialize_all = "lowercase")]
enum Strategy {
    /// The one nearest to the stop before a drop, or after a pick.
    Nearest,
    /// Any.
    Random,
    /// The nearest one in the first zone that has one.
    Zones,
}

impl StorageSettings {
    /// Its nodes.
    pub(super) fn nodes(&self) -> Vec<u32> {
        self.places.iter().map(|place| place.node).collect()
    }
}

/// Returns the places with storages, which orders may name.
pub(super) fn places(places: &Places, storages: &[StorageSettings]) -> Places {
    let named = storages.iter().map(|storage| (storage.name.clone(), storage.nodes()));
    places.with_storages(named.collect())
}

/// Reads the storages of a load.
pub(super) fn read(list: &Node, groups: &Groups<'_>) -> Result<Vec<StorageSettings>, yaml::Error> {
    let mut storages: Vec<StorageSettings> = Vec::new();
    for value in list.list()? {
        let storage = storage(value, groups)?;
        for other in &storages {
            if other.name == storage.name {
                return Err(value.error(format!("two storages have the name `{}`", other.name)));
            }
            let (ours, theirs) = (storage.nodes(), other.nodes());
            if let Some(node) = ours.iter().find(|node| theirs.contains(node)) {
                let (label, name) = (groups.places.label(*node), &other.name);
                return Err(value.error(format!(
                    "{label} is a place of this storage and of `{name}`: name it in one of them"
                )));
            }
        }
        storages.push(storage);
    }
    Ok(storages)
}

fn storage(value: &Node, groups: &Groups<'_>) -> Result<StorageSettings, yaml::Error> {
    let fields = value.fields(&["name", "at", "full", "strategy", "zones"])?;
    let name = name(fields.required("name")?, groups)?;
    let nodes = nodes(fields.required("at")?, groups)?;
    let full = match fields.get("full") {
        None => InitialFill::Share(0.0),
        Some(value) => initial_fill(value, &nodes, groups)?,
    };
    let strategy = strategy(value, &fields)?;
    let zones = fields.optional("zones", |list| zones(list, &nodes, groups))?.unwrap_or_default();
    let mut places = Vec::with_capacity(nodes.len());
    for node in nodes {
        let zone = &groups.places.place(node).zone;
        let rank = zones.iter().position(|name| name == zone).unwrap_or(zones.len()) as u32;
        places.push(StoragePlace { node, rank });
    }
    Ok(StorageSettings { name, places, full, strategy })
}

fn name(value: &Node, groups: &Groups<'_>) -> Result<String, yaml::Error> {
    let name = value.text()?.trim().to_owned();
    if name.is_empty() {
        return Err(value.error("the name of a storage is empty"));
    }
    if groups.has(&name) || groups.places.find(&name).is_some() {
        return Err(value.error(format!(
            "`{name}` is a group, a role or a node already: give the storage another name"
        )));
    }
    Ok(name)
}

/// Reads nodes: those of a generator's `from`, or all whose names have a pattern with `*`.
fn nodes(value: &Node, groups: &Groups<'_>) -> Result<Vec<u32>, yaml::Error> {
    let mut nodes = Vec::new();
    match value.list() {
        Ok(items) => {
            for item in items {
                nodes.extend(named(item, groups)?);
            }
        }
        Err(_) if value.is_map() => nodes = groups.find(Some(value), Role::None)?,
        Err(_) => nodes = named(value, groups)?,
    }
    let mut unique = Vec::with_capacity(nodes.len());
    let mut known = std::collections::BTreeSet::new();
    unique.extend(nodes.into_iter().filter(|node| known.insert(*node)));
    if unique.is_empty() {
        Err(value.error("a storage has at least one place"))
    } else {
        Ok(unique)
    }
}

fn named(value: &Node, groups: &Groups<'_>) -> Result<Vec<u32>, yaml::Error> {
    let text = value.text()?;
    if !text.contains('*') {
        return groups.find(Some(value), Role::None);
    }
    let nodes = groups.places.nodes_named(|name| matches(&text, name));
    if nodes.is_empty() {
        return Err(value.error(format!("no node has a name like `{text}`")));
    }
    Ok(nodes)
}

/// Whether a name has a pattern, in which each `*` stands for any text.
fn matches(pattern: &str, name: &str) -> bool {
    let Some((first, rest)) = pattern.split_once('*') else { return pattern == name };
    let Some(mut name) = name.strip_prefix(first) else { return false };
    let (middle, last) = rest.rsplit_once('*').unwrap_or(("", rest));
    for part in middle.split('*').filter(|part| !part.is_empty()) {
        let Some(at) = name.find(part) else { return false };
        name = &name[at + part.len()..];
    }
    name.ends_with(last)
}

fn initial_fill(
    value: &Node,
    nodes: &[u32],
    groups: &Groups<'_>,
) -> Result<InitialFill, yaml::Error> {
    let Ok(list) = value.list() else {
        return match value.non_negative()? {
            share if share <= 1.0 => Ok(InitialFill::Share(share)),
            share => Err(value.error(format!("{share}: give a share from 0 to 1, or nodes"))),
        };
    };
    let mut full = Vec::new();
    for item in list {
        for node in named(item, groups)? {
            if !nodes.contains(&node) {
                let label = groups.places.label(node);
                return Err(item.error(format!("{label} is no place of this storage")));
            }
            full.push(node);
        }
    }
    Ok(InitialFill::Nodes(full))
}

fn strategy(value: &Node, fields: &Fields<'_, '_>) -> Result<Strategy, yaml::Error> {
    let strategy = fields.optional("strategy", |value| {
        let name = value.text()?;
        name.parse().map_err(|_| {
            value.error(format!("unknown strategy `{name}`; use nearest, random or zones"))
        })
    })?;
    let strategy = strategy.unwrap_or(Strategy::Nearest);
    match (strategy, fields.get("zones").is_some()) {
        (Strategy::Zones, false) => {
            Err(value.error("give `zones`, in the order in which they are used"))
        }
        (Strategy::Nearest | Strategy::Random, true) => {
            Err(value.error("`zones` are those of the strategy zones: give `strategy: zones`, too"))
        }
        _ => Ok(strategy),
    }
}

fn zones(list: &Node, nodes: &[u32], groups: &Groups<'_>) -> Result<Vec<String>, yaml::Error> {
    let mut zones = Vec::new();
    for item in list.list()? {
        let zone = item.text()?.into_owned();
        if !nodes.iter().any(|node| groups.places.place(*node).zone == zone) {
            return Err(item.error(format!("no place of this storage is in the zone `{zone}`")));
        }
        zones.push(zone);
    }
    Ok(zones)
}

#[cfg(test)]
mod tests;
