//! The search for one path: A* over legs and layers.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap, VecDeque};

use regatta_base::sweep::angle_between;

use super::layers::Layers;
use super::space::Space;
use super::{Path, Step};
use crate::roads::{Leg, Roads};

/// The smallest change of heading that takes a layer of its own, in radians: 90°, less rounding.
const LARGE_TURN: f32 = core::f32::consts::FRAC_PI_2 - 1e-3;
/// The largest number of goals whose numbers of legs are kept.
const MOST_GOALS: usize = 256;
/// The number of legs to a goal that can't be reached.
const FAR: u16 = u16::MAX;

/// The query of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Query<'a> {
    pub roads: &'a Roads,
    pub space: &'a Space,
    pub layers: &'a Layers,
    /// The start: a path of one step.
    pub start: &'a Path,
    /// The first layer in which a robot that starts inside of a leg may reach its end.
    pub earliest: u16,
    /// The node of the goal.
    pub goal: u32,
    /// As published: whether the robot keeps away from the neighbours of others' nodes and from
    /// their reached targets, and stays at its own up to the last layer.
    pub strict: bool,
    /// The maximum number of states to examine.
    pub most_states: u64,
}

/// A state that is open: the least cost of a path over it, its layer, and its index. Each layer
/// costs 0.5: counted in halves, the cost so far is the layer.
type Open = (Reverse<u16>, u16, Reverse<u32>);

/// Searches paths, one after the other. It keeps its memory in between.
#[derive(Debug)]
pub(super) struct Finder {
    /// States in a layer: the ends of all legs, and the inside of the leg on which the robot
    /// starts.
    width: usize,
    /// By layer and state: the number of the search that reached it, and the state before.
    reached: Vec<Vec<(u32, u32)>>,
    search: u32,
    open: BinaryHeap<Open>,
    /// By goal, with or without legs in reverse gear: the fewest legs from each node.
    hops: BTreeMap<(u32, bool), Vec<u16>>,
    /// Legs by the node that they lead to.
    arrivals: Vec<Vec<Leg>>,
    pub looked_at: u64,
}

impl Finder {
    pub(super) fn new(roads: &Roads, layers: u16) -> Self {
        let mut arrivals = vec![Vec::new(); roads.nodes() as usize];
        for &leg in (0..roads.nodes()).flat_map(|node| roads.exits(node)) {
            arrivals[roads.end(leg) as usize].push(leg);
        }
        Self {
            width: 2 * roads.edges().len() + 1,
            reached: vec![Vec::new(); layers.into()],
            search: 0,
            open: BinaryHeap::new(),
            hops: BTreeMap::new(),
            arrivals,
            looked_at: 0,
        }
    }

    /// Returns the path that arrives first, on legs that are open; `None` if there is none within
    /// the layers.
    pub(super) fn find(&mut self, query: Query<'_>, is_open: impl Fn(Leg) -> bool) -> Option<Path> {
        let Query { roads, space, layers, start, .. } = query;
        let first = start.steps[0].leg;
        let (hops, reverse) = self.hops_from(roads, query.goal, roads.end(first));
        if hops[roads.end(first) as usize] == FAR || self.is_target_blocked(query) {
            self.keep_hops((query.goal, reverse), hops);
            return None;
        }
        let most = self.looked_at + query.most_states;
        self.search += 1;
        self.open.clear();
        self.reach(
            query,
            &hops,
            (0, if start.starts_inside { self.width - 1 } else { first.index() }),
            u32::MAX,
        );
        let mut found = None;
        while let Some((_, layer, Reverse(state))) = self.open.pop() {
            self.looked_at += 1;
            if self.looked_at > most {
                break;
            }
            let index = state as usize % self.width;
            if index == self.width - 1 {
                self.expand_inside(query, &hops, layer, state);
                continue;
            }
            let leg = Leg::from_index(index as u32);
            if is_target(query, leg, layer) {
                found = Some(self.path(state, start));
                break;
            }
            let node = roads.end(leg);
            let may_stay = layers.count() > layer + 1
                && layers.is_free(space.end(leg), layer + 1)
                && (!query.strict || layers.is_apart(node, layer + 1));
            if may_stay {
                self.reach(query, &hops, (layer + 1, index), state);
            }
            for &next in roads
                .exits(node)
                .iter()
                .filter(|next| is_open(**next) && (reverse || !next.is_reverse()))
            {
                let turns =
                    angle_between(roads.headings(leg)[1], roads.headings(next)[0]) >= LARGE_TURN;
                let arrival = layer + if turns { 2 } else { 1 };
                let turn = roads.is_turn(leg, next).then(|| space.turn(node));
                if arrival < layers.count()
                    && (!turns || may_stay)
                    && turn.is_none_or(|turn| layers.is_passable(turn, arrival, !query.strict))
                    && layers.is_passable(space.whole(next), arrival, !query.strict)
                    && self.may_arrive(query, next, arrival)
                {
                    self.reach(query, &hops, (arrival, next.index()), state);
                }
            }
        }
        self.keep_hops((query.goal, reverse), hops);
        found
    }

    /// A robot that is behind others on a leg waits there, or reaches its end.
    fn expand_inside(&mut self, query: Query<'_>, hops: &[u16], layer: u16, state: u32) {
        let (leg, next) = (query.start.steps[0].leg, layer + 1);
        if next >= query.layers.count() {
            return;
        }
        if query.layers.is_free(query.space.inside(leg), next) {
            self.reach(query, hops, (next, self.width - 1), state);
        }
        let is_passable = query.layers.is_passable(query.space.rest(leg), next, !query.strict);
        if next >= query.earliest && is_passable && self.may_arrive(query, leg, next) {
            self.reach(query, hops, (next, leg.index()), state);
        }
    }

    fn may_arrive(&self, query: Query<'_>, leg: Leg, layer: u16) -> bool {
        let is_free = query.layers.is_free(query.space.end(leg), layer);
        is_free && (!query.strict || query.layers.is_apart(query.roads.end(leg), layer))
    }

    fn reach(&mut self, query: Query<'_>, hops: &[u16], (layer, index): (u16, usize), before: u32) {
        let row = &mut self.reached[usize::from(layer)];
        row.resize(self.width, (0, 0));
        if row[index].0 == self.search {
            return;
        }
        let leg = if index == self.width - 1 {
            query.start.steps[0].leg
        } else {
            Leg::from_index(index as u32)
        };
        let least = layer.saturating_add(hops[query.roads.end(leg) as usize]);
        if least < query.layers.count() {
            row[index] = (self.search, before);
            self.open.push((
                Reverse(least),
                layer,
                Reverse((usize::from(layer) * self.width + index) as u32),
            ));
        }
    }

    /// Whether others stay at the goal up to the last layer, by whatever leg the robot comes.
    fn is_target_blocked(&self, query: Query<'_>) -> bool {
        if !query.strict {
            return false;
        }
        let goal = query.goal;
        let first = query.start.steps[0].leg;
        let starts_there = (query.roads.end(first) == goal).then_some(first);
        let mut legs = self.arrivals[goal as usize].iter().copied().chain(starts_there);
        !legs.any(|leg| free_from(query, leg).is_some())
    }

    fn path(&self, state: u32, start: &Path) -> Path {
        let mut places = Vec::new();
        let mut state = state;
        while state != u32::MAX {
            let (layer, index) = (state as usize / self.width, state as usize % self.width);
            places.push((layer, index));
            state = self.reached[layer][index].1;
        }
        let mut steps: Vec<Step> = Vec::new();
        for (layer, index) in places.into_iter().rev().filter(|place| place.1 != self.width - 1) {
            let leg = Leg::from_index(index as u32);
            if steps.last().is_none_or(|last| last.leg != leg) {
                steps.push(Step { leg, layer: layer as u16 });
            }
        }
        Path { steps, is_planned: true, ..start.clone() }
    }

    /// The fewest legs from each node to a goal, on empty roads; in reverse gear only if nothing
    /// else leads there from `start`.
    fn hops_from(&mut self, roads: &Roads, goal: u32, start: u32) -> (Vec<u16>, bool) {
        let forward = self.hops_to(roads, goal, false);
        if forward[start as usize] != FAR {
            return (forward, false);
        }
        self.keep_hops((goal, false), forward);
        (self.hops_to(roads, goal, true), true)
    }

    fn hops_to(&mut self, roads: &Roads, goal: u32, reverse: bool) -> Vec<u16> {
        if let Some(hops) = self.hops.remove(&(goal, reverse)) {
            return hops;
        }
        let mut hops = vec![FAR; roads.nodes() as usize];
        let mut open = VecDeque::from([goal]);
        hops[goal as usize] = 0;
        while let Some(node) = open.pop_front() {
            let arrivals =
                self.arrivals[node as usize].iter().filter(|leg| reverse || !leg.is_reverse());
            for start in arrivals.map(|&leg| roads.start(leg)) {
                if hops[start as usize] == FAR {
                    hops[start as usize] = hops[node as usize].saturating_add(1);
                    open.push_back(start);
                }
            }
        }
        hops
    }

    fn keep_hops(&mut self, goal: (u32, bool), hops: Vec<u16>) {
        if self.hops.len() >= MOST_GOALS {
            self.hops.clear();
        }
        self.hops.insert(goal, hops);
    }
}

/// Whether a robot that reaches the end of a leg in a layer is at its goal and may stay there.
fn is_target(query: Query<'_>, leg: Leg, layer: u16) -> bool {
    query.roads.end(leg) == query.goal
        && match query.strict {
            true => free_from(query, leg).is_some_and(|first| first <= layer),
            false => query.layers.may_stop(query.space, leg, layer),
        }
}

fn free_from(query: Query<'_>, leg: Leg) -> Option<u16> {
    let node = query.strict.then(|| query.roads.end(leg));
    query.layers.free_from(query.space, leg, node)
}
