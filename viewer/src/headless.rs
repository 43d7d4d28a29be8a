//! Pictures without a window.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::{UVec2, Vec3};
use image::RgbaImage;
use regatta_plugin::{Participant, Result, Termination};

use crate::camera::Camera;
use crate::gpu::TargetKind;
use crate::gpu::device::Gpu;
use crate::gpu::frame::Renderer;
use crate::options::Options;
use crate::palette::Colouring;
use crate::picture::{FORMAT, Offscreen, write_png};
use crate::record::Film;
use crate::stage::Stage;

/// Between two looks for something new.
const POLL: Duration = Duration::from_millis(2);
/// After so long without a fleet, say that it is waited for.
const SILENCE: Duration = Duration::from_secs(1);
/// Columns may come some moments after the frame.
const COLUMNS_WAIT: Duration = Duration::from_millis(150);

/// A stage, and the texture that it is drawn on.
struct Studio<'a> {
    options: &'a Options,
    gpu: Gpu,
    stage: Stage,
    offscreen: Offscreen,
    termination: Termination,
}

/// Draws what the options ask for.
///
/// # Errors
/// If there is no adapter, the fleet can't be read, or a picture can't be written.
pub fn run(options: &Options) -> Result {
    let termination = Termination::watch()?;
    let gpu = Gpu::offscreen()?;
    let target = TargetKind { format: FORMAT, samples: options.look.samples.unwrap_or(4) };
    let offscreen = Offscreen::new(&gpu, options.size.0)?;
    let participant = Participant::join(&options.fleet, "viewer")?;
    let mut renderer = Renderer::new(&gpu, target);
    options.look.furnish(&mut renderer);
    let stage = Stage::new(&participant, renderer, options.look.scene())?;
    let mut studio = Studio { options, gpu, stage, offscreen, termination };
    match (&options.screenshot, &options.record) {
        (Some(path), _) => studio.screenshot(path),
        (None, Some(path)) => studio.record(path),
        (None, None) => {
            Err(regatta_plugin::Error::new("--headless needs --screenshot FILE, --record FOLDER or --bench N"))
        }
    }
}

impl Studio<'_> {
    fn screenshot(&mut self, path: &Path) -> Result {
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        self.settle()?;
        let picture = self.shoot(1.0)?;
        write_png(&picture, path)?;
        Ok(())
    }

    /// Draws pictures in even steps of wall time, each of the fleet at its moment.
    fn record(&mut self, path: &Path) -> Result {
        let mut film = Film::create(path, self.options.fps, self.size())?;
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        let started = Instant::now();
        let step = Duration::from_secs(1) / self.options.fps;
        let wanted = (self.options.record_for().as_secs_f64() * f64::from(self.options.fps)).ceil() as u32;
        let mut late = 0;
        while film.pictures() < wanted && !self.termination.requested() {
            let due = started + step * film.pictures();
            self.wait_until(due)?;
            let picture = self.shoot(self.stage.alpha(Instant::now()))?;
            film.add(&picture)?;
            // Where drawing takes longer than a step, the same picture stands for the steps that it took.
            let passed = (started.elapsed().as_secs_f64() * f64::from(self.options.fps)) as u32;
            while film.pictures() < passed.min(wanted) {
                film.add(&picture)?;
                late += 1;
            }
        }
        let pictures = film.finish()?;
        if late > 0 {
            eprintln!(
                "{late} of {} pictures are repeats: this machine draws fewer than {} a second",
                pictures, self.options.fps
            );
        }
        Ok(())
    }

    /// Takes frames as they come until a picture is due.
    fn wait_until(&mut self, due: Instant) -> Result {
        loop {
            self.stage.update(Instant::now())?;
            let left = due.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            std::thread::sleep(left.min(POLL));
        }
    }

    /// Waits for a world and a frame of the wanted time; false if asked to end.
    fn wait_for_fleet(&mut self) -> Result<bool> {
        let (started, mut said) = (Instant::now(), false);
        let from = self.options.at.map_or(Duration::ZERO, Into::into);
        while !self.termination.requested() {
            let news = self.stage.update(Instant::now())?;
            if news.frame && self.stage.scene.trails.points > 0 {
                self.stage.collect_trails();
            }
            let time = self.stage.feed.frame().map(|frame| frame.sim_time());
            if time.is_some_and(|time| time >= from) && self.stage.feed.world().is_some() {
                let bounds = self.stage.bounds();
                self.options.look.lay_floor(&mut self.stage.renderer, bounds);
                return Ok(true);
            }
            if !said && time.is_none() && started.elapsed() > SILENCE {
                eprintln!("waiting for fleet '{}'", self.options.fleet);
                said = true;
            }
            std::thread::sleep(POLL);
        }
        Ok(false)
    }

    /// Takes what columns there are for the frame.
    fn settle(&mut self) -> Result {
        let started = Instant::now();
        let has_column = matches!(self.stage.scene.colouring, Colouring::Column(_));
        while has_column && self.stage.feed.value().is_none() && started.elapsed() < COLUMNS_WAIT {
            std::thread::sleep(POLL);
            self.stage.update(Instant::now())?;
        }
        Ok(())
    }

    fn camera(&self) -> Camera {
        let pose = self.options.follow.and_then(|robot| {
            let (frame, robot) = (self.stage.feed.frame()?, robot as usize);
            Some((*frame.x().get(robot)?, *frame.y().get(robot)?, *frame.theta().get(robot)?))
        });
        let offset = self.stage.scene.offset;
        match pose {
            Some((x, y, theta)) => Camera {
                target: Vec3::new(x + offset.x, y + offset.y, 0.2),
                yaw: theta,
                pitch: 0.42,
                distance: 6.0,
                ..Camera::default()
            },
            None => self.options.camera.camera(self.stage.bounds(), self.size()),
        }
    }

    fn size(&self) -> UVec2 {
        self.offscreen.size()
    }

    fn shoot(&mut self, alpha: f32) -> Result<RgbaImage> {
        let camera = self.camera();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let size = self.size();
        self.stage.draw(&mut encoder, &self.offscreen.view, &camera, size, alpha);
        Ok(self.offscreen.read(encoder)?)
    }
}
