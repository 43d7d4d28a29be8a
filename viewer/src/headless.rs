//! Rendering without a window: a screenshot or a recording.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::{UVec2, Vec2};
use image::RgbaImage;
use regatta_plugin::frame::ClockState;
use regatta_plugin::{Error, Participant, Result, Termination};

use crate::camera::Camera;
use crate::caption::{Annotations, Caption};
use crate::feed::News;
use crate::gpu::TargetConfig;
use crate::gpu::device::Gpu;
use crate::gpu::renderer::Renderer;
use crate::interface::labels::Labels;
use crate::jams::inbox::JamInbox;
use crate::options::Options;
use crate::palette::Colouring;
use crate::picture::{FORMAT, Offscreen, write_png};
use crate::plans::inbox::PlanInbox;
use crate::plans::{PlanFacts, Watch};
use crate::route::RoutePoller;
use crate::stage::Stage;
use crate::video::VideoWriter;

/// The time between two polls for new data.
const POLL: Duration = Duration::from_millis(2);
/// The time after which a message says that the viewer waits for the fleet.
const NOTICE_AFTER: Duration = Duration::from_secs(1);
/// The longest wait for columns, which may arrive some moments after their frame.
const COLUMNS_WAIT: Duration = Duration::from_millis(300);
/// The timeout of a request for routes, for a screenshot and for a picture of a recording.
const ROUTE_TIMEOUTS: [Duration; 2] = [Duration::from_secs(2), Duration::from_millis(100)];

/// The longest wait for the figures of a heat map.
const HEAT_WAIT: Duration = Duration::from_secs(3);
/// The longest wait for the plans of all robots of a screenshot.
const PLANS_WAIT: Duration = Duration::from_secs(10);

/// A stage with the texture that it is drawn into.
struct HeadlessViewer<'a> {
    options: &'a Options,
    gpu: Gpu,
    participant: Participant,
    stage: Stage,
    routes: RoutePoller,
    plans: Option<PlanInbox>,
    jams: Option<JamInbox>,
    offscreen: Offscreen,
    caption: Caption,
    termination: Termination,
}

/// Writes the screenshot or the recording that the options request.
///
/// # Errors
/// If there is no graphics adapter, the fleet can't be read, or a picture can't be written.
pub fn run(options: &Options) -> Result {
    check_output(options)?;
    let termination = Termination::watch()?;
    let gpu = Gpu::offscreen()?;
    let target = TargetConfig::new(&gpu, FORMAT, options.look.samples.unwrap_or(4));
    let offscreen = Offscreen::new(&gpu, options.picture_size(), target)?;
    let participant = Participant::join(&options.fleet, "viewer")?;
    let mut renderer = Renderer::new(&gpu, target);
    options.look.load_meshes(&mut renderer);
    let stage = Stage::new(&participant, renderer, options.look.scene())?;
    let mut routes = RoutePoller::default();
    routes.watch(options.follow.iter().chain(&options.look.select).copied().collect(), Instant::now());
    let followed = options.follow.iter().chain(&options.look.select).copied().collect();
    let plans = PlanInbox::open(&options.fleet, Watch { selected: followed, ..stage.plan_watch() })?;
    let jams = JamInbox::open(&options.fleet, stage.jam_watch(None))?;
    let caption = Caption::new(&gpu);
    let mut viewer =
        HeadlessViewer { caption, options, gpu, participant, stage, routes, plans, jams, offscreen, termination };
    match (&options.screenshot, &options.record) {
        (Some(path), _) => viewer.screenshot(path),
        (None, Some(path)) => viewer.record(path),
        (None, None) => Err(Error::new("--headless needs --screenshot FILE, --record FOLDER or --bench N")),
    }
}

/// Returns an error if pictures would replace others without `--force`.
fn check_output(options: &Options) -> Result {
    let output = options.screenshot.as_deref().or(options.record.as_deref());
    match output.filter(|path| !options.force && is_taken(path)) {
        Some(path) => Err(Error::new(format!("{}: this exists; --force replaces it", path.display()))),
        None => Ok(()),
    }
}

/// Whether there is a file, or a folder with something in it.
fn is_taken(path: &Path) -> bool {
    path.read_dir().map_or_else(|_| path.is_file(), |mut entries| entries.next().is_some())
}

impl HeadlessViewer<'_> {
    fn screenshot(&mut self, path: &Path) -> Result {
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        self.wait_for_columns()?;
        self.wait_for_plans()?;
        self.wait_for_heat()?;
        self.warn_about_options();
        let picture = self.render(1.0)?;
        write_png(&picture, path)?;
        Ok(())
    }

    /// Records pictures at regular steps of wall time.
    fn record(&mut self, path: &Path) -> Result {
        let mut video = VideoWriter::create(path, self.options.fps, self.size())?;
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        self.warn_about_options();
        let started = Instant::now();
        let step = Duration::from_secs(1) / self.options.fps;
        let total = (self.options.record_for().as_secs_f64() * f64::from(self.options.fps)).ceil() as u32;
        let mut repeats = 0;
        while video.pictures() < total && !self.termination.requested() {
            let due = started + step * video.pictures();
            self.update_until(due)?;
            let picture = self.render(self.stage.alpha(Instant::now()))?;
            video.add(&picture)?;
            // If rendering takes longer than a step, the picture is repeated for the steps that were missed.
            let passed = (started.elapsed().as_secs_f64() * f64::from(self.options.fps)) as u32;
            while video.pictures() < passed.min(total) {
                video.add(&picture)?;
                repeats += 1;
            }
        }
        let pictures = video.finish()?;
        if repeats > 0 {
            let fps = self.options.fps;
            eprintln!("{repeats} of {pictures} pictures are repeats: this machine renders fewer than {fps} per second");
        }
        Ok(())
    }

    /// Uploads new data as it arrives, until a picture is due.
    fn update_until(&mut self, due: Instant) -> Result {
        loop {
            let news = self.stage.update(Instant::now())?;
            self.update_labels(news);
            let left = due.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(());
            }
            std::thread::sleep(left.min(POLL));
        }
    }

    /// Updates the ids of nodes and edges after a new world.
    fn update_labels(&mut self, news: News) {
        if let Some(world) = self.stage.feed.world().filter(|_| news.world) {
            self.caption.labels = Labels::new(&world);
        }
    }

    /// Waits for a world, and for a frame at or after the requested time. Returns false if interrupted.
    fn wait_for_fleet(&mut self) -> Result<bool> {
        let (started, mut is_notified, mut polls) = (Instant::now(), false, 0);
        let from = self.options.at.map_or(Duration::ZERO, Into::into);
        while !self.termination.requested() {
            let news = self.stage.update(Instant::now())?;
            self.update_labels(news);
            if news.frame && self.stage.scene.trails.points > 0 {
                self.stage.collect_trails();
            }
            let time = self.stage.feed.frame().map(|frame| frame.sim_time());
            polls += u32::from(time.is_some());
            if let Some(time) = time.filter(|time| polls == 1 && self.options.at.is_some() && *time > from) {
                let seconds = time.as_secs_f64();
                tracing::warn!(
                    "the fleet is already at {seconds:.2} s, which is after --at; the picture shows that time"
                );
            }
            if time.is_some_and(|time| time >= from) && self.stage.feed.world().is_some() {
                let bounds = self.stage.bounds();
                self.options.look.load_floor_picture(&mut self.stage.renderer, bounds);
                return Ok(true);
            }
            if !is_notified && started.elapsed() > NOTICE_AFTER {
                let what = if time.is_some() { "the time --at of " } else { "" };
                eprintln!("waiting for {what}fleet '{}'", self.options.fleet);
                is_notified = true;
            }
            if let Some(time) = time.filter(|_| self.has_ended()) {
                let (time, fleet) = (time.as_secs_f64(), &self.options.fleet);
                return Err(Error::new(format!("fleet '{fleet}' ended at {time:.2} s, before --at")));
            }
            std::thread::sleep(POLL);
        }
        Ok(false)
    }

    /// Whether the producer has stopped or is gone.
    fn has_ended(&self) -> bool {
        let header = self.stage.feed.frame().map(|frame| *frame.header());
        header.is_some_and(|header| header.clock == ClockState::Stopped as u32) || !self.stage.feed.has_producer()
    }

    /// Waits a moment for the columns of robot types and values.
    fn wait_for_columns(&mut self) -> Result {
        let started = Instant::now();
        let has_column = matches!(self.stage.scene.colouring, Colouring::Column(_));
        let lacks = |stage: &Stage| stage.feed.robot_type().is_none() || has_column && stage.feed.value().is_none();
        while lacks(&self.stage) && started.elapsed() < COLUMNS_WAIT {
            std::thread::sleep(POLL);
            self.stage.update(Instant::now())?;
        }
        Ok(())
    }

    /// Waits until the routes of all robots have been asked for once, and who waits is known.
    fn wait_for_plans(&mut self) -> Result {
        let started = Instant::now();
        let layers = self.stage.scene.layers;
        while self.plans.is_some() && started.elapsed() < PLANS_WAIT && !self.termination.requested() {
            std::thread::sleep(POLL);
            self.stage.update(Instant::now())?;
            let Some(facts) = self.update_plans()? else { continue };
            let has_round = facts.routes.is_some_and(|routes| routes.round_secs.is_finite() || routes.under_way == 0);
            // Without a fleet manager, nobody publishes the columns.
            let is_late = started.elapsed() > COLUMNS_WAIT;
            let has_columns = facts.has_goals && (!layers.waits || facts.waiting.is_some());
            if (!layers.plans || has_round) && (has_columns || is_late) {
                break;
            }
        }
        Ok(())
    }

    /// Waits a moment for the figures of the heat map, which are published once a simulated second.
    fn wait_for_heat(&mut self) -> Result {
        let started = Instant::now();
        while self.jams.is_some() && started.elapsed() < HEAT_WAIT && !self.termination.requested() {
            std::thread::sleep(POLL);
            self.stage.update(Instant::now())?;
            self.update_jams()?;
            if self.stage.jam_facts().heat.is_some() {
                return Ok(());
            }
        }
        if self.jams.is_some() {
            let fleet = &self.options.fleet;
            tracing::warn!("nobody publishes the figures of edges; start: regatta plugin traffic --fleet {fleet}");
        }
        Ok(())
    }

    /// Takes what was found of where it jams.
    fn update_jams(&mut self) -> Result {
        let found = self.jams.as_ref().map(JamInbox::take).transpose()?;
        found.into_iter().flatten().for_each(|report| {
            self.stage.set_jams(report);
        });
        Ok(())
    }

    /// Takes the newest plans. Returns what is known if there are new ones.
    fn update_plans(&mut self) -> Result<Option<PlanFacts>> {
        let Some(found) = self.plans.as_ref().map(PlanInbox::newest).transpose()?.flatten() else { return Ok(None) };
        self.stage.set_plans(&found);
        Ok(Some(found.facts))
    }

    /// The robots of --follow and --select.
    fn selected(&self) -> impl Iterator<Item = u32> {
        self.options.follow.iter().chain(&self.options.look.select).copied()
    }

    /// The position at which a robot is drawn, and its heading.
    fn pose(&self, robot: u32) -> Option<(Vec2, f32)> {
        let (frame, row) = (self.stage.feed.frame()?, robot as usize);
        let position = Vec2::new(*frame.x().get(row)?, *frame.y().get(row)?);
        Some((position + self.stage.scene.offset, *frame.theta().get(row)?))
    }

    /// Warns about options that have no effect on this fleet.
    fn warn_about_options(&self) {
        let robots = self.stage.feed.frame().map_or(0, |frame| frame.len());
        if let Some(robot) = self.selected().find(|robot| *robot as usize >= robots) {
            tracing::warn!("there is no robot {robot}: the fleet has {robots} robots, numbered from 0");
        }
        if let (Some(Colouring::Column(name)), None) = (&self.options.look.colour, self.stage.feed.value()) {
            tracing::warn!("the column '{name}' is not published, so all robots have the same colour");
        }
        if self.stage.scene.trails.points > 0 && self.options.screenshot.is_some() && self.options.at.is_none() {
            tracing::warn!("trails start with this program; use --at with a later time to let them grow");
        }
    }

    fn camera(&self) -> Camera {
        match self.options.follow.and_then(|robot| self.pose(robot)) {
            Some((position, theta)) => {
                Camera { target: position.extend(0.2), yaw: theta, pitch: 0.42, distance: 6.0, ..Camera::default() }
            }
            None => self.options.camera.camera(self.stage.bounds(), self.size()),
        }
    }

    fn size(&self) -> UVec2 {
        self.offscreen.size()
    }

    fn render(&mut self, alpha: f32) -> Result<RgbaImage> {
        let timeout = ROUTE_TIMEOUTS[usize::from(self.options.record.is_some())];
        if let Some(routes) = self.routes.poll(&self.participant, timeout)? {
            self.stage.set_routes(routes);
        }
        self.update_plans()?;
        self.update_jams()?;
        let camera = self.camera();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let size = self.size();
        self.stage.draw(&mut encoder, &self.offscreen.view, &camera, size, alpha);
        let (target, legend) = ((&self.offscreen.overlay, size), self.stage.legend());
        let legend = (!self.options.look.no_legend).then_some(&legend);
        let selected = self.selected().filter(|_| !self.options.look.no_ids);
        let robots = selected.filter_map(|robot| Some((robot, self.pose(robot)?.0))).collect();
        let plans = self.stage.plan_facts();
        let heat = self.stage.jam_facts().heat;
        let density = self.stage.shown_density(&camera, size);
        let scene = &self.stage.scene;
        let annotations = Annotations { camera: &camera, scene, legend, plans, heat, density, robots };
        self.caption.draw(&self.gpu, &mut encoder, target, &annotations);
        Ok(self.offscreen.read(encoder)?)
    }
}
