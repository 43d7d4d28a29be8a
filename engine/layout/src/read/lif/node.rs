//! Nodes, stations and their actions.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec2;
use serde_json::Value;

use super::ids::Target;
use super::object::{Context, Object, Raw, plain};
use super::vehicle::{Choice, OF_NODES};
use super::{Reader, Sheet};
use crate::model::tags::{Role, Tags};
use crate::model::value::shorten;
use crate::read::layout::{LayoutNode, LayoutStation};

impl<'text> Reader<'_, '_, 'text> {
    /// Reads a node of the layout with this index.
    pub fn node(
        &mut self,
        raw: Raw<'text>,
        sheet: &Sheet<'text>,
        layout: usize,
    ) -> Option<LayoutNode> {
        let context = &mut self.context;
        let mut object = Object::parse(raw, "a node", context)?;
        let at = object.at;
        let Some(id) = object.take_text("nodeId", context) else {
            context.error(at, "a node has no `nodeId`: give it one");
            return None;
        };
        let position = position(&mut object, &id, context);
        let name = object.take_text("nodeName", context).map(Into::into);
        let mut node = LayoutNode {
            at,
            position,
            tags: Tags { name, level: sheet.level.clone(), ..Tags::default() },
            ..LayoutNode::default()
        };
        let (choice, types) = self.vehicles.choose(&mut object, &OF_NODES, context);
        types.set(&mut node.tags);
        if let Choice::Some(mut properties) = choice {
            node.heading = properties
                .take_number("theta", context)
                .map(|angle| checked_angle(at, angle, context));
            node.role = take_actions(&mut properties, &mut node.tags, context);
            properties.keep_json(&["loadRestriction", "allowedDeviationXY"], &mut node.tags);
            properties.keep_rest(&mut node.tags.properties, context);
        }
        object.keep_rest(&mut node.tags.properties, context);
        node.id = self.node_ids.unique(id, layout);
        Some(node)
    }

    /// Reads the stations of the layout with this index.
    pub fn stations(
        &mut self,
        list: &[Raw<'text>],
        layout: usize,
        nodes: &[LayoutNode],
    ) -> Vec<LayoutStation> {
        if list.is_empty() {
            return Vec::new();
        }
        let roles: BTreeMap<&str, Role> =
            nodes.iter().map(|node| (node.id.as_str(), node.role)).collect();
        list.iter().filter_map(|raw| self.station(raw, layout, &roles)).collect()
    }

    fn station(
        &mut self,
        raw: Raw<'text>,
        layout: usize,
        roles: &BTreeMap<&str, Role>,
    ) -> Option<LayoutStation> {
        let context = &mut self.context;
        let mut object = Object::parse(raw, "a station", context)?;
        let mut station = LayoutStation { at: object.at, ..LayoutStation::default() };
        let Some(id) = object.take_text("stationId", context) else {
            context.error(object.at, "a station has no `stationId`: give it one");
            return None;
        };
        for node in object.take_list("interactionNodeIds", context).into_iter().filter_map(plain) {
            match self.node_ids.resolve(node, layout) {
                Target::Known(node) => station.nodes.push(node),
                Target::Elsewhere => {
                    context.note(object.at, "a node of a station is in a layout that isn't read")
                }
            }
        }
        if station.nodes.is_empty() {
            context.warning(
                object.at,
                format!("station `{}` has no `interactionNodeIds`", shorten(&id)),
            );
        }
        let role =
            |node: &String| roles.get(node.as_str()).copied().filter(|role| *role != Role::None);
        station.role = station.nodes.iter().find_map(role).unwrap_or_default();
        if let Some(kind) = object.take_text("stationType", context) {
            station.properties.insert("stationType".into(), kind.as_str().into());
            if station.role == Role::None {
                station.role = self::role(&kind);
            }
        }
        if let Some(mut position) =
            object.take_object("stationPosition", "`stationPosition`", context)
        {
            if let Some(theta) = position.take_number("theta", context) {
                station.properties.insert("theta".into(), theta.to_string().into());
            }
            station.position = point(position, context);
        }
        object.keep_rest(&mut station.properties, context);
        station.name = self.station_ids.unique(id, layout);
        Some(station)
    }
}

/// Reads `x` and `y`, in metres.
/// Returns the position of a node. Reports one that is missing or wrong.
fn position<'text>(
    object: &mut Object<'text>,
    id: &str,
    context: &mut Context<'_, 'text>,
) -> Option<DVec2> {
    let at = object.at;
    let found = match object.take("nodePosition") {
        Some(raw) => point(Object::parse(raw, "`nodePosition`", context)?, context),
        None => None,
    };
    if found.is_none() {
        let id = shorten(id);
        let message = format!("node `{id}` has no `nodePosition` with `x` and `y`: give it one");
        context.error(at, message);
    }
    found
}

fn point<'text>(mut object: Object<'text>, context: &mut Context<'_, 'text>) -> Option<DVec2> {
    let [x, y] = ["x", "y"].map(|key| object.take_number(key, context));
    object.ignore_rest(context);
    Some(DVec2::new(x?, y?))
}

/// Returns an angle, and notes one that is probably in degrees.
pub(super) fn checked_angle(at: u32, angle: f64, context: &mut Context<'_, '_>) -> f64 {
    if angle.abs() > 2.0 * PI + 0.01 {
        let message = "an angle is more than a full turn: LIF has radians; if all angles are \
                       degrees, `regatta graph check --fix` converts them";
        context.note(at, message);
    }
    angle
}

/// Keeps actions as a property. Returns their [role](role_of).
pub(super) fn take_actions(
    object: &mut Object<'_>,
    tags: &mut Tags,
    context: &mut Context<'_, '_>,
) -> Role {
    object.keep_json(&["forbiddenActionTypes"], tags);
    let mut roles = Vec::new();
    for key in ["actions", "requiredActions", "feasibleActions"] {
        let Some(json) = object.take_json(key).filter(|json| json != "[]") else { continue };
        tags.set(key, &json);
        roles.extend(self::roles(&json));
    }
    let role = role_of(&roles);
    if roles.iter().any(|other| is_lost(*other, role)) {
        context.note(
            object.at,
            "a node or edge has actions of several roles, such as pick and charge: that of loads, \
             or else the first, is its role",
        );
    }
    role
}

/// Whether the role of a place doesn't tell one of its roles.
fn is_lost(role: Role, kept: Role) -> bool {
    role != Role::None && role != kept && !(kept == Role::Transfer && role.handles_loads())
}

/// Returns the role of a place with some roles, as [`Role::and`] joins two.
pub(crate) fn role_of(roles: &[Role]) -> Role {
    roles.iter().fold(Role::None, |role, other| role.and(*other))
}

/// Returns the roles of a list of actions.
pub(crate) fn roles(actions: &str) -> Vec<Role> {
    let actions: Vec<Value> = serde_json::from_str(actions).unwrap_or_default();
    let roles = actions.iter().filter_map(|action| action.get("actionType")?.as_str()).map(role);
    roles.filter(|role| *role != Role::None).collect()
}

/// Returns the role of an action type of VDA 5050, or of another common type.
fn role(action: &str) -> Role {
    match action.to_ascii_lowercase().as_str() {
        "pick" | "pickup" | "load" => Role::Pick,
        "drop" | "dropoff" | "unload" => Role::Drop,
        "park" | "parking" | "startparking" => Role::Park,
        "startcharging" | "charge" | "charging" => Role::Charge,
        _ => Role::None,
    }
}
