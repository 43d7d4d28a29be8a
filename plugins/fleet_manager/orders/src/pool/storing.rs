//! Orders with stops at storages: they wait until there are places for all of these stops.

use std::cmp::Reverse;
use std::sync::Arc;

use super::{Change, NewOrder, Order, OrderEvent, OrderId, OrderPool, State, Unroutable};
use crate::load::Load;
use crate::places::Places;
use crate::storages::{Lack, StorageFill, Storages, places};

/// An order that waits for places: the higher priority is first, and then the older order.
pub(super) type Unplaced = (Reverse<u8>, OrderId);

impl OrderPool {
    /// Adds the storages of a load, with their initial fill. Orders may name them from now on.
    pub fn set_storages(&mut self, load: &Load) {
        if !load.storages.is_empty() {
            self.places = Arc::new(places(&self.places, &load.storages));
        }
        self.storages = Storages::new(&load.storages, load.seed);
    }

    /// The places of each storage, and the orders that wait for one.
    pub fn storages(&self) -> Vec<StorageFill> {
        let mut fills = self.storages.fills();
        for (_, lack) in self.unplaced_orders() {
            let Some(fill) = fills.get_mut(lack.storage) else { continue };
            match lack.is_full {
                true => fill.waiting_drops += 1,
                false => fill.waiting_picks += 1,
            }
        }
        fills
    }

    /// The orders that wait for a place of a storage, and the storage that has none.
    fn unplaced_orders(&self) -> impl Iterator<Item = (OrderId, Lack)> {
        self.unplaced.iter().filter_map(|((_, id), lack)| Some((*id, (*lack)?)))
    }

    /// Whether a stop of an order is at a storage that hasn't chosen a place yet.
    pub(super) fn needs_place(&self, order: &NewOrder) -> bool {
        order.stops.iter().any(|stop| self.places.storage(stop.node).is_some())
    }

    /// Lets an order wait for a robot, or for places before that.
    pub(super) fn make_ready(&mut self, order: &mut Order) {
        if self.needs_place(&order.content) {
            order.state = State::Unplaced;
            self.unplaced.insert((Reverse(order.content.priority), order.id), None);
            self.storages.ask();
        } else {
            order.state = State::Waiting;
            self.wait(order.id);
        }
    }

    /// Chooses places for the orders that wait for them, as far as there are any.
    pub(super) fn place_orders(&mut self, now_secs: f64) {
        if self.unplaced.is_empty() || !self.storages.take_change() {
            return;
        }
        let waiting: Vec<Unplaced> = self.unplaced.keys().copied().collect();
        for key in waiting {
            self.place_order(key, now_secs);
        }
        // The tries themselves have changed nothing.
        self.storages.take_change();
    }

    fn place_order(&mut self, key: Unplaced, now_secs: f64) {
        let (_, id) = key;
        let Some(order) = self.open.get_mut(&id) else { return };
        match self.storages.reserve(id, &mut order.content.stops, &self.places) {
            Ok(()) => {
                self.unplaced.remove(&key);
                order.state = State::Waiting;
                let has_waited = !std::mem::take(&mut order.reason).is_empty();
                self.wait(id);
                if has_waited {
                    self.note(id, now_secs, Change::Reopened);
                }
                self.tell_stops(id, now_secs);
                self.changed.insert(id);
            }
            Err(lack) => {
                let before = self.unplaced.insert(key, Some(lack)).flatten();
                let reason = Unroutable::NoPlace;
                if before.is_none() {
                    order.reason = reason.to_string();
                    self.note(id, now_secs, Change::Unroutable { reason, lack: Some(lack) });
                }
            }
        }
    }

    /// Writes the stops of an order into the events.
    pub(super) fn tell_stops(&mut self, id: OrderId, now_secs: f64) {
        let Some(order) = self.open.get(&id) else { return };
        self.events.extend(order.content.stops.iter().zip(0..).map(|(stop, index)| OrderEvent {
            secs: now_secs,
            id,
            change: Change::Stop {
                stop: index,
                node: stop.node,
                action: stop.action,
                dwell_secs: stop.dwell_secs,
            },
        }));
    }

    /// Frees the places that an order that is over has reserved.
    pub(super) fn release_places(&mut self, order: &Order) {
        self.unplaced.remove(&(Reverse(order.content.priority), order.id));
        self.storages.release(order.id);
    }
}

/// Returns an order whose stops at storages are at the first place of each.
pub(super) fn at_first_places(order: &NewOrder, places: &Places) -> NewOrder {
    let mut order = order.clone();
    for stop in &mut order.stops {
        stop.node = places.nodes_at(stop.node)[0];
    }
    order
}
