//! Commits several robots to ways at the same time, where each keeps the others from getting one.

use super::commit::Start;
use super::commitment::Commitment;
use super::{Committed, is_able};
use crate::planner::Plans;
use crate::traffic::{Robot, Traffic};

/// The same for robots that get their ways at the same time.
const OPPOSING_JOINTLY_SECS: f32 = 30.0;
/// The largest number of robots that change places with each other.
const LONGEST_CHAIN: usize = 6;

/// The way in which a robot takes a node.
enum Taker {
    /// It stands there, and doesn't go on.
    Stands,
    /// Its way ends there, behind its own goal or without one: it may end elsewhere.
    Retires,
}

impl Committed {
    /// Gives robots without commitments such, where each of them keeps the others from getting one.
    pub(super) fn commit_lost(&mut self, traffic: &Traffic<'_>, plans: &mut Plans) {
        let mut lost: Vec<(f64, u32)> = traffic
            .robots()
            .filter(|(robot, state)| is_able(state) && self.commitment(*robot).is_none())
            .map(|(robot, state)| (state.sent, robot))
            .collect();
        lost.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut lost: Vec<u32> = lost.into_iter().map(|(_, robot)| robot).collect();
        // Those that can't drive to their goals at the same time only come to rest.
        let mut modest = Vec::new();
        while !lost.is_empty() {
            let stuck = self.commit_jointly(traffic, &lost, &modest, plans);
            let last = lost.iter().rposition(|robot| stuck.binary_search(robot).is_ok());
            match last {
                None if stuck.is_empty() => return,
                Some(index) if !modest.contains(&lost[index]) => modest.push(lost[index]),
                Some(index) => drop(lost.remove(index)),
                None => drop(lost.pop()),
            }
        }
    }

    /// Gives robots ways at the same time, those that are `modest` only to where they may stay.
    /// Returns those that couldn't drive to the end of their
    /// ways then: if there are any, all keep the ways that they have.
    pub(super) fn commit_jointly(
        &mut self,
        traffic: &Traffic<'_>,
        robots: &[u32],
        modest: &[u32],
        plans: &mut Plans,
    ) -> Vec<u32> {
        let before: Vec<Option<Commitment>> =
            robots.iter().map(|&robot| self.commitments[robot as usize].take()).collect();
        let mut stuck = Vec::new();
        for (index, &robot) in robots.iter().enumerate() {
            let is_modest = modest.contains(&robot);
            let way = self.joint_commitment(traffic, robot, is_modest, &robots[index + 1..]);
            if way.is_none() {
                stuck.push(robot);
            }
            self.commitments[robot as usize] = way;
        }
        if stuck.is_empty() {
            self.set_state(traffic, None);
            stuck = self.state.complete(traffic.roads, &mut self.blocks, None);
        }
        if !stuck.is_empty() {
            for (&robot, before) in robots.iter().zip(before) {
                self.commitments[robot as usize] = before;
            }
            stuck.sort_unstable();
            return stuck;
        }
        for &robot in robots {
            self.counts.commitments += 1;
            let Some(commitment) = self.commitment(robot) else { continue };
            match traffic.robot(robot).and_then(Robot::goal) {
                Some(_) => plans.route(robot, commitment.way[..commitment.sent].to_vec()),
                None if traffic.robot(robot).is_some_and(Robot::is_pinned) => {}
                None => plans.evicted.push((robot, commitment.end)),
            }
        }
        Vec::new()
    }

    /// Lets a robot whose goal is taken change places with the robot that takes it, and with the
    /// one that takes the goal of that one, and so on. Returns whether they do.
    pub(super) fn exchange(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        plans: &mut Plans,
    ) -> bool {
        let (mut chain, mut modest) = (vec![robot], Vec::new());
        while let Some(goal) = chain.last().and_then(|&last| traffic.robot(last)?.goal()) {
            let Some((other, taker)) = self.taker(traffic, goal) else { break };
            let Some(state) = traffic.robot(other).filter(|_| !chain.contains(&other)) else {
                break;
            };
            let stays = match taker {
                Taker::Stands => state.is_pinned() || state.goal() == Some(goal),
                Taker::Retires => false,
            };
            if !is_able(state) || stays || chain.len() >= LONGEST_CHAIN {
                // The last one of the chain goes where it may stay, as its goal isn't left.
                modest.extend(chain.last());
                break;
            }
            chain.push(other);
        }
        chain.len() > 1 && self.commit_jointly(traffic, &chain, &modest, plans).is_empty()
    }

    /// The robot that takes a node as a goal for others.
    fn taker(&self, traffic: &Traffic<'_>, node: u32) -> Option<(u32, Taker)> {
        traffic.robots().find_map(|(robot, state)| {
            if self.stands_at(traffic, robot, node) {
                Some((robot, Taker::Stands))
            } else if self.retires_to(traffic, robot, state, node) {
                Some((robot, Taker::Retires))
            } else {
                None
            }
        })
    }

    fn stands_at(&self, traffic: &Traffic<'_>, robot: u32, node: u32) -> bool {
        traffic.base_end(robot).is_some_and(|(_, end)| end == node) && !self.goes_on(traffic, robot)
    }

    /// Whether the way of a robot ends at a node that isn't its goal, and may end elsewhere: where
    /// there are more robots than places of rest, each keeps its own.
    fn retires_to(&self, traffic: &Traffic<'_>, robot: u32, state: &Robot, node: u32) -> bool {
        let is_end = self.commitment(robot).is_some_and(|commitment| commitment.end == node);
        is_end && state.goal() != Some(node) && traffic.robots().count() <= self.rests.len()
    }

    /// Returns a way for a robot as if all others without ways got one, too: to its goal, or else
    /// to the nearest place where it may stay.
    pub(super) fn joint_commitment(
        &mut self,
        traffic: &Traffic<'_>,
        robot: u32,
        is_modest: bool,
        released: &[u32],
    ) -> Option<Commitment> {
        let (state, (last, node)) = (traffic.robot(robot)?, traffic.base_end(robot)?);
        let mut scene = self.scene(traffic, robot, released);
        scene.opposing_secs = OPPOSING_JOINTLY_SECS;
        let start = Start { robot, last, node };
        let goal = state.goal().filter(|_| !is_modest);
        let whole = goal.filter(|goal| !scene.is_taken[*goal as usize]).and_then(|goal| {
            let way = self.route(traffic, state, &start, goal, &scene)?;
            let last = way.last().copied().unwrap_or(last);
            let from = Start { robot, last, node: goal };
            let tail = self.tail(traffic, state, &from, &scene)?;
            Some((way.len(), Some(goal), [way, tail].concat()))
        });
        let (sent, goal, way) = match whole {
            Some(whole) => whole,
            None => {
                let way = self.tail(traffic, state, &start, &scene)?;
                (way.len(), None, way)
            }
        };
        let end = way.last().map_or(node, |&leg| traffic.roads.end(leg));
        Some(Commitment { from: last, way, sent, end, goal })
    }
}
