//! What the window's system tells, and when to draw.

use std::sync::Arc;
use std::time::{Duration, Instant};

use regatta_plugin::{Error, Result, Termination};
use winit::application::ApplicationHandler;
use winit::dpi::LogicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::window::{Window, WindowId};

use super::live::{Live, Next, Origin, title};
use crate::interface::Interface;
use crate::interface::rig::{Follow, Rig};
use crate::interface::settings::{self, Settings};
use crate::options::{CameraOption, Options};

/// Devices lost so soon one after the other are not lost by chance.
const LOSSES: (usize, Duration) = (3, Duration::from_secs(20));

/// Longest sleep: Ctrl-C is seen after it.
const PATIENCE: Duration = Duration::from_millis(200);

/// The program with a window.
pub struct App<'a> {
    options: &'a Options,
    termination: Termination,
    instance: wgpu::Instance,
    live: Option<Live>,
    /// When devices were lost.
    losses: Vec<Instant>,
    failure: Option<Error>,
}

impl<'a> App<'a> {
    /// Waits for the display to be ready.
    pub fn new(options: &'a Options, termination: Termination) -> Self {
        let instance = crate::gpu::device::instance();
        Self { options, termination, instance, live: None, losses: Vec::new(), failure: None }
    }

    /// What ended it, if that wasn't a person.
    ///
    /// # Errors
    /// The first thing that failed.
    pub fn finish(self) -> Result {
        self.failure.map_or(Ok(()), Err)
    }

    /// Opens the window and all that draws into it.
    fn open(&self, events: &ActiveEventLoop) -> Result<Live> {
        let path = settings::path();
        let loaded = path.as_deref().map_or(Ok(Settings::default()), Settings::load);
        let (kept, complaint) = match loaded {
            Ok(kept) => (kept, None),
            Err(error) => (Settings::default(), Some(error.to_string())),
        };
        let mut told = kept.clone().with(&self.options.look);
        if let Some(size) = self.options.size {
            told.window = size.0.as_vec2().to_array();
        }
        let [width, height] = told.window;
        let attributes = Window::default_attributes()
            .with_title(title(&self.options.fleet, None))
            .with_inner_size(LogicalSize::new(width, height))
            .with_min_inner_size(LogicalSize::new(320.0, 200.0));
        let window = events.create_window(attributes).map_err(|error| Error::new(format!("no window: {error}")))?;
        let mut interface = Interface::new(told.clone(), self.rig());
        if let Some(complaint) = complaint {
            interface.tell(complaint);
        }
        Live::open(self.options, &self.instance, Arc::new(window), interface, Origin { stored: kept, told })
    }

    /// The camera that the options ask for.
    fn rig(&self) -> Rig {
        let mut rig = match self.options.camera {
            CameraOption::Eye(camera) => Rig::new(camera, true),
            CameraOption::Top => Rig::top_view(),
            CameraOption::Fit => Rig::default(),
        };
        if let Some(robot) = self.options.follow {
            rig.follow(Some((robot, Follow::Behind)));
        }
        rig
    }

    fn draw(&mut self, events: &ActiveEventLoop) {
        let Some(live) = &mut self.live else { return };
        match live.draw() {
            Ok(()) => {}
            Err(error) => return self.fail(events, error),
        }
        if live.wants_to_close() {
            return self.close(events);
        }
        if let Some(reason) = live.lost() {
            self.reopen(events, &reason);
        }
    }

    /// Makes all anew that was made with a device that is lost.
    fn reopen(&mut self, events: &ActiveEventLoop, reason: &str) {
        let (most, within) = LOSSES;
        self.losses.retain(|loss| loss.elapsed() < within);
        self.losses.push(Instant::now());
        let Some(live) = self.live.take() else { return };
        if self.losses.len() > most {
            let text = format!("the graphics device is lost again and again ({reason}); see to its driver");
            return self.fail(events, Error::new(text));
        }
        tracing::warn!("the graphics device was lost ({reason}); opening it again");
        let (window, mut interface, origin) = live.into_parts();
        interface.tell("the graphics device was lost, and opened again");
        match Live::open(self.options, &self.instance, window, interface, origin) {
            Ok(live) => self.live = Some(live),
            Err(error) => self.fail(events, error),
        }
    }

    fn fail(&mut self, events: &ActiveEventLoop, error: Error) {
        self.failure = self.failure.take().or(Some(error));
        self.close(events);
    }

    fn close(&mut self, events: &ActiveEventLoop) {
        if let Some(live) = &mut self.live {
            live.save_settings();
        }
        events.exit();
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.live.is_some() {
            return;
        }
        match self.open(events) {
            Ok(live) => self.live = Some(live),
            Err(error) => self.fail(events, error),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match &event {
            WindowEvent::CloseRequested => return self.close(events),
            WindowEvent::RedrawRequested => return self.draw(events),
            _ => {}
        }
        if let Some(live) = &mut self.live {
            live.take(&event);
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if self.termination.requested() {
            return self.close(events);
        }
        let Some(live) = &mut self.live else { return };
        match live.next(Instant::now()) {
            Ok(Next::Draw) => {
                live.request_redraw();
                // A hidden window may never be asked to draw.
                events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + PATIENCE));
            }
            Ok(Next::LookAt(at)) => events.set_control_flow(ControlFlow::WaitUntil(at)),
            Err(error) => self.fail(events, error),
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The surface goes before the display that it is on.
        self.live = None;
    }
}
