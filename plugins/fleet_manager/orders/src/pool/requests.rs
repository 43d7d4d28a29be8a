//! Requests from the web API.

use super::{Change, OrderPool, Request, Threads, WithdrawError};
use crate::order::{OrderName, State};

impl OrderPool {
    /// Takes what has come over the web API since the last call. Returns the robots whose orders
    /// were withdrawn, and which are free now.
    pub fn take_requests(&mut self, now_secs: f64) -> Vec<u32> {
        let mut free = Vec::new();
        for request in self.threads.as_mut().map(Threads::requests).unwrap_or_default() {
            match request {
                Request::Post { orders, created_secs } => orders.into_iter().for_each(|order| {
                    self.create(created_secs.min(now_secs), now_secs, order);
                }),
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
}
