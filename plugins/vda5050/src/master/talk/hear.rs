//! Answers of a vehicle: its states about the order that it was told, about requests to cancel
//! it, and about actions.

use super::{After, Cancel, News, RETRY_SECS, Talk, Told, has_order};
use crate::message::{ActionState, ActionStatus, Error, State, Topic};

/// The types of errors about orders, in 2.x and in 3.0.
const REJECTIONS: [&str; 14] = [
    "validationError",
    "orderError",
    "orderUpdateError",
    "noRouteError",
    "VALIDATION_FAILURE",
    "INVALID_ORDER",
    "UNSUPPORTED_PARAMETER",
    "OTHER_ORDER_ACTIVE",
    "OUTDATED_ORDER_UPDATE",
    "SAME_ORDER_UPDATE_ID",
    "ORDER_UPDATE_FOLLOWING_CANCEL",
    "START_NODE_OUT_OF_RANGE",
    "NO_ROUTE_TO_TARGET",
    "INVALID_ORDER_ACTION",
];

impl Talk {
    /// Takes a state.
    pub fn take(&mut self, state: &State, now: f64) -> Vec<News> {
        let mut news = Vec::new();
        self.take_jobs(state, &mut news);
        let has_none = self.told.is_none() && !has_order(state) && !state.driving;
        if let Some(cancel) = self.cancel.take_if(|cancel| has_none || cancel.is_done(state)) {
            self.told = None;
            news.push(News::Cancelled(cancel.after));
            return news;
        }
        let Some(told) = &mut self.told else { return news };
        let is_of = told.part.order_id == state.order_id;
        if is_of && state.order_update_id >= told.part.update_id {
            if !told.is_taken {
                self.rejection = None;
            }
            told.is_taken = true;
            if state.node_states.is_empty() && told.is_unreached(state) {
                news.push(News::OrderLost);
            }
        } else if told.is_taken {
            news.push(News::OrderLost);
        } else if let Some(error) = state.errors.iter().find(|error| told.is_rejected_by(error)) {
            news.push(self.reject(error, state, now));
        }
        if news.contains(&News::OrderLost) {
            self.told = None;
        }
        news
    }

    fn reject(&mut self, error: &Error, state: &State, now: f64) -> News {
        let text = error.error_description.clone().unwrap_or_default();
        let reason = format!("{}: {text}", error.error_type);
        self.rejection = Some((reason.clone(), now + RETRY_SECS));
        self.told = None;
        // An action id stands for one action of one order.
        let id = self.next_id();
        if let Some(job) = self.jobs.first_mut() {
            job.action_id = id;
        }
        if has_order(state) {
            self.cancel(After::GoOn);
        }
        News::Rejected(reason)
    }

    /// Takes the ends of actions where the vehicle stands.
    fn take_jobs(&mut self, state: &State, news: &mut Vec<News>) {
        self.jobs.retain(|job| {
            let found = state.action_states.iter().find(|it| it.action_id == job.action_id);
            let Some(found) = found.filter(|it| it.action_status.is_over()) else { return true };
            if found.action_status == ActionStatus::Failed {
                let result = found.action_result.clone().unwrap_or_default();
                news.push(News::ActionFailed(job.action_type.clone(), result));
            }
            false
        });
    }
}

impl Told {
    /// Whether the base isn't driven to its end.
    fn is_unreached(&self, state: &State) -> bool {
        self.part.start + u64::from(state.last_node_sequence_id) / 2 < self.part.base_end
    }

    /// Whether an error is about this order.
    fn is_rejected_by(&self, error: &Error) -> bool {
        if error.reference("topic").is_some_and(|topic| topic != Topic::Order.name()) {
            return false;
        }
        let is_update = error
            .reference("orderUpdateId")
            .is_none_or(|update| update == self.part.update_id.to_string());
        let is_order = error.reference("orderId").map_or_else(
            || REJECTIONS.contains(&error.error_type.as_str()) && self.tries == 1,
            |order| order == self.part.order_id,
        );
        is_order && is_update
    }
}

impl Cancel {
    /// Whether the vehicle has stopped, or had no order.
    fn is_done(&self, state: &State) -> bool {
        let has_stopped = !state.driving && state.node_states.is_empty();
        let mut found = self.ids.iter().filter_map(|id| find_action(state, id));
        found.any(|action| match action.action_status {
            ActionStatus::Failed => true,
            ActionStatus::Finished => has_stopped,
            _ => false,
        })
    }
}

fn find_action<'a>(state: &'a State, id: &str) -> Option<&'a ActionState> {
    let instant = state.instant_action_states.iter().flatten();
    state.action_states.iter().chain(instant).find(|action| action.action_id == id)
}
