//! The input of the interface, a [`ViewModel`], and its output, [`Action`]s. Both are independent
//! of windows and graphics cards.

use std::time::Duration;

use glam::Vec2;
use regatta_plugin::activity::Activity;
use regatta_plugin::control::{ControlRequest, ControlResponse};
use regatta_plugin::frame::{ClockState, Frame};
use regatta_plugin::recording::RecordingMark;
use regatta_plugin::work::WorkFigures;
use regatta_plugin::{ColumnName, Contacts, World};
pub use regatta_scene::Item;
use regatta_scene::camera::Bounds;
use regatta_scene::palette::Legend;
use regatta_scene::plans::PlanFacts;
use regatta_scene::route::Remaining;

use super::labels::Labels;
use super::performance::Timing;
use super::pose::Pose;
use super::rows::{RowQuery, Rows};
use crate::commands::UserCommand;
use crate::jams::JamFacts;
use crate::orders::{NamedOrder, RobotOrder};
use crate::robot_filter::{Filter, Matches, activity_of};

/// The state of the engine, as seen by the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EngineState {
    /// There has been no engine since the viewer was started.
    Awaited,
    /// It drives the warm-up of a run, so much simulated time so far. The run begins at its end.
    WarmingUp(Duration),
    /// It publishes frames.
    Running,
    /// Its clock is paused.
    Paused,
    /// It is not paused, but publishes no frames.
    Silent,
    /// It has stopped or was killed.
    Gone,
}

/// The numbers of frames read and missed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames read.
    pub read: u64,
    /// Frames that were published but not read.
    pub skipped: u64,
}

/// The UDP programs that are running.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RunningUdp {
    /// Whether the UDP source receives robots.
    pub receives: bool,
    /// Whether the UDP sender sends the fleet.
    pub sends: bool,
}

/// Everything that the interface shows in one picture.
#[derive(Clone, Debug)]
pub struct ViewModel<'a> {
    /// The name of the fleet.
    pub fleet: &'a str,
    /// The state of its engine.
    pub engine: EngineState,
    /// The last status that the engine reported.
    pub status: Option<&'a ControlResponse>,
    /// The newest frame.
    pub frame: Option<Frame<'a>>,
    /// The route graph and the robot types; empty as long as there is no world.
    pub world: World<'a>,
    /// The labels of nodes and edges.
    pub labels: &'a Labels,
    /// Each robot's index into the robot types.
    pub robot_type_column: Option<&'a [f32]>,
    /// The activity of each robot of the frame, if a fleet manager publishes it.
    pub activity_column: Option<&'a [f32]>,
    /// The pairs that a collision checker reports.
    pub contacts: Option<Contacts<'a>>,
    /// The legend of the robots' colours.
    pub legend: &'a Legend,
    /// The columns that plugins publish.
    pub columns: &'a [ColumnName],
    /// The values of those columns for the selected robot.
    pub values: &'a [(ColumnName, f32)],
    /// The selected robot's order, if the order log has named it.
    pub order: Option<RobotOrder>,
    /// The order of the selected robot, as its manager names it.
    pub named_order: Option<&'a NamedOrder>,
    /// The figures of the fleet's work with their run, if a fleet manager publishes them.
    pub work: Option<(u64, WorkFigures)>,
    /// The rest of the selected robot's route, if it is known.
    pub route: Option<Remaining>,
    /// The known part of the plans of all robots.
    pub plans: PlanFacts,
    /// The indices of closed edges, sorted.
    pub closed: &'a [u32],
    /// The density of half the strength in robots per hectare, if robots are drawn as their
    /// density.
    pub density: Option<f32>,
    /// The facts about jams.
    pub jams: &'a JamFacts,
    /// The answer to the last [`Action::Rows`].
    pub rows: Option<&'a Rows>,
    /// The robots that match the filter; `None` until they are known.
    pub matches: Option<&'a Matches>,
    /// The bounds of everything to be seen.
    pub bounds: Bounds,
    /// The pose of the followed robot, as drawn.
    pub followed: Option<Pose>,
    /// The durations of the last pictures.
    pub timing: &'a Timing,
    /// The numbers of frames read and skipped.
    pub counts: Counts,
    /// Age of the newest frame when it was read, in seconds.
    pub lag: Option<f64>,
    /// Points of each trail that fit the graphics adapter, of those requested.
    pub trail_points: u32,
    /// The UDP programs that are running.
    pub udp: RunningUdp,
    /// The recording that is replayed, or the kept part of a live run.
    pub timeline: Option<Timeline<'a>>,
}

/// A recording that is replayed. Times are nanoseconds on its clock.
#[derive(Clone, Copy, Debug)]
pub struct Timeline<'a> {
    /// The name of the file.
    pub name: &'a str,
    /// The last note at or before the shown frame; empty for none.
    pub note: &'a str,
    /// The first time.
    pub start: u64,
    /// The last time.
    pub end: u64,
    /// The time of the shown frame, if it is known.
    pub now: Option<u64>,
    /// Marks up to this time are known.
    pub searched: u64,
    /// Marks that there was no room for.
    pub left_out: u64,
    /// The marks, sorted by time.
    pub marks: &'a [RecordingMark],
    /// The kept part of a live run.
    pub live: Option<Live>,
}

/// The kept part of a live run.
#[derive(Clone, Copy, Debug)]
pub struct Live {
    /// The memory that it takes, in bytes.
    pub bytes: usize,
    /// Whether the past is shown, and not the newest frame.
    pub is_past: bool,
}

impl Live {
    /// The memory for frames, in bytes.
    pub const BUDGET: usize = 256 << 20;
}

/// A request of the user that is carried out outside of the interface.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Look for the robot with the order of this name.
    FindOrder(String),
    /// Send a request to the engine.
    Control(ControlRequest),
    /// Select the item at a point of the picture.
    Pick {
        /// Points from the top left corner of the picture.
        at: Vec2,
        /// Whether to add to the selection instead of replacing it.
        extend: bool,
    },
    /// Open the menu of the item at a point of the picture.
    Menu {
        /// Points from the top left corner of the picture.
        at: Vec2,
        /// Points from the top left corner of the window.
        window: Vec2,
    },
    /// Send a command to the fleet.
    Command(UserCommand),
    /// Show a live run as it was at a simulated time in nanoseconds, or again as it is.
    LookBack(Option<u64>),
    /// Write a note of the recording.
    Note {
        /// Nanoseconds on the recording's clock.
        time: u64,
        /// Its text.
        text: String,
    },
    /// Take the robot or the place at a point of the picture as an end of the measurement.
    Measure {
        /// Points from the top left corner of the picture.
        at: Vec2,
    },
    /// Write a plan as SVG into the current folder.
    WriteSvg,
    /// Ask for a file, and open it.
    Open,
    /// Write a picture of the window as PNG into the current folder.
    WritePicture,
    /// Compute rows of the fleet list.
    Rows(RowQuery),
    /// Dim robots that don't match.
    Filter(Filter),
    /// Start a program that receives robots by UDP and can answer.
    StartUdpSource {
        /// Host and port to receive at.
        listen: String,
        /// Host and port to answer to.
        echo_to: Option<String>,
        /// Metres to add to the positions that it answers.
        offset: Vec2,
    },
    /// Start a program that sends the fleet by UDP.
    StartUdpSender {
        /// Host and port to send to.
        to: String,
    },
    /// Stop the UDP source.
    StopUdpSource,
    /// Stop the UDP sender.
    StopUdpSender,
    /// Write a file.
    Write {
        /// Its path.
        path: std::path::PathBuf,
        /// Its contents.
        text: String,
    },
    /// Switch full screen on or off.
    FullScreen,
    /// Close the window.
    Quit,
}

impl ViewModel<'_> {
    /// Whether the engine's clock is paused.
    pub fn is_paused(&self) -> bool {
        // A frame of the past doesn't know it.
        let shown = self.frame.filter(|_| !self.is_past()).map(|frame| frame.header().clock);
        let clock = shown.or(self.status.map(|status| status.clock));
        clock == Some(ClockState::Paused as u32)
    }

    /// The shown source: the file of a recording, or the fleet.
    pub fn name(&self) -> &str {
        self.recording().map_or(self.fleet, |recording| recording.name)
    }

    /// The recording that is replayed; `None` for a live fleet.
    pub fn recording(&self) -> Option<Timeline<'_>> {
        self.timeline.filter(|timeline| timeline.live.is_none())
    }

    /// The time of the shown frame in seconds, on the clock of its recording, or else in simulated
    /// time.
    pub fn clock_secs(&self) -> Option<f64> {
        let recorded = self.recording().and_then(|recording| recording.now);
        let nanos = recorded.or_else(|| Some(self.frame?.header().sim_time_nanos))?;
        Some(nanos as f64 * 1e-9)
    }

    /// Whether the past of a live run is shown.
    pub fn is_past(&self) -> bool {
        self.timeline.and_then(|timeline| timeline.live).is_some_and(|live| live.is_past)
    }

    /// The figures of the work of the shown run. The past of a live run has none.
    pub fn work(&self) -> Option<WorkFigures> {
        let run_id = self.frame.filter(|_| !self.is_past())?.run_id();
        self.work.filter(|(of_run, _)| *of_run == run_id).map(|(_, figures)| figures)
    }

    /// Returns the selected robot's value in a column, if it is published.
    pub fn value(&self, column: &str) -> Option<f32> {
        self.values.iter().find(|(name, _)| name.as_str() == column).map(|(_, value)| *value)
    }

    /// Returns the activity of a robot of the frame; `None` if it is absent.
    pub fn activity(&self, robot: u32) -> Option<Activity> {
        let (frame, row) = (self.frame?, robot as usize);
        let activities = self.activity_column.unwrap_or_default();
        (row < frame.len()).then(|| activity_of(frame.state_of(row), activities, robot))?
    }

    /// Returns the pose of a robot in the newest frame, moved by the offset.
    pub fn pose(&self, robot: u32, offset: Vec2) -> Option<Pose> {
        let (frame, row) = (self.frame?, robot as usize);
        let place = Vec2::new(*frame.x().get(row)?, *frame.y().get(row)?) + offset;
        Some(Pose { place, theta: *frame.theta().get(row)? })
    }
}
