//! Groups of nodes, by name, role, zone or as lists.

use std::collections::BTreeMap;

use regatta_base::yaml::{self, Node};
use regatta_plugin::world::Role;

use crate::places::{PlaceError, Places};
use crate::storages::StorageSettings;

/// The named groups of nodes.
pub(crate) struct Groups<'places> {
    named: BTreeMap<String, Vec<u32>>,
    pub(crate) places: &'places Places,
}

impl<'places> Groups<'places> {
    pub(super) fn read(
        groups: Option<&Node>,
        places: &'places Places,
    ) -> Result<Self, yaml::Error> {
        let pairs = groups.map(Node::pairs).transpose()?.unwrap_or_default();
        let mut named = BTreeMap::new();
        for (name, value) in pairs {
            named.insert(name.into_owned(), group(value, places)?);
        }
        Ok(Self { named, places })
    }

    /// Returns the groups with the nodes of storages, for stations at all places of one.
    pub(super) fn with_nodes_of(mut self, storages: &[StorageSettings]) -> Self {
        for storage in storages {
            self.named.insert(storage.name.clone(), storage.nodes());
        }
        self
    }

    /// Returns the groups in which the name of a storage is the storage itself, for orders.
    pub(super) fn with_storages<'storages>(
        self,
        storages: &[StorageSettings],
        places: &'storages Places,
    ) -> Groups<'storages> {
        let mut named = self.named;
        for storage in storages {
            named.remove(&storage.name);
        }
        Groups { named, places }
    }

    /// Whether a group has a name.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.named.contains_key(name) || role_named(name).is_some()
    }

    /// Returns the nodes that a field names, which are no storages.
    pub(crate) fn find_nodes(&self, field: Option<&Node>) -> Result<Vec<u32>, yaml::Error> {
        let nodes = self.find(field, Role::None)?;
        match (nodes.iter().find(|node| self.places.storage(**node).is_some()), field) {
            (Some(storage), Some(field)) => Err(field.error(format!(
                "orders pick and drop at the storage `{}`: name it in `from`, `to` or `flows`",
                self.places.label(*storage)
            ))),
            _ => Ok(nodes),
        }
    }

    /// Returns the nodes that a field names, or those of the role, or all if none has it; but no
    /// chargers.
    pub(crate) fn find(&self, field: Option<&Node>, role: Role) -> Result<Vec<u32>, yaml::Error> {
        let Some(field) = field else {
            let nodes = self.with_role(role);
            if nodes.is_empty() || role == Role::None {
                return Ok(self
                    .places
                    .nodes(|place| place.role != Role::Charge && !place.is_in_lift));
            }
            return Ok(nodes);
        };
        if field.is_map() || field.list().is_ok() {
            return group(field, self.places);
        }
        let name = field.text()?;
        let with_role = role_named(&name).map(|role| self.with_role(role));
        match self.named.get(name.as_ref()).cloned().or(with_role) {
            Some(nodes) if !nodes.is_empty() => Ok(nodes),
            Some(_) => Err(field.error(format!("no node has the role `{name}`"))),
            None => match self.places.find_one(&name) {
                Ok(node) => Ok(vec![node]),
                Err(PlaceError::Unknown(_)) => Err(field.error(format!(
                    "`{name}` is neither a group nor a role, nor the name or the id of a node"
                ))),
                Err(error) => Err(field.error(error.to_string())),
            },
        }
    }

    fn with_role(&self, role: Role) -> Vec<u32> {
        self.places.nodes(|place| has_role(place.role, role))
    }
}

fn group(value: &Node, places: &Places) -> Result<Vec<u32>, yaml::Error> {
    let nodes = if value.is_map() { matching(value, places)? } else { listed(value, places)? };
    if nodes.is_empty() { Err(value.error("no node is in this group")) } else { Ok(nodes) }
}

fn listed(value: &Node, places: &Places) -> Result<Vec<u32>, yaml::Error> {
    let mut nodes = Vec::new();
    for item in value.list()? {
        let found = places.find_one(&item.text()?);
        nodes.push(found.map_err(|error| item.error(error.to_string()))?);
    }
    Ok(nodes)
}

fn matching(value: &Node, places: &Places) -> Result<Vec<u32>, yaml::Error> {
    let fields = value.fields(&["role", "zone"])?;
    let role = fields.optional("role", node_role)?;
    let zone = fields.optional("zone", Node::text)?;
    Ok(places.nodes(|place| {
        role.is_none_or(|role| has_role(place.role, role))
            && zone.as_ref().is_none_or(|zone| place.zone == zone.as_ref())
    }))
}

/// Whether a place can be used in a role.
fn has_role(of_place: Role, role: Role) -> bool {
    match role {
        Role::Pick => of_place.is_pick(),
        Role::Drop => of_place.is_drop(),
        _ => of_place == role,
    }
}

fn role_named(name: &str) -> Option<Role> {
    Role::ALL.into_iter().find(|role| role.name() == name)
}

fn node_role(value: &Node) -> Result<Role, yaml::Error> {
    let name = value.text()?;
    role_named(&name).ok_or_else(|| value.error(format!("unknown role `{name}`")))
}
