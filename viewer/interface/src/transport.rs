//! The transport bar at the bottom: pause, step and speed of the engine's clock, and the number of
//! robots.

use std::ops::RangeInclusive;

use egui::{DragValue, RichText, Slider, Ui, vec2};
use regatta_plugin::control::{ControlKind, ControlRequest};

use super::context::{PanelContext, Request};
use super::icons::{self, Icon};
use super::keys::Command;
use super::style;
use super::view_model::Action;

/// The slowest and the fastest speed of the slider; right of the fastest is "as fast as possible".
const SPEEDS: (f32, f32) = (0.1, 100.0);
/// The slider's position for "as fast as possible". Other positions are the common logarithm of the
/// speed.
const UNLIMITED: f32 = 2.3;
/// The least width of the window in which the sliders have names, and lines between them, in
/// points.
const NAMED: f32 = 720.0;
/// The least length of a slider's rail, in points.
const SHORTEST_RAIL: f32 = 40.0;
/// The largest number of robots on the slider.
const MAX_ROBOTS: u32 = 1_000_000;

/// Returns the action that sends a request of this kind to the engine.
fn control(kind: ControlKind) -> Action {
    Action::Control(ControlRequest::new(kind))
}

/// Returns the action that sets the speed.
fn speed(speed: f32) -> Action {
    Action::Control(ControlRequest { speed, ..ControlRequest::new(ControlKind::Speed) })
}

/// Returns the action that sets the number of robots.
fn robots(count: u32) -> Action {
    Action::Control(ControlRequest {
        count: count.into(),
        ..ControlRequest::new(ControlKind::Robots)
    })
}

/// The transport bar: slider values that the engine has not adopted yet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TransportBar {
    speed: Option<f32>,
    robots: Option<u32>,
}

impl TransportBar {
    /// Shows the bar; `shows_past` tells whether the timeline of a live run is shown.
    pub fn show(&mut self, context: &PanelContext<'_>, shows_past: bool, ui: &mut Ui) {
        let is_connected = context.model.status.is_some();
        let room = ui.available_width();
        // Sliders get shorter, and then are numbers only. A recording has one.
        let (sliders, others) =
            if context.model.recording().is_some() { (1.0, 320.0) } else { (2.0, 440.0) };
        let rest = (room - others - if room >= NAMED { 120.0 } else { 0.0 }) / sliders;
        ui.spacing_mut().slider_width = if rest < SHORTEST_RAIL { 0.0 } else { rest.min(130.0) };
        ui.horizontal_centered(|ui| {
            ui.add_enabled_ui(is_connected, |ui| {
                let (icon, name) = if context.model.is_paused() {
                    (Icon::Play, "Resume")
                } else {
                    (Icon::Pause, "Pause")
                };
                let response = icons::button(ui, icon, name, vec2(38.0, 28.0));
                if response.on_hover_text(format!("{name} (Space)")).clicked() {
                    context.ask(Request::Run(Command::Pause));
                }
                if context.model.recording().is_some() {
                    let response = icons::button(ui, Icon::StepBack, "Step back", vec2(32.0, 28.0));
                    if response.on_hover_text("One frame back (,)").clicked() {
                        context.ask(Request::Run(Command::StepBack));
                    }
                }
                if icons::button(ui, Icon::Step, "Step", vec2(32.0, 28.0))
                    .on_hover_text("One tick (.)")
                    .clicked()
                {
                    context.ask(Request::Run(Command::Step));
                }
            });
            ui.add_space(4.0);
            clock(context, ui, room >= NAMED);
            if room >= NAMED {
                ui.separator();
                ui.label(style::faint(ui, "speed"));
            }
            ui.add_enabled_ui(is_connected, |ui| self.speed_slider(context, ui));
            // The number of robots of a recording can't be changed.
            if context.model.recording().is_none() {
                if room >= NAMED {
                    ui.separator();
                    ui.label(style::faint(ui, "robots"));
                }
                ui.add_enabled_ui(is_connected, |ui| self.robots_slider(context, ui));
            }
            if context.model.timeline.is_some_and(|timeline| timeline.live.is_some()) {
                if room >= NAMED {
                    ui.separator();
                }
                let text = "The last ten minutes, while the run goes on (U)";
                let button = egui::Button::selectable(shows_past, "Past");
                if ui.add(button).on_hover_text(text).clicked() {
                    context.ask(Request::Run(Command::Past));
                }
            }
        });
    }

    fn speed_slider(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let reported = context.model.frame.map_or(1.0, |frame| frame.header().speed);
        let mut position = position_of(self.speed.unwrap_or(reported));
        let (range, format) =
            (SPEEDS.0.log10()..=UNLIMITED, |position, _: RangeInclusive<usize>| {
                speed_text(speed_at(position as f32))
            });
        let response = if has_rail(ui) {
            let slider = Slider::new(&mut position, range);
            ui.add(slider.custom_formatter(format).custom_parser(parse_speed))
        } else {
            let number = DragValue::new(&mut position).range(range).speed(0.01);
            ui.add(number.custom_formatter(format).custom_parser(parse_speed))
        };
        let response =
            response.on_hover_text("Requested speed: simulated seconds per second ([ and ])");
        if response.changed() {
            let wanted = speed_at(position);
            self.speed = Some(wanted);
            context.act(speed(wanted));
        } else if !response.dragged() && !response.has_focus() {
            self.speed = None;
        }
    }

    fn robots_slider(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        // If the engine has ended, the last frame gives the number.
        let in_frame = context.model.frame.map_or(0, |frame| frame.len() as u32);
        let reported = context.model.status.map_or(in_frame, |status| status.robots);
        let mut count = self.robots.unwrap_or(reported);
        let range = 1..=MAX_ROBOTS.max(reported);
        let speed = f64::from(count) * 0.01;
        let response = if has_rail(ui) {
            ui.add(Slider::new(&mut count, range).logarithmic(true).smart_aim(true))
        } else {
            ui.add(DragValue::new(&mut count).range(range).speed(speed))
        };
        let response =
            response.on_hover_text("Number of robots, also while the fleet runs (K and I)");
        if response.changed() {
            self.robots = Some(count);
            context.act(robots(count));
        } else if !response.dragged() && !response.has_focus() && self.robots == Some(reported) {
            self.robots = None;
        }
    }
}

fn clock(context: &PanelContext<'_>, ui: &mut Ui, with_speed: bool) {
    let text = context.model.clock_secs().map_or("–".to_owned(), clock_text);
    ui.add_sized(
        [96.0, 24.0],
        egui::Label::new(RichText::new(text).monospace().size(17.0)).extend(),
    );
    if !with_speed {
        return;
    }
    let factor = context
        .model
        .status
        .filter(|_| !context.model.is_paused())
        .map(|status| status.real_time_factor);
    let text = factor.map_or("– ×".to_owned(), |factor| format!("{factor:.2}×"));
    ui.add_sized([50.0, 24.0], egui::Label::new(style::faint(ui, text)).extend())
        .on_hover_text("Measured speed: simulated seconds per second");
}

/// Pauses or resumes; a recording that has ended begins again.
pub(super) fn pause_or_resume(context: &PanelContext<'_>) {
    if !context.model.is_paused() {
        return context.act(control(ControlKind::Pause));
    }
    if let Some(timeline) = context.model.recording()
        && timeline.now.is_some_and(|now| now >= timeline.end)
    {
        let seek = ControlRequest::new(ControlKind::Seek);
        context.act(Action::Control(ControlRequest { count: timeline.start, ..seek }));
    }
    context.act(control(ControlKind::Resume));
}

/// Advances one tick: a running engine is paused first.
pub(super) fn step(context: &PanelContext<'_>) {
    if !context.model.is_paused() {
        context.act(control(ControlKind::Pause));
    }
    let step = ControlRequest::new(ControlKind::Step);
    context.act(Action::Control(ControlRequest { count: 1, ..step }));
}

/// Multiplies the speed by a factor.
pub(super) fn multiply_speed(context: &PanelContext<'_>, factor: f32) {
    let reported = context.model.frame.map_or(1.0, |frame| frame.header().speed);
    context.act(speed(match (reported.is_finite(), factor > 1.0) {
        (false, true) => reported,
        (true, true) if reported >= SPEEDS.1 => f32::INFINITY,
        (true, _) => (reported * factor).clamp(SPEEDS.0, SPEEDS.1),
        (false, false) => SPEEDS.1,
    }));
}

/// Multiplies the number of robots by a factor; it changes by at least one.
pub(super) fn multiply_robots(context: &PanelContext<'_>, factor: f32) {
    if context.model.recording().is_some() {
        return context.notify("the number of robots of a recording can't be changed");
    }
    let reported = context.model.status.map_or(1, |status| status.robots);
    let wanted = (reported as f32 * factor) as u32;
    let least = reported.saturating_sub(1);
    context.act(robots(if factor > 1.0 {
        wanted.max(reported + 1)
    } else {
        wanted.min(least).max(1)
    }));
}

/// Whether there is room for the rails of sliders.
fn has_rail(ui: &Ui) -> bool {
    ui.spacing().slider_width >= SHORTEST_RAIL
}

/// Parses a speed such as `2×`. Returns its position.
fn parse_speed(text: &str) -> Option<f64> {
    let speed = text.trim().trim_end_matches('×').parse().ok()?;
    Some(position_of(speed).into())
}

fn position_of(speed: f32) -> f32 {
    if speed.is_finite() { speed.clamp(SPEEDS.0, SPEEDS.1).log10() } else { UNLIMITED }
}

fn speed_at(position: f32) -> f32 {
    let fastest = SPEEDS.1.log10();
    if position > (fastest + UNLIMITED) / 2.0 {
        return f32::INFINITY;
    }
    // Rounded to two digits, and to 1 near it, so that real time is easy to hit.
    let exact = 10_f32.powf(position.min(fastest));
    let unit = 10_f32.powf(exact.log10().floor() - 1.0);
    let round = (exact / unit).round() * unit;
    if (0.94..1.06).contains(&round) { 1.0 } else { round }
}

fn speed_text(speed: f32) -> String {
    match speed {
        speed if speed.is_infinite() => "max".into(),
        speed if speed < 10.0 => format!("{speed:.2}×"),
        speed => format!("{speed:.0}×"),
    }
}

/// Formats hours, minutes and seconds.
pub fn clock_text(seconds: f64) -> String {
    let (minutes, rest) = ((seconds / 60.0) as u64, seconds % 60.0);
    match minutes / 60 {
        0 => format!("{:02}:{:05.2}", minutes, rest),
        hours => format!("{hours}:{:02}:{:04.1}", minutes % 60, rest),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slider_positions_and_speeds_correspond() {
        for speed in [0.1_f32, 0.5, 1.0, 2.0, 25.0, 100.0, f32::INFINITY] {
            let back = speed_at(position_of(speed));
            assert!(back == speed || (back - speed).abs() < 1e-3 * speed, "{speed} became {back}");
        }
        assert_eq!(speed_text(f32::INFINITY), "max");
    }

    #[test]
    fn clock_times_are_formatted() {
        assert_eq!(clock_text(0.0), "00:00.00");
        assert_eq!(clock_text(83.456), "01:23.46");
        assert_eq!(clock_text(7384.5), "2:03:04.5");
    }
}
