//! Measures a master by the traffic on its broker: the transports that its vehicles carry out, and
//! the time that it takes to send the next base.
//!
//! ```text
//!   order, state ──▶ Meter ──▶ Figures: transports, bases, waiting, idle times, errors
//! ```
//!
//! Like the judge it has no connections and no clocks. A vehicle asks for its next base when a
//! state has `newBaseRequest`, or shows that the last released node is reached. The master answers
//! with the next order that releases more. It was *free to answer* at once if none of the nodes
//! that it released then was in the base of another vehicle since the vehicle had asked.

mod figures;
mod holds;
mod route;
#[cfg(test)]
mod tests;
mod vehicle;

use rustc_hash::FxHashMap;

pub use figures::{Answer, BaseWait, Figures, Finished};

use crate::judge::clock;
use crate::message::{Order, State, Topic, decode};
use holds::Holds;
use vehicle::Vehicle;

/// A transport order that was handed to a master.
#[derive(Clone, Debug, PartialEq)]
struct Handed {
    number: u64,
    pick: String,
    drop: String,
    time: f64,
}

/// Measures a master. Times are in seconds, of any clock that all calls share.
#[derive(Debug, Default)]
pub struct Meter {
    /// The places of nodes that have several names, or belong to a station.
    places: FxHashMap<String, String>,
    vehicles: FxHashMap<String, Vehicle>,
    holds: Holds,
    /// The transport orders that aren't finished, the oldest first.
    handed: Vec<Handed>,
    figures: Figures,
}

impl Meter {
    /// Creates a meter. `places` has the place of each node id that isn't a place of its own: nodes
    /// of the same station are the same place.
    pub fn new(places: impl IntoIterator<Item = (String, String)>) -> Self {
        Self { places: places.into_iter().collect(), ..Self::default() }
    }

    /// Takes a message that came at a time. Broken ones and those of other topics are left to the
    /// judge.
    pub fn take(&mut self, topic: &str, payload: &[u8], time: f64) {
        let Some((vehicle, topic)) = topic.rsplit_once('/') else { return };
        if topic == Topic::Order.name() {
            if let Ok(order) = decode::<Order>(payload) {
                self.take_order(vehicle, &order, time);
            }
        } else if topic == Topic::State.name()
            && let Ok(state) = decode::<State>(payload)
        {
            self.take_state(vehicle, &state, time);
        }
    }

    /// Notes a transport order that was handed to the master. It is finished when a vehicle has
    /// carried a load from its pick to its drop; of several such orders, the oldest.
    pub fn hand_over(&mut self, number: u64, pick: &str, drop: &str, time: f64) {
        let (pick, drop) = (self.place(pick), self.place(drop));
        self.handed.push(Handed { number, pick, drop, time });
    }

    /// The number of vehicles that have said at which node they are.
    pub fn placed_vehicles(&self) -> usize {
        self.vehicles.values().filter(|vehicle| vehicle.is_placed()).count()
    }

    /// The figures so far.
    pub fn figures(&self) -> &Figures {
        &self.figures
    }

    /// Ends the measurement at a time, and returns the figures: bases that are still to come count
    /// with the time so far.
    pub fn end(mut self, time: f64) -> Figures {
        for (name, vehicle) in &mut self.vehicles {
            let wait = vehicle.end(name, time, &self.holds);
            self.figures.bases.extend(wait);
            self.figures.vehicles += 1;
            self.figures.never_ordered += u64::from(!vehicle.has_had_orders());
        }
        self.figures.open_orders = self.handed.len() as u64;
        self.figures
    }

    fn place(&self, node: &str) -> String {
        self.places.get(node).map_or(node, String::as_str).to_owned()
    }

    fn take_order(&mut self, name: &str, order: &Order, time: f64) {
        let vehicle = self.vehicles.entry(name.to_owned()).or_default();
        self.figures.orders += 1;
        self.figures.first_order.get_or_insert(time);
        self.figures.last_order = Some(time);
        let (wait, idle) = vehicle.take_order(order, name, time, &self.holds);
        self.figures.bases.extend(wait);
        self.figures.idle_secs.extend(idle);
        self.holds.set(name, vehicle.held_nodes(), time);
    }

    fn take_state(&mut self, name: &str, state: &State, time: f64) {
        if let Some(sent) = clock::seconds(&state.header.timestamp) {
            self.figures.delay_secs.push((time - sent) as f32);
        }
        let vehicle = self.vehicles.entry(name.to_owned()).or_default();
        for kind in vehicle.new_errors(state) {
            *self.figures.errors.entry(kind).or_default() += 1;
        }
        let carried = vehicle.take_state(state, time);
        self.holds.set(name, vehicle.held_nodes(), time);
        for (pick, drop) in carried {
            self.finish(&pick, &drop, time);
        }
    }

    fn finish(&mut self, pick: &str, drop: &str, time: f64) {
        let (pick, drop) = (self.place(pick), self.place(drop));
        let of_order = |order: &Handed| order.pick == pick && order.drop == drop;
        let order = self.handed.iter().position(of_order).map(|index| self.handed.remove(index));
        self.figures.finished.push(Finished {
            time,
            number: order.as_ref().map(|order| order.number),
            service_secs: order.map(|order| time - order.time),
        });
    }
}
