//! Requests of the control service to a replay.

use std::time::Duration;

use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::frame::ClockState;
use regatta_plugin::inbox::Answer;

use super::options::Speed;
use super::{Replay, ReplayError};

/// A request that was carried out or refused, and is to be answered.
#[derive(Debug)]
pub(super) struct Pending {
    ticket: u64,
    /// Answered only when all steps are made.
    is_step: bool,
    refusal: Option<String>,
}

impl Replay<'_> {
    /// Carries out what was asked since the last call, and answers what is due. Orders are thrown away: what was
    /// recorded can't be changed.
    pub(super) fn answer_requests(&mut self) -> Result<(), ReplayError> {
        let mut requests = Vec::new();
        self.stage.producer.take_requests(|request| {
            self.next_ticket += 1;
            requests.push((self.next_ticket, *request));
            Answer::Later(self.next_ticket)
        })?;
        for (ticket, request) in requests {
            let refusal = self.carry_out(&request)?.err();
            let is_step = request.kind() == Some(ControlKind::Step);
            self.pending.push(Pending { ticket, is_step, refusal });
        }
        if self.pending.iter().any(|pending| self.is_due(pending)) {
            let status = self.status();
            let due: Vec<_> = self.pending.extract_if(.., |pending| !pending.is_step || self.steps_left == 0).collect();
            self.stage.producer.answer_waiting(|ticket| {
                let pending = due.iter().find(|pending| pending.ticket == ticket)?;
                Some(match &pending.refusal {
                    Some(reason) => status.refuse(reason),
                    None => status.accept(),
                })
            });
        }
        let mut orders = 0;
        self.stage.producer.take_orders(|_, records| orders += records.len())?;
        if orders > 0 && !std::mem::replace(&mut self.warned_of_orders, true) {
            regatta_plugin::tell!("replay: robots of a recording take no orders; {orders} ignored");
        }
        Ok(())
    }

    fn is_due(&self, pending: &Pending) -> bool {
        !pending.is_step || self.steps_left == 0
    }

    /// The inner error is why the request is refused.
    fn carry_out(&mut self, request: &ControlRequest) -> Result<Result<(), String>, ReplayError> {
        let time = self.time;
        match request.kind() {
            Some(ControlKind::Status) => return Ok(Ok(())),
            Some(ControlKind::Pause) => (self.paused, self.steps_left) = (true, 0),
            Some(ControlKind::Resume) => {
                (self.paused, self.steps_left) = (false, 0);
                self.pace.restart(self.pace.speed(), time);
            }
            Some(ControlKind::Step) => {
                if !self.paused || self.steps_left == 0 {
                    self.pace.restart(self.pace.speed(), time);
                }
                self.paused = true;
                self.steps_left = self.steps_left.saturating_add(request.count);
            }
            Some(ControlKind::Speed) => match Speed::from_f32(request.speed) {
                Some(Speed(speed)) => self.pace.restart(speed, time),
                None => return Ok(Err(format!("{} is no speed: 0.001 to 1000, or max", request.speed))),
            },
            Some(ControlKind::Seek) => {
                let wanted = Duration::from_nanos(request.count);
                return Ok(match self.refuse_time(wanted) {
                    Some(reason) => Err(reason),
                    None => Ok(self.seek(wanted)?),
                });
            }
            Some(ControlKind::Robots) => return Ok(Err("a recording has the robots that it has".to_owned())),
            None => return Ok(Err(format!("request {} is unknown to this replay", request.kind))),
        }
        self.show_again(self.clock())?;
        Ok(Ok(()))
    }

    /// How the replay is.
    fn status(&self) -> ControlResponse {
        let [p50, p99] = self.pace.percentiles().map(|cost| cost.as_nanos() as u64);
        let robots_by_state = self.stage.robots_by_state();
        ControlResponse {
            run_id: self.stage.producer.run_id(),
            tick: self.stage.header().tick,
            sim_time_nanos: self.stage.header().sim_time_nanos,
            late_ticks: self.pace.late(),
            tick_cost_p50_nanos: p50,
            tick_cost_p99_nanos: p99,
            wall_time_nanos: self.started.elapsed().as_nanos() as u64,
            robots_by_state,
            robots: robots_by_state.iter().sum(),
            pid: std::process::id(),
            clock: self.clock() as u32,
            speed: self.pace.speed(),
            real_time_factor: self.pace.real_time_factor(),
            ..ControlResponse::default()
        }
    }

    pub(super) fn clock(&self) -> ClockState {
        if self.paused { ClockState::Paused } else { ClockState::Running }
    }
}
