//! The engine as a [`Producer`]: its clock, control service and lockstep are those of every
//! producer.

use regatta_plugin::control::ControlKind;
use regatta_plugin::frame::RobotState;
use regatta_plugin::producer::{Moment, Producer, RefusalReason, Session};
use regatta_scenario::MAX_ROBOTS;

use super::{EngineError, Simulation};

impl Producer for Simulation {
    type Error = EngineError;

    fn start(&mut self, session: &mut Session) -> Result<(), EngineError> {
        self.publish_world(session)?;
        self.publish_types(session)?;
        self.publish_batteries(session)?;
        self.publish_facilities(session)?;
        self.write_frame(session, true)
    }

    fn next_moment(&mut self, session: &Session) -> Result<Option<Moment>, EngineError> {
        let next = session.next_tick();
        Ok(self.last_tick.is_none_or(|last| next.tick <= last).then_some(next))
    }

    fn tick(&mut self, session: &mut Session) -> Result<(), EngineError> {
        self.events.set_wanted(session.ports().has_event_readers());
        self.take_commands(session)?;
        self.disturbances.carry_out(session.tick(), &mut self.fleet, &mut self.events);
        self.fleet.drain_batteries(session.tick(), &mut self.events);
        self.fleet.step_facilities(session.tick(), &mut self.events);
        if let Some(mut frame) = self.loan_if_due(session)? {
            self.fleet.step(Some(frame.columns_mut()), &mut self.events);
            self.publish_events(session)?;
            if session.tick() >= self.batteries_due {
                self.publish_batteries(session)?;
            }
            self.send(session, frame, true)
        } else {
            self.fleet.step(None, &mut self.events);
            self.publish_events(session)?;
            self.announce_events(session);
            session.ports().update();
            Ok(())
        }
    }

    fn show(&mut self, session: &mut Session) -> Result<(), EngineError> {
        self.write_frame(session, false)
    }

    fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        self.fleet.robots_by_state()
    }

    /// Commands wait for the next tick; routes are reported between two.
    fn between_ticks(&mut self, session: &mut Session) -> Result<(), EngineError> {
        self.answer_routes(session)
    }

    fn refuses(&self, kind: ControlKind) -> Option<RefusalReason> {
        (kind == ControlKind::Seek)
            .then(|| "an engine can't go to another time; a replay can".to_owned())
    }

    fn set_robots(
        &mut self,
        session: &mut Session,
        robots: u64,
    ) -> Result<Result<(), RefusalReason>, EngineError> {
        if robots > u64::from(MAX_ROBOTS) {
            return Ok(Err(format!(
                "{robots} robots are too many: a fleet holds at most {MAX_ROBOTS}"
            )));
        }
        let robots = robots as u32;
        if let Err(error) = session.ports().check_room(robots as usize) {
            return Ok(Err(error.to_string()));
        }
        self.events.set_wanted(session.ports().has_event_readers());
        let before = self.fleet.present() as u32;
        if let Err(error) = self.place_robots(robots) {
            self.place_robots(before).expect("removals need no room");
            return Ok(Err(error.to_string()));
        }
        // Their events belong to the next tick.
        self.publish_types(session)?;
        self.publish_batteries(session)?;
        Ok(Ok(()))
    }
}
