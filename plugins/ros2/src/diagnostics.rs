//! The state of the run once a second, as `/diagnostics`.

use std::time::{Duration, Instant};

use regatta_plugin::Frame;
use regatta_plugin::activity::Activity;
use regatta_plugin::frame::{ClockState, FrameHeader, RobotState};

use crate::link::{Keep, Link, LinkError, Output};
use crate::message::display::{DiagnosticArray, DiagnosticStatus, KeyValue, level};
use crate::message::geometry::{Header, Time};
use crate::options::Namespace;

/// The time between two messages.
const EVERY: Duration = Duration::from_secs(1);

/// The topic.
pub(crate) struct Diagnostics {
    output: Output<DiagnosticArray>,
    name: String,
    published: Option<Instant>,
    refused: u64,
    late_ticks: u64,
}

impl Diagnostics {
    pub fn open(link: &mut Link, namespace: &Namespace) -> Result<Self, LinkError> {
        let output = link.output("/diagnostics", Keep::Nothing, 2_000)?;
        let name = namespace.absolute().trim_start_matches('/').to_owned();
        Ok(Self { output, name, published: None, refused: 0, late_ticks: 0 })
    }

    /// Publishes the state, if it is time.
    pub fn publish(&mut self, frame: &Frame<'_>, link: &Link) {
        if self.published.is_some_and(|published| published.elapsed() < EVERY) {
            return;
        }
        self.published = Some(Instant::now());
        let status = vec![self.clock(frame.header()), self.robots(frame), self.dds(link.refused())];
        let header = Header::new(&Time::after(frame.sim_time()), "");
        self.output.publish(DiagnosticArray { header, status });
    }

    fn clock(&mut self, header: &FrameHeader) -> DiagnosticStatus {
        let is_late = header.late_ticks > self.late_ticks;
        self.late_ticks = header.late_ticks;
        let is_paused = header.clock == ClockState::Paused as u32;
        let message = match (is_late, is_paused) {
            (true, _) => "ticks are late",
            (false, true) => "paused",
            (false, false) => "running",
        };
        let values = [
            ("tick", header.tick.to_string()),
            ("simulated time in s", format!("{:.3}", header.sim_time_nanos as f64 * 1e-9)),
            ("wanted speed", header.speed.to_string()),
            ("late ticks", header.late_ticks.to_string()),
            ("cost of a tick in ms", format!("{:.3}", header.tick_cost_nanos as f64 * 1e-6)),
        ];
        self.status("clock", if is_late { level::WARN } else { level::OK }, message, &values)
    }

    fn robots(&self, frame: &Frame<'_>) -> DiagnosticStatus {
        let mut counts = [0_usize; RobotState::COUNT];
        for state in frame.state() {
            if let Some(count) = counts.get_mut(usize::from(*state)) {
                *count += 1;
            }
        }
        let values: Vec<_> = (0..RobotState::COUNT as u8)
            .filter_map(|number| Activity::of_state(RobotState::from_number(number)))
            .zip(counts)
            .map(|(activity, count)| (activity.name(), count.to_string()))
            .collect();
        let (level, message) =
            match [RobotState::Faulted, RobotState::Broken].map(|state| counts[state as usize]) {
                [0, 0] => (level::OK, format!("{} robots", counts.iter().sum::<usize>())),
                [0, broken] => (level::WARN, format!("{broken} robots are broken")),
                [faulted, _] => (level::ERROR, format!("{faulted} robots are faulted")),
            };
        self.status("robots", level, &message, &values)
    }

    fn dds(&mut self, refused: u64) -> DiagnosticStatus {
        let is_worse = refused > self.refused;
        self.refused = refused;
        let (level, message) = match is_worse {
            true => (level::WARN, "a reader takes no messages"),
            false => (level::OK, "readers keep up"),
        };
        self.status("ros2", level, message, &[("messages left out", refused.to_string())])
    }

    fn status(
        &self,
        part: &str,
        level: u8,
        message: &str,
        values: &[(&str, String)],
    ) -> DiagnosticStatus {
        let values = values.iter();
        let values =
            values.map(|(key, value)| KeyValue { key: (*key).to_owned(), value: value.clone() });
        DiagnosticStatus {
            level,
            name: format!("{}: {part}", self.name),
            message: message.to_owned(),
            hardware_id: self.name.clone(),
            values: values.collect(),
        }
    }
}
