//! A producer whose values are known for each tick, and which accepts every command.

use regatta_plugin::command::CommandKind;
use regatta_plugin::event::{EventKind, EventRecord};
use regatta_plugin::frame::RobotState;
use regatta_plugin::producer::{Producer, Session};
use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};
use regatta_plugin::{Error, Result};

/// The value of a robot at a tick: any bits but those of NaN.
pub fn value(tick: u64, row: usize) -> f32 {
    (tick as f32 * 0.37 + row as f32).sin() * 1e3
}

/// The name of the node of the world.
pub const NODE: &str = "dock 1";

#[derive(Default)]
pub struct Engine {
    events: Vec<EventRecord>,
}

impl Engine {
    pub const ROBOTS: usize = 300;

    fn world() -> WorldData {
        let mut world = WorldData::default();
        let name = world.texts.add(NODE);
        world.nodes = vec![NodeRecord { id: 1, name, ..NodeRecord::default() }; 2];
        let edge = EdgeRecord { id: 7, destination: 1, length: 3.0, ..EdgeRecord::default() };
        world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [3.0, 0.0])]);
        world
    }
}

impl Producer for Engine {
    type Error = Error;

    fn start(&mut self, session: &mut Session) -> Result {
        session.ports().publish_world(&Self::world())?;
        // A column that is published only once.
        session.ports().publish_column("type", 0, &[0.0; Self::ROBOTS])?;
        self.tick(session)
    }

    fn tick(&mut self, session: &mut Session) -> Result {
        let tick = session.tick();
        session.ports().publish_events(tick, 0, &self.events)?;
        self.events.clear();
        session.ports().publish_column("battery", tick, &[tick as f32; Self::ROBOTS])?;
        self.show(session)
    }

    fn show(&mut self, session: &mut Session) -> Result {
        let tick = session.tick();
        Ok(session.publish(Self::ROBOTS, |columns| {
            for row in 0..Self::ROBOTS {
                for column in [&mut *columns.x, columns.y, columns.theta, columns.speed, columns.s]
                {
                    column[row] = value(tick, row);
                }
                (columns.edge[row], columns.state[row]) = (0, RobotState::Driving as u8);
            }
        })?)
    }

    fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        [0, Self::ROBOTS as u32, 0, 0, 0, 0, 0, 0]
    }

    fn between_ticks(&mut self, session: &mut Session) -> Result {
        session.ports().take_commands(|_, _, records| {
            let commands = records.iter().filter(|record| record.kind != CommandKind::Leg as u32);
            self.events.extend(commands.map(|command| EventRecord {
                token: command.token,
                kind: EventKind::Accepted as u32,
                robot: command.robot,
                id: records.len() as u32,
                detail: 0,
            }));
        })?;
        Ok(())
    }
}
