//! The nodes in the bases of vehicles.

use rustc_hash::{FxHashMap, FxHashSet};

/// The vehicles that hold each node, and since when nobody does.
#[derive(Debug, Default)]
pub(super) struct Holds {
    holders: FxHashMap<String, FxHashSet<String>>,
    /// The times at which nodes lost a holder, with that holder: the last two of them.
    left: FxHashMap<String, [Option<Left>; 2]>,
    of_vehicle: FxHashMap<String, FxHashSet<String>>,
}

/// A vehicle that has left a node.
#[derive(Clone, Debug)]
struct Left {
    vehicle: String,
    time: f64,
}

impl Holds {
    /// Replaces the nodes that a vehicle holds.
    pub fn set(&mut self, vehicle: &str, nodes: FxHashSet<String>, time: f64) {
        let before = self.of_vehicle.remove(vehicle).unwrap_or_default();
        for node in before.difference(&nodes) {
            self.leave(node, vehicle, time);
        }
        for node in nodes.difference(&before) {
            self.holders.entry(node.clone()).or_default().insert(vehicle.to_owned());
        }
        self.of_vehicle.insert(vehicle.to_owned(), nodes);
    }

    fn leave(&mut self, node: &str, vehicle: &str, time: f64) {
        if let Some(holders) = self.holders.get_mut(node) {
            holders.remove(vehicle);
        }
        let left = self.left.entry(node.to_owned()).or_default();
        // One entry of each vehicle: the other one may be the vehicle that asks.
        if left[0].as_ref().is_some_and(|last| last.vehicle != vehicle) {
            left.swap(0, 1);
        }
        left[0] = Some(Left { vehicle: vehicle.to_owned(), time });
    }

    /// Whether no other vehicle has held a node since a time.
    pub fn is_free_since(&self, node: &str, vehicle: &str, since: f64) -> bool {
        let mut holders = self.holders.get(node).into_iter().flatten();
        if holders.any(|holder| holder != vehicle) {
            return false;
        }
        let mut left = self.left.get(node).into_iter().flatten().flatten();
        !left.any(|left| left.vehicle != vehicle && left.time > since)
    }
}
