//! The spots, passages and nodes that stored paths block, layer by layer.

use super::Path;
use super::space::{Passage, Space, Spot};
use crate::roads::{Leg, Roads};

/// The number of stored paths that block each spot, passage and node in each layer.
#[derive(Debug)]
pub(super) struct Layers {
    count: u16,
    spots: Vec<u16>,
    passages: Vec<u16>,
    nodes: Vec<u16>,
    /// As `passages`: by robots that have long reached their targets.
    tails: Vec<u16>,
    /// Spots, passages and nodes in a layer.
    widths: [usize; 3],
}

/// The least number of layers that a robot is assumed to stay at its target, beyond the one in
/// which it arrives.
const STOP_LAYERS: u16 = 1;

/// Whether a path is stored or taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    Store,
    Remove,
}

impl Layers {
    pub(super) fn new(space: &Space, count: u16) -> Self {
        let widths = [space.spots(), space.passages(), space.nodes()];
        let [spots, passages, nodes] = widths.map(|width| vec![0; width * usize::from(count)]);
        Self { count, spots, tails: passages.clone(), passages, nodes, widths }
    }

    pub(super) fn count(&self) -> u16 {
        self.count
    }

    /// Whether a robot may be at a spot in a layer.
    pub(super) fn is_free(&self, spot: Spot, layer: u16) -> bool {
        self.spots[usize::from(layer) * self.widths[0] + spot.0] == 0
    }

    /// Whether a robot may drive along a passage, to be through in a layer; passing robots that
    /// have `long_arrived` or not.
    pub(super) fn is_passable(&self, passage: Passage, layer: u16, long_arrived: bool) -> bool {
        (layer - 1..=layer).all(|layer| {
            let index = usize::from(layer) * self.widths[1] + passage.0;
            self.passages[index] == 0 && (long_arrived || self.tails[index] == 0)
        })
    }

    /// Whether a node is neither on a stored path in a layer, nor next to one.
    pub(super) fn is_apart(&self, node: u32, layer: u16) -> bool {
        self.nodes[usize::from(layer) * self.widths[2] + node as usize] == 0
    }

    /// Whether a robot that reaches the end of a leg in a layer may stay there for a moment.
    pub(super) fn may_stop(&self, space: &Space, leg: Leg, layer: u16) -> bool {
        (layer..=layer + STOP_LAYERS)
            .all(|layer| layer >= self.count || self.is_free(space.end(leg), layer))
    }

    /// Returns the first layer from which on a robot may stay at the end of a leg; `None` if it
    /// can't.
    pub(super) fn free_from(&self, space: &Space, leg: Leg, node: Option<u32>) -> Option<u16> {
        let mut first = self.count;
        while first > 0
            && self.is_free(space.end(leg), first - 1)
            && node.is_none_or(|node| self.is_apart(node, first - 1))
        {
            first -= 1;
        }
        (first < self.count).then_some(first)
    }

    /// Stores the passages that a robot at a spot blocks, from a layer up to another one.
    fn stay(&mut self, space: &Space, spot: Spot, [from, to]: [u16; 2], change: Change) {
        stay(
            &mut self.passages,
            self.widths[1],
            space.blocked_by(spot),
            [from, to.min(self.count - 1)],
            change,
        );
    }

    fn drive(&mut self, space: &Space, passage: Passage, layer: u16, change: Change) {
        for layer in [layer - 1, layer] {
            let start = usize::from(layer) * self.widths[0];
            for &spot in space.blocking(passage) {
                alter(&mut self.spots[start + spot as usize], change);
            }
        }
    }

    fn mark(&mut self, nodes: &[u32], [from, to]: [u16; 2], change: Change) {
        for layer in from..=to.min(self.count - 1) {
            let start = usize::from(layer) * self.widths[2];
            for &node in nodes {
                alter(&mut self.nodes[start + node as usize], change);
            }
        }
    }

    /// Stores a place where a robot is from the first layer up to another one, with or without the
    /// neighbours of its node.
    pub(super) fn hold(
        &mut self,
        roads: &Roads,
        space: &Space,
        path: &Path,
        until: u16,
        apart: bool,
        change: Change,
    ) {
        let leg = path.steps[0].leg;
        self.stay(space, path.first_spot(space), [0, until], change);
        let own = [roads.end(leg)];
        self.mark(if apart { space.neighbours(own[0]) } else { &own }, [0, until], change);
    }

    /// Stores a path, or takes it out: its spots and those on the way between them, from the first
    /// layer to the last.
    pub(super) fn alter(&mut self, roads: &Roads, space: &Space, path: &Path, change: Change) {
        if path.starts_inside {
            self.stay(space, space.inside(path.steps[0].leg), [0, path.steps[0].layer - 1], change);
        }
        for (index, step) in path.steps.iter().enumerate() {
            let until = path.steps.get(index + 1).map_or(self.count - 1, |next| next.layer - 1);
            if index + 1 == path.steps.len() {
                let tail = step.layer.saturating_add(STOP_LAYERS);
                self.stay(space, space.end(step.leg), [step.layer, tail], change);
                let blocked = space.blocked_by(space.end(step.leg));
                stay(
                    &mut self.tails,
                    self.widths[1],
                    blocked,
                    [tail.saturating_add(1), until],
                    change,
                );
            } else {
                self.stay(space, space.end(step.leg), [step.layer, until], change);
            }
            self.mark(space.neighbours(roads.end(step.leg)), [step.layer, until], change);
        }
        for (passage, layer) in path.passages(roads, space) {
            self.drive(space, passage, layer, change);
        }
    }

    /// Whether no stored path blocks a path; it may be next to others.
    pub(super) fn is_clear(&self, roads: &Roads, space: &Space, path: &Path) -> bool {
        let stays = path.steps.iter().enumerate().all(|(index, step)| {
            let until = path.steps.get(index + 1).map_or(self.count - 1, |next| next.layer - 1);
            let until = if index + 1 == path.steps.len() {
                step.layer.saturating_add(STOP_LAYERS)
            } else {
                until
            };
            (step.layer..=until.min(self.count - 1))
                .all(|layer| self.is_free(space.end(step.leg), layer))
        });
        stays
            && path
                .passages(roads, space)
                .all(|(passage, layer)| self.is_passable(passage, layer, true))
    }
}

impl Path {
    /// The robot's spot in the first layer.
    pub(super) fn first_spot(&self, space: &Space) -> Spot {
        let first = self.steps[0].leg;
        if self.starts_inside { space.inside(first) } else { space.end(first) }
    }

    /// The passages that the robot drives along, each with the layer in which it is through.
    fn passages<'a>(
        &'a self,
        roads: &'a Roads,
        space: &'a Space,
    ) -> impl Iterator<Item = (Passage, u16)> + 'a {
        let first = self.steps[0];
        let rest = self.starts_inside.then(|| (space.rest(first.leg), first.layer));
        let legs = self.steps.windows(2).flat_map(move |pair| {
            let turn = roads
                .is_turn(pair[0].leg, pair[1].leg)
                .then(|| space.turn(roads.start(pair[1].leg)));
            turn.into_iter()
                .chain([space.whole(pair[1].leg)])
                .map(|passage| (passage, pair[1].layer))
        });
        rest.into_iter().chain(legs)
    }
}

fn stay(counts: &mut [u16], width: usize, passages: &[u32], [from, to]: [u16; 2], change: Change) {
    for layer in from..=to {
        let start = usize::from(layer) * width;
        for &passage in passages {
            alter(&mut counts[start + passage as usize], change);
        }
    }
}

fn alter(count: &mut u16, change: Change) {
    *count = match change {
        Change::Store => count.saturating_add(1),
        Change::Remove => count.saturating_sub(1),
    };
}
