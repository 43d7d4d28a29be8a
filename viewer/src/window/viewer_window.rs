//! An open window: the fleet that is read, the device that draws, the interface, and the data flow
//! between them.

mod accessibility;
mod paint;
mod show;

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ViewportId;
use glam::{UVec2, Vec2};
use regatta_gpu::TargetConfig;
use regatta_gpu::copy::Insets;
use regatta_gpu::device::Gpu;
use regatta_gpu::painter::Painter;
use regatta_gpu::renderer::Renderer;
use regatta_interface::Interface;
use regatta_interface::labels::{Labels, levels};
use regatta_interface::performance::{PictureTime, Timing};
use regatta_interface::robot_filter::{Filter, Matches};
use regatta_interface::view_model::{EngineState, Item};
use regatta_plugin::{FleetName, Participant, Result};
use regatta_scene::Detail;
use winit::event::WindowEvent;
use winit::window::Window;

use super::assets::{Assets, Unloadable};
use super::file_dialog::FileDialog;
use super::fleet_state::FleetState;
use super::frame_pacing::{Due, FramePacing};
use super::opened::OpenedFiles;
use super::picture_request::PictureRequest;
use super::settings_store::{SettingsError, SettingsStore};
use super::surface::{WindowSurface, create_surface};
use super::udp::UdpProcesses;
use crate::feed::News;
use crate::frame_history::FrameHistory;
use crate::jams::JamQuery;
use crate::link::{Link, Report};
use crate::options::{LookOptions, Options};
use crate::plans::PlanQuery;
use crate::stage::Stage;

/// The time between two checks of a hidden window.
const HIDDEN_INTERVAL: Duration = Duration::from_millis(200);
/// The time between two looks for the answer of an open file dialog.
const DIALOG_INTERVAL: Duration = Duration::from_millis(100);

/// The next step of the event loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Draw a picture.
    Draw,
    /// Do nothing until then.
    WaitUntil(Instant),
}

/// An open window of the viewer.
pub struct ViewerWindow {
    // Fields are dropped in this order, so renderers precede their surfaces.
    painter: Painter,
    /// The pictures of levels beside the scene's.
    insets: Insets,
    stage: Stage,
    target: TargetConfig,
    surface: WindowSurface,
    gpu: Gpu,
    instance: wgpu::Instance,
    context: egui::Context,
    input: egui_winit::State,
    window: Arc<Window>,
    interface: Interface,
    fleet_state: FleetState,
    link: Link,
    udp: UdpProcesses,
    opened: OpenedFiles,
    file_dialog: FileDialog,
    frame_pacing: FramePacing,
    timing: Timing,
    look: LookOptions,
    fleet: FleetName,
    /// The name of the file or the fleet that is shown.
    name: String,
    /// Width and height of the window, in pixels.
    size: UVec2,
    /// The file that was opened with this window.
    recording: Option<std::path::PathBuf>,
    is_hidden: bool,
    /// The picture that is to be written to a file instead of the screen.
    picture_request: PictureRequest,
    /// The message about the last picture that was written, which isn't to be in the next one.
    picture_message: Option<String>,
    is_closing: bool,
    assets: Assets,
    drawn_at: Instant,
    settings_store: SettingsStore,
}

/// The parts of a window that outlive its device.
pub struct Kept {
    /// The window.
    pub window: Arc<Window>,
    /// The interface.
    pub interface: Interface,
    /// The settings.
    pub settings_store: SettingsStore,
    /// The connection to assistive programs.
    pub adapter: Option<egui_winit::accesskit_winit::Adapter>,
}

impl ViewerWindow {
    /// Creates everything that draws into a window.
    ///
    /// # Errors
    /// If there is no adapter or the fleet can't be read.
    pub fn open(
        options: &Options,
        instance: &wgpu::Instance,
        window: Arc<Window>,
        interface: Interface,
        settings_store: SettingsStore,
    ) -> Result<Self> {
        let surface = create_surface(instance, &window)?;
        let gpu = Gpu::open(instance, Some(&surface))?;
        let surface = WindowSurface::new(surface, &gpu, size_of(&window))?;
        let samples = options.look.samples.unwrap_or(if gpu.is_software() { 1 } else { 4 });
        let target = TargetConfig::new(&gpu, surface.fleet_format, samples);
        let mut renderer = Renderer::new(&gpu, target);
        // The mesh for all robot types is among the settings.
        let mut look = options.look.clone();
        look.mesh.retain(|model| model.robot_type.is_some());
        look.load_meshes(&mut renderer);
        renderer.enable_timer();
        let participant = Participant::join(&options.fleet, "viewer")?;
        let mut scene = options.look.scene();
        if gpu.is_software() {
            scene.detail = Detail::software();
        }
        let mut stage = Stage::new(&participant, renderer, scene)?;
        stage.history = options.recording.is_none().then(FrameHistory::default);
        let context = egui::Context::default();
        let limit = gpu.device.limits().max_texture_dimension_2d as usize;
        let scale = window.scale_factor() as f32;
        let input = egui_winit::State::new(
            context.clone(),
            ViewportId::ROOT,
            &window,
            Some(scale),
            None,
            Some(limit),
        );
        let rate = window.current_monitor().and_then(|monitor| monitor.refresh_rate_millihertz());
        let adapter = format!("{} ({})", gpu.info.name, gpu.info.backend);
        let (now, size) = (Instant::now(), size_of(&window));
        Ok(Self {
            size,
            painter: Painter::new(&gpu, surface.interface_format),
            insets: Insets::new(&gpu, surface.fleet_format),
            stage,
            target,
            frame_pacing: FramePacing::new(
                rate.map(|rate| f64::from(rate) / 1e3),
                gpu.is_software(),
                now,
            ),
            surface,
            gpu,
            instance: instance.clone(),
            context,
            input,
            window,
            settings_store,
            interface,
            fleet_state: FleetState::default(),
            link: Link::open(&options.fleet)?,
            udp: UdpProcesses::default(),
            opened: OpenedFiles::default(),
            file_dialog: FileDialog::default(),
            timing: Timing::new(adapter),
            look,
            fleet: options.fleet.clone(),
            name: options.name(),
            recording: options.recording.clone(),
            is_hidden: false,
            picture_request: PictureRequest::default(),
            picture_message: None,
            is_closing: false,
            assets: Assets::default(),
            drawn_at: now,
        })
    }

    /// Returns the parts that outlive the device.
    pub fn into_parts(self) -> Kept {
        Kept {
            window: self.window,
            interface: self.interface.for_new_context(),
            settings_store: self.settings_store,
            adapter: self.input.accesskit,
        }
    }

    /// Handles an event of the window.
    pub fn handle_event(&mut self, event: &WindowEvent) {
        match event {
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                self.size = size_of(&self.window);
                self.surface.resize(&self.gpu, self.size);
                self.record_size();
            }
            WindowEvent::Occluded(is_hidden) => self.is_hidden = *is_hidden,
            WindowEvent::DroppedFile(path) => {
                self.open_file(path);
                self.frame_pacing.schedule(Instant::now());
            }
            _ => {}
        }
        if self.input.on_window_event(&self.window, event).repaint {
            self.frame_pacing.schedule(Instant::now());
        }
    }

    /// Opens a file in a window of its own, or takes it for the look of this one.
    fn open_file(&mut self, path: &std::path::Path) {
        match self.opened.open(path) {
            Some(message) => self.interface.notify(message),
            None => self.interface.use_file(path),
        }
    }

    fn record_size(&mut self) {
        let size = self.window.inner_size().to_logical::<f32>(self.window.scale_factor());
        let normal = self.window.fullscreen().is_none() && !self.window.is_maximized();
        if normal && size.width > 0.0 && size.height > 0.0 {
            self.interface.settings.window = Vec2::new(size.width, size.height);
        }
    }

    /// Receives news, and returns the next step of the event loop.
    ///
    /// # Errors
    /// If the fleet can't be read.
    pub fn next(&mut self, now: Instant) -> Result<Next> {
        if self.receive_reports() {
            self.frame_pacing.schedule(now);
        }
        if self.is_hidden || self.size.min_element() == 0 {
            return Ok(Next::WaitUntil(now + HIDDEN_INTERVAL));
        }
        if self.stage.feed.has_newer()? {
            self.frame_pacing.keep_drawing(now);
        }
        // Marks arrive while a replay stands, too.
        if self
            .stage
            .feed
            .recording()
            .is_some_and(|recording| recording.header.searched_nanos != u64::MAX)
        {
            self.frame_pacing.schedule(now + Duration::from_millis(250));
        }
        if self.file_dialog.is_open() {
            self.frame_pacing.schedule(now + DIALOG_INTERVAL);
        }
        if self.engine_state(now) == EngineState::Silent {
            self.frame_pacing.schedule(now + Duration::from_secs(1));
        }
        Ok(match self.frame_pacing.due(now) {
            Due::Now => Next::Draw,
            Due::At(at) => Next::WaitUntil(at),
        })
    }

    /// Asks the display for the size of the window, which panics if the display has gone.
    #[cfg(target_os = "linux")]
    pub fn ask_display(&self) {
        let _ = self.window.inner_size();
    }

    /// Requests a redraw event.
    pub fn request_redraw(&self) {
        self.window.request_redraw();
    }

    /// Whether the user has asked to close the window.
    pub fn is_closing(&self) -> bool {
        self.is_closing
    }

    /// Returns why the device was lost, if it was.
    pub fn device_loss(&self) -> Option<String> {
        self.gpu.lost()
    }

    /// Receives the reports of the link and of UDP processes. Returns whether there is something
    /// new to show.
    fn receive_reports(&mut self) -> bool {
        let mut has_news = false;
        let reports: Vec<_> = self.link.reports().collect();
        for report in reports {
            has_news |= match report {
                Report::Notice(text) => {
                    self.interface.notify(text);
                    true
                }
                Report::Refused(command, text) => {
                    let now = self.stage.frame().map_or(0, |frame| frame.header().sim_time_nanos);
                    self.interface.tell_refusal(command, text, now);
                    true
                }
                Report::Routes(routes) => {
                    self.stage.set_routes(routes);
                    true
                }
                Report::Holder(robot) => {
                    self.interface.show_robot(robot);
                    true
                }
                Report::Plans(plans) => {
                    self.stage.set_plans(*plans);
                    true
                }
                Report::Jams(jams) => self.stage.set_jams(*jams),
                Report::Log(log) => {
                    self.interface.log().take(*log);
                    true
                }
                Report::Matches(filter, matches) => self.set_matches(&filter, matches),
                Report::Facts(fact) => self.fleet_state.apply(fact),
            };
        }
        has_news |= self.receive_file();
        let ended = [self.udp.remove_ended(), self.opened.remove_ended()].concat();
        has_news |= !ended.is_empty();
        for text in ended {
            self.interface.notify(text);
        }
        has_news
    }

    /// Opens the file that was chosen in the dialog. Returns whether the dialog has answered.
    fn receive_file(&mut self) -> bool {
        match self.file_dialog.answer() {
            Some(Ok(path)) => self.open_file(&path),
            Some(Err(message)) => self.interface.notify(message),
            None => return false,
        }
        true
    }

    /// Sets the robots that match a filter. Returns whether the filter is among those requested
    /// last.
    fn set_matches(&mut self, filter: &Filter, matches: Matches) -> bool {
        if *filter == self.fleet_state.filter {
            self.stage.set_matches(&matches);
            self.fleet_state.matches = Some(matches);
            return true;
        }
        let beside = filter.level.as_ref().filter(|_| filter.is_like(&self.fleet_state.filter));
        beside.is_some_and(|level| self.stage.set_matches_beside(level, &matches))
    }

    /// Shows levels side by side, or no longer.
    fn show_beside(&mut self) {
        let levels: Vec<_> = self.interface.levels_beside().collect();
        let has_changed = self.stage.show_beside(&levels, || {
            let mut renderer = Renderer::new(&self.gpu, self.target);
            self.look.load_meshes(&mut renderer);
            renderer
        });
        if has_changed {
            // The new renderers have neither the picture on the floor nor the mesh of the settings.
            self.assets = Assets::default();
        }
    }

    /// Draws a picture of the newest state.
    ///
    /// # Errors
    /// If the fleet can't be read, the window can't be drawn into, or the graphics memory is full.
    pub fn draw(&mut self) -> Result {
        let start = Instant::now();
        self.frame_pacing.record_draw(start);
        self.take_choices();
        self.stage.colouring = self.interface.settings.colouring();
        let is_other_level = self.stage.scene.level.as_deref() != self.interface.level();
        if is_other_level {
            self.stage.scene.level = self.interface.level().map(str::to_owned);
        }
        if self.fleet_state.routes_of != self.stage.scene.selected {
            self.fleet_state.routes_of.clone_from(&self.stage.scene.selected);
            self.stage.set_routes(Vec::new());
            self.link.routes(self.fleet_state.routes_of.clone());
        }
        let watch = PlanQuery { matching: self.fleet_state.matching(), ..self.stage.plan_query() };
        if self.fleet_state.plan_query != watch {
            self.fleet_state.plan_query.clone_from(&watch);
            self.link.plans(watch);
        }
        let (edges, node) = self.interface.watched_places();
        let jams = JamQuery { history: true, edges, node, ..self.stage.jam_query() };
        if self.fleet_state.jam_query != jams {
            self.fleet_state.jam_query.clone_from(&jams);
            self.link.jams(jams);
        }
        let news = self.stage.feed.poll()?;
        let read = Instant::now();
        self.stage.apply(news, start)?;
        self.show_beside();
        self.update_state(News { world: news.world || is_other_level, ..news }, start);
        let uploaded = Instant::now();
        let (picture, output, actions) = self.show(start);
        let shown = Instant::now();
        self.carry_out(actions, output.pixels_per_point);
        // Keys and clicks have changed what the panels of this picture show.
        self.take_choices();
        self.schedule(&output, start);
        let waited = self.paint(picture, output, start)?;
        self.gpu.check_memory()?;
        self.timing.push(PictureTime {
            period: (start - self.drawn_at).min(Duration::from_secs(1)),
            reading: read - start,
            uploads: uploaded - read,
            encoding: shown.elapsed().saturating_sub(waited),
            interface: shown - uploaded,
            waiting: waited,
        });
        self.drawn_at = start;
        let saved = self.settings_store.save_later(&self.interface.settings, start);
        self.report_unsaved(saved);
        Ok(())
    }

    /// Takes the user's choices of look and selection for the scene.
    fn take_choices(&mut self) {
        self.interface.settings.apply(&mut self.stage.scene);
        self.stage.scene.marked = self.interface.marked();
        let robots = self.interface.robots();
        self.stage.scene.selected =
            if robots.is_empty() { self.look.select.clone() } else { robots };
    }

    /// Updates the state by the news of a poll.
    fn update_state(&mut self, news: News, now: Instant) {
        if let Some(world) = self.stage.feed.world().filter(|_| news.world) {
            self.fleet_state.labels = Labels::new(&world, self.stage.scene.level.as_deref());
            self.interface.set_levels(levels(&world));
        }
        if self.stage.feed.frame().is_some() {
            for Unloadable { file, message } in
                self.assets.update(&mut self.interface.settings, &mut self.stage)
            {
                tracing::warn!("{message}");
                self.interface.notify(message);
                self.settings_store.forget(&file);
            }
        }
        if let Some(frame) = self.stage.frame() {
            let followed = self.interface.camera_controller.followed().map(|(robot, _)| robot);
            self.fleet_state.record_frame(
                &frame,
                news.frame,
                followed,
                self.stage.scene.offset,
                now,
            );
        }
        if news != News::default() {
            self.frame_pacing.keep_drawing(now);
        }
    }

    /// Writes the settings if they have changed.
    pub fn save_settings(&mut self) {
        let saved = self.settings_store.save(&self.interface.settings);
        self.report_unsaved(saved);
    }

    fn report_unsaved(&mut self, saved: Result<(), SettingsError>) {
        if let Err(error) = saved {
            tracing::warn!("{error}");
            self.interface.notify(error.to_string());
        }
    }
}

fn size_of(window: &Window) -> UVec2 {
    let size = window.inner_size();
    UVec2::new(size.width, size.height)
}

/// Returns the title of the window: the shown source, and the selected robot.
pub fn title(fleet: &str, selected: Option<Item>) -> String {
    match selected {
        Some(Item::Robot(id)) => format!("Regatta: {fleet}, robot {id}"),
        _ => format!("Regatta: {fleet}"),
    }
}
