//! Requests: from the web API, and to send a robot somewhere at once.

use super::{Change, NewOrder, OrderId, OrderPool, Request, Stop, Threads, WithdrawError};
use crate::order::{Action, OrderName, State};

impl OrderPool {
    /// Takes the requests of the web API since the last call. Returns the robots whose orders were
    /// withdrawn: they are free now.
    pub fn take_requests(&mut self, now_secs: f64) -> Vec<u32> {
        let mut free = Vec::new();
        for request in self.threads.as_mut().map(Threads::requests).unwrap_or_default() {
            match request {
                Request::Post { orders, created_secs } => {
                    for order in orders {
                        self.create(created_secs.min(now_secs), now_secs, order);
                    }
                }
                Request::Withdraw { name, immediate, reply } => {
                    match self.cancel(&name, immediate, now_secs) {
                        Ok(robot) => {
                            free.extend(robot);
                            self.replies.push(Box::new(move |()| reply(Ok(()))));
                        }
                        Err(error) => reply(Err(error)),
                    }
                }
            }
        }
        free
    }

    /// Cancels an order for good; one that its robot has begun only if `immediate`. Returns the
    /// robot that had it.
    ///
    /// # Errors
    /// [`WithdrawError`] if there is no such open order, or it has begun.
    pub fn cancel(
        &mut self,
        name: &OrderName,
        immediate: bool,
        now_secs: f64,
    ) -> Result<Option<u32>, WithdrawError> {
        let id = *self.names.get(name).ok_or(WithdrawError::Unknown)?;
        let order = self.open.get(&id).ok_or(WithdrawError::Unknown)?;
        if order.is_bound() && !immediate {
            return Err(WithdrawError::Begun);
        }
        let robot = order.state.robot();
        let change = Change::Cancelled { robot, reason: "withdrawn".to_owned() };
        self.close(id, State::Cancelled, now_secs, change);
        Ok(robot)
    }

    /// Sends a robot to a node, in place of an earlier request. An order that it hasn't
    /// begun is taken from it; one that it has begun is finished first. `run_id` is that of the
    /// world. Returns the new order, and whether the robot is free for it now.
    pub fn send(&mut self, robot: u32, node: u32, run_id: u64, now_secs: f64) -> (OrderId, bool) {
        self.recall(robot, now_secs);
        let name = OrderName::of_request(robot, self.next_id, run_id);
        let stops = vec![Stop { node, action: Action::None, dwell_secs: 0.0 }];
        let content = NewOrder {
            name,
            stops,
            priority: u8::MAX,
            earliest_secs: 0.0,
            deadline_secs: None,
            intended_robot: Some(robot),
            robot_types: Vec::new(),
        };
        let id = OrderId(self.next_id);
        self.create(now_secs, now_secs, content);
        let is_free = self.order_of(robot).is_none() || self.withdraw(robot, now_secs).is_ok();
        (id, is_free)
    }

    /// Cancels the orders by which a robot was sent somewhere. Returns whether there were any.
    pub fn recall(&mut self, robot: u32, now_secs: f64) -> bool {
        let theirs = self.intended.range((robot, OrderId(0))..=(robot, OrderId(u64::MAX)));
        let orders = theirs.filter_map(|(_, id)| self.open.get(id));
        let sent = orders.filter(|order| order.content.name.is_of_request());
        let sent: Vec<_> = sent.map(|order| (order.id, order.state.robot())).collect();
        for (id, robot) in &sent {
            let change = Change::Cancelled { robot: *robot, reason: "recalled".to_owned() };
            self.close(*id, State::Cancelled, now_secs, change);
        }
        !sent.is_empty()
    }
}
