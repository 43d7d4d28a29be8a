//! The largest number of robots that can be under way.

use regatta_base::graph::Leg;

use super::conflicts::Conflicts;
use super::cover::most_on_roads;
use super::network::{Network, leg_of};
use super::robot::RobotType;
use super::room::{Certainty, Count, groups, most_standing};

/// The largest group of touching nodes that is counted anew for each leg.
const MOST_COUNTED: usize = 64;

/// The largest numbers of robots of which at least one moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MostUnderWay {
    /// Robots that stop at nodes of the main part only: the largest number that stand there without
    /// touching each other while one of them can drive along a leg. A bound if the layout has
    /// zones, which may allow fewer.
    pub at_nodes: Count,
    /// A bound for robots that stop anywhere on the roads of the main part without touching each
    /// other, also on roads beside each other.
    pub anywhere: u64,
}

/// Counts the robots of the main part.
pub fn most_under_way(
    network: &Network<'_>,
    conflicts: &Conflicts,
    robot: &RobotType,
) -> MostUnderWay {
    let rooms = Rooms::new(network, conflicts);
    let mut most = Count::NONE;
    for leg in (0..2 * network.graph.edges().len() as u32).map(leg_of) {
        if rooms.is_driven(leg) {
            let count = rooms.besides(leg);
            most = if count.robots > most.robots { count } else { most };
            most.certainty = most.certainty.and(count.certainty);
        }
    }
    if !network.graph.zones().is_empty() {
        most.certainty = Certainty::Bound;
    }
    MostUnderWay { at_nodes: most, anywhere: most_on_roads(network, robot) }
}

/// The groups of touching nodes of the main part.
struct Rooms<'a> {
    network: &'a Network<'a>,
    conflicts: &'a Conflicts,
    groups: Vec<Vec<u32>>,
    /// By group: the robots that fit.
    counts: Vec<Count>,
    /// By node: the number of its group; `u32::MAX` outside of the main part.
    group_of: Vec<u32>,
    total: Count,
}

impl<'a> Rooms<'a> {
    fn new(network: &'a Network<'a>, conflicts: &'a Conflicts) -> Self {
        let groups = groups(conflicts, &network.main_nodes());
        let counts: Vec<Count> =
            groups.iter().map(|group| most_standing(conflicts, group)).collect();
        let mut group_of = vec![u32::MAX; network.nodes() as usize];
        for (number, group) in (0..).zip(&groups) {
            for &node in group {
                group_of[node as usize] = number;
            }
        }
        let total = counts.iter().fold(Count::NONE, |sum, count| sum.plus(*count));
        Self { network, conflicts, groups, counts, group_of, total }
    }

    /// Whether a leg is a way, and leads from a node of the main part to another one.
    fn is_driven(&self, leg: Leg) -> bool {
        let (start, end) = (self.network.start(leg), self.network.end(leg));
        self.network.is_way(leg)
            && start != end
            && self.network.is_main(start)
            && self.network.is_main(end)
    }

    /// The largest number of robots of which one can drive along a leg.
    fn besides(&self, leg: Leg) -> Count {
        let start = self.network.start(leg);
        let mut taken: Vec<u32> = vec![start];
        taken.extend(self.conflicts.touching(start));
        taken.extend(self.conflicts.blockers(leg));
        taken.retain(|&node| self.group_of[node as usize] != u32::MAX);
        taken.sort_unstable();
        taken.dedup();
        let mut affected: Vec<u32> =
            taken.iter().map(|&node| self.group_of[node as usize]).collect();
        affected.sort_unstable();
        affected.dedup();
        let mut count = self.total.plus(Count { robots: 1, ..Count::NONE });
        for group in affected {
            let (before, after) = (self.counts[group as usize], self.without(group, &taken));
            count.robots -= before.robots - after.robots.min(before.robots);
            count.certainty = count.certainty.and(after.certainty);
        }
        count
    }

    /// The robots that fit into a group without some of its nodes, which are in ascending order.
    fn without(&self, group: u32, taken: &[u32]) -> Count {
        let nodes = &self.groups[group as usize];
        if nodes.len() > MOST_COUNTED {
            return Count { certainty: Certainty::Bound, ..self.counts[group as usize] };
        }
        let mut left = nodes.clone();
        left.retain(|node| taken.binary_search(node).is_err());
        most_standing(self.conflicts, &left)
    }
}
