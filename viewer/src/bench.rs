//! `--bench`: measures the rendering speed with synthetic fleets or with a running one.

mod synthetic;

use std::time::{Duration, Instant};

use regatta_gpu::TargetConfig;
use regatta_gpu::device::Gpu;
use regatta_gpu::renderer::{Picture, Renderer};
use regatta_interface::text::with_plural;
use regatta_plugin::{Participant, Result, Termination, World};
use regatta_scene::camera::{Bounds, Camera, Window};
use regatta_scene::heat::{Heat, HeatMap};
use regatta_scene::palette::{Colouring, Theme};
use regatta_scene::{Detail, Scene};

use crate::jams::JamQuery;
use crate::options::Options;
use crate::picture::{FORMAT, Offscreen};
use crate::plans::PlanQuery;
use crate::stage::Stage;
use crate::worker::Inbox;
use synthetic::SyntheticFleet;

/// The time limit of a measurement, after the least number of pictures.
const TIME: Duration = Duration::from_secs(5);
/// The least and the greatest number of pictures of a measurement.
const PICTURES: (usize, usize) = (10, 600);
/// The number of heat maps that are worked out to measure it.
const HEAT_MAPS: usize = 15;
/// The angle in radians by which the camera of the view `turn` turns with each picture. The view
/// measures pictures while the user moves the camera, so that the ground has to be drawn.
const TURN: f32 = 1e-3;
/// Unmeasured pictures at the start, while shaders are compiled and buffers are created.
const WARM_UP: usize = 3;

/// The times of one picture, in seconds.
#[derive(Clone, Copy, Debug, Default)]
struct Times {
    read: f64,
    upload: f64,
    encode: f64,
    whole: f64,
    /// CPU time of all threads, where the system reports it.
    busy: f64,
    gpu: Option<f64>,
}

/// Prints a table of measurements.
///
/// # Errors
/// If there is no graphics adapter, or the fleet can't be read.
pub fn run(options: &Options) -> Result {
    let termination = Termination::watch()?;
    let gpu = Gpu::offscreen()?;
    let samples = options.look.samples.unwrap_or(if gpu.is_software() { 1 } else { 4 });
    let target = TargetConfig::new(&gpu, FORMAT, samples);
    let bench = Bench {
        options,
        offscreen: Offscreen::new(&gpu, options.picture_size(), target)?,
        gpu,
        target,
        termination,
    };
    let (info, size) = (&bench.gpu.info, options.picture_size());
    println!(
        "adapter: {} ({}, {:?}), {}, {}x{}",
        info.name,
        info.driver_info,
        info.backend,
        with_plural(samples.into(), "sample"),
        size.x,
        size.y
    );
    println!(
        "medians in ms; whole: from reading to the finished picture; busy: CPU time of all threads \
         (mean)"
    );
    println!(
        "   robots  fleet      view   read  upload  encode |    CPU |     GPU |   whole |    busy \
         | frames/s | resident MB"
    );
    for robots in &options.bench {
        for view in ["fit", "near", "turn"] {
            if *robots == 0 {
                bench.live(view)?
            } else {
                bench.synthetic(*robots as usize, view)
            }
            bench.gpu.check_memory()?;
        }
    }
    Ok(())
}

struct Bench<'a> {
    options: &'a Options,
    gpu: Gpu,
    target: TargetConfig,
    offscreen: Offscreen,
    termination: Termination,
}

impl Bench<'_> {
    fn renderer(&self) -> Renderer {
        let mut renderer = Renderer::new(&self.gpu, self.target);
        renderer.enable_timer();
        renderer
    }

    fn scene(&self) -> Scene {
        let mut scene = self.options.look.scene();
        if self.gpu.is_software() {
            scene.detail = Detail::software();
        }
        scene
    }

    fn camera(&self, view: &str, bounds: Bounds) -> Camera {
        let aspect = self.options.picture_size().x as f32 / self.options.picture_size().y as f32;
        match view {
            "fit" | "turn" => self.options.camera.camera(bounds, Window::whole(aspect)),
            _ => Camera::fit(
                Bounds { low: bounds.centre() - 12.0, high: bounds.centre() + 12.0 },
                aspect,
            ),
        }
    }

    /// The camera of a picture, by its number.
    fn turned(camera: Camera, view: &str, number: u64) -> Camera {
        let angle = if view == "turn" { number as f32 * TURN } else { 0.0 };
        Camera { yaw: camera.yaw + angle, ..camera }
    }

    fn synthetic(&self, robots: usize, view: &str) {
        let fleet = SyntheticFleet::new(robots);
        let mut renderer = self.renderer();
        let graph = fleet.graph();
        renderer.set_graph(&graph.view(1, 1));
        let heat = self.scene().heat.map(|heat| heat_map(heat, &graph.view(1, 1), &mut renderer));
        let scene = Scene { colouring: Colouring::Speed, ..self.scene() };
        let legend = scene.colouring.legend(Theme::Dark, &[], Some((0.0, 2.0)));
        let camera = self.camera(view, fleet.bounds());
        let size = self.offscreen.size();
        let mut number = 0;
        let times = self.measure(|times| {
            number += 1;
            let start = Instant::now();
            let frame = fleet.frame(number);
            renderer.push_frame(&frame);
            renderer.set_values(Some(frame.speed()));
            times.upload = start.elapsed().as_secs_f64();
            let mut encoder = self.gpu.encoder();
            let camera = &Self::turned(camera, view, number as u64);
            let picture =
                Picture { camera, scene: &scene, legend: &legend, size, within: None, alpha: 0.5 };
            renderer.draw(&mut encoder, &self.offscreen.view, &picture);
            self.gpu.queue.submit([encoder.finish()]);
            times.encode = start.elapsed().as_secs_f64() - times.upload;
            times.gpu = renderer.gpu_seconds();
        });
        print_row(robots, "synthetic", view, &times);
        if let Some((edges, [work, upload])) = heat.filter(|_| view == "fit") {
            println!(
                "           heat map of {}: {work:.2} ms on its own thread, then {upload:.2} ms of \
                 a picture",
                with_plural(edges as u64, "edge")
            );
        }
    }

    fn live(&self, view: &str) -> Result {
        let participant = Participant::join(&self.options.fleet, "viewer")?;
        let mut stage = Stage::new(&participant, self.renderer(), self.scene())?;
        stage.colouring.clone_from(&self.options.look.colour);
        while stage.feed.frame().is_none() || stage.feed.world().is_none() {
            if self.termination.requested() {
                return Ok(());
            }
            stage.update(Instant::now())?;
            std::thread::sleep(Duration::from_millis(5));
        }
        let camera = self.camera(view, stage.bounds());
        let plans = Inbox::open(&self.options.fleet, stage.plan_query())?;
        let jams = Inbox::open(&self.options.fleet, stage.jam_query())?;
        let (mut failed, mut number) = (None, 0);
        let times = self.measure(|times| {
            let start = Instant::now();
            match stage.feed.poll() {
                Ok(news) => {
                    times.read = start.elapsed().as_secs_f64();
                    failed = stage.apply(news, start).err();
                }
                Err(error) => failed = Some(error.into()),
            }
            if let Err(error) = take_answers(&mut stage, plans.as_ref(), jams.as_ref()) {
                failed = Some(error);
            }
            let uploaded = start.elapsed().as_secs_f64();
            times.upload = uploaded - times.read;
            let mut encoder = self.gpu.encoder();
            let (size, alpha) = (self.offscreen.size(), stage.alpha(start));
            number += 1;
            stage.draw(
                &mut encoder,
                &self.offscreen.view,
                &Self::turned(camera, view, number),
                size,
                alpha,
            );
            self.gpu.queue.submit([encoder.finish()]);
            times.encode = start.elapsed().as_secs_f64() - uploaded;
            times.gpu = stage.renderer.gpu_seconds();
        });
        print_row(stage.feed.frame().map_or(0, |frame| frame.len()), "live", view, &times);
        failed.map_or(Ok(()), Err)
    }

    /// Draws pictures one after the other; each is finished before the next one starts.
    fn measure(&self, mut draw: impl FnMut(&mut Times)) -> Vec<Times> {
        let mut all = Vec::new();
        for _ in 0..WARM_UP {
            draw(&mut Times::default());
            self.gpu.wait();
        }
        let (started, busy) = (Instant::now(), busy_seconds());
        while !self.termination.requested()
            && all.len() < PICTURES.1
            && (all.len() < PICTURES.0 || started.elapsed() < TIME)
        {
            let (start, mut times) = (Instant::now(), Times::default());
            draw(&mut times);
            self.gpu.wait();
            times.whole = start.elapsed().as_secs_f64();
            all.push(times);
        }
        let busy = (busy_seconds() - busy) / all.len() as f64;
        for times in &mut all {
            times.busy = busy;
        }
        all
    }
}

/// Uploads the answers that have come since the last picture.
fn take_answers(
    stage: &mut Stage,
    plans: Option<&Inbox<PlanQuery>>,
    jams: Option<&Inbox<JamQuery>>,
) -> Result {
    if let Some(found) = plans.map(Inbox::newest).transpose()?.flatten() {
        stage.set_plans(found);
    }
    for found in jams.map(Inbox::take).transpose()?.unwrap_or_default() {
        stage.set_jams(found);
    }
    Ok(())
}

/// Works a heat map out and uploads it. Returns the number of its edges, and the median times in
/// milliseconds of either.
fn heat_map(heat: Heat, world: &World<'_>, renderer: &mut Renderer) -> (u32, [f64; 2]) {
    let traffic = synthetic::traffic(world);
    let (mut edges, mut times) = (0, [(); 2].map(|()| Vec::new()));
    for _ in 0..HEAT_MAPS {
        let start = Instant::now();
        let map = HeatMap::new(heat, &traffic.view(), world);
        let done = Instant::now();
        renderer.set_heat(Some(&map));
        edges = map.facts.edges;
        times[0].push((done - start).as_secs_f64());
        times[1].push(done.elapsed().as_secs_f64());
    }
    (edges, times.map(median))
}

/// Returns the median of times in seconds, in milliseconds.
fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN) * 1e3
}

/// Returns the median of a part of times in milliseconds. The part is in seconds.
fn median_of(times: &[Times], part: impl Fn(&Times) -> f64) -> f64 {
    median(times.iter().map(part).collect())
}

fn print_row(robots: usize, fleet: &str, view: &str, times: &[Times]) {
    let cpu = median_of(times, |times| times.read + times.upload + times.encode);
    let whole = median_of(times, |times| times.whole);
    let gpu = match times.first().and_then(|times| times.gpu) {
        Some(_) => format!("{:7.2}", median_of(times, |times| times.gpu.unwrap_or(f64::NAN))),
        None => "unknown".to_owned(),
    };
    println!(
        "{robots:9}  {fleet:9} {view:>5} {:6.3}  {:6.3}  {:6.3} | {cpu:6.3} | {gpu} | {whole:7.2} \
         | {:7.2} | {:8.1} | {:11}",
        median_of(times, |times| times.read),
        median_of(times, |times| times.upload),
        median_of(times, |times| times.encode),
        median_of(times, |times| times.busy),
        1e3 / whole,
        resident_megabytes().map_or("unknown".to_owned(), |megabytes| format!("{megabytes:.0}")),
    );
}

/// Returns the resident memory of this process; `None` where the system doesn't report it.
fn resident_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

/// Returns the CPU time of this process in seconds, with a resolution of 10 ms; NaN where the
/// system doesn't report it.
fn busy_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The process name, in parentheses, may contain spaces.
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    let ticks = fields
        .map(|field| field.parse::<f64>().unwrap_or(f64::NAN))
        .reduce(|user, system| user + system);
    ticks.map_or(f64::NAN, |ticks| ticks / 100.0)
}
