//! The places of storages during a run: which are empty, full or reserved.

use std::collections::BTreeMap;

use glam::Vec2;
use regatta_base::random::Random;
use serde::Serialize;

use super::{InitialFill, StorageSettings, Strategy};
use crate::order::{Action, OrderId, Stop};
use crate::places::Places;

/// The random numbers of storages; see those of stations and timetables.
const STORAGES: u64 = u64::MAX - 2;
const FILL: u64 = 0;
const CHOICE: u64 = 1;

/// The state of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Slot {
    Empty,
    /// Reserved for a load that comes.
    Awaited,
    Full,
    /// Reserved for a pick: its load goes.
    Promised,
}

/// All storages, and the places that orders have reserved.
#[derive(Clone, Debug, Default)]
pub(crate) struct Storages {
    storages: Vec<Storage>,
    reserved: BTreeMap<OrderId, Vec<Reservation>>,
    /// Whether a place has become free or full, or an order waits, since it was last asked.
    has_changed: bool,
}

#[derive(Clone, Debug)]
struct Storage {
    settings: StorageSettings,
    random: Random,
    /// By place.
    slots: Vec<Slot>,
}

/// A place that an order has.
#[derive(Clone, Copy, Debug)]
struct Reservation {
    /// The index of the order's stop.
    stop: usize,
    storage: usize,
    place: usize,
}

/// The storage that has no place for an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lack {
    /// The index of the storage.
    pub storage: usize,
    /// Whether it is full, with a load for each place; otherwise it is empty.
    pub is_full: bool,
}

/// The places of a storage at present.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct StorageFill {
    /// The name.
    pub name: String,
    /// The number of its places.
    pub places: usize,
    /// Places with a load, those that are reserved for a pick included.
    pub full: usize,
    /// Places that are reserved.
    pub reserved: usize,
    /// Orders that wait for an empty place.
    pub waiting_drops: usize,
    /// Orders that wait for a full place.
    pub waiting_picks: usize,
}

impl std::fmt::Display for StorageFill {
    /// Writes the fill as part of a line, such as `rack: 3 of 4 places full, 2 orders wait …`.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, places, full, waiting_drops, waiting_picks, .. } = self;
        write!(formatter, "{name}: {full} of {places} places full")?;
        for (orders, place) in [(waiting_drops, "an empty place"), (waiting_picks, "a load")] {
            match orders {
                0 => {}
                1 => write!(formatter, ", 1 order waits for {place}")?,
                _ => write!(formatter, ", {orders} orders wait for {place}")?,
            }
        }
        Ok(())
    }
}

impl Storages {
    /// Makes storages with their initial fill.
    pub(crate) fn new(settings: &[StorageSettings], seed: u64) -> Self {
        let random = Random::new(seed).part(STORAGES);
        let storages = settings.iter().zip(0..).map(|(settings, number)| {
            let random = random.part(number);
            Storage { slots: settings.slots(random), settings: settings.clone(), random }
        });
        Self { storages: storages.collect(), has_changed: true, ..Self::default() }
    }

    /// The same storages with their initial fill.
    pub(crate) fn unused(&self) -> Self {
        let mut storages = self.storages.clone();
        for storage in &mut storages {
            storage.slots = storage.settings.slots(storage.random);
        }
        Self { storages, has_changed: true, ..Self::default() }
    }

    /// Notes that an order waits for places.
    pub(crate) fn ask(&mut self) {
        self.has_changed = true;
    }

    /// Whether waiting orders may get places now that they couldn't have at the last call.
    pub(crate) fn take_change(&mut self) -> bool {
        std::mem::take(&mut self.has_changed)
    }

    /// Reserves a place for each stop of an order at a storage. The stops are then at these places.
    ///
    /// # Errors
    /// [`Lack`] for the first stop without a place: then nothing is reserved.
    pub(crate) fn reserve(
        &mut self,
        id: OrderId,
        stops: &mut [Stop],
        places: &Places,
    ) -> Result<(), Lack> {
        let named: Vec<Stop> = stops.to_vec();
        for index in 0..stops.len() {
            let Some(storage) = places.storage(stops[index].node) else { continue };
            let is_pick = stops[index].action == Action::Pick;
            let near = neighbour(stops, index).map(|stop| places.place(stop.node).position);
            let Some(place) = self.storages[storage].choose(is_pick, near, (id, index), places)
            else {
                self.release(id);
                stops.copy_from_slice(&named);
                return Err(Lack { storage, is_full: !is_pick });
            };
            let storage_of = &mut self.storages[storage];
            storage_of.slots[place] = if is_pick { Slot::Promised } else { Slot::Awaited };
            stops[index].node = storage_of.settings.places[place].node;
            let reservation = Reservation { stop: index, storage, place };
            self.reserved.entry(id).or_default().push(reservation);
        }
        Ok(())
    }

    /// Notes that the robot of an order has handled a stop: its place is full after a drop, and
    /// empty after a pick.
    pub(crate) fn handled(&mut self, id: OrderId, stop: usize) {
        let Some(reservations) = self.reserved.get_mut(&id) else { return };
        let Some(at) = reservations.iter().position(|it| it.stop == stop) else { return };
        let reservation = reservations.remove(at);
        self.set(reservation, Slot::Empty, Slot::Full);
    }

    /// Takes the places back that an order has reserved.
    pub(crate) fn release(&mut self, id: OrderId) {
        for reservation in self.reserved.remove(&id).unwrap_or_default() {
            self.set(reservation, Slot::Full, Slot::Empty);
        }
    }

    /// Sets a reserved place, by what it was reserved for.
    fn set(&mut self, reservation: Reservation, if_promised: Slot, if_awaited: Slot) {
        let slot = &mut self.storages[reservation.storage].slots[reservation.place];
        *slot = if *slot == Slot::Promised { if_promised } else { if_awaited };
        self.has_changed = true;
    }

    /// The places of each storage. Orders that wait aren't counted.
    pub(crate) fn fills(&self) -> Vec<StorageFill> {
        let fills = self.storages.iter().map(|storage| StorageFill {
            name: storage.settings.name.clone(),
            places: storage.slots.len(),
            full: storage.count(|slot| matches!(slot, Slot::Full | Slot::Promised)),
            reserved: storage.count(|slot| matches!(slot, Slot::Awaited | Slot::Promised)),
            waiting_drops: 0,
            waiting_picks: 0,
        });
        fills.collect()
    }
}

impl Storage {
    /// Returns a place for a stop of an order, as the strategy chooses it.
    fn choose(
        &self,
        is_pick: bool,
        near: Option<Vec2>,
        (id, stop): (OrderId, usize),
        places: &Places,
    ) -> Option<usize> {
        let wanted = if is_pick { Slot::Full } else { Slot::Empty };
        let all = (0..self.slots.len()).filter(|place| self.slots[*place] == wanted);
        let rank = all.clone().map(|place| self.settings.places[place].rank).min()?;
        let mut fitting = all.filter(|place| self.settings.places[*place].rank == rank);
        match (self.settings.strategy, near) {
            (Strategy::Random, _) => {
                let fitting: Vec<usize> = fitting.collect();
                let random = self.random.part(CHOICE).part(id.0);
                Some(fitting[random.below(stop as u64, fitting.len())])
            }
            (_, None) => fitting.next(),
            (_, Some(near)) => fitting.min_by(|a, b| {
                let [a, b] = [*a, *b].map(|place| self.settings.places[place].node);
                let [a, b] = [a, b].map(|node| places.place(node).position.distance_squared(near));
                a.total_cmp(&b)
            }),
        }
    }

    fn count(&self, condition: impl Fn(&Slot) -> bool) -> usize {
        self.slots.iter().filter(|slot| condition(slot)).count()
    }
}

impl StorageSettings {
    /// The initial state of its places.
    fn slots(&self, random: Random) -> Vec<Slot> {
        let mut slots = vec![Slot::Empty; self.places.len()];
        match &self.full {
            InitialFill::Nodes(nodes) => {
                for (slot, place) in slots.iter_mut().zip(&self.places) {
                    if nodes.contains(&place.node) {
                        *slot = Slot::Full;
                    }
                }
            }
            InitialFill::Share(share) => {
                let count = (share * slots.len() as f64).round() as usize;
                let mut order: Vec<usize> = (0..slots.len()).collect();
                for index in 0..count {
                    let rest = order.len() - index;
                    order.swap(index, index + random.part(FILL).below(index as u64, rest));
                    slots[order[index]] = Slot::Full;
                }
            }
        }
        slots
    }
}

/// The stop to which the place of another one should be near: the stop after a pick, the stop
/// before a drop, or else the only one beside it.
fn neighbour(stops: &[Stop], index: usize) -> Option<&Stop> {
    let before = index.checked_sub(1).and_then(|before| stops.get(before));
    let after = stops.get(index + 1);
    if stops[index].action == Action::Pick { after.or(before) } else { before.or(after) }
}
