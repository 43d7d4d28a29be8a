//! The names in orders: the nodes of the world, by id, name, role and zone, the storages of a load,
//! and the robot types.

use std::collections::{BTreeMap, BTreeSet};

use glam::Vec2;
use regatta_plugin::World;
use regatta_plugin::world::Role;

/// A node of the world.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Place {
    /// Id in the route graph's file.
    pub id: u32,
    /// Name; empty for none.
    pub name: String,
    /// Zone; empty for none.
    pub zone: String,
    /// The role of the node.
    pub role: Role,
    /// Metres east and north of the world's origin.
    pub position: Vec2,
    /// Whether it is in the cabin of a lift, which a robot that stands there would keep.
    pub is_in_lift: bool,
}

/// The error of looking a place up.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlaceError {
    /// No place has the name or the id.
    #[error("`{0}` is neither the name nor the id of a node")]
    Unknown(String),
    /// A place has the name in other letters.
    #[error("`{name}` is neither the name nor the id of a node; did you mean `{similar}`?")]
    OtherCase {
        /// The name that no place has.
        name: String,
        /// The name of a place, which has small letters instead of capitals or the other way round.
        similar: String,
    },
    /// Several places have the name.
    #[error("several nodes have the name `{0}`; give the id of one")]
    Ambiguous(String),
    /// No robot type has the name.
    #[error("no robot type has the name `{}`; there are: {known}", name.escape_debug())]
    UnknownRobotType {
        /// The name.
        name: String,
        /// The names that there are.
        known: String,
    },
}

/// The table of all places. A node is an index in it and in the world's nodes. The numbers after
/// the last node are the storages of a load: an order's stop there becomes a node when a place is
/// chosen.
#[derive(Clone, Debug, Default)]
pub struct Places {
    places: Vec<Place>,
    /// The names of storages, and their nodes, of which each has at least one.
    storages: Vec<(String, Vec<u32>)>,
    by_name: BTreeMap<String, u32>,
    /// The names that several places have.
    repeated: BTreeSet<String>,
    by_id: BTreeMap<u32, u32>,
    /// The names of the robot types, in the order of the world; `None` if they aren't known.
    robot_types: Option<Vec<String>>,
}

impl Places {
    /// Makes the table of a world.
    pub fn of(world: &World) -> Self {
        let levels = world.lifts().iter().flat_map(|lift| world.lift_levels(lift));
        let stops: BTreeSet<u32> =
            levels.flat_map(|level| world.level_nodes(level)).copied().collect();
        let places = (0..).zip(world.nodes()).map(|(index, node)| Place {
            id: node.id,
            name: world.text(node.name).to_owned(),
            zone: world.text(node.zone).to_owned(),
            role: node.role(),
            position: Vec2::new(node.x, node.y),
            is_in_lift: stops.contains(&index),
        });
        let mut table = Self::new(places.collect());
        for other in world.other_names() {
            table.add_name(world.text(other.name), other.node);
        }
        let types = world.robot_types().iter().map(|record| record.name().to_owned());
        table.with_robot_types(types.collect())
    }

    /// Returns the table with the names of robot types, in the order of the world.
    #[must_use]
    pub fn with_robot_types(self, names: Vec<String>) -> Self {
        Self { robot_types: Some(names), ..self }
    }

    /// Returns the table without robot types, as for a layout whose robots aren't known yet: orders
    /// may name any type, and are for any robot.
    #[must_use]
    pub fn without_robot_types(self) -> Self {
        Self { robot_types: None, ..self }
    }

    /// Returns the indices of robot types in ascending order, each once.
    ///
    /// # Errors
    /// [`PlaceError::UnknownRobotType`] for the first name that none has.
    pub fn robot_types(&self, names: &[String]) -> Result<Vec<u32>, PlaceError> {
        let Some(known) = &self.robot_types else { return Ok(Vec::new()) };
        let mut types = BTreeSet::new();
        for name in names {
            let Some(index) = (0..).zip(known).find(|(_, known)| *known == name.trim()) else {
                let (name, known) = (name.clone(), known.join(", "));
                return Err(PlaceError::UnknownRobotType { name, known });
            };
            types.insert(index.0);
        }
        Ok(types.into_iter().collect())
    }

    /// Returns the names of robot types by their indices.
    pub fn robot_type_names(&self, types: &[u32]) -> Vec<String> {
        let known = self.robot_types.as_deref().unwrap_or_default();
        types.iter().filter_map(|index| known.get(*index as usize).cloned()).collect()
    }

    /// Returns the table with storages, by their names and nodes, which orders may name like nodes.
    pub(crate) fn with_storages(&self, storages: Vec<(String, Vec<u32>)>) -> Self {
        let mut table = self.clone();
        for ((name, _), number) in storages.iter().zip(self.places.len() as u32..) {
            table.by_name.insert(name.clone(), number);
        }
        Self { storages, ..table }
    }

    /// Returns the index of the storage that stands in place of a node; `None` for a node.
    pub fn storage(&self, node: u32) -> Option<usize> {
        let index = (node as usize).checked_sub(self.places.len())?;
        (index < self.storages.len()).then_some(index)
    }

    /// The first place of a storage.
    ///
    /// # Panics
    /// If there is no such storage.
    pub fn first_place(&self, storage: usize) -> &Place {
        self.place(self.storages[storage].1[0])
    }

    /// Returns the nodes of a storage, or the node itself.
    pub fn nodes_at(&self, node: u32) -> Vec<u32> {
        match self.storage(node) {
            Some(index) => self.storages[index].1.clone(),
            None => vec![node],
        }
    }

    /// Gives a node another name, unless it is the name or the id of a node. Of several nodes with
    /// the same other name, such as those of a station, the first has it.
    pub(crate) fn add_name(&mut self, name: &str, node: u32) {
        if name.is_empty() || name.parse().is_ok_and(|id| self.by_id.contains_key(&id)) {
            return;
        }
        self.by_name.entry(name.to_owned()).or_insert(node);
    }

    /// Makes a table of places, in the order of the world's nodes. Of places with the same name or
    /// id, the first has it.
    pub fn new(places: Vec<Place>) -> Self {
        let mut table = Self::default();
        for (place, index) in places.iter().zip(0_u32..) {
            table.by_id.entry(place.id).or_insert(index);
            if !place.name.is_empty() {
                let first = *table.by_name.entry(place.name.clone()).or_insert(index);
                if first != index {
                    table.repeated.insert(place.name.clone());
                }
            }
        }
        Self { places, ..table }
    }

    /// The number of places.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Returns the node with this name, or else with this id.
    pub fn find(&self, text: &str) -> Option<u32> {
        let text = text.trim();
        self.by_name.get(text).copied().or_else(|| self.with_id(text.parse().ok()?))
    }

    /// Returns the only node with this name, or else the one with this id.
    ///
    /// # Errors
    /// [`PlaceError`] if there is none, or if several have the name.
    pub fn find_one(&self, text: &str) -> Result<u32, PlaceError> {
        let text = text.trim();
        if self.repeated.contains(text) {
            return Err(PlaceError::Ambiguous(text.to_owned()));
        }
        self.find(text).ok_or_else(|| self.unknown(text))
    }

    fn unknown(&self, text: &str) -> PlaceError {
        let (name, lower) = (text.to_owned(), text.to_lowercase());
        match self.by_name.keys().find(|other| other.to_lowercase() == lower) {
            Some(similar) => PlaceError::OtherCase { name, similar: similar.clone() },
            None => PlaceError::Unknown(name),
        }
    }

    /// Returns the node with an id of the route graph's file.
    pub fn with_id(&self, id: u32) -> Option<u32> {
        self.by_id.get(&id).copied()
    }

    /// The place of a node; the first place of a storage.
    ///
    /// # Panics
    /// If there is no such node.
    pub fn place(&self, node: u32) -> &Place {
        let node = self.storage(node).map_or(node, |index| self.storages[index].1[0]);
        &self.places[node as usize]
    }

    /// Returns the name of a node, or its id if it has none; the name of a storage.
    pub fn label(&self, node: u32) -> String {
        if let Some(index) = self.storage(node) {
            return self.storages[index].0.clone();
        }
        match self.places.get(node as usize) {
            Some(place) if place.name.is_empty() => place.id.to_string(),
            Some(place) => place.name.clone(),
            None => String::new(),
        }
    }

    /// Returns the nodes with a name for which a condition holds, in ascending order. The name of a
    /// station is one of the first of its nodes.
    pub(crate) fn nodes_named(&self, condition: impl Fn(&str) -> bool) -> Vec<u32> {
        let mut nodes = self.nodes(|place| condition(&place.name));
        let others = self.by_name.iter().filter(|(name, _)| condition(name));
        nodes.extend(others.map(|(_, node)| *node).filter(|node| self.storage(*node).is_none()));
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Returns the nodes for which a condition holds, in ascending order.
    pub fn nodes(&self, condition: impl Fn(&Place) -> bool) -> Vec<u32> {
        (0..)
            .zip(&self.places)
            .filter(|(_, place)| condition(place))
            .map(|(node, _)| node)
            .collect()
    }
}
