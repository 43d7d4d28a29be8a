//! The recorder: a plugin that hands all that a fleet tells to a [`Sink`].

use std::path::PathBuf;
use std::time::Duration;

use regatta_plugin::frame::FrameHeader;
use regatta_plugin::{Error, Events, Frame, Participant, Plugin, Result, World};

use crate::schema::Topic;
use crate::sink::{Sink, SinkError, Tally};
use crate::sources::Sources;
use crate::timeline::{Gaps, Timeline};
use crate::{encode, scene};

/// Records a fleet until it is stopped.
#[derive(Debug)]
pub(crate) struct Recorder {
    path: PathBuf,
    sink: Sink,
    every: u64,
    poses: Option<Poses>,
    sources: Option<Sources>,
    timeline: Timeline,
    sees_all: bool,
    gaps: Gaps,
    /// Samples of anything but frames that were missed.
    others_missed: u64,
    /// Frames of the run, by distinct ticks.
    frames_seen: u64,
    /// Whether the frames of this tick are recorded.
    wanted: bool,
    newest: FrameHeader,
    /// What came ahead of the frame that tells its time.
    waiting: Vec<Waiting>,
}

/// How to record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// Record one frame of so many; at least 1.
    pub every: u64,
    /// Time between poses for general tools; none if `None`.
    pub poses_period: Option<Duration>,
    /// Whether every frame is looked at, so that one that isn't seen is one that was missed.
    pub sees_all: bool,
}

/// When poses are due.
#[derive(Clone, Copy, Debug)]
struct Poses {
    period: u64,
    run_id: u64,
    next: u64,
}

#[derive(Debug)]
struct Waiting {
    topic: Topic,
    /// Of an earlier moment than the frame; `None` for the frame's.
    tick: Option<(u64, u64)>,
    message: Vec<u8>,
}

impl Recorder {
    pub fn new(path: PathBuf, sink: Sink, settings: Settings) -> Self {
        let poses = |period: Duration| Poses { period: period.as_nanos() as u64, run_id: 0, next: 0 };
        Self {
            path,
            sink,
            every: settings.every,
            poses: settings.poses_period.map(poses),
            sources: None,
            timeline: Timeline::default(),
            sees_all: settings.sees_all,
            gaps: Gaps::default(),
            others_missed: 0,
            frames_seen: 0,
            wanted: true,
            newest: FrameHeader::default(),
            waiting: Vec::new(),
        }
    }

    fn take_waiting(&mut self) {
        for Waiting { topic, tick, message } in self.waiting.drain(..) {
            let log_time = tick.map_or(self.timeline.now(), |(run_id, tick)| self.timeline.time_of(run_id, tick));
            self.sink.send(topic, log_time, self.newest.wall_time_nanos, message);
        }
    }

    fn take_frame(&mut self, frame: &Frame<'_>, log_time: u64) {
        if frame.run_id() != self.newest.run_id {
            self.frames_seen = 0;
        }
        if self.gaps.note(frame.run_id(), frame.tick()) {
            self.wanted = self.frames_seen.is_multiple_of(self.every);
            self.frames_seen += 1;
        }
        self.newest = *frame.header();
        if self.wanted {
            self.sink.send(Topic::Frames, log_time, self.newest.wall_time_nanos, encode::frame(frame));
        }
        if self.poses.as_mut().is_some_and(|poses| poses.are_due(frame)) {
            for (topic, message) in
                [(Topic::Poses, scene::poses(frame, log_time)), (Topic::Robots, scene::robots(frame, log_time))]
            {
                self.sink.send(topic, log_time, self.newest.wall_time_nanos, message);
            }
        }
    }

    fn take_sources(&mut self) -> Result {
        let Self { sources, sink, timeline, newest, others_missed, sees_all, .. } = self;
        let Some(sources) = sources else { return Ok(()) };
        sources.poll(|found| {
            // Whoever looks at some frames only wants some of what goes with them.
            *others_missed += if *sees_all || !found.topic.is_state() { found.missed } else { 0 };
            sink.send(found.topic, timeline.time_of(found.run_id, found.tick), newest.wall_time_nanos, found.message);
        })
    }

    /// Frames that the producer published and the recorder never saw.
    fn frames_missed(&self) -> u64 {
        if self.sees_all { self.gaps.missed() } else { 0 }
    }

    /// The recording in one line.
    fn report(&self, tally: &Tally) -> String {
        let lost = [
            (self.frames_missed(), "that the recorder didn't see (too slow, or never published)"),
            (tally.frames_dropped, "that the disk was too slow for"),
            (tally.frames_failed, "that could not be written"),
        ];
        let lost = lost.iter().filter(|(count, _)| *count > 0).map(|(count, why)| format!("{count} {why}"));
        let lost = match lost.collect::<Vec<_>>().join(", ") {
            none if none.is_empty() => "no frame lost".to_owned(),
            lost => format!("frames lost: {lost}"),
        };
        let others = match tally.others_dropped + self.others_missed {
            0 => String::new(),
            count => format!("; {count} other messages lost"),
        };
        let (path, seconds) = (self.path.display(), self.timeline.now() as f64 * 1e-9);
        let megabytes = tally.bytes as f64 * 1e-6;
        format!("{path}: {} frames up to {seconds:.2} s, {megabytes:.1} MB; {lost}{others}", tally.frames)
    }
}

impl Poses {
    fn are_due(&mut self, frame: &Frame<'_>) -> bool {
        let now = frame.header().sim_time_nanos;
        if frame.run_id() != self.run_id {
            (self.run_id, self.next) = (frame.run_id(), now);
        }
        let due = now >= self.next;
        if due {
            // On a grid, so that the rate holds whatever the ticks' period is.
            self.next = (self.next + self.period).max(now.saturating_sub(self.period));
        }
        due
    }
}

impl Plugin for Recorder {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.sources = Some(Sources::open(fleet)?);
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        let now = self.timeline.now();
        for (topic, message) in [
            (Topic::World, encode::world(world)),
            (Topic::Graph, scene::graph(world, now)),
            (Topic::GraphPoints, scene::graph_points(world, now)),
        ] {
            self.waiting.push(Waiting { topic, tick: None, message });
        }
        Ok(())
    }

    fn wants_events(&self) -> bool {
        true
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        let tick = Some((events.header.run_id, events.header.tick));
        self.others_missed += events.missed;
        self.waiting.push(Waiting { topic: Topic::Events, tick, message: encode::events(events) });
        Ok(())
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        let log_time = self.timeline.advance(frame.header());
        let begins_run = frame.run_id() != self.newest.run_id;
        if let Some(sources) = self.sources.as_mut().filter(|_| begins_run && frame.header().lockstep != 0) {
            // The producer waits: nothing is missed meanwhile.
            sources.open_columns()?;
        }
        self.take_waiting();
        self.take_frame(frame, log_time);
        self.take_sources()
    }

    fn on_idle(&mut self, _has_producer: bool) -> Result {
        // What comes after the last frame, or while the clock stands. Before the first there is no clock to put it on.
        if self.newest.run_id == 0 { Ok(()) } else { self.take_sources() }
    }

    fn on_stop(&mut self) -> Result {
        self.take_waiting();
        let polled = self.take_sources();
        let missed = [("frames_missed", self.frames_missed()), ("others_missed", self.others_missed)];
        self.sink.note("regatta.end", &missed.map(|(name, count)| (name, count.to_string())));
        let (tally, error) = self.sink.finish();
        regatta_plugin::tell!("record: {}", self.report(&tally));
        match error {
            Some(error @ SinkError::Write { .. }) => {
                Err(Error::new(format_args!("{error}; the recording is incomplete")))
            }
            Some(error) => Err(error.into()),
            None => polled,
        }
    }
}
