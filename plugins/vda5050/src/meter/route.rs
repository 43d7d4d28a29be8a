//! The order of a vehicle as its master has sent it.

use rustc_hash::FxHashMap;

use crate::message::{ActionState, Edge, Node, Order};

/// The nodes after the base that count as asked for, if an order has a horizon.
const AHEAD: usize = 2;

/// An order with its updates.
#[derive(Clone, Debug, Default)]
pub(super) struct Route {
    pub order_id: String,
    pub update_id: u32,
    nodes: Vec<Step>,
    /// Edges by their sequence ids.
    edges: FxHashMap<u32, String>,
}

/// A node of an order.
#[derive(Clone, Debug)]
pub(super) struct Step {
    pub node: String,
    pub sequence_id: u32,
    pub is_released: bool,
    /// The ids of its actions.
    pub actions: Vec<String>,
}

impl Route {
    /// The route of a new order.
    pub fn of(order: &Order) -> Self {
        let mut route = Self { order_id: order.order_id.clone(), ..Self::default() };
        route.update(order);
        route
    }

    /// Takes an update: what it has replaces the old from its first node on.
    pub fn update(&mut self, order: &Order) {
        self.update_id = order.order_update_id;
        let first = order.nodes.first().map_or(0, |node| node.sequence_id);
        self.nodes.retain(|step| step.sequence_id < first);
        self.nodes.extend(order.nodes.iter().map(Step::of));
        self.edges.retain(|sequence_id, _| *sequence_id < first);
        self.edges.extend(order.edges.iter().map(named));
    }

    /// The nodes with a sequence id from this one on.
    pub fn from(&self, sequence_id: u32) -> impl Iterator<Item = &Step> {
        self.nodes.iter().filter(move |step| step.sequence_id >= sequence_id)
    }

    /// The last node of the base.
    pub fn base_end(&self) -> Option<&Step> {
        self.nodes.iter().rev().find(|step| step.is_released)
    }

    /// The first nodes of the horizon.
    pub fn ahead(&self) -> impl Iterator<Item = &Step> {
        self.nodes.iter().filter(|step| !step.is_released).take(AHEAD)
    }

    /// The edges before and after a node.
    pub fn edges_at(&self, sequence_id: u32) -> [Option<String>; 2] {
        let before = sequence_id.checked_sub(1);
        [before, sequence_id.checked_add(1)].map(|id| self.edges.get(&id?).cloned())
    }
}

impl Step {
    fn of(node: &Node) -> Self {
        Self {
            node: node.node_id.clone(),
            sequence_id: node.sequence_id,
            is_released: node.released,
            actions: node.actions.iter().map(|action| action.action_id.clone()).collect(),
        }
    }

    /// Whether no action of the node is to be carried out any more.
    pub fn is_handled(&self, states: &[ActionState]) -> bool {
        let mut states = states.iter().filter(|state| self.actions.contains(&state.action_id));
        states.all(|state| state.action_status.is_over())
    }
}

fn named(edge: &Edge) -> (u32, String) {
    (edge.sequence_id, edge.edge_id.clone())
}
