//! The manager of a fleet: gives tasks to robots, sends them from stop to stop, and steers them there.
//!
//! A cycle is a function of what came before, of the frame and of the requests: in lockstep a run repeats bit by bit.

use std::sync::Arc;

use regatta_plugin::frame::{Columns, NO_EDGE, RobotState};

use crate::planner::DrivingTimes;
use crate::roads::Roads;
use crate::steering::{Command, Seen, Settings, Steering};
use crate::tasks::{Candidate, Next, Stop, TaskBook};

/// What a robot is about.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Errand {
    /// Nothing.
    #[default]
    None,
    /// On its way to a node.
    To(u32),
    /// At a stop, until this simulated second.
    Handling(f64),
}

/// The manager of a fleet.
pub struct Manager {
    steering: Steering,
    tasks: TaskBook,
    times: DrivingTimes,
    /// By robot.
    errands: Vec<Errand>,
    present: Vec<u32>,
    candidates: Vec<Candidate>,
}

impl Manager {
    /// Makes the manager of a fleet on some roads.
    pub fn new(roads: Arc<Roads>, settings: Settings, tasks: TaskBook) -> Self {
        Self {
            times: DrivingTimes::new(&roads),
            steering: Steering::new(roads, settings),
            tasks,
            errands: Vec::new(),
            present: Vec::new(),
            candidates: Vec::new(),
        }
    }

    /// The steering.
    pub fn steering(&self) -> &Steering {
        &self.steering
    }

    /// The tasks.
    pub fn tasks(&self) -> &TaskBook {
        &self.tasks
    }

    /// The tasks, to drain their events.
    pub fn tasks_mut(&mut self) -> &mut TaskBook {
        &mut self.tasks
    }

    /// Takes back what was granted to a robot from a command on: it was refused.
    pub fn refuse(&mut self, robot: u32) {
        self.steering.take_back(robot);
    }

    /// Takes a frame at a simulated time in seconds; returns what to order. `robot_types` has an index for each robot, or is
    /// empty if all are of the first type.
    pub fn cycle(&mut self, now_secs: f64, columns: &Columns<'_>, robot_types: &[f32]) -> &[Command] {
        self.see(columns, robot_types);
        self.tasks.generate_until(now_secs, self.present.len());
        for robot in self.tasks.take_requests(now_secs) {
            self.halt(robot);
        }
        for index in 0..self.present.len() {
            self.serve(self.present[index], now_secs);
        }
        if self.steering.is_ready() {
            self.assign(now_secs);
        }
        self.steering.step(now_secs)
    }

    fn see(&mut self, columns: &Columns<'_>, robot_types: &[f32]) {
        self.present.clear();
        self.errands.resize(columns.state.len(), Errand::None);
        for robot in 0..columns.state.len() {
            let state = RobotState::from_number(columns.state[robot]);
            if state == RobotState::Absent {
                self.lose(robot as u32);
                continue;
            }
            let seen = Seen {
                robot_type: robot_types.get(robot).map_or(0, |index| *index as usize),
                edge: (columns.edge[robot] != NO_EDGE).then_some(columns.edge[robot]),
                s: columns.s[robot],
                speed: columns.speed[robot].abs(),
                position: [columns.x[robot], columns.y[robot]],
                state,
            };
            self.steering.see(robot as u32, &seen);
            self.present.push(robot as u32);
        }
    }

    /// A robot has left the fleet: its task is given to another one, or has failed if its load is gone with it.
    fn lose(&mut self, robot: u32) {
        if self.steering.robot(robot).is_none() {
            return;
        }
        self.steering.lose(robot);
        self.errands[robot as usize] = Errand::None;
        if self.tasks.task_of(robot).is_some() && self.tasks.withdraw(robot, self.steering.now()).is_err() {
            self.tasks.failed(robot, self.steering.now(), "the robot was removed");
        }
    }

    /// Moves a robot's task on, if it has come to a stop or has handled one.
    fn serve(&mut self, robot: u32, now_secs: f64) {
        // A store remembers whose orders had begun: they go on.
        if self.errands[robot as usize] == Errand::None
            && let Some(stop) = self.tasks.current_stop(robot)
        {
            self.send(robot, stop.node);
        }
        if let Errand::To(node) = self.errands[robot as usize] {
            if self.steering.has_arrived(robot, node) && self.tasks.arrived(robot, now_secs) {
                let dwell_secs = self.tasks.current_stop(robot).map_or(0.0, |stop: Stop| stop.dwell_secs);
                self.errands[robot as usize] = Errand::Handling(now_secs + dwell_secs);
                self.steering.stay(robot);
            } else if self.steering.is_unreachable(robot) {
                self.give_up(robot, now_secs);
            }
        }
        if let Errand::Handling(until) = self.errands[robot as usize]
            && now_secs >= until
        {
            match self.tasks.handled(robot, now_secs) {
                Some(Next::Stop(stop)) => self.send(robot, stop.node),
                Some(Next::Done) | None => self.halt(robot),
            }
        }
    }

    /// Gives a task up to whose next stop no way leads.
    fn give_up(&mut self, robot: u32, now_secs: f64) {
        self.halt(robot);
        match self.tasks.withdraw(robot, now_secs) {
            Ok(task) => {
                self.tasks.unroutable(task, now_secs, "no way leads to its stop");
            }
            Err(_) => {
                self.tasks.failed(robot, now_secs, "no way leads to its next stop");
            }
        }
    }

    fn assign(&mut self, now_secs: f64) {
        let roads = self.steering.roads().clone();
        self.candidates.clear();
        for &robot in &self.present {
            if !self.tasks.is_bound(robot)
                && let Some(node) = self.steering.base_end_node(robot)
            {
                self.candidates.push(Candidate { robot, position: roads.position(node) });
            }
        }
        self.times.begin();
        for order in self.tasks.open_orders() {
            if let Some(stop) = order.content().stops().get(order.handled_stops()) {
                self.times.prepare(&roads, stop.node);
            }
        }
        let (steering, times) = (&self.steering, &self.times);
        let secs = |robot: u32, node: u32| times.between(&roads, steering.base_end_node(robot)?, node);
        let changes = self.tasks.assign(now_secs, &self.candidates, &secs);
        changes.withdrawn.into_iter().for_each(|(_, robot)| self.halt(robot));
        for (_, robot) in changes.assigned {
            if let Some(stop) = self.tasks.current_stop(robot) {
                self.send(robot, stop.node);
            }
        }
    }

    fn send(&mut self, robot: u32, node: u32) {
        self.errands[robot as usize] = Errand::To(node);
        self.steering.send(robot, node);
    }

    fn halt(&mut self, robot: u32) {
        self.errands[robot as usize] = Errand::None;
        self.steering.halt(robot);
    }
}
