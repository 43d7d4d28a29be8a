//! Descriptions of loads: which orders a scenario's plant gets, and how many.
//!
//! ```yaml
//! load:
//!   seed: 7                          # 0 if absent
//!   groups:                          # named groups of nodes
//!     inbound: [A1, A2, 17]          # by name or id
//!     north: {zone: north, role: drop}
//!   generators:
//!     - name: deliveries             # in the names of its orders: load:deliveries-1 …; its number if absent
//!       from: inbound                # a group, or a role; default: the role pick, or any node if there is none
//!       to: north                    # likewise, with the role drop
//!       per_hour: 120                # Poisson; or a profile that begins anew after its end:
//!       # shifts: [{until: 3600, per_hour: 200}, {until: 7200, per_hour: 20}]
//!       priority: 5                  # 0 to 255, 0 if absent
//!       dwell: {min: 5, max: 15}     # seconds at each stop, evenly spread; or a number; 0 if absent
//!       deadline: 900                # seconds after its creation; none if absent
//!     - endless: robots              # as many open orders as there are robots, or a number
//!       among: north                 # orders with one stop of this group; any node if absent
//!     - endless: 50
//!       from: inbound                # orders with two stops, as above
//!       to: north
//! ```
//!
//! A generator's fields may also stand beside `seed` and `groups`, if there is only one. A file may
//! have further keys beside `load`: it may be a scenario.

use std::collections::BTreeMap;
use std::path::Path;

use regatta_plugin::world::Role;

use super::file::{FileError, text_of};
use super::places::Places;
use super::yaml::{self, Fields, InputError, Value};

/// A valid description of a load.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Load {
    /// The seed of all random numbers.
    pub seed: u64,
    /// The generators.
    pub(super) generators: Vec<GeneratorSettings>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct GeneratorSettings {
    pub(super) name: String,
    pub(super) arrival: Arrival,
    pub(super) stops: Stops,
    pub(super) priority: u8,
    /// The shortest and the longest dwell time, in seconds.
    pub(super) dwell_secs: [f64; 2],
    pub(super) deadline_secs: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Arrival {
    /// At random, at the mean rates of this profile.
    Poisson(Vec<Shift>),
    /// Whenever fewer than this number of orders are open, or fewer than there are robots.
    Endless(Option<usize>),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stops {
    /// A node of the group.
    One(Vec<u32>),
    /// From a node of the first group to another one of the second.
    Two { from: Vec<u32>, to: Vec<u32> },
}

/// A part of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shift {
    /// Its end in seconds; infinite for a rate that never changes.
    pub(super) until_secs: f64,
    pub(super) per_hour: f64,
}

/// The largest rate, in orders an hour.
const MAX_PER_HOUR: f64 = 1e8;
const LOAD_FIELDS: [&str; 3] = ["seed", "groups", "generators"];
const GENERATOR_FIELDS: [&str; 10] = [
    "name", "from", "to", "per_hour", "shifts", "priority", "dwell", "deadline", "endless", "among",
];

impl Load {
    /// Reads the load of a file.
    ///
    /// # Errors
    /// [`FileError`] if it can't be read or something in it is wrong.
    pub fn read(path: &Path, places: &Places) -> Result<Self, FileError> {
        Self::parse(&text_of(path)?, places)
            .map_err(|error| FileError::Invalid { path: path.to_owned(), error })
    }

    /// Parses the load of a text.
    ///
    /// # Errors
    /// [`InputError`] for the first thing that is wrong.
    pub fn parse(text: &str, places: &Places) -> Result<Self, InputError> {
        yaml::read(text, |document| {
            let pairs = document.pairs()?;
            let inner = pairs.iter().find(|(key, _)| key == "load").map(|(_, value)| *value);
            load(inner.unwrap_or(document), places)
        })
    }
}

fn load(load: Value, places: &Places) -> Result<Load, InputError> {
    let all: Vec<_> = LOAD_FIELDS.into_iter().chain(GENERATOR_FIELDS).collect();
    let fields = load.fields(&all)?;
    let groups = Groups::read(fields.get("groups"), places)?;
    let seed = fields.optional("seed", |value| value.integer(i64::MAX as u64))?.unwrap_or(0);
    let generators = match fields.get("generators") {
        None => vec![generator(load, &fields, 1, &groups)?],
        Some(list) => {
            load.fields(&LOAD_FIELDS)?;
            let mut generators = Vec::new();
            for (value, number) in list.list()?.into_iter().zip(1..) {
                let fields = value.fields(&GENERATOR_FIELDS)?;
                generators.push(generator(value, &fields, number, &groups)?);
            }
            generators
        }
    };
    let mut names: Vec<_> = generators.iter().map(|generator| &generator.name).collect();
    names.sort();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(load.error(format!("two generators have the name `{}`", pair[0]))),
        None => Ok(Load { seed, generators }),
    }
}

fn generator(
    value: Value,
    fields: &Fields,
    number: usize,
    groups: &Groups,
) -> Result<GeneratorSettings, InputError> {
    let name = fields
        .optional("name", |value| generator_name(value))?
        .unwrap_or_else(|| number.to_string());
    let arrival = arrival(value, fields)?;
    let has_ends = fields.get("from").is_some() || fields.get("to").is_some();
    let stops = match arrival {
        Arrival::Endless(_) if !has_ends => {
            Stops::One(groups.find(fields.get("among"), Role::None)?)
        }
        _ => transports(value, fields, groups)?,
    };
    let dwell_secs = fields.optional("dwell", dwell)?.unwrap_or_default();
    let priority = fields.optional("priority", |value| value.integer(255))?.unwrap_or(0) as u8;
    let deadline_secs = fields.optional("deadline", Value::positive)?;
    Ok(GeneratorSettings { name, arrival, stops, priority, dwell_secs, deadline_secs })
}

fn generator_name(value: Value) -> Result<String, InputError> {
    let name = value.text()?;
    let is_plain = |c: char| c.is_alphanumeric() || "_-.".contains(c);
    match name.chars().all(is_plain) && (1..=64).contains(&name.len()) {
        true => Ok(name),
        false => {
            Err(value.error("the name of a generator has 1 to 64 letters, digits, `_`, `-`, `.`"))
        }
    }
}

fn arrival(value: Value, fields: &Fields) -> Result<Arrival, InputError> {
    match (fields.get("per_hour"), fields.get("shifts"), fields.get("endless")) {
        (Some(rate), None, None) => Ok(Arrival::Poisson(vec![Shift {
            until_secs: f64::INFINITY,
            per_hour: per_hour(rate)?,
        }])),
        (None, Some(shifts), None) => profile(shifts).map(Arrival::Poisson),
        (None, None, Some(orders)) => endless(orders).map(Arrival::Endless),
        _ => Err(value.error("a generator has one of per_hour, shifts, endless")),
    }
}

fn endless(orders: Value) -> Result<Option<usize>, InputError> {
    match orders.text()?.as_str() {
        "robots" => Ok(None),
        _ => Ok(Some(orders.integer(1_000_000)? as usize)),
    }
}

fn transports(value: Value, fields: &Fields, groups: &Groups) -> Result<Stops, InputError> {
    if fields.get("among").is_some() {
        return Err(value.error(
            "`among` is for an endless load of orders with one stop, without `from` and `to`",
        ));
    }
    let from = groups.find(fields.get("from"), Role::Pick)?;
    let to = groups.find(fields.get("to"), Role::Drop)?;
    if from.len() == 1 && from == to {
        return Err(value.error("`from` and `to` are the same single node"));
    }
    Ok(Stops::Two { from, to })
}

fn per_hour(value: Value) -> Result<f64, InputError> {
    match value.positive()? {
        rate if rate <= MAX_PER_HOUR => Ok(rate),
        rate => Err(value.error(format!("{rate} orders an hour are over {MAX_PER_HOUR}"))),
    }
}

fn profile(value: Value) -> Result<Vec<Shift>, InputError> {
    let mut shifts: Vec<Shift> = Vec::new();
    for shift in value.list()? {
        let fields = shift.fields(&["until", "per_hour"])?;
        let until_secs = fields.required("until")?.positive()?;
        if until_secs <= shifts.last().map_or(0.0, |last| last.until_secs) {
            return Err(shift.error("`until` must be after that of the shift before"));
        }
        shifts.push(Shift { until_secs, per_hour: per_hour(fields.required("per_hour")?)? });
    }
    if shifts.is_empty() { Err(value.error("there are no shifts")) } else { Ok(shifts) }
}

fn dwell(value: Value) -> Result<[f64; 2], InputError> {
    if !value.is_mapping() {
        return value.positive().map(|secs| [secs; 2]);
    }
    let fields = value.fields(&["min", "max"])?;
    let range = [fields.required("min")?.positive()?, fields.required("max")?.positive()?];
    if range[0] <= range[1] { Ok(range) } else { Err(value.error("`min` is above `max`")) }
}

/// The named groups of nodes.
struct Groups<'places> {
    named: BTreeMap<String, Vec<u32>>,
    places: &'places Places,
}

impl<'places> Groups<'places> {
    fn read(groups: Option<Value>, places: &'places Places) -> Result<Self, InputError> {
        let pairs = groups.map(Value::pairs).transpose()?.unwrap_or_default();
        let mut named = BTreeMap::new();
        for (name, value) in pairs {
            named.insert(name, group(value, places)?);
        }
        Ok(Self { named, places })
    }

    /// Returns the nodes that a field names, or those of the role, or all if none has it; but no
    /// chargers.
    fn find(&self, field: Option<Value>, role: Role) -> Result<Vec<u32>, InputError> {
        let Some(field) = field else {
            let nodes = self.with_role(role);
            let any = || self.places.nodes(|place| place.role != Role::Charge);
            return Ok(if nodes.is_empty() || role == Role::None { any() } else { nodes });
        };
        let name = field.text()?;
        let role =
            Role::ALL.into_iter().find(|role| role.name() == name).map(|role| self.with_role(role));
        match self.named.get(&name).cloned().or(role) {
            Some(nodes) if !nodes.is_empty() => Ok(nodes),
            Some(_) => Err(field.error(format!("no node has the role `{name}`"))),
            None => Err(field.error(format!("`{name}` is neither a group nor a role"))),
        }
    }

    fn with_role(&self, role: Role) -> Vec<u32> {
        self.places.nodes(|place| place.role == role)
    }
}

fn group(value: Value, places: &Places) -> Result<Vec<u32>, InputError> {
    let nodes = if value.is_mapping() { matching(value, places)? } else { listed(value, places)? };
    if nodes.is_empty() { Err(value.error("no node is in this group")) } else { Ok(nodes) }
}

fn listed(value: Value, places: &Places) -> Result<Vec<u32>, InputError> {
    let mut nodes = Vec::new();
    for item in value.list()? {
        let label = item.text()?;
        nodes.push(places.find(&label).ok_or_else(|| {
            item.error(format!("`{label}` is neither the name nor the id of a node"))
        })?);
    }
    Ok(nodes)
}

fn matching(value: Value, places: &Places) -> Result<Vec<u32>, InputError> {
    let fields = value.fields(&["role", "zone"])?;
    let role = |value: Value| {
        let name = value.text()?;
        let role = Role::ALL.into_iter().find(|role| role.name() == name);
        role.ok_or_else(|| value.error(format!("unknown role `{name}`")))
    };
    let role = fields.optional("role", role)?;
    let zone = fields.optional("zone", Value::text)?;
    let fits = |place: &super::places::Place| {
        role.is_none_or(|role| place.role == role)
            && zone.as_ref().is_none_or(|zone| place.zone == *zone)
    };
    Ok(places.nodes(fits))
}
