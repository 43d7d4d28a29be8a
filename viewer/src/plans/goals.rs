//! The goals of robots: marks at the nodes to which a fleet manager has sent them.

use regatta_plugin::World;
use regatta_scene::plans::GoalMark;

/// The indices of a route graph's nodes by their ids.
#[derive(Clone, Debug, Default)]
pub struct Places(Vec<(u32, u32)>);

impl Places {
    /// Collects the nodes of a world.
    pub fn new(world: &World<'_>) -> Self {
        let mut places: Vec<_> = world.nodes().iter().map(|node| node.id).zip(0..).collect();
        places.sort_by_key(|(id, _)| *id);
        Self(places)
    }

    fn index(&self, id: f32) -> Option<usize> {
        // The conversion would turn NaN and negative numbers into 0.
        (id >= 0.0).then(|| self.0.binary_search_by_key(&(id as u32), |(id, _)| *id).ok())?
    }
}

/// Returns a mark for each node that is a goal: of a selected robot, or of one that `is_watched`.
/// `goals` holds the id of the node that each robot was sent to, or NaN. Marks of selected robots
/// come last, so that they are drawn over the others.
pub fn marks(
    goals: &[f32],
    is_watched: impl Fn(u32) -> bool,
    selected: &[u32],
    places: &Places,
) -> Vec<GoalMark> {
    let mut is_marked = vec![0_u8; places.0.len()];
    let watched = (0..).zip(goals).filter(|(robot, _)| is_watched(*robot));
    let chosen = selected.iter().filter_map(|robot| goals.get(*robot as usize));
    for (mark, goal) in watched.map(|(_, goal)| (1, goal)).chain(chosen.map(|goal| (2, goal))) {
        if let Some(index) = places.index(*goal) {
            is_marked[index] = mark;
        }
    }
    let mut all = Vec::new();
    for (mark, selected) in [(1, 0), (2, 1)] {
        let marked = places.0.iter().zip(&is_marked).filter(|(_, marked)| **marked == mark);
        all.extend(marked.map(|((_, node), _)| GoalMark { node: *node, selected }));
    }
    all
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{NodeRecord, WorldData};

    use super::*;

    #[test]
    fn each_goal_is_marked_once_and_those_of_selected_robots_last() {
        let node = |id, x| NodeRecord { id, x, ..NodeRecord::default() };
        let world = WorldData {
            nodes: vec![node(30, 3.0), node(10, 1.0), node(20, 2.0)],
            ..WorldData::default()
        };
        let places = Places::new(&world.view(1, 1));
        let mark = |node, selected| GoalMark { node, selected };
        let goals = [20.0, 10.0, f32::NAN, 20.0, 99.0, -1.0, 30.0];
        assert_eq!(
            marks(&goals, |_| true, &[1, 77], &places),
            [mark(2, 0), mark(0, 0), mark(1, 1)]
        );
        assert_eq!(marks(&goals, |robot| robot == 6, &[1], &places), [mark(0, 0), mark(1, 1)]);
        assert_eq!(marks(&goals, |_| false, &[0, 2, 5], &places), [mark(2, 1)]);
        assert_eq!(marks(&goals, |_| false, &[], &places), []);
        assert_eq!(marks(&[0.0], |_| true, &[], &Places::default()), []);
    }
}
