//! Stations: whom and what robots wait for at stops, beside other robots.
//!
//! ```yaml
//! load:
//!   stations:
//!     - at: [S1, S2, S3]                # nodes, as in a generator's `from`
//!       operators: 2                    # robots that are served there at the same time
//!       changeover: {min: 5, max: 10}   # seconds until an operator serves the next robot
//!       open: [{from: 0, until: 14400}, {from: 16200, until: 30600}]
//!       every: 86400                    # seconds after which opening times come again
//!     - at: out
//!       buffer: {places: 4, cycle: 30}  # loads that find room; seconds in which one is taken away
//!       queue: [Q1, Q2]               # nodes where robots wait for this node, the nearest first
//! ```
//!
//! Robots are served in the order of their arrival. A service begins as soon as an operator is
//! free, the buffer has a place for a load to drop, and the station is open. Its end is known at
//! its begin: it takes the dwell time of the stop.

use std::collections::{BTreeMap, VecDeque};

use regatta_base::random::Random;
use regatta_base::yaml::{self, Fields, Node};
use regatta_plugin::world::Role;

use super::distribution::Distribution;
use super::load::Groups;
use super::order::{Action, Stop};

/// The random numbers of stations; those of generators are parts 1, 2 … of the seed, and those of
/// timetables the last part.
const STATIONS: u64 = u64::MAX - 1;
const CHANGEOVER: u64 = 0;
const CYCLE: u64 = 1;
/// The most operators of a station, and the most places of a buffer.
const MOST_OPERATORS: u64 = 10_000;

/// Stations that share operators, opening times and a buffer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct StationSettings {
    /// Indices of nodes.
    at: Vec<u32>,
    /// The number of robots that are served at the same time; any number without.
    operators: Option<usize>,
    changeover: Distribution,
    hours: Option<Hours>,
    buffer: Option<Buffer>,
    /// The nodes where robots wait for the only node of the station, the nearest first.
    queue: Vec<u32>,
}

/// Opening times.
#[derive(Clone, Debug, PartialEq)]
struct Hours {
    /// In ascending order, in seconds from the start of a period; at least one.
    windows: Vec<Window>,
    /// The seconds after which they come again; never if infinite.
    every_secs: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Window {
    from_secs: f64,
    until_secs: f64,
}

/// A place for loads that were dropped, which are taken away one at a time.
#[derive(Clone, Debug, PartialEq)]
struct Buffer {
    places: usize,
    cycle: Distribution,
}

/// The service of a robot at a stop, in simulated seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Service {
    /// Its begin: the robot has waited until then.
    pub begin_secs: f64,
    /// Its end.
    pub end_secs: f64,
}

/// All stations with settings, and the services so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Stations {
    groups: Vec<Group>,
    /// The group of a node.
    by_node: BTreeMap<u32, usize>,
}

#[derive(Clone, Debug)]
struct Group {
    settings: StationSettings,
    random: Random,
    /// The number of services so far.
    served: u64,
    /// By operator: the time from which on it is free.
    free_secs: Vec<f64>,
    /// The times at which the loads of a full buffer are gone, or fewer.
    gone_secs: VecDeque<f64>,
}

impl Stations {
    /// Makes stations that nobody has come to yet.
    pub(super) fn new(settings: &[StationSettings], seed: u64) -> Self {
        let random = Random::new(seed).part(STATIONS);
        let mut stations = Self::default();
        for (index, settings) in settings.iter().enumerate() {
            stations.by_node.extend(settings.at.iter().map(|node| (*node, index)));
            stations.groups.push(Group {
                random: random.part(index as u64),
                served: 0,
                free_secs: vec![0.0; settings.operators.unwrap_or(0)],
                gone_secs: VecDeque::new(),
                settings: settings.clone(),
            });
        }
        stations
    }

    /// The nodes of stations with a queue, and the nodes of the queue, the nearest first.
    pub(super) fn queues(&self) -> impl Iterator<Item = (u32, &[u32])> {
        let queues = self.groups.iter().map(|group| &group.settings);
        queues
            .filter(|station| !station.queue.is_empty())
            .filter_map(|station| station.at.first().map(|node| (*node, station.queue.as_slice())))
    }

    /// The same stations, to which nobody has come yet.
    pub(super) fn unused(&self) -> Self {
        let mut stations = self.clone();
        for group in &mut stations.groups {
            group.served = 0;
            group.free_secs.fill(0.0);
            group.gone_secs.clear();
        }
        stations
    }

    /// Begins the service of a robot that has come to a stop.
    pub(super) fn serve(&mut self, stop: &Stop, now_secs: f64) -> Service {
        match self.by_node.get(&stop.node) {
            Some(index) => self.groups[*index].serve(stop, now_secs),
            None => Service { begin_secs: now_secs, end_secs: now_secs + stop.dwell_secs },
        }
    }
}

impl Group {
    fn serve(&mut self, stop: &Stop, now_secs: f64) -> Service {
        let random = self.random.part(self.served);
        self.served += 1;
        let operator = self.free_secs.iter_mut().min_by(|a, b| a.total_cmp(b));
        let is_dropped = stop.action == Action::Drop;
        let mut begin_secs = operator.as_ref().map_or(now_secs, |free| now_secs.max(**free));
        if let Some(buffer) = self.settings.buffer.as_ref().filter(|_| is_dropped)
            && self.gone_secs.len() == buffer.places
        {
            // The load that is gone first leaves the place.
            begin_secs = begin_secs.max(self.gone_secs.pop_front().unwrap_or(begin_secs));
        }
        if let Some(hours) = &self.settings.hours {
            begin_secs = hours.open_from(begin_secs);
        }
        let end_secs = begin_secs + stop.dwell_secs;
        if let Some(free) = operator {
            *free = end_secs + self.settings.changeover.secs(random, CHANGEOVER);
        }
        if let Some(buffer) = self.settings.buffer.as_ref().filter(|_| is_dropped) {
            let last_secs = self.gone_secs.back().map_or(end_secs, |last| end_secs.max(*last));
            self.gone_secs.push_back(last_secs + buffer.cycle.secs(random, CYCLE));
        }
        Service { begin_secs, end_secs }
    }
}

impl Hours {
    /// Returns the first time from a time on at which the station is open; infinity if it never
    /// opens again.
    fn open_from(&self, secs: f64) -> f64 {
        let period =
            if self.every_secs.is_finite() { (secs / self.every_secs).floor() } else { 0.0 };
        let period_secs = if period > 0.0 { period * self.every_secs } else { 0.0 };
        let of_period = secs - period_secs;
        match self.windows.iter().find(|window| of_period < window.until_secs) {
            Some(window) => period_secs + of_period.max(window.from_secs),
            None => period_secs + self.every_secs + self.windows[0].from_secs,
        }
    }
}

/// Reads the stations of a load.
pub(super) fn read(list: &Node, groups: &Groups<'_>) -> Result<Vec<StationSettings>, yaml::Error> {
    let (mut stations, mut known) = (Vec::new(), BTreeMap::new());
    for (value, number) in list.list()?.iter().zip(1..) {
        let station = station(value, groups)?;
        for node in &station.at {
            if let Some(other) = known.insert(*node, number) {
                let id = groups.places.place(*node).id;
                return Err(value.error(format!(
                    "node {id} is in this entry and in entry {other}; name it in one of them"
                )));
            }
        }
        stations.push(station);
    }
    Ok(stations)
}

fn station(value: &Node, groups: &Groups<'_>) -> Result<StationSettings, yaml::Error> {
    let fields =
        value.fields(&["at", "operators", "changeover", "open", "every", "buffer", "queue"])?;
    let mut at = groups.find(Some(fields.required("at")?), Role::None)?;
    at.sort_unstable();
    at.dedup();
    let operators = fields.optional("operators", |value| at_least_one(value, "operator"))?;
    if operators.is_none() && fields.get("changeover").is_some() {
        return Err(value.error("`changeover` is the time of an operator: give `operators`, too"));
    }
    Ok(StationSettings {
        operators,
        changeover: fields.optional("changeover", Distribution::read)?.unwrap_or_default(),
        hours: hours(value, &fields)?,
        queue: queue(&fields, &at, groups)?,
        buffer: fields.optional("buffer", buffer)?,
        at,
    })
}

/// Reads the nodes of a queue, in their order.
fn queue(
    fields: &Fields<'_, '_>,
    at: &[u32],
    groups: &Groups<'_>,
) -> Result<Vec<u32>, yaml::Error> {
    let Some(list) = fields.get("queue") else { return Ok(Vec::new()) };
    if at.len() != 1 {
        return Err(
            list.error("a queue belongs to a single node: give each node an entry of its own")
        );
    }
    let mut nodes = Vec::new();
    for entry in list.list()? {
        let found = groups.places.find_one(&entry.text()?);
        let node = found.map_err(|error| entry.error(error.to_string()))?;
        if at.contains(&node) || nodes.contains(&node) {
            return Err(entry.error("this node is the station, or twice in its queue"));
        }
        nodes.push(node);
    }
    if nodes.is_empty() { Err(list.error("there are no places in the queue")) } else { Ok(nodes) }
}

fn buffer(value: &Node) -> Result<Buffer, yaml::Error> {
    let fields = value.fields(&["places", "cycle"])?;
    Ok(Buffer {
        places: at_least_one(fields.required("places")?, "place")?,
        cycle: Distribution::read(fields.required("cycle")?)?,
    })
}

fn at_least_one(value: &Node, of: &str) -> Result<usize, yaml::Error> {
    match value.integer(MOST_OPERATORS)? {
        0 => Err(value.error(format!("give at least one {of}"))),
        count => Ok(count as usize),
    }
}

fn hours(value: &Node, fields: &Fields<'_, '_>) -> Result<Option<Hours>, yaml::Error> {
    let every_secs = fields.optional("every", Node::non_negative)?;
    let Some(list) = fields.get("open") else {
        return match every_secs {
            None => Ok(None),
            Some(_) => Err(value.error("`every` repeats opening times: give `open`, too")),
        };
    };
    let mut windows: Vec<Window> = Vec::new();
    for entry in list.list()? {
        let window = window(entry)?;
        if windows.last().is_some_and(|last| window.from_secs < last.until_secs) {
            return Err(entry.error("opening times have to be in ascending order"));
        }
        windows.push(window);
    }
    let Some(last) = windows.last() else { return Err(list.error("there are no opening times")) };
    if every_secs.is_some_and(|every_secs| every_secs < last.until_secs) {
        return Err(value.error("`every` is shorter than the opening times that it repeats"));
    }
    Ok(Some(Hours { windows, every_secs: every_secs.unwrap_or(f64::INFINITY) }))
}

fn window(value: &Node) -> Result<Window, yaml::Error> {
    let fields = value.fields(&["from", "until"])?;
    let from_secs = fields.required("from")?.non_negative()?;
    let until_secs = fields.required("until")?.non_negative()?;
    if from_secs >= until_secs {
        return Err(value.error("`until` has to be later than `from`"));
    }
    Ok(Window { from_secs, until_secs })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::Load;
    use crate::places::{Place, Places};

    fn load(stations: &str) -> Result<Load, String> {
        let place = |id| Place { id, name: format!("S{id}"), ..Place::default() };
        let places = Places::new((0..4).map(place).collect());
        Load::parse(&format!("load: {{per_hour: 1, stations: {stations}}}"), &places)
            .map_err(|error| error.to_string())
    }

    fn stations(text: &str) -> Stations {
        let load = load(text).expect("stations");
        Stations::new(&load.stations, load.seed)
    }

    /// Serves robots that come to nodes at times, and stay for 10 s. Returns the begins and ends.
    fn services(stations: &mut Stations, arrivals: &[(u32, f64)]) -> Vec<(f64, f64)> {
        let mut services = Vec::new();
        for &(node, now_secs) in arrivals {
            let stop = Stop { node, action: Action::Drop, dwell_secs: 10.0 };
            let Service { begin_secs, end_secs } = stations.serve(&stop, now_secs);
            services.push((begin_secs, end_secs));
        }
        services
    }

    #[test]
    fn operators_serve_robots_in_the_order_of_their_arrival() {
        let mut one = stations("[{at: [S0, S1], operators: 1, changeover: 5}]");
        let found = services(&mut one, &[(0, 100.0), (1, 101.0), (2, 102.0), (0, 200.0)]);
        assert_eq!(found, [(100.0, 110.0), (115.0, 125.0), (102.0, 112.0), (200.0, 210.0)]);
        let mut two = stations("[{at: [S0, S1, S2], operators: 2}]");
        let found = services(&mut two, &[(0, 0.0), (1, 4.0), (2, 5.0)]);
        assert_eq!(found, [(0.0, 10.0), (4.0, 14.0), (10.0, 20.0)]);
        let found = services(&mut two.unused(), &[(0, 0.0), (1, 4.0)]);
        assert_eq!(found, [(0.0, 10.0), (4.0, 14.0)], "nobody has come yet");
    }

    #[test]
    fn a_full_buffer_blocks_until_a_load_is_taken_away() {
        let mut buffer = stations("[{at: S0, buffer: {places: 2, cycle: 60}}]");
        // Loads lie there from 10, 20 and so on; they are gone at 70, 130, 190, 250.
        let found = services(&mut buffer, &[(0, 0.0), (0, 10.0), (0, 20.0), (0, 80.0)]);
        assert_eq!(found, [(0.0, 10.0), (10.0, 20.0), (70.0, 80.0), (130.0, 140.0)]);
        let pick = Stop { node: 0, action: Action::Pick, dwell_secs: 1.0 };
        assert_eq!(buffer.serve(&pick, 141.0).begin_secs, 141.0, "a pick needs no place");
    }

    #[test]
    fn a_service_begins_while_the_station_is_open() {
        let hours = "open: [{from: 100, until: 200}, {from: 300, until: 400}], every: 1000";
        let mut open = stations(&format!("[{{at: S0, {hours}}}]"));
        let times = [0.0, 150.0, 199.0, 200.0, 400.0, 1050.0, 1350.0];
        let found = services(&mut open, &times.map(|secs| (0, secs)));
        let begins: Vec<f64> = found.iter().map(|(begin, _)| *begin).collect();
        assert_eq!(begins, [100.0, 150.0, 199.0, 300.0, 1100.0, 1100.0, 1350.0]);
        let mut once = stations("[{at: S0, open: [{from: 100, until: 200}]}]");
        assert_eq!(services(&mut once, &[(0, 500.0)])[0].0, f64::INFINITY);
    }

    /// An operator with services of 10 s is a queue M/D/1: with a utilisation of a half, robots
    /// wait for a quarter of the mean time between arrivals (Pollaczek and Khinchine).
    #[test]
    fn waits_are_those_of_queueing_theory() {
        let mut station = stations("[{at: S0, operators: 1}]");
        let (random, mut now_secs, mut waited_secs) = (Random::new(1), 0.0, 0.0);
        let robots = 200_000;
        for robot in 0..robots {
            now_secs += 20.0 * random.exponential(robot);
            waited_secs += services(&mut station, &[(0, now_secs)])[0].0 - now_secs;
        }
        let mean_secs = waited_secs / robots as f64;
        assert!((mean_secs - 5.0).abs() < 0.15, "{mean_secs}");
    }

    #[test]
    fn what_is_wrong_is_refused_with_the_reason() {
        for (text, reason) in [
            ("[{operators: 1}]", "`at` is missing"),
            ("[{at: S9}]", "`S9` is neither"),
            ("[{at: S0, operators: 0}]", "at least one operator"),
            ("[{at: S0, changeover: 5}]", "give `operators`, too"),
            ("[{at: S0, every: 5}]", "give `open`, too"),
            ("[{at: S0, open: []}]", "no opening times"),
            ("[{at: S0, open: [{from: 5, until: 5}]}]", "later than `from`"),
            ("[{at: S0, open: [{from: 5, until: 9}, {from: 8, until: 10}]}]", "ascending"),
            ("[{at: S0, open: [{from: 5, until: 9}], every: 8}]", "shorter than"),
            ("[{at: S0, buffer: {places: 0, cycle: 5}}]", "at least one place"),
            ("[{at: [S0, S1], queue: [S2]}]", "a single node"),
            ("[{at: S0, queue: [S1, S0]}]", "this node is the station"),
            ("[{at: S0, queue: [S1, S1]}]", "twice in its queue"),
            ("[{at: S0, queue: []}]", "no places in the queue"),
            ("[{at: S0}, {at: [S1, S0]}]", "node 0 is in this entry and in entry 1"),
        ] {
            let error = load(text).expect_err(text);
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
