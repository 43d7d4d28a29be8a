//! What robots drive next.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use crate::graph::{Gear, Leg};
use crate::motion::{Onward, Roads};

/// Whether a listed route is driven again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Repeat {
    /// Once; then the robot is idle.
    Once,
    /// For ever. The route has to end where it starts.
    Loop,
}

/// Where a robot takes its route from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RouteSource {
    /// It stands until an order gives it one.
    None,
    /// These legs; robots with the same route share it.
    Listed(Arc<[Leg]>, Repeat),
    /// A random walk along edges in forward gear that never ends, but at a dead end. At each node every edge that
    /// starts there is as likely as the others, but for the one straight back: that is taken only if there is no other.
    Random,
}

/// A robot's place in its [`Plan`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Route {
    /// Number of the plan, or one of the constants'.
    plan: u32,
    /// The plan's next leg; in a random walk, how many choices have been made.
    position: u32,
}

impl Route {
    /// Stands where it is.
    pub(crate) const PARKED: Self = Self { plan: u32::MAX, position: 0 };
    /// Drives to the end of its leg.
    pub(crate) const FINISH: Self = Self { plan: u32::MAX - 1, position: 0 };
    /// Walks at random.
    pub(crate) const WALK: Self = Self { plan: u32::MAX - 2, position: 0 };
}

/// Why there is no next leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// The route ends.
    Done,
    /// The released base ends, but not the route.
    Unreleased,
    /// No edge starts here.
    DeadEnd,
}

/// Legs in order.
#[derive(Clone, Debug)]
enum Plan {
    /// Nobody's; for the next.
    Free,
    /// From a scenario.
    Listed { legs: Arc<[Leg]>, repeat: Repeat },
    /// From orders, for one robot: the first `released` legs are its base, the others its horizon.
    Ordered { legs: Vec<Leg>, released: usize },
}

/// All plans, by number.
#[derive(Debug)]
pub(crate) struct Plans {
    plans: Vec<Plan>,
    free: Vec<u32>,
    /// Of the random walks; well mixed.
    seed: u64,
}

impl Plans {
    pub(super) fn new(seed: u64) -> Self {
        Self { plans: Vec::new(), free: Vec::new(), seed: mix(seed) }
    }

    /// The next leg of a route, and moves the route on.
    pub(crate) fn next(&self, roads: &Roads, onward: &mut Onward) -> Result<Leg, Ending> {
        let Route { plan, position } = onward.route;
        let (leg, place) = match self.plans.get(plan as usize) {
            Some(Plan::Listed { legs, repeat }) => listed(legs, *repeat, position)?,
            Some(Plan::Ordered { legs, released }) => ordered(legs, *released, position)?,
            None if plan == Route::WALK.plan => (self.wander(roads, onward)?, position),
            Some(Plan::Free) | None => return Err(Ending::Done),
        };
        onward.route.position = place.wrapping_add(1);
        Ok(leg)
    }

    fn wander(&self, roads: &Roads, onward: &Onward) -> Result<Leg, Ending> {
        let counter = u64::from(onward.robot) << 32 | u64::from(onward.route.position);
        let random = (mix(self.seed ^ counter) >> 32) as u32;
        let edge = roads.wander(onward.node, onward.leg, random).ok_or(Ending::DeadEnd)?;
        Ok(Leg { edge, gear: Gear::Forward })
    }

    /// The route at the start of these legs. Robots that are given the same list share its plan, if not too many
    /// others were made in between.
    pub(super) fn list(&mut self, legs: Arc<[Leg]>, repeat: Repeat) -> Route {
        const RECENT: usize = 64;
        let is_same = |plan: &Plan| match plan {
            Plan::Listed { legs: other, repeat: again } => Arc::ptr_eq(other, &legs) && *again == repeat,
            Plan::Free | Plan::Ordered { .. } => false,
        };
        let recent = self.plans.len().saturating_sub(RECENT);
        match self.plans[recent..].iter().position(is_same) {
            Some(place) => Route { plan: (recent + place) as u32, position: 0 },
            None => self.add(Plan::Listed { legs, repeat }),
        }
    }

    /// The route at the start of ordered legs.
    pub(super) fn order(&mut self, legs: Vec<Leg>, released: usize) -> Route {
        self.add(Plan::Ordered { legs, released })
    }

    fn add(&mut self, plan: Plan) -> Route {
        let number = match self.free.pop() {
            Some(number) => {
                self.plans[number as usize] = plan;
                number
            }
            None => {
                self.plans.push(plan);
                self.plans.len() as u32 - 1
            }
        };
        Route { plan: number, position: 0 }
    }

    /// Legs of a route's released base that are still to be entered. A loop's base ends with its lap, a random
    /// walk's with the leg that the robot is on.
    pub(super) fn base(&self, route: Route) -> &[Leg] {
        match self.plans.get(route.plan as usize) {
            Some(Plan::Listed { legs, .. }) => &legs[route.position as usize..],
            Some(Plan::Ordered { legs, released }) => &legs[route.position as usize..*released],
            Some(Plan::Free) | None => &[],
        }
    }

    /// Legs of a route that come after its base: an order's horizon; of a loop, what is left of one lap from the leg that
    /// the robot is on.
    pub(super) fn horizon(&self, route: Route) -> &[Leg] {
        match self.plans.get(route.plan as usize) {
            Some(Plan::Listed { legs, repeat: Repeat::Loop }) => &legs[..(route.position as usize).saturating_sub(1)],
            Some(Plan::Ordered { legs, released }) => &legs[*released..],
            Some(Plan::Free | Plan::Listed { .. }) | None => &[],
        }
    }

    /// Gives up a robot's route.
    pub(super) fn release(&mut self, route: Route) {
        if let Some(plan @ Plan::Ordered { .. }) = self.plans.get_mut(route.plan as usize) {
            *plan = Plan::Free;
            self.free.push(route.plan);
        }
    }
}

fn listed(legs: &[Leg], repeat: Repeat, position: u32) -> Result<(Leg, u32), Ending> {
    match (legs.get(position as usize), repeat) {
        (Some(&leg), _) => Ok((leg, position)),
        (None, Repeat::Loop) => Ok((legs[0], 0)),
        (None, Repeat::Once) => Err(Ending::Done),
    }
}

fn ordered(legs: &[Leg], released: usize, position: u32) -> Result<(Leg, u32), Ending> {
    match legs.get(position as usize) {
        Some(&leg) if (position as usize) < released => Ok((leg, position)),
        Some(_) => Err(Ending::Unreleased),
        None => Err(Ending::Done),
    }
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014), after one step of its sequence: random bits for any counter.
fn mix(counter: u64) -> u64 {
    let z = counter.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
