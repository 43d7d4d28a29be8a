//! The decisions of a cycle.

use super::{ChargeAction, Charging, Decision, Phase, Situation};
use crate::roads::Roads;

/// The nodes that are taken, by robots that are there or go there, in ascending order.
struct Taken {
    /// Nodes at the ends of bases, and the robots.
    ends: Vec<(u32, u32)>,
    /// Nodes of the stops of orders, and their robots.
    stops: Vec<(u32, u32)>,
}

impl Taken {
    fn of(situations: &[Situation]) -> Self {
        let mut ends: Vec<_> =
            situations.iter().filter_map(|at| Some((at.node?, at.robot))).collect();
        let mut stops: Vec<_> =
            situations.iter().filter_map(|at| Some((at.stop?, at.robot))).collect();
        ends.sort_unstable();
        stops.sort_unstable();
        Self { ends, stops }
    }

    /// Whether another robot is at a node, or on the last edge to it, or has an order to go there.
    fn by_another(&self, node: u32, robot: u32) -> bool {
        among(&self.ends, node).chain(among(&self.stops, node)).any(|other| other != robot)
    }
}

/// The robots at a node, of pairs in ascending order.
fn among(pairs: &[(u32, u32)], node: u32) -> impl Iterator<Item = u32> {
    let first = pairs.partition_point(|(other, _)| *other < node);
    pairs[first..].iter().take_while(move |(other, _)| *other == node).map(|(_, robot)| *robot)
}

impl Charging {
    /// Decides which robots charge, at a simulated time in seconds. `situations`
    /// are in ascending order of robots; `secs` returns the driving time between two nodes, if
    /// there is a way.
    pub fn decide(
        &mut self,
        now_secs: f64,
        roads: &Roads,
        situations: &[Situation],
        secs: &dyn Fn(u32, u32) -> Option<f64>,
    ) -> &[Decision] {
        self.decisions.clear();
        for at in situations {
            self.follow(at, now_secs);
        }
        let taken = Taken::of(situations);
        let are_waiting = self.give_chargers(&taken, situations, secs);
        let ends: Vec<u32> = taken.ends.iter().map(|(node, _)| *node).collect();
        for index in 0..self.chargers.len() {
            let node = self.chargers[index].node;
            if let Some(robot) = self.chargers[index].promised
                && (are_waiting || among(&taken.stops, node).any(|other| other != robot))
            {
                self.make_room(index, robot, roads, &ends);
            }
        }
        if !are_waiting {
            self.top_up(now_secs, &taken, situations, secs);
        }
        &self.decisions
    }

    /// Updates the phase of a robot.
    fn follow(&mut self, at: &Situation, now_secs: f64) {
        let to_charger = self.secs_to_charger(at.node) * self.settings.delay;
        let (settings, full) = (self.settings, self.or_all(self.settings.full));
        let Some(robot) = self.robots.get_mut(at.robot as usize) else {
            return;
        };
        if robot.battery.is_none() {
            return;
        }
        robot.is_low =
            robot.charge < settings.low || !robot.has_energy_for(to_charger, settings.reserve);
        robot.idle_since =
            if at.stop.is_some() { None } else { robot.idle_since.or(Some(now_secs)) };
        let is_flat = at.is_broken && robot.charge <= 0.0;
        let before = robot.phase;
        let has_left = match before {
            Phase::Resting(charger) | Phase::Leaving(charger, _) => {
                at.node.is_some_and(|end| end != self.chargers[charger].node)
            }
            _ => false,
        };
        robot.phase = match before {
            Phase::Flat if at.is_broken => Phase::Flat,
            Phase::Flat => Phase::Free,
            _ if is_flat => Phase::Flat,
            Phase::Free if robot.is_low && !at.is_bound && at.node.is_some() => Phase::Waiting,
            Phase::Going(_) if at.is_unreachable => Phase::Waiting,
            Phase::Going(charger) if at.has_arrived => Phase::Charging(charger),
            Phase::Charging(charger) if robot.charge >= full => Phase::Resting(charger),
            Phase::Resting(_) if has_left => Phase::Free,
            Phase::Leaving(..) if at.stop.is_some() || at.has_arrived || at.is_unreachable => {
                Phase::Free
            }
            same => same,
        };
        let (after, robot) = (robot.phase, at.robot);
        let is_away = has_left && matches!(before, Phase::Leaving(..));
        if is_away
            || (before != after && matches!(after, Phase::Free | Phase::Waiting | Phase::Flat))
        {
            self.break_promises(robot);
        }
        if before == after {
            return;
        }
        match after {
            Phase::Waiting => self.decide_on(robot, ChargeAction::Wait),
            Phase::Charging(_) => self.decide_on(robot, ChargeAction::Stay),
            Phase::Flat => self.decide_on(robot, ChargeAction::Flat),
            Phase::Resting(_) => self.decide_on(robot, ChargeAction::Free),
            Phase::Free if at.stop.is_none() && matches!(before, Phase::Leaving(..)) => {
                self.decide_on(robot, ChargeAction::Free);
            }
            _ => {}
        }
    }

    fn decide_on(&mut self, robot: u32, action: ChargeAction) {
        self.decisions.push(Decision { robot, action });
    }

    /// Promises free chargers to the robots that wait for one, those first whose batteries last for
    /// the shortest time. Returns whether some still wait.
    fn give_chargers(
        &mut self,
        taken: &Taken,
        situations: &[Situation],
        secs: &dyn Fn(u32, u32) -> Option<f64>,
    ) -> bool {
        let mut waiting: Vec<(f64, u32, u32)> = Vec::new();
        for at in situations {
            let (Some(robot), Some(node)) = (self.robots.get(at.robot as usize), at.node) else {
                continue;
            };
            let Some(battery) = robot.battery.filter(|_| robot.phase == Phase::Waiting) else {
                continue;
            };
            let lasts = robot.left(battery, 0.0) / battery.drain.max(1e-3);
            waiting.push((lasts - self.secs_to_charger(Some(node)), at.robot, node));
        }
        waiting.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let served = waiting
            .iter()
            .filter(|(_, robot, node)| self.promise(*robot, *node, taken, secs))
            .count();
        served < waiting.len()
    }

    /// Sends robots that have nothing to do to chargers that no other robot needs.
    fn top_up(
        &mut self,
        now_secs: f64,
        taken: &Taken,
        situations: &[Situation],
        secs: &dyn Fn(u32, u32) -> Option<f64>,
    ) {
        for at in situations {
            let (Some(robot), Some(node)) = (self.robots.get(at.robot as usize), at.node) else {
                continue;
            };
            let is_idle =
                robot.idle_since.is_some_and(|since| now_secs - since >= self.settings.idle_secs);
            let may_charge = robot.battery.is_some()
                && robot.phase == Phase::Free
                && robot.charge < self.or_all(self.settings.top_up);
            if is_idle
                && may_charge
                && !at.is_broken
                && self.chargers.iter().any(|charger| charger.promised.is_none())
            {
                self.promise(at.robot, node, taken, secs);
            }
        }
    }

    /// Promises the nearest free charger to a robot; `false` if there is none, or it can't be sure
    /// to get there: then it waits until a nearer one is free.
    fn promise(
        &mut self,
        robot: u32,
        node: u32,
        taken: &Taken,
        secs: &dyn Fn(u32, u32) -> Option<f64>,
    ) -> bool {
        let free = (0..self.chargers.len()).filter(|&index| {
            let charger = &self.chargers[index];
            charger.promised.is_none() && !taken.by_another(charger.node, robot)
        });
        let measured =
            free.filter_map(|index| Some((secs(node, self.chargers[index].node)?, index)));
        let Some((secs_there, nearest)) =
            measured.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
        else {
            return false;
        };
        let is_nearest = secs_there <= self.secs_to_charger(Some(node));
        if !is_nearest
            && !self.robots[robot as usize].has_energy_for(secs_there * self.settings.delay, 0.0)
        {
            return false;
        }
        self.chargers[nearest].promised = Some(robot);
        self.robots[robot as usize].phase = Phase::Going(nearest);
        self.decide_on(robot, ChargeAction::Go(self.chargers[nearest].node));
        true
    }

    /// Lets a robot leave its charger, if it has charged enough.
    fn make_room(&mut self, charger: usize, robot: u32, roads: &Roads, taken: &[u32]) {
        let Some(state) = self.robots.get(robot as usize) else { return };
        let has_enough =
            matches!(state.phase, Phase::Charging(_)) && state.charge >= self.settings.enough;
        if !has_enough && !matches!(state.phase, Phase::Resting(_)) {
            return;
        }
        if let Some(refuge) = self.refuge(roads, self.chargers[charger].node, taken) {
            self.robots[robot as usize].phase = Phase::Leaving(charger, refuge);
            self.decide_on(robot, ChargeAction::Go(refuge));
        }
    }
}
