//! The application: it handles the events of the windowing system and decides when to draw.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui_winit::accesskit_winit;
use regatta_interface::Interface;
use regatta_interface::camera_controller::{CameraController, Follow};
use regatta_interface::cameras::CameraOption;
use regatta_plugin::{Error, Result, Termination};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

use super::settings_store::SettingsStore;
use super::viewer_window::{Kept, Next, ViewerWindow, title};
use crate::options::Options;

/// The number of lost devices within a time that is tolerated.
const MAX_LOSSES: (usize, Duration) = (3, Duration::from_secs(20));

/// The longest sleep, after which Ctrl-C is noticed.
const MAX_SLEEP: Duration = Duration::from_millis(200);

/// The application with its window.
pub struct App<'a> {
    options: &'a Options,
    termination: Termination,
    /// Takes what assistive programs want to the event loop.
    proxy: EventLoopProxy<accesskit_winit::Event>,
    instance: wgpu::Instance,
    viewer: Option<ViewerWindow>,
    /// The times at which devices were lost.
    losses: Vec<Instant>,
    failure: Option<Error>,
    /// The time at which there is something to do without an event.
    wakes_at: Instant,
    /// Whether a picture was drawn since the last check for events. Drawing may read events, in
    /// which case the loop doesn't wait.
    has_drawn: bool,
}

impl<'a> App<'a> {
    /// Creates the application; the window opens when the display is ready.
    pub fn new(
        options: &'a Options,
        termination: Termination,
        proxy: EventLoopProxy<accesskit_winit::Event>,
    ) -> Self {
        let instance = regatta_gpu::device::instance();
        Self {
            options,
            termination,
            proxy,
            instance,
            viewer: None,
            losses: Vec::new(),
            failure: None,
            wakes_at: Instant::now(),
            has_drawn: false,
        }
    }

    /// Returns the outcome after the event loop has ended.
    ///
    /// # Errors
    /// The first failure.
    pub fn finish(self) -> Result {
        self.failure.map_or(Ok(()), Err)
    }

    /// The time at which there is something to do without an event.
    #[cfg(target_os = "linux")]
    pub fn wakes_at(&self) -> Instant {
        self.wakes_at
    }

    /// Asks the display for something, which panics if it has gone.
    #[cfg(target_os = "linux")]
    pub fn ask_display(&self) {
        if let Some(viewer) = &self.viewer {
            viewer.ask_display();
        }
    }

    /// Drops everything that depended on a display that has gone.
    #[cfg(target_os = "linux")]
    pub fn abandon(&mut self) {
        if let Some(mut viewer) = self.viewer.take() {
            viewer.save_settings();
        }
    }

    /// Opens the window and everything that draws into it.
    fn open(&self, events: &ActiveEventLoop) -> Result<ViewerWindow> {
        let (settings_store, error) = SettingsStore::load(self.options);
        let size = settings_store.initial().window;
        let attributes = Window::default_attributes()
            .with_title(title(&self.options.name(), None))
            .with_inner_size(LogicalSize::new(size.x, size.y))
            .with_min_inner_size(LogicalSize::new(320.0, 200.0))
            // It is shown once it is connected to assistive programs.
            .with_visible(false);
        let window = events
            .create_window(attributes)
            .map_err(|error| Error::new(format!("can't open a window: {error}")))?;
        let controller = self.camera_controller(self.options.requested_camera()?);
        let mut interface = Interface::new(settings_store.initial().clone(), controller);
        interface.bookmarks.clone_from(&self.options.bookmark);
        interface.show_level(self.options.look.level.clone());
        interface.show_side_by_side(self.options.levels);
        if let Some(error) = error {
            interface.notify(error.to_string());
        }
        ViewerWindow::open(
            self.options,
            &self.instance,
            Arc::new(window),
            interface,
            settings_store,
        )
    }

    /// Returns the camera that the options request.
    fn camera_controller(&self, view: CameraOption) -> CameraController {
        let mut controller = match view {
            CameraOption::Eye(camera) => CameraController::new(camera, true),
            CameraOption::Top => CameraController::top_view(),
            CameraOption::Plan => CameraController::plan(),
            CameraOption::Fit | CameraOption::Named(_) => CameraController::default(),
        };
        if let Some(robot) = self.options.follow {
            controller.follow(Some((robot, Follow::Behind)));
        }
        controller
    }

    fn draw(&mut self, events: &ActiveEventLoop) {
        let Some(viewer) = &mut self.viewer else { return };
        self.has_drawn = true;
        if let Err(error) = viewer.draw() {
            return self.fail(events, error);
        }
        if viewer.is_closing() {
            return self.close(events);
        }
        if let Some(reason) = viewer.device_loss() {
            self.reopen(events, &reason);
        }
    }

    /// Recreates everything that depended on a lost device.
    fn reopen(&mut self, events: &ActiveEventLoop, reason: &str) {
        let (most, within) = MAX_LOSSES;
        self.losses.retain(|loss| loss.elapsed() < within);
        self.losses.push(Instant::now());
        let Some(viewer) = self.viewer.take() else { return };
        if self.losses.len() > most {
            let text =
                format!("the graphics device was lost repeatedly ({reason}); check its driver");
            return self.fail(events, Error::new(text));
        }
        tracing::warn!("the graphics device was lost ({reason}); opening it again");
        let Kept { window, mut interface, settings_store, adapter } = viewer.into_parts();
        interface.notify("the graphics device was lost and opened again");
        match ViewerWindow::open(self.options, &self.instance, window, interface, settings_store) {
            Ok(mut viewer) => {
                viewer.set_adapter(adapter);
                self.viewer = Some(viewer);
            }
            Err(error) => self.fail(events, error),
        }
    }

    fn fail(&mut self, events: &ActiveEventLoop, error: Error) {
        self.failure = self.failure.take().or(Some(error));
        self.close(events);
    }

    fn close(&mut self, events: &ActiveEventLoop) {
        if let Some(viewer) = &mut self.viewer {
            viewer.save_settings();
        }
        events.exit();
    }
}

impl ApplicationHandler<accesskit_winit::Event> for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.viewer.is_some() {
            return;
        }
        match self.open(events) {
            Ok(mut viewer) => {
                viewer.appear(events, self.proxy.clone());
                self.viewer = Some(viewer);
            }
            Err(error) => self.fail(events, error),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, event: accesskit_winit::Event) {
        if let Some(viewer) = &mut self.viewer {
            viewer.handle_assistance(event);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match &event {
            WindowEvent::CloseRequested => return self.close(events),
            WindowEvent::RedrawRequested => return self.draw(events),
            _ => {}
        }
        if let Some(viewer) = &mut self.viewer {
            viewer.handle_event(&event);
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if self.termination.requested() {
            return self.close(events);
        }
        let Some(viewer) = &mut self.viewer else { return };
        let wakes_at = match viewer.next(Instant::now()) {
            Ok(Next::Draw) => {
                viewer.request_redraw();
                // A hidden window may never receive a redraw event.
                Instant::now() + MAX_SLEEP
            }
            Ok(Next::WaitUntil(at)) => at,
            Err(error) => return self.fail(events, error),
        };
        events.set_control_flow(ControlFlow::WaitUntil(wakes_at));
        self.wakes_at = if self.has_drawn { Instant::now() } else { wakes_at };
        self.has_drawn = false;
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The surface must be dropped before its display.
        self.viewer = None;
    }
}
