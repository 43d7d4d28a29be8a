//! The engine's clock and the number of robots: the bar at the bottom.

use egui::{RichText, Slider, Ui, vec2};
use regatta_plugin::control::{ControlKind, ControlRequest};

use super::Interface;
use super::facts::{Action, Facts};
use super::icons::{self, Icon};
use super::style;

/// Slowest and fastest factor of the slider; right of the fastest is "as fast as possible".
const SPEEDS: (f32, f32) = (0.1, 100.0);
/// Place of "as fast as possible" on the slider, which counts in powers of ten.
const MAX: f32 = 2.3;
/// Most robots that the slider gives.
const MOST_ROBOTS: u32 = 1_000_000;

/// What a person is about to choose, until the engine has it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drafts {
    speed: Option<f32>,
    robots: Option<u32>,
}

/// A request of the engine.
pub fn control(kind: ControlKind) -> Action {
    Action::Control(ControlRequest::new(kind))
}

/// Another speed.
pub fn speed(speed: f32) -> Action {
    Action::Control(ControlRequest { speed, ..ControlRequest::new(ControlKind::Speed) })
}

/// Another number of robots.
pub fn robots(count: u32) -> Action {
    Action::Control(ControlRequest { count: count.into(), ..ControlRequest::new(ControlKind::Robots) })
}

impl Interface {
    pub(super) fn transport(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let theme = self.settings.theme();
        let alive = facts.status.is_some();
        ui.horizontal_centered(|ui| {
            ui.add_enabled_ui(alive, |ui| {
                let (icon, name) = if facts.is_paused() { (Icon::Play, "Resume") } else { (Icon::Pause, "Pause") };
                let response = icons::button(ui, icon, name, vec2(38.0, 28.0));
                if response.on_hover_text(format!("{name} (Space)")).clicked() {
                    actions.push(self.pause_or_resume(facts));
                }
                if icons::button(ui, Icon::Step, "Step", vec2(32.0, 28.0)).on_hover_text("One tick (.)").clicked() {
                    actions.extend(self.step(facts));
                }
            });
            ui.add_space(4.0);
            self.clock(ui, facts);
            ui.separator();
            ui.label(style::faint(ui, theme, "speed"));
            ui.add_enabled_ui(alive, |ui| self.speed_slider(ui, facts, actions));
            ui.separator();
            ui.label(style::faint(ui, theme, "robots"));
            ui.add_enabled_ui(alive, |ui| self.robots_slider(ui, facts, actions));
        });
    }

    fn clock(&self, ui: &mut Ui, facts: &Facts<'_>) {
        let time = facts.frame.map(|frame| frame.sim_time().as_secs_f64());
        let text = time.map_or("–".to_owned(), clock_text);
        ui.add_sized([96.0, 24.0], egui::Label::new(RichText::new(text).monospace().size(17.0)));
        let factor = facts.status.filter(|_| !facts.is_paused()).map(|status| status.real_time_factor);
        let text = factor.map_or("– ×".to_owned(), |factor| format!("{factor:.2}×"));
        ui.add_sized([50.0, 24.0], egui::Label::new(style::faint(ui, self.settings.theme(), text)))
            .on_hover_text("simulated seconds per second, as reached");
    }

    fn speed_slider(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let told = facts.frame.map_or(1.0, |frame| frame.header().speed);
        let mut place = place_of(self.drafts.speed.unwrap_or(told));
        let slider = Slider::new(&mut place, SPEEDS.0.log10()..=MAX)
            .custom_formatter(|place, _| speed_text(speed_at(place as f32)))
            .custom_parser(|text| {
                text.trim().trim_end_matches('×').parse().ok().map(|speed: f32| f64::from(place_of(speed)))
            });
        let response = ui.add(slider).on_hover_text("wanted simulated seconds per second ([ and ])");
        if response.changed() {
            let wanted = speed_at(place);
            self.drafts.speed = Some(wanted);
            actions.push(speed(wanted));
        } else if !response.dragged() && !response.has_focus() {
            self.drafts.speed = None;
        }
    }

    fn robots_slider(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let told = facts.status.map_or(0, |status| status.robots);
        let mut count = self.drafts.robots.unwrap_or(told);
        let slider = Slider::new(&mut count, 1..=MOST_ROBOTS.max(told)).logarithmic(true).smart_aim(true);
        let response = ui.add(slider).on_hover_text("number of robots, while the fleet runs (K and I)");
        if response.changed() {
            self.drafts.robots = Some(count);
            actions.push(robots(count));
        } else if !response.dragged() && !response.has_focus() && self.drafts.robots == Some(told) {
            self.drafts.robots = None;
        }
    }

    pub(super) fn pause_or_resume(&self, facts: &Facts<'_>) -> Action {
        control(if facts.is_paused() { ControlKind::Resume } else { ControlKind::Pause })
    }

    /// A step is one of a paused engine.
    pub(super) fn step(&self, facts: &Facts<'_>) -> Vec<Action> {
        let pause = (!facts.is_paused()).then(|| control(ControlKind::Pause));
        let step = Action::Control(ControlRequest { count: 1, ..ControlRequest::new(ControlKind::Step) });
        pause.into_iter().chain([step]).collect()
    }

    /// The speed times a factor.
    pub(super) fn times_speed(&self, facts: &Facts<'_>, factor: f32) -> Action {
        let told = facts.frame.map_or(1.0, |frame| frame.header().speed);
        speed(if told.is_finite() { (told * factor).clamp(SPEEDS.0, SPEEDS.1) } else { SPEEDS.1 })
    }

    /// The number of robots times a factor, at least one more or less.
    pub(super) fn times_robots(&self, facts: &Facts<'_>, factor: f32) -> Action {
        let told = facts.status.map_or(1, |status| status.robots);
        let wanted = (told as f32 * factor) as u32;
        robots(if factor > 1.0 { wanted.max(told + 1) } else { wanted.min(told.saturating_sub(1)).max(1) })
    }
}

fn place_of(speed: f32) -> f32 {
    if speed.is_finite() { speed.clamp(SPEEDS.0, SPEEDS.1).log10() } else { MAX }
}

fn speed_at(place: f32) -> f32 {
    let fastest = SPEEDS.1.log10();
    if place > (fastest + MAX) / 2.0 {
        return f32::INFINITY;
    }
    // Two figures, and 1 is easy to meet.
    let exact = 10_f32.powf(place.min(fastest));
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

/// Hours, minutes and seconds.
fn clock_text(seconds: f64) -> String {
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
    fn speeds_are_where_the_slider_says() {
        for speed in [0.1_f32, 0.5, 1.0, 2.0, 25.0, 100.0, f32::INFINITY] {
            let back = speed_at(place_of(speed));
            assert!(back == speed || (back - speed).abs() < 1e-3 * speed, "{speed} is {back}");
        }
        assert_eq!(speed_text(f32::INFINITY), "max");
    }

    #[test]
    fn clocks_are_read_at_a_glance() {
        assert_eq!(clock_text(0.0), "00:00.00");
        assert_eq!(clock_text(83.456), "01:23.46");
        assert_eq!(clock_text(7384.5), "2:03:04.5");
    }
}
