//! The places that a load names, and changes of its stations.

use std::collections::BTreeSet;

use regatta_layout::{NodeIndex, Role, RouteGraph};
use serde_json::{Map, Value, json};

use super::{FASTER, Remedy};
use crate::plan::Load;

/// The keys of a generator with places.
const PLACES: [&str; 5] = ["from", "to", "among", "at", "via"];

/// The words by which a load names a node.
pub struct Labels {
    /// Its id, its names.
    own: BTreeSet<String>,
    /// Its role, its zone, and the groups that it is in.
    of_groups: BTreeSet<String>,
}

impl Labels {
    /// Returns the words for a node.
    pub fn of(load: &Load, graph: &RouteGraph, node: NodeIndex) -> Self {
        let (place, role) = (graph.node(node), graph.purposes()[node.0 as usize]);
        let mut own = BTreeSet::from([place.id.to_string()]);
        own.extend(place.name().map(str::to_owned));
        own.extend(place.other_names());
        let mut of_groups = BTreeSet::new();
        for (is_role, name) in [(role.is_pick(), Role::Pick), (role.is_drop(), Role::Drop)] {
            if is_role {
                of_groups.insert(<&str>::from(name).to_owned());
            }
        }
        of_groups.insert(<&str>::from(role).to_owned());
        let zone = place.tags.as_ref().and_then(|tags| tags.zone.as_deref());
        of_groups.extend(zone.map(str::to_owned));
        if let Some(Value::Object(groups)) = load.rest.get("groups") {
            let named = groups.iter().filter(|(_, nodes)| names(nodes, &own));
            of_groups.extend(named.map(|(name, _)| name.clone()));
        }
        Self { own, of_groups }
    }

    /// Whether some places of a load contain the node.
    fn are_in(&self, places: &Value) -> bool {
        names(places, &self.own) || names(places, &self.of_groups)
    }
}

/// Whether a text or a list contains one of some words.
fn names(places: &Value, words: &BTreeSet<String>) -> bool {
    match places {
        Value::Array(places) => places.iter().any(|place| words.contains(&label(place))),
        place => words.contains(&label(place)),
    }
}

fn label(place: &Value) -> String {
    place.as_str().map_or_else(|| place.to_string(), str::to_owned)
}

/// The description of a station in a load.
#[derive(Clone, Copy, Debug)]
pub struct StationEntry<'a> {
    index: usize,
    entry: &'a Map<String, Value>,
}

impl StationEntry<'_> {
    /// The number of the entry.
    pub fn index(&self) -> usize {
        self.index
    }

    /// The number of operators, if it is given.
    pub fn operators(&self) -> Option<u64> {
        self.entry.get("operators")?.as_u64()
    }

    /// The seconds in which a load is taken out of its buffer, if they are a number.
    pub fn cycle(&self) -> Option<f64> {
        self.entry.get("buffer")?.get("cycle")?.as_f64()
    }

    /// Whether it has a queue.
    pub fn has_queue(&self) -> bool {
        self.entry.contains_key("queue")
    }
}

/// Returns the entry that describes the station at a node.
pub fn entry<'a>(load: &'a Load, labels: &Labels) -> Option<StationEntry<'a>> {
    let entries = load.rest.get("stations")?.as_array()?;
    let mut entries = entries.iter().enumerate();
    entries.find_map(|(index, entry)| {
        let entry = entry.as_object()?;
        labels.are_in(entry.get("at")?).then_some(StationEntry { index, entry })
    })
}

/// Changes the entry of a station as a remedy says; `None` if it can't.
pub fn change(load: &mut Load, index: usize, remedy: &Remedy) -> Option<()> {
    let entry = load.rest.get_mut("stations")?.get_mut(index)?;
    match remedy {
        Remedy::Operator(_) => {
            let more = entry.get("operators")?.as_u64()? + 1;
            *entry.get_mut("operators")? = more.into();
        }
        Remedy::Buffer(_) => {
            let cycle = entry.get_mut("buffer")?.get_mut("cycle")?;
            *cycle = json!(cycle.as_f64()? / FASTER);
        }
        _ => return None,
    }
    Some(())
}

/// Gives the station at a node a queue, the nearest place first; `None` if its entry is of several
/// nodes.
pub fn add_queue(load: &mut Load, labels: &Labels, places: &[u32]) -> Option<()> {
    let queue: Vec<String> = places.iter().map(u32::to_string).collect();
    let index = entry(load, labels).map(|entry| entry.index);
    let stations = load.rest.entry("stations").or_insert_with(|| json!([])).as_array_mut()?;
    let Some(index) = index else {
        // The id is the word that no other node has.
        let id = labels.own.iter().find(|word| word.parse::<u32>().is_ok())?;
        stations.push(json!({"at": id, "queue": queue}));
        return Some(());
    };
    let entry = stations.get_mut(index)?.as_object_mut()?;
    let at = entry.get("at")?;
    let is_single = match at {
        Value::Array(nodes) => nodes.len() == 1 && names(at, &labels.own),
        _ => names(at, &labels.own),
    };
    if is_single {
        entry.insert("queue".to_owned(), json!(queue));
    }
    is_single.then_some(())
}

/// Adds a place to all lists that name another one. Returns whether orders go there: by name, or by
/// its role.
pub fn add_place(load: &mut Load, labels: &Labels, place: u32) -> bool {
    let mut is_named = labels.of_groups.iter().any(|group| names_group(load, group));
    if let Some(Value::Object(groups)) = load.rest.get_mut("groups") {
        for nodes in groups.values_mut() {
            is_named |= extend(nodes, labels, place);
        }
    }
    is_named |= add_to_generator(load, labels, place);
    for generator in load.generators.iter_mut().flatten() {
        is_named |= add_to_generator(generator, labels, place);
    }
    if let Some(Value::Array(stations)) = load.rest.get_mut("stations") {
        for at in stations.iter_mut().filter_map(|station| station.get_mut("at")) {
            extend(at, labels, place);
        }
    }
    is_named
}

/// Whether a load, or a generator of it, takes places by a role or a zone.
fn names_group(load: &Load, group: &str) -> bool {
    let mut all = std::iter::once(load).chain(load.generators.iter().flatten());
    all.any(|load| PLACES.iter().any(|key| load.rest.get(*key).is_some_and(|it| it == group)))
}

fn add_to_generator(load: &mut Load, labels: &Labels, place: u32) -> bool {
    let mut is_named = false;
    for key in PLACES {
        is_named |= load.rest.get_mut(key).is_some_and(|places| extend(places, labels, place));
    }
    if let Some(Value::Array(flows)) = load.rest.get_mut("flows") {
        for end in flows.iter_mut().flat_map(|flow| {
            flow.as_object_mut()
                .into_iter()
                .flat_map(|flow| flow.iter_mut().filter(|(key, _)| *key == "from" || *key == "to"))
        }) {
            is_named |= extend(end.1, labels, place);
        }
    }
    if let Some(Value::Object(at)) = load.dwell.as_mut().and_then(|dwell| dwell.get_mut("at")) {
        let own = labels.own.iter().find_map(|name| at.get(name).cloned());
        at.extend(own.map(|dwell| (place.to_string(), dwell)));
    }
    is_named
}

/// Adds a place where another one is named.
fn extend(places: &mut Value, labels: &Labels, place: u32) -> bool {
    if !names(places, &labels.own) {
        return false;
    }
    let place = Value::from(place.to_string());
    match places {
        Value::Array(places) => places.push(place),
        single => *single = json!([single.clone(), place]),
    }
    true
}
