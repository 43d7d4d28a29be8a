//! Orders as a vehicle has them: base and horizon after all updates, those that its states show and
//! those that they don't show yet.

use std::collections::VecDeque;

use crate::message::{Action, Edge, Node, NodeState, Order, State};

/// Orders of a vehicle that wait for its answer; the oldest of more are forgotten.
const MOST_WAITING: usize = 16;

/// An order with its updates.
#[derive(Clone, Debug)]
pub(super) struct Route {
    pub order_id: String,
    pub update_id: u32,
    pub nodes: Vec<Node>,
    pub edges: Vec<Edge>,
    /// The part of it that was seen.
    pub extent: Extent,
}

/// The part of an order that was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Extent {
    /// All of it.
    Whole,
    /// Not its beginning, which was sent before.
    End,
}

impl Route {
    pub fn new(order: &Order) -> Self {
        let begins = order.nodes.first().is_some_and(|node| node.sequence_id == 0);
        Self {
            order_id: order.order_id.clone(),
            update_id: order.order_update_id,
            nodes: order.nodes.clone(),
            edges: order.edges.clone(),
            extent: if begins { Extent::Whole } else { Extent::End },
        }
    }

    /// The last node of the base.
    pub fn base_end(&self) -> Option<&Node> {
        self.nodes.iter().rfind(|node| node.released)
    }

    /// The order after an update that begins at the end of its base.
    pub fn updated(&self, order: &Order) -> Self {
        let mut route = self.clone();
        route.update_id = order.order_update_id;
        route.nodes.retain(|node| node.released);
        let end = route.nodes.last().map_or(0, |node| node.sequence_id);
        route.edges.retain(|edge| edge.sequence_id < end);
        route.nodes.extend(order.nodes.iter().skip(1).cloned());
        route.edges.extend(order.edges.iter().cloned());
        route
    }

    /// The node with a sequence id.
    pub fn node(&self, sequence_id: u32) -> Option<&Node> {
        self.nodes.iter().find(|node| node.sequence_id == sequence_id)
    }

    /// The edge with a sequence id.
    pub fn edge(&self, sequence_id: u32) -> Option<&Edge> {
        self.edges.iter().find(|edge| edge.sequence_id == sequence_id)
    }

    /// All actions.
    pub fn actions(&self) -> impl Iterator<Item = &Action> {
        let of_nodes = self.nodes.iter().flat_map(|node| &node.actions);
        of_nodes.chain(self.edges.iter().flat_map(|edge| &edge.actions))
    }

    /// Whether a vehicle has reached a node of the order, by the nodes that are left.
    pub fn is_begun(&self, left: &[NodeState]) -> bool {
        let first = self.nodes.first().map_or(0, |node| node.sequence_id);
        left.first().is_none_or(|node| node.sequence_id > first)
    }

    /// The released edges from a sequence id on, each with its nodes.
    pub fn released_after(&self, sequence_id: u32) -> impl Iterator<Item = (&Edge, [&Node; 2])> {
        let edges = self.edges.iter().zip(self.nodes.windows(2));
        let released = edges.filter(move |(edge, _)| edge.released);
        released
            .filter(move |(edge, _)| edge.sequence_id > sequence_id)
            .map(|(edge, ends)| (edge, [&ends[0], &ends[1]]))
    }

    fn has_ids(&self, order_id: &str, update_id: u32) -> bool {
        self.order_id == order_id && self.update_id == update_id
    }
}

/// An order that was sent, and isn't in a state yet.
#[derive(Clone, Debug)]
pub(super) struct Sent {
    pub order: Order,
    /// The order with its updates; `None` if the vehicle has to reject it.
    pub route: Option<Route>,
    pub time: f64,
}

/// The orders of a vehicle.
#[derive(Debug, Default)]
pub(super) struct Orders {
    /// The order that states show, as far as it was seen.
    pub shown: Option<Route>,
    /// The orders that states don't show yet.
    pub sent: VecDeque<Sent>,
    /// The last order that was sent.
    pub last: Option<Order>,
    pub cancelling: Cancelling,
}

/// Whether the order of a vehicle is cancelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Cancelling {
    /// It isn't.
    #[default]
    No,
    /// The master has asked for it.
    Asked,
}

/// The order of a vehicle, by a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Showing {
    /// The same as the state before.
    Same,
    /// An order that was sent.
    Taken,
    /// The order of the time before this judge has listened.
    Unknown,
    /// An order that wasn't sent.
    NeverSent,
    /// An update that wasn't sent.
    UpdateNeverSent,
}

impl Orders {
    /// The order that the vehicle has if it takes all that was sent.
    pub fn latest(&self) -> Option<&Route> {
        self.sent.iter().rev().find_map(|sent| sent.route.as_ref()).or(self.shown.as_ref())
    }

    /// Notes an order that was sent.
    pub fn push(&mut self, order: &Order, route: Option<Route>, time: f64) {
        if self.sent.len() >= MOST_WAITING {
            self.sent.pop_front();
        }
        self.sent.push_back(Sent { order: order.clone(), route, time });
    }

    /// Takes the order that a state shows, after the state before.
    pub fn show(&mut self, state: &State, before: Option<&State>) -> Showing {
        let (order_id, update_id) = (state.order_id.as_str(), state.order_update_id);
        let taken = self.sent.iter().position(|sent| {
            sent.order.order_id == order_id && sent.order.order_update_id == update_id
        });
        if let Some(place) = taken {
            return self.take(place);
        }
        let is_same = before.is_some_and(|before| {
            before.order_id == order_id && before.order_update_id == update_id
        });
        let is_shown = self.shown.as_ref().is_some_and(|route| route.has_ids(order_id, update_id));
        if is_same || is_shown {
            return Showing::Same;
        }
        let is_update = self.latest().is_some_and(|route| route.order_id == order_id);
        self.shown = None;
        match before {
            None => Showing::Unknown,
            Some(_) if order_id.is_empty() => Showing::Unknown,
            Some(_) if is_update => Showing::UpdateNeverSent,
            Some(_) => Showing::NeverSent,
        }
    }

    fn take(&mut self, place: usize) -> Showing {
        let is_update = self.shown.as_ref().is_some_and(|shown| {
            self.sent.get(place).is_some_and(|sent| sent.order.order_id == shown.order_id)
        });
        if !is_update {
            self.cancelling = Cancelling::No;
        }
        self.shown = self.sent.drain(..=place).next_back().and_then(|sent| sent.route);
        Showing::Taken
    }

    /// Forgets the nodes that lie behind a vehicle, but the last ones.
    pub fn forget_behind(&mut self, sequence_id: u32) {
        let kept = sequence_id.saturating_sub(2);
        if let Some(route) = self.shown.as_mut().filter(|route| route.nodes.len() > 64) {
            let before = route.nodes.len();
            route.nodes.retain(|node| node.sequence_id >= kept);
            route.edges.retain(|edge| edge.sequence_id > kept);
            if route.nodes.len() < before {
                route.extent = Extent::End;
            }
        }
    }
}
