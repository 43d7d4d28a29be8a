//! A tick: take orders → step → publish.

mod control;
mod options;
mod population;
mod routes;
mod stats;

use std::sync::Arc;
use std::time::{Duration, Instant};

use regatta_plugin::event::EventHeader;
use regatta_plugin::frame::{ClockState, FrameHeader};
use regatta_plugin::lockstep::LockstepError;
use regatta_plugin::order::{OrderHeader, OrderRecord};
use regatta_plugin::publish::{FrameLoan, Producer};
use regatta_plugin::{Participant, RouteServer, Termination};

use crate::clock::Clock;
use crate::digest::Digest;
use crate::fleet::{Events, Fleet, FleetConfig};
use crate::graph::arc_length::Tracks;
use crate::motion::Isa;
use crate::scenario::{MAX_ROBOTS, Scenario};
pub use options::{EngineError, Options, Summary};
use stats::TickStats;

/// Longest sleep between looks at control requests.
const CONTROL_POLL: Duration = Duration::from_millis(5);

/// Most events that one tick publishes; the rest is counted.
const MAX_EVENTS: usize = 1 << 18;

/// One fleet, from its first frame to its last.
pub struct Engine {
    options: Options,
    scenario: Scenario,
    fleet: Fleet,
    producer: Producer,
    routes: RouteServer,
    started: Instant,
    clock: Clock,
    paused: bool,
    /// Ticks that a paused clock still has to make.
    steps_left: u64,
    tick: u64,
    stats: TickStats,
    events: Events,
    /// What the column `type` last told.
    kinds: Vec<u16>,
    tracks: Arc<Tracks>,
    orders: Vec<(OrderHeader, Vec<OrderRecord>)>,
    /// The orders of this tick, if anybody reads the order log.
    order_log: Vec<OrderRecord>,
    digest: Option<Digest>,
    pending: Vec<control::Pending>,
    next_ticket: u64,
}

impl Engine {
    /// Compiles the scenario, opens the fleet's services and puts the robots on the road.
    ///
    /// # Errors
    /// If another producer of that fleet runs, shared memory can't be had, or the options don't fit the
    /// scenario or the machine.
    pub fn new(scenario: Scenario, options: Options) -> Result<Self, EngineError> {
        let robots = options.robots.unwrap_or_else(|| scenario.robots());
        if robots > MAX_ROBOTS {
            return Err(EngineError::TooManyRobots(robots));
        }
        let participant = Participant::join(&options.fleet, "engine")?;
        let producer = Producer::create_on(participant, robots as usize)?;
        let tracks = Arc::new(Tracks::compile(&scenario.graph));
        let config = FleetConfig {
            types: scenario.robot_types.clone(),
            tick_period: scenario.tick_period,
            seed: scenario.seed,
            isa: options.isa.unwrap_or_else(Isa::detect),
            threads: options.threads,
            most_robots: MAX_ROBOTS,
        };
        let fleet = Fleet::new(scenario.graph.clone(), tracks.clone(), config)?;
        let now = Instant::now();
        let mut engine = Self {
            started: now,
            clock: Clock::new(scenario.tick_period, options.speed, now),
            digest: options.digest.then(Digest::default),
            stats: TickStats::new(now),
            paused: false,
            steps_left: 0,
            tick: 0,
            events: Events::new(MAX_EVENTS),
            kinds: Vec::new(),
            tracks,
            orders: Vec::new(),
            order_log: Vec::new(),
            pending: Vec::new(),
            next_ticket: 0,
            options,
            scenario,
            fleet,
            routes: RouteServer::open_on(producer.participant())?,
            producer,
        };
        engine.events.set_wanted(engine.producer.has_event_readers());
        engine.set_robots(robots);
        engine.publish_world()?;
        Ok(engine)
    }

    /// Runs until the wanted number of ticks is made or the process is asked to end.
    ///
    /// # Errors
    /// If shared memory fails, or a plugin in lockstep doesn't finish a tick in time.
    pub fn run(&mut self, termination: &Termination) -> Result<Summary, EngineError> {
        self.publish_types()?;
        self.republish(self.clock_state())?;
        // The frame before the first step too: or else it would depend on who was faster whether a plugin sees it.
        self.wait_for_lockstep(termination)?;
        self.started = Instant::now();
        self.clock.restart(self.clock.speed(), self.started);
        self.stats.restart(self.tick, self.started);
        while !termination.requested() && self.options.ticks.is_none_or(|ticks| self.tick < ticks) {
            self.answer_requests()?;
            self.answer_routes()?;
            if self.wait_until_due() {
                self.make_tick(termination)?;
            }
        }
        self.republish(ClockState::Stopped)?;
        Ok(Summary {
            ticks: self.tick,
            sim_time: self.sim_time(),
            wall_time: self.started.elapsed(),
            late_ticks: self.clock.late_ticks(),
            digest: self.digest.as_ref().map(Digest::value),
        })
    }

    /// Sleeps towards the next tick, not longer than control requests may wait; whether the tick is due.
    fn wait_until_due(&mut self) -> bool {
        if self.paused && self.steps_left == 0 {
            self.producer.update();
            std::thread::sleep(CONTROL_POLL);
            return false;
        }
        let rest = self.clock.release().saturating_duration_since(Instant::now());
        if !rest.is_zero() {
            std::thread::sleep(rest.min(CONTROL_POLL));
        }
        rest <= CONTROL_POLL
    }

    fn make_tick(&mut self, termination: &Termination) -> Result<(), EngineError> {
        let start = Instant::now();
        self.events.set_wanted(self.producer.has_event_readers());
        self.take_orders()?;
        self.tick += 1;
        if self.publishes() {
            let header = self.describe(self.clock_state());
            let mut frame = self.producer.loan(self.fleet.robots())?;
            self.fleet.step(Some(frame.columns_mut()), &mut self.events);
            self.stats.tick_done(start.elapsed());
            send(frame, header, self.digest.as_mut())?;
            self.producer.notify();
        } else {
            self.fleet.step(None, &mut self.events);
            self.stats.tick_done(start.elapsed());
        }
        self.publish_events()?;
        self.producer.update();
        self.end_tick(termination)
    }

    /// Waits for plugins in lockstep, and notes whether the tick was in time.
    fn end_tick(&mut self, termination: &Termination) -> Result<(), EngineError> {
        if self.publishes() {
            self.wait_for_lockstep(termination)?;
        }
        let now = Instant::now();
        if self.paused {
            self.steps_left -= 1;
        }
        self.clock.tick_done(now);
        self.stats.note_time(self.tick, self.scenario.tick_period, now);
        Ok(())
    }

    /// Whether this tick has a frame.
    fn publishes(&self) -> bool {
        self.tick.is_multiple_of(u64::from(self.scenario.ticks_per_frame))
    }

    fn wait_for_lockstep(&mut self, termination: &Termination) -> Result<(), EngineError> {
        let (names, timeout) = (&self.options.lockstep, self.options.lockstep_timeout);
        while !names.is_empty() {
            match self.producer.wait_done(names, self.tick, timeout) {
                Err(LockstepError::Interrupted { .. }) if !termination.requested() => {}
                Err(LockstepError::Interrupted { .. }) => return Ok(()),
                outcome => return Ok(outcome?),
            }
        }
        Ok(())
    }

    /// Applies the orders that came since the last tick; in lockstep by sender, so that the order in which
    /// processes were scheduled doesn't count.
    fn take_orders(&mut self) -> Result<(), EngineError> {
        let logged = self.producer.has_order_log_readers();
        let Self { producer, fleet, events, orders, order_log, options, .. } = self;
        let mut came = false;
        let mut apply = |records: &[OrderRecord]| {
            came = true;
            fleet.apply(records, events);
            if logged {
                order_log.extend_from_slice(records);
            }
        };
        if options.lockstep.is_empty() {
            producer.take_orders(|_, records| apply(records))?;
        } else {
            producer.take_orders(|header, records| orders.push((*header, records.to_vec())))?;
            orders.sort_by_key(|(header, _)| header.sender);
            orders.drain(..).for_each(|(_, records)| apply(&records));
        }
        if !came || self.fleet.robot_types() == self.kinds { Ok(()) } else { self.publish_types() }
    }

    fn publish_events(&mut self) -> Result<(), EngineError> {
        if !self.events.records().is_empty() {
            let header = EventHeader { tick: self.tick, dropped: self.events.dropped(), ..EventHeader::default() };
            self.producer.publish_events(&header, self.events.records())?;
            self.events.clear();
        }
        if !self.order_log.is_empty() {
            self.producer.publish_order_log(self.tick, &self.order_log)?;
            self.order_log.clear();
        }
        Ok(())
    }

    /// Publishes the poses as they are, for readers to see that the clock or the fleet has changed.
    fn republish(&mut self, clock: ClockState) -> Result<(), EngineError> {
        let header = self.describe(clock);
        let mut frame = self.producer.loan(self.fleet.robots())?;
        self.fleet.write(frame.columns_mut());
        let first = self.tick == 0 && clock != ClockState::Stopped;
        send(frame, header, self.digest.as_mut().filter(|_| first))?;
        self.producer.notify();
        self.producer.update();
        Ok(())
    }

    /// What changes from frame to frame in a header.
    fn describe(&self, clock: ClockState) -> FrameHeader {
        FrameHeader {
            tick: self.tick,
            sim_time_nanos: self.sim_time().as_nanos() as u64,
            late_ticks: self.clock.late_ticks(),
            tick_cost_nanos: self.stats.last_cost().as_nanos() as u64,
            tick_period_nanos: self.scenario.tick_period.as_nanos() as u64,
            speed: self.clock.speed().as_f32(),
            clock: clock as u32,
            lockstep: u32::from(!self.options.lockstep.is_empty()),
            ..FrameHeader::default()
        }
    }

    fn sim_time(&self) -> Duration {
        Duration::from_nanos(self.scenario.tick_period.as_nanos() as u64 * self.tick)
    }

    fn clock_state(&self) -> ClockState {
        if self.paused { ClockState::Paused } else { ClockState::Running }
    }
}

fn send(mut frame: FrameLoan, description: FrameHeader, digest: Option<&mut Digest>) -> Result<(), EngineError> {
    let header = frame.header_mut();
    let FrameHeader { run_id, world_revision, robots, stride_lines, .. } = *header;
    *header = FrameHeader { run_id, world_revision, robots, stride_lines, ..description };
    if let Some(digest) = digest {
        digest.frame(description.tick, robots as usize, &frame.columns_mut());
    }
    frame.send()?;
    Ok(())
}
