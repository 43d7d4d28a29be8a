//! The last ten minutes of a live run, in bounded memory. They can be viewed while the run
//! continues.
//!
//! Frames are kept whole, as they were in shared memory, with the activities of their robots, but
//! not all of them: as many per simulated
//! second as the memory allows for ten minutes, and at most ten. If even one each two seconds is
//! too much, less than ten minutes are kept.

use std::collections::VecDeque;

use regatta_interface::view_model::Live;
use regatta_plugin::Frame;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, frame_lines};

/// The simulated time that is kept at most, in nanoseconds.
const KEPT: u64 = 600_000_000_000;
/// The shortest and the longest time between two kept frames, in nanoseconds.
const INTERVALS: (u64, u64) = (100_000_000, 2_000_000_000);

/// A frame with memory of its own.
#[derive(Debug)]
struct KeptFrame {
    header: FrameHeader,
    lines: Box<[Line]>,
    /// The values of the column `activity`, if a fleet manager publishes it.
    activities: Option<Box<[f32]>>,
}

impl KeptFrame {
    fn copy(frame: &Frame<'_>, activities: Option<&[f32]>) -> Self {
        let robots = frame.len();
        let mut lines = vec![Line::default(); frame_lines(robots)].into_boxed_slice();
        let to = ColumnsMut::split(&mut lines, robots);
        to.x[..robots].copy_from_slice(frame.x());
        to.y[..robots].copy_from_slice(frame.y());
        to.theta[..robots].copy_from_slice(frame.theta());
        to.speed[..robots].copy_from_slice(frame.speed());
        to.s[..robots].copy_from_slice(frame.s());
        to.edge[..robots].copy_from_slice(frame.edge());
        to.state[..robots].copy_from_slice(frame.state());
        Self { header: *frame.header(), lines, activities: activities.map(Box::from) }
    }

    fn bytes(&self) -> usize {
        let activities = self.activities.as_deref().map_or(0, size_of_val);
        size_of_val(&*self.lines) + activities + size_of::<Self>()
    }
}

/// The frames of the current run that are kept.
#[derive(Debug)]
pub struct FrameHistory {
    frames: VecDeque<KeptFrame>,
    bytes: usize,
    budget: usize,
}

impl Default for FrameHistory {
    fn default() -> Self {
        Self::new(Live::BUDGET)
    }
}

impl FrameHistory {
    /// Creates an empty history with room for so many bytes.
    pub fn new(budget: usize) -> Self {
        Self { frames: VecDeque::new(), bytes: 0, budget }
    }

    /// Keeps a copy of a frame and of the activities of its robots if one is due. Drops copies that
    /// are too old or have no room. Another run resets the history.
    pub fn take(&mut self, frame: &Frame<'_>, activities: Option<&[f32]>) {
        let now = frame.header().sim_time_nanos;
        let last = self.frames.back().map(|last| (last.header.run_id, last.header.sim_time_nanos));
        if last.is_some_and(|(run, time)| run != frame.run_id() || now < time) {
            (self.frames, self.bytes) = (VecDeque::new(), 0);
        } else if last.is_some_and(|(_, time)| now - time < self.interval(frame.len(), activities))
        {
            return;
        }
        let kept = KeptFrame::copy(frame, activities);
        self.bytes += kept.bytes();
        self.frames.push_back(kept);
        // The newest one is kept in any case.
        while self.frames.len() > 1 && (self.bytes > self.budget || self.length() > KEPT) {
            self.bytes -= self.frames.pop_front().map_or(0, |oldest| oldest.bytes());
        }
    }

    /// The time between two kept frames of so many robots, in nanoseconds.
    fn interval(&self, robots: usize, activities: Option<&[f32]>) -> u64 {
        let lines = frame_lines(robots) * size_of::<Line>();
        let bytes = (lines + activities.map_or(0, size_of_val) + size_of::<KeptFrame>()) as u64;
        (KEPT / (self.budget as u64 / bytes).max(1)).clamp(INTERVALS.0, INTERVALS.1)
    }

    fn length(&self) -> u64 {
        self.span().map_or(0, |(start, end)| end - start)
    }

    /// The simulated times of the oldest and the newest kept frame, in nanoseconds.
    pub fn span(&self) -> Option<(u64, u64)> {
        Some((
            self.frames.front()?.header.sim_time_nanos,
            self.frames.back()?.header.sim_time_nanos,
        ))
    }

    /// The memory that is in use, in bytes.
    pub fn bytes(&self) -> usize {
        self.bytes
    }

    /// The newest kept frame at or before a simulated time, or the oldest one.
    pub fn at(&self, time: u64) -> Option<Frame<'_>> {
        let frame = self.kept_at(time)?;
        Frame::new(&frame.header, &frame.lines)
    }

    /// The activities of the robots of that frame, if a fleet manager published them.
    pub fn activities_at(&self, time: u64) -> Option<&[f32]> {
        self.kept_at(time)?.activities.as_deref()
    }

    fn kept_at(&self, time: u64) -> Option<&KeptFrame> {
        let after = self.frames.partition_point(|frame| frame.header.sim_time_nanos <= time);
        self.frames.get(after.saturating_sub(1))
    }

    /// The time of the first kept frame after a simulated time, in nanoseconds.
    pub fn after(&self, time: u64) -> Option<u64> {
        let after = self.frames.partition_point(|frame| frame.header.sim_time_nanos <= time);
        self.frames.get(after).map(|frame| frame.header.sim_time_nanos)
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::stride_lines;

    use super::*;

    /// The run of a fleet with a manager.
    const MANAGED: u64 = 7;

    /// Passes frames of so many robots to a history, a tick of 50 ms each.
    fn run(history: &mut FrameHistory, run_id: u64, robots: usize, ticks: std::ops::Range<u64>) {
        let mut lines = vec![Line::default(); frame_lines(robots)];
        for tick in ticks {
            ColumnsMut::split(&mut lines, robots).x.fill(tick as f32);
            let header = FrameHeader {
                run_id,
                tick,
                sim_time_nanos: tick * 50_000_000,
                robots: robots as u32,
                stride_lines: stride_lines(robots) as u32,
                ..FrameHeader::default()
            };
            let activities = vec![(tick % 8) as f32; robots];
            let activities = (run_id == MANAGED).then_some(&*activities);
            history.take(&Frame::new(&header, &lines).expect("a frame"), activities);
        }
    }

    #[test]
    fn ten_minutes_are_kept_and_found_by_their_times() {
        let mut history = FrameHistory::default();
        run(&mut history, 1, 10, 0..20_000);
        let (start, end) = history.span().expect("frames");
        assert_eq!(end, 999_900_000_000);
        assert_eq!(end - start, KEPT);
        let frame = history.at(700_060_000_000).expect("a frame");
        assert_eq!((frame.tick(), frame.x()[9]), (14_000, 14_000.0), "the newest one until then");
        assert_eq!(history.at(0).expect("the oldest").header().sim_time_nanos, start);
        assert_eq!(
            (history.after(700_000_000_000), history.after(end)),
            (Some(700_100_000_000), None)
        );
        run(&mut history, 2, 10, 0..3);
        assert_eq!(history.span(), Some((0, 100_000_000)), "another run begins anew");
    }

    #[test]
    fn many_robots_have_fewer_frames_and_never_more_memory() {
        let mut history = FrameHistory::new(1 << 20);
        run(&mut history, 1, 1000, 0..4000);
        assert!(history.bytes() <= 1 << 20 && history.bytes() > 900_000, "{}", history.bytes());
        let frame = history.bytes() / history.frames.len();
        assert!((25_000..27_000).contains(&frame), "{frame} bytes for a thousand robots");
        let (start, end) = history.span().expect("frames");
        assert_eq!(
            (end - start) / (history.frames.len() as u64 - 1),
            INTERVALS.1,
            "and so less than ten minutes"
        );
        let mut tiny = FrameHistory::new(10);
        run(&mut tiny, 1, 1000, 0..100);
        assert_eq!(tiny.frames.len(), 1, "the newest one");
    }

    #[test]
    fn activities_are_kept_with_their_frames() {
        let mut history = FrameHistory::new(1 << 20);
        run(&mut history, MANAGED, 1000, 0..4000);
        assert!(history.bytes() <= 1 << 20, "{}", history.bytes());
        let (_, end) = history.span().expect("frames");
        let tick = history.at(end).expect("a frame").tick();
        let activities = history.activities_at(end).expect("activities");
        assert_eq!(activities, vec![(tick % 8) as f32; 1000]);
        run(&mut history, MANAGED + 1, 10, 0..3);
        assert_eq!(history.activities_at(0), None, "no fleet manager");
    }
}
