//! Rendering without a window: a screenshot, a recording of a live fleet, or a film of a recording.

mod film;
mod scrub;

mod output;

use std::path::Path;
use std::time::{Duration, Instant};

use glam::{UVec2, Vec2};
use image::RgbaImage;
use regatta_plugin::frame::{ClockState, RobotState};
use regatta_plugin::{Error, Participant, Result, Termination};

use crate::camera::Camera;
use crate::caption::{Annotations, Caption};
use crate::feed::News;
use crate::gpu::TargetConfig;
use crate::gpu::device::Gpu;
use crate::gpu::renderer::Renderer;
use crate::interface::banner::Banner;
use crate::interface::labels::{Labels, levels};
use crate::interface::robot_spots;
use crate::interface::style::thousands;
use crate::interface::transport::clock_text;
use crate::jams::Watch as JamWatched;
use crate::options::{CameraOption, Options};
use crate::palette::{Colouring, Theme};
use crate::picture::{FORMAT, Offscreen, write_png};
use crate::plans::{PlanFacts, Watch};
use crate::route::RoutePoller;
use crate::stage::Stage;
use crate::video::VideoWriter;
use crate::watching::Inbox;

/// The time between two polls for new data.
const POLL: Duration = Duration::from_millis(2);
/// The time after which a message says that the viewer waits for the fleet.
const NOTICE_AFTER: Duration = Duration::from_secs(1);
/// The longest time that the replay of a recording may take to start.
const REPLAY_START: Duration = Duration::from_secs(30);
/// The longest wait for columns, which may arrive some moments after their frame.
const COLUMNS_WAIT: Duration = Duration::from_millis(300);
/// The longest wait for a column that the command line names, whose plugin may just be starting.
const REQUESTED_COLUMN_WAIT: Duration = Duration::from_secs(3);
/// The timeout of a request for routes, for a screenshot and for a picture of a recording.
const ROUTE_TIMEOUTS: [Duration; 2] = [Duration::from_secs(2), Duration::from_millis(100)];

/// The longest wait for the figures of a heat map.
const HEAT_WAIT: Duration = Duration::from_secs(3);
/// The longest wait for the plans of all robots of a screenshot.
const PLANS_WAIT: Duration = Duration::from_secs(10);

/// A stage with the texture that it is drawn into.
struct HeadlessViewer<'a> {
    options: &'a Options,
    /// The camera, unless a robot is followed.
    view: CameraOption,
    gpu: Gpu,
    participant: Participant,
    stage: Stage,
    routes: RoutePoller,
    plans: Option<Inbox<Watch>>,
    jams: Option<Inbox<JamWatched>>,
    offscreen: Offscreen,
    caption: Caption,
    /// The time of the picture, where it isn't that of the newest frame, in seconds.
    clock: Option<f64>,
    termination: Termination,
}

/// Writes the screenshot or the recording that the options request.
///
/// # Errors
/// If there is no graphics adapter, the fleet can't be read, or a picture can't be written.
pub fn run(options: &Options) -> Result {
    output::check(options)?;
    let view = options.requested_camera()?;
    let termination = Termination::watch()?;
    let gpu = Gpu::offscreen()?;
    // A measurement draws as a window does.
    let samples = if gpu.is_software() && !options.bench.is_empty() { 1 } else { 4 };
    let target = TargetConfig::new(&gpu, FORMAT, options.look.samples.unwrap_or(samples));
    let offscreen = Offscreen::new(&gpu, options.picture_size(), target)?;
    let participant = Participant::join(&options.fleet, "viewer")?;
    let mut renderer = Renderer::new(&gpu, target);
    options.look.load_meshes(&mut renderer);
    let stage = Stage::new(&participant, renderer, options.look.scene())?;
    let mut routes = RoutePoller::default();
    routes.watch(options.follow.iter().chain(&options.look.select).copied().collect(), Instant::now());
    let followed = options.follow.iter().chain(&options.look.select).copied().collect();
    // A film reads them with each frame, so that they don't depend on when a thread wakes.
    let watch = Watch { selected: followed, ..stage.plan_watch() };
    let plans = if options.film.is_some() { None } else { Inbox::open(&options.fleet, watch)? };
    let jams = if options.film.is_some() { None } else { Inbox::open(&options.fleet, stage.jam_watch())? };
    let caption = Caption::new(&gpu);
    let mut viewer = HeadlessViewer {
        view,
        caption,
        clock: None,
        options,
        gpu,
        participant,
        stage,
        routes,
        plans,
        jams,
        offscreen,
        termination,
    };
    match (&options.film, &options.screenshot, &options.record) {
        (Some(path), ..) => viewer.film(path),
        (None, Some(path), _) => viewer.screenshot(path),
        (None, None, Some(path)) => viewer.record(path),
        (None, None, None) if options.svg.is_some() => viewer.svg(options.svg.as_deref().unwrap_or(Path::new(""))),
        (None, None, None) if !options.bench.is_empty() => viewer.scrub(),
        (None, None, None) => Err(Error::new("--headless needs --screenshot FILE, --record FOLDER or --bench N")),
    }
}

impl HeadlessViewer<'_> {
    fn screenshot(&mut self, path: &Path) -> Result {
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        self.wait_for_columns()?;
        self.check_options()?;
        self.wait_for_plans()?;
        self.wait_for_heat()?;
        let picture = self.render(1.0)?;
        write_png(&picture, path)?;
        Ok(())
    }

    /// Writes a plan.
    fn svg(&mut self, path: &Path) -> Result {
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        self.wait_for_columns()?;
        self.check_options()?;
        let theme = self.options.look.theme.unwrap_or(Theme::Light);
        let text = self.stage.svg(&self.options.fleet.to_string(), theme, self.options.svg_scale)?;
        std::fs::write(path, text).map_err(|error| Error::new(format!("{}: {error}", path.display())))
    }

    /// Records pictures at regular steps of wall time.
    fn record(&mut self, path: &Path) -> Result {
        let mut video = VideoWriter::create(path, self.options.fps, self.size())?;
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        self.wait_for_columns()?;
        self.check_options()?;
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
            eprintln!(
                "{repeats} of {pictures} pictures are repeats: this machine renders fewer than {fps} per second; \
                 `regatta record`, then `regatta viewer FILE --film`, repeats none"
            );
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
            self.caption.labels = Labels::new(&world, self.options.look.level.as_deref());
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
                let (time, fleet) = (time.as_secs_f64(), &self.options.fleet);
                return Err(Error::new(format!(
                    "fleet '{fleet}' is already at {time:.2} s, after --at: give a later time, or replay a recording"
                )));
            }
            if time.is_some_and(|time| time >= from) && self.stage.feed.world().is_some() {
                let bounds = self.stage.bounds();
                self.options.look.load_floor_picture(&mut self.stage.renderer, bounds);
                return Ok(true);
            }
            if self.options.recording.is_some() && time.is_none() && started.elapsed() > REPLAY_START {
                return Err(Error::new("the replay of the recording doesn't start; `regatta replay FILE` says why"));
            }
            if !is_notified && started.elapsed() > NOTICE_AFTER {
                let what = if time.is_some() { "the time --at of " } else { "" };
                eprintln!("waiting for {what}fleet '{}'", self.options.fleet);
                is_notified = true;
            }
            if time.is_none() && started.elapsed() > self.options.timeout.into() {
                let (fleet, timeout) = (&self.options.fleet, self.options.timeout);
                return Err(Error::new(format!(
                    "no frame of fleet '{fleet}' within {timeout}: start it with `regatta run`, or give a longer --timeout"
                )));
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
        let wait = if self.options.look.colour.is_some() { REQUESTED_COLUMN_WAIT } else { COLUMNS_WAIT };
        while lacks(&self.stage) && started.elapsed() < wait && !self.termination.requested() {
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
        let found = self.jams.as_ref().map(Inbox::take).transpose()?;
        found.into_iter().flatten().for_each(|report| {
            self.stage.set_jams(report);
        });
        Ok(())
    }

    /// Takes the newest plans. Returns what is known if there are new ones.
    fn update_plans(&mut self) -> Result<Option<PlanFacts>> {
        let Some(found) = self.plans.as_ref().map(Inbox::newest).transpose()?.flatten() else { return Ok(None) };
        self.stage.set_plans(&found);
        Ok(Some(found.facts))
    }

    /// The lines that say what a picture shows: the fleet, the simulated time and the number of robots.
    fn title(&self) -> Vec<String> {
        let frame = self.stage.feed.frame();
        let robots = frame.map_or(0, |frame| {
            frame.columns().state.iter().filter(|state| **state != RobotState::Absent as u8).count()
        });
        let time = self.clock.unwrap_or_else(|| frame.map_or(0.0, |frame| frame.sim_time().as_secs_f64()));
        // The fleet of a recording has another name each time.
        let file =
            self.options.recording.as_ref().and_then(|file| Some(file.file_name()?.to_string_lossy().into_owned()));
        let name = file.unwrap_or_else(|| self.options.fleet.to_string());
        vec![name, format!("{}, {} robots", clock_text(time), thousands(robots as u64))]
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

    /// Refuses options that this fleet can't fulfil, and warns about those that have no effect.
    fn check_options(&self) -> Result {
        let robots = self.stage.feed.frame().map_or(0, |frame| frame.len());
        if let Some(robot) = self.selected().find(|robot| *robot as usize >= robots) {
            return Err(Error::new(format!(
                "there is no robot {robot}: fleet '{}' has {robots} robots, numbered from 0",
                self.options.fleet
            )));
        }
        let levels = self.stage.feed.world().map(|world| levels(&world)).unwrap_or_default();
        if let Some(level) = self.options.look.level.as_ref().filter(|level| !levels.contains(*level)) {
            let known = if levels.is_empty() { "none".to_owned() } else { levels.join(", ") };
            return Err(Error::new(format!("there is no level '{level}'; the levels of this world: {known}")));
        }
        if let (Some(Colouring::Column(name)), None) = (&self.options.look.colour, self.stage.feed.value()) {
            return Err(Error::new(format!(
                "nobody publishes the column '{name}' of fleet '{}': start its plugin, or give another --colour",
                self.options.fleet
            )));
        }
        if self.stage.scene.trails.points > 0 && self.options.screenshot.is_some() && self.options.at.is_none() {
            tracing::warn!("trails start with this program; use --at with a later time to let them grow");
        }
        Ok(())
    }

    fn camera(&self) -> Camera {
        match self.options.follow.and_then(|robot| self.pose(robot)) {
            Some((position, theta)) => {
                Camera { target: position.extend(0.2), yaw: theta, pitch: 0.42, distance: 6.0, ..Camera::default() }
            }
            None => self.view.camera(self.stage.bounds(), self.size()),
        }
    }

    fn size(&self) -> UVec2 {
        self.offscreen.size()
    }

    fn render(&mut self, alpha: f32) -> Result<RgbaImage> {
        // A recording has no routes to ask for.
        if self.options.film.is_none() {
            let timeout = ROUTE_TIMEOUTS[usize::from(self.options.record.is_some())];
            if let Some(routes) = self.routes.poll(&self.participant, timeout)? {
                self.stage.set_routes(routes);
            }
            self.update_plans()?;
            self.update_jams()?;
        }
        self.stage.hide_other_levels();
        let camera = self.camera();
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let size = self.size();
        self.stage.draw(&mut encoder, &self.offscreen.view, &camera, size, alpha);
        let (target, legend) = ((&self.offscreen.overlay, size), self.stage.legend());
        let legend = (!self.options.look.no_legend).then_some(&legend);
        let selected = self.selected().filter(|_| !self.options.look.no_ids);
        let robots = selected.filter_map(|robot| Some((robot, self.pose(robot)?.0))).collect();
        let plans = self.stage.plan_facts();
        let time = self.clock.or_else(|| Some(self.stage.feed.frame()?.sim_time().as_secs_f64()));
        let look = &self.options.look;
        let banner = Banner { title: look.title.clone(), clock: time.filter(|_| look.clock), scale: look.scale };
        let frame = self.stage.feed.frame();
        let robot_radius = self.stage.feed.world().map_or(0.5, |world| robot_spots::radius(&world));
        let heat = self.stage.jam_facts().heat;
        let density = self.stage.shown_density(&camera, size);
        let (title, scene) = (self.title(), &self.stage.scene);
        let annotations = Annotations {
            camera: &camera,
            scene,
            legend,
            plans,
            title,
            frame,
            robot_radius,
            heat,
            closed: self.stage.closed().len() as u32,
            density,
            robots,
            banner,
        };
        self.caption.draw(&self.gpu, &mut encoder, target, &annotations);
        Ok(self.offscreen.read(encoder)?)
    }
}
