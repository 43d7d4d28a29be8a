//! The action `NavigateToPose` of a robot, as Nav2 serves it.

use std::time::{Duration as StdDuration, Instant};

use regatta_plugin::frame::RobotState;
use regatta_plugin::tell;
use ros2_client::RmwRequestId;
use ros2_client::action::{
    ActionServer, CancelGoalRequest, CancelGoalResponse, GetResultResponse, GoalId, GoalInfo,
    GoalStatusEnum, SendGoalResponse,
};
use ros2_client::action_msgs::{CancelGoalResponseEnum, GoalStatus, GoalStatusArray};
use ros2_client::builtin_interfaces::Time as RosTime;
use ros2_client::dds::rustdds::RepresentationIdentifier;
use ros2_client::dds::rustdds::serialization::{
    deserialize_from_cdr_with_rep_id, to_writer_with_rep_id,
};
use serde::Deserialize;

use crate::desk::Fleet;
use crate::link::{Link, LinkError, asked};
use crate::map::Place;
use crate::message::geometry::{Duration, Header, PoseStamped};
use crate::message::navigation::{
    NavigateToPoseFeedback, NavigateToPoseGoal, NavigateToPoseResult, UNKNOWN,
};
use crate::options::robot_name;
use crate::poses::MAP;
use crate::snapshot::{Robot, Snapshot};
use crate::steering::Refusal;

/// A robot this close to the node of its goal is there, in metres.
const THERE: f64 = 0.05;
/// The speed below which it stands, in metres per second.
const STANDS: f64 = 0.01;
/// The time between two messages of feedback.
const FEEDBACK_EVERY: StdDuration = StdDuration::from_millis(200);
/// Goals that are remembered after their end, so that their result can be asked for.
const REMEMBERED: usize = 16;
/// Requests for results that may wait for a goal's end.
const MOST_WAITING: usize = 8;

type Server = ActionServer<NavigateToPoseGoal, NavigateToPoseResult, NavigateToPoseFeedback>;

/// The action.
pub(crate) struct Navigation {
    robot: u32,
    server: Server,
    /// From the oldest on.
    goals: Vec<Goal>,
    told: Instant,
}

/// A goal that was accepted.
struct Goal {
    id: GoalId,
    accepted: RosTime,
    place: Place,
    /// Simulated time of its acceptance.
    start: StdDuration,
    status: GoalStatusEnum,
    reason: String,
    /// Requests for its result.
    waiting: Vec<RmwRequestId>,
}

impl Goal {
    fn is_active(&self) -> bool {
        self.status == GoalStatusEnum::Executing
    }

    fn info(&self) -> GoalInfo {
        GoalInfo { goal_id: self.id, stamp: self.accepted }
    }

    fn result(&self) -> GetResultResponse<NavigateToPoseResult> {
        let is_good = self.status == GoalStatusEnum::Succeeded;
        let error_code = if is_good { 0 } else { UNKNOWN };
        let result = NavigateToPoseResult { error_code, error_msg: self.reason.clone() };
        GetResultResponse { status: self.status, result }
    }
}

/// The fields of a [`CancelGoalRequest`], which has them to itself.
#[derive(Deserialize)]
struct Cancellation {
    goal_id: GoalId,
    stamp: RosTime,
}

impl Cancellation {
    fn of(request: &CancelGoalRequest) -> Option<Self> {
        let (mut bytes, encoding) = (Vec::new(), RepresentationIdentifier::CDR_LE);
        to_writer_with_rep_id(&mut bytes, request, encoding).ok()?;
        let fields = deserialize_from_cdr_with_rep_id(&bytes, encoding);
        fields.ok().map(|(fields, _)| fields)
    }

    /// Whether it means a goal: by its id, or all that were accepted up to a time, or all.
    fn means(&self, goal: &Goal) -> bool {
        let is_older = goal.accepted <= self.stamp;
        match (self.goal_id == GoalId::ZERO, self.stamp == RosTime::ZERO) {
            (true, true) => true,
            (true, false) => is_older,
            (false, true) => self.goal_id == goal.id,
            (false, false) => self.goal_id == goal.id || is_older,
        }
    }
}

impl Navigation {
    pub fn open(robot: u32, link: &mut Link) -> Result<Self, LinkError> {
        let name = format!("{}/navigate_to_pose", robot_name(robot));
        let server = link.action(&name, "nav2_msgs", "NavigateToPose")?;
        Ok(Self { robot, server, goals: Vec::new(), told: Instant::now() })
    }

    /// Takes requests, and follows the robot to its goal.
    pub fn serve(&mut self, fleet: &mut Fleet<'_>) {
        for (request, goal) in asked(self.server.goal_server()) {
            let accepted = self.take_goal(goal.goal_id, &goal.goal, fleet);
            let response = SendGoalResponse { accepted, stamp: RosTime::now() };
            tell_failure(self.server.send_goal_response(request, response));
            self.publish_statuses();
        }
        for (request, cancellation) in asked(self.server.cancel_server()) {
            let response = self.cancel(&cancellation, fleet);
            tell_failure(self.server.send_cancel_response(request, response));
        }
        self.take_result_requests();
        self.follow(fleet.snapshot);
    }

    /// Ends the goal, as the engine has refused the way there.
    pub fn refuse(&mut self, refusal: &Refusal) {
        if refusal.robot == self.robot {
            self.end(GoalStatusEnum::Aborted, &refusal.reason);
        }
    }

    /// Whether the goal is accepted.
    fn take_goal(&mut self, id: GoalId, goal: &NavigateToPoseGoal, fleet: &mut Fleet<'_>) -> bool {
        let place = match fleet.map.goal(&goal.pose) {
            Ok(place) => place.clone(),
            Err(error) => {
                fleet.steering.log_refusal("goal", self.robot, &error.to_string());
                return false;
            }
        };
        if self.goals.iter().any(|other| other.id == id) {
            return false;
        }
        if let Err(error) = fleet.steering.send(self.robot, place.node) {
            fleet.steering.log_refusal("goal", self.robot, &error.to_string());
            return false;
        }
        self.end(GoalStatusEnum::Aborted, "another goal has come");
        if self.goals.len() == REMEMBERED {
            self.goals.remove(0);
        }
        self.goals.push(Goal {
            id,
            accepted: RosTime::now(),
            place,
            start: fleet.snapshot.sim_time,
            status: GoalStatusEnum::Executing,
            reason: String::new(),
            waiting: Vec::new(),
        });
        true
    }

    fn cancel(&mut self, request: &CancelGoalRequest, fleet: &mut Fleet<'_>) -> CancelGoalResponse {
        let failed = |return_code| CancelGoalResponse { return_code, goals_canceling: Vec::new() };
        let Some(cancellation) = Cancellation::of(request) else {
            return failed(CancelGoalResponseEnum::Rejected);
        };
        let mut meant = self.goals.iter().filter(|goal| cancellation.means(goal)).peekable();
        if meant.peek().is_none() && cancellation.goal_id != GoalId::ZERO {
            return failed(CancelGoalResponseEnum::UnknownGoal);
        }
        let Some(info) = meant.find(|goal| goal.is_active()).map(Goal::info) else {
            return failed(CancelGoalResponseEnum::GoalTerminated);
        };
        if let Err(error) = fleet.steering.cancel(self.robot) {
            fleet.steering.log_refusal("cancellation", self.robot, &error.to_string());
            return failed(CancelGoalResponseEnum::Rejected);
        }
        self.end(GoalStatusEnum::Canceled, "cancelled");
        let return_code = CancelGoalResponseEnum::None;
        CancelGoalResponse { return_code, goals_canceling: vec![info] }
    }

    fn take_result_requests(&mut self) {
        for (request, question) in asked(self.server.result_server()) {
            let goal = self.goals.iter_mut().find(|goal| goal.id == question.goal_id);
            let response = match goal {
                Some(goal) if goal.is_active() => {
                    if goal.waiting.len() < MOST_WAITING {
                        goal.waiting.push(request);
                    }
                    continue;
                }
                Some(goal) => goal.result(),
                None => GetResultResponse {
                    status: GoalStatusEnum::Unknown,
                    result: NavigateToPoseResult::default(),
                },
            };
            tell_failure(self.server.send_result(request, response));
        }
    }

    /// Ends the goal that the robot drives to, if there is one.
    fn end(&mut self, status: GoalStatusEnum, reason: &str) {
        let Some(goal) = self.goals.iter_mut().find(|goal| goal.is_active()) else { return };
        goal.status = status;
        goal.reason = reason.to_owned();
        let result = goal.result();
        for request in std::mem::take(&mut goal.waiting) {
            tell_failure(self.server.send_result(request, result.clone()));
        }
        self.publish_statuses();
    }

    /// Looks whether the robot is there, and tells how far it has come.
    fn follow(&mut self, snapshot: &Snapshot) {
        let Some(goal) = self.goals.iter().find(|goal| goal.is_active()) else { return };
        let Some(robot) = snapshot.robot(self.robot) else {
            return self.end(GoalStatusEnum::Aborted, "the robot has left the fleet");
        };
        let distance = (goal.place.x - robot.x).hypot(goal.place.y - robot.y);
        if distance < THERE && robot.speed.abs() < STANDS {
            return self.end(GoalStatusEnum::Succeeded, "");
        }
        if robot.state == RobotState::Faulted {
            return self.end(GoalStatusEnum::Aborted, "the robot can't continue");
        }
        if self.told.elapsed() >= FEEDBACK_EVERY {
            self.told = Instant::now();
            let feedback = feedback(robot, distance, goal.start, snapshot);
            // One that isn't taken is outdated soon.
            let _ = self.server.send_feedback(goal.id, feedback);
        }
    }

    fn publish_statuses(&self) {
        let statuses = self.goals.iter();
        let statuses =
            statuses.map(|goal| GoalStatus { goal_info: goal.info(), status: goal.status });
        let statuses = GoalStatusArray { status_list: statuses.collect() };
        // The next change brings all of them again.
        let _ = self.server.send_goal_statuses(statuses);
    }
}

/// Distance and time are those of a straight line at the present speed.
fn feedback(
    robot: &Robot,
    distance: f64,
    start: StdDuration,
    snapshot: &Snapshot,
) -> NavigateToPoseFeedback {
    let header = Header::new(&snapshot.stamp(), MAP);
    let seconds = if robot.speed.abs() > STANDS { distance / robot.speed.abs() } else { 0.0 };
    NavigateToPoseFeedback {
        current_pose: PoseStamped { header, pose: robot.pose() },
        navigation_time: Duration::of(snapshot.sim_time.saturating_sub(start)),
        estimated_time_remaining: Duration::of(StdDuration::from_secs_f64(seconds.min(1e6))),
        distance_remaining: distance as f32,
        ..NavigateToPoseFeedback::default()
    }
}

fn tell_failure(sent: Result<(), ros2_client::WriteError<()>>) {
    if let Err(error) = sent {
        tell!("ros2: a response can't be sent: {error}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn goal(number: u8, accepted: i64) -> Goal {
        let bytes = [number; 16];
        let id = deserialize_from_cdr_with_rep_id(&bytes, RepresentationIdentifier::CDR_LE);
        let (id, _): (GoalId, usize) = id.expect("sixteen bytes");
        Goal {
            id,
            accepted: RosTime::from_nanos(accepted),
            place: Place { node: 1, x: 0.0, y: 0.0, level: String::new() },
            start: StdDuration::ZERO,
            status: GoalStatusEnum::Executing,
            reason: String::new(),
            waiting: Vec::new(),
        }
    }

    #[test]
    fn goals_are_cancelled_by_id_by_time_or_all() {
        let goals = [goal(1, 10), goal(2, 20), goal(3, 30)];
        let meant = |goal_id, stamp| {
            let cancellation = Cancellation { goal_id, stamp: RosTime::from_nanos(stamp) };
            goals.iter().map(|goal| cancellation.means(goal)).collect::<Vec<_>>()
        };
        assert_eq!(meant(GoalId::ZERO, 0), [true, true, true]);
        assert_eq!(meant(GoalId::ZERO, 20), [true, true, false]);
        assert_eq!(meant(goals[2].id, 0), [false, false, true]);
        assert_eq!(meant(goals[2].id, 10), [true, false, true]);
    }
}
