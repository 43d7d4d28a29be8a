//! A producer at work: its ports, its clock, its figures and the requests that wait for answers.

use std::time::{Duration, Instant};

use super::clock::Clock;
use super::figures::Figures;
use super::overload::{LateTicks, Overload};
use super::speed::Speed;
use super::{LockstepOptions, Producer, RefusalReason};
use crate::ports::error::{LockstepError, PublishError, ReadError};
use crate::ports::producer::{FrameLoan, ProducerPorts};
#[cfg(feature = "shared-memory")]
use crate::process::termination::Termination;
use crate::records::command::CommandKind;
use crate::records::event::{EventKind, EventRecord, Refusal};
use crate::records::frame::{ClockState, ColumnsMut, FrameHeader};

/// The longest sleep between two checks for control requests.
const CONTROL_POLL: Duration = Duration::from_millis(5);

/// A point in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moment {
    /// Ticks since the start of the run.
    pub tick: u64,
    /// Simulated time since the start of the run, in nanoseconds.
    pub sim_nanos: u64,
}

/// A control request that was carried out or refused, and waits for its answer.
#[derive(Debug)]
pub(super) struct Pending {
    /// The ticket by which to answer it.
    pub(super) ticket: u64,
    /// The number of steps in all after which it is answered.
    pub(super) due: u64,
    /// The reason if it is refused.
    pub(super) refusal: Option<RefusalReason>,
}

/// The shortest time that the readers of a warm-up have for a frame: for the first one, they may
/// have to prepare.
const WARM_UP_TIMEOUT: Duration = Duration::from_mins(1);

/// The settings of a session after its warm-up.
#[derive(Debug)]
struct AfterWarmUp {
    /// The simulated time at which it ends, in nanoseconds.
    from_nanos: u64,
    speed: Speed,
    lockstep: LockstepOptions,
}

/// The readers of the frames of a session.
#[derive(Debug)]
enum Readers {
    /// Processes that nobody waits for, or waits for by name.
    Processes(LockstepOptions),
    /// A driver, which calls them after each frame.
    Driven,
}

/// Runs a [`Producer`], and gives it its ports and its time. [`produce`](crate::produce) makes one
/// from a command line; a larger program makes its own:
///
/// ```no_run
/// use std::time::Duration;
///
/// use regatta_plugin::producer::{LockstepOptions, Producer, Session, Speed};
/// use regatta_plugin::{Error, FleetName, ProducerPorts, Result, Termination};
///
/// fn serve(producer: &mut impl Producer<Error = Error>) -> Result {
///     let ports = ProducerPorts::create(&FleetName::default(), 100)?;
///     let (tick, lockstep) = (Duration::from_millis(20), LockstepOptions::default());
///     Session::new(ports, tick, Speed::default(), lockstep).run(producer, &Termination::watch()?)
/// }
/// ```
#[derive(Debug)]
pub struct Session {
    ports: ProducerPorts,
    pub(super) clock: Clock,
    pub(super) figures: Figures,
    overload: Overload,
    readers: Readers,
    tick_period: Duration,
    pub(super) now: Moment,
    pub(super) started: Instant,
    /// The jumps in time so far.
    jumps: u64,
    /// Whether the last frame of the run is due.
    ended: bool,
    /// Whether the current tick has published a frame.
    frame_sent: bool,
    pub(super) pending: Vec<Pending>,
    /// Ticks that were made while stepping, in all.
    pub(super) steps_made: u64,
    commands_refused: u64,
    /// Answers to refused commands, which belong to the next frame.
    refused: Vec<EventRecord>,
    /// Whether the first frame has been published.
    has_begun: bool,
    /// The time since when shared memory has been full.
    full_since: Option<Instant>,
    frames_left_out: u64,
    /// `None` if there is no warm-up, or it is over.
    after_warm_up: Option<AfterWarmUp>,
}

impl Session {
    /// Creates a session on ports. `tick_period` is simulated time; a producer whose moments are
    /// not that far apart overrides [`next_moment`](Producer::next_moment).
    pub fn new(
        ports: ProducerPorts,
        tick_period: Duration,
        speed: Speed,
        lockstep: LockstepOptions,
    ) -> Self {
        Self::with_readers(ports, tick_period, speed, Readers::Processes(lockstep))
    }

    /// Creates a session of a [`LocalFleet`](crate::LocalFleet): it [begins](Self::begin),
    /// [advances](Self::advance) and [ends](Self::end) as its driver calls it, at full speed. The
    /// driver calls the readers after each frame, so that they are in lockstep.
    pub fn driven(ports: ProducerPorts, tick_period: Duration) -> Self {
        Self::with_readers(ports, tick_period, Speed::Max, Readers::Driven)
    }

    fn with_readers(
        ports: ProducerPorts,
        tick_period: Duration,
        speed: Speed,
        readers: Readers,
    ) -> Self {
        let now = Instant::now();
        Self {
            ports,
            clock: Clock::new(speed, 0, now),
            figures: Figures::new(0, now),
            overload: Overload::new(now),
            readers,
            tick_period,
            now: Moment::default(),
            started: now,
            jumps: 0,
            ended: false,
            frame_sent: false,
            pending: Vec::new(),
            steps_made: 0,
            commands_refused: 0,
            refused: Vec::new(),
            has_begun: false,
            full_since: None,
            frames_left_out: 0,
            after_warm_up: None,
        }
    }

    /// Lets the run begin with a warm-up: so much simulated time is driven at full speed, in
    /// lockstep with readers of these names, so that it repeats bit by bit. Then the speed and the
    /// lockstep of the session begin. A reader that doesn't take part ends the warm-up early.
    #[must_use]
    pub fn warmed_up(mut self, duration: Duration, names: &[String]) -> Self {
        let Readers::Processes(lockstep) = &mut self.readers else { return self };
        if duration.is_zero() {
            return self;
        }
        let others = names.iter().filter(|name| !lockstep.names.contains(name)).cloned();
        let warming = LockstepOptions {
            names: lockstep.names.iter().cloned().chain(others).collect(),
            timeout: lockstep.timeout.max(WARM_UP_TIMEOUT),
        };
        self.after_warm_up = Some(AfterWarmUp {
            from_nanos: duration.as_nanos() as u64,
            speed: self.clock.speed(),
            lockstep: std::mem::replace(lockstep, warming),
        });
        self.clock = Clock::new(Speed::Max, 0, self.started);
        self
    }

    /// Ends the warm-up at its time.
    fn end_warm_up_if_due(&mut self) {
        if !self.is_warming_up() {
            self.end_warm_up();
        }
    }

    /// Ends the warm-up, if there is one: at its time, or when somebody takes over the clock.
    pub(super) fn end_warm_up(&mut self) {
        let Some(AfterWarmUp { speed, lockstep, .. }) = self.after_warm_up.take() else { return };
        self.readers = Readers::Processes(lockstep);
        let now = Instant::now();
        // Somebody who has set another speed since, or has paused, gets it.
        if self.clock.speed() == Speed::Max {
            self.clock.set_speed(speed, self.now.sim_nanos, self.now.sim_nanos, now);
        }
        self.clock.restart(self.next_tick().sim_nanos, now);
        self.figures.restart(self.now.sim_nanos, now);
    }

    /// Runs a producer until it ends or the process is asked to end.
    ///
    /// # Errors
    /// If a port fails, a reader in lockstep doesn't finish a tick in time, or the producer returns
    /// an error.
    #[cfg(feature = "shared-memory")]
    pub fn run<P: Producer>(
        &mut self,
        producer: &mut P,
        termination: &Termination,
    ) -> Result<(), P::Error> {
        self.begin(producer)?;
        while !termination.requested() && self.advance(producer)? {}
        self.end(producer)
    }

    /// Publishes the world and the first frame of a producer.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn begin<P: Producer>(&mut self, producer: &mut P) -> Result<(), P::Error> {
        producer.start(self)?;
        self.has_begun = true;
        // The first frame too: else the speed of processes would decide whether a reader sees it.
        self.wait_for_lockstep()?;
        self.started = Instant::now();
        let first = producer.next_moment(self)?.unwrap_or(self.now);
        self.clock.restart(first.sim_nanos, self.started);
        self.figures.restart(self.now.sim_nanos, self.started);
        Ok(())
    }

    /// Makes the next tick if it is due, and answers requests. Returns `false` after the last one.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn advance<P: Producer>(&mut self, producer: &mut P) -> Result<bool, P::Error> {
        self.end_warm_up_if_due();
        self.answer_requests(producer)?;
        producer.between_ticks(self)?;
        match producer.next_moment(self)? {
            Some(next) if self.is_due(producer, next)? => self.make_tick(producer, next)?,
            Some(_) => {}
            None => return Ok(!self.at_end(producer)?),
        }
        Ok(true)
    }

    /// Publishes the last frame again, as the end of the run.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn end<P: Producer>(&mut self, producer: &mut P) -> Result<(), P::Error> {
        self.ended = true;
        producer.show(self)
    }

    /// Waits for the next moment, but not longer than control requests may wait; returns whether it
    /// is due.
    fn is_due<P: Producer>(&mut self, producer: &mut P, next: Moment) -> Result<bool, P::Error> {
        if self.clock.stands() {
            self.ports.update();
            producer.wait(self, CONTROL_POLL)?;
            return Ok(false);
        }
        let left = self.clock.due(next.sim_nanos).saturating_duration_since(Instant::now());
        if !left.is_zero() {
            producer.wait(self, left.min(CONTROL_POLL))?;
        }
        Ok(left <= CONTROL_POLL)
    }

    fn make_tick<P: Producer>(&mut self, producer: &mut P, next: Moment) -> Result<(), P::Error> {
        let start = Instant::now();
        let before = std::mem::replace(&mut self.now, next);
        self.frame_sent = false;
        producer.tick(self)?;
        self.figures.note_cost(start.elapsed());
        let ticks = self.now.tick.saturating_sub(before.tick).max(u64::from(self.frame_sent));
        self.wait_for_lockstep()?;
        let after = producer.next_moment(self)?.map(|moment| moment.sim_nanos);
        let now = Instant::now();
        self.steps_made += ticks.min(self.clock.steps_left());
        self.clock.finish(ticks, self.now.sim_nanos, after, now);
        self.figures.note_time(self.now.sim_nanos, now);
        let late = LateTicks { all: self.clock.late_ticks(), skipped: self.clock.skipped_ticks() };
        self.overload.note(ticks, late, now, self.ports.participant());
        Ok(())
    }

    fn at_end<P: Producer>(&mut self, producer: &mut P) -> Result<bool, P::Error> {
        if self.clock.steps_left() > 0 {
            self.interrupt_steps("the end of the run");
            self.clock.drop_steps();
        }
        if producer.at_end(self)? {
            self.answer_requests(producer)?;
            return Ok(true);
        }
        self.ports.update();
        producer.wait(self, CONTROL_POLL)?;
        Ok(false)
    }

    /// Waits for the readers in lockstep, if a frame has been published.
    pub(super) fn wait_for_lockstep(&mut self) -> Result<(), LockstepError> {
        #[cfg(feature = "shared-memory")]
        if let Readers::Processes(lockstep) = &self.readers
            && std::mem::take(&mut self.frame_sent)
            && !lockstep.names.is_empty()
        {
            loop {
                match self.ports.wait_done(&lockstep.names, self.now.tick, lockstep.timeout) {
                    Err(LockstepError::Interrupted { .. }) if !Termination::was_requested() => {}
                    Err(LockstepError::Interrupted { .. }) => return Ok(()),
                    Err(error @ LockstepError::Timeout { .. }) if self.after_warm_up.is_some() => {
                        let producer = self.ports.participant().name();
                        crate::tell!("{producer}: the warm-up ends early: {error}");
                        self.end_warm_up();
                        return Ok(());
                    }
                    outcome => return outcome,
                }
            }
        }
        Ok(())
    }

    /// The ports.
    pub fn ports(&mut self) -> &mut ProducerPorts {
        &mut self.ports
    }

    /// The id of the run.
    pub fn run_id(&self) -> u64 {
        self.ports.run_id()
    }

    /// Ticks since the start of the run.
    pub fn tick(&self) -> u64 {
        self.now.tick
    }

    /// Simulated time since the start of the run.
    pub fn sim_time(&self) -> Duration {
        Duration::from_nanos(self.now.sim_nanos)
    }

    /// Wall time since the first tick was due.
    pub fn wall_time(&self) -> Duration {
        self.started.elapsed()
    }

    /// The moment one tick after the current one.
    pub fn next_tick(&self) -> Moment {
        let tick = self.now.tick + 1;
        Moment { tick, sim_nanos: self.tick_period.as_nanos() as u64 * tick }
    }

    /// Sets the tick of the current moment: a producer that knows it only when it reads the frame
    /// does this.
    pub fn set_tick(&mut self, tick: u64) {
        self.now.tick = tick;
    }

    /// Begins to go to another moment: the frames from now on tell that they come after a jump.
    /// [`jump`](Self::jump) ends it.
    pub fn begin_jump(&mut self) {
        self.jumps += 1;
    }

    /// Goes to another moment at once: a replay that seeks does this. Steps that are left are
    /// dropped.
    pub fn jump(&mut self, to: Moment) {
        let now = Instant::now();
        self.now = to;
        self.interrupt_steps("a jump in time");
        self.clock.drop_steps();
        self.clock.restart(to.sim_nanos, now);
        self.figures.restart(to.sim_nanos, now);
    }

    /// Pauses the clock.
    pub fn pause(&mut self) {
        self.interrupt_steps("a pause");
        self.clock.pause();
    }

    /// The state of the clock, as frames report it.
    pub fn clock_state(&self) -> ClockState {
        if self.ended {
            return ClockState::Stopped;
        }
        if self.is_warming_up() { ClockState::WarmingUp } else { self.clock.state() }
    }

    /// Whether the current moment belongs to the warm-up. The frame at its end is the run's first.
    fn is_warming_up(&self) -> bool {
        self.after_warm_up.as_ref().is_some_and(|after| self.now.sim_nanos < after.from_nanos)
    }

    /// The number of ticks that ended after their deadline.
    pub fn late_ticks(&self) -> u64 {
        self.clock.late_ticks()
    }

    /// Whether readers in lockstep are waited for.
    pub fn is_lockstep(&self) -> bool {
        match &self.readers {
            Readers::Processes(lockstep) => !lockstep.names.is_empty(),
            Readers::Driven => true,
        }
    }

    /// Loans the next frame, with a complete header.
    ///
    /// # Errors
    /// As [`ProducerPorts::loan`].
    pub fn loan(&mut self, robots: usize) -> Result<FrameLoan, PublishError> {
        let mut frame = self.ports.loan(robots)?;
        let header = frame.header_mut();
        *header = FrameHeader {
            tick: self.now.tick,
            sim_time_nanos: self.now.sim_nanos,
            late_ticks: self.clock.late_ticks(),
            tick_cost_nanos: self.figures.last_cost().as_nanos() as u64,
            tick_period_nanos: self.tick_period.as_nanos() as u64,
            speed: self.clock.speed().as_f32(),
            clock: self.clock_state() as u32,
            lockstep: u32::from(self.is_lockstep()),
            jumps: self.jumps,
            ..*header
        };
        Ok(frame)
    }

    /// Loans the next frame, or returns `None` where `/dev/shm` is full: then the tick has no
    /// frame, and the run goes on. The user is told. A run in lockstep, or one that hasn't begun,
    /// has an error instead.
    ///
    /// # Errors
    /// As [`loan`](Self::loan).
    pub fn loan_unless_full(&mut self, robots: usize) -> Result<Option<FrameLoan>, PublishError> {
        let loaned = self.loan(robots);
        if loaned.is_ok() && self.full_since.take().is_some() {
            crate::tell!(
                "{}: shared memory has room for frames again; {} frames were left out so far",
                self.ports.participant().name(),
                self.frames_left_out
            );
        }
        match loaned {
            Ok(frame) => Ok(Some(frame)),
            Err(error) => {
                self.unless_full(Err(error))?;
                self.frames_left_out += 1;
                Ok(None)
            }
        }
    }

    /// Passes an outcome on, except that full shared memory is no error: the readers miss what
    /// wasn't published, which the sequence numbers tell them, and the run goes on. The user is
    /// told. A run in lockstep, or one that hasn't begun, has the error.
    ///
    /// # Errors
    /// The outcome's.
    pub fn unless_full(&mut self, outcome: Result<(), PublishError>) -> Result<(), PublishError> {
        match outcome {
            Err(error @ (PublishError::MemoryFull { .. } | PublishError::NoRoom { .. }))
                if self.has_begun && !self.is_lockstep() =>
            {
                if self.full_since.is_none() {
                    self.full_since = Some(Instant::now());
                    crate::tell!("{}: {error}", self.ports.participant().name());
                }
                Ok(())
            }
            outcome => outcome,
        }
    }

    /// The number of frames that were left out because shared memory was full.
    pub fn frames_left_out(&self) -> u64 {
        self.frames_left_out
    }

    /// Publishes a loaned frame and wakes the readers. Everything that belongs to its tick must
    /// have been published before.
    ///
    /// # Errors
    /// As [`FrameLoan::send`].
    pub fn send(&mut self, frame: FrameLoan) -> Result<(), PublishError> {
        if !self.refused.is_empty() {
            let published = self.ports.publish_events(self.now.tick, 0, &self.refused);
            self.unless_full(published)?;
            self.refused.clear();
        }
        frame.send()?;
        self.frame_sent = true;
        self.ports.notify();
        self.ports.update();
        Ok(())
    }

    /// Publishes a frame of `robots` robots whose columns `fill` writes in full. They hold an older
    /// frame before. Where `/dev/shm` is full, the frame is left out, as by
    /// [`loan_unless_full`](Self::loan_unless_full).
    ///
    /// # Errors
    /// As [`loan`](Self::loan) and [`send`](Self::send).
    pub fn publish(
        &mut self,
        robots: usize,
        fill: impl FnOnce(&mut ColumnsMut<'_>),
    ) -> Result<(), PublishError> {
        let Some(mut frame) = self.loan_unless_full(robots)? else { return Ok(()) };
        fill(&mut frame.columns_mut());
        self.send(frame)
    }

    /// Refuses all commands that have arrived, by an event for each, which is published before the
    /// next frame.
    ///
    /// # Errors
    /// [`ReadError::Receive`] if a connection is broken.
    pub fn refuse_commands(&mut self) -> Result<(), ReadError> {
        let mut refused = Vec::new();
        self.ports.take_commands(|_, _, records| {
            let commands = records.iter().filter(|record| record.kind != CommandKind::Leg as u32);
            refused.extend(commands.map(|command| EventRecord {
                token: command.token,
                kind: EventKind::Refused as u32,
                robot: command.robot,
                id: command.id,
                detail: Refusal::NotSteerable as u32,
            }));
        })?;
        self.commands_refused += refused.len() as u64;
        if self.ports.has_event_readers() {
            self.refused.append(&mut refused);
        }
        Ok(())
    }

    /// The number of commands that were [refused](Self::refuse_commands).
    pub fn commands_refused(&self) -> u64 {
        self.commands_refused
    }
}
