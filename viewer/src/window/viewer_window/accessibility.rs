//! The tree of the interface for screen readers and other assistive programs, by AccessKit.

use std::time::Instant;

use egui_winit::accesskit_winit::{Adapter, Event, WindowEvent};
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};

use super::ViewerWindow;

impl ViewerWindow {
    /// Connects the window to assistive programs, and shows it. It must not have been shown before.
    pub fn appear(&mut self, events: &ActiveEventLoop, proxy: EventLoopProxy<Event>) {
        self.input.init_accesskit(events, &self.window, proxy);
        self.window.set_visible(true);
    }

    /// Takes the connection of the window before its device was lost.
    pub fn set_adapter(&mut self, adapter: Option<Adapter>) {
        self.input.accesskit = adapter;
        // The context is another one, and the tree may have been asked for.
        self.context.enable_accesskit();
    }

    /// Handles what an assistive program wants.
    pub fn handle_assistance(&mut self, event: Event) {
        match event.window_event {
            WindowEvent::InitialTreeRequested => self.context.enable_accesskit(),
            WindowEvent::ActionRequested(request) => {
                self.input.on_accesskit_action_request(request)
            }
            WindowEvent::AccessibilityDeactivated => self.context.disable_accesskit(),
        }
        self.frame_pacing.schedule(Instant::now());
    }
}
