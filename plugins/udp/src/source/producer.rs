//! The source as a [`Producer`]. It follows the sender of the poses: it can be paused, but not
//! steered.

use std::time::{Duration, Instant};

use regatta_plugin::control::ControlKind;
use regatta_plugin::frame::RobotState;
use regatta_plugin::producer::{Producer, RefusalReason, Session};
use regatta_plugin::world::WorldData;
use regatta_plugin::{Error, Result};

use super::Source;

impl Producer for Source {
    type Error = Error;

    fn start(&mut self, session: &mut Session) -> Result {
        let world = WorldData {
            robot_types: self.robot_type.into_iter().collect(),
            ..WorldData::default()
        };
        session.ports().publish_world(&world)?;
        self.show(session)
    }

    fn tick(&mut self, session: &mut Session) -> Result {
        if let Some(silence) = self.forget {
            self.intake.robots.forget(silence, self.now());
        }
        self.show(session)
    }

    fn show(&mut self, session: &mut Session) -> Result {
        let rows = self.intake.robots.len();
        self.publish_types(session, rows)?;
        let now = self.now();
        Ok(session.publish(rows, |columns| self.intake.robots.write(columns, now))?)
    }

    fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        let (standing, driving) = self.intake.robots.standing_and_driving(self.now());
        let mut by_state = [0; RobotState::COUNT];
        (by_state[RobotState::Idle as usize], by_state[RobotState::Driving as usize]) =
            (standing, driving);
        by_state
    }

    fn between_ticks(&mut self, session: &mut Session) -> Result {
        self.receive_until(Instant::now());
        session.refuse_commands()?;
        self.report(session);
        Ok(())
    }

    fn wait(&mut self, _session: &mut Session, duration: Duration) -> Result {
        self.receive_until(Instant::now() + duration);
        Ok(())
    }

    fn refuses(&self, kind: ControlKind) -> Option<RefusalReason> {
        let reason = match kind {
            ControlKind::Status | ControlKind::Pause | ControlKind::Resume => return None,
            ControlKind::Step | ControlKind::Speed | ControlKind::Seek => {
                "time comes from the sender of the poses: a UDP source can only pause and resume"
            }
            ControlKind::Robots => {
                "robots come from the sender of the poses: a UDP source can't add any"
            }
        };
        Some(reason.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use regatta_plugin::FleetName;
    use regatta_plugin::producer::{LockstepOptions, Speed};
    use regatta_plugin::{ProducerPorts, Subscriber};

    use super::*;
    use crate::socket::Socket;
    use crate::source::SourceOptions;
    use regatta_kit::parse;

    #[test]
    fn a_source_is_paused_and_resumed_and_nothing_else() -> Result {
        let options = parse::<SourceOptions>(["udp-source", "--listen", "0"])?.expect("options");
        let mut source = Source::new(Socket::listen(&options.listen)?, &options)?;
        for kind in [ControlKind::Status, ControlKind::Pause, ControlKind::Resume] {
            assert_eq!(source.refuses(kind), None);
        }
        for kind in [ControlKind::Step, ControlKind::Speed, ControlKind::Robots, ControlKind::Seek]
        {
            assert!(source.refuses(kind).is_some_and(|reason| reason.len() <= 128), "{kind:?}");
        }
        let fleet: FleetName = format!("test-udp-source-{}", std::process::id()).parse()?;
        let ports = ProducerPorts::create(&fleet, 0)?;
        let mut session = Session::new(
            ports,
            Duration::from_millis(20),
            Speed::default(),
            LockstepOptions::default(),
        );
        source.start(&mut session)?;
        let mut frames = Subscriber::open(&fleet)?;
        session.ports().update();
        assert_eq!(frames.latest()?.map(|frame| (frame.tick(), frame.len())), Some((0, 0)));
        Ok(())
    }
}
