//! Requests of the control service: carried out between ticks.

use std::time::Instant;

use regatta_plugin::control::{ControlKind, ControlRequest, ControlResponse};
use regatta_plugin::inbox::Answer;

use super::{Engine, EngineError};
use crate::clock::Speed;
use crate::scenario::MAX_ROBOTS;

/// Most ticks that one request may step.
const MAX_STEP: u64 = 1 << 40;

/// A request that has been carried out or refused, and is to be answered.
#[derive(Debug)]
pub(super) struct Pending {
    ticket: u64,
    /// The tick from which it may be answered.
    due: u64,
    refusal: Option<String>,
}

impl Engine {
    /// Carries out what was asked since the last call, and answers what is due.
    pub(super) fn answer_requests(&mut self) -> Result<(), EngineError> {
        let mut requests = Vec::new();
        self.producer.take_requests(|request| {
            self.next_ticket += 1;
            requests.push((self.next_ticket, *request));
            Answer::Later(self.next_ticket)
        })?;
        for (ticket, request) in requests {
            let refusal = self.carry_out(&request)?.err();
            self.pending.push(Pending { ticket, due: self.tick + self.steps_left_for(&request), refusal });
        }
        if self.pending.iter().any(|pending| pending.due <= self.tick) {
            let status = self.status();
            self.producer.answer_waiting(|ticket| {
                let due = |pending: &&Pending| pending.ticket == ticket && pending.due <= status.tick;
                self.pending.iter().find(due).map(|pending| answer(pending, status))
            });
            self.pending.retain(|pending| pending.due > self.tick);
        }
        Ok(())
    }

    fn steps_left_for(&self, request: &ControlRequest) -> u64 {
        if request.kind == ControlKind::Step as u32 { self.steps_left } else { 0 }
    }

    /// The inner error is why the request is refused.
    fn carry_out(&mut self, request: &ControlRequest) -> Result<Result<(), String>, EngineError> {
        let is = |kind: ControlKind| request.kind == kind as u32;
        if is(ControlKind::Status) {
            return Ok(Ok(()));
        }
        let outcome = if is(ControlKind::Pause) {
            self.pause();
            Ok(())
        } else if is(ControlKind::Resume) {
            self.resume();
            Ok(())
        } else if is(ControlKind::Step) {
            self.step(request.count)
        } else if is(ControlKind::Speed) {
            self.change_speed(request.speed)
        } else if is(ControlKind::Robots) {
            self.change_robots(request.count)?
        } else if is(ControlKind::Seek) {
            Err("an engine can't go to another time; a replay can".to_owned())
        } else {
            Err(format!("request {} is unknown to this engine", request.kind))
        };
        if outcome.is_ok() {
            self.republish(self.clock_state())?;
        }
        Ok(outcome)
    }

    fn pause(&mut self) {
        self.paused = true;
        self.steps_left = 0;
    }

    fn resume(&mut self) {
        self.paused = false;
        self.steps_left = 0;
        self.restart_clock(self.clock.speed());
    }

    fn restart_clock(&mut self, speed: Speed) {
        let now = Instant::now();
        self.clock.restart(speed, now);
        self.stats.restart(self.tick, now);
    }

    fn step(&mut self, ticks: u64) -> Result<(), String> {
        if ticks > MAX_STEP {
            return Err(format!("{ticks} ticks are too many for one step: ask for at most {MAX_STEP}"));
        }
        if !self.paused || self.steps_left == 0 {
            // At the wanted speed, so that readers can follow; the first at once.
            self.restart_clock(self.clock.speed());
        }
        self.paused = true;
        self.steps_left += ticks;
        Ok(())
    }

    fn change_speed(&mut self, factor: f32) -> Result<(), String> {
        let speed = Speed::from_f32(factor).ok_or_else(|| format!("{factor} is no speed: 0.001 to 1000, or max"))?;
        self.restart_clock(speed);
        Ok(())
    }

    fn change_robots(&mut self, count: u64) -> Result<Result<(), String>, EngineError> {
        match u32::try_from(count) {
            Ok(robots) if robots <= MAX_ROBOTS => {
                if let Err(error) = self.producer.check_room(robots as usize) {
                    return Ok(Err(error.to_string()));
                }
                self.set_robots(robots);
                self.publish_types()?;
                Ok(Ok(()))
            }
            _ => Ok(Err(format!("{count} robots are too many: a fleet holds at most {MAX_ROBOTS}"))),
        }
    }

    /// How the fleet is.
    fn status(&self) -> ControlResponse {
        let (p50, p99) = self.stats.percentiles();
        ControlResponse {
            run_id: self.producer.run_id(),
            tick: self.tick,
            sim_time_nanos: self.sim_time().as_nanos() as u64,
            late_ticks: self.clock.late_ticks(),
            tick_cost_p50_nanos: p50.as_nanos() as u64,
            tick_cost_p99_nanos: p99.as_nanos() as u64,
            resident_bytes: resident_bytes(),
            wall_time_nanos: self.started.elapsed().as_nanos() as u64,
            robots_by_state: self.fleet.robots_by_state(),
            robots: self.fleet.present() as u32,
            pid: std::process::id(),
            clock: self.clock_state() as u32,
            speed: self.clock.speed().as_f32(),
            real_time_factor: self.stats.real_time_factor(),
            accepted: 1,
            reserved: 0,
            reason: [0; 128],
        }
    }
}

fn answer(pending: &Pending, status: ControlResponse) -> ControlResponse {
    let Some(refusal) = &pending.refusal else { return status };
    let mut reason = [0; 128];
    let length = refusal.len().min(reason.len());
    reason[..length].copy_from_slice(&refusal.as_bytes()[..length]);
    ControlResponse { accepted: 0, reason, ..status }
}

/// Resident memory of this process in bytes, shared memory included; 0 where the system doesn't say.
fn resident_bytes() -> u64 {
    let kibibytes = |text: String| -> Option<u64> {
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
        line.trim().trim_end_matches(" kB").parse().ok()
    };
    std::fs::read_to_string("/proc/self/status").ok().and_then(kibibytes).unwrap_or(0) * 1024
}
