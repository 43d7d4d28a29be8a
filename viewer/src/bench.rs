//! `--bench`: how fast pictures are drawn, of fleets made up here or of a running one.

use std::time::{Duration, Instant};

use glam::Vec2;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, NO_EDGE, frame_lines, stride_lines};
use regatta_plugin::world::{EdgeRecord, NodeRecord};
use regatta_plugin::{Frame, Participant, Result, Termination};

use crate::camera::{Bounds, Camera};
use crate::gpu::TargetKind;
use crate::gpu::device::Gpu;
use crate::gpu::frame::{Picture, Renderer};
use crate::options::Options;
use crate::palette::{Colouring, Theme};
use crate::picture::{FORMAT, Offscreen};
use crate::scene::{Detail, Scene};
use crate::stage::Stage;

/// Longest time for one line of the table, and fewest and most pictures.
const TIME: Duration = Duration::from_secs(5);
const PICTURES: (usize, usize) = (10, 600);
/// Pictures before the first that counts: shaders are compiled, buffers made.
const WARM_UP: usize = 3;
/// Metres between two robots of a made-up fleet.
const SPACING: f32 = 2.4;

/// Seconds that the parts of one picture took.
#[derive(Clone, Copy, Debug, Default)]
struct Times {
    read: f64,
    upload: f64,
    encode: f64,
    whole: f64,
    /// Of all threads, where the system says.
    busy: f64,
    gpu: Option<f64>,
}

/// Prints a table.
///
/// # Errors
/// If there is no adapter, or the fleet can't be read.
pub fn run(options: &Options) -> Result {
    let termination = Termination::watch()?;
    let gpu = Gpu::offscreen()?;
    let samples = options.look.samples.unwrap_or(if gpu.is_software() { 1 } else { 4 });
    let bench = Bench { options, offscreen: Offscreen::new(&gpu, options.picture_size())?, gpu, samples, termination };
    let (info, size) = (&bench.gpu.info, options.picture_size());
    println!(
        "adapter: {} ({}, {:?}), {} samples, {}x{}",
        info.name, info.driver_info, info.backend, samples, size.x, size.y
    );
    println!("medians in ms; whole: from reading to the finished picture; busy: processor time of all threads (mean)");
    println!(
        "   robots  fleet     view   read  upload  encode |    CPU |     GPU |   whole |    busy | frames/s | resident MB"
    );
    for robots in &options.bench {
        for view in ["fit", "near"] {
            if *robots == 0 { bench.live(view)? } else { bench.made_up(*robots as usize, view) }
        }
    }
    Ok(())
}

struct Bench<'a> {
    options: &'a Options,
    gpu: Gpu,
    samples: u32,
    offscreen: Offscreen,
    termination: Termination,
}

impl Bench<'_> {
    fn renderer(&self) -> Renderer {
        let mut renderer = Renderer::new(&self.gpu, TargetKind::new(&self.gpu, FORMAT, self.samples));
        renderer.time();
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
            "fit" => self.options.camera.camera(bounds, self.options.picture_size()),
            _ => Camera::fit(Bounds { low: bounds.centre() - 12.0, high: bounds.centre() + 12.0 }, aspect),
        }
    }

    fn made_up(&self, robots: usize, view: &str) {
        let fleet = MadeUp::new(robots);
        let mut renderer = self.renderer();
        let (nodes, edges) = fleet.graph();
        renderer.set_graph(&nodes, &edges);
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
            let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let picture = Picture { camera: &camera, scene: &scene, legend: &legend, size, within: None, alpha: 0.5 };
            renderer.draw(&mut encoder, &self.offscreen.view, &picture);
            self.gpu.queue.submit([encoder.finish()]);
            times.encode = start.elapsed().as_secs_f64() - times.upload;
            times.gpu = renderer.gpu_seconds();
        });
        print_line(robots, "made up", view, &times);
    }

    fn live(&self, view: &str) -> Result {
        let participant = Participant::join(&self.options.fleet, "viewer")?;
        let mut stage = Stage::new(&participant, self.renderer(), self.scene())?;
        while stage.feed.frame().is_none() || stage.feed.world().is_none() {
            if self.termination.requested() {
                return Ok(());
            }
            stage.update(Instant::now())?;
            std::thread::sleep(Duration::from_millis(5));
        }
        let camera = self.camera(view, stage.bounds());
        let mut failed = None;
        let times = self.measure(|times| {
            let start = Instant::now();
            match stage.feed.poll() {
                Ok(news) => {
                    times.read = start.elapsed().as_secs_f64();
                    failed = stage.apply(news, start).err();
                }
                Err(error) => failed = Some(error.into()),
            }
            let uploaded = start.elapsed().as_secs_f64();
            times.upload = uploaded - times.read;
            let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let (size, alpha) = (self.offscreen.size(), stage.alpha(start));
            stage.draw(&mut encoder, &self.offscreen.view, &camera, size, alpha);
            self.gpu.queue.submit([encoder.finish()]);
            times.encode = start.elapsed().as_secs_f64() - uploaded;
            times.gpu = stage.renderer.gpu_seconds();
        });
        print_line(stage.feed.frame().map_or(0, |frame| frame.len()), "live", view, &times);
        failed.map_or(Ok(()), Err)
    }

    /// Draws pictures one after the other. Each is finished before the next is begun.
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
        all.iter_mut().for_each(|times| times.busy = busy);
        all
    }
}

fn print_line(robots: usize, fleet: &str, view: &str, times: &[Times]) {
    let median = |part: &dyn Fn(&Times) -> f64| {
        let mut values: Vec<_> = times.iter().map(part).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN) * 1e3
    };
    let cpu = median(&|times| times.read + times.upload + times.encode);
    let whole = median(&|times| times.whole);
    let gpu = match times.first().and_then(|times| times.gpu) {
        Some(_) => format!("{:7.2}", median(&|times| times.gpu.unwrap_or(f64::NAN))),
        None => "unknown".to_owned(),
    };
    println!(
        "{robots:9}  {fleet:8} {view:>5} {:6.3}  {:6.3}  {:6.3} | {cpu:6.3} | {gpu} | {whole:7.2} | {:7.2} | {:8.1} | {:11}",
        median(&|times| times.read),
        median(&|times| times.upload),
        median(&|times| times.encode),
        median(&|times| times.busy),
        1e3 / whole,
        resident_megabytes().map_or("unknown".to_owned(), |megabytes| format!("{megabytes:.0}")),
    );
}

/// Of this process; `None` where the system doesn't say.
fn resident_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

/// Processor time of this process so far, to a hundredth of a second; not a number where the system doesn't say.
fn busy_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name in brackets may hold spaces.
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace().skip(11).take(2);
    let ticks = fields.map(|field| field.parse::<f64>().unwrap_or(f64::NAN)).reduce(|user, system| user + system);
    ticks.map_or(f64::NAN, |ticks| ticks / 100.0)
}

/// A fleet that drives along straight lanes.
struct MadeUp {
    robots: usize,
    frames: [(FrameHeader, Vec<Line>); 2],
}

impl MadeUp {
    fn new(robots: usize) -> Self {
        let frames = [0.0, 0.05].map(|step| {
            let mut lines = vec![Line::default(); frame_lines(robots)];
            let columns = ColumnsMut::split(&mut lines, robots);
            for i in 0..robots {
                let (lane, place) = (i / side(robots), i % side(robots));
                columns.x[i] = place as f32 * SPACING + step;
                columns.y[i] = lane as f32 * SPACING;
                columns.theta[i] = if lane % 2 == 0 { 0.0 } else { std::f32::consts::PI };
                columns.speed[i] = (i % 21) as f32 * 0.1;
                columns.edge[i] = NO_EDGE;
                columns.state[i] = 1;
            }
            let (robots, stride_lines) = (robots as u32, stride_lines(robots) as u32);
            (FrameHeader { run_id: 1, robots, stride_lines, ..FrameHeader::default() }, lines)
        });
        Self { robots, frames }
    }

    fn bounds(&self) -> Bounds {
        Bounds { low: Vec2::ZERO, high: Vec2::splat(side(self.robots) as f32 * SPACING) }
    }

    /// An edge for ten robots, at most 100,000.
    fn graph(&self) -> (Vec<NodeRecord>, Vec<EdgeRecord>) {
        let (side, long) = (side(self.robots) as f32 * SPACING, 10.0 * SPACING);
        let across = (side / long).ceil().max(1.0) as u32;
        let lanes = (side / SPACING).ceil() as u32;
        let mut nodes = Vec::new();
        let mut edges = Vec::new();
        for i in 0..(across * lanes).min(100_000) {
            let (x, y) = ((i % across) as f32 * long, (i / across) as f32 * SPACING);
            let at = |part: f32| [x + part * long, y];
            nodes.push(NodeRecord { id: i, x, y, theta: 0.0 });
            edges.push(EdgeRecord {
                id: i,
                origin: i,
                destination: i,
                length: long,
                control_points: [at(0.0), at(0.3), at(0.7), at(1.0)],
                velocity_forward: 1.0,
                ..EdgeRecord::default()
            });
        }
        (nodes, edges)
    }

    fn frame(&self, number: usize) -> Frame<'_> {
        let (header, lines) = &self.frames[number % 2];
        Frame::new(header, lines).expect("as many lines as the robots need")
    }
}

fn side(robots: usize) -> usize {
    (robots as f64).sqrt().ceil() as usize
}
