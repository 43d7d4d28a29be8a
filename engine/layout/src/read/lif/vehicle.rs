//! The properties of nodes and edges for one of the vehicle types.

use std::collections::BTreeSet;

use serde_json::Value;

use super::MAX_NAMES;
use super::object::{Context, Object, Raw};
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

/// The choice among the properties of a node or an edge.
pub(super) enum Choice<'text> {
    /// The properties of the vehicle type in use.
    Some(Object<'text>),
    /// The element has no properties.
    Empty,
    /// The element has properties, but none for the vehicle type of the options.
    Others,
}

impl<'a> Vehicles<'a> {
    pub fn new(wanted: Option<&'a str>) -> Self {
        Self { wanted, first: None, known: BTreeSet::new(), is_wanted_known: false }
    }

    /// Chooses among `vehicleTypeNodeProperties` or `vehicleTypeEdgeProperties`, and returns the
    /// names of all types.
    pub fn choose<'text>(
        &mut self,
        list: &[Raw<'text>],
        kind: &'static str,
        context: &mut Context<'_, 'text>,
    ) -> (Choice<'text>, String) {
        let mut objects: Vec<Object<'text>> =
            list.iter().filter_map(|raw| Object::parse(raw, kind, context)).collect();
        let types: Vec<Option<String>> =
            objects.iter_mut().map(|object| object.take_text("vehicleTypeId", context)).collect();
        for name in types.iter().flatten() {
            self.add(name);
        }
        let wanted = self.wanted.or(self.first.as_deref());
        let index = types.iter().position(|name| name.is_some() && name.as_deref() == wanted);
        if let (None, [first, _, ..]) = (self.wanted, list) {
            self.note_differences(list, context.at(first), context);
        }
        let names = types.iter().flatten().map(String::as_str).collect::<Vec<_>>().join(", ");
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
        let mut others = list.iter().map(|raw| {
            let mut value: Value = serde_json::from_str(raw.get()).unwrap_or_default();
            value.as_object_mut().map(|fields| fields.remove("vehicleTypeId"));
            value
        });
        let first = others.next();
        if others.any(|other| Some(other) != first) {
            let used = shorten(self.first.as_deref().unwrap_or_default());
            let message = format!(
                "vehicle types differ in their properties here: those of `{used}` are used if \
                 there are any; choose a type with --vehicle-type"
            );
            context.note(at, message);
        }
    }
}
