//! Zones: groups of nodes and edges with a rule for the robots in them.

use std::collections::BTreeMap;

use regatta_plugin::World;
use regatta_plugin::world::{ZoneRecord, ZoneRule};

use crate::findings::{Finding, Findings, Kind};
use crate::motion::Row;
use crate::orders::Now;
use crate::world_model::WorldModel;

/// The distance along its edge from a node up to which a robot is at it, in metres.
const AT_NODE: f32 = 0.005;
/// The same for a robot on no edge.
const NEAR_NODE: f64 = 0.05;

/// The zones of a world that a robot may be in.
#[derive(Debug, Default)]
pub(crate) struct ZoneTable {
    /// With their names.
    zones: Vec<(ZoneRecord, String)>,
    /// By edge.
    of_edges: BTreeMap<u32, Vec<usize>>,
    /// By node.
    of_nodes: BTreeMap<u32, Vec<usize>>,
}

impl ZoneTable {
    pub fn new(world: &World<'_>) -> Self {
        let mut table = Self::default();
        for (index, zone) in world.zones().iter().enumerate() {
            for &node in world.zone_nodes(zone) {
                table.of_nodes.entry(node).or_default().push(index);
            }
            for &edge in world.zone_edges(zone) {
                table.of_edges.entry(edge).or_default().push(index);
            }
            table.zones.push((*zone, world.text(zone.name).to_owned()));
        }
        table
    }

    pub fn is_empty(&self) -> bool {
        self.zones.is_empty()
    }
}

/// A robot in a zone.
#[derive(Clone, Copy, Debug)]
struct Inside {
    robot: u32,
    /// The node at which it entered, by index.
    entry: u32,
    /// The edge that it is on, by index.
    edge: u32,
}

/// The robots in a zone.
#[derive(Debug, Default)]
struct Occupants {
    before: Vec<Inside>,
    now: Vec<Inside>,
    /// Whether the rule was broken in the frame before: a breach that lasts counts once.
    is_broken: bool,
}

/// The robots in all zones, frame by frame.
#[derive(Debug, Default)]
pub(crate) struct Zones {
    by_zone: Vec<Occupants>,
}

impl Zones {
    /// Begins a frame.
    pub fn begin_frame(&mut self, world: &WorldModel) {
        self.by_zone.resize_with(world.zones.zones.len(), Occupants::default);
        for occupants in &mut self.by_zone {
            std::mem::swap(&mut occupants.before, &mut occupants.now);
            occupants.now.clear();
        }
    }

    /// Takes a robot of the frame; in ascending order of robots.
    pub fn take(&mut self, world: &WorldModel, robot: u32, row: &Row) {
        let table = &world.zones;
        if table.is_empty() {
            return;
        }
        let Some(edge) = world.edge(row.edge) else {
            for (&node, zones) in &table.of_nodes {
                if world.distance_to_node(node, row) <= NEAR_NODE {
                    self.enter_all(zones, Inside { robot, entry: node, edge: row.edge });
                }
            }
            return;
        };
        let ends =
            [(row.s, edge.record.origin), (edge.record.length - row.s, edge.record.destination)];
        for (_, node) in ends.into_iter().filter(|(metres, _)| *metres <= AT_NODE) {
            if let Some(zones) = table.of_nodes.get(&node) {
                self.enter_all(zones, Inside { robot, entry: node, edge: row.edge });
            }
        }
        let backs = row.speed < 0.0;
        let entry = if backs { edge.record.destination } else { edge.record.origin };
        let is_between = row.s > AT_NODE && row.s < edge.record.length - AT_NODE;
        if let Some(zones) = table.of_edges.get(&row.edge).filter(|_| is_between) {
            self.enter_all(zones, Inside { robot, entry, edge: row.edge });
        }
    }

    fn enter_all(&mut self, zones: &[usize], inside: Inside) {
        for &zone in zones {
            let Occupants { before, now, .. } = &mut self.by_zone[zone];
            if now.last().is_some_and(|last| last.robot == inside.robot) {
                continue;
            }
            let known = before.binary_search_by_key(&inside.robot, |before| before.robot);
            let entry = known.map_or(inside.entry, |index| before[index].entry);
            now.push(Inside { entry, ..inside });
        }
    }

    /// Adds the zones whose rule is broken to the findings, once for each breach.
    pub fn judge(&mut self, world: &WorldModel, now: Now, findings: &mut Findings) {
        for (occupants, (zone, name)) in self.by_zone.iter_mut().zip(&world.zones.zones) {
            let (value, limit) = match zone.rule() {
                Some(ZoneRule::Capacity) => (occupants.now.len(), zone.capacity as usize),
                Some(ZoneRule::SameDirection) => (occupants.entries(), 1),
                None => (0, 0),
            };
            let was_broken = std::mem::replace(&mut occupants.is_broken, value > limit);
            if value <= limit || was_broken {
                continue;
            }
            findings.add(Kind::Zone, || Finding {
                robots: occupants.now.iter().map(|inside| inside.robot).collect(),
                edge: occupants.now.first().and_then(|inside| world.edge_id(inside.edge)),
                note: match zone.rule() {
                    Some(ZoneRule::Capacity) => {
                        format!("{value} in zone `{name}`, which has room for {limit}").into()
                    }
                    _ => format!("they entered zone `{name}` at {value} nodes").into(),
                },
                ..Finding::at(now.tick, now.seconds)
            });
        }
    }
}

impl Occupants {
    /// The number of different nodes at which robots have entered.
    fn entries(&self) -> usize {
        let mut entries: Vec<u32> = self.now.iter().map(|inside| inside.entry).collect();
        entries.sort_unstable();
        entries.dedup();
        entries.len()
    }
}
