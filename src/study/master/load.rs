//! The transport orders of a run: those of the study's load, made as the fleet manager makes them.

use std::collections::BTreeMap;
use std::sync::Arc;

use regatta_orders::{Candidate, InTurn, Load, OrderId, OrderPool, Places};
use regatta_study::master::MasterPlan;
use serde_json::json;

use crate::failure::Failure;

/// The load of a run. The pool gives each order to a made-up robot of its own, so that it is open
/// until a vehicle has carried it out.
#[derive(Debug)]
pub struct LiveLoad {
    pool: OrderPool,
    vehicles: usize,
    robots: BTreeMap<OrderId, u32>,
}

/// An order that has come: its number, and its first and last node as indices in the layout's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// The number, from 1.
    pub number: u64,
    /// The nodes to pick at and to drop at.
    pub nodes: [u32; 2],
}

impl LiveLoad {
    /// Makes the load of a run.
    ///
    /// # Errors
    /// If the load isn't one of the fleet manager's.
    pub fn new(
        plan: &MasterPlan,
        vehicles: u32,
        seed: u64,
        places: Places,
    ) -> Result<Self, Failure> {
        let job = plan.variant.job("", vehicles, seed, plan.time, "");
        let text = json!({ "load": job.scenario.setup.load }).to_string();
        let load = Load::parse(&text, &places).map_err(|error| format!("the load: {error}"))?;
        let mut pool = OrderPool::new(Arc::new(places));
        pool.set_assigner(InTurn);
        pool.add_load(&load);
        Ok(Self { pool, vehicles: vehicles as usize, robots: BTreeMap::new() })
    }

    /// Returns the orders that have come until a time, in seconds from the start of the load.
    pub fn arrivals(&mut self, secs: f64) -> Vec<Arrival> {
        self.pool.generate_until(secs, self.vehicles);
        let first = self.robots.values().max().map_or(0, |robot| robot + 1);
        let robots = (first..).take(self.pool.waiting_orders().count());
        let robots = robots.map(|robot| Candidate { robot, ..Candidate::default() });
        let changes = self.pool.assign(secs, &robots.collect::<Vec<_>>(), &|_, _| Some(0.0));
        let mut arrivals = Vec::new();
        for (id, robot) in changes.assigned {
            self.robots.insert(id, robot);
            let Some(stops) = self.pool.order(id).map(|order| &order.content.stops) else {
                continue;
            };
            if let [first, .., last] = &stops[..] {
                arrivals.push(Arrival { number: id.0, nodes: [first.node, last.node] });
            }
        }
        self.pool.events();
        arrivals
    }

    /// Notes that an order is finished.
    pub fn finish(&mut self, number: u64, secs: f64) {
        let Some(robot) = self.robots.remove(&OrderId(number)) else { return };
        while self.pool.arrived(robot, secs).is_some() {
            self.pool.handled(robot, secs);
        }
        self.pool.events();
    }
}
