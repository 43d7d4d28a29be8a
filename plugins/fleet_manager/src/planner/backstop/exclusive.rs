//! Zones for one robot: a robot on one stand keeps others out of all of the zone.

use std::collections::BTreeMap;

use super::ways::{Stand, stretches};
use crate::claims::Stretch;
use crate::roads::{Leg, Roads};

/// The stands in zones for one robot, and the zones of robots that can't be led.
#[derive(Debug, Default)]
pub struct Exclusive {
    /// By zone: stands, in ascending order.
    stands: BTreeMap<u32, Vec<u16>>,
    /// In ascending order.
    shut: Vec<u32>,
}

impl Exclusive {
    /// Collects the zones of stands, and of the claims of robots that aren't led.
    pub fn new(roads: &Roads, stands: &[Stand], others: &[Stretch]) -> Self {
        let mut exclusive = Self::default();
        for (number, stand) in (0..).zip(stands) {
            for zone in zones(roads, &stand.stretch()) {
                exclusive.stands.entry(zone).or_default().push(number);
            }
        }
        exclusive.shut = others.iter().flat_map(|stretch| zones(roads, stretch)).collect();
        exclusive.shut.sort_unstable();
        exclusive
    }

    /// Returns the stands from which a robot keeps another one out of the zones that it enters on a
    /// way; `None` if a robot that can't be led does.
    pub fn in_way(&self, roads: &Roads, from: Stand, legs: &[Leg]) -> Option<Vec<u16>> {
        let own = zones(roads, &from.stretch());
        let mut in_way = Vec::new();
        for stretch in stretches(roads, from, legs) {
            for zone in zones(roads, &stretch).into_iter().filter(|zone| !own.contains(zone)) {
                if self.shut.binary_search(&zone).is_ok() {
                    return None;
                }
                in_way.extend(self.stands.get(&zone).into_iter().flatten());
            }
        }
        Some(in_way)
    }
}

/// Returns the zones for one robot that a stretch is in.
fn zones(roads: &Roads, stretch: &Stretch) -> Vec<u32> {
    let parts = roads.zones().parts(stretch.track).iter().filter(|part| {
        let driven = part.driven(roads, stretch.leg);
        stretch.from <= driven.high && stretch.to >= driven.low
    });
    parts.map(|part| part.zone).filter(|zone| roads.zones().is_exclusive(*zone)).collect()
}
