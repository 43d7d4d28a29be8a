//! The work of a fleet manager, if one runs and keeps up: what its robots are about, and its tasks.

use regatta_plugin::activity::Activity;
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::{ColumnReader, Frame, Participant, ReadError, Result, TaskReader};

use crate::aggregator::Aggregator;
use crate::effort::EffortTally;
use crate::received::Received;
use crate::snapshot::Work;
use crate::task_times::TimeRecorder;
use crate::tasks::TaskTally;

/// Numbers of robots by activity, in the order of [`Activity::ALL`].
type ByActivity = [u64; Activity::ALL.len()];

/// A reader of the column `activity` and the task log of a fleet.
#[derive(Debug)]
pub struct WorkReader {
    column: ColumnReader,
    tasks: TaskReader,
}

/// What has been read of a manager's work.
#[derive(Debug, Default)]
pub struct WorkTally {
    robots: Option<Received<ByActivity>>,
    tasks: TaskTally,
    effort: EffortTally,
    cycles: Cycles,
}

/// What the manager of a run spent on each frame.
#[derive(Debug, Default)]
struct Cycles {
    run_id: u64,
    secs: TimeRecorder,
}

impl Cycles {
    fn add(&mut self, header: &ColumnHeader) {
        if self.run_id != header.run_id {
            *self = Self { run_id: header.run_id, secs: TimeRecorder::default() };
        }
        // A manager that doesn't tell has no times.
        if header.cost_micros > 0 {
            self.secs.observe(f64::from(header.cost_micros) * 1e-6);
        }
    }
}

impl WorkReader {
    /// Opens both, whether or not a manager publishes them yet.
    ///
    /// # Errors
    /// Fails if the fleet uses another version of the contract, or has no room for another reader.
    pub fn open_on(participant: &Participant) -> Result<Self> {
        let tasks = TaskReader::open_on(participant)?;
        Ok(Self { column: ColumnReader::open_on(participant, "activity")?, tasks })
    }

    /// Adds what robots have done since the frame before.
    pub fn add_frame(&mut self, tally: &mut WorkTally, frame: &Frame<'_>) {
        // What can't be read is counted by `update`.
        let column = self
            .column
            .current()
            .ok()
            .flatten()
            .filter(|column| column.header.run_id == frame.run_id());
        tally.effort.add(frame, column.map_or(&[], |column| column.values));
    }

    /// Adds what is new at the wall time `now`, in nanoseconds. What can't be read is another
    /// program's error: it is counted and skipped.
    pub fn update(&mut self, tally: &mut WorkTally, aggregator: &mut Aggregator, now: u64) {
        for outcome in [self.read_robots(tally, now), self.read_tasks(tally, aggregator)] {
            if outcome.is_err() {
                aggregator.count_read_error();
            }
        }
    }

    fn read_robots(&mut self, tally: &mut WorkTally, now: u64) -> Result<(), ReadError> {
        if let Some(column) = self.column.latest()? {
            let (run_id, value) = (column.header.run_id, by_activity(column.values));
            tally.cycles.add(column.header);
            tally.robots = Some(Received { run_id, received_nanos: now, value });
        }
        Ok(())
    }

    /// Reads the task log. Before the first frame, the length of a tick is unknown.
    fn read_tasks(
        &mut self,
        tally: &mut WorkTally,
        aggregator: &Aggregator,
    ) -> Result<(), ReadError> {
        let Some(clock) = aggregator.clock() else { return Ok(()) };
        self.tasks.take(|tasks| {
            tally.tasks.add(tasks, clock.tick_secs);
            Ok(())
        })
    }
}

impl WorkTally {
    /// Returns the work that belongs to the newest frame; `None` if no manager publishes the column
    /// `activity`.
    pub fn work(&self, aggregator: &Aggregator) -> Option<Work> {
        let robots = *self.robots.as_ref()?.if_current(aggregator.newest()?)?;
        let tasks = self.tasks.figures(&aggregator.clock()?);
        Some(Work {
            robots,
            tasks,
            effort: self.effort.effort(),
            cycle: self.cycles.secs.summary(),
        })
    }
}

/// Returns the name of an activity as a part of the names of metrics and columns.
pub fn activity_key(activity: Activity) -> String {
    activity.name().replace(' ', "_")
}

/// Counts robots by activity. Values that are none are left out.
fn by_activity(values: &[f32]) -> ByActivity {
    let mut robots = ByActivity::default();
    for activity in values.iter().filter_map(|value| Activity::from_value(*value)) {
        robots[activity as usize] += 1;
    }
    robots
}

#[cfg(test)]
mod tests {
    use regatta_plugin::frame::{ClockState, FrameHeader, Line, frame_lines, stride_lines};
    use regatta_plugin::task::{TaskKind, TaskRecord};
    use regatta_plugin::{ColumnPublisher, FleetName, TaskPublisher};

    use super::*;

    const RUN: u64 = 7;
    const SECOND: u64 = 1_000_000_000;

    /// Adds a frame without robots.
    fn add_frame(aggregator: &mut Aggregator, run_id: u64, tick: u64, wall_time_nanos: u64) {
        let header = FrameHeader {
            run_id,
            tick,
            wall_time_nanos,
            tick_period_nanos: SECOND / 10,
            clock: ClockState::Running as u32,
            stride_lines: stride_lines(0) as u32,
            ..FrameHeader::default()
        };
        let lines = vec![Line::default(); frame_lines(0)];
        aggregator.add_frame(&Frame::new(&header, &lines).expect("a frame"), wall_time_nanos);
    }

    #[test]
    fn robots_are_counted_by_activity() {
        let values = [0.0, 2.0, 2.0, 7.0, f32::NAN, 8.0, -1.0, 0.5, f32::INFINITY];
        assert_eq!(by_activity(&values), [1, 0, 2, 0, 0, 0, 0, 1]);
        for activity in Activity::ALL {
            assert_eq!(by_activity(&[f32::from(activity as u8)])[activity as usize], 1);
        }
    }

    #[test]
    fn work_belongs_to_the_run_of_the_newest_frame() {
        let name: FleetName =
            format!("unit-metrics-work-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let mut column = ColumnPublisher::open_on(&participant, "activity").expect("a column");
        let mut log = TaskPublisher::open_on(&participant).expect("a log");
        let mut reader = WorkReader::open_on(&participant).expect("a reader");
        let (mut aggregator, mut tally) = (Aggregator::default(), WorkTally::default());
        add_frame(&mut aggregator, RUN, 40, SECOND);
        reader.update(&mut tally, &mut aggregator, SECOND);
        assert_eq!(tally.work(&aggregator), None, "no manager runs");

        column.set_cost(std::time::Duration::from_micros(2500));
        column
            .write(RUN, 40, 3, |chunk| chunk.copy_from_slice(&[2.0, 2.0, 0.0]))
            .expect("published");
        let record = |kind| [TaskRecord::new(5, kind)];
        log.publish(RUN, 10, 0, &record(TaskKind::Created)).expect("published");
        log.publish(RUN, 40, 0, &record(TaskKind::Finished)).expect("published");
        reader.update(&mut tally, &mut aggregator, SECOND);
        let work = tally.work(&aggregator).expect("a manager runs");
        assert_eq!(work.robots, [1, 0, 2, 0, 0, 0, 0, 0]);
        assert_eq!((work.tasks.created, work.tasks.finished, work.tasks.open), (1, 1, Some(0)));
        assert_eq!(work.tasks.service.mean(), Some(3.0));
        assert_eq!((work.cycle.count, work.cycle.longest), (1, 2.5e-3));

        add_frame(&mut aggregator, RUN, 60, 3 * SECOND);
        assert_eq!(tally.work(&aggregator), None, "the manager has died");
        add_frame(&mut aggregator, RUN + 1, 0, SECOND);
        assert_eq!(tally.work(&aggregator), None, "another run");
        aggregator.note_idle(false);
        assert_eq!(tally.work(&aggregator), None, "no engine");
    }
}
