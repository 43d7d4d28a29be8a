//! An open window: the fleet that is read, the device that draws, the interface, and what goes between them.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Rect, ViewportId};
use glam::{UVec2, Vec2};
use regatta_plugin::frame::ClockState;
use regatta_plugin::{FleetName, Participant, Result};
use winit::event::WindowEvent;
use winit::window::{Fullscreen, Window};

use super::furniture::Furniture;
use super::known::Known;
use super::pulse::{Due, Pulse};
use super::surface::{NoCanvas, Screen, surface_of};
use super::udp::Udp;
use crate::feed::News;
use crate::gpu::TargetConfig;
use crate::gpu::device::Gpu;
use crate::gpu::painter::{Drawing, Painter};
use crate::gpu::renderer::Renderer;
use crate::interface::Interface;
use crate::interface::facts::{Action, Engine, Facts, Thing};
use crate::interface::labels::Labels;
use crate::interface::performance::Timing;
use crate::interface::rig::between;
use crate::interface::settings::{self, Settings};
use crate::link::{Link, Report};
use crate::options::{LookOptions, Options};
use crate::scene::Detail;
use crate::stage::Stage;

/// Between two looks at a window that can't be seen.
const HIDDEN: Duration = Duration::from_millis(200);
/// After so long without a frame of a running engine, something is wrong.
const SILENCE: Duration = Duration::from_millis(1500);
/// Settings are written so long after the last change.
const SAVE_AFTER: Duration = Duration::from_secs(2);

/// What to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Draw a picture.
    Draw,
    /// Nothing, and look again then.
    LookAt(Instant),
}

/// Where the settings of a window came from.
#[derive(Debug)]
pub struct Origin {
    /// What was in the file.
    pub stored: Settings,
    /// That, and over it what the command line said.
    pub told: Settings,
}

/// An open window.
pub struct Live {
    // Dropped in this order: what is drawn with goes before what is drawn on.
    painter: Painter,
    stage: Stage,
    screen: Screen,
    gpu: Gpu,
    instance: wgpu::Instance,
    context: egui::Context,
    input: egui_winit::State,
    window: Arc<Window>,
    interface: Interface,
    known: Known,
    link: Link,
    udp: Udp,
    pulse: Pulse,
    timing: Timing,
    look: LookOptions,
    fleet: FleetName,
    hidden: bool,
    closing: bool,
    furniture: Furniture,
    drawn: Instant,
    saved: Settings,
    origin: Origin,
    changed: Option<Instant>,
}

impl Live {
    /// Opens all that draws into a window.
    ///
    /// # Errors
    /// If there is no adapter, or the fleet can't be read.
    pub fn open(
        options: &Options,
        instance: &wgpu::Instance,
        window: Arc<Window>,
        interface: Interface,
        origin: Origin,
    ) -> Result<Self> {
        let surface = surface_of(instance, &window)?;
        let gpu = Gpu::open(instance, Some(&surface))?;
        let screen = Screen::new(surface, &gpu, size_of(&window))?;
        let samples = options.look.samples.unwrap_or(if gpu.is_software() { 1 } else { 4 });
        let mut renderer = Renderer::new(&gpu, TargetConfig::new(&gpu, screen.fleet, samples));
        // What stands for all types is among the settings.
        let mut look = options.look.clone();
        look.mesh.retain(|model| model.robot_type.is_some());
        look.load_meshes(&mut renderer);
        renderer.enable_timer();
        let participant = Participant::join(&options.fleet, "viewer")?;
        let mut scene = options.look.scene();
        if gpu.is_software() {
            scene.detail = Detail::software();
        }
        let stage = Stage::new(&participant, renderer, scene)?;
        let context = egui::Context::default();
        let limit = gpu.device.limits().max_texture_dimension_2d as usize;
        let scale = window.scale_factor() as f32;
        let input = egui_winit::State::new(context.clone(), ViewportId::ROOT, &window, Some(scale), None, Some(limit));
        let rate = window.current_monitor().and_then(|monitor| monitor.refresh_rate_millihertz());
        let adapter = format!("{} ({})", gpu.info.name, gpu.info.backend);
        let now = Instant::now();
        Ok(Self {
            painter: Painter::new(&gpu, screen.interface),
            stage,
            pulse: Pulse::new(rate.map(|rate| f64::from(rate) / 1e3), gpu.is_software(), now),
            screen,
            gpu,
            instance: instance.clone(),
            context,
            input,
            window,
            saved: interface.settings.clone(),
            origin,
            interface,
            known: Known::default(),
            link: Link::open(&options.fleet)?,
            udp: Udp::default(),
            timing: Timing::new(adapter),
            look,
            fleet: options.fleet.clone(),
            hidden: false,
            closing: false,
            furniture: Furniture::default(),
            drawn: now,
            changed: None,
        })
    }

    /// The window, and what a person has chosen: all that outlives a device.
    pub fn into_parts(self) -> (Arc<Window>, Interface, Origin) {
        (self.window, self.interface.undressed(), self.origin)
    }

    /// Takes what the window's system tells.
    pub fn take(&mut self, event: &WindowEvent) {
        match event {
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                self.screen.resize(&self.gpu, size_of(&self.window));
                self.keep_size();
            }
            WindowEvent::Occluded(hidden) => self.hidden = *hidden,
            WindowEvent::DroppedFile(path) => {
                self.interface.take_file(path);
                self.pulse.want(Instant::now());
            }
            _ => {}
        }
        if self.input.on_window_event(&self.window, event).repaint {
            self.pulse.want(Instant::now());
        }
    }

    fn keep_size(&mut self) {
        let size = self.window.inner_size().to_logical::<f32>(self.window.scale_factor());
        let normal = self.window.fullscreen().is_none() && !self.window.is_maximized();
        if normal && size.width > 0.0 && size.height > 0.0 {
            self.interface.settings.window = [size.width, size.height];
        }
    }

    /// Says what to do now.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn next(&mut self, now: Instant) -> Result<Next> {
        if self.hear() {
            self.pulse.want(now);
        }
        if self.hidden || size_of(&self.window).min_element() == 0 {
            return Ok(Next::LookAt(now + HIDDEN));
        }
        if self.stage.feed.has_newer()? {
            self.pulse.stir(now);
        }
        if self.engine(now) == Engine::Silent {
            self.pulse.want(now + Duration::from_secs(1));
        }
        Ok(match self.pulse.due(now) {
            Due::Now => Next::Draw,
            Due::At(at) => Next::LookAt(at),
        })
    }

    /// Asks the window's system for the moment to draw.
    pub fn request_redraw(&self) {
        self.window.request_redraw();
    }

    /// Whether a person asked for the end.
    pub fn wants_to_close(&self) -> bool {
        self.closing
    }

    /// Why the device is gone, if it is.
    pub fn lost(&self) -> Option<String> {
        self.gpu.lost()
    }

    /// Takes what the link has found; whether there is something new to be seen.
    fn hear(&mut self) -> bool {
        let mut seen = false;
        let reports: Vec<_> = self.link.reports().collect();
        for report in reports {
            seen |= match report {
                Report::Notice(text) => {
                    self.interface.tell(text);
                    true
                }
                Report::Routes(routes) => {
                    self.stage.set_routes(routes);
                    true
                }
                Report::Facts(fact) => self.known.take(fact),
            };
        }
        let ended = self.udp.ended();
        seen |= !ended.is_empty();
        ended.into_iter().for_each(|text| self.interface.tell(text));
        seen
    }

    /// Draws a picture of what is newest.
    ///
    /// # Errors
    /// If the fleet can't be read, or the window can't be drawn into.
    pub fn draw(&mut self) -> Result {
        let start = Instant::now();
        self.pulse.draw(start);
        self.interface.settings.apply(&mut self.stage.scene);
        let robots = self.interface.robots();
        self.stage.scene.selected = if robots.is_empty() { self.look.select.clone() } else { robots };
        if self.known.routes_of != self.stage.scene.selected {
            self.known.routes_of.clone_from(&self.stage.scene.selected);
            self.stage.set_routes(Vec::new());
            self.link.routes(self.known.routes_of.clone());
        }
        let news = self.stage.feed.poll()?;
        let read = Instant::now();
        self.stage.apply(news, start)?;
        self.note(news, start);
        let uploaded = Instant::now();
        let (picture, output, actions) = self.show(start);
        let shown = Instant::now();
        self.act(actions, output.pixels_per_point);
        self.plan(&output, start);
        let waited = self.paint(picture, output, start)?;
        let parts = [read - start, uploaded - read, shown.elapsed().saturating_sub(waited), shown - uploaded, waited];
        let period = (start - self.drawn).as_secs_f32();
        self.timing.push(parts.map(|part| part.as_secs_f32()), period.min(1.0));
        self.drawn = start;
        self.keep_settings(start);
        Ok(())
    }

    /// Remembers what a poll has brought.
    fn note(&mut self, news: News, now: Instant) {
        if let Some(world) = self.stage.feed.world().filter(|_| news.world) {
            self.known.labels = Labels::new(world.nodes(), world.edges());
        }
        if self.stage.feed.frame().is_some() {
            let complaints = self.furniture.renew(&self.interface.settings, &mut self.stage);
            complaints.into_iter().for_each(|text| self.interface.tell(text));
        }
        if let Some(frame) = self.stage.feed.frame() {
            let followed = self.interface.rig.followed().map(|(robot, _)| robot);
            self.known.note(&frame, news.frame, followed, self.stage.scene.offset, now);
        }
        if news != News::default() {
            self.pulse.stir(now);
        }
    }

    /// How the producer is.
    fn engine(&self, now: Instant) -> Engine {
        let Some(frame) = self.stage.feed.frame() else { return Engine::Awaited };
        let header = frame.header();
        let gone = header.clock == ClockState::Stopped as u32 || !self.stage.feed.has_producer();
        if gone {
            return Engine::Gone;
        }
        if header.clock == ClockState::Paused as u32 {
            return Engine::Paused;
        }
        let tick = Duration::from_nanos(header.tick_period_nanos).as_secs_f32() / header.speed.max(1e-3);
        let patience = SILENCE.max(Duration::from_secs_f32((3.0 * tick).min(60.0)));
        if self.known.heard.is_none_or(|heard| now.saturating_duration_since(heard) > patience) {
            // One that was killed counts as there until this.
            self.stage.feed.forget_dead();
            return Engine::Silent;
        }
        Engine::Running
    }

    /// Lets the interface show what there is.
    fn show(&mut self, now: Instant) -> (Rect, egui::FullOutput, Vec<Action>) {
        let alpha = self.stage.alpha(now);
        let (engine, legend, world) = (self.engine(now), self.stage.legend(), self.stage.feed.world());
        let facts = Facts {
            fleet: &self.fleet.to_string(),
            engine,
            status: self.known.status.as_deref(),
            frame: self.stage.feed.frame(),
            nodes: world.map_or(&[], |world| world.nodes()),
            edges: world.map_or(&[], |world| world.edges()),
            labels: &self.known.labels,
            types: world.map_or(&[], |world| world.robot_types()),
            kinds: self.stage.feed.robot_type(),
            contacts: self.stage.feed.contacts(),
            legend: &legend,
            columns: &self.known.columns,
            values: &self.known.values,
            route: match self.interface.selected {
                Some(Thing::Robot(id)) => self.stage.remaining(id),
                _ => None,
            },
            rows: self.known.rows.as_ref(),
            bounds: self.stage.bounds(),
            followed: self.known.followed.map(|(_, [from, to])| between(from, to, alpha)),
            timing: &self.timing,
            counts: self.stage.feed.counts(),
            lag: self.known.lag,
            trail_points: self.stage.renderer.trail_points(),
            udp: self.udp.runs(),
        };
        let input = self.input.take_egui_input(&self.window);
        let (mut picture, mut actions, interface) = (Rect::ZERO, Vec::new(), &mut self.interface);
        let output = self.context.run_ui(input, |ui| {
            let (place, asked) = interface.show(ui, &facts);
            picture = place;
            actions.extend(asked);
        });
        (picture, output, actions)
    }

    /// Does what the interface asks for.
    fn act(&mut self, actions: Vec<Action>, pixels_per_point: f32) {
        for action in actions {
            match action {
                Action::Control(request) => self.link.request(request),
                Action::Pick { at, beside } => {
                    let picked = self.stage.renderer.pick(at * pixels_per_point).map(Thing::from);
                    if !beside {
                        self.interface.select(picked);
                    } else if let Some(thing) = picked {
                        self.interface.select_beside(thing);
                    }
                }
                Action::Rows(query) => self.link.rows(query),
                Action::FullScreen => {
                    let full = self.window.fullscreen().is_some();
                    self.window.set_fullscreen((!full).then_some(Fullscreen::Borderless(None)));
                }
                Action::Quit => self.closing = true,
                udp => {
                    let told = self.udp.act(&udp, &self.fleet);
                    told.into_iter().for_each(|text| self.interface.tell(text));
                }
            }
            self.pulse.want(Instant::now());
        }
        if self.known.asked != self.interface.selected {
            self.known.asked = self.interface.selected;
            self.known.values.clear();
            let robot = if let Some(Thing::Robot(id)) = self.known.asked { Some(id) } else { None };
            self.link.robot(robot);
            self.window.set_title(&title(&self.fleet, self.known.asked));
        }
    }

    /// When the interface wants to be drawn again.
    fn plan(&mut self, output: &egui::FullOutput, now: Instant) {
        let delay = output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        if let Some(at) = delay.and_then(|delay| now.checked_add(delay)) {
            self.pulse.want(at);
        }
        // Between two frames everything moves.
        if self.stage.alpha(now) < 1.0 {
            self.pulse.want(now);
        }
    }

    /// Draws fleet and interface. Returns how long it waited for the screen.
    fn paint(&mut self, picture: Rect, mut output: egui::FullOutput, now: Instant) -> Result<Duration> {
        self.input.handle_platform_output(&self.window, std::mem::take(&mut output.platform_output));
        let changes = std::mem::take(&mut output.textures_delta);
        self.painter.upload(&self.gpu, &changes);
        let before = Instant::now();
        let canvas = self.screen.acquire(&self.gpu);
        let mut waited = before.elapsed();
        match canvas {
            Ok(canvas) => {
                let scale = output.pixels_per_point;
                let triangles = self.context.tessellate(std::mem::take(&mut output.shapes), scale);
                let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let (at, size) = pixels(picture, scale, canvas.size);
                let (camera, alpha) = (self.interface.rig.camera(), self.stage.alpha(now));
                self.stage.draw_within(&mut encoder, &canvas.fleet, Some((at, canvas.size)), &camera, size, alpha);
                let drawing = Drawing { triangles, pixels_per_point: scale, size: canvas.size };
                self.painter.draw(&self.gpu, &mut encoder, &canvas.interface, &drawing);
                self.gpu.queue.submit([encoder.finish()]);
                let before = Instant::now();
                canvas.present(&self.gpu);
                waited += before.elapsed();
                if let Some(seconds) = self.stage.renderer.poll_gpu_seconds() {
                    self.timing.push_gpu(seconds as f32);
                }
            }
            Err(NoCanvas::Hidden) => {}
            Err(NoCanvas::Later) => self.pulse.want(now + Duration::from_millis(5)),
            Err(NoCanvas::Lost) => self.renew_surface()?,
        }
        self.painter.free(changes);
        Ok(waited)
    }

    /// Makes another surface in place of one that is lost.
    fn renew_surface(&mut self) -> Result {
        tracing::info!("the window's surface was lost; making another");
        if self.gpu.lost().is_none() {
            let surface = surface_of(&self.instance, &self.window)?;
            self.screen = Screen::new(surface, &self.gpu, size_of(&self.window))?;
        }
        self.pulse.want(Instant::now());
        Ok(())
    }

    fn keep_settings(&mut self, now: Instant) {
        if self.interface.settings == self.saved {
            self.changed = None;
        } else if now.saturating_duration_since(*self.changed.get_or_insert(now)) > SAVE_AFTER {
            self.save_settings();
        }
    }

    /// Writes the settings if they have changed.
    pub fn save_settings(&mut self) {
        if self.interface.settings == self.saved {
            return;
        }
        self.saved = self.interface.settings.clone();
        self.changed = None;
        let kept = self.saved.kept(&self.origin.told, &self.origin.stored);
        if let Some(Err(error)) = settings::path().map(|path| kept.save(&path)) {
            tracing::warn!("{error}");
            self.interface.tell(error.to_string());
        }
    }
}

fn size_of(window: &Window) -> UVec2 {
    let size = window.inner_size();
    UVec2::new(size.width, size.height)
}

/// Where the picture is on the canvas, and how large: at least a pixel, and all of it there.
fn pixels(picture: Rect, scale: f32, canvas: UVec2) -> (UVec2, UVec2) {
    let corner = |at: egui::Pos2| (Vec2::new(at.x, at.y) * scale).round().max(Vec2::ZERO).as_uvec2();
    let low = corner(picture.min).min(canvas - 1);
    let high = corner(picture.max).min(canvas).max(low + 1);
    (low, high - low)
}

/// What the window is called: its fleet, and what is selected.
pub fn title(fleet: &FleetName, selected: Option<Thing>) -> String {
    match selected {
        Some(Thing::Robot(id)) => format!("Regatta: {fleet}, robot {id}"),
        _ => format!("Regatta: {fleet}"),
    }
}
