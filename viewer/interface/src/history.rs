//! The recent values of the selected robot, for the plots of the selection panel.

use std::collections::VecDeque;

use egui_plot::PlotPoints;
use regatta_plugin::frame::{Frame, RobotState};

/// Simulated seconds that the plots show.
pub const SPAN: f64 = 60.0;
/// The plotted values: name, unit, and the smallest span of the value axis.
pub const PLOTS: [(&str, &str, f64); 4] =
    [("x", "m", 1.0), ("y", "m", 1.0), ("θ", "°", 20.0), ("speed", "m/s", 0.5)];
/// The smallest distance between two points, in simulated seconds.
const MIN_GAP: f64 = 0.05;
/// The index of the heading in [`PLOTS`].
const THETA: usize = 2;

/// The simulated time between two snapshots of all robots, in seconds.
const SNAPSHOT_GAP: f64 = 0.25;
/// The maximum memory for the snapshots of a minute, in bytes; a larger fleet is not recorded.
const MAX_BYTES: f64 = 64e6;

/// The columns of all robots during the last minute, copied as they are a few times per simulated
/// second.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    run: u64,
    snapshots: VecDeque<Snapshot>,
}

#[derive(Clone, Debug)]
struct Snapshot {
    /// Simulated seconds.
    at: f64,
    columns: [Vec<f32>; 4],
    state: Vec<u8>,
}

impl Recorder {
    /// Takes a snapshot of a frame if one is due. Another run, or a step back in time, resets the
    /// history.
    pub fn push(&mut self, frame: &Frame<'_>) {
        let now = frame.sim_time().as_secs_f64();
        let last = self.snapshots.back().map_or(f64::NEG_INFINITY, |snapshot| snapshot.at);
        if self.run != frame.run_id() || now < last {
            (self.run, self.snapshots) = (frame.run_id(), VecDeque::new());
        } else if now < last + SNAPSHOT_GAP {
            return;
        }
        if frame.len() as f64 * 17.0 * SPAN / SNAPSHOT_GAP > MAX_BYTES {
            self.snapshots.clear();
            return;
        }
        let columns = [frame.x(), frame.y(), frame.theta(), frame.speed()].map(<[f32]>::to_vec);
        self.snapshots.push_back(Snapshot {
            at: now,
            columns,
            state: frame.columns().state.to_vec(),
        });
        while self.snapshots.front().is_some_and(|snapshot| snapshot.at < now - SPAN) {
            self.snapshots.pop_front();
        }
    }

    /// Returns the points of a robot's history that were recorded before the newest frame.
    fn points(&self, run: u64, row: usize) -> VecDeque<Point> {
        let mut points = VecDeque::new();
        for snapshot in self.snapshots.iter().filter(|_| self.run == run) {
            let state = snapshot.state.get(row);
            if state.is_some_and(|state| *state != RobotState::Absent as u8) {
                let values = [0, 1, 2, 3].map(|column: usize| snapshot.columns[column][row]);
                points.push_back(Point::new(snapshot.at, values));
            }
        }
        points
    }
}

/// The values of a robot at a time.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Simulated seconds.
    at: f64,
    /// The values of [`PLOTS`].
    values: [f64; 4],
}

impl Point {
    /// Creates a point of x, y, the heading in radians, and the speed.
    fn new(at: f64, [x, y, theta, speed]: [f32; 4]) -> Self {
        Self { at, values: [x, y, theta.to_degrees(), speed].map(f64::from) }
    }
}

/// The values of one robot during the last minute.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// The run id and the robot's id.
    source: Option<(u64, u32)>,
    points: VecDeque<Point>,
}

impl History {
    /// Adds the values of a frame. Another robot or run, or a step back in time, resets the
    /// history. The history of another robot starts with its recorded values.
    pub fn push(&mut self, frame: &Frame<'_>, robot: u32, recorder: &Recorder) {
        let (row, now) = (robot as usize, frame.sim_time().as_secs_f64());
        let source = Some((frame.run_id(), robot));
        let last = self.points.back().map_or(f64::NEG_INFINITY, |point| point.at);
        if self.source != source || now < last {
            *self = Self { source, points: recorder.points(frame.run_id(), row) };
        } else if now < last + MIN_GAP {
            return;
        }
        if frame.state_of(row) == RobotState::Absent {
            return;
        }
        let values = [frame.x(), frame.y(), frame.theta(), frame.speed()].map(|column| column[row]);
        self.points.push_back(Point::new(now, values));
        while self.points.front().is_some_and(|point| point.at < now - SPAN) {
            self.points.pop_front();
        }
    }

    /// Returns the smallest and the largest value of one plot, at least `span` apart.
    pub fn range(&self, plot: usize, span: f64) -> [f64; 2] {
        let values = self.points.iter().map(|point| point.values[plot]);
        let (low, high) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (middle, half) = ((low + high) / 2.0, ((high - low) / 2.0).max(span / 2.0));
        if low <= high { [middle - half, middle + half] } else { [0.0, span] }
    }

    /// Returns the lines of one plot: seconds before now, and the value. The heading's line is
    /// split where the angle wraps round.
    pub fn lines(&self, plot: usize) -> Vec<PlotPoints<'static>> {
        let now = self.points.back().map_or(0.0, |point| point.at);
        let points: Vec<_> =
            self.points.iter().map(|point| [point.at - now, point.values[plot]]).collect();
        let is_continuous =
            |a: &[f64; 2], b: &[f64; 2]| plot != THETA || (a[1] - b[1]).abs() < 180.0;
        points.chunk_by(is_continuous).map(|part| PlotPoints::from(part.to_vec())).collect()
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines, stride_lines};

    use super::*;

    #[test]
    fn the_history_of_a_robot_begins_before_it_is_selected() {
        let mut lines = vec![Line::default(); frame_lines(3)];
        let (mut recorder, mut history) = (Recorder::default(), History::default());
        for step in 0..100_u64 {
            let columns = ColumnsMut::split(&mut lines, 3);
            (0..3).for_each(|row| (columns.x[row], columns.state[row]) = (step as f32, 1));
            let sim_time_nanos = step * 100_000_000;
            let stride_lines = stride_lines(3) as u32;
            let header = FrameHeader {
                run_id: 1,
                robots: 3,
                stride_lines,
                sim_time_nanos,
                ..FrameHeader::default()
            };
            let frame = Frame::new(&header, &lines).expect("a frame");
            recorder.push(&frame);
            if step == 99 {
                history.push(&frame, 1, &recorder);
            }
        }
        let [low, high] = history.range(0, 1.0);
        assert_eq!((low, high), (0.0, 99.0), "from the first frame on");
        assert!(history.points.len() > 30, "{}", history.points.len());
    }
}
