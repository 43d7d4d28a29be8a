//! Requests the routes of many robots, some at a time, round after round.

use std::time::{Duration, Instant};

use regatta_interface::robot_filter::{RobotSet, is_in};
use regatta_plugin::frame::RobotState;
use regatta_plugin::route::RouteResponse;
use regatta_plugin::{Frame, RouteClient, RouteError};
use regatta_scene::plans::Coverage;

/// The maximum number of robots whose routes are requested. An answer takes a kilobyte.
const MAX_ROBOTS: usize = 16_384;
/// The number of routes that are asked for at once.
const AT_ONCE: usize = 8;
/// The longest wait for an answer.
const TIMEOUT: Duration = Duration::from_millis(200);

/// The routes of all robots at their last request.
#[derive(Debug)]
pub struct Collector {
    routes: Vec<Option<Box<RouteResponse>>>,
    /// The run that the routes belong to.
    run: u64,
    next: usize,
    round_began: Instant,
    round_secs: f32,
}

impl Collector {
    /// Creates a collector that knows no routes.
    pub fn new() -> Self {
        Self {
            routes: Vec::new(),
            run: 0,
            next: 0,
            round_began: Instant::now(),
            round_secs: f32::INFINITY,
        }
    }

    /// Asks for the routes of the next of some robots (`None` for all) that are under way in a
    /// frame, until `until` or the end of the round. Returns whether the round has ended.
    ///
    /// # Errors
    /// [`RouteError`]: there are no answers now.
    pub fn advance(
        &mut self,
        client: &mut RouteClient,
        frame: &Frame<'_>,
        robots: Option<&RobotSet>,
        until: Instant,
    ) -> Result<bool, RouteError> {
        self.fit(frame);
        loop {
            let batch = self.batch(frame, robots);
            if !batch.is_empty() {
                for answer in client.routes(&batch, TIMEOUT)? {
                    let is_current = answer.is_found() && answer.run_id == self.run;
                    if let Some(route) = self.routes.get_mut(answer.robot as usize) {
                        *route = is_current.then(|| Box::new(answer));
                    }
                }
            }
            if self.next == self.routes.len() {
                self.round_secs = self.round_began.elapsed().as_secs_f32();
                (self.next, self.round_began) = (0, Instant::now());
                return Ok(true);
            }
            if Instant::now() >= until {
                return Ok(false);
            }
        }
    }

    /// Starts again with another run, and adapts to the number of robots.
    fn fit(&mut self, frame: &Frame<'_>) {
        if self.run != frame.run_id() {
            *self = Self { run: frame.run_id(), ..Self::new() };
        }
        self.routes.resize(frame.len().min(MAX_ROBOTS), None);
        self.next = self.next.min(self.routes.len());
    }

    /// Takes the next robots to request. Robots without a route, and robots that aren't wanted, are
    /// skipped.
    fn batch(&mut self, frame: &Frame<'_>, robots: Option<&RobotSet>) -> Vec<u32> {
        let mut batch = Vec::with_capacity(AT_ONCE);
        while self.next < self.routes.len() && batch.len() < AT_ONCE {
            if is_under_way(frame, self.next) && is_in(robots, self.next as u32) {
                batch.push(self.next as u32);
            } else {
                self.routes[self.next] = None;
            }
            self.next += 1;
        }
        batch
    }

    /// The routes that are known.
    pub fn routes(&self) -> impl Iterator<Item = &RouteResponse> {
        self.routes.iter().flatten().map(AsRef::as_ref)
    }

    /// Counts those of some robots (`None` for all) under way in a frame that have a known route.
    pub fn coverage(&self, frame: &Frame<'_>, robots: Option<&RobotSet>) -> Coverage {
        let mut all = Coverage { round_secs: self.round_secs, ..Coverage::default() };
        for robot in 0..frame.len() {
            if is_under_way(frame, robot) && is_in(robots, robot as u32) {
                all.under_way += 1;
                all.known += u32::from(self.routes.get(robot).is_some_and(Option::is_some));
            }
        }
        all
    }
}

fn is_under_way(frame: &Frame<'_>, robot: usize) -> bool {
    !matches!(frame.state_of(robot), RobotState::Absent | RobotState::Idle)
}
