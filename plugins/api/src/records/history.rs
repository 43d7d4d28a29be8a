//! The history of a run so far: figures of the fleet over time on `regatta/F/history`, and the
//! places where robots lose time on `regatta/F/spots`. Both are published whole, so that a reader
//! that joins late has all of it.

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::activity::Activity;
use super::frame::{Frame, NO_EDGE, RobotState};
use super::sequence::Sequenced;

/// The most edges of a [`HotSpot`].
pub const SPOT_EDGES: usize = 4;
/// The value of [`FleetSample::touching`] if no process checks for contacts.
const UNKNOWN: u32 = u32::MAX;

/// The iceoryx2 user header of `regatta/F/history`, with a payload of [`FleetSample`]s, and of
/// `regatta/F/spots`, with one of [`HotSpot`]s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_HistoryHeader"))]
pub struct HistoryHeader {
    /// The run.
    pub run_id: u64,
    /// The tick of the newest frame that is counted.
    pub tick: u64,
    /// Its simulated time, in nanoseconds.
    pub sim_time_nanos: u64,
    /// The simulated time of the first frame that is counted, in nanoseconds; the time before isn't
    /// known.
    pub began_nanos: u64,
    /// Counts the samples of the run, from 1. The publisher fills it in.
    pub sequence: u64,
}

/// The figures of a fleet at a time.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_FleetSample"))]
pub struct FleetSample {
    /// Simulated seconds.
    pub secs: f64,
    /// Robots by activity, in the order of [`Activity::ALL`].
    pub activities: [u32; Activity::COUNT],
    /// Pairs of robots that touch; [`touching`](Self::touching()) reads it.
    pub touching: u32,
    /// Robots that enter an edge, per hour, over the last minute; NaN if it isn't known.
    pub throughput: f32,
    /// The mean speed of all robots, in metres per second.
    pub mean_speed: f32,
}

impl FleetSample {
    /// Takes the figures of a frame: the activities and the speeds of its robots. `published` are
    /// the values of the column [`ACTIVITY`](super::column::ACTIVITY); it is empty where no fleet
    /// manager publishes it, and robots beyond its end are counted by their states.
    pub fn of(frame: &Frame<'_>, published: &[f32]) -> Self {
        let with_column = published.len().min(frame.len());
        let mut activities = [0; Activity::COUNT];
        for (state, value) in frame.state().iter().zip(published) {
            let state = RobotState::from_number(*state);
            if let Some(activity) = Activity::of(state, Activity::from_value(*value)) {
                activities[activity as usize] += 1;
            }
        }
        for state in (0..RobotState::COUNT as u8).map(RobotState::from_number) {
            if let Some(activity) = Activity::of_state(state) {
                activities[activity as usize] += count(&frame.state()[with_column..], state as u8);
            }
        }
        let robots: u32 = activities.iter().sum();
        let mean_speed = (speed_sum(frame) / f64::from(robots.max(1))) as f32;
        Self { secs: frame.sim_time().as_secs_f64(), activities, mean_speed, ..Self::default() }
    }

    /// The number of robots of an activity.
    pub fn count(&self, activity: Activity) -> u32 {
        self.activities[activity as usize]
    }

    /// The number of all robots.
    pub fn robots(&self) -> u32 {
        self.activities.iter().sum()
    }

    /// Adds the pairs that touch; `None` if no process checks.
    #[must_use]
    pub fn with_touching(self, pairs: Option<u32>) -> Self {
        Self { touching: pairs.unwrap_or(UNKNOWN), ..self }
    }

    /// Pairs of robots that touch; `None` if no process checks.
    pub fn touching(&self) -> Option<u32> {
        (self.touching != UNKNOWN).then_some(self.touching)
    }

    /// Robots that enter an edge, per hour, over the last minute; `None` if it isn't known.
    pub fn throughput(&self) -> Option<f32> {
        (!self.throughput.is_nan()).then_some(self.throughput)
    }
}

/// Adds up the speeds of all robots, in metres per second.
fn speed_sum(frame: &Frame<'_>) -> f64 {
    let mut sum = 0.0;
    for (state, speed) in frame.state().iter().zip(frame.speed()) {
        // A row without a robot has a state beyond the list. A branch would cost more.
        let is_robot = usize::from(*state) < RobotState::COUNT;
        sum += if is_robot { f64::from(speed.abs()) } else { 0.0 };
    }
    sum
}

/// Counts the robots in a state, in blocks whose counts fit into a byte: so the compiler compares
/// many at once.
fn count(states: &[u8], state: u8) -> u32 {
    let blocks = states.chunks(u8::MAX.into());
    let in_block = |block: &[u8]| block.iter().fold(0, |sum, of| sum + u8::from(*of == state));
    blocks.map(|block| u32::from(in_block(block))).sum()
}

impl Default for FleetSample {
    fn default() -> Self {
        Self {
            secs: 0.0,
            activities: [0; Activity::COUNT],
            touching: UNKNOWN,
            throughput: f32::NAN,
            mean_speed: 0.0,
        }
    }
}

numbered! {
    /// The development of a [`HotSpot`].
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Trend: u32 {
        /// It costs more time than it used to.
        Growing = 1,
        /// It costs about as much as before.
        Steady = 2,
        /// It costs less.
        Easing = 3,
        /// No robot loses time there any more.
        Over = 4,
    }
}

impl Trend {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Growing => "growing",
            Self::Steady => "steady",
            Self::Easing => "easing",
            Self::Over => "over",
        }
    }
}

/// A place where robots lose time.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_HotSpot"))]
pub struct HotSpot {
    /// The time that robots have touched others there, added up over robots, in simulated seconds.
    pub contact_secs: f64,
    /// The time that other robots have stood there and couldn't drive on.
    pub standing_secs: f64,
    /// The simulated times of the first and of the last loss, in seconds.
    pub seen: [f64; 2],
    /// The middle of the losses, in metres east.
    pub x: f32,
    /// The middle of the losses, in metres north.
    pub y: f32,
    /// The edges with the most losses, by their indices in the world; [`NO_EDGE`] where there are
    /// fewer.
    pub edges: [u32; SPOT_EDGES],
    /// A [`Trend`]; [`trend`](Self::trend()) reads it.
    pub trend: u32,
    /// Zero.
    pub reserved: u32,
}

impl Default for HotSpot {
    fn default() -> Self {
        Self { edges: [NO_EDGE; SPOT_EDGES], trend: Trend::Steady as u32, ..Self::zeroed() }
    }
}

impl HotSpot {
    /// All time that was lost, in robot seconds.
    pub fn lost_secs(&self) -> f64 {
        self.contact_secs + self.standing_secs
    }

    /// The edges with the most losses, by their indices in the world.
    pub fn edges(&self) -> impl Iterator<Item = u32> {
        self.edges.into_iter().filter(|edge| *edge != NO_EDGE)
    }

    /// Its development. A number that this version doesn't know is [`Steady`](Trend::Steady).
    pub fn trend(&self) -> Trend {
        Trend::from_number(self.trend).unwrap_or(Trend::Steady)
    }
}

super::sequence::sequenced!(HistoryHeader: sequence);
