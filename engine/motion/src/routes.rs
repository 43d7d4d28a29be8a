//! Routes: the legs that robots drive next.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use regatta_base::graph::{Gear, Leg, NodeIndex};
use regatta_base::random::mix;

use super::leg_table::LegTable;

/// A robot's position in its [`Plan`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Route {
    /// Number of the plan, or that of one of the constants below.
    plan: u32,
    /// The plan's next leg; in a random walk, the number of choices made so far.
    position: u32,
}

impl Route {
    /// The route of a robot that stays where it is.
    pub const PARKED: Self = Self { plan: u32::MAX, position: 0 };
    /// The route of a robot that drives to the end of its leg.
    pub const FINISH: Self = Self { plan: u32::MAX - 1, position: 0 };
    /// The start of a random walk.
    pub const WALK: Self = Self { plan: u32::MAX - 2, position: 0 };

    /// Whether it is a random walk.
    pub fn is_walk(self) -> bool {
        self.plan == Self::WALK.plan
    }
}

/// A position on a robot's route from which its next legs can be read, one after the other.
#[derive(Clone, Copy, Debug)]
pub struct RouteCursor {
    /// The robot, whose id decides on random walks.
    pub robot: u32,
    /// The position on its route.
    pub route: Route,
    /// The node that the next leg leaves.
    pub node: NodeIndex,
    /// The leg that leads to `node`.
    pub leg: Option<Leg>,
}

/// The reason why a robot's released base has no next leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BaseEnd {
    /// The route ends.
    Done,
    /// The released base ends, but the route goes on; or it leads along an edge that is closed or
    /// barred.
    Unreleased,
    /// No edge leaves this node.
    DeadEnd,
}

/// Legs in order.
#[derive(Clone, Debug)]
enum Plan {
    /// Unused; its number goes to the next plan that is added.
    Free,
    /// Listed by a scenario; a loop is driven for ever, and ends where it starts.
    Listed { legs: Arc<[Leg]>, is_loop: bool },
    /// From commands, for one robot: the first `released` legs are its base, the others its
    /// horizon. The last released leg (if there is none, the leg that the robot is on when it gets
    /// the plan) is released up to `limit` metres from where it is entered; infinity for all of it.
    Commanded { legs: Vec<Leg>, released: usize, limit: f64 },
}

/// All plans, by number.
#[derive(Debug)]
pub struct Plans {
    plans: Vec<Plan>,
    free: Vec<u32>,
    /// The mixed seed of the random walks.
    seed: u64,
}

impl Plans {
    /// Makes an empty list; the seed is that of the random walks.
    pub fn new(seed: u64) -> Self {
        Self { plans: Vec::new(), free: Vec::new(), seed: mix(seed) }
    }

    /// Returns the next leg of a route and moves the route past it.
    pub(super) fn next(&self, table: &LegTable, cursor: &mut RouteCursor) -> Result<Leg, BaseEnd> {
        let (leg, place) = self.wanted(table, cursor)?;
        if table.is_closed(leg.edge) || table.is_barred(leg.edge) {
            return Err(BaseEnd::Unreleased);
        }
        cursor.route.position = place.wrapping_add(1);
        Ok(leg)
    }

    /// Returns the next leg of a route, even if no robot may enter it, and its place in the route.
    pub(super) fn wanted(
        &self,
        table: &LegTable,
        cursor: &RouteCursor,
    ) -> Result<(Leg, u32), BaseEnd> {
        let Route { plan, position } = cursor.route;
        match self.plans.get(plan as usize) {
            Some(Plan::Listed { legs, is_loop }) => next_listed(legs, *is_loop, position),
            Some(Plan::Commanded { legs, released, .. }) => {
                next_commanded(legs, *released, position)
            }
            None if cursor.route.is_walk() => Ok((self.random_leg(table, cursor)?, position)),
            Some(Plan::Free) | None => Err(BaseEnd::Done),
        }
    }

    fn random_leg(&self, table: &LegTable, cursor: &RouteCursor) -> Result<Leg, BaseEnd> {
        let counter = u64::from(cursor.robot) << 32 | u64::from(cursor.route.position);
        let random = (mix(self.seed ^ counter) >> 32) as u32;
        let edge = table.random_exit(cursor.node, cursor.leg, random)?;
        Ok(Leg { edge, gear: Gear::Forward })
    }

    /// Adds a list of legs, at least one, and returns the route at its start. A loop has to end
    /// where it starts. Robots with the same list share its plan, unless many others were added in
    /// between.
    pub fn list(&mut self, legs: Arc<[Leg]>, is_loop: bool) -> Route {
        const RECENT: usize = 64;
        let recent = self.plans.len().saturating_sub(RECENT);
        for (number, plan) in self.plans.iter().enumerate().skip(recent) {
            match plan {
                Plan::Listed { legs: other, is_loop: again }
                    if Arc::ptr_eq(other, &legs) && *again == is_loop =>
                {
                    return Route { plan: number as u32, position: 0 };
                }
                _ => {}
            }
        }
        self.add(Plan::Listed { legs, is_loop })
    }

    /// Adds commanded legs and returns the route at their start. `limit` is in metres along the
    /// last released leg.
    pub fn command(&mut self, legs: Vec<Leg>, released: usize, limit: f64) -> Route {
        self.add(Plan::Commanded { legs, released, limit })
    }

    /// Releases the first `released` legs of a commanded route, the last of them up to `limit`
    /// metres.
    pub fn set_base(&mut self, route: Route, released: usize, limit: f64) {
        if let Some(Plan::Commanded { released: legs, limit: metres, .. }) =
            self.plans.get_mut(route.plan as usize)
        {
            (*legs, *metres) = (released, limit);
        }
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

    /// Returns the metres of the last released leg that are released; infinity for all of it.
    pub fn limit(&self, route: Route) -> f64 {
        match self.plans.get(route.plan as usize) {
            Some(Plan::Commanded { limit, .. }) => *limit,
            _ => f64::INFINITY,
        }
    }

    /// Returns the metres that are released of the leg that the robot is on; infinity for all of
    /// it.
    pub fn limit_on_leg(&self, route: Route) -> f64 {
        match self.plans.get(route.plan as usize) {
            Some(Plan::Commanded { released, limit, .. })
                if *released == route.position as usize =>
            {
                *limit
            }
            _ => f64::INFINITY,
        }
    }

    /// Returns the reason why a robot stops at the limit of its leg.
    pub(super) fn end_at_limit(&self, route: Route) -> BaseEnd {
        match self.plans.get(route.plan as usize) {
            Some(Plan::Commanded { legs, .. }) if !legs.is_empty() => BaseEnd::Unreleased,
            _ => BaseEnd::Done,
        }
    }

    /// Returns the number of released legs of a route, counted from its start, and the last of
    /// them.
    pub fn released(&self, route: Route) -> (usize, Option<Leg>) {
        match self.plans.get(route.plan as usize) {
            Some(Plan::Commanded { legs, released, .. }) => {
                (*released, legs[..*released].last().copied())
            }
            _ => (0, None),
        }
    }

    /// Legs of a route's released base that are still to be entered. A loop's base ends with its
    /// lap, a random walk's with the leg that the robot is on.
    pub fn base(&self, route: Route) -> &[Leg] {
        match self.plans.get(route.plan as usize) {
            Some(Plan::Listed { legs, .. }) => &legs[route.position as usize..],
            Some(Plan::Commanded { legs, released, .. }) => {
                &legs[route.position as usize..*released]
            }
            Some(Plan::Free) | None => &[],
        }
    }

    /// Legs of a route that come after its base: a command's horizon; of a loop, the rest of one
    /// lap, counted from the leg that the robot is on.
    pub fn horizon(&self, route: Route) -> &[Leg] {
        match self.plans.get(route.plan as usize) {
            Some(Plan::Listed { legs, is_loop: true }) => {
                &legs[..(route.position as usize).saturating_sub(1)]
            }
            Some(Plan::Commanded { legs, released, .. }) => &legs[*released..],
            Some(Plan::Free | Plan::Listed { .. }) | None => &[],
        }
    }

    /// Whether a route goes on for ever: a loop, or a random walk.
    pub fn is_endless(&self, route: Route) -> bool {
        let plan = self.plans.get(route.plan as usize);
        route.is_walk() || matches!(plan, Some(Plan::Listed { is_loop: true, .. }))
    }

    /// Frees the plan of a robot that gives up its route, if no other robot can share it.
    pub fn discard(&mut self, route: Route) {
        if let Some(plan @ Plan::Commanded { .. }) = self.plans.get_mut(route.plan as usize) {
            *plan = Plan::Free;
            self.free.push(route.plan);
        }
    }
}

fn next_listed(legs: &[Leg], is_loop: bool, position: u32) -> Result<(Leg, u32), BaseEnd> {
    match (legs.get(position as usize), is_loop) {
        (Some(&leg), _) => Ok((leg, position)),
        (None, true) => Ok((legs[0], 0)),
        (None, false) => Err(BaseEnd::Done),
    }
}

fn next_commanded(legs: &[Leg], released: usize, position: u32) -> Result<(Leg, u32), BaseEnd> {
    match legs.get(position as usize) {
        Some(&leg) if (position as usize) < released => Ok((leg, position)),
        Some(_) => Err(BaseEnd::Unreleased),
        None => Err(BaseEnd::Done),
    }
}
