//! Films in simulated time: every picture of a recording lies the same step of simulated time after
//! the one before, however long this machine takes for it. The replay stands, and is asked for one
//! frame after the other.

use std::path::Path;
use std::time::{Duration, Instant};

use regatta_interface::text::with_plural;
use regatta_plugin::control::ControlResponse;
use regatta_plugin::{Control, ControlError, Error, Result};
use regatta_scene::TRAIL_INTERVAL;

use super::HeadlessViewer;
use crate::video::VideoWriter;
use crate::worker::Reader;

/// The time between two notes of the progress.
const TELL_EVERY: Duration = Duration::from_secs(5);

/// The times of a film's pictures, on the recording's clock, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Schedule {
    from: u64,
    to: u64,
    /// Simulated time between two pictures.
    step: f64,
}

impl Schedule {
    /// The number of pictures: both ends are shown if the time between them is a multiple of the
    /// step.
    fn pictures(self) -> u32 {
        // Rounding must not cost the last picture.
        ((self.to.saturating_sub(self.from) as f64 / self.step + 1e-6).floor() + 1.0) as u32
    }

    /// The time of a picture. It is computed from its number, so that rounding doesn't add up.
    fn time(self, picture: u32) -> u64 {
        self.from + (f64::from(picture) * self.step).round() as u64
    }
}

/// The two recorded frames between which the shown moment lies.
#[derive(Clone, Copy, Debug)]
struct Around {
    before: ControlResponse,
    after: ControlResponse,
    /// Fewest ticks between two recorded frames so far.
    gap: u64,
    is_at_end: bool,
}

impl Around {
    /// The moment to show, from the frame before (0) to the one after (1).
    fn alpha(&self, time: u64) -> f32 {
        let (from, to) = (self.before.sim_time_nanos, self.after.sim_time_nanos);
        if self.before.run_id != self.after.run_id || to <= from {
            return 1.0;
        }
        (time.saturating_sub(from) as f64 / (to - from) as f64).clamp(0.0, 1.0) as f32
    }
}

impl HeadlessViewer<'_> {
    /// Films the recording from the time at which its replay stands.
    pub(super) fn film(&mut self, path: &Path) -> Result {
        let mut video = VideoWriter::create(path, self.options.fps, self.size())?;
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        let watch = self.stage.plan_query();
        let mut plans =
            (watch.plans || watch.waits).then(|| Reader::open(&self.options.fleet)).transpose()?;
        let mut jams =
            self.options.counts_traffic().then(|| Reader::open(&self.options.fleet)).transpose()?;
        let (mut control, mut around) = self.stand()?;
        // The description of the recording may have come after its first frame.
        self.stage.update(Instant::now())?;
        self.wait_for_columns()?;
        self.check_options()?;
        let schedule = self.schedule(&around.after)?;
        self.draw_trails_out(&mut control, &mut around, schedule.from)?;
        let (mut told, total) = (Instant::now(), schedule.pictures());
        while video.pictures() < total && !self.termination.requested() {
            let time = schedule.time(video.pictures());
            self.go_on(&mut control, &mut around, time)?;
            if let Some(plans) = &mut plans {
                let found = plans.read(&self.stage.plan_query())?;
                self.stage.set_plans(found);
            }
            if let Some(jams) = &mut jams {
                self.stage.set_jams(jams.read(&self.stage.jam_query())?);
            }
            self.clock = Some(time as f64 * 1e-9);
            let picture = self.render(around.alpha(time))?;
            video.add(&picture)?;
            if told.elapsed() > TELL_EVERY {
                told = Instant::now();
                regatta_plugin::tell!(
                    "viewer: {} of {}",
                    video.pictures(),
                    with_plural(total.into(), "picture")
                );
            }
        }
        let pictures = video.finish()?;
        let count = with_plural(pictures.into(), "picture");
        regatta_plugin::tell!(
            "viewer: {}: {count}, each {:.4} s of simulated time",
            path.display(),
            schedule.step * 1e-9
        );
        Ok(())
    }

    /// Plays a recording up to the time of the picture, so that trails grow, and the traffic on edges
    /// is counted for a heat map. Returns the moment to show between the two newest frames.
    pub(super) fn play_to_picture(&mut self) -> Result<f32> {
        let mut jams =
            self.options.counts_traffic().then(|| Reader::open(&self.options.fleet)).transpose()?;
        let (mut control, mut around) = self.stand()?;
        let time = self.options.at.map_or(around.after.sim_time_nanos, nanos);
        self.draw_trails_out(&mut control, &mut around, time)?;
        self.go_on(&mut control, &mut around, time)?;
        if let Some(jams) = &mut jams {
            self.stage.set_jams(jams.read(&self.stage.jam_query())?);
        }
        self.clock = Some(time as f64 * 1e-9);
        Ok(around.alpha(time))
    }

    /// Plays a recording up to a time, and adds a point to all trails at each of their intervals.
    fn draw_trails_out(&mut self, control: &mut Control, around: &mut Around, time: u64) -> Result {
        if self.stage.scene.trails.points == 0 {
            return Ok(());
        }
        let interval = TRAIL_INTERVAL.as_nanos() as u64;
        while around.after.sim_time_nanos + interval < time
            && !around.is_at_end
            && !self.termination.requested()
        {
            self.stage.collect_trails();
            self.go_on(control, around, around.after.sim_time_nanos + interval)?;
        }
        self.stage.collect_trails();
        Ok(())
    }

    /// Opens the controls of the replay, which stands.
    fn stand(&self) -> Result<(Control, Around)> {
        let mut control = Control::open_on(&self.participant)?;
        // The second answer comes after the replay has connected all readers of this program and
        // sent them the current data.
        control.status()?;
        control.speed(f32::INFINITY)?;
        let now = control.status()?;
        Ok((control, Around { before: now, after: now, gap: u64::MAX, is_at_end: false }))
    }

    fn schedule(&self, now: &ControlResponse) -> Result<Schedule> {
        let Some(recording) = self.stage.feed.recording() else {
            return Err(Error::new("only recordings can be filmed in simulated time"));
        };
        let to = self
            .options
            .to
            .map_or(recording.header.end_nanos, nanos)
            .min(recording.header.end_nanos);
        let from = self.options.from.map_or(now.sim_time_nanos, nanos);
        let step = f64::from(self.options.speed) * 1e9 / f64::from(self.options.fps);
        Ok(Schedule { from, to, step })
    }

    /// Asks for recorded frames until one is at or after a time, and reads the last two of them.
    fn go_on(&mut self, control: &mut Control, around: &mut Around, time: u64) -> Result {
        while around.after.sim_time_nanos < time
            && !around.is_at_end
            && !self.termination.requested()
        {
            match control.step(self.ticks_ahead(around, time)) {
                Ok(now) => {
                    let ticks = now.tick.saturating_sub(around.after.tick);
                    if now.run_id == around.after.run_id && ticks > 0 {
                        around.gap = around.gap.min(ticks);
                    }
                    (around.before, around.after) = (around.after, now);
                    // The answer comes after the frame, and after all that belongs to it.
                    let news = self.stage.update(Instant::now())?;
                    self.update_labels(news);
                }
                Err(ControlError::Refused { .. }) => around.is_at_end = true,
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// The number of ticks that can be passed at once without passing the frame before `time`.
    fn ticks_ahead(&self, around: &Around, time: u64) -> u64 {
        let period = self.stage.feed.frame().map_or(0, |frame| frame.header().tick_period_nanos);
        let left = (time - around.after.sim_time_nanos).checked_div(period).unwrap_or(0);
        left.saturating_sub(around.gap.saturating_mul(2)).max(1)
    }
}

fn nanos(time: humantime::Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_one_step_apart_and_include_both_ends() {
        let schedule = Schedule { from: 1_000_000_000, to: 3_000_000_000, step: 1e9 / 30.0 };
        assert_eq!(schedule.pictures(), 61);
        assert_eq!((schedule.time(0), schedule.time(60)), (1_000_000_000, 3_000_000_000));
        assert_eq!(schedule.time(1), 1_033_333_333);
        assert_eq!(Schedule { to: 1_000_000_000, ..schedule }.pictures(), 1);
        assert_eq!(Schedule { to: 1_050_000_000, ..schedule }.pictures(), 2, "only whole steps");
    }

    #[test]
    fn the_moment_lies_between_two_frames_of_one_run() {
        let at = |sim_time_nanos, run_id| ControlResponse {
            sim_time_nanos,
            run_id,
            ..ControlResponse::default()
        };
        let around = Around { before: at(100, 1), after: at(200, 1), gap: 1, is_at_end: false };
        assert_eq!([100, 150, 200, 300].map(|time| around.alpha(time)), [0.0, 0.5, 1.0, 1.0]);
        let between_runs = Around { after: at(200, 2), ..around };
        assert!(
            (between_runs.alpha(150) - 1.0).abs() < f32::EPSILON,
            "robots don't glide from run to run"
        );
    }
}
