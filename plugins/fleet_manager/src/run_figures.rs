//! Figures of a run: the cost of the manager's cycles, and the finished orders over time.

use std::time::Duration;

use regatta_base::grouped;
use regatta_plugin::activity::Activity;
use serde_json::{Map, Value, json};

use regatta_orders::{Change, OrderEvent};

/// The mean simulated time between frames, in seconds, from which on the manager is too slow for
/// the speed of the simulation: robots wait for it longer than for each other.
const LATE_SECS: f64 = 0.5;

/// The length of the periods whose finished stops are counted, in simulated seconds.
const PERIOD_SECS: f64 = 10.0;

/// The figures of a run so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct RunFigures {
    /// Robots in the last frame.
    pub(crate) robots: usize,
    /// The simulated time of the last frame, in seconds.
    pub(crate) now_secs: f64,
    /// The time that it took to compile the roads and to open the manager's ports and files.
    start: Duration,
    cycles: u64,
    /// The simulated time between the frames of the cycles, in seconds.
    between_secs: f64,
    spent: Duration,
    longest: Duration,
    /// The stops that were finished in each period.
    stops: Vec<u32>,
    /// The orders that were finished in each period.
    orders: Vec<u32>,
    effort: Effort,
    /// By robot, the time at which it finished an order, or else came; infinite if it has left.
    finished_secs: Vec<f64>,
    longest_without_finish_secs: f64,
}

impl RunFigures {
    /// Begins a run.
    pub(crate) fn begin(start: Duration) -> Self {
        Self { start, ..Self::default() }
    }

    /// Adds further time that was spent before the first cycle.
    pub(crate) fn add_start(&mut self, spent: Duration) {
        self.start += spent;
    }

    /// Notes the robots of a frame. `is_there` returns for each id whether the robot is there.
    pub(crate) fn see(&mut self, now_secs: f64, robots: usize, is_there: impl Fn(usize) -> bool) {
        (self.now_secs, self.robots) = (now_secs, robots);
        self.finished_secs.resize(robots, f64::INFINITY);
        for (robot, finished) in self.finished_secs.iter_mut().enumerate() {
            match is_there(robot) {
                true => *finished = finished.min(now_secs),
                false => *finished = f64::INFINITY,
            }
        }
    }

    /// Notes a change of an order.
    pub(crate) fn take(&mut self, event: &OrderEvent) {
        match event.change {
            Change::Handled { .. } => {
                count(&mut self.stops, event.secs);
            }
            Change::Finished { robot } => {
                count(&mut self.orders, event.secs);
                if let Some(finished) = self.finished_secs.get_mut(robot as usize) {
                    self.longest_without_finish_secs =
                        self.longest_without_finish_secs.max(event.secs - *finished);
                    *finished = event.secs;
                }
            }
            _ => {}
        }
    }

    /// Notes the activity of all robots for the time since the frame before.
    pub(crate) fn spend(&mut self, secs: f64, robots: impl Iterator<Item = Doing>) {
        // The activity before the first frame is unknown.
        if self.cycles > 0 {
            self.between_secs += secs;
            for doing in robots {
                self.effort.add(&doing, secs);
            }
        }
    }

    /// Notes the duration of a cycle.
    pub(crate) fn end_cycle(&mut self, spent: Duration) {
        self.cycles += 1;
        self.spent += spent;
        self.longest = self.longest.max(spent);
    }

    /// The mean of a cycle in milliseconds.
    pub(crate) fn mean_cycle_ms(&self) -> f64 {
        millis(self.spent) / self.cycles.max(1) as f64
    }

    /// The longest cycle in milliseconds.
    pub(crate) fn longest_cycle_ms(&self) -> f64 {
        millis(self.longest)
    }

    /// The longest time that a robot has been there without finishing an order, in seconds.
    fn longest_without_finish_secs(&self) -> f64 {
        let open = self.finished_secs.iter().map(|finished| self.now_secs - finished);
        open.fold(self.longest_without_finish_secs, f64::max)
    }

    /// The part of the robots' time that they spent on an activity, from 0 to 1.
    pub(crate) fn share(&self, activity: Activity) -> f64 {
        self.effort.share(activity)
    }

    /// The mean simulated time between the frames that the manager has seen, in seconds.
    fn mean_gap_secs(&self) -> f64 {
        self.between_secs / self.cycles.saturating_sub(1).max(1) as f64
    }

    /// The effort of robots, as lines for people, and whether the manager was too slow for the
    /// figures to be those of the plant.
    pub(crate) fn table(&self) -> String {
        let mut text = self.effort.table();
        let gap = self.mean_gap_secs();
        if gap > LATE_SECS {
            text += &format!(
                "too slow      the manager saw a frame every {gap:.1} simulated seconds: these are \
                 figures of a late manager, not of the plant; give a lower --speed, or --lockstep \
                 fleet-manager\n"
            );
        }
        text
    }

    /// The figures as JSON.
    pub(crate) fn json(&self) -> Value {
        json!({
            "robots": self.robots,
            "start_ms": millis(self.start),
            "cycles": self.cycles,
            "mean_gap_secs": self.mean_gap_secs(),
            "mean_cycle_ms": self.mean_cycle_ms(),
            "longest_cycle_ms": self.longest_cycle_ms(),
            "longest_without_finish_secs": self.longest_without_finish_secs(),
            "period_secs": PERIOD_SECS,
            "stops_by_period": self.stops,
            "orders_by_period": self.orders,
            "effort": self.effort.json(),
        })
    }
}

/// Counts something in the period of a simulated time in seconds.
fn count(periods: &mut Vec<u32>, secs: f64) {
    let period = (secs / PERIOD_SECS) as usize;
    periods.resize(periods.len().max(period + 1), 0);
    periods[period] += 1;
}

fn millis(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// The activity of a robot in a frame.
#[derive(Clone, Copy, Debug)]
pub struct Doing {
    /// Its activity.
    pub activity: Activity,
    /// Whether it has an order.
    pub has_order: bool,
    /// Whether it has picked something up, and not dropped the last of it.
    pub is_loaded: bool,
    /// Metres per second.
    pub speed: f32,
}

/// Time and metres of all robots so far.
#[derive(Clone, Debug, Default)]
pub struct Effort {
    /// Robot seconds by activity, in the order of [`Activity::ALL`].
    secs: [f64; Activity::ALL.len()],
    /// Robot seconds with an order.
    ordered_secs: f64,
    loaded_metres: f64,
    empty_metres: f64,
}

impl Effort {
    /// Adds some seconds of a robot's activity.
    pub fn add(&mut self, doing: &Doing, secs: f64) {
        self.secs[doing.activity as usize] += secs;
        self.ordered_secs += if doing.has_order { secs } else { 0.0 };
        let metres = f64::from(doing.speed.abs()) * secs;
        *(if doing.is_loaded { &mut self.loaded_metres } else { &mut self.empty_metres }) += metres;
    }

    fn robot_secs(&self) -> f64 {
        self.secs.iter().sum()
    }

    /// The part of the robots' time in which they had an order, from 0 to 1.
    pub fn utilisation(&self) -> f64 {
        ratio(self.ordered_secs, self.robot_secs())
    }

    /// The part of the robots' time that they spent on an activity, from 0 to 1.
    pub fn share(&self, activity: Activity) -> f64 {
        ratio(self.secs[activity as usize], self.robot_secs())
    }

    /// The figures as JSON.
    pub fn json(&self) -> Value {
        let secs = Activity::ALL.map(|activity| {
            (activity.name().replace(' ', "_"), json!(self.secs[activity as usize]))
        });
        json!({
            "robot_secs": Map::from_iter(secs),
            "utilisation": self.utilisation(),
            "loaded_metres": self.loaded_metres,
            "empty_metres": self.empty_metres,
        })
    }

    /// The figures as lines of a name and its values, for people.
    pub fn table(&self) -> String {
        let metres = self.loaded_metres + self.empty_metres;
        let shares = Activity::ALL.into_iter().filter(|activity| self.share(*activity) > 0.0);
        let shares: Vec<_> = shares
            .map(|activity| format!("{} {:.1} %", activity.name(), 100.0 * self.share(activity)))
            .collect();
        format!(
            "robots' time  {:.1} % with an order: {}\ndriven        {}, {:.1} % of it empty\n",
            100.0 * self.utilisation(),
            shares.join(", "),
            distance(metres),
            100.0 * ratio(self.empty_metres, metres),
        )
    }
}

/// Formats metres.
fn distance(metres: f64) -> String {
    match metres {
        short if short < 999.5 => format!("{short:.0} m"),
        long => format!("{} km", grouped(long / 1e3, 1)),
    }
}

fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use regatta_orders::OrderId;

    fn finished(secs: f64, robot: u32) -> OrderEvent {
        OrderEvent { secs, id: OrderId(1), change: Change::Finished { robot } }
    }

    #[test]
    fn the_robot_that_finishes_nothing_for_longest_counts() {
        let mut figures = RunFigures::begin(Duration::ZERO);
        figures.see(5.0, 2, |_| true);
        figures.take(&finished(45.0, 0));
        figures.see(60.0, 2, |_| true);
        assert_eq!(
            figures.longest_without_finish_secs(),
            55.0,
            "robot 1 has finished nothing since it came"
        );
        figures.see(90.0, 2, |robot| robot == 0);
        assert_eq!(figures.longest_without_finish_secs(), 45.0, "robot 1 has left");
        figures.take(&finished(95.0, 0));
        figures.see(96.0, 2, |_| true);
        assert_eq!(figures.longest_without_finish_secs(), 50.0);
    }

    #[test]
    fn stops_are_counted_by_period() {
        let mut figures = RunFigures::begin(Duration::ZERO);
        for secs in [0.0, 9.9, 10.0, 35.0] {
            figures.take(&OrderEvent {
                secs,
                id: OrderId(1),
                change: Change::Handled { robot: 0, stop: 0 },
            });
        }
        assert_eq!(figures.json()["stops_by_period"], json!([2, 1, 0, 1]));
    }

    #[test]
    fn a_manager_that_sees_few_frames_says_so() {
        for (gap, is_told) in [(0.1, false), (12.0, true)] {
            let mut figures = RunFigures::begin(Duration::ZERO);
            for _ in 0..5 {
                figures.spend(gap, std::iter::empty());
                figures.end_cycle(Duration::ZERO);
            }
            let text = figures.table();
            assert_eq!(text.contains("--lockstep fleet-manager"), is_told, "{gap} s: {text}");
            assert!(!is_told || text.contains("every 12.0 simulated seconds"), "{text}");
        }
    }

    #[test]
    fn time_and_metres_add_up() {
        let mut effort = Effort::default();
        let doing =
            |activity, has_order, is_loaded, speed| Doing { activity, has_order, is_loaded, speed };
        effort.add(&doing(Activity::Fetching, true, false, 2.0), 10.0);
        effort.add(&doing(Activity::Carrying, true, true, -1.0), 40.0);
        effort.add(&doing(Activity::Idle, false, false, 0.0), 50.0);
        assert_eq!((effort.utilisation(), effort.share(Activity::Carrying)), (0.5, 0.4));
        let json = effort.json();
        assert_eq!((&json["loaded_metres"], &json["empty_metres"]), (&json!(40.0), &json!(20.0)));
        assert_eq!(json["robot_secs"]["fetching"], 10.0);
        let text = effort.table();
        assert!(
            text.contains("50.0 % with an order") && text.contains(" 60 m, 33.3 % of it empty"),
            "{text}"
        );
        assert_eq!(Effort::default().utilisation(), 0.0);
    }
}
