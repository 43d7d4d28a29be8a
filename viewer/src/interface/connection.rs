//! The engine, and programs that bring robots in and out by UDP.

use egui::{RichText, TextEdit, Ui};

use super::Interface;
use super::facts::{Action, Engine, Facts};
use super::fleet_list::dot;
use super::style::{self, Tones, heading, line, thousands};

impl Engine {
    /// In a word or two, and its colour.
    pub(super) fn words(self, tones: &Tones) -> (&'static str, egui::Color32) {
        match self {
            Self::Awaited => ("waiting for an engine", tones.warn),
            Self::Running => ("running", tones.good),
            Self::Paused => ("paused", tones.warn),
            Self::Silent => ("no frames come", tones.bad),
            Self::Gone => ("the engine has ended", tones.bad),
        }
    }
}

impl Interface {
    pub(super) fn connection(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let (theme, tones) = (self.settings.theme(), self.tones());
        ui.label(RichText::new(facts.fleet).size(20.0));
        let (words, colour) = facts.engine.words(&tones);
        dot(ui, colour, RichText::new(words));
        heading(ui, theme, "engine");
        if let Some(status) = facts.status {
            line(ui, theme, "process", status.pid.to_string());
            line(ui, theme, "robots", thousands(status.robots.into()));
            line(ui, theme, "ticks", thousands(status.tick));
            line(ui, theme, "late ticks", thousands(status.late_ticks));
            let cost = |nanos: u64| format!("{:.2} ms", nanos as f64 * 1e-6);
            line(ui, theme, "a tick, median", cost(status.tick_cost_p50_nanos));
            line(ui, theme, "a tick, 99 %", cost(status.tick_cost_p99_nanos));
            line(ui, theme, "memory", format!("{} MB", status.resident_bytes / 1_000_000));
        } else {
            ui.label(style::faint(ui, theme, "none answers"));
        }
        heading(ui, theme, "this reader");
        let lag = facts.lag.map_or("–".to_owned(), |lag| format!("{:.1} ms", lag * 1e3));
        line(ui, theme, "lag", lag);
        line(ui, theme, "frames skipped", thousands(facts.counts.skipped));
        heading(ui, theme, "UDP in: robots as id,x,y,theta");
        self.udp_source(ui, facts, actions);
        heading(ui, theme, "UDP out: this fleet");
        self.udp_sender(ui, facts, actions);
    }

    fn udp_source(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let (udp, runs) = (&mut self.settings.udp, facts.udp[0]);
        address(ui, "receive at", &mut udp.listen, !runs);
        ui.add_enabled(!runs, egui::Checkbox::new(&mut udp.echo, "answer each line"));
        if udp.echo {
            address(ui, "answer to", &mut udp.echo_to, !runs);
        }
        if runs {
            if ui.button("Stop receiving").clicked() {
                actions.push(Action::StopUdpSource);
            }
        } else if ui.button("Receive").on_hover_text("starts `regatta plugin udp-source`").clicked() {
            let offset = self.settings.offset.into();
            let echo_to = udp.echo.then(|| udp.echo_to.trim().to_owned());
            actions.push(Action::StartUdpSource { listen: udp.listen.trim().to_owned(), echo_to, offset });
        }
    }

    fn udp_sender(&mut self, ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
        let (udp, runs) = (&mut self.settings.udp, facts.udp[1]);
        address(ui, "send to", &mut udp.send_to, !runs);
        if runs {
            if ui.button("Stop sending").clicked() {
                actions.push(Action::StopUdpSender);
            }
        } else if ui.button("Send").on_hover_text("starts `regatta plugin udp`").clicked() {
            actions.push(Action::StartUdpSender { to: udp.send_to.trim().to_owned() });
        }
    }
}

/// Host and port, in two fields.
fn address(ui: &mut Ui, label: &str, address: &mut String, enabled: bool) {
    let (mut host, mut port) = match address.rsplit_once(':') {
        Some((host, port)) => (host.to_owned(), port.to_owned()),
        None => (address.clone(), String::new()),
    };
    ui.horizontal(|ui| {
        ui.add_sized([62.0, 18.0], egui::Label::new(label));
        let mut field = |text: &mut String, hint: &str, width: f32| {
            let edit = TextEdit::singleline(text).hint_text(hint).desired_width(width).id_salt((label, hint));
            ui.add_enabled(enabled, edit).changed()
        };
        let changed = field(&mut host, "host", 96.0) | field(&mut port, "port", 48.0);
        if changed {
            *address = format!("{}:{}", host.trim(), port.trim());
        }
    });
}
