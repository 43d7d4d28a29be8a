//! The master as a [`Producer`]: its time is that of the wall clock.

use std::time::Duration;

use regatta_base::graph::Gear;
use regatta_plugin::closure::ClosedEdge;
use regatta_plugin::column::{BATTERY, TYPE};
use regatta_plugin::control::ControlKind;
use regatta_plugin::frame::{ColumnsMut, NO_EDGE, RobotState};
use regatta_plugin::order::{OrderKind, StopAction};
use regatta_plugin::producer::{Producer, RefusalReason, Session};
use regatta_plugin::route::RouteResponse;
use regatta_plugin::{Error, Result, Termination};

use super::Master;
use super::vehicle::Row;

/// The time between two looks at the broker before the first frame.
const LOOK: Duration = Duration::from_millis(5);
/// The largest number of routes that are reported between two ticks.
const MOST_ROUTES: usize = 16;

impl Producer for Master {
    type Error = Error;

    fn start(&mut self, session: &mut Session) -> Result {
        self.run = format!("{:08x}", session.run_id() as u32);
        while self.is_collecting() && !Termination::was_requested() {
            self.listen();
            std::thread::sleep(LOOK);
        }
        self.admit();
        // Robots of the first frame join no fleet that is there already.
        self.events.clear();
        session.ports().publish_world(&self.world)?;
        self.publish_columns(session)?;
        self.show(session)
    }

    fn tick(&mut self, session: &mut Session) -> Result {
        let before = self.vehicles.len();
        self.admit();
        if self.vehicles.len() != before || session.tick().is_multiple_of(ticks(session)) {
            self.publish_columns(session)?;
        }
        self.work(session)?;
        self.close_around();
        let has_changed = self.note_closures();
        let tick = session.tick();
        let rows = self.rows();
        if !self.events.is_empty() {
            let published = session.ports().publish_events(tick, 0, &self.events);
            session.unless_full(published)?;
            self.events.clear();
        }
        if has_changed {
            let edges = self.published.iter().map(|edge| self.world.edges[*edge as usize].id);
            let mut closed: Vec<ClosedEdge> = edges.map(|edge| ClosedEdge { edge }).collect();
            closed.sort_unstable();
            let published = session.ports().publish_closures(tick, &closed);
            session.unless_full(published)?;
        }
        if !self.command_log.is_empty() {
            let published = session.ports().publish_command_log(tick, &self.command_log);
            session.unless_full(published)?;
            self.command_log.clear();
        }
        self.publish_rows(session, &rows)
    }

    fn show(&mut self, session: &mut Session) -> Result {
        let rows = self.rows();
        self.publish_rows(session, &rows)
    }

    fn robots_by_state(&self) -> [u32; RobotState::COUNT] {
        let mut counts = [0; RobotState::COUNT];
        for (_, vehicle) in &self.vehicles {
            counts[vehicle.shown() as usize] += 1;
        }
        counts
    }

    fn between_ticks(&mut self, session: &mut Session) -> Result {
        self.work(session)?;
        let (run_id, tick) = (session.run_id(), session.tick());
        let Self { routes, vehicles, roads, .. } = self;
        routes.answer(MOST_ROUTES, |request| {
            let response = RouteResponse::unknown(run_id, tick, request.robot);
            let vehicle = vehicles.get(request.robot as usize).map(|(_, vehicle)| vehicle);
            let Some(course) = vehicle.and_then(|vehicle| vehicle.course()) else {
                return response;
            };
            let (first, end) = (course.first(roads), course.base_end(roads));
            let legs: Vec<_> = (first..).map_while(|number| course.leg(number)).collect();
            let released = end.saturating_sub(first) as usize;
            let edges = legs.iter().map(|leg| (leg.edge.0, leg.gear == Gear::Reverse));
            response.with_legs(released, legs.len(), edges)
        })?;
        Ok(())
    }

    fn refuses(&self, kind: ControlKind) -> Option<RefusalReason> {
        let reason = match kind {
            ControlKind::Status => return None,
            ControlKind::Robots => "the robots are vehicles on a broker: connect others there",
            _ => "the robots are vehicles outside of this program: their time can't be changed",
        };
        Some(reason.to_owned())
    }
}

/// The ticks in a second.
fn ticks(session: &Session) -> u64 {
    let period = session.next_tick().sim_nanos / session.next_tick().tick.max(1);
    (1_000_000_000 / period.max(1)).max(1)
}

impl Master {
    /// Takes what has come, and passes on what follows of it.
    fn work(&mut self, session: &mut Session) -> Result {
        self.listen();
        self.take_orders(session.run_id())?;
        let is_logged = session.ports().has_command_log_readers();
        let mut samples = Vec::new();
        session
            .ports()
            .take_commands(|_, authority, records| samples.push((authority, records.to_vec())))?;
        for (authority, records) in samples {
            self.take_commands(&records, authority);
            if is_logged {
                self.command_log.extend_from_slice(&records);
            }
        }
        self.serve();
        Ok(())
    }

    /// Takes the order log: robots at stops have something to do there.
    fn take_orders(&mut self, run_id: u64) -> Result {
        let Self { orders, vehicles, options, .. } = self;
        orders.take(|tick| -> Result {
            let arrived = tick.records.iter().filter(|record| {
                tick.header.run_id == run_id && record.kind() == Some(OrderKind::Arrived)
            });
            for record in arrived {
                let action = StopAction::from_number(record.action).unwrap_or_default();
                if let Some((_, vehicle)) = vehicles.get_mut(record.robot as usize) {
                    vehicle.handle(action, |kind| options.parameters_of(kind));
                }
            }
            Ok(())
        })
    }

    fn rows(&mut self) -> Vec<Option<Row>> {
        let Self { vehicles, roads, .. } = self;
        vehicles.iter_mut().map(|(_, vehicle)| vehicle.row(roads)).collect()
    }

    fn publish_rows(&mut self, session: &mut Session, rows: &[Option<Row>]) -> Result {
        let origin = self.world.origin;
        Ok(session.publish(rows.len(), |columns| {
            for (robot, row) in rows.iter().enumerate() {
                write_row(columns, robot, row.as_ref(), origin);
            }
        })?)
    }

    /// Publishes the types and the charges of robots.
    fn publish_columns(&mut self, session: &mut Session) -> Result {
        let tick = session.tick();
        let types = self.vehicles.iter().map(|(_, vehicle)| vehicle.robot_type() as f32);
        let types: Vec<f32> = types.collect();
        let published = session.ports().publish_column(TYPE.name(), tick, &types);
        session.unless_full(published)?;
        if self.world.robot_types.iter().all(|kind| kind.battery_capacity <= 0.0) {
            return Ok(());
        }
        let charges = self.vehicles.iter().map(|(_, vehicle)| vehicle.charge());
        let charges: Vec<f32> =
            charges.map(|charge| charge.map_or(f32::NAN, |it| it as f32)).collect();
        let published = session.ports().publish_column(BATTERY.name(), tick, &charges);
        Ok(session.unless_full(published)?)
    }
}

fn write_row(columns: &mut ColumnsMut<'_>, robot: usize, row: Option<&Row>, origin: [f64; 2]) {
    let Some(row) = row else {
        columns.state[robot] = RobotState::Absent as u8;
        return;
    };
    columns.x[robot] = (row.position[0] - origin[0]) as f32;
    columns.y[robot] = (row.position[1] - origin[1]) as f32;
    columns.theta[robot] = row.theta as f32;
    columns.speed[robot] = row.speed as f32;
    let (edge, s) = row.place.unwrap_or((NO_EDGE, 0.0));
    (columns.edge[robot], columns.s[robot]) = (edge, s as f32);
    columns.state[robot] = row.state as u8;
}
