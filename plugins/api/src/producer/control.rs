//! The control service of a producer: requests are carried out between ticks.

use std::time::{Duration, Instant};

use super::figures::resident_bytes;
use super::session::{Pending, Session};
use super::speed::Speed;
use super::{Producer, RefusalReason};
use crate::records::control::{ControlKind, ControlRequest, ControlResponse};
use crate::records::padded;

/// The largest number of ticks that one request may step.
const MAX_STEP: u64 = 1 << 40;

impl Session {
    /// Carries out the requests that have arrived, and answers those that are due.
    pub(super) fn answer_requests<P: Producer>(
        &mut self,
        producer: &mut P,
    ) -> Result<(), P::Error> {
        while let Some((ticket, request)) = self.ports().take_request()? {
            let refusal = self.carry_out(producer, &request)?.err();
            let is_step = request.kind() == Some(ControlKind::Step) && refusal.is_none();
            let due = if is_step { self.steps_made + self.clock.steps_left() } else { 0 };
            self.pending.push(Pending { ticket, due, refusal });
        }
        let steps_made = self.steps_made;
        let due: Vec<_> =
            self.pending.extract_if(.., |pending| pending.due <= steps_made).collect();
        if due.is_empty() {
            return Ok(());
        }
        // Once for all: it takes a look at every robot.
        let status = self.status(producer);
        for Pending { ticket, refusal, .. } in due {
            let response = refusal.map_or(status.accept(), |reason| status.refuse(&reason));
            self.ports().answer(ticket, response);
        }
        Ok(())
    }

    /// The inner error is the reason of a refusal.
    fn carry_out<P: Producer>(
        &mut self,
        producer: &mut P,
        request: &ControlRequest,
    ) -> Result<Result<(), RefusalReason>, P::Error> {
        let Some(kind) = request.kind() else {
            return Ok(Err(format!("request {} is unknown to this producer", request.kind)));
        };
        if kind == ControlKind::Status {
            return Ok(Ok(()));
        }
        if let Some(reason) = producer.refuses(kind) {
            return Ok(Err(reason));
        }
        if kind != ControlKind::Robots {
            self.end_warm_up();
        }
        let (current, now) = (self.now.sim_nanos, Instant::now());
        let outcome = match kind {
            ControlKind::Status => Ok(()),
            ControlKind::Pause => {
                self.pause();
                Ok(())
            }
            ControlKind::Resume => {
                self.interrupt_steps("a resume");
                self.clock.resume(current, now);
                self.figures.restart(current, now);
                Ok(())
            }
            ControlKind::Step => self.step(producer, request.count)?,
            ControlKind::Speed => self.change_speed(producer, request.speed)?,
            ControlKind::Robots => producer.set_robots(self, request.count)?,
            ControlKind::Seek => {
                // It publishes the frame of that time itself.
                let outcome = producer.seek(self, Duration::from_nanos(request.count))?;
                self.wait_for_lockstep()?;
                return Ok(outcome);
            }
        };
        if outcome.is_ok() {
            producer.show(self)?;
        }
        Ok(outcome)
    }

    fn step<P: Producer>(
        &mut self,
        producer: &mut P,
        ticks: u64,
    ) -> Result<Result<(), RefusalReason>, P::Error> {
        if ticks > MAX_STEP {
            return Ok(Err(format!(
                "{ticks} ticks are too many for one step: ask for at most {MAX_STEP}"
            )));
        }
        let next = producer.next_moment(self)?.unwrap_or(self.now).sim_nanos;
        let now = Instant::now();
        if self.clock.stands() {
            self.figures.restart(self.now.sim_nanos, now);
        }
        self.clock.step(ticks, next, now);
        Ok(Ok(()))
    }

    fn change_speed<P: Producer>(
        &mut self,
        producer: &mut P,
        factor: f32,
    ) -> Result<Result<(), RefusalReason>, P::Error> {
        let Some(speed) = Speed::from_f32(factor) else {
            return Ok(Err(format!("invalid speed {factor}: give 0.001 to 1000, or max")));
        };
        let next = producer.next_moment(self)?.unwrap_or(self.now).sim_nanos;
        let now = Instant::now();
        self.clock.set_speed(speed, self.now.sim_nanos, next, now);
        self.figures.restart(self.now.sim_nanos, now);
        Ok(Ok(()))
    }

    /// Refuses the step requests that still wait, because of `what`.
    pub(super) fn interrupt_steps(&mut self, what: &str) {
        let left = self.clock.steps_left();
        for pending in self.pending.iter_mut().filter(|pending| pending.due > self.steps_made) {
            pending.due = 0;
            pending.refusal = Some(format!("{what} ended the step with {left} ticks left"));
        }
    }

    /// The state of the producer.
    fn status<P: Producer>(&mut self, producer: &P) -> ControlResponse {
        let (p50, p99) = self.figures.percentiles();
        let robots_by_state = producer.robots_by_state();
        ControlResponse {
            run_id: self.run_id(),
            tick: self.now.tick,
            sim_time_nanos: self.now.sim_nanos,
            late_ticks: self.clock.late_ticks(),
            tick_cost_p50_nanos: p50.as_nanos() as u64,
            tick_cost_p99_nanos: p99.as_nanos() as u64,
            resident_bytes: resident_bytes(),
            wall_time_nanos: self.started.elapsed().as_nanos() as u64,
            robots_by_state,
            robots: robots_by_state.iter().sum(),
            pid: std::process::id(),
            clock: self.clock_state() as u32,
            speed: self.clock.speed().as_f32(),
            real_time_factor: self.figures.real_time_factor(),
            owner: self.ports().owner().map(padded).unwrap_or([0; 96]),
            ..ControlResponse::default()
        }
    }
}
