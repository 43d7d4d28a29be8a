//! Descriptions of loads: generators of a plant's orders.
//!
//! ```yaml
//! load:
//!   seed: 7                          # 0 if absent
//!   groups:                          # named groups of nodes
//!     inbound: [A1, A2, 17]          # by name or id
//!     north: {zone: north, role: drop}
//!   generators:
//!     - name: deliveries             # for orders load:deliveries-1 …; its number if absent
//!       from: inbound                # a group, a role, a node or a list of nodes; the role pick,
//!                                    # or any node, if absent
//!       to: north                    # likewise, with the role drop
//!       per_hour: 120                # Poisson; or a profile that begins anew after its end:
//!       # shifts: [{until: 3600, per_hour: 200}, {until: 7200, per_hour: 20}]
//!       priority: 5                  # 0 to 255, 0 if absent
//!       dwell: {min: 5, max: 15}     # seconds at each stop, uniform; or a number; 0 if absent
//!       deadline: 900                # seconds after its creation; none if absent
//!     - endless: robots              # as many open orders as there are robots, or a number
//!       among: north                 # orders with one stop of this group; any node if absent
//!     - endless: 50
//!       from: inbound                # orders with two stops, as above
//!       to: north
//! ```
//!
//! A generator may also be a file of orders ([`timetable`](super::timetable)).
//!
//! A generator's fields may also stand beside `seed` and `groups`, if there is only one. A file may
//! have further keys beside `load`: it may be a scenario.

use std::collections::BTreeMap;
use std::path::Path;

use regatta_base::yaml::{self, Fields, Node};
use regatta_plugin::world::Role;

use super::file::{FileError, text_of};
use super::places::{PlaceError, Places};
use super::timetable::Timetable;

/// A valid description of a load.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Load {
    /// The seed of all random numbers.
    pub seed: u64,
    /// The generators.
    pub(super) generators: Vec<GeneratorSettings>,
    /// The timetables.
    pub(super) timetables: Vec<Timetable>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct GeneratorSettings {
    pub(super) name: String,
    pub(super) arrival: Arrival,
    pub(super) stops: Stops,
    pub(super) priority: u8,
    pub(super) dwell_secs: DwellSecs,
    pub(super) deadline_secs: Option<f64>,
}

/// The shortest and the longest dwell time, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct DwellSecs {
    pub(super) min: f64,
    pub(super) max: f64,
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
const GENERATOR_FIELDS: [&str; 15] = [
    "name",
    "from",
    "to",
    "per_hour",
    "shifts",
    "priority",
    "dwell",
    "deadline",
    "endless",
    "among",
    "orders",
    "timetable",
    "scale",
    "shift",
    "resample",
];

impl Load {
    /// Reads the load of a file.
    ///
    /// # Errors
    /// [`FileError`] if it can't be read or has an error.
    pub fn read(path: &Path, places: &Places) -> Result<Self, FileError> {
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse_in(Some(folder), &text_of(path)?, places)
            .map_err(|error| FileError::Invalid { path: path.to_owned(), error })
    }

    /// Parses the load of a text, which can't name files.
    ///
    /// # Errors
    /// [`yaml::Error`] for the first thing that is wrong.
    pub fn parse(text: &str, places: &Places) -> Result<Self, yaml::Error> {
        Self::parse_in(None, text, places)
    }

    fn parse_in(folder: Option<&Path>, text: &str, places: &Places) -> Result<Self, yaml::Error> {
        let document = yaml::parse(text)?;
        let fields = document.all_fields()?;
        load(fields.get("load").unwrap_or(&document), folder, places)
    }
}

fn load(load: &Node, folder: Option<&Path>, places: &Places) -> Result<Load, yaml::Error> {
    let all: Vec<_> = LOAD_FIELDS.into_iter().chain(GENERATOR_FIELDS).collect();
    let fields = load.fields(&all)?;
    let groups = Groups::read(fields.get("groups"), places)?;
    let seed = fields.optional("seed", |value| value.integer(i64::MAX as u64))?.unwrap_or(0);
    let mut entries = Vec::new();
    match fields.get("generators") {
        None => entries.push((load, fields)),
        Some(list) => {
            load.fields(&LOAD_FIELDS)?;
            for value in list.list()? {
                entries.push((value, value.fields(&GENERATOR_FIELDS)?));
            }
        }
    }
    let (mut generators, mut timetables) = (Vec::new(), Vec::new());
    for ((value, fields), number) in entries.iter().zip(1..) {
        match Timetable::read(value, fields, folder, places)? {
            Some(timetable) => timetables.push(timetable),
            None => generators.push(generator(value, fields, number, &groups)?),
        }
    }
    let mut names: Vec<_> = generators.iter().map(|generator| &generator.name).collect();
    names.sort();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(load.error(format!("two generators have the name `{}`", pair[0]))),
        None => Ok(Load { seed, generators, timetables }),
    }
}

fn generator(
    value: &Node,
    fields: &Fields<'_, '_>,
    number: usize,
    groups: &Groups,
) -> Result<GeneratorSettings, yaml::Error> {
    let name = fields.optional("name", generator_name)?.unwrap_or_else(|| number.to_string());
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
    let deadline_secs = fields.optional("deadline", Node::non_negative)?;
    Ok(GeneratorSettings { name, arrival, stops, priority, dwell_secs, deadline_secs })
}

fn generator_name(value: &Node) -> Result<String, yaml::Error> {
    let name = value.text()?;
    let is_plain = name.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c));
    if is_plain && (1..=64).contains(&name.len()) {
        return Ok(name.into_owned());
    }
    Err(value.error("the name of a generator has 1 to 64 letters, digits, `_`, `-`, `.`"))
}

fn arrival(value: &Node, fields: &Fields<'_, '_>) -> Result<Arrival, yaml::Error> {
    match (fields.get("per_hour"), fields.get("shifts"), fields.get("endless")) {
        (Some(rate), None, None) => Ok(Arrival::Poisson(vec![Shift {
            until_secs: f64::INFINITY,
            per_hour: per_hour(rate)?,
        }])),
        (None, Some(shifts), None) => profile(shifts).map(Arrival::Poisson),
        (None, None, Some(orders)) => endless(orders).map(Arrival::Endless),
        _ => Err(value.error("give a generator exactly one of per_hour, shifts and endless")),
    }
}

fn endless(orders: &Node) -> Result<Option<usize>, yaml::Error> {
    match orders.text()?.as_ref() {
        "robots" => Ok(None),
        _ => Ok(Some(orders.integer(1_000_000)? as usize)),
    }
}

fn transports(
    value: &Node,
    fields: &Fields<'_, '_>,
    groups: &Groups,
) -> Result<Stops, yaml::Error> {
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

fn per_hour(value: &Node) -> Result<f64, yaml::Error> {
    match value.non_negative()? {
        rate if rate <= MAX_PER_HOUR => Ok(rate),
        rate => {
            Err(value
                .error(format!("{rate} orders an hour are too many; give at most {MAX_PER_HOUR}")))
        }
    }
}

fn profile(value: &Node) -> Result<Vec<Shift>, yaml::Error> {
    let mut shifts: Vec<Shift> = Vec::new();
    for shift in value.list()? {
        let fields = shift.fields(&["until", "per_hour"])?;
        let until_secs = fields.required("until")?.non_negative()?;
        if until_secs <= shifts.last().map_or(0.0, |last| last.until_secs) {
            return Err(shift.error("`until` must be later than that of the previous shift"));
        }
        shifts.push(Shift { until_secs, per_hour: per_hour(fields.required("per_hour")?)? });
    }
    if shifts.is_empty() { Err(value.error("there are no shifts")) } else { Ok(shifts) }
}

pub(super) fn dwell(value: &Node) -> Result<DwellSecs, yaml::Error> {
    if !value.is_map() {
        return value.non_negative().map(|secs| DwellSecs { min: secs, max: secs });
    }
    let fields = value.fields(&["min", "max"])?;
    let min = fields.required("min")?.non_negative()?;
    let max = fields.required("max")?.non_negative()?;
    if min <= max { Ok(DwellSecs { min, max }) } else { Err(value.error("`min` is above `max`")) }
}

/// The named groups of nodes.
struct Groups<'places> {
    named: BTreeMap<String, Vec<u32>>,
    places: &'places Places,
}

impl<'places> Groups<'places> {
    fn read(groups: Option<&Node>, places: &'places Places) -> Result<Self, yaml::Error> {
        let pairs = groups.map(Node::pairs).transpose()?.unwrap_or_default();
        let mut named = BTreeMap::new();
        for (name, value) in pairs {
            named.insert(name.into_owned(), group(value, places)?);
        }
        Ok(Self { named, places })
    }

    /// Returns the nodes that a field names, or those of the role, or all if none has it; but no
    /// chargers.
    fn find(&self, field: Option<&Node>, role: Role) -> Result<Vec<u32>, yaml::Error> {
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
