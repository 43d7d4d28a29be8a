//! Draws one robot's track in a recording: its path on the map, and its pose, speed and activity
//! over time.

mod axis;
mod charts;
mod map;
mod svg;

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use glam::DVec2;
use regatta_plugin::activity::Activity;
use regatta_plugin::column::ACTIVITY;
use regatta_plugin::frame::RobotState;
use regatta_plugin::world::CurveRecord;

use crate::arguments::path_parser;
use crate::output::Draft;
use crate::progress::{Interrupted, Progress};
use crate::reading::{ReadingError, Recording};
use crate::recorded::Row;
use crate::table::{Span, for_each_snapshot};
pub use svg::png;
use svg::{Area, begin};

/// Options of `regatta plot`.
#[derive(Args, Clone, Debug)]
pub struct PlotArgs {
    /// Recording
    file: PathBuf,
    /// Id of the robot
    #[arg(long, value_name = "ID")]
    robot: u32,
    /// Picture to write: a .png or .svg file
    #[arg(short, long, value_name = "FILE", value_parser = path_parser())]
    output: PathBuf,
    /// Replace files that exist
    #[arg(long)]
    force: bool,
    /// Start at this time of the recording, for example 12.5s or 3min
    #[arg(long, value_name = "TIME")]
    from: Option<humantime::Duration>,
    /// End at this time of the recording
    #[arg(long, value_name = "TIME")]
    to: Option<humantime::Duration>,
}

/// The error of drawing a robot.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The recording can't be read.
    #[error(transparent)]
    Reading(#[from] ReadingError),
    /// The robot isn't in the recording in the requested time range.
    #[error(
        "robot {robot} is not in {path} between {from:.2} s and {to:.2} s; its robots have ids \
         from 0 to {last}"
    )]
    NoRobot {
        /// The robot's id.
        robot: u32,
        /// The recording.
        path: PathBuf,
        /// The start of the time range, in seconds.
        from: f64,
        /// The end of the time range, in seconds.
        to: f64,
        /// The highest recorded id.
        last: usize,
    },
    /// The picture's format is unknown.
    #[error("can't draw {path}; give a file name that ends with .png or .svg")]
    Format {
        /// The file.
        path: PathBuf,
    },
    /// The process was asked to end.
    #[error("the plot was interrupted")]
    Interrupted,
    /// The time range ends before it starts.
    #[error("--from {from} is after --to {to}; give an earlier --from, or a later --to")]
    Times {
        /// The requested start.
        from: humantime::Duration,
        /// The requested end.
        to: humantime::Duration,
    },
    /// The picture can't be written.
    #[error("can't write {path} ({reason})")]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: io::Error,
    },
}

impl From<Interrupted> for PlotError {
    fn from(_: Interrupted) -> Self {
        Self::Interrupted
    }
}

/// A robot in one frame.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// The time on the recording's clock, in seconds.
    time: f64,
    /// The position in metres.
    position: DVec2,
    /// The heading in radians.
    theta: f64,
    /// The speed in metres per second.
    speed: f64,
    /// By its state, and by the fleet manager's column if that is recorded.
    activity: Option<Activity>,
}

/// A robot's track. A new segment starts with each run, and when the robot is present again after
/// an absence.
struct Track {
    segments: Vec<Vec<Sample>>,
    /// The curves of the route graph's edges.
    curves: Vec<CurveRecord>,
}

impl Track {
    fn samples(&self) -> impl DoubleEndedIterator<Item = &Sample> {
        self.segments.iter().flatten()
    }

    /// Returns the times of the first and the last sample, in seconds.
    fn span(&self) -> (f64, f64) {
        let (first, last) = (self.samples().next(), self.samples().next_back());
        (first.map_or(0.0, |sample| sample.time), last.map_or(0.0, |sample| sample.time))
    }

    /// Returns the driven distance in metres.
    fn length(&self) -> f64 {
        let pairs = self.segments.iter().flat_map(|segment| segment.windows(2));
        pairs.map(|pair| pair[0].position.distance(pair[1].position)).sum()
    }
}

/// Draws a robot's track. Returns one line that describes the written file.
///
/// # Errors
/// Returns a [`PlotError`] if the recording can't be read, the picture can't be written, the time
/// range is invalid, or the robot isn't in the recording in that range.
pub fn plot(args: &PlotArgs) -> Result<String, PlotError> {
    if let (Some(from), Some(to)) = (args.from, args.to)
        && from > to
    {
        return Err(PlotError::Times { from, to });
    }
    let extension = args.output.extension().unwrap_or_default().to_ascii_lowercase();
    let is_png = extension == "png";
    if !is_png && extension != "svg" {
        return Err(PlotError::Format { path: args.output.clone() });
    }
    let recording = Recording::open_frames(&args.file)?;
    let (draft, mut file) = Draft::create(&args.output, args.force)
        .map_err(|reason| unwritable(&args.output, reason))?;
    let track = track(&recording, args)?;
    let name = args.file.file_name().unwrap_or_default().to_string_lossy();
    let svg = picture(&track, &format!("Robot {}", args.robot), &name);
    let bytes = if is_png {
        png(&svg).map_err(|reason| unwritable(&args.output, io::Error::other(reason)))?
    } else {
        svg.into_bytes()
    };
    let written = file.write_all(&bytes).and_then(|()| draft.commit());
    written.map_err(|reason| unwritable(&args.output, reason))?;
    let samples = track.samples().count();
    Ok(format!("{}: {samples} frames of robot {}", args.output.display(), args.robot))
}

fn unwritable(path: &Path, reason: io::Error) -> PlotError {
    PlotError::Write { path: path.to_owned(), reason }
}

fn track(recording: &Recording, args: &PlotArgs) -> Result<Track, PlotError> {
    let span = Span::of(recording, args.from, args.to);
    let mut progress = Progress::start("plot");
    let mut track = Track { segments: Vec::new(), curves: Vec::new() };
    let (mut run, mut was_present, mut most_robots) = (None, false, 0);
    let names = recording.topics().into_iter().filter_map(|topic| topic.column().cloned());
    let columns: Vec<_> = names.filter(|name| name.as_str() == ACTIVITY.name()).collect();
    for_each_snapshot(recording, &columns, &span, |snapshot| -> Result<(), PlotError> {
        progress.report(span.done(snapshot.time))?;
        most_robots = most_robots.max(snapshot.len());
        let row = snapshot.row(args.robot as usize);
        let changed_run = run.replace(snapshot.run) != Some(snapshot.run);
        if changed_run {
            track.curves = snapshot.curves().to_vec();
        }
        let starts_segment = row.is_some() && (changed_run || !was_present);
        was_present = row.is_some();
        if starts_segment {
            track.segments.push(Vec::new());
        }
        if let (Some(row), Some(segment)) = (row, track.segments.last_mut()) {
            let published = snapshot.column(0, args.robot as usize);
            segment.push(sample(snapshot.time, &row, published.and_then(Activity::from_value)));
        }
        Ok(())
    })?;
    if track.segments.is_empty() {
        return Err(PlotError::NoRobot {
            robot: args.robot,
            path: args.file.clone(),
            from: span.from as f64 * 1e-9,
            to: span.to as f64 * 1e-9,
            last: most_robots.saturating_sub(1),
        });
    }
    Ok(track)
}

fn sample(time: Duration, row: &Row, published: Option<Activity>) -> Sample {
    Sample {
        time: time.as_secs_f64(),
        position: DVec2::new(row.x.into(), row.y.into()),
        theta: row.theta.into(),
        speed: row.speed.into(),
        activity: Activity::of(RobotState::from_number(row.state), published),
    }
}

/// The picture's width and height in pixels.
const SIZE: DVec2 = DVec2::new(1280.0, 800.0);
const MARGIN: f64 = 40.0;
/// The upper edge of the plots, below the title.
const TOP: f64 = 122.0;

fn picture(track: &Track, title: &str, recording: &str) -> String {
    let mut svg = begin(SIZE);
    let (start, end) = track.span();
    let (metres, seconds) = (track.length(), end - start);
    svg.text(DVec2::new(MARGIN, 52.0)).class("title").content(title);
    let mean = if seconds > 0.0 { metres / seconds } else { 0.0 };
    let about = format!(
        "{recording} · {start:.2} s to {end:.2} s · {metres:.1} m driven · \
         {mean:.2} m/s on average"
    );
    svg.text(DVec2::new(MARGIN, 76.0)).class("about").content(&about);
    let middle = SIZE.x * 0.53;
    let bottom = SIZE.y - MARGIN - 24.0;
    let map = Area { left: MARGIN + 44.0, top: TOP, right: middle - 26.0, bottom };
    let charts = Area { left: middle + 56.0, top: TOP, right: SIZE.x - MARGIN, bottom };
    map::draw(&mut svg, map, track);
    charts::draw(&mut svg, charts, track);
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(from: f64, theta: impl Fn(f64) -> f64) -> Vec<Sample> {
        let sample = |i: u32| {
            let time = from + f64::from(i) * 0.1;
            Sample {
                time,
                position: DVec2::new(time, (time / 3.0).sin()),
                theta: theta(time),
                speed: 1.0,
                activity: Some(Activity::Moving),
            }
        };
        (0..100).map(sample).collect()
    }

    fn count(svg: &str, class: &str) -> usize {
        svg.matches(&format!("class=\"{class}\"")).count()
    }

    #[test]
    fn each_segment_is_a_line_and_a_heading_is_unwrapped() {
        let turning = |time: f64| {
            (time + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
        };
        let track = Track {
            segments: vec![segment(0.0, turning), segment(20.0, |_| 0.5)],
            curves: Vec::new(),
        };
        let svg = picture(&track, "Robot 1", "run.mcap");
        assert_eq!(count(&svg, "path"), 2);
        // Four values in two segments. The heading wraps around at π and 3π, but is drawn as one
        // line.
        assert_eq!(count(&svg, "line"), 4 * 2);
        // It turns by 9.9 rad.
        assert!(svg.contains(">540<") && !svg.contains(">−180<"), "{svg}");
    }

    #[test]
    fn a_robot_that_never_moves_is_drawn() {
        let still =
            Sample { time: 5.0, position: DVec2::ONE, theta: 0.0, speed: 0.0, activity: None };
        let svg = picture(
            &Track { segments: vec![vec![still]], curves: Vec::new() },
            "Robot 1",
            "run.mcap",
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
