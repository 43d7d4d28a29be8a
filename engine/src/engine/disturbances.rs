//! Disturbances of a scenario: robots that stall, and robots that break down.
//!
//! Each robot has a sequence of its own, drawn from the seed, the robot and a count. So it depends
//! on nothing that happens to the fleet, and a tick costs only what is due in it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::time::Duration;

use regatta_base::ln;
use regatta_base::random::{mix, unit};
use regatta_scenario::{Breakdowns, Disturbances, Stalls};

use crate::fleet::{EventBuffer, Fleet};

/// Something that happens to a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Incident {
    Stall,
    Recovery,
    Breakdown,
    Repair,
}

/// An incident by tick, robot and kind, and the number of those before it in its sequence.
type Due = (u64, u32, Incident, u32);

/// The disturbances that are due, for every robot that was ever there.
#[derive(Debug)]
pub(super) struct Schedule {
    stalls: Option<Stalls>,
    breakdowns: Option<Breakdowns>,
    seed: u64,
    ticks_per_second: f64,
    due: BinaryHeap<Reverse<Due>>,
    /// Robots with ids below have their sequences.
    robots: u32,
}

impl Schedule {
    pub fn new(disturbances: &Disturbances, seed: u64, tick_period: Duration) -> Self {
        Self {
            stalls: disturbances.stalls,
            breakdowns: disturbances.breakdowns,
            seed: mix(seed ^ 0x6469_7374_7572_6265),
            ticks_per_second: 1.0 / tick_period.as_secs_f64(),
            due: BinaryHeap::new(),
            robots: 0,
        }
    }

    /// Carries out the incidents that are due by a tick.
    pub fn carry_out(&mut self, tick: u64, fleet: &mut Fleet, events: &mut EventBuffer) {
        self.begin(tick, fleet.robots() as u32);
        while let Some(&Reverse((due, robot, incident, number))) = self.due.peek()
            && due <= tick
        {
            self.due.pop();
            match incident {
                Incident::Stall => fleet.stall(robot, events),
                Incident::Recovery => fleet.recover(robot, events),
                Incident::Breakdown => fleet.break_down(robot, events),
                Incident::Repair => fleet.repair(robot, events),
            }
            if let Some(next) = self.after(tick, robot, incident, number) {
                self.due.push(Reverse(next));
            }
        }
    }

    /// Begins the sequences of robots that are new.
    fn begin(&mut self, tick: u64, robots: u32) {
        if self.stalls.is_none() && self.breakdowns.is_none() {
            return;
        }
        for robot in self.robots..robots {
            let first = [self.next_stall(tick, robot, 0), self.next_breakdown(tick, robot, 0)];
            self.due.extend(first.into_iter().flatten().map(Reverse));
        }
        self.robots = self.robots.max(robots);
    }

    /// Returns the next incident of a sequence.
    fn after(&self, tick: u64, robot: u32, incident: Incident, number: u32) -> Option<Due> {
        match incident {
            Incident::Stall => {
                let seconds = self.exponential(robot, incident, number, self.stalls?.mean_secs);
                Some((tick + self.ticks(seconds), robot, Incident::Recovery, number))
            }
            Incident::Recovery => self.next_stall(tick, robot, number + 1),
            Incident::Breakdown => match self.breakdowns?.repair_secs {
                Some(seconds) => {
                    Some((tick + self.ticks(seconds), robot, Incident::Repair, number))
                }
                None => self.next_breakdown(tick, robot, number + 1),
            },
            Incident::Repair => self.next_breakdown(tick, robot, number + 1),
        }
    }

    fn next_stall(&self, tick: u64, robot: u32, number: u32) -> Option<Due> {
        let stalls = self
            .stalls
            .filter(|stalls| self.random(robot, Incident::Stall, u32::MAX) < stalls.share)?;
        self.next(tick, robot, Incident::Stall, number, stalls.per_hour)
    }

    fn next_breakdown(&self, tick: u64, robot: u32, number: u32) -> Option<Due> {
        self.next(tick, robot, Incident::Breakdown, number, self.breakdowns?.per_hour)
    }

    fn next(
        &self,
        tick: u64,
        robot: u32,
        incident: Incident,
        number: u32,
        per_hour: f64,
    ) -> Option<Due> {
        let gap = self.exponential(robot, incident, number | 1 << 31, 3600.0 / per_hour);
        // Never, if it is that far away.
        let due = tick.checked_add(self.ticks(gap)).filter(|_| gap.is_finite())?;
        Some((due, robot, incident, number))
    }

    /// Returns whole ticks, at least one.
    fn ticks(&self, seconds: f64) -> u64 {
        (seconds * self.ticks_per_second).ceil().max(1.0) as u64
    }

    fn exponential(&self, robot: u32, incident: Incident, number: u32, mean: f64) -> f64 {
        -ln(1.0 - self.random(robot, incident, number)) * mean
    }

    /// Returns a number in [0, 1).
    fn random(&self, robot: u32, incident: Incident, number: u32) -> f64 {
        let counter = u64::from(robot) << 32 | u64::from(number);
        unit(mix(self.seed ^ mix(counter ^ mix(incident as u64))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn schedule(seed: u64) -> Schedule {
        let stalls = Stalls { per_hour: 12.0, mean_secs: 8.0, share: 0.25 };
        let breakdowns = Breakdowns { per_hour: 1.0, repair_secs: Some(600.0) };
        let disturbances = Disturbances {
            stalls: Some(stalls),
            breakdowns: Some(breakdowns),
            speed_variation: 0.0,
        };
        Schedule::new(&disturbances, seed, SECOND)
    }

    /// Returns what happens to a thousand robots in ten hours: tick, robot and incident.
    fn incidents(seed: u64) -> Vec<(u64, u32, Incident)> {
        let mut schedule = schedule(seed);
        schedule.begin(0, 1000);
        let mut all = Vec::new();
        while let Some(Reverse((tick, robot, incident, number))) = schedule.due.pop() {
            if tick > 36_000 {
                return all;
            }
            all.push((tick, robot, incident));
            schedule.due.extend(schedule.after(tick, robot, incident, number).map(Reverse));
        }
        all
    }

    #[test]
    fn incidents_have_the_wanted_rates() {
        let all = incidents(1);
        let count =
            |wanted| all.iter().filter(|(_, _, incident)| *incident == wanted).count() as f64;
        // A stall lasts 8 s, so that 3608 s are between two pairs of twelve; a repair takes 600 s.
        let stalls = 250.0 * 36_000.0 / (300.0 + 8.0);
        assert!(
            (count(Incident::Stall) / stalls - 1.0).abs() < 0.15,
            "{} stalls, not {stalls}",
            count(Incident::Stall)
        );
        let breakdowns = 1000.0 * 36_000.0 / 4200.0;
        assert!(
            (count(Incident::Breakdown) / breakdowns - 1.0).abs() < 0.05,
            "{}",
            count(Incident::Breakdown)
        );
        let mut stalled: Vec<_> = all
            .iter()
            .filter(|(_, _, i)| *i == Incident::Stall)
            .map(|(_, robot, _)| robot)
            .collect();
        stalled.sort_unstable();
        stalled.dedup();
        assert!((200..300).contains(&stalled.len()), "a quarter of the robots: {}", stalled.len());
    }

    #[test]
    fn they_depend_on_the_seed_alone() {
        assert_eq!(incidents(1), incidents(1));
        assert_ne!(incidents(1), incidents(2));
    }

    #[test]
    fn without_disturbances_nothing_is_due() {
        let mut schedule = Schedule::new(&Disturbances::default(), 1, SECOND);
        schedule.begin(0, 1000);
        assert!(schedule.due.is_empty());
    }
}
