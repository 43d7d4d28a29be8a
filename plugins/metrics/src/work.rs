//! The work of a fleet manager, if one runs and keeps up: the activities of its robots, their
//! effort, and its orders.

use regatta_plugin::activity::Activity;
use regatta_plugin::column::{ACTIVITY, ColumnHeader};
use regatta_plugin::frame::RobotState;
use regatta_plugin::work::WorkFigures;
use regatta_plugin::{
    ColumnReader, Frame, OrderReader, Participant, ReadError, Result, WorkReader as FigureReader,
};

use crate::aggregator::{Aggregator, RunClock};
use crate::durations::TimeRecorder;
use crate::fleet::Received;
use crate::orders::OrderTally;
use crate::snapshot::Work;

/// Numbers of robots by activity, in the order of [`Activity::ALL`].
type ByActivity = [u64; Activity::ALL.len()];

/// A reader of the column `activity`, the order log and the figures of a fleet.
#[derive(Debug)]
pub struct WorkReader {
    column: ColumnReader,
    orders: OrderReader,
    figures: FigureReader,
}

/// A manager's work, as far as it has been read.
#[derive(Debug, Default)]
pub struct WorkTally {
    robots: Option<Received<ByActivity>>,
    orders: OrderTally,
    /// The figures that the manager publishes, with their run.
    run: Option<(u64, WorkFigures)>,
    effort: EffortTally,
    cycles: Cycles,
}

/// The times that the manager of a run spent on frames.
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
        // Not every manager publishes its times.
        if header.cost_micros > 0 {
            self.secs.observe(f64::from(header.cost_micros) * 1e-6);
        }
    }
}

impl WorkReader {
    /// Opens them, whether or not a manager publishes them yet.
    ///
    /// # Errors
    /// Fails if the fleet uses another version of the contract, or has no room for another reader.
    pub fn open_on(participant: &Participant) -> Result<Self> {
        let orders = OrderReader::open_on(participant)?;
        let figures = FigureReader::open_on(participant)?;
        Ok(Self { column: ColumnReader::open_on(participant, ACTIVITY.name())?, orders, figures })
    }

    /// Adds the effort of robots since the frame before.
    pub fn add_frame(&mut self, tally: &mut WorkTally, frame: &Frame<'_>) {
        // Errors are counted by `read_robots`.
        let column = self.column.current().ok().flatten();
        let column = column.filter(|column| column.header.run_id == frame.run_id());
        tally.effort.add(frame, column.map_or(&[], |column| column.values));
    }

    /// Reads the column at the wall time `now`, in nanoseconds, if there is a new one.
    pub fn read_robots(&mut self, tally: &mut WorkTally, now: u64) -> Result<(), ReadError> {
        if let Some(column) = self.column.latest()? {
            tally.cycles.add(column.header);
            let robots = by_activity(column.values);
            tally.robots = Some(Received::new(column.header.run_id, now, robots));
        }
        Ok(())
    }

    /// Reads the figures of a run that the manager publishes.
    pub fn read_figures(
        &mut self,
        tally: &mut WorkTally,
        clock: Option<RunClock>,
    ) -> Result<(), ReadError> {
        self.figures.take()?;
        tally.run = clock.and_then(|clock| {
            let figures = self.figures.of_run(clock.run_id)?;
            Some((clock.run_id, *figures))
        });
        Ok(())
    }

    /// Reads the order log. Before the first frame, the length of a tick is unknown.
    pub fn read_orders(
        &mut self,
        tally: &mut WorkTally,
        clock: Option<RunClock>,
    ) -> Result<(), ReadError> {
        let Some(clock) = clock else { return Ok(()) };
        self.orders.take(|orders| {
            tally.orders.add(orders, clock.tick_secs);
            Ok(())
        })
    }
}

impl WorkTally {
    /// Returns the work that belongs to the newest frame; `None` if no manager publishes the column
    /// `activity`.
    pub fn work(&self, aggregator: &Aggregator) -> Option<Work> {
        let robots = *self.robots.as_ref()?.if_current(aggregator.newest()?)?;
        let clock = aggregator.clock()?;
        let run = self.run.filter(|(run_id, _)| *run_id == clock.run_id);
        Some(Work {
            robots,
            orders: self.orders.figures(&clock),
            run: run.map(|(_, figures)| figures),
            effort: self.effort.effort,
            cycle: self.cycles.secs.summary(),
        })
    }
}

/// Totals over all robots of a run, since a reader began to read its frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Seconds of simulated time that robots had an order.
    pub busy_secs: f64,
    /// Seconds of simulated time that robots were there.
    pub robot_secs: f64,
    /// Metres driven by robots that carry something.
    pub loaded_metres: f64,
    /// Metres driven by all others.
    pub empty_metres: f64,
}

impl Effort {
    /// The part of the robots' time in which they had an order, from 0 to 1; `None` without time.
    pub fn utilisation(&self) -> Option<f64> {
        (self.robot_secs > 0.0).then(|| self.busy_secs / self.robot_secs)
    }

    /// The part of the metres that were driven without a load, from 0 to 1; `None` without metres.
    pub fn empty_part(&self) -> Option<f64> {
        let metres = self.loaded_metres + self.empty_metres;
        (metres > 0.0).then(|| self.empty_metres / metres)
    }

    /// Adds the activities of some seconds, given the states and speeds of robots and the values of
    /// the column `activity`.
    fn add(&mut self, states: &[u8], speeds: &[f32], activities: &[f32], secs: f64) {
        for ((&state, &speed), &activity) in states.iter().zip(speeds).zip(activities) {
            let Some(activity) = Activity::from_value(activity) else { continue };
            if state == RobotState::Absent as u8 {
                continue;
            }
            self.robot_secs += secs;
            self.busy_secs += if activity.has_order() { secs } else { 0.0 };
            let metres = f64::from(speed.abs()) * secs;
            match activity {
                Activity::Carrying => self.loaded_metres += metres,
                _ => self.empty_metres += metres,
            }
        }
    }
}

/// A tally of [`Effort`], fed with frames.
#[derive(Clone, Copy, Debug, Default)]
struct EffortTally {
    /// The run and the simulated time in seconds of the last frame.
    last: Option<(u64, f64)>,
    effort: Effort,
}

impl EffortTally {
    /// Adds the time from the frame before to this one, in which robots are assumed to have had
    /// their present activity.
    fn add(&mut self, frame: &Frame<'_>, activities: &[f32]) {
        let (run_id, now_secs) = (frame.run_id(), frame.sim_time().as_secs_f64());
        match self.last.replace((run_id, now_secs)) {
            Some((run, before_secs)) if run == run_id && before_secs <= now_secs => {
                self.effort.add(frame.state(), frame.speed(), activities, now_secs - before_secs);
            }
            _ => self.effort = Effort::default(),
        }
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
    use regatta_plugin::order::{OrderKind, OrderRecord};
    use regatta_plugin::{ColumnPublisher, FleetName, OrderPublisher};

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
        assert_eq!(by_activity(&values)[..8], [1, 0, 2, 0, 0, 0, 0, 1]);
        for activity in Activity::ALL {
            assert_eq!(by_activity(&[f32::from(activity as u8)])[activity as usize], 1);
        }
    }

    #[test]
    fn work_belongs_to_the_run_of_the_newest_frame() {
        let name: FleetName =
            format!("unit-metrics-work-{}", std::process::id()).parse().expect("a name");
        let participant = Participant::join(&name, "test").expect("joined");
        let mut column = ColumnPublisher::open_on(&participant, ACTIVITY.name()).expect("a column");
        let mut log = OrderPublisher::open_on(&participant).expect("a log");
        let mut reader = WorkReader::open_on(&participant).expect("a reader");
        let (mut aggregator, mut tally) = (Aggregator::default(), WorkTally::default());
        add_frame(&mut aggregator, RUN, 40, SECOND);
        reader.read_robots(&mut tally, SECOND).expect("read");
        reader.read_orders(&mut tally, aggregator.clock()).expect("read");
        assert_eq!(tally.work(&aggregator), None, "no manager runs");

        column.set_cost(std::time::Duration::from_micros(2500));
        column
            .write(RUN, 40, 3, |chunk| chunk.copy_from_slice(&[2.0, 2.0, 0.0]))
            .expect("published");
        let record = |kind| [OrderRecord::new(5, kind)];
        log.publish(RUN, 10, 0, &record(OrderKind::Created)).expect("published");
        log.publish(RUN, 40, 0, &record(OrderKind::Finished)).expect("published");
        reader.read_robots(&mut tally, SECOND).expect("read");
        reader.read_orders(&mut tally, aggregator.clock()).expect("read");
        let work = tally.work(&aggregator).expect("a manager runs");
        assert_eq!(work.robots[..8], [1, 0, 2, 0, 0, 0, 0, 0]);
        assert_eq!((work.orders.created, work.orders.finished, work.orders.open), (1, 1, Some(0)));
        assert_eq!(work.orders.service.mean(), Some(3.0));
        assert_eq!((work.cycle.count, work.cycle.longest), (1, 2.5e-3));

        add_frame(&mut aggregator, RUN, 60, 3 * SECOND);
        assert_eq!(tally.work(&aggregator), None, "the manager has died");
        add_frame(&mut aggregator, RUN + 1, 0, SECOND);
        assert_eq!(tally.work(&aggregator), None, "another run");
        aggregator.note_idle(false);
        assert_eq!(tally.work(&aggregator), None, "no engine");
    }

    #[test]
    fn time_and_metres_add_up() {
        let (driving, absent) = (RobotState::Driving as u8, RobotState::Absent as u8);
        let activities = [Activity::Fetching, Activity::Carrying, Activity::Idle, Activity::Idle]
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
