//! The recent values of the selected robot, for the plots of the selection panel.

use std::collections::VecDeque;

use egui_plot::PlotPoints;
use regatta_plugin::frame::{Frame, RobotState};

/// Simulated seconds that the plots show.
pub const SPAN: f64 = 60.0;
/// The plotted values: name, unit, and the smallest span of the value axis.
pub const PLOTS: [(&str, &str, f64); 4] = [("x", "m", 1.0), ("y", "m", 1.0), ("θ", "°", 20.0), ("speed", "m/s", 0.5)];
/// The smallest distance between two points, in simulated seconds.
const MIN_GAP: f64 = 0.05;
/// The index of the heading in [`PLOTS`].
const THETA: usize = 2;

/// The values of one robot during the last minute.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// The run id and the robot's id.
    source: Option<(u64, u32)>,
    /// Simulated seconds, then the values of [`PLOTS`].
    points: VecDeque<[f64; 5]>,
}

impl History {
    /// Adds the values of a frame. The history starts anew with another robot or run, or when time has gone back.
    pub fn push(&mut self, frame: &Frame<'_>, robot: u32) {
        let (row, now) = (robot as usize, frame.sim_time().as_secs_f64());
        let source = Some((frame.run_id(), robot));
        let last = self.points.back().map_or(f64::NEG_INFINITY, |point| point[0]);
        if self.source != source || now < last {
            *self = Self { source, points: VecDeque::new() };
        } else if now < last + MIN_GAP {
            return;
        }
        if frame.state_of(row) == RobotState::Absent {
            return;
        }
        let values = [frame.x()[row], frame.y()[row], frame.theta()[row].to_degrees(), frame.speed()[row]];
        let [x, y, theta, speed] = values.map(f64::from);
        self.points.push_back([now, x, y, theta, speed]);
        while self.points.front().is_some_and(|point| point[0] < now - SPAN) {
            self.points.pop_front();
        }
    }

    /// Returns the smallest and the largest value of one plot, at least `span` apart.
    pub fn range(&self, plot: usize, span: f64) -> [f64; 2] {
        let values = self.points.iter().map(|point| point[plot + 1]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).max(span / 2.0));
        if low <= high { [middle - half, middle + half] } else { [0.0, span] }
    }

    /// Returns the lines of one plot: seconds before now, and the value. The heading's line is split where the angle
    /// wraps round.
    pub fn lines(&self, plot: usize) -> Vec<PlotPoints<'static>> {
        let now = self.points.back().map_or(0.0, |point| point[0]);
        let points: Vec<_> = self.points.iter().map(|point| [point[0] - now, point[plot + 1]]).collect();
        let is_continuous = |a: &[f64; 2], b: &[f64; 2]| plot != THETA || (a[1] - b[1]).abs() < 180.0;
        points.chunk_by(is_continuous).map(|part| PlotPoints::from(part.to_vec())).collect()
    }
}
