//! Queues: places before a station where robots wait until they may drive to it.

use std::collections::BTreeMap;

use regatta_orders::OrderPool;

use super::{Manager, Progress};
use crate::roads::Roads;

/// The queues of all stations that have one.
#[derive(Debug, Default)]
pub(super) struct Queues {
    queues: Vec<Queue>,
    /// By node: the queue of the station there.
    by_station: BTreeMap<u32, usize>,
    /// By robot: the queue that it is in.
    by_robot: BTreeMap<u32, usize>,
}

#[derive(Debug)]
struct Queue {
    /// The station's node.
    station: u32,
    /// The nodes to wait at, the nearest first; at least one.
    places: Vec<u32>,
    /// Whether a road that is driven both ways leads to the last place: robots that waited on it
    /// would be in the way of others.
    keeps_road_free: bool,
    /// The robot that may drive to the station or is there, and then those that wait.
    robots: Vec<u32>,
}

/// The node that a robot is to drive to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// The station itself.
    Station,
    /// This node, where it waits for the station.
    Place(u32),
    /// None yet: it waits where it is, and makes way for others.
    Later,
}

impl Queues {
    pub fn new(orders: &OrderPool, roads: &Roads) -> Self {
        let mut queues = Self::default();
        for (station, places) in orders.queues() {
            queues.by_station.insert(station, queues.queues.len());
            let keeps_road_free = places.last().is_some_and(|last| is_on_two_way(roads, *last));
            let (places, robots) = (places.to_vec(), Vec::new());
            queues.queues.push(Queue { station, places, keeps_road_free, robots });
        }
        queues
    }

    /// Puts a robot that is sent to a node at the end of the queue there, unless it is in it.
    fn join(&mut self, robot: u32, node: u32) -> Slot {
        let queue = self.by_station.get(&node).copied();
        if self.by_robot.get(&robot).copied() != queue {
            self.leave(robot);
        }
        let Some(index) = queue else { return Slot::Station };
        if self.by_robot.insert(robot, index).is_none() {
            self.queues[index].robots.push(robot);
        }
        self.queues[index].slot_of(robot)
    }

    /// Takes a robot out of its queue, if it is in one.
    pub fn leave(&mut self, robot: u32) {
        if let Some(index) = self.by_robot.remove(&robot) {
            self.queues[index].robots.retain(|other| *other != robot);
        }
    }
}

/// Whether a road from a node to a next one leads back, too.
fn is_on_two_way(roads: &Roads, node: u32) -> bool {
    roads.exits(node).iter().any(|leg| {
        let next = roads.end(*leg);
        roads.exits(next).iter().any(|back| roads.end(*back) == node)
    })
}

impl Queue {
    /// The slot of a robot of the queue.
    fn slot_of(&self, robot: u32) -> Slot {
        self.slot(self.robots.iter().position(|other| *other == robot).unwrap_or_default())
    }

    /// The slot of the robot at an index of the queue. Beyond the places, robots come to the last
    /// one on a road that is driven one way, and wait before it.
    fn slot(&self, index: usize) -> Slot {
        let Some(before) = index.checked_sub(1) else { return Slot::Station };
        match (self.places.get(before), self.places.last()) {
            (Some(node), _) => Slot::Place(*node),
            (None, Some(last)) if !self.keeps_road_free => Slot::Place(*last),
            (None, _) => Slot::Later,
        }
    }
}

impl Manager {
    /// Sends a robot to the node of its stop, or to a place in the queue before it.
    pub(super) fn send(&mut self, robot: u32, node: u32) {
        let slot = self.queues.join(robot, node);
        self.send_to(robot, node, slot);
        if slot == Slot::Later {
            self.orders.queued(robot, self.steering.now());
        }
        if slot != Slot::Station && self.steering.base_end_node(robot) == Some(node) {
            self.put_first(robot, node);
        }
    }

    /// Puts a robot that is at a station first in the queue there, unless another one is served.
    fn put_first(&mut self, robot: u32, station: u32) {
        let Some(index) = self.queues.by_station.get(&station).copied() else { return };
        let robots = &mut self.queues.queues[index].robots;
        let is_busy = robots
            .first()
            .is_some_and(|first| matches!(self.progress[*first as usize], Progress::AtStop(_)));
        if !is_busy {
            robots.retain(|other| *other != robot);
            robots.insert(0, robot);
            self.send_to(robot, station, Slot::Station);
        }
    }

    fn send_to(&mut self, robot: u32, node: u32, slot: Slot) {
        let progress = &mut self.progress[robot as usize];
        match slot {
            Slot::Station => {
                *progress = Progress::Driving(node);
                self.steering.send(robot, node);
            }
            Slot::Place(place) => {
                *progress = Progress::Queueing { stop: node, place: Some(place) };
                self.steering.send(robot, place);
            }
            Slot::Later => {
                *progress = Progress::Queueing { stop: node, place: None };
                self.steering.halt(robot);
            }
        }
    }

    /// Lets the robots of all queues move up.
    pub(super) fn move_up(&mut self) {
        for index in 0..self.queues.queues.len() {
            self.let_nearest_through(index);
            for place in 0..self.queues.queues[index].robots.len() {
                let queue = &self.queues.queues[index];
                let (station, robot, slot) =
                    (queue.station, queue.robots[place], queue.slot(place));
                let is_there = match self.progress[robot as usize] {
                    Progress::Queueing { place, .. } => {
                        slot == place.map_or(Slot::Later, Slot::Place)
                    }
                    Progress::Driving(_) => slot == Slot::Station,
                    Progress::Free | Progress::AtStop(_) => true,
                };
                if !is_there {
                    self.send_to(robot, station, slot);
                }
            }
        }
    }

    /// Lets a robot that waits at its place change with the one before it that is still on its way,
    /// and not nearer to the station.
    fn let_nearest_through(&mut self, index: usize) {
        for behind in 1..self.queues.queues[index].robots.len() {
            let Queue { station, robots, .. } = &self.queues.queues[index];
            let (station, pair) = (*station, [robots[behind - 1], robots[behind]]);
            let [is_ahead_waiting, waits] = pair.map(|robot| self.waits_in_queue(robot));
            let is_at_stop = matches!(self.progress[pair[0] as usize], Progress::AtStop(_));
            if waits && !is_ahead_waiting && !is_at_stop {
                let [ahead_secs, secs] = pair.map(|robot| self.secs_to(robot, station));
                // The base of one that stands behind the other ends at the same node.
                if ahead_secs >= secs {
                    self.queues.queues[index].robots.swap(behind - 1, behind);
                }
            }
        }
    }

    /// Whether a robot stands at a place of a queue.
    pub(super) fn waits_in_queue(&self, robot: u32) -> bool {
        let progress = self.progress.get(robot as usize);
        matches!(progress, Some(Progress::Queueing { place: Some(_), .. }))
            && self.steering.robot(robot).is_some_and(|state| state.is_pinned())
    }

    /// The driving time of a robot to a node, in seconds; infinity if it isn't known.
    fn secs_to(&mut self, robot: u32, node: u32) -> f64 {
        let roads = self.steering.roads().clone();
        self.times.prepare(&roads, node);
        let from = self.steering.base_end_node(robot);
        from.and_then(|from| self.times.between(&roads, from, node)).unwrap_or(f64::INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use regatta_orders::{Change, Load, OrderPool, Places};
    use regatta_plugin::world::Orientation;

    use super::*;
    use crate::model::managed::Managed;
    use crate::model::worlds;
    use crate::planner::PlannerKind;

    /// A loop: picks at node 0, and drops at node 4 behind two places to wait at.
    const LOAD: &str = "load: {stations: [{at: 4, queue: [3, 2]}], \
                        endless: robots, from: 0, to: 4, dwell: {pick: 2, drop: 90}}";

    fn loop_of_eight() -> regatta_plugin::world::WorldData {
        let points = [
            [0.0, 0.0],
            [15.0, 0.0],
            [30.0, 0.0],
            [45.0, 0.0],
            [60.0, 0.0],
            [60.0, 30.0],
            [30.0, 30.0],
            [0.0, 30.0],
        ];
        let edges = [[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 6], [6, 7], [7, 0]];
        worlds::straight(&points, &edges, [0.9, 0.6], Orientation::Tangential)
    }

    #[test]
    fn robots_move_up_in_the_order_of_the_queue() {
        let world = loop_of_eight();
        let view = world.view(1, 1);
        let places = std::sync::Arc::new(Places::of(&view));
        let mut orders = OrderPool::new(places.clone());
        orders.add_load(&Load::parse(LOAD, &places).expect("a load"));
        let mut queues = Queues::new(&orders, &Roads::new(&view));
        let slots: Vec<Slot> = (10..14).map(|robot| queues.join(robot, 4)).collect();
        let [nearest, last] = [3, 2].map(Slot::Place);
        assert_eq!(slots, [Slot::Station, nearest, last, last], "the road is driven one way");
        assert_eq!(queues.join(11, 4), nearest, "it is in the queue already");
        assert_eq!(queues.join(9, 7), Slot::Station, "there is no queue");
        assert_eq!(queues.join(10, 0), Slot::Station, "it has left");
        assert_eq!([11, 12, 13].map(|robot| queues.join(robot, 4)), [Slot::Station, nearest, last]);
        queues.leave(12);
        assert_eq!(queues.join(13, 4), nearest);
        let track = worlds::single_track(7);
        let mut queues = Queues::new(&orders, &Roads::new(&track.view(1, 1)));
        let slots: Vec<Slot> = (10..14).map(|robot| queues.join(robot, 4)).collect();
        assert_eq!(slots, [Slot::Station, nearest, last, Slot::Later], "it is driven both ways");
    }

    #[test]
    fn robots_wait_at_the_places_before_a_busy_station() {
        let mut fleet = Managed::new(&loop_of_eight(), 4, 1, LOAD, PlannerKind::Lanes);
        let (mut queued, mut dropped, mut waited) = (0, 0, false);
        for _ in 0..36_000 {
            fleet.run(1, 0, 0);
            for event in fleet.manager.orders_mut().events() {
                queued += u32::from(matches!(event.change, Change::Queued { .. }));
                dropped += u32::from(matches!(event.change, Change::Handled { stop: 1, .. }));
            }
            let waiting = (0..4).filter(|robot| fleet.manager.waits_in_queue(*robot)).count();
            waited |= waiting == 2;
        }
        // An hour at 0.1 s a tick: a drop takes 90 s, and the way from the nearest place some 15 s.
        assert!((32..=40).contains(&dropped), "{dropped}");
        assert!(queued > 30 && waited, "{queued}");
    }
}
