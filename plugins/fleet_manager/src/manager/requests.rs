//! Requests of other processes: to send a robot somewhere, and to call it back.

use regatta_plugin::manager::{ManagerAnswer, ManagerRequest, ManagerRequestKind, ManagerResponse};

use super::Manager;

impl Manager {
    /// Answers a request, and carries it out from the next cycle on. `run_id` is that of the world.
    pub fn request(&mut self, request: &ManagerRequest, run_id: u64) -> ManagerResponse {
        let (answer, id) = match request.kind() {
            Some(ManagerRequestKind::Send) => {
                self.send_on_request(request.robot, request.node, run_id)
            }
            Some(ManagerRequestKind::Recall) => (self.recall(request.robot), 0),
            None => (ManagerAnswer::UnknownKind, 0),
        };
        ManagerResponse::new(request, answer, id)
    }

    fn send_on_request(&mut self, robot: u32, node_id: u32, run_id: u64) -> (ManagerAnswer, u64) {
        if self.steering.robot(robot).is_none() {
            return (ManagerAnswer::UnknownRobot, 0);
        }
        let Some(node) = self.orders.places().with_id(node_id) else {
            return (ManagerAnswer::UnknownNode, 0);
        };
        let roads = self.steering.roads().clone();
        self.times.prepare(&roads, node);
        let has_no_way = match self.steering.base_end_node(robot) {
            Some(from) => self.times.between(&roads, from, node).is_none(),
            None => false,
        };
        if has_no_way || self.steering.is_out_of_reach(node) {
            return (ManagerAnswer::NoWay, 0);
        }
        let (id, is_free) = self.orders.send(robot, node, run_id, self.steering.now());
        if is_free {
            self.halt(robot);
        }
        (if is_free { ManagerAnswer::Now } else { ManagerAnswer::Later }, id.0)
    }

    fn recall(&mut self, robot: u32) -> ManagerAnswer {
        let had = self.orders.order_of(robot);
        if !self.orders.recall(robot, self.steering.now()) {
            return ManagerAnswer::NotSent;
        }
        if had != self.orders.order_of(robot) {
            self.halt(robot);
        }
        ManagerAnswer::Now
    }
}
