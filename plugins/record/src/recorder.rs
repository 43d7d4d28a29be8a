//! The recorder: a plugin that passes everything a fleet publishes to a [`Sink`].

use std::collections::BTreeMap;
use std::time::Duration;

use regatta_plugin::frame::FrameHeader;
use regatta_plugin::{Error, Events, Frame, Participant, Plugin, Result, World};

use crate::arguments::TopicSet;
use crate::schema::Topic;
use crate::sink::{Payload, Sink, SinkError, Tally};
use crate::sources::{Sample, Sources};
use crate::thinning::{Held, Thinning};
use crate::timeline::Timeline;
use crate::{encode, scene};

/// The plugin that records a fleet until it is stopped.
#[derive(Debug)]
pub(crate) struct Recorder {
    sink: Sink,
    topics: TopicSet,
    every: u64,
    /// `None` if every frame is recorded, and so everything else.
    thinning: Option<Thinning>,
    poses: Option<Poses>,
    /// The run and the tick of the contacts that are recorded as markers.
    marked: Option<(u64, u64)>,
    sources: Option<Sources>,
    timeline: Timeline,
    sees_all: bool,
    /// The number of frames that the producer published but the recorder didn't get.
    frames_missed: u64,
    /// The number of missed messages on other topics than frames.
    others_missed: u64,
    /// The number of frames seen in the run, by distinct ticks.
    frames_seen: u64,
    /// Whether the frames of the current tick are recorded.
    records_tick: bool,
    newest: FrameHeader,
    /// The messages that arrived before the frame that determines their time.
    pending: Vec<Pending>,
    /// During a warm-up, the newest sample of each state: its end is the beginning of a recording.
    warm_up: Option<BTreeMap<Topic, Sample>>,
}

/// The settings of a [`Recorder`].
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// The topics to record.
    pub topics: TopicSet,
    /// Record every `every`th frame; at least 1.
    pub every: u64,
    /// Simulated time between poses for general tools; `None` for no poses.
    pub poses_period: Option<Duration>,
    /// Whether the recorder receives every frame, so that a frame it doesn't see was missed.
    pub sees_all: bool,
}

/// The schedule of poses for general tools, in nanoseconds of simulated time.
#[derive(Clone, Copy, Debug)]
struct Poses {
    period: u64,
    run_id: u64,
    next: u64,
}

/// A message that waits for the next frame.
#[derive(Debug)]
struct Pending {
    topic: Topic,
    /// The run and tick of the message; `None` for those of the next frame.
    tick: Option<(u64, u64)>,
    message: Vec<u8>,
}

impl Recorder {
    pub fn new(sink: Sink, settings: Settings) -> Self {
        let period = settings.poses_period.map(|period| period.as_nanos() as u64);
        Self {
            sink,
            topics: settings.topics,
            every: settings.every,
            thinning: (settings.every > 1 || !settings.sees_all).then(Thinning::default),
            poses: period.map(|period| Poses { period, run_id: 0, next: 0 }),
            marked: None,
            sources: None,
            timeline: Timeline::default(),
            sees_all: settings.sees_all,
            frames_missed: 0,
            others_missed: 0,
            frames_seen: 0,
            records_tick: true,
            newest: FrameHeader::default(),
            pending: Vec::new(),
            warm_up: None,
        }
    }

    /// Leaves out what happens in a warm-up: of worlds, columns, contacts and facilities it keeps
    /// the newest.
    fn skip_warm_up(&mut self) -> Result {
        self.pending.retain(|pending| pending.tick.is_none());
        let states = self.warm_up.get_or_insert_default();
        let Some(sources) = &mut self.sources else { return Ok(()) };
        sources.poll(|sample| {
            if sample.topic.is_state() {
                states.insert(sample.topic.clone(), sample);
            }
        })
    }

    /// Records the states that a warm-up has left, at the time of the run's first frame.
    fn record_warm_up(&mut self) {
        let log_time = self.timeline.now();
        for (topic, sample) in self.warm_up.take().into_iter().flatten() {
            self.sink.send(topic, log_time, self.newest.wall_time_nanos, sample.payload);
        }
    }

    fn record_pending(&mut self) {
        for Pending { topic, tick, message } in self.pending.drain(..) {
            let log_time = match tick {
                Some((run_id, tick)) => self.timeline.time_of(run_id, tick),
                None => self.timeline.now(),
            };
            if self.topics.includes(&topic) {
                let message = Payload::Message(message);
                self.sink.send(topic, log_time, self.newest.wall_time_nanos, message);
            }
        }
    }

    fn record_frame(&mut self, frame: &Frame<'_>, log_time: u64) {
        if frame.run_id() != self.newest.run_id {
            self.frames_seen = 0;
        }
        if self.sees_all && self.warm_up.is_none() {
            self.frames_missed += frame.missed();
        }
        if self.frames_seen == 0 || frame.tick() != self.newest.tick {
            self.records_tick = self.frames_seen.is_multiple_of(self.every);
            self.frames_seen += 1;
        }
        self.newest = *frame.header();
        if self.records_tick {
            if self.topics.includes(&Topic::Frames) {
                self.send(Topic::Frames, log_time, encode::frame(frame));
            }
            if let Some(thinning) = &mut self.thinning {
                let held = thinning.record_frame(frame.run_id(), frame.tick());
                self.record_held(held);
            }
        }
        if self.poses.as_mut().is_some_and(|poses| poses.are_due(frame)) {
            if self.topics.includes(&Topic::Poses) {
                self.send(Topic::Poses, log_time, scene::poses(frame, log_time));
            }
            if self.topics.includes(&Topic::Robots) {
                self.send(Topic::Robots, log_time, scene::robots(frame, log_time));
            }
            self.record_markers();
        }
    }

    /// Records the newest contacts as markers, unless they are recorded already.
    fn record_markers(&mut self) {
        let contacts = self.sources.as_ref().and_then(Sources::contacts);
        let Some(contacts) = contacts.filter(|_| self.topics.includes(&Topic::ContactMarkers))
        else {
            return;
        };
        let (run_id, tick) = (contacts.header.run_id, contacts.header.tick);
        if run_id == self.newest.run_id
            && self.marked.replace((run_id, tick)) != Some((run_id, tick))
        {
            let log_time = self.timeline.time_of(run_id, tick);
            let message = scene::contact_markers(contacts.pairs, log_time);
            self.send(Topic::ContactMarkers, log_time, message);
        }
    }

    fn send(&mut self, topic: Topic, log_time: u64, message: Vec<u8>) {
        self.sink.send(topic, log_time, self.newest.wall_time_nanos, Payload::Message(message));
    }

    /// Records samples that belong to a recorded frame.
    fn record_held(&mut self, held: Vec<Held>) {
        for Held { sample, log_time } in held {
            self.sink.send(sample.topic, log_time, self.newest.wall_time_nanos, sample.payload);
        }
    }

    fn record_sources(&mut self) -> Result {
        let Self { sources, sink, thinning, timeline, newest, others_missed, sees_all, .. } = self;
        let Some(sources) = sources else { return Ok(()) };
        sources.poll(|sample| {
            // A recorder that skips frames also skips the columns and contacts between them.
            *others_missed += if *sees_all || !sample.topic.is_state() { sample.missed } else { 0 };
            let log_time = timeline.time_of(sample.run_id, sample.tick);
            let recorded = match thinning.as_mut().filter(|_| sample.topic.is_state()) {
                Some(thinning) => thinning.take(sample, log_time),
                None => [Some(Held { sample, log_time }), None],
            };
            for Held { sample, log_time } in recorded.into_iter().flatten() {
                sink.send(sample.topic, log_time, newest.wall_time_nanos, sample.payload);
            }
        })
    }

    /// Records the other sources, after the first frame. Before it, there is no time to record.
    fn record_sources_if_started(&mut self) -> Result {
        let has_started = self.newest.run_id != 0 && self.warm_up.is_none();
        if has_started { self.record_sources() } else { Ok(()) }
    }

    /// Returns a summary of the recording in one line.
    fn report(&self, tally: &Tally) -> String {
        let lost = [
            (self.frames_missed, "that the recorder was too slow for"),
            (tally.lost.frames_dropped, "that the disk was too slow for"),
            (tally.lost.frames_failed, "that could not be written"),
        ];
        let lost = lost.iter().filter(|(count, _)| *count > 0);
        let lost: Vec<_> = lost.map(|(count, why)| format!("{count} {why}")).collect();
        let lost = match lost.is_empty() {
            true => "no frame lost".to_owned(),
            false => format!("frames lost: {}", lost.join(", ")),
        };
        let others = match tally.lost.others + self.others_missed {
            0 => String::new(),
            count => format!("; {count} other messages lost"),
        };
        let (seconds, megabytes) = (self.timeline.now() as f64 * 1e-9, tally.bytes as f64 * 1e-6);
        let Tally { name, frames, growth, .. } = tally;
        format!(
            "{name}: {frames} frames up to {seconds:.2} s, {megabytes:.1} MB ({growth}); \
             {lost}{others}"
        )
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
            // One period after the last due time rather than after `now`, so that the mean rate
            // doesn't depend on the tick period.
            self.next = (self.next + self.period).max(now.saturating_sub(self.period));
        }
        due
    }
}

impl Plugin for Recorder {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.sources = Some(Sources::open(fleet, &self.topics)?);
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        let now = self.timeline.now();
        for (topic, message) in [
            (Topic::World, encode::world(world)),
            (Topic::Graph, scene::graph(world, now)),
            (Topic::GraphPoints, scene::graph_points(world, now)),
        ] {
            self.pending.push(Pending { topic, tick: None, message });
        }
        Ok(())
    }

    fn wants_events(&self) -> bool {
        self.topics.includes(&Topic::Events)
    }

    fn on_events(&mut self, events: &Events<'_>) -> Result {
        let tick = Some((events.header.run_id, events.header.tick));
        self.others_missed += events.missed;
        self.pending.push(Pending { topic: Topic::Events, tick, message: encode::events(events) });
        // The other services overflow, too, if only frames at a low rate have them read.
        self.record_sources_if_started()
    }

    fn on_frame(&mut self, frame: &Frame<'_>) -> Result {
        if frame.header().is_warm_up() {
            return self.skip_warm_up();
        }
        let log_time = self.timeline.advance(frame.header());
        let starts_run = frame.run_id() != self.newest.run_id;
        if let Some(sources) = &mut self.sources
            && starts_run
            && frame.header().lockstep != 0
        {
            // The producer waits for this plugin, so that nothing is missed meanwhile.
            sources.open_columns()?;
        }
        self.record_pending();
        self.record_frame(frame, log_time);
        self.record_warm_up();
        self.record_sources()
    }

    fn on_idle(&mut self, _has_producer: bool) -> Result {
        // Records come after the last frame, too, and while the clock is paused.
        self.record_sources_if_started()
    }

    fn on_stop(&mut self) -> Result {
        self.record_pending();
        let polled = if self.warm_up.is_some() { Ok(()) } else { self.record_sources() };
        if let Some(thinning) = &mut self.thinning {
            let held = thinning.flush();
            self.record_held(held);
        }
        let missed = [("frames_missed", self.frames_missed), ("others_missed", self.others_missed)];
        let (tally, error) =
            self.sink.finish("regatta.end", &missed.map(|(name, count)| (name, count.to_string())));
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
