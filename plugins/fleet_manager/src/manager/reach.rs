//! Orders whose stops robots can't reach: the layout has no way there, or edges are closed.

use std::collections::BTreeMap;

use regatta_orders::{NewOrder, Order, OrderId, Service, State, Stop, Unroutable};

use super::Manager;
use crate::charging::Charge;
use crate::roads::Roads;
use crate::steering::Steering;

/// The largest number of nodes that a warning names.
const MOST_NAMED: usize = 6;

impl Manager {
    /// Makes the orders whose time has come.
    pub(super) fn generate(&mut self, now_secs: f64) {
        if self.orders.has_loads_for_types() {
            self.orders.set_fleet(self.robots_by_type());
        }
        let ways = Ways::of(&self.steering, &self.present, &self.robot_types);
        self.orders.generate_feasible_until(now_secs, self.present.len(), &|order| {
            ways.is_feasible(order)
        });
    }

    /// The number of robots of each type.
    fn robots_by_type(&self) -> Vec<usize> {
        let mut counts = Vec::new();
        for robot in &self.present {
            let robot_type = self.robot_types[*robot as usize] as usize;
            counts.resize(counts.len().max(robot_type + 1), 0);
            counts[robot_type] += 1;
        }
        counts
    }

    /// Tries orders again that couldn't be reached before roads were closed or opened, or before
    /// robots came or were moved to other parts of the roads, and finds those that can't be reached
    /// any more.
    pub(super) fn reconsider(&mut self, now_secs: f64) {
        let ways = Ways::of(&self.steering, &self.present, &self.robot_types);
        let closures = self.steering.closure_changes();
        // In most cycles nothing has changed, and nothing is allocated.
        if self.checked.0 != closures || !ways.parts().eq(self.checked.1.iter().copied()) {
            self.checked = (closures, ways.parts().collect());
            let lost = self.orders.open_orders().filter(|order| order.state == State::Unroutable);
            let mut back: Vec<&Order> = lost.filter(|order| !self.is_out_of_reach(order)).collect();
            back.retain(|order| self.obstacle(&order.content).is_none());
            for id in back.iter().map(|order| order.id).collect::<Vec<_>>() {
                self.orders.reopen(id, now_secs);
            }
        }
        // A robot would have to search all roads for each of them.
        if self.steering.has_closures() {
            let lost = self.orders.waiting_orders().filter(|order| self.is_out_of_reach(order));
            for id in lost.map(|order| order.id).collect::<Vec<OrderId>>() {
                self.orders.unroutable(id, now_secs, Unroutable::ClosedEdges);
            }
        }
    }

    /// Whether closures keep robots from coming to an order's next stop.
    fn is_out_of_reach(&self, order: &Order) -> bool {
        let next = order.content.stops.get(order.handled_stops);
        next.is_some_and(|stop| self.steering.is_out_of_reach(stop.node))
    }

    /// Gives up the order of a robot that can't reach its next stop. Where closures have cut off
    /// the robot and not the stop, another robot may carry it out; a robot that has begun it waits
    /// until roads are open again.
    pub(super) fn give_up(&mut self, robot: u32, now_secs: f64) {
        if self.steering.has_closures() && self.orders.is_bound(robot) {
            return;
        }
        let node = self.steering.base_end_node(robot);
        let is_cut_off = node.is_some_and(|node| self.steering.is_cut_off(node));
        let is_for_others = is_cut_off || self.is_for_others(robot);
        self.halt(robot);
        match self.orders.withdraw(robot, now_secs) {
            Ok(_) if is_for_others => {}
            Ok(id) => {
                let reason = match self.steering.has_closures() {
                    true => Unroutable::ClosedEdges,
                    false => Unroutable::NoWay,
                };
                self.orders.unroutable(id, now_secs, reason);
            }
            Err(_) => {
                self.orders.failed(robot, now_secs, "no way leads to its next stop");
            }
        }
    }

    /// Whether no way leads a robot to its next stop, but one leads another robot there.
    fn is_for_others(&self, robot: u32) -> bool {
        let Some(Stop { node: goal, .. }) = self.orders.current_stop(robot) else { return false };
        let order = self.orders.order_of(robot).and_then(|id| self.orders.order(id));
        let types = order.map_or(&[][..], |order| order.content.robot_types.as_slice());
        let ways = Ways::of(&self.steering, &self.present, &self.robot_types);
        !ways.lead(robot, goal) && ways.lead_any(goal, types)
    }

    /// Warns of the nodes where orders of the load end, and from which no way leads back to the
    /// part of the roads that has most of its stops.
    pub(super) fn warn_of_traps(&mut self) {
        let (roads, stops) = (self.steering.roads(), self.orders.load_stops());
        let mut of_parts: BTreeMap<u32, (usize, u32)> = BTreeMap::new();
        for &stop in &stops.all {
            of_parts.entry(roads.part_of(stop)).or_insert((0, stop)).0 += 1;
        }
        let most = of_parts.values().copied().rev().max_by_key(|(count, _)| *count);
        let Some((_, main)) = most else { return };
        let traps = stops.last.iter().copied();
        let traps: Vec<u32> = traps
            .filter(|stop| roads.can_reach(main, *stop) && !roads.can_reach(*stop, main))
            .collect();
        if traps.is_empty() {
            return;
        }
        let places = self.orders.places();
        let mut names: Vec<String> = traps
            .iter()
            .take(MOST_NAMED)
            .map(|node| format!("`{}`", places.label(*node)))
            .collect();
        if let Some(more @ 1..) = traps.len().checked_sub(MOST_NAMED) {
            names.push(format!("{more} more"));
        }
        self.warnings.push(format!(
            "orders end at {}, from which no way leads back: their robots stay there",
            names.join(", ")
        ));
        self.traps.extend(traps);
    }

    /// Warns of a robot that has come to a station which never opens again.
    pub(super) fn warn_of_closed_station(&mut self, robot: u32, node: u32, service: Service) {
        if service.begin_secs.is_infinite() {
            self.warnings.push(format!(
                "robot {robot} stays at {} for good: its station never opens again; give later \
                 opening times, or `every`",
                self.orders.places().label(node)
            ));
        }
    }

    /// Returns the reason for which no robot can ever carry an order out, if any.
    fn obstacle(&self, order: &NewOrder) -> Option<Unroutable> {
        let obstacle = Ways::of(&self.steering, &self.present, &self.robot_types).obstacle(order);
        obstacle
            .or_else(|| self.exceeds_batteries(order, Charge::Full).then_some(Unroutable::Battery))
    }

    /// Marks the waiting orders that no robot can carry out, and warns of stops from which no way
    /// leads on. An order is judged again only if robots have come to other parts of the roads, or
    /// the ways to chargers are known.
    pub(super) fn find_impossible(&mut self, now_secs: f64) {
        let ways = Ways::of(&self.steering, &self.present, &self.robot_types);
        let judged_for = (ways.parts().collect(), self.charging.is_measured());
        let mut ids = self.orders.take_new_waiting();
        if judged_for != self.judged_for {
            ids = self.orders.waiting_orders().map(|order| order.id).collect();
        }
        if self.charging.is_needed() {
            let roads = self.steering.roads().clone();
            let orders = ids.iter().filter_map(|id| self.orders.waiting_order(*id));
            for stop in orders.flat_map(|order| &order.content.stops) {
                self.times.prepare(&roads, stop.node);
            }
        }
        let mut impossible = Vec::new();
        for order in ids.into_iter().filter_map(|id| self.orders.waiting_order(id)) {
            let obstacle = self.obstacle(&order.content);
            if obstacle.is_none() && self.exceeds_batteries(&order.content, Charge::Usual) {
                self.for_full_batteries.insert(order.id);
            }
            if let Some(obstacle) = obstacle {
                impossible.push((order.id, obstacle));
            } else if let Some(node) = ways.trap(order).filter(|node| self.traps.insert(*node)) {
                self.warnings.push(format!(
                    "order {} ends at {}, from which no way leads back: its robot stays there",
                    order.content.name,
                    self.orders.places().label(node)
                ));
            }
        }
        for (id, obstacle) in impossible {
            self.orders.unroutable(id, now_secs, obstacle);
        }
        self.judged_for = judged_for;
    }
}

/// The ways of the layout that lead robots to nodes, closed roads included.
struct Ways<'a> {
    roads: &'a Roads,
    steering: &'a Steering,
    present: &'a [u32],
    /// By robot.
    robot_types: &'a [u32],
}

impl<'a> Ways<'a> {
    fn of(steering: &'a Steering, present: &'a [u32], robot_types: &'a [u32]) -> Self {
        Self { roads: steering.roads(), steering, present, robot_types }
    }

    /// Returns the robots, and the part of the roads in which each is, if its place is known.
    fn parts(&self) -> impl Iterator<Item = (u32, Option<u32>)> + '_ {
        self.present.iter().map(|robot| {
            let node = self.steering.base_end_node(*robot);
            (*robot, node.map(|node| self.roads.part_of(node)))
        })
    }

    /// Whether no closure keeps robots from the stops of a new order or from leaving them. During a
    /// closure, an order to a node where a robot stands already isn't feasible: a robot that is cut
    /// off would carry out one in each cycle. Other obstacles last, and are told.
    fn is_feasible(&self, order: &NewOrder) -> bool {
        if !self.steering.has_closures() {
            return true;
        }
        let is_drive = order.stops.len() > 1 || !self.is_taken(order.stops[0].node);
        is_drive && order.stops.iter().all(|stop| self.is_open(stop.node))
    }

    /// Whether the base of a robot ends at a node.
    fn is_taken(&self, node: u32) -> bool {
        self.present.iter().any(|robot| self.steering.base_end_node(*robot) == Some(node))
    }

    /// Whether no closure keeps robots from coming to a node or from leaving it.
    fn is_open(&self, node: u32) -> bool {
        !self.steering.is_out_of_reach(node) && !self.steering.is_cut_off(node)
    }

    /// Returns the reason for which the layout allows no robot to carry an order out, if any.
    fn obstacle(&self, order: &NewOrder) -> Option<Unroutable> {
        let stops = &order.stops;
        if !stops.windows(2).all(|pair| self.roads.can_reach(pair[0].node, pair[1].node)) {
            return Some(Unroutable::NoWayOn);
        }
        let first = stops.first()?.node;
        let leads = match order.intended_robot {
            Some(robot) if !self.is_present(robot) => return Some(Unroutable::NoRobot),
            Some(robot) => self.lead(robot, first),
            None if !self.has_any(&order.robot_types) => return Some(Unroutable::NoType),
            None => self.lead_any(first, &order.robot_types),
        };
        (!leads).then_some(Unroutable::NoWay)
    }

    /// Returns the last stop of an order if no way leads on from there, neither to another stop
    /// nor back to a robot that could come.
    fn trap(&self, order: &Order) -> Option<u32> {
        let stops = &order.content.stops;
        let last = stops.last()?.node;
        let roads = self.roads;
        let mut exits = roads.exits(last).iter().map(|leg| roads.end(*leg));
        if exits.any(|next| self.roads.can_reach(next, last)) {
            return None;
        }
        let places = self.present.iter().filter_map(|robot| self.steering.base_end_node(*robot));
        let others = stops.iter().map(|stop| stop.node).chain(places).filter(|at| *at != last);
        let mut is_trap = false;
        for at in others.filter(|at| *at != last) {
            if self.roads.can_reach(last, at) {
                return None;
            }
            is_trap |= self.roads.can_reach(at, last);
        }
        is_trap.then_some(last)
    }

    /// Whether a robot is in the fleet, or there are no robots yet.
    fn is_present(&self, robot: u32) -> bool {
        self.present.is_empty() || self.present.binary_search(&robot).is_ok()
    }

    /// Whether a way leads a robot to a node, or its place isn't known.
    fn lead(&self, robot: u32, goal: u32) -> bool {
        let node = self.steering.base_end_node(robot);
        node.is_none_or(|node| self.roads.can_reach(node, goal))
    }

    /// Whether a robot of some types is in the fleet, or there are no robots yet.
    fn has_any(&self, types: &[u32]) -> bool {
        self.present.is_empty() || self.present.iter().any(|robot| self.is_of(*robot, types))
    }

    /// Whether a way leads any robot of some types to a node, or there are no robots yet.
    fn lead_any(&self, goal: u32, types: &[u32]) -> bool {
        let mut fitting = self.present.iter().filter(|robot| self.is_of(**robot, types));
        self.present.is_empty() || fitting.any(|robot| self.lead(*robot, goal))
    }

    /// Whether a robot is of some types; all are if there are none.
    fn is_of(&self, robot: u32, types: &[u32]) -> bool {
        types.is_empty() || types.contains(&self.robot_types[robot as usize])
    }
}
