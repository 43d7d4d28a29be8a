//! The exchange with the interface: the shown data, and the returned actions.

use std::time::{Duration, Instant};

use egui::{Rect, ViewportId};
use glam::{UVec2, Vec2};
use regatta_interface::measure::End;
use regatta_interface::pose::interpolate;
use regatta_interface::robot_filter::Matches;
use regatta_interface::view_model::{Action, EngineState, Item, ViewModel};
use regatta_plugin::FleetName;
use regatta_plugin::frame::ClockState;
use winit::window::Fullscreen;

use super::{ViewerWindow, size_of, title};
use crate::notes;
use crate::stage::Stage;

/// The time without a frame after which a running engine is considered silent.
const MAX_SILENCE: Duration = Duration::from_millis(1500);

/// Returns the name of a file for what is shown. Characters of the level's name that aren't letters
/// or digits may not be allowed in it.
fn file_name(stage: &Stage, fleet: &FleetName, ending: &str) -> String {
    let seconds = stage.frame().map_or(0.0, |frame| stage.feed.clock_secs(&frame));
    let level = stage.scene.level.iter().map(|level| format!("-{level}")).collect::<String>();
    let level = level.replace(|letter: char| !letter.is_alphanumeric(), "-");
    format!("regatta-{fleet}{level}-{seconds:.2}s.{ending}")
}

impl ViewerWindow {
    /// Returns the state of the engine.
    pub(super) fn engine_state(&self, now: Instant) -> EngineState {
        if let Some(driven) = self.stage.feed.warm_up().filter(|_| self.stage.feed.has_producer()) {
            return EngineState::WarmingUp(driven);
        }
        let Some(frame) = self.stage.feed.frame() else { return EngineState::Awaited };
        let header = frame.header();
        if header.clock == ClockState::Stopped as u32 || !self.stage.feed.has_producer() {
            return EngineState::Gone;
        }
        if header.clock == ClockState::Paused as u32 {
            return EngineState::Paused;
        }
        let tick =
            Duration::from_nanos(header.tick_period_nanos).as_secs_f32() / header.speed.max(1e-3);
        let max_silence = MAX_SILENCE.max(Duration::from_secs_f32((3.0 * tick).min(60.0)));
        let last_frame = self.fleet_state.last_frame_at;
        if last_frame.is_none_or(|last| now.saturating_duration_since(last) > max_silence) {
            // A killed engine counts as present until its remains are removed.
            self.stage.feed.forget_dead();
            return EngineState::Silent;
        }
        EngineState::Running
    }

    /// Runs the interface for one picture. Returns where the picture of the fleet is, egui's
    /// output, and the actions.
    pub(super) fn show(&mut self, now: Instant) -> (Rect, egui::FullOutput, Vec<Action>) {
        let alpha = self.stage.alpha(now);
        let (engine, legend, world) =
            (self.engine_state(now), self.stage.legend(), self.stage.feed.world());
        let model = ViewModel {
            fleet: &self.fleet.to_string(),
            engine,
            status: self.fleet_state.status.as_deref(),
            frame: self.stage.frame(),
            world: world.unwrap_or_default(),
            labels: &self.fleet_state.labels,
            robot_type_column: self.stage.feed.robot_type(),
            activity_column: self.stage.activities(),
            contacts: self.stage.feed.contacts(),
            legend: &legend,
            columns: &self.fleet_state.columns,
            values: &self.fleet_state.values,
            order: self.fleet_state.order,
            named_order: self.fleet_state.named_order.as_ref(),
            work: self.fleet_state.work,
            route: match self.interface.selection.item {
                Some(Item::Robot(id)) => self.stage.remaining(id),
                _ => None,
            },
            plans: self.stage.plan_facts(),
            closed: self.stage.closed(),
            jams: self.stage.jam_facts(),
            density: self
                .stage
                .shown_density(&self.interface.camera_controller.camera(), self.picture_size()),
            rows: self.fleet_state.rows.as_ref(),
            matches: self.fleet_state.matches.as_ref(),
            bounds: self.stage.bounds(),
            followed: self.fleet_state.followed.map(|(_, [from, to])| interpolate(from, to, alpha)),
            timing: &self.timing,
            counts: self.stage.feed.counts(),
            lag: self.fleet_state.lag,
            trail_points: self.stage.renderer.trail_points(),
            udp: self.udp.running(),
            timeline: self.stage.timeline(),
        };
        let input = self.input.take_egui_input(&self.window);
        let (mut picture, mut actions, interface) = (Rect::ZERO, Vec::new(), &mut self.interface);
        let output = self.context.run_ui(input, |ui| {
            let (place, requested) = interface.show(ui, &model);
            picture = place;
            actions.extend(requested);
        });
        (picture, output, actions)
    }

    /// Width and height of the picture of a level in pixels, if known from the last picture.
    fn picture_size(&self) -> UVec2 {
        let size = self.stage.renderer.drawn_size().as_uvec2();
        if size == UVec2::ONE { size_of(&self.window) } else { size }
    }

    /// Carries out actions, and requests the values of a newly selected robot.
    pub(super) fn carry_out(&mut self, actions: Vec<Action>, pixels_per_point: f32) {
        for action in actions {
            match action {
                Action::Control(request) => self.link.request(request),
                Action::Pick { at, extend } => {
                    let picked = self.stage.renderer.pick(at * pixels_per_point);
                    if !extend {
                        self.interface.select(picked);
                    } else if let Some(item) = picked {
                        self.interface.toggle_selected(item);
                    }
                }
                Action::Menu { at, window } => {
                    let item = self.stage.renderer.pick(at * pixels_per_point);
                    self.interface.open_menu(item, egui::pos2(window.x, window.y));
                }
                Action::Command(command) => self.link.command(command),
                Action::FindOrder(name) => self.link.find_order(name),
                Action::LookBack(time) => self.stage.look_back(time),
                Action::WriteSvg => self.write_svg(),
                Action::Open => self.file_dialog.open(&self.window),
                Action::WritePicture => self.ask_for_picture(),
                Action::Note { time, text } => self.write_note(time, &text),
                Action::Measure { at } => self.measure(at, pixels_per_point),
                Action::Rows(query) => self.link.rows(query),
                Action::Filter(filter) => {
                    // Those that match the filter before are kept until it is known which match
                    // this one.
                    if filter.is_empty() {
                        self.stage.set_matches(&Matches::default());
                        self.fleet_state.matches = None;
                    }
                    self.fleet_state.filter.clone_from(&filter);
                    let beside = self.interface.levels_beside();
                    let beside: Vec<_> = beside.map(|level| filter.of_level(Some(level))).collect();
                    self.link.filters([vec![filter], beside].concat());
                }
                Action::Write { path, text } => {
                    let written = std::fs::write(&path, text);
                    self.interface.notify(match written {
                        Ok(()) => format!("written: {}", path.display()),
                        Err(error) => format!("can't write {}: {error}", path.display()),
                    });
                }
                Action::FullScreen => {
                    let full = self.window.fullscreen().is_some();
                    self.window.set_fullscreen((!full).then_some(Fullscreen::Borderless(None)));
                }
                Action::Quit => self.is_closing = true,
                udp => {
                    if let Some(text) = self.udp.carry_out(&udp, &self.fleet) {
                        self.interface.notify(text);
                    }
                }
            }
            self.frame_pacing.schedule(Instant::now());
        }
        let selected = self.interface.selection.item;
        if self.fleet_state.values_of != selected {
            self.fleet_state.values_of = selected;
            self.fleet_state.values.clear();
            self.fleet_state.order = None;
            self.fleet_state.named_order = None;
            self.link.robot(if let Some(Item::Robot(id)) = selected { Some(id) } else { None });
            self.window.set_title(&title(&self.name, selected));
        }
    }

    /// Asks for a picture, in which the message about the one before is not to be seen.
    fn ask_for_picture(&mut self) {
        self.picture_request.ask(Instant::now());
        if let Some(message) = self.picture_message.take() {
            self.interface.dismiss(&message);
        }
    }

    /// The name of a file for what is shown.
    pub(super) fn file_name(&self, ending: &str) -> String {
        file_name(&self.stage, &self.fleet, ending)
    }

    /// Writes a plan of the shown time and level into the current folder, and shows its path.
    fn write_svg(&mut self) {
        let path = self.file_name("svg");
        let written = self.stage.svg(&self.name, self.stage.scene.theme, None);
        let written = written.map_err(|error| error.to_string());
        let written = written.and_then(|text| {
            std::fs::write(&path, text).map_err(|error| format!("{path}: {error}"))
        });
        self.interface
            .notify(written.map_or_else(|error| error, |()| format!("the plan is in {path}")));
    }

    /// Writes a note into the file beside the recording, which the replay reads again.
    fn write_note(&mut self, time: u64, text: &str) {
        self.interface.notify(match &self.recording {
            None => "the recording's file isn't known here; open it with: regatta viewer FILE"
                .to_owned(),
            Some(recording) => match notes::append(recording, time, text) {
                Ok(()) => format!("the note was saved in {}", notes::file_of(recording).display()),
                Err(error) => {
                    format!("can't write {}: {error}", notes::file_of(recording).display())
                }
            },
        });
    }

    /// Takes the robot or the place at a point of the picture as an end of the measured distance.
    fn measure(&mut self, at: Vec2, pixels_per_point: f32) {
        let end = match self.stage.renderer.pick(at * pixels_per_point) {
            Some(Item::Robot(id)) => Some(End::Robot(id)),
            _ => {
                let size = self.stage.renderer.drawn_size() / pixels_per_point;
                self.interface.camera_controller.camera().unproject(at, size).map(End::Place)
            }
        };
        if let Some(end) = end {
            self.interface.measure_to(end);
        }
    }

    /// Schedules the next picture: when the interface asks for it, or at once while robots move
    /// between two frames.
    pub(super) fn schedule(&mut self, output: &egui::FullOutput, now: Instant) {
        let delay =
            output.viewport_output.get(&ViewportId::ROOT).map(|viewport| viewport.repaint_delay);
        if let Some(at) = delay.and_then(|delay| now.checked_add(delay)) {
            self.frame_pacing.schedule(at);
        }
        if self.stage.alpha(now) < 1.0 || self.picture_request.is_pending() {
            self.frame_pacing.schedule(now);
        }
    }
}
