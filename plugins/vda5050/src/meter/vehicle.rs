//! A vehicle as the meter sees it.

use rustc_hash::{FxHashMap, FxHashSet};

use super::figures::{Answer, BaseWait};
use super::holds::Holds;
use super::route::Route;
use crate::message::{Action, ActionState, ActionStatus, Order, State};

const PICK: &str = "pick";
const DROP: &str = "drop";

/// A vehicle, its order, and its request for a base.
#[derive(Debug, Default)]
pub(super) struct Vehicle {
    route: Option<Route>,
    /// The actions to pick and to drop that aren't over, by their ids.
    actions: FxHashMap<String, Handling>,
    /// The node where it has picked its load.
    picked: Option<String>,
    last_node: String,
    last_sequence_id: u32,
    request: Option<Request>,
    /// The time since which it has nothing to do.
    idle_since: Option<f64>,
    errors: Vec<String>,
}

/// An action at a node.
#[derive(Clone, Debug)]
struct Handling {
    is_pick: bool,
    node: String,
}

/// A request for the next base.
#[derive(Clone, Debug)]
struct Request {
    since: f64,
    /// The time since which the vehicle stands at the end of its base.
    standing_since: Option<f64>,
    /// The end of its base.
    node: String,
    sequence_id: u32,
}

impl Vehicle {
    /// Whether it has said at which node it is.
    pub fn is_placed(&self) -> bool {
        !self.last_node.is_empty()
    }

    /// Whether it has had an order.
    pub fn has_had_orders(&self) -> bool {
        self.route.is_some()
    }

    /// The nodes from its last one to the end of its base.
    pub fn held_nodes(&self) -> FxHashSet<String> {
        let route = self.route.iter().flat_map(|route| route.from(self.last_sequence_id));
        let base = route.filter(|step| step.is_released).map(|step| step.node.clone());
        base.chain(Some(self.last_node.clone()).filter(|_| self.is_placed())).collect()
    }

    /// Takes an order or an update. Returns the base that the vehicle had asked for, and how long
    /// it had nothing to do since its last order.
    pub fn take_order(
        &mut self,
        order: &Order,
        name: &str,
        time: f64,
        holds: &Holds,
    ) -> (Option<BaseWait>, Option<f64>) {
        self.note_actions(order);
        let known = self.route.as_mut().filter(|route| route.order_id == order.order_id);
        let Some(route) = known else {
            self.request = None;
            self.last_sequence_id = order.nodes.first().map_or(0, |node| node.sequence_id);
            let idle_since = self.idle_since.take();
            let is_first = self.route.replace(Route::of(order)).is_none();
            return (None, idle_since.filter(|_| !is_first).map(|since| time - since));
        };
        if order.order_update_id <= route.update_id {
            return (None, None);
        }
        // The edges of a horizon that an update leaves out are those that were asked for.
        let before = route.clone();
        route.update(order);
        let wait = self.answer(&before, name, time, holds);
        (wait, None)
    }

    /// The request that the route answers, if it has more of a base than before.
    fn answer(&mut self, before: &Route, name: &str, time: f64, holds: &Holds) -> Option<BaseWait> {
        let route = self.route.as_ref()?;
        let request = self.request.as_ref()?;
        let mut new: Vec<&str> = Vec::new();
        for step in route.from(request.sequence_id + 1).filter(|step| step.is_released) {
            new.push(&step.node);
        }
        let next_node = (*new.first()?).to_owned();
        let is_free = new.iter().all(|node| holds.is_free_since(node, name, request.since));
        let answer = if is_free { Answer::Free } else { Answer::Held };
        let edges = [before, route].map(|route| route.edges_at(request.sequence_id));
        let [[came_by, _], [_, goes_by]] = edges;
        let wait = request.wait(name, time, Some(next_node), [came_by, goes_by], answer);
        (self.request, self.idle_since) = (None, None);
        Some(wait)
    }

    /// Ends the measurement. Returns the base that it still waits for, if its order has more.
    pub fn end(&mut self, name: &str, time: f64, holds: &Holds) -> Option<BaseWait> {
        let (route, request) = (self.route.as_ref()?, self.request.take()?);
        let ahead: Vec<&str> = route.ahead().map(|step| &*step.node).collect();
        let next_node = (*ahead.first()?).to_owned();
        let is_free = ahead.iter().all(|node| holds.is_free_since(node, name, request.since));
        let answer = if is_free { Answer::MissingFree } else { Answer::MissingHeld };
        let edges = route.edges_at(request.sequence_id);
        Some(request.wait(name, time, Some(next_node), edges, answer))
    }

    /// Remembers where the order picks and drops.
    fn note_actions(&mut self, order: &Order) {
        for node in &order.nodes {
            for Action { action_type, action_id, .. } in &node.actions {
                let is_pick = action_type == PICK;
                if is_pick || action_type == DROP {
                    let handling = Handling { is_pick, node: node.node_id.clone() };
                    self.actions.insert(action_id.clone(), handling);
                }
            }
        }
    }

    /// Takes a state. Returns the transports that it shows as finished: pick and drop.
    pub fn take_state(&mut self, state: &State, time: f64) -> Vec<(String, String)> {
        self.last_node.clone_from(&state.last_node_id);
        let carried = self.finish_actions(&state.action_states);
        let current = self.route.as_ref().filter(|route| route.order_id == state.order_id);
        let is_current = current.is_some_and(|route| route.update_id == state.order_update_id);
        if current.is_some() {
            self.last_sequence_id = state.last_node_sequence_id;
        }
        if is_current {
            self.note_request(state, time);
        }
        let is_over = state.action_states.iter().all(|action| action.action_status.is_over());
        let is_idle = state.node_states.is_empty() && is_over;
        if is_idle && (is_current || self.route.is_none()) {
            self.idle_since.get_or_insert(time);
        }
        carried
    }

    fn finish_actions(&mut self, states: &[ActionState]) -> Vec<(String, String)> {
        let mut carried = Vec::new();
        for state in states.iter().filter(|state| state.action_status.is_over()) {
            let Some(handling) = self.actions.remove(&state.action_id) else { continue };
            if state.action_status != ActionStatus::Finished {
                continue;
            }
            if handling.is_pick {
                self.picked = Some(handling.node);
            } else if let Some(pick) = self.picked.take() {
                carried.push((pick, handling.node));
            }
        }
        carried
    }

    /// Notes that the vehicle asks for its next base: not before it has done its work at the end of
    /// this one. At the end of an order without a horizon it asks, too, in case that an update
    /// comes.
    fn note_request(&mut self, state: &State, time: f64) {
        let Some(route) = &self.route else { return };
        let Some(end) = route.base_end() else { return };
        let is_at_end = state.last_node_sequence_id >= end.sequence_id;
        let has_horizon = route.ahead().next().is_some();
        let asks = is_at_end || has_horizon && state.new_base_request == Some(true);
        if !asks || !end.is_handled(&state.action_states) {
            return;
        }
        let request = self.request.get_or_insert_with(|| Request {
            since: time,
            standing_since: None,
            node: end.node.clone(),
            sequence_id: end.sequence_id,
        });
        if is_at_end {
            request.standing_since.get_or_insert(time);
        }
    }

    /// The types of errors that the state before didn't have.
    pub fn new_errors(&mut self, state: &State) -> Vec<String> {
        let now: Vec<String> = state.errors.iter().map(|error| error.error_type.clone()).collect();
        let mut known = std::mem::replace(&mut self.errors, now.clone());
        let mut new = now;
        new.retain(|kind| match known.iter().position(|other| other == kind) {
            Some(index) => {
                known.swap_remove(index);
                false
            }
            None => true,
        });
        new
    }
}

impl Request {
    fn wait(
        &self,
        vehicle: &str,
        time: f64,
        next_node: Option<String>,
        edges: [Option<String>; 2],
        answer: Answer,
    ) -> BaseWait {
        BaseWait {
            vehicle: vehicle.to_owned(),
            node: self.node.clone(),
            next_node,
            edges,
            secs: time - self.since,
            standing_secs: self.standing_since.map_or(0.0, |since| time - since),
            answer,
        }
    }
}
