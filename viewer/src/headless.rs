//! Rendering without a window: a screenshot, a recording of a live fleet, or a film of a recording.

mod film;
mod levels;
mod output;
mod scrub;
mod waiting;

use std::path::Path;
use std::time::{Duration, Instant};

use glam::{UVec2, Vec2};
use image::RgbaImage;
use regatta_gpu::TargetConfig;
use regatta_gpu::device::Gpu;
use regatta_gpu::renderer::Renderer;
use regatta_interface::banner::Banner;
use regatta_interface::cameras::CameraOption;
use regatta_interface::labels::{Labels, levels};
use regatta_interface::legend::{LEGEND, beside_legend};
use regatta_interface::text::with_plural;
use regatta_interface::transport::clock_text;
use regatta_plugin::frame::RobotState;
use regatta_plugin::{Error, Participant, Result, Termination};
use regatta_scene::camera::{Camera, Window};
use regatta_scene::palette::{Colouring, Theme};
use regatta_scene::plans::PlanFacts;

use crate::caption::{Annotations, Caption, pixels_per_point};
use crate::feed::News;
use crate::jams::JamQuery;
use crate::link::routes::RoutePoller;
use crate::options::Options;
use crate::picture::{FORMAT, Offscreen, write_png};
use crate::plans::PlanQuery;
use crate::stage::Stage;
use crate::video::VideoWriter;
use crate::worker::Inbox;
use levels::Part;

/// The time between two polls for new data.
const POLL: Duration = Duration::from_millis(2);
/// The timeout of a request for routes, for a screenshot and for a picture of a recording.
const ROUTE_TIMEOUTS: [Duration; 2] = [Duration::from_secs(2), Duration::from_millis(100)];

/// A stage with the texture that it is drawn into.
struct HeadlessViewer<'a> {
    options: &'a Options,
    /// The camera, unless a robot is followed.
    view: CameraOption,
    gpu: Gpu,
    participant: Participant,
    stage: Stage,
    routes: RoutePoller,
    plans: Option<Inbox<PlanQuery>>,
    jams: Option<Inbox<JamQuery>>,
    offscreen: Offscreen,
    caption: Caption,
    /// The time of the picture, where it isn't that of the newest frame, in seconds.
    clock: Option<f64>,
    /// The part of the picture that is drawn, if levels are shown side by side.
    part: Option<Part>,
    samples: u32,
    /// Whether the legend is hidden: as requested, or because it has no room.
    no_legend: bool,
    /// Whether the missing parts of the picture were reported.
    has_warned: bool,
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
    let samples = options.look.samples.unwrap_or(samples);
    let target = TargetConfig::new(&gpu, FORMAT, samples);
    let offscreen = Offscreen::new(&gpu, options.picture_size(), target)?;
    let participant = Participant::join(&options.fleet, "viewer")?;
    let mut renderer = Renderer::new(&gpu, target);
    options.look.load_meshes(&mut renderer);
    let mut stage = Stage::new(&participant, renderer, options.look.scene())?;
    stage.colouring.clone_from(&options.look.colour);
    let mut routes = RoutePoller::default();
    let followed: Vec<u32> = options.follow.iter().chain(&options.look.select).copied().collect();
    routes.watch(followed.clone(), Instant::now());
    // A film reads them with each frame, so that they don't depend on when a thread wakes.
    let watch = PlanQuery { selected: followed, ..stage.plan_query() };
    let plans = if options.film.is_some() { None } else { Inbox::open(&options.fleet, watch)? };
    let jams = if options.film.is_some() || options.counts_traffic() {
        None
    } else {
        Inbox::open(&options.fleet, stage.jam_query())?
    };
    let caption = Caption::new(&gpu);
    let mut viewer = HeadlessViewer {
        view,
        caption,
        clock: None,
        part: None,
        samples,
        no_legend: options.look.no_legend,
        has_warned: false,
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
        (None, None, None) if options.svg.is_some() => {
            viewer.svg(options.svg.as_deref().unwrap_or(Path::new("")))
        }
        (None, None, None) if !options.bench.is_empty() => viewer.scrub(),
        (None, None, None) => {
            Err(Error::new("--headless needs --screenshot FILE, --record FOLDER or --bench N"))
        }
    }
}

impl HeadlessViewer<'_> {
    fn screenshot(&mut self, path: &Path) -> Result {
        if !self.wait_for_fleet()? {
            return Ok(());
        }
        let alpha = if self.options.plays_to_picture() { self.play_to_picture()? } else { 1.0 };
        self.wait_for_columns()?;
        self.check_options()?;
        self.wait_for_plans()?;
        self.wait_for_heat()?;
        let picture = if self.options.levels {
            self.render_levels(self.samples)?
        } else {
            self.render(alpha)?
        };
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
        let text = self.stage.svg(&self.options.name(), theme, self.options.svg_scale)?;
        std::fs::write(path, text)
            .map_err(|error| Error::new(format!("{}: {error}", path.display())))
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
        let total = (Duration::from(self.options.for_).as_secs_f64() * f64::from(self.options.fps))
            .ceil() as u32;
        let mut repeats = 0;
        while video.pictures() < total && !self.termination.requested() {
            let due = started + step * video.pictures();
            self.update_until(due)?;
            let picture = self.render(self.stage.alpha(Instant::now()))?;
            video.add(&picture)?;
            // If rendering takes longer than a step, the picture is repeated for the steps that
            // were missed.
            let passed = (started.elapsed().as_secs_f64() * f64::from(self.options.fps)) as u32;
            while video.pictures() < passed.min(total) {
                video.add(&picture)?;
                repeats += 1;
            }
        }
        let pictures = video.finish()?;
        if repeats > 0 {
            let fps = self.options.fps;
            let verb = if repeats == 1 { "is a repeat" } else { "are repeats" };
            regatta_plugin::tell!(
                "viewer: {repeats} of {} {verb}: this machine renders fewer than {fps} per second; \
                 `regatta record`, then `regatta viewer FILE --film`, repeats none",
                with_plural(pictures.into(), "picture")
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

    /// Takes the new figures of jams.
    fn update_jams(&mut self) -> Result {
        if let Some(jams) = &self.jams {
            for report in jams.take()? {
                self.stage.set_jams(report);
            }
        }
        Ok(())
    }

    /// Takes the newest plans. Returns their counts if there are new ones.
    fn update_plans(&mut self) -> Result<Option<PlanFacts>> {
        let Some(plans) = &self.plans else { return Ok(None) };
        let Some(found) = plans.newest()? else { return Ok(None) };
        self.stage.set_plans(found);
        Ok(Some(self.stage.plan_facts()))
    }

    /// The lines of a picture's caption: the fleet, the simulated time and the number of robots.
    fn title(&self) -> Vec<String> {
        let frame = self.stage.feed.frame();
        let robots = frame.map_or(0, |frame| {
            frame.columns().state.iter().filter(|state| **state != RobotState::Absent as u8).count()
        });
        let time = self
            .clock
            .unwrap_or_else(|| frame.map_or(0.0, |frame| self.stage.feed.clock_secs(&frame)));
        vec![
            self.options.name(),
            format!("{}, {}", clock_text(time), with_plural(robots as u64, "robot")),
        ]
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

    /// Refuses options that don't fit this fleet, and warns about options without an effect.
    fn check_options(&self) -> Result {
        let robots = self.stage.feed.frame().map_or(0, |frame| frame.len());
        if let Some(robot) = self.selected().find(|robot| *robot as usize >= robots) {
            return Err(Error::new(format!(
                "there is no robot {robot}: fleet '{}' has {}, numbered from 0",
                self.options.fleet,
                with_plural(robots as u64, "robot")
            )));
        }
        let levels = self.stage.feed.world().map(|world| levels(&world)).unwrap_or_default();
        if let Some(level) =
            self.options.look.level.as_ref().filter(|level| !levels.contains(*level))
        {
            let known = if levels.is_empty() { "none".to_owned() } else { levels.join(", ") };
            return Err(Error::new(format!(
                "there is no level '{level}'; the levels of this world: {known}"
            )));
        }
        if let (Some(Colouring::Column(name)), None) =
            (&self.options.look.colour, self.stage.feed.value())
        {
            return Err(Error::new(format!(
                "nobody publishes the column '{name}' of fleet '{}': start its plugin, or give \
                 another --colour",
                self.options.fleet
            )));
        }
        if self.stage.scene.trails.points > 0
            && self.options.screenshot.is_some()
            && self.options.at.is_none()
        {
            tracing::warn!(
                "trails start with this program; use --at with a later time to let them grow"
            );
        }
        Ok(())
    }

    fn camera(&self) -> Camera {
        match self.options.follow.and_then(|robot| self.pose(robot)) {
            Some((position, theta)) => Camera {
                target: position.extend(0.2),
                yaw: theta,
                pitch: 0.42,
                distance: 6.0,
                ..Camera::default()
            },
            None => self.view.camera(self.stage.bounds(), self.window()),
        }
    }

    /// The part of the picture in which everything is to fit.
    fn window(&self) -> Window {
        let size = self.size().as_vec2();
        match self.no_legend || self.part.is_some() {
            true => Window::whole(size.x / size.y),
            false => beside_legend(size / pixels_per_point(self.size())),
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
        if self.part.is_none() && !self.no_legend && legend_width(self.size()) == 0 {
            self.leave_out(&[LEGEND]);
        }
        let (picture, left_out) = self.draw(alpha)?;
        // Without the legend, everything else has more room.
        if self.leave_out(&left_out) { Ok(self.draw(alpha)?.0) } else { Ok(picture) }
    }

    /// Reports once the parts for which the picture has no room. Returns whether the legend is
    /// hidden from now on.
    fn leave_out(&mut self, left_out: &[&str]) -> bool {
        if !left_out.is_empty() && !std::mem::replace(&mut self.has_warned, true) {
            tracing::warn!("{}", no_room(self.options.picture_size(), left_out));
        }
        let hides_legend = left_out.contains(&LEGEND);
        self.no_legend |= hides_legend;
        hides_legend
    }

    /// Draws a picture. Returns the names of the annotations that it has no room for, too.
    fn draw(&mut self, alpha: f32) -> Result<(RgbaImage, Vec<&'static str>)> {
        let camera = self.camera();
        let mut encoder = self.gpu.encoder();
        let size = self.size();
        self.stage.draw(&mut encoder, &self.offscreen.view, &camera, size, alpha);
        let (target, legend) = ((&self.offscreen.overlay, size), self.stage.legend());
        let legend = Some(&legend).filter(|_| self.part.is_none() && !self.no_legend);
        let plan =
            self.part.as_ref().is_none_or(|part| part.has_scale) && !self.options.look.no_legend;
        let selected = self.selected().filter(|_| !self.options.look.no_ids);
        let robots = selected.filter_map(|robot| Some((robot, self.pose(robot)?.0))).collect();
        let time =
            self.clock.or_else(|| Some(self.stage.feed.clock_secs(&self.stage.feed.frame()?)));
        let look = &self.options.look;
        let level = self.part.as_ref().map(|part| part.level.clone());
        let heading = match (&look.title, level) {
            (Some(title), Some(level)) => Some(format!("{title}: {level}")),
            (title, level) => title.clone().or(level),
        };
        let banner =
            Banner { title: heading, clock: time.filter(|_| look.clock), scale: look.scale };
        let annotations = Annotations {
            legend,
            plan,
            frame: self.stage.feed.frame(),
            world: self.stage.feed.world().unwrap_or_default(),
            density: self.stage.shown_density(&camera, size),
            robots,
            banner,
            ..self.stage.annotations(&camera, self.title())
        };
        let left_out = self.caption.draw(&self.gpu, &mut encoder, target, &annotations);
        Ok((self.offscreen.read(encoder)?, left_out))
    }
}

/// Returns the width of the strip on the left of a picture that its legend takes, in pixels; 0 if
/// the picture has no room to spare.
fn legend_width(size: UVec2) -> u32 {
    let beside = beside_legend(size.as_vec2() / pixels_per_point(size));
    (beside.low.x * size.x as f32).ceil() as u32
}

/// Returns a message about the parts for which a picture of this size has no room, with the remedy.
fn no_room(size: UVec2, left_out: &[&str]) -> String {
    let advice =
        if left_out.contains(&LEGEND) { ", or hide the legend with --no-legend" } else { "" };
    let names = left_out.join(" and ");
    format!(
        "a picture of {}x{} has no room for its {names}; give a larger --size{advice}",
        size.x, size.y
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_without_room_says_what_to_do() {
        assert_eq!(
            no_room(UVec2::new(320, 200), &["title", "legend"]),
            "a picture of 320x200 has no room for its title and legend; give a larger --size, or \
             hide the legend with --no-legend"
        );
        assert!(!no_room(UVec2::new(320, 200), &["clock"]).contains("--no-legend"));
    }

    #[test]
    fn a_legend_takes_less_than_half_of_the_width() {
        assert_eq!([320, 499].map(|width| legend_width(UVec2::new(width, 400))), [0, 0]);
        for width in [500, 640, 1920] {
            let taken = legend_width(UVec2::new(width, 400));
            assert!(taken > 200 && taken * 9 <= width * 4, "{taken} of {width}");
        }
    }
}
