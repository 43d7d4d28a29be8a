//! What the robots of a fleet manager drive: metres with a load and without, and the part of their
//! time that is work.

use regatta_plugin::Frame;
use regatta_plugin::activity::Activity;
use regatta_plugin::frame::RobotState;

/// Totals over all robots of a run, since a reader began to read its frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Seconds of simulated time that robots had a task.
    pub busy_secs: f64,
    /// Seconds of simulated time that robots were there.
    pub robot_secs: f64,
    /// Metres driven by robots that carry something.
    pub loaded_metres: f64,
    /// Metres driven by all others.
    pub empty_metres: f64,
}

impl Effort {
    /// The part of the robots' time in which they had a task, from 0 to 1; `None` without time.
    pub fn utilisation(&self) -> Option<f64> {
        (self.robot_secs > 0.0).then(|| self.busy_secs / self.robot_secs)
    }

    /// The part of the metres that were driven without a load, from 0 to 1; `None` without metres.
    pub fn empty_part(&self) -> Option<f64> {
        let metres = self.loaded_metres + self.empty_metres;
        (metres > 0.0).then(|| self.empty_metres / metres)
    }

    /// Adds what robots do for some seconds, given their states, their speeds and the values of the
    /// column `activity`.
    fn add(&mut self, states: &[u8], speeds: &[f32], activities: &[f32], secs: f64) {
        for ((&state, &speed), &activity) in states.iter().zip(speeds).zip(activities) {
            let Some(activity) =
                Activity::from_value(activity).filter(|_| state != RobotState::Absent as u8)
            else {
                continue;
            };
            self.robot_secs += secs;
            self.busy_secs += if activity.has_task() { secs } else { 0.0 };
            let metres = f64::from(speed.abs()) * secs;
            *(if activity == Activity::Carrying {
                &mut self.loaded_metres
            } else {
                &mut self.empty_metres
            }) += metres;
        }
    }
}

/// A tally of [`Effort`], fed with frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct EffortTally {
    /// The run and the simulated time in seconds of the last frame.
    last: Option<(u64, f64)>,
    effort: Effort,
}

impl EffortTally {
    /// Adds the time from the frame before to this one; robots are taken to have done all the while
    /// what the column `activity` says now.
    pub fn add(&mut self, frame: &Frame<'_>, activities: &[f32]) {
        let (run_id, now_secs) = (frame.run_id(), frame.sim_time().as_secs_f64());
        match self.last.replace((run_id, now_secs)) {
            Some((run, before_secs)) if run == run_id && before_secs <= now_secs => {
                self.effort.add(frame.state(), frame.speed(), activities, now_secs - before_secs);
            }
            _ => self.effort = Effort::default(),
        }
    }

    /// The totals so far.
    pub fn effort(&self) -> Effort {
        self.effort
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_and_metres_add_up() {
        let (driving, absent) = (RobotState::Driving as u8, RobotState::Absent as u8);
        let activities = [Activity::ToPick, Activity::Carrying, Activity::Idle, Activity::Idle]
            .map(|a| a as u8 as f32);
        let mut effort = Effort::default();
        assert_eq!((effort.utilisation(), effort.empty_part()), (None, None));
        effort.add(&[driving, driving, driving, absent], &[1.0, -2.0, 0.0, 9.0], &activities, 0.5);
        assert_eq!((effort.robot_secs, effort.busy_secs), (1.5, 1.0));
        assert_eq!((effort.loaded_metres, effort.empty_metres), (1.0, 0.5));
        effort.add(&[driving], &[1.0], &[f32::NAN], 0.5);
        assert_eq!(effort.robot_secs, 1.5, "no activity is known");
    }
}
