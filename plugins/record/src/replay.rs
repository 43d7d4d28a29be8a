//! A replay: a producer like the engine, whose frames come from a recording.

mod control;
mod options;
mod pace;
mod stage;

use std::time::{Duration, Instant};

use regatta_plugin::frame::ClockState;
use regatta_plugin::lockstep::LockstepError;
use regatta_plugin::{Participant, Termination};

use crate::reading::{Reader, Recording, Selection};
use crate::schema::Topic;
use control::Pending;
pub use options::{ReplayArgs, ReplayError};
use pace::Pace;
use stage::{Show, Stage, StageError};

/// Longest sleep between looks at control requests.
const CONTROL_POLL: Duration = Duration::from_millis(5);

/// Replays a recording until it is over or Ctrl-C.
///
/// # Errors
/// [`ReplayError`].
pub fn replay(args: &ReplayArgs) -> Result<(), ReplayError> {
    let termination = Termination::watch().map_err(|error| ReplayError::Signals(error.to_string()))?;
    let recording = Recording::open(&args.file)?;
    let (start, end) = recording.span();
    if !recording.is_closed() {
        regatta_plugin::tell!("replay: {} was never closed; `regatta record --repair` does", args.file.display());
    }
    let participant = Participant::join(&args.fleet, "replay")?;
    let mut topics = recording.topics();
    topics.retain(|topic| !args.no_columns || !topic.is_from_plugin());
    let stage = Stage::open(participant, &topics)?;
    regatta_plugin::tell!(
        "fleet '{}': {} frames from {:.2} s to {:.2} s of {}; Ctrl-C stops",
        args.fleet,
        recording.count(&Topic::Frames),
        start.as_secs_f64(),
        end.as_secs_f64(),
        args.file.display()
    );
    Replay::new(&recording, stage, args, termination)?.run()
}

/// A recording on its way through a fleet's services.
struct Replay<'recording> {
    recording: &'recording Recording,
    reader: Reader<'recording>,
    stage: Stage,
    pace: Pace,
    args: ReplayArgs,
    termination: Termination,
    lockstep_timeout: Duration,
    started: Instant,
    /// Time in the recording of the moment shown last, in nanoseconds.
    time: u64,
    paused: bool,
    /// Ticks that a paused replay is still to go.
    steps_left: u64,
    pending: Vec<Pending>,
    next_ticket: u64,
    warned_of_orders: bool,
}

impl<'recording> Replay<'recording> {
    fn new(
        recording: &'recording Recording,
        stage: Stage,
        args: &ReplayArgs,
        termination: Termination,
    ) -> Result<Self, ReplayError> {
        let (start, _) = recording.span();
        let from = args.from.map_or(start, Into::into);
        let timeout = Duration::try_from_secs_f64(args.lockstep_timeout)
            .map_err(|_| ReplayError::Time(format!("{} is no time: give seconds, 10 say", args.lockstep_timeout)))?;
        let mut replay = Self {
            recording,
            reader: recording.read(&Selection::default())?,
            stage,
            pace: Pace::new(args.speed.0, 0),
            args: args.clone(),
            termination,
            lockstep_timeout: timeout,
            started: Instant::now(),
            time: 0,
            paused: args.paused,
            steps_left: 0,
            pending: Vec::new(),
            next_ticket: 0,
            warned_of_orders: false,
        };
        if let Some(reason) = replay.refuse_time(from) {
            return Err(ReplayError::Time(reason));
        }
        if !args.lockstep.is_empty() {
            replay.gather(from)?;
        }
        replay.seek(from)?;
        Ok(replay)
    }

    fn run(&mut self) -> Result<(), ReplayError> {
        while !self.termination.requested() {
            self.answer_requests()?;
            let next = self.reader.peek()?;
            if next.is_none() && self.is_over()? {
                break;
            }
            if next.is_some_and(|next| self.wait_until_due(next)) {
                self.play()?;
            }
        }
        self.show_again(ClockState::Stopped)
    }

    /// At the end of the recording: whether that is the end.
    fn is_over(&mut self) -> Result<bool, ReplayError> {
        self.steps_left = 0;
        if self.args.repeat && !self.paused {
            let (start, _) = self.recording.span();
            self.seek(start)?;
        } else if self.args.hold || self.args.repeat || self.paused {
            self.stage.update();
            std::thread::sleep(CONTROL_POLL);
            if !self.paused {
                self.paused = true;
                self.show_again(ClockState::Paused)?;
            }
        } else {
            return Ok(true);
        }
        Ok(false)
    }

    /// Sleeps towards the next moment, not longer than control requests may wait; whether it is due.
    fn wait_until_due(&mut self, next: u64) -> bool {
        if self.paused && self.steps_left == 0 {
            self.stage.update();
            std::thread::sleep(CONTROL_POLL);
            return false;
        }
        let rest = self.pace.rest(next);
        if !rest.is_zero() {
            std::thread::sleep(rest.min(CONTROL_POLL));
        }
        rest <= CONTROL_POLL
    }

    /// Shows the next moment on time.
    fn play(&mut self) -> Result<(), ReplayError> {
        let start = Instant::now();
        let tick = self.stage.header().tick;
        if self.show_moment()? {
            let ticks = self.stage.header().tick.saturating_sub(tick).max(1);
            self.steps_left = self.steps_left.saturating_sub(ticks);
        }
        let next = self.reader.peek()?;
        self.pace.played(self.time, start.elapsed(), next);
        Ok(())
    }

    /// Publishes the next moment: all messages of the same time. In lockstep, waits for plugins if there was a frame
    /// among them, which it returns.
    fn show_moment(&mut self) -> Result<bool, ReplayError> {
        let Some(time) = self.reader.peek()? else { return Ok(false) };
        self.time = time;
        let show = self.show(self.clock());
        let mut had_frame = false;
        while self.reader.peek()? == Some(time) {
            let Some(entry) = self.reader.next()? else { break };
            let shown = self.stage.publish(entry.topic, entry.message, show);
            had_frame |= shown.map_err(|error| explain(self.recording, entry.topic, time, error))?;
        }
        if had_frame {
            self.wait_for_lockstep()?;
        }
        Ok(had_frame)
    }

    fn show(&self, clock: ClockState) -> Show {
        Show { clock, speed: self.pace.speed(), lockstep: !self.args.lockstep.is_empty() }
    }

    /// Publishes the newest frame again, for readers to see that the clock has changed.
    fn show_again(&mut self, clock: ClockState) -> Result<(), ReplayError> {
        let Some((time, message)) = self.recording.last_until(&Topic::Frames, self.time)? else { return Ok(()) };
        let show = self.show(clock);
        let shown = self.stage.publish(&Topic::Frames, &message, show);
        shown.map(drop).map_err(|error| explain(self.recording, &Topic::Frames, time, error))
    }

    fn wait_for_lockstep(&mut self) -> Result<(), ReplayError> {
        let (names, tick) = (&self.args.lockstep, self.stage.header().tick);
        while !names.is_empty() {
            match self.stage.producer.wait_done(names, tick, self.lockstep_timeout) {
                Err(LockstepError::Interrupted { .. }) if !self.termination.requested() => {}
                Err(LockstepError::Interrupted { .. }) => return Ok(()),
                outcome => return Ok(outcome?),
            }
        }
        Ok(())
    }

    /// Shows a frame and its world alone, and waits for the plugins in lockstep: so they are there for all that goes
    /// with it.
    fn gather(&mut self, time: Duration) -> Result<(), ReplayError> {
        let until = time.as_nanos() as u64;
        let show = self.show(self.clock());
        for topic in [Topic::World, Topic::Frames] {
            let Some((time, message)) = self.recording.last_until(&topic, until)? else { return Ok(()) };
            let shown = self.stage.publish(&topic, &message, show);
            shown.map_err(|error| explain(self.recording, &topic, time, error))?;
        }
        self.wait_for_lockstep()
    }

    /// Why a time can't be gone to.
    fn refuse_time(&self, time: Duration) -> Option<String> {
        let (start, end) = self.recording.span();
        let [start, end, time] = [start, end, time].map(|time| time.as_secs_f64());
        let outside = !(start..=end).contains(&time);
        outside.then(|| format!("the recording goes from {start:.3} s to {end:.3} s; {time:.3} s is outside"))
    }

    /// Shows the newest frame at or before `time`, and goes on from there.
    fn seek(&mut self, time: Duration) -> Result<(), ReplayError> {
        let time = time.as_nanos() as u64;
        let frame = self.recording.last_until(&Topic::Frames, time)?.map_or(0, |(time, _)| time);
        if frame < self.time {
            self.stage.begin_run()?;
        }
        self.show_state_before(frame)?;
        self.reader = self.recording.read(&Selection { from: frame, topics: Vec::new() })?;
        // The first moments of a recording may have no frame.
        while self.reader.peek()?.is_some() && !self.show_moment()? {}
        self.steps_left = 0;
        self.pace.restart(self.pace.speed(), self.time);
        Ok(())
    }

    /// Publishes what counts until something newer comes: the world, columns, contacts.
    fn show_state_before(&mut self, frame: u64) -> Result<(), ReplayError> {
        let Some(before) = frame.checked_sub(1) else { return Ok(()) };
        let show = self.show(self.clock());
        for topic in self.recording.topics().into_iter().filter(Topic::is_state) {
            let Some((time, message)) = self.recording.last_until(&topic, before)? else { continue };
            let shown = self.stage.publish(&topic, &message, show);
            shown.map_err(|error| explain(self.recording, &topic, time, error))?;
        }
        Ok(())
    }
}

/// Says where in the recording a message is that can't be shown.
fn explain(recording: &Recording, topic: &Topic, time: u64, error: StageError) -> ReplayError {
    match error {
        StageError::Message(error) => recording.malformed(topic, time, error).into(),
        StageError::Replay(error) => error,
    }
}
