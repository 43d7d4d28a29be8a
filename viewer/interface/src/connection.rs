//! The connection panel: the engine, and the programs that receive and send robots by UDP.

use egui::{RichText, Role, TextEdit, Ui, WidgetInfo};

use super::context::PanelContext;
use super::settings::UdpSettings;
use super::style::{self, ThemeColours, heading, line, status_dot};
use super::view_model::{Action, EngineState};
use crate::text::thousands;

impl EngineState {
    /// Returns a short text and its colour.
    pub(super) fn text_and_colour(self, colours: &ThemeColours) -> (&'static str, egui::Color32) {
        match self {
            Self::Awaited => ("waiting for an engine", colours.warn),
            Self::WarmingUp(_) => ("warming up", colours.warn),
            Self::Running => ("running", colours.good),
            Self::Paused => ("paused", colours.warn),
            Self::Silent => ("no frames received", colours.bad),
            Self::Gone => ("engine ended", colours.bad),
        }
    }
}

/// Shows the panel; `udp` are the addresses as typed.
pub(super) fn show(context: &PanelContext<'_>, udp: &mut UdpSettings, ui: &mut Ui) {
    ui.label(RichText::new(context.model.name()).size(20.0));
    let (text, colour) = context.model.engine.text_and_colour(&context.colours);
    status_dot(ui, colour, RichText::new(text));
    heading(ui, "engine");
    if let Some(status) = context.model.status {
        line(ui, "process", status.pid.to_string());
        line(ui, "robots", thousands(status.robots.into()));
        line(ui, "ticks", thousands(status.tick));
        line(ui, "late ticks", thousands(status.late_ticks));
        line(ui, "tick cost, median", millis_text(status.tick_cost_p50_nanos));
        line(ui, "tick cost, 99 %", millis_text(status.tick_cost_p99_nanos));
        line(ui, "memory", format!("{} MB", status.resident_bytes / 1_000_000));
    } else {
        ui.label(style::faint(ui, "no engine answers"));
    }
    heading(ui, "this viewer");
    let lag = context.model.lag.map_or("–".to_owned(), |lag| format!("{:.1} ms", lag * 1e3));
    line(ui, "lag", lag);
    line(ui, "frames skipped", thousands(context.model.counts.skipped));
    heading(ui, "UDP in: robots as id,x,y,theta");
    udp_source(context, udp, ui);
    heading(ui, "UDP out: this fleet");
    udp_sender(context, udp, ui);
}

fn millis_text(nanos: u64) -> String {
    format!("{:.2} ms", nanos as f64 * 1e-6)
}

fn udp_source(context: &PanelContext<'_>, udp: &mut UdpSettings, ui: &mut Ui) {
    let is_running = context.model.udp.receives;
    address(ui, "receive at", &mut udp.listen, !is_running);
    ui.add_enabled(!is_running, egui::Checkbox::new(&mut udp.echo, "answer each line"));
    if udp.echo {
        address(ui, "answer to", &mut udp.echo_to, !is_running);
    }
    if is_running {
        if ui.button("Stop receiving").clicked() {
            context.act(Action::StopUdpSource);
        }
    } else if ui.button("Receive").on_hover_text("Start `regatta plugin udp-source`").clicked() {
        let echo_to = udp.echo.then(|| udp.echo_to.trim().to_owned());
        context.act(Action::StartUdpSource {
            listen: udp.listen.trim().to_owned(),
            echo_to,
            offset: context.offset,
        });
    }
}

fn udp_sender(context: &PanelContext<'_>, udp: &mut UdpSettings, ui: &mut Ui) {
    let is_running = context.model.udp.sends;
    address(ui, "send to", &mut udp.send_to, !is_running);
    if is_running {
        if ui.button("Stop sending").clicked() {
            context.act(Action::StopUdpSender);
        }
    } else if ui.button("Send").on_hover_text("Start `regatta plugin udp`").clicked() {
        context.act(Action::StartUdpSender { to: udp.send_to.trim().to_owned() });
    }
}

/// Shows a host and a port in two fields.
fn address(ui: &mut Ui, label: &str, address: &mut String, enabled: bool) {
    let (mut host, mut port) = match address.rsplit_once(':') {
        Some((host, port)) => (host.to_owned(), port.to_owned()),
        None => (address.clone(), String::new()),
    };
    ui.horizontal(|ui| {
        ui.add_sized([62.0, 18.0], egui::Label::new(label));
        let mut field = |text: &mut String, hint: &str, width: f32| {
            let edit = TextEdit::singleline(text)
                .hint_text(hint)
                .desired_width(width)
                .id_salt((label, hint));
            let response = ui.add_enabled(enabled, edit);
            let name = format!("{label}: {hint}");
            response.widget_info(|| WidgetInfo::labeled(Role::TextInput, enabled, &name));
            response.changed()
        };
        let changed = field(&mut host, "host", 96.0) | field(&mut port, "port", 48.0);
        if changed {
            *address = format!("{}:{}", host.trim(), port.trim());
        }
    });
}
