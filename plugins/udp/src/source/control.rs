//! What the source answers to requests and orders. It follows whoever sends it poses, so it can stop looking, and
//! no more.

use regatta_plugin::Result;
use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::event::{EventHeader, EventKind, EventRecord, Refusal};
use regatta_plugin::frame::ClockState;
use regatta_plugin::inbox::Answer;
use regatta_plugin::order::OrderKind;

use super::Source;

impl Source {
    /// Carries out what was asked since the last call, and answers it.
    pub(super) fn answer_requests(&mut self) -> Result {
        let mut outcomes = Vec::new();
        self.producer.take_requests(|request| {
            outcomes.push(carry_out(request));
            Answer::Later(outcomes.len() as u64 - 1)
        })?;
        // The status takes a look at every robot.
        if outcomes.is_empty() {
            return Ok(());
        }
        if let Some(paused) = outcomes.iter().filter_map(|outcome| outcome.ok().flatten()).next_back() {
            self.set_paused(paused)?;
        }
        let status = self.status();
        self.producer.answer_waiting(|ticket| match outcomes.get(ticket as usize)? {
            Ok(_) => Some(status.accept()),
            Err(reason) => Some(status.refuse(reason)),
        });
        Ok(())
    }

    /// Refuses all orders, by an event for each.
    pub(super) fn refuse_orders(&mut self) -> Result {
        let mut refused = Vec::new();
        self.producer.take_orders(|_, records| {
            let orders = records.iter().filter(|record| record.kind != OrderKind::Leg as u32);
            refused.extend(orders.map(|order| EventRecord {
                token: order.token,
                kind: EventKind::Refused as u32,
                robot: order.robot,
                id: order.id,
                detail: Refusal::MalformedOrder as u32,
            }));
        })?;
        self.orders_refused += refused.len() as u64;
        if !refused.is_empty() && self.producer.has_event_readers() {
            let header = EventHeader { tick: self.ticker.tick, ..EventHeader::default() };
            self.producer.publish_events(&header, &refused)?;
        }
        Ok(())
    }

    fn status(&self) -> ControlResponse {
        let [standing, driving] = self.intake.robots.standing_and_driving(self.now());
        let [p50, p99] = self.ticker.cost_percentiles();
        ControlResponse {
            run_id: self.producer.run_id(),
            tick: self.ticker.tick,
            sim_time_nanos: self.ticker.sim_time_nanos(),
            late_ticks: self.ticker.late_ticks,
            tick_cost_p50_nanos: p50.as_nanos() as u64,
            tick_cost_p99_nanos: p99.as_nanos() as u64,
            resident_bytes: resident_bytes(),
            wall_time_nanos: self.now().as_nanos() as u64,
            robots_by_state: [standing, driving, 0, 0, 0],
            robots: standing + driving,
            pid: std::process::id(),
            clock: clock_state(self.paused) as u32,
            speed: 1.0,
            real_time_factor: self.ticker.real_time_factor,
            ..ControlResponse::default()
        }
    }
}

pub(super) fn clock_state(paused: bool) -> ClockState {
    if paused { ClockState::Paused } else { ClockState::Running }
}

/// Whether to be paused from now on, if the request changes that; or why not.
fn carry_out(request: &ControlRequest) -> Result<Option<bool>, &'static str> {
    match request.kind() {
        Some(ControlKind::Status) => Ok(None),
        Some(ControlKind::Pause) => Ok(Some(true)),
        Some(ControlKind::Resume) => Ok(Some(false)),
        Some(ControlKind::Step | ControlKind::Speed | ControlKind::Seek) => {
            Err("time comes from whoever sends the poses: a UDP source can only pause and resume")
        }
        Some(ControlKind::Robots) => Err("robots come from whoever sends the poses: a UDP source can't make any"),
        None => Err("the request is unknown to this UDP source"),
    }
}

/// Resident memory of this process in bytes, shared memory included; 0 where the system doesn't say.
fn resident_bytes() -> u64 {
    let kibibytes = |text: String| -> Option<u64> {
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
        line.trim().trim_end_matches(" kB").parse().ok()
    };
    std::fs::read_to_string("/proc/self/status").ok().and_then(kibibytes).unwrap_or(0) * 1024
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_looking_can_be_controlled() {
        let outcome = |kind| carry_out(&ControlRequest::new(kind));
        assert_eq!(outcome(ControlKind::Status), Ok(None));
        assert_eq!(outcome(ControlKind::Pause), Ok(Some(true)));
        assert_eq!(outcome(ControlKind::Resume), Ok(Some(false)));
        for kind in [ControlKind::Step, ControlKind::Speed, ControlKind::Robots, ControlKind::Seek] {
            assert!(outcome(kind).is_err_and(|reason| reason.len() <= 128), "{kind:?}");
        }
        assert!(carry_out(&ControlRequest { kind: 999, ..ControlRequest::default() }).is_err());
    }
}
