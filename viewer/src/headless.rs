//! Pictures without a window.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::{UVec2, Vec2};
use image::RgbaImage;
use regatta_plugin::frame::ClockState;
use regatta_plugin::{Error, Participant, Result, Termination};

use crate::camera::Camera;
use crate::caption::{Caption, Shown};
use crate::feed::News;
use crate::gpu::TargetKind;
use crate::gpu::device::Gpu;
use crate::gpu::frame::Renderer;
use crate::interface::labels::Labels;
use crate::options::Options;
use crate::palette::Colouring;
use crate::picture::{FORMAT, Offscreen, write_png};
use crate::record::Film;
use crate::route::RouteWatch;
use crate::stage::Stage;

/// Between two looks for something new.
const POLL: Duration = Duration::from_millis(2);
/// After so long without a fleet, say that it is waited for.
const SILENCE: Duration = Duration::from_secs(1);
/// Columns may come some moments after the frame.
const COLUMNS_WAIT: Duration = Duration::from_millis(300);
/// How long routes may take for a picture, and for one of many.
const ROUTE_PATIENCE: [Duration; 2] = [Duration::from_secs(2), Duration::from_millis(100)];

/// A stage, and the texture that it is drawn on.
struct Studio<'a> {
    options: &'a Options,
    gpu: Gpu,
    participant: Participant,
    stage: Stage,
    routes: RouteWatch,
    offscreen: Offscreen,
    caption: Caption,
    termination: Termination,
}

/// Draws what the options ask for.
///
/// # Errors
/// If there is no adapter, the fleet can't be read, or a picture can't be written.
pub fn run(options: &Options) -> Result {
    let termination = Termination::watch()?;
    let gpu = Gpu::offscreen()?;
    let target = TargetKind::new(&gpu, FORMAT, options.look.samples.unwrap_or(4));
    let offscreen = Offscreen::new(&gpu, options.picture_size())?;
    let participant = Participant::join(&options.fleet, "viewer")?;
    let mut renderer = Renderer::new(&gpu, target);
    options.look.furnish(&mut renderer);
    let stage = Stage::new(&participant, renderer, options.look.scene())?;
    let mut routes = RouteWatch::default();
    routes.watch(options.follow.iter().chain(&options.look.select).copied().collect(), Instant::now());
    let mut studio =
        Studio { caption: Caption::new(&gpu), options, gpu, participant, stage, routes, offscreen, termination };
    match (&options.screenshot, &options.record) {
        (Some(path), _) => studio.screenshot(path),
        (None, Some(path)) => studio.record(path),
        (None, None) => Err(Error::new("--headless needs --screenshot FILE, --record FOLDER or --bench N")),
    }
}

impl Studio<'_> {
    fn screenshot(&mut self, path: &Path) -> Result {
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        self.settle()?;
        self.complain();
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
        self.complain();
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
            let news = self.stage.update(Instant::now())?;
            self.learn(news);
            let left = due.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            std::thread::sleep(left.min(POLL));
        }
    }

    /// Takes the ids of a new world.
    fn learn(&mut self, news: News) {
        if let Some(world) = self.stage.feed.world().filter(|_| news.world) {
            self.caption.labels = Labels::new(world.nodes(), world.edges());
        }
    }

    /// Waits for a world and a frame of the wanted time; false if asked to end.
    fn wait_for_fleet(&mut self) -> Result<bool> {
        let (started, mut said, mut looks) = (Instant::now(), false, 0);
        let from = self.options.at.map_or(Duration::ZERO, Into::into);
        while !self.termination.requested() {
            let news = self.stage.update(Instant::now())?;
            self.learn(news);
            if news.frame && self.stage.scene.trails.points > 0 {
                self.stage.collect_trails();
            }
            let time = self.stage.feed.frame().map(|frame| frame.sim_time());
            looks += u32::from(time.is_some());
            if let Some(time) = time.filter(|time| looks == 1 && self.options.at.is_some() && *time > from) {
                let told = format!("{:.2} s have passed already; --at is before that", time.as_secs_f64());
                tracing::warn!("{told}, so the picture is of now");
            }
            if time.is_some_and(|time| time >= from) && self.stage.feed.world().is_some() {
                let bounds = self.stage.bounds();
                self.options.look.lay_floor(&mut self.stage.renderer, bounds);
                return Ok(true);
            }
            if !said && started.elapsed() > SILENCE {
                let what = if time.is_some() { "that time of " } else { "" };
                eprintln!("waiting for {what}fleet '{}'", self.options.fleet);
                said = true;
            }
            if let Some(time) = time.filter(|_| self.has_ended()) {
                let (time, fleet) = (time.as_secs_f64(), &self.options.fleet);
                return Err(Error::new(format!("fleet '{fleet}' ended at {time:.2} s, before --at")));
            }
            std::thread::sleep(POLL);
        }
        Ok(false)
    }

    /// Whether no more frames are to come.
    fn has_ended(&self) -> bool {
        let header = self.stage.feed.frame().map(|frame| *frame.header());
        header.is_some_and(|header| header.clock == ClockState::Stopped as u32) || !self.stage.feed.has_producer()
    }

    /// Takes what columns there are for the frame.
    fn settle(&mut self) -> Result {
        let started = Instant::now();
        let has_column = matches!(self.stage.scene.colouring, Colouring::Column(_));
        let lacks = |stage: &Stage| stage.feed.kinds().is_none() || has_column && stage.feed.value().is_none();
        while lacks(&self.stage) && started.elapsed() < COLUMNS_WAIT {
            std::thread::sleep(POLL);
            self.stage.update(Instant::now())?;
        }
        Ok(())
    }

    /// The robots that the options name.
    fn chosen(&self) -> impl Iterator<Item = u32> {
        self.options.follow.iter().chain(&self.options.look.select).copied()
    }

    /// Where a robot is drawn, and its heading.
    fn pose(&self, robot: u32) -> Option<(Vec2, f32)> {
        let (frame, row) = (self.stage.feed.frame()?, robot as usize);
        let place = Vec2::new(*frame.x().get(row)?, *frame.y().get(row)?);
        Some((place + self.stage.scene.offset, *frame.theta().get(row)?))
    }

    /// Says what of the options there is nothing of.
    fn complain(&self) {
        let robots = self.stage.feed.frame().map_or(0, |frame| frame.len());
        if let Some(robot) = self.chosen().find(|robot| *robot as usize >= robots) {
            tracing::warn!("there is no robot {robot}: the fleet has {robots}, from 0 on");
        }
        if let (Some(Colouring::Column(name)), None) = (&self.options.look.colour, self.stage.feed.value()) {
            tracing::warn!("nobody publishes the column '{name}'; robots are of one colour");
        }
        if self.stage.scene.trails.points > 0 && self.options.screenshot.is_some() && self.options.at.is_none() {
            tracing::warn!("trails begin when this program does: --at a later time lets them grow");
        }
    }

    fn camera(&self) -> Camera {
        match self.options.follow.and_then(|robot| self.pose(robot)) {
            Some((place, theta)) => {
                Camera { target: place.extend(0.2), yaw: theta, pitch: 0.42, distance: 6.0, ..Camera::default() }
            }
            None => self.options.camera.camera(self.stage.bounds(), self.size()),
        }
    }

    fn size(&self) -> UVec2 {
        self.offscreen.size()
    }

    fn shoot(&mut self, alpha: f32) -> Result<RgbaImage> {
        let patience = ROUTE_PATIENCE[usize::from(self.options.record.is_some())];
        if let Some(routes) = self.routes.ask(&self.participant, patience)? {
            self.stage.set_routes(routes);
        }
        let camera = self.camera();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let size = self.size();
        self.stage.draw(&mut encoder, &self.offscreen.view, &camera, size, alpha);
        let (target, legend) = ((&self.offscreen.overlay, size), self.stage.legend());
        let legend = (!self.options.look.no_legend).then_some(&legend);
        let chosen = self.chosen().filter(|_| !self.options.look.no_ids);
        let robots = chosen.filter_map(|robot| Some((robot, self.pose(robot)?.0))).collect();
        let shown = Shown { camera: &camera, scene: &self.stage.scene, legend, robots };
        self.caption.draw(&self.gpu, &mut encoder, target, &shown);
        Ok(self.offscreen.read(encoder)?)
    }
}
