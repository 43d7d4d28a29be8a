//! Vehicles together: those that touch, and bases that meet head-on.

use rustc_hash::{FxHashMap, FxHashSet};

use super::finding::{Notes, quoted};
use super::place::{Footprint, MOST_SIZE};
use super::route::Route;
use super::rule::Rule;
use crate::message::{Edge, Node, Position};

/// Metres of a side of a cell of the grid; two vehicles that touch are in cells side by side.
const CELL: f64 = MOST_SIZE;
/// Seconds for which a position counts.
const FRESH: f64 = 2.0;
/// Metres by which nodes of the same name may differ and be the same place.
const SAME_PLACE: f64 = 0.1;
/// Metres by which sizes are rounded up; contacts are deeper.
const GRAZE: f64 = 0.01;

type Cell = (i64, i64);
type Way = (String, String);

/// The places and the bases of all vehicles.
#[derive(Debug, Default)]
pub(super) struct Fleet {
    places: FxHashMap<String, Place>,
    cells: FxHashMap<Cell, FxHashSet<String>>,
    /// The vehicles that each vehicle touches.
    contacts: FxHashMap<String, Vec<String>>,
    /// The released ways of each vehicle, from node to node.
    ways: FxHashMap<Way, Vec<Claim>>,
    ways_of: FxHashMap<String, FxHashSet<Way>>,
}

/// The last place of a vehicle.
#[derive(Clone, Debug)]
struct Place {
    position: Position,
    footprint: Footprint,
    time: f64,
    cell: Cell,
}

/// A way in the base of a vehicle.
#[derive(Clone, Debug)]
struct Claim {
    vehicle: String,
    edge: String,
    ends: [Option<[f64; 2]>; 2],
}

impl Fleet {
    /// Judges the place of a vehicle against those of all others.
    pub fn take_place(
        &mut self,
        position: &Position,
        footprint: Option<Footprint>,
        now: f64,
        notes: &mut Notes<'_>,
    ) {
        let Some(footprint) = footprint.filter(|_| position.localized) else { return };
        let cell = [position.x, position.y].map(|metres| (metres / CELL).floor() as i64);
        let place = Place { position: position.clone(), footprint, time: now, cell: cell.into() };
        let touched = self.touched(notes.vehicle, &place);
        let before = self.contacts.insert(notes.vehicle.to_owned(), touched.clone());
        let before = before.unwrap_or_default();
        for other in touched.iter().filter(|other| !before.contains(other)) {
            // The other one has told the same contact, if it has moved into it.
            let is_told = self
                .contacts
                .get(other)
                .is_some_and(|theirs| theirs.iter().any(|name| name == notes.vehicle));
            if !is_told {
                notes.add(Rule::Contact, format!("the vehicle touches {}", quoted(other)));
            }
        }
        self.put(notes.vehicle, place);
    }

    /// The vehicles that a vehicle touches at a place.
    fn touched(&self, vehicle: &str, place: &Place) -> Vec<String> {
        let (east, north) = place.cell;
        let cells = (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y)));
        let cells = cells.filter_map(|(x, y)| Some((east.checked_add(x)?, north.checked_add(y)?)));
        let names = cells.filter_map(|cell| self.cells.get(&cell)).flatten();
        let others = names.filter(|name| *name != vehicle);
        let touched = others.filter(|name| {
            let there = self.places.get(*name);
            there.is_some_and(|there| place.time - there.time <= FRESH && place.touches(there))
        });
        touched.cloned().collect()
    }

    fn put(&mut self, vehicle: &str, place: Place) {
        let cell = place.cell;
        let before = self.places.insert(vehicle.to_owned(), place);
        if let Some(before) = before.filter(|before| before.cell != cell)
            && let Some(names) = self.cells.get_mut(&before.cell)
        {
            names.remove(vehicle);
            if names.is_empty() {
                self.cells.remove(&before.cell);
            }
        }
        self.cells.entry(cell).or_default().insert(vehicle.to_owned());
    }

    /// Takes the ways that a vehicle has in its base, and judges them against those of others.
    pub fn take_base(&mut self, route: &Route, behind: u32, notes: &mut Notes<'_>) {
        self.forget_base(notes.vehicle);
        let mut ways = FxHashSet::default();
        for (edge, ends) in route.released_after(behind) {
            let way = (ends[0].node_id.clone(), ends[1].node_id.clone());
            if !ways.insert(way.clone()) {
                continue;
            }
            let claim = Claim::new(notes.vehicle, edge, ends);
            let back = (way.1.clone(), way.0.clone());
            let opposite = self.ways.get(&back).into_iter().flatten();
            if let Some(other) = opposite.into_iter().find(|other| other.meets(&claim)) {
                let text = format!(
                    "edge {} is released against {} on edge {}",
                    quoted(&claim.edge),
                    quoted(&other.vehicle),
                    quoted(&other.edge)
                );
                notes.add(Rule::HeadOn, text);
            }
            self.ways.entry(way).or_default().push(claim);
        }
        self.ways_of.insert(notes.vehicle.to_owned(), ways);
    }

    /// Forgets the ways in the base of a vehicle.
    pub fn forget_base(&mut self, vehicle: &str) {
        for way in self.ways_of.remove(vehicle).unwrap_or_default() {
            if let Some(claims) = self.ways.get_mut(&way) {
                claims.retain(|claim| claim.vehicle != vehicle);
                if claims.is_empty() {
                    self.ways.remove(&way);
                }
            }
        }
    }
}

fn is_same_place(one: Option<[f64; 2]>, other: Option<[f64; 2]>) -> bool {
    let Some((one, other)) = one.zip(other) else { return true };
    (one[0] - other[0]).hypot(one[1] - other[1]) <= SAME_PLACE
}

/// The shadow of a shape on an axis: its lowest and its highest place.
fn shadow(corners: &[[f64; 2]; 4], axis: [f64; 2]) -> [f64; 2] {
    let along = corners.map(|corner| corner[0] * axis[0] + corner[1] * axis[1]);
    [along.into_iter().fold(f64::MAX, f64::min), along.into_iter().fold(f64::MIN, f64::max)]
}

impl Claim {
    fn new(vehicle: &str, edge: &Edge, ends: [&Node; 2]) -> Self {
        let places = ends.map(|node| node.node_position.as_ref());
        let ends = places.map(|place| place.map(|place| [place.x, place.y]));
        Self { vehicle: vehicle.to_owned(), edge: edge.edge_id.clone(), ends }
    }

    /// Whether a way in the opposite direction, of another vehicle, is at the same place.
    fn meets(&self, other: &Self) -> bool {
        let [from, to] = self.ends;
        let [start, end] = other.ends;
        self.vehicle != other.vehicle && is_same_place(from, end) && is_same_place(to, start)
    }
}

impl Place {
    /// The corners of the vehicle, around its position.
    fn corners(&self) -> [[f64; 2]; 4] {
        let (sin, cos) = self.position.theta.sin_cos();
        let length = self.footprint.length / 2.0 - GRAZE;
        let width = self.footprint.width / 2.0 - GRAZE;
        [(length, width), (-length, width), (-length, -width), (length, -width)].map(
            |(ahead, left)| {
                let east = self.position.x + ahead * cos - left * sin;
                [east, self.position.y + ahead * sin + left * cos]
            },
        )
    }

    /// Whether two vehicles touch: no side of either separates them.
    fn touches(&self, other: &Self) -> bool {
        if self.position.map_id != other.position.map_id {
            return false;
        }
        let (mine, theirs) = (self.corners(), other.corners());
        [self, other].iter().all(|vehicle| {
            let (sin, cos) = vehicle.position.theta.sin_cos();
            [[cos, sin], [-sin, cos]].iter().all(|axis| overlap(&mine, &theirs, *axis))
        })
    }
}

/// Whether the shadows of two shapes on an axis overlap.
fn overlap(one: &[[f64; 2]; 4], other: &[[f64; 2]; 4], axis: [f64; 2]) -> bool {
    let ([low, high], [other_low, other_high]) = (shadow(one, axis), shadow(other, axis));
    low < other_high && other_low < high
}
