//! The figures that the source reports.

use std::time::Instant;

use regatta_plugin::producer::Session;

use super::Source;
use super::intake::Intake;
use crate::tally::Faults;

/// Counts of ignored and failed messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Trouble {
    pub faults: Faults,
    pub dropped: u64,
    pub commands_refused: u64,
    pub answers_refused: u64,
    pub receive_errors: u64,
}

impl Source {
    /// Reports once a second: trouble always, other figures with `--verbose`.
    pub(super) fn report(&mut self, session: &Session) {
        if !self.second.has_passed(Instant::now()) {
            return;
        }
        let trouble = self.trouble(session);
        if self.verbose {
            regatta_plugin::tell!("udp-source: {}", self.summary(session));
        } else if trouble != self.reported {
            regatta_plugin::tell!("udp-source: ignored so far: {}", trouble.text());
        }
        self.reported = trouble;
    }

    fn trouble(&self, session: &Session) -> Trouble {
        Trouble {
            faults: self.intake.faults,
            dropped: self.socket.dropped().unwrap_or(0),
            commands_refused: session.commands_refused(),
            answers_refused: self.answers.as_ref().map_or(0, |answers| answers.outlet.sent.refused),
            receive_errors: self.receive_errors,
        }
    }

    fn summary(&self, session: &Session) -> String {
        let Intake { lines, datagrams, bytes, .. } = self.intake;
        let (standing, driving) = self.intake.robots.standing_and_driving(self.now());
        let answered = self
            .answers
            .as_ref()
            .map_or(String::new(), |answers| format!(", {} answered", answers.outlet.sent.lines));
        format!(
            "{lines} lines of {} robots received in {datagrams} datagrams ({bytes} bytes)\
             {answered} {}; {} frames, {} late; ignored: {}",
            standing + driving,
            self.effort,
            session.tick(),
            session.late_ticks(),
            self.trouble(session).text()
        )
    }

    /// Reports the closing figures.
    pub(super) fn report_end(&self, session: &Session, json: bool) {
        regatta_plugin::tell!("udp-source: {}", self.summary(session));
        if !json {
            return;
        }
        let Intake { lines, datagrams, bytes, faults, .. } = self.intake;
        let answers = self.answers.as_ref().map(|answers| answers.outlet.sent.lines);
        let json = serde_json::json!({
            "lines": lines, "datagrams": datagrams, "bytes": bytes,
            "dropped_packets": self.socket.dropped(),
            "receive_buffer_bytes": self.socket.receive_buffer_bytes(),
            "malformed": faults.malformed, "negative_ids": faults.negative_id,
            "ids_too_large": faults.id_too_large, "not_finite": faults.not_finite,
            "oversized_datagrams": faults.oversized,
            "answers": answers, "commands_refused": session.commands_refused(),
            "frames": session.tick(), "late_ticks": session.late_ticks(),
            "wall_secs": self.effort.wall_secs(), "cpu_secs": self.effort.cpu_secs(),
        });
        println!("{json}");
    }
}

impl Trouble {
    fn text(&self) -> String {
        let mut text = self.faults.to_string();
        for (count, what) in [
            (
                self.dropped,
                "packets dropped by the system, of up to 64 datagrams each (the receive buffer was \
                 full)",
            ),
            (self.commands_refused, "commands refused (the sender of the poses drives the robots)"),
            (self.answers_refused, "answers not sent"),
            (self.receive_errors, "errors of the socket"),
        ] {
            if count > 0 {
                text += &format!(", {count} {what}");
            }
        }
        text.strip_prefix("nothing, ").map_or(text.clone(), str::to_owned)
    }
}
