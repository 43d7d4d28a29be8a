//! The transport bar at the bottom: pause, step and speed of the engine's clock, and the number of
//! robots.

use std::ops::RangeInclusive;

use egui::{DragValue, RichText, Slider, Ui, vec2};
use regatta_plugin::control::{ControlKind, ControlRequest};

use super::icons::{self, Icon};
use super::state::Interface;
use super::style;
use super::view_model::{Action, ViewModel};

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

impl Interface {
    pub(super) fn transport(
        &mut self,
        ui: &mut Ui,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let theme = self.settings.theme();
        let is_connected = model.status.is_some();
        let room = ui.available_width();
        // Sliders get shorter, and then are numbers only. A recording has one.
        let (sliders, others) =
            if model.recording().is_some() { (1.0, 320.0) } else { (2.0, 440.0) };
        let rest = (room - others - if room >= NAMED { 120.0 } else { 0.0 }) / sliders;
        ui.spacing_mut().slider_width = if rest < SHORTEST_RAIL { 0.0 } else { rest.min(130.0) };
        ui.horizontal_centered(|ui| {
            ui.add_enabled_ui(is_connected, |ui| {
                let (icon, name) =
                    if model.is_paused() { (Icon::Play, "Resume") } else { (Icon::Pause, "Pause") };
                let response = icons::button(ui, icon, name, vec2(38.0, 28.0));
                if response.on_hover_text(format!("{name} (Space)")).clicked() {
                    actions.extend(self.pause_or_resume(model));
                }
                if model.recording().is_some() {
                    let response = icons::button(ui, Icon::StepBack, "Step back", vec2(32.0, 28.0));
                    if response.on_hover_text("One frame back (,)").clicked() {
                        self.step_back(model, actions);
                    }
                }
                if icons::button(ui, Icon::Step, "Step", vec2(32.0, 28.0))
                    .on_hover_text("One tick (.)")
                    .clicked()
                {
                    actions.extend(self.step(model));
                }
            });
            ui.add_space(4.0);
            self.clock(ui, model, room >= NAMED);
            if room >= NAMED {
                ui.separator();
                ui.label(style::faint(ui, theme, "speed"));
            }
            ui.add_enabled_ui(is_connected, |ui| self.speed_slider(ui, model, actions));
            // The robots of a recording are what they were.
            if model.recording().is_none() {
                if room >= NAMED {
                    ui.separator();
                    ui.label(style::faint(ui, theme, "robots"));
                }
                ui.add_enabled_ui(is_connected, |ui| self.robots_slider(ui, model, actions));
            }
            if model.timeline.is_some_and(|timeline| timeline.live.is_some()) {
                if room >= NAMED {
                    ui.separator();
                }
                let text = "The last ten minutes, while the run goes on (U)";
                let button = egui::Button::selectable(self.timeline.shows_past, "Past");
                if ui.add(button).on_hover_text(text).clicked() {
                    self.toggle_past(actions);
                }
            }
        });
    }

    fn clock(&self, ui: &mut Ui, model: &ViewModel<'_>, with_speed: bool) {
        let text = model.clock_secs().map_or("–".to_owned(), clock_text);
        ui.add_sized(
            [96.0, 24.0],
            egui::Label::new(RichText::new(text).monospace().size(17.0)).extend(),
        );
        if !with_speed {
            return;
        }
        let factor =
            model.status.filter(|_| !model.is_paused()).map(|status| status.real_time_factor);
        let text = factor.map_or("– ×".to_owned(), |factor| format!("{factor:.2}×"));
        ui.add_sized(
            [50.0, 24.0],
            egui::Label::new(style::faint(ui, self.settings.theme(), text)).extend(),
        )
        .on_hover_text("Measured speed: simulated seconds per second");
    }

    fn speed_slider(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let reported = model.frame.map_or(1.0, |frame| frame.header().speed);
        let mut position = position_of(self.sliders.speed.unwrap_or(reported));
        let (range, format) =
            (SPEEDS.0.log10()..=UNLIMITED, |position, _: RangeInclusive<usize>| {
                speed_text(speed_at(position as f32))
            });
        let parse = |text: &str| {
            text.trim()
                .trim_end_matches('×')
                .parse()
                .ok()
                .map(|speed: f32| f64::from(position_of(speed)))
        };
        let response = if has_rail(ui) {
            ui.add(Slider::new(&mut position, range).custom_formatter(format).custom_parser(parse))
        } else {
            let number = DragValue::new(&mut position).range(range).speed(0.01);
            ui.add(number.custom_formatter(format).custom_parser(parse))
        };
        let response =
            response.on_hover_text("Requested speed: simulated seconds per second ([ and ])");
        if response.changed() {
            let wanted = speed_at(position);
            self.sliders.speed = Some(wanted);
            actions.push(speed(wanted));
        } else if !response.dragged() && !response.has_focus() {
            self.sliders.speed = None;
        }
    }

    fn robots_slider(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        // Of an engine that has ended, the last frame tells.
        let in_frame = || model.frame.map_or(0, |frame| frame.len() as u32);
        let reported = model.status.map_or_else(in_frame, |status| status.robots);
        let mut count = self.sliders.robots.unwrap_or(reported);
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
            self.sliders.robots = Some(count);
            actions.push(robots(count));
        } else if !response.dragged()
            && !response.has_focus()
            && self.sliders.robots == Some(reported)
        {
            self.sliders.robots = None;
        }
    }

    /// Returns the requests that pause or resume; at the end of a recording, it begins again.
    pub(super) fn pause_or_resume(&self, model: &ViewModel<'_>) -> Vec<Action> {
        if !model.is_paused() {
            return vec![control(ControlKind::Pause)];
        }
        let ended = model
            .recording()
            .filter(|timeline| timeline.now.is_some_and(|now| now >= timeline.end));
        let again = ended.map(|timeline| {
            Action::Control(ControlRequest {
                count: timeline.start,
                ..ControlRequest::new(ControlKind::Seek)
            })
        });
        again.into_iter().chain([control(ControlKind::Resume)]).collect()
    }

    /// Returns the requests that advance one tick: a running engine is paused first.
    pub(super) fn step(&self, model: &ViewModel<'_>) -> Vec<Action> {
        let pause = (!model.is_paused()).then(|| control(ControlKind::Pause));
        let step =
            Action::Control(ControlRequest { count: 1, ..ControlRequest::new(ControlKind::Step) });
        pause.into_iter().chain([step]).collect()
    }

    /// Returns the action that multiplies the speed by a factor.
    pub(super) fn times_speed(&self, model: &ViewModel<'_>, factor: f32) -> Action {
        let reported = model.frame.map_or(1.0, |frame| frame.header().speed);
        speed(match (reported.is_finite(), factor > 1.0) {
            (false, true) => reported,
            (true, true) if reported >= SPEEDS.1 => f32::INFINITY,
            (true, _) => (reported * factor).clamp(SPEEDS.0, SPEEDS.1),
            (false, false) => SPEEDS.1,
        })
    }

    /// Returns the action that multiplies the number of robots by a factor; it changes by at least
    /// one.
    pub(super) fn times_robots(&mut self, model: &ViewModel<'_>, factor: f32) -> Option<Action> {
        if model.recording().is_some() {
            self.notify("a recording has the robots that it has");
            return None;
        }
        let reported = model.status.map_or(1, |status| status.robots);
        let wanted = (reported as f32 * factor) as u32;
        let least = reported.saturating_sub(1);
        Some(robots(if factor > 1.0 { wanted.max(reported + 1) } else { wanted.min(least).max(1) }))
    }
}

/// Whether there is room for the rails of sliders, and not only for their numbers.
fn has_rail(ui: &Ui) -> bool {
    ui.spacing().slider_width >= SHORTEST_RAIL
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
