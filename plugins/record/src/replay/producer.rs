//! The replay as a [`Producer`]: its clock, control service and lockstep are those of every
//! producer.

use std::time::Duration;

use regatta_plugin::control::ControlKind;
use regatta_plugin::frame::{ClockState, RobotState};
use regatta_plugin::producer::{Moment, Producer, RefusalReason, Session};

use super::{Replay, ReplayError, explain};
use crate::schema::Topic;

impl Producer for Replay<'_> {
    type Error = ReplayError;

    fn start(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        let (start, _) = self.recording.span();
        let from = self.args.from.map_or(start, Into::into);
        if let Some(reason) = self.refuse_time(from) {
            return Err(ReplayError::Time(reason));
        }
        let withhold = session.is_lockstep();
        self.go_to(session, from, withhold)
    }

    fn next_moment(&mut self, session: &Session) -> Result<Option<Moment>, ReplayError> {
        Ok(self.reader.peek()?.map(|sim_nanos| Moment { tick: session.tick(), sim_nanos }))
    }

    fn tick(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        self.finish_jump(session)?;
        self.show_moment(session, false).map(drop)
    }

    fn show(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        let Some((time, message)) = self.recording.last_until(&Topic::Frames, self.time)? else {
            return Ok(());
        };
        let shown = self.stage.publish(session, &Topic::Frames, &message);
        shown.map_err(|error| explain(self.recording, &Topic::Frames, time, error))
    }

    fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        self.stage.robots_by_state()
    }

    fn between_ticks(&mut self, session: &mut Session) -> Result<(), ReplayError> {
        self.stage.update()?;
        self.stage.publish_closures(session)?;
        if let Some(contacts) =
            self.contact_search.as_mut().and_then(|search| search.poll(self.time))
        {
            self.stage.take_contacts(session, contacts)?;
        }
        session.refuse_orders()?;
        if session.orders_refused() > 0 && !std::mem::replace(&mut self.reported_orders, true) {
            regatta_plugin::tell!(
                "replay: orders are refused: the robots of a recording can't be steered"
            );
        }
        Ok(())
    }

    fn refuses(&self, kind: ControlKind) -> Option<RefusalReason> {
        (kind == ControlKind::Robots)
            .then(|| "a replay can't change the number of robots".to_owned())
    }

    fn seek(
        &mut self,
        session: &mut Session,
        sim_time: Duration,
    ) -> Result<Result<(), RefusalReason>, ReplayError> {
        match self.refuse_time(sim_time) {
            Some(reason) => Ok(Err(reason)),
            None => self.go_to(session, sim_time, false).map(Ok),
        }
    }

    fn at_end(&mut self, session: &mut Session) -> Result<bool, ReplayError> {
        let is_paused = session.clock_state() == ClockState::Paused;
        if self.args.repeat && !is_paused {
            let (start, _) = self.recording.span();
            self.go_to(session, start, false)?;
            return Ok(false);
        }
        let stays = self.args.hold || self.args.repeat || is_paused;
        if stays && !is_paused {
            session.pause();
            self.show(session)?;
        }
        Ok(!stays)
    }
}
