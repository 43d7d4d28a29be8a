//! Admission: while too many robots wait for each other, the others stay where they are and give
//! way.

use std::collections::BTreeMap;

use crate::density::{Density, DensitySettings};
use crate::roads::Roads;
use crate::traffic::Traffic;

/// The number of places for each robot that is always admitted.
const PLACES_PER_ROBOT: f64 = 20.0;
/// The number of robots that are always admitted if there are four places for each: so few resolve
/// their jams themselves.
const FEW: f64 = 20.0;

/// The robots that are admitted: they drive to their goals.
#[derive(Debug)]
pub(super) struct Admission {
    density: Density,
    /// By admitted robot: when it was sent to its goal, in simulated seconds. Another goal needs
    /// another admission.
    sent: BTreeMap<u32, f64>,
    last: f64,
}

impl Admission {
    pub(super) fn new(roads: &Roads, settings: DensitySettings) -> Self {
        let places = f64::from(roads.nodes());
        let density =
            Density::new(settings, (places / PLACES_PER_ROBOT).max(FEW.min(places / 4.0)));
        Self { density, sent: BTreeMap::new(), last: 0.0 }
    }

    /// Admits robots, those first that come first in `ranks`.
    pub(super) fn admit(&mut self, traffic: &Traffic<'_>, ranks: &[u32]) {
        self.sent.retain(|robot, since| sent(traffic, *robot) == Some(*since));
        let admitted = self.sent.keys().filter_map(|robot| traffic.robot(*robot));
        let waiting = admitted.filter(|state| state.waiting_since.is_finite()).count();
        self.density.adapt(self.sent.len(), waiting, (traffic.now - self.last) as f32);
        self.last = traffic.now;
        for &robot in ranks {
            if !self.density.is_open() {
                return;
            }
            if !self.sent.contains_key(&robot)
                && let Some(since) = sent(traffic, robot)
            {
                self.sent.insert(robot, since);
                self.density.enter();
            }
        }
    }

    /// Whether a robot goes for its goal.
    pub(super) fn is_admitted(&self, robot: u32) -> bool {
        self.sent.contains_key(&robot)
    }
}

/// The time at which a robot with a goal was sent there, in simulated seconds.
fn sent(traffic: &Traffic<'_>, robot: u32) -> Option<f64> {
    traffic.robot(robot).filter(|state| state.goal().is_some()).map(|state| state.sent)
}
