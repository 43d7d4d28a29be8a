//! Describes a recording by its index, without reading its messages.

mod sizes;

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::decode;
use crate::disk::size;
use crate::reading::{ReadingError, Recording, Selection};
use crate::recorded::RecordedFrame;
use crate::schema::Topic;

/// The description of a recording.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// The file.
    pub file: PathBuf,
    /// Its size.
    pub bytes: u64,
    /// Whether it was closed. If not, the messages after its last complete chunk are missing.
    pub is_closed: bool,
    /// The fleet, if the recording says so.
    pub fleet: Option<String>,
    /// The version of Regatta that recorded it.
    pub version: Option<String>,
    /// The version of the contract with plugins.
    pub contract: Option<String>,
    /// When the recording began, as in RFC 3339.
    pub began: Option<String>,
    /// The times of the first and the last message, in seconds on the recording's clock.
    pub start_s: f64,
    /// The end of that time.
    pub end_s: f64,
    /// The number of frames.
    pub frames: u64,
    /// Frames per second of the recording.
    pub frames_per_s: f64,
    /// The first and the last tick.
    pub ticks: Option<[u64; 2]>,
    /// The number of robots in the last frame, absent ones included.
    pub robots: Option<u32>,
    /// The ids of the runs, in order, as hexadecimal numbers.
    pub runs: Vec<String>,
    /// The numbers of nodes and edges of the last world.
    pub nodes: Option<usize>,
    /// The number of its edges.
    pub edges: Option<usize>,
    /// Frames that the recorder missed, if the recording says so.
    pub frames_missed: Option<u64>,
    /// Other messages that the recorder missed.
    pub others_missed: Option<u64>,
    /// The topics, sorted.
    pub topics: Vec<TopicInfo>,
}

/// The messages of a topic.
#[derive(Clone, Debug, Serialize)]
pub struct TopicInfo {
    /// The topic's name.
    pub name: String,
    /// The number of messages.
    pub messages: u64,
    /// Messages per second of the recording.
    pub messages_per_s: f64,
    /// Their size when they aren't compressed.
    pub bytes: u64,
    /// Their part of the file.
    pub bytes_in_file: u64,
}

/// Describes a recording.
///
/// # Errors
/// Returns a [`ReadingError`] if the file can't be read or isn't a recording.
pub fn info(path: &Path) -> Result<Info, ReadingError> {
    let recording = Recording::open(path)?;
    let (start, end) = recording.span();
    let seconds = (end - start).as_secs_f64();
    let rate =
        |count: u64| if seconds > 0.0 { count.saturating_sub(1) as f64 / seconds } else { 0.0 };
    let metadata = recording.metadata()?;
    let fact = |record: &str, name: &str| metadata.get(record)?.get(name).cloned();
    let count = |name: &str| fact("regatta.end", name)?.parse().ok();
    let (ticks, robots) = frames(&recording)?;
    let Worlds { runs, graph } = worlds(&recording)?;
    let sizes = sizes::of(&recording)?;
    let topic = |topic: &Topic| {
        let (messages, sizes) =
            (recording.count(topic), sizes.get(topic).copied().unwrap_or_default());
        TopicInfo {
            name: topic.name(),
            messages,
            messages_per_s: rate(messages),
            bytes: sizes.bytes,
            bytes_in_file: sizes.in_file as u64,
        }
    };
    let frames = recording.count(&Topic::Frames);
    Ok(Info {
        file: path.to_owned(),
        bytes: recording.bytes()?,
        is_closed: recording.is_closed(),
        fleet: fact("regatta", "fleet"),
        version: fact("regatta", "version"),
        contract: fact("regatta", "contract"),
        began: fact("regatta", "began"),
        start_s: start.as_secs_f64(),
        end_s: end.as_secs_f64(),
        frames,
        frames_per_s: rate(frames),
        ticks,
        robots,
        runs: runs.iter().map(|run| format!("{run:016x}")).collect(),
        nodes: graph.map(|(nodes, _)| nodes),
        edges: graph.map(|(_, edges)| edges),
        frames_missed: count("frames_missed"),
        others_missed: count("others_missed"),
        topics: recording.topics().iter().map(topic).collect(),
    })
}

/// Returns the first and the last tick, and the number of robots in the last frame.
fn frames(recording: &Recording) -> Result<(Option<[u64; 2]>, Option<u32>), ReadingError> {
    let header = |time: u64, message: &[u8]| {
        let frame = RecordedFrame::parse(message);
        frame
            .map(|frame| frame.header)
            .map_err(|reason| recording.malformed(&Topic::Frames, time, reason))
    };
    let mut reader = recording.read(&Selection::all_of(vec![Topic::Frames]))?;
    let Some(first) = reader.next()? else { return Ok((None, None)) };
    let first = header(first.log_time, first.message)?;
    let last = recording.last_until(&Topic::Frames, u64::MAX)?;
    let last = last.map_or(Ok(first), |(time, message)| header(time, &message))?;
    Ok((Some([first.tick, last.tick]), Some(last.robots)))
}

/// What the worlds of a recording say.
#[derive(Default)]
struct Worlds {
    /// The ids of all runs, in order.
    runs: Vec<u64>,
    /// The numbers of nodes and edges of the last world.
    graph: Option<(usize, usize)>,
}

fn worlds(recording: &Recording) -> Result<Worlds, ReadingError> {
    let mut worlds = Worlds::default();
    let mut reader = recording.read(&Selection::all_of(vec![Topic::World]))?;
    while let Some(entry) = reader.next()? {
        let world = decode::world(entry.message);
        let world =
            world.map_err(|reason| recording.malformed(entry.topic, entry.log_time, reason))?;
        worlds.graph = Some((world.data.nodes.len(), world.data.edges.len()));
        if !worlds.runs.contains(&world.run_id) {
            worlds.runs.push(world.run_id);
        }
    }
    Ok(worlds)
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = |fact: &Option<String>| fact.clone().unwrap_or_else(|| "unknown".to_owned());
        let mut line = |name: &str, fact: String| writeln!(f, "{name:<11}{fact}");
        line("file", format!("{}, {}", self.file.display(), size(self.bytes as f64)))?;
        line(
            "fleet",
            format!(
                "{}, recorded {} by Regatta {}",
                known(&self.fleet),
                known(&self.began),
                known(&self.version)
            ),
        )?;
        let seconds = self.end_s - self.start_s;
        line("time", format!("{:.2} s to {:.2} s: {seconds:.2} s", self.start_s, self.end_s))?;
        let ticks = self
            .ticks
            .map_or_else(String::new, |[first, last]| format!(", ticks {first} to {last}"));
        line("frames", format!("{}{ticks}, {:.1} per second", self.frames, self.frames_per_s))?;
        if let (Some(robots), Some(nodes), Some(edges)) = (self.robots, self.nodes, self.edges) {
            line("robots", format!("{robots}, on {nodes} nodes and {edges} edges"))?;
        }
        line("runs", self.runs.join(", "))?;
        line("complete", self.completeness())?;
        writeln!(
            f,
            "\n{:<24}{:>10}{:>12}{:>12}{:>12}",
            "topic", "messages", "per second", "size", "in file"
        )?;
        for TopicInfo { name, messages, messages_per_s, bytes, bytes_in_file } in &self.topics {
            let (bytes, in_file) = (size(*bytes as f64), size(*bytes_in_file as f64));
            writeln!(f, "{name:<24}{messages:>10}{messages_per_s:>12.1}{bytes:>12}{in_file:>12}")?;
        }
        Ok(())
    }
}

impl Info {
    /// Says whether something is missing.
    fn completeness(&self) -> String {
        match (self.is_closed, self.frames_missed, self.others_missed) {
            (false, ..) => {
                "no: it was never closed; `regatta record --repair` closes it".to_owned()
            }
            (true, Some(0), Some(0)) => "yes".to_owned(),
            (true, Some(frames), others) => {
                format!(
                    "no: {frames} frames and {} other messages were missed",
                    others.unwrap_or(0)
                )
            }
            (true, None, _) => {
                "unknown: the recording goes on in another file, or was repaired".to_owned()
            }
        }
    }
}

#[cfg(test)]
mod tests;
