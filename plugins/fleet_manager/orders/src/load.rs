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
//!       # flows: [{from: A1, to: north, share: 3}, {from: A2, to: S7}]  # in place of from and to
//!       via: [wrapping]              # groups of stops between the two
//!       per_hour: 120                # Poisson; or a profile that begins anew after its end:
//!       # shifts: [{until: 3600, per_hour: 200}, {until: 7200, per_hour: 20}]
//!       # gaps: {min: 20, max: 40}   # or the seconds between arrivals, a distribution
//!       batch: {min: 1, max: 4}      # orders that come at the same time; or a number; 1 if absent
//!       priority: 5                  # 0 to 255, 0 if absent
//!       robot_types: [forklift]      # for robots of these types; or one name; any if absent
//!       dwell: {min: 5, max: 15}     # seconds at each stop, a distribution; 0 if absent
//!       deadline: 900                # seconds after its creation; none if absent
//!     - endless: robots              # as many open orders as there are robots, or a number
//!       among: north                 # orders with one stop of this group; any node if absent
//!     - endless: 50
//!       from: inbound                # orders with two stops, as above
//!       to: north
//! ```
//!
//! A generator may also be a file of orders ([`timetable`](super::timetable)). The key `stations`
//! has operators, opening times, buffers and queues ([`stations`]); `storages` has places that are
//! full or empty ([`storages`]).
//!
//! A generator's fields may also stand beside `seed` and `groups`, if there is only one. A file may
//! have further keys beside `load`: it may be a scenario.

mod arrival;
mod groups;
mod stops;

use std::path::Path;

use regatta_base::yaml::{self, Fields, Node};

use self::arrival::batch;
pub(super) use self::arrival::{Arrival, Batch, Shift};
pub(super) use self::groups::Groups;
#[cfg(test)]
pub(super) use self::stops::Flow;
pub(super) use self::stops::{Stops, Transport};
use super::dwell::Dwell;
use super::file::{FileError, text_of, texts};
use super::places::Places;
use super::stations::{self, StationSettings};
use super::storages::{self, StorageSettings};
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
    /// Stations with operators, opening times or buffers.
    pub(super) stations: Vec<StationSettings>,
    /// Storages, whose places are full or empty.
    pub(super) storages: Vec<StorageSettings>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct GeneratorSettings {
    pub(super) name: String,
    pub(super) arrival: Arrival,
    pub(super) batch: Batch,
    pub(super) stops: Stops,
    pub(super) priority: u8,
    pub(super) dwell: Dwell,
    pub(super) deadline_secs: Option<f64>,
    /// The robot types that may get the orders; any may if empty.
    pub(super) robot_types: Vec<u32>,
}

const LOAD_FIELDS: [&str; 5] = ["seed", "groups", "generators", "stations", "storages"];
const GENERATOR_FIELDS: [&str; 20] = [
    "name",
    "from",
    "to",
    "via",
    "flows",
    "per_hour",
    "shifts",
    "gaps",
    "batch",
    "priority",
    "robot_types",
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
        Self::parse_beside(Some(folder), &text_of(path)?, places)
            .map_err(|error| FileError::Invalid { path: path.to_owned(), error })
    }

    /// Parses the load of a text, which can't name files.
    ///
    /// # Errors
    /// [`yaml::Error`] for the first thing that is wrong.
    pub fn parse(text: &str, places: &Places) -> Result<Self, yaml::Error> {
        Self::parse_beside(None, text, places)
    }

    /// Parses the load of a text, whose files of orders lie in a folder; without one, it can't name
    /// files.
    ///
    /// # Errors
    /// [`yaml::Error`] for the first thing that is wrong, in the text or in a file.
    pub fn parse_beside(
        folder: Option<&Path>,
        text: &str,
        places: &Places,
    ) -> Result<Self, yaml::Error> {
        let document = yaml::parse(text)?;
        let fields = document.all_fields()?;
        load(fields.get("load").unwrap_or(&document), folder, places)
    }

    /// Returns the places with the storages of a text's load, which orders may name. Nothing else
    /// of the load is read.
    ///
    /// # Errors
    /// [`yaml::Error`] for the first thing that is wrong with them.
    pub fn places(text: &str, places: &Places) -> Result<Places, yaml::Error> {
        let document = yaml::parse(text)?;
        let fields = document.all_fields()?;
        let load = fields.get("load").unwrap_or(&document).all_fields()?;
        let groups = Groups::read(load.get("groups"), places)?;
        let storages = load.optional("storages", |list| storages::read(list, &groups))?;
        Ok(storages::places(places, &storages.unwrap_or_default()))
    }
}

fn load(load: &Node, folder: Option<&Path>, places: &Places) -> Result<Load, yaml::Error> {
    let all: Vec<_> = LOAD_FIELDS.into_iter().chain(GENERATOR_FIELDS).collect();
    let fields = load.fields(&all)?;
    let groups = Groups::read(fields.get("groups"), places)?;
    let storages = fields.optional("storages", |list| storages::read(list, &groups))?;
    let storages = storages.unwrap_or_default();
    let groups = groups.with_nodes_of(&storages);
    let seed = fields.optional("seed", |value| value.integer(i64::MAX as u64))?.unwrap_or(0);
    let stations = fields.optional("stations", |list| stations::read(list, &groups))?;
    let places = &storages::places(places, &storages);
    let groups = groups.with_storages(&storages, places);
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
        None => {
            let stations = stations.unwrap_or_default();
            Ok(Load { seed, generators, timetables, stations, storages })
        }
    }
}

fn generator(
    value: &Node,
    fields: &Fields<'_, '_>,
    number: usize,
    groups: &Groups,
) -> Result<GeneratorSettings, yaml::Error> {
    let name = fields.optional("name", generator_name)?.unwrap_or_else(|| number.to_string());
    let arrival = Arrival::read(value, fields)?;
    Ok(GeneratorSettings {
        name,
        batch: batch(fields, &arrival)?,
        stops: Stops::read(value, fields, &arrival, groups)?,
        arrival,
        priority: fields.optional("priority", |value| value.integer(255))?.unwrap_or(0) as u8,
        dwell: fields
            .optional("dwell", |value| Dwell::read(value, groups.places))?
            .unwrap_or_default(),
        deadline_secs: fields.optional("deadline", Node::non_negative)?,
        robot_types: robot_types(fields, groups.places)?,
    })
}

/// Reads the robot types of a generator, if it names some.
pub(super) fn robot_types(
    fields: &Fields<'_, '_>,
    places: &Places,
) -> Result<Vec<u32>, yaml::Error> {
    let types = fields.optional("robot_types", |value| {
        let found = places.robot_types(&texts(value)?);
        found.map_err(|error| value.error(error.to_string()))
    })?;
    Ok(types.unwrap_or_default())
}

fn generator_name(value: &Node) -> Result<String, yaml::Error> {
    let name = value.text()?;
    let is_plain = name.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c));
    if is_plain && (1..=64).contains(&name.len()) {
        return Ok(name.into_owned());
    }
    Err(value.error("the name of a generator has 1 to 64 letters, digits, `_`, `-`, `.`"))
}
