//! A plugin outside Regatta's repository: how long has each robot been standing?
//!
//! It publishes that as the column `standing`, in seconds, which the viewer can tint by, and prints
//! the robot that has stood the longest, once a second.
//!
//!     regatta run graphs/thirty.yaml &
//!     cargo run --release -- --rate 10

use regatta_plugin::frame::RobotState;
use regatta_plugin::{ColumnPublisher, Frame, Participant, Plugin, Result};

/// Slower than this is standing, in m/s.
const STANDING: f32 = 0.001;

#[derive(Default)]
struct Standing {
    column: Option<ColumnPublisher>,
    run_id: u64,
    /// Per robot, the simulated time in seconds at which it was last seen to move.
    moved: Vec<f64>,
    standing: Vec<f32>,
    next_line: f64,
}

impl Plugin for Standing {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.column = Some(ColumnPublisher::open_on(fleet, "standing")?);
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame) -> Result {
        let now = frame.sim_time().as_secs_f64();
        if frame.run_id() != self.run_id {
            // The engine was restarted, and so was its clock.
            *self = Self { column: self.column.take(), run_id: frame.run_id(), ..Self::default() };
        }
        self.moved.resize(frame.len(), now);
        self.standing.resize(frame.len(), 0.0);
        for (robot, speed) in frame.speed().iter().enumerate() {
            if speed.abs() > STANDING || frame.state_of(robot) == RobotState::Absent {
                self.moved[robot] = now;
            }
            self.standing[robot] = (now - self.moved[robot]) as f32;
        }
        if let Some(column) = &mut self.column {
            column.publish(frame, &self.standing)?;
        }
        if now >= self.next_line {
            self.next_line = now + 1.0;
            self.print_longest(frame.tick());
        }
        Ok(())
    }
}

impl Standing {
    fn print_longest(&self, tick: u64) {
        let longest = self.standing.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        if let Some((robot, seconds)) = longest {
            println!("tick {tick}: robot {robot} has stood for {seconds:.1} s");
        }
    }
}

fn main() -> Result {
    regatta_plugin::run(Standing::default())
}
