//! The properties of nodes and edges for one of the vehicle types.

use std::collections::BTreeSet;

use serde_json::Value;

use super::MAX_NAMES;
use super::object::{Context, Object, Raw};
use crate::model::tags::{OTHER_VEHICLE_TYPES, Tags, VEHICLE_TYPES};
use crate::model::value::shorten;

/// The vehicle type whose properties are used.
pub(super) struct Vehicles<'a> {
    /// The vehicle type of the options.
    wanted: Option<&'a str>,
    /// The first vehicle type of the file.
    first: Option<String>,
    /// Some vehicle types of the file, for messages.
    known: BTreeSet<String>,
    is_wanted_known: bool,
}

/// The keys of the properties by vehicle type: that of LIF 1 and that of LIF 2.
pub(super) struct Keys {
    names: [&'static str; 2],
    /// An element of either, for messages.
    kind: &'static str,
}

pub(super) const OF_NODES: Keys = Keys {
    names: ["vehicleTypeNodeProperties", "mobileRobotTypeNodeProperties"],
    kind: "an element of `vehicleTypeNodeProperties`",
};
pub(super) const OF_EDGES: Keys = Keys {
    names: ["vehicleTypeEdgeProperties", "mobileRobotTypeEdgeProperties"],
    kind: "an element of `vehicleTypeEdgeProperties`",
};

/// The choice among the properties of a node or an edge.
pub(super) enum Choice<'text> {
    /// The properties of the vehicle type in use.
    Some(Object<'text>),
    /// The element has no properties.
    Empty,
    /// The element has properties, but none for the vehicle type of the options.
    Others,
}

/// The names of the vehicle types of a node or an edge.
pub(super) struct TypeNames {
    /// Those whose properties are read, or are the same.
    same: String,
    /// Those whose properties aren't kept.
    others: String,
}

impl TypeNames {
    /// The names of elements of a list, the one at an index being read.
    fn of(types: &[Vec<String>], list: &[Raw<'_>], index: usize) -> Self {
        let used = list.get(index).filter(|_| list.len() > 1).map(without_types);
        let (mut same, mut others) = (Vec::new(), Vec::new());
        for (number, names) in types.iter().enumerate() {
            let is_same = number == index
                || list.get(number).is_none_or(|raw| used.as_ref() == Some(&without_types(raw)));
            let names = names.iter().map(String::as_str);
            if is_same { same.extend(names) } else { others.extend(names) }
        }
        Self { same: same.join(", "), others: others.join(", ") }
    }

    /// Sets them as properties.
    pub fn set(&self, tags: &mut Tags) {
        tags.set(VEHICLE_TYPES, &self.same);
        tags.set(OTHER_VEHICLE_TYPES, &self.others);
    }
}

impl<'a> Vehicles<'a> {
    pub fn new(wanted: Option<&'a str>) -> Self {
        Self { wanted, first: None, known: BTreeSet::new(), is_wanted_known: false }
    }

    /// Takes the properties of all types out of a node or an edge. Returns those of one type, and
    /// the names of the types.
    pub fn choose<'text>(
        &mut self,
        owner: &mut Object<'text>,
        keys: &Keys,
        context: &mut Context<'_, 'text>,
    ) -> (Choice<'text>, TypeNames) {
        let mut list = owner.take_list(keys.names[0], context);
        list.extend(owner.take_list(keys.names[1], context));
        let mut objects: Vec<Object<'text>> =
            list.iter().filter_map(|raw| Object::parse(raw, keys.kind, context)).collect();
        let types: Vec<Vec<String>> =
            objects.iter_mut().map(|object| take_types(object, context)).collect();
        for name in types.iter().flatten() {
            self.add(name);
        }
        let wanted = self.wanted.or(self.first.as_deref());
        let index =
            types.iter().position(|names| names.iter().any(|name| Some(name.as_str()) == wanted));
        if let (None, [first, _, ..]) = (self.wanted, list.as_slice()) {
            self.note_differences(&list, context.at(first), context);
        }
        if let (None, None, Some(raw), Some(first)) =
            (self.wanted, index, list.first(), &self.first)
            && types.iter().any(|names| !names.is_empty())
        {
            let message = format!(
                "not for the vehicle type `{}`, but read all the same, as if for all types; choose \
                 a type with --vehicle-type",
                shorten(first)
            );
            context.assume(context.at(raw), message);
        }
        let names = TypeNames::of(&types, &list, index.unwrap_or(0));
        let choice = match index {
            _ if objects.is_empty() => Choice::Empty,
            None if self.wanted.is_some() => Choice::Others,
            index => Choice::Some(objects.swap_remove(index.unwrap_or(0))),
        };
        (choice, names)
    }

    /// Reports a vehicle type that the file doesn't have.
    pub fn report(&self, context: &mut Context<'_, '_>) {
        let Some(wanted) = self.wanted.filter(|_| !self.is_wanted_known) else { return };
        let known = self.known.iter().map(|name| shorten(name)).collect::<Vec<_>>().join("`, `");
        context.error(
            0,
            format!("no vehicle type is named `{}`: the file has `{known}`", shorten(wanted)),
        );
    }

    fn add(&mut self, name: &str) {
        self.first.get_or_insert_with(|| name.to_owned());
        self.is_wanted_known |= Some(name) == self.wanted;
        if self.known.len() < MAX_NAMES && !self.known.contains(name) {
            self.known.insert(name.to_owned());
        }
    }

    fn note_differences(&self, list: &[Raw<'_>], at: u32, context: &mut Context<'_, '_>) {
        let mut others = list.iter().map(without_types);
        let first = others.next();
        if others.any(|other| Some(other) != first) {
            let used = shorten(self.first.as_deref().unwrap_or_default());
            let message = format!(
                "vehicle types differ in their properties here: those of `{used}` are used if \
                 there are any; choose a type with --vehicle-type"
            );
            context.assume(at, message);
        }
    }
}

/// Returns the properties of an element, without the types that they are for.
fn without_types(raw: &Raw<'_>) -> Value {
    let mut value: Value = serde_json::from_str(raw.get()).unwrap_or_default();
    if let Some(fields) = value.as_object_mut() {
        fields.retain(|key, _| key != "vehicleTypeId" && key != "mobileRobotTypes");
    }
    value
}

/// Takes the names of the types that properties are for: the id of LIF 1, or `MANUFACTURER/SERIES`
/// of LIF 2.
fn take_types<'text>(object: &mut Object<'text>, context: &mut Context<'_, 'text>) -> Vec<String> {
    let mut types: Vec<String> = object.take_text("vehicleTypeId", context).into_iter().collect();
    for raw in object.take_list("mobileRobotTypes", context) {
        let Some(mut robot) = Object::parse(raw, "a mobile robot type", context) else { continue };
        let parts = ["manufacturer", "seriesName"].map(|key| robot.take_text(key, context));
        robot.ignore_rest(context);
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        if !parts.is_empty() {
            types.push(parts.join("/"));
        }
    }
    types
}
