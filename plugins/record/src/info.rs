//! Describes a recording by its index, without reading its messages.

use std::collections::BTreeMap;
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
    /// Whether it was closed. Otherwise, the messages after its last complete chunk are missing.
    pub is_closed: bool,
    /// The fleet, if it is in the metadata.
    pub fleet: Option<String>,
    /// The version of Regatta that recorded it.
    pub version: Option<String>,
    /// The version of the contract with plugins.
    pub contract: Option<String>,
    /// The time at which the recording began, as in RFC 3339.
    pub began: Option<String>,
    /// The time of the first message, in seconds on the recording's clock.
    pub start_s: f64,
    /// The time of the last message, in seconds on the recording's clock.
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
    /// The number of nodes of the last world.
    pub nodes: Option<usize>,
    /// The number of edges of the last world.
    pub edges: Option<usize>,
    /// The number of frames that the recorder missed, if it is in the metadata.
    pub frames_missed: Option<u64>,
    /// The number of other messages that the recorder missed, if it is in the metadata.
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
    /// Their uncompressed size.
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
    let mut metadata = recording.metadata()?;
    let mut about = metadata.remove("regatta").unwrap_or_default();
    let ends = metadata.remove("regatta.end").unwrap_or_default();
    let (ticks, robots) = frames(&recording)?;
    let Worlds { runs, nodes_and_edges } = worlds(&recording)?;
    let frames = recording.count(&Topic::Frames);
    Ok(Info {
        file: path.to_owned(),
        bytes: recording.bytes()?,
        is_closed: recording.is_closed(),
        fleet: about.remove("fleet"),
        version: about.remove("version"),
        contract: about.remove("contract"),
        began: about.remove("began"),
        start_s: start.as_secs_f64(),
        end_s: end.as_secs_f64(),
        frames,
        frames_per_s: per_second(&recording, frames),
        ticks,
        robots,
        runs: runs.iter().map(|run| format!("{run:016x}")).collect(),
        nodes: nodes_and_edges.map(|(nodes, _)| nodes),
        edges: nodes_and_edges.map(|(_, edges)| edges),
        frames_missed: ends.get("frames_missed").and_then(|count| count.parse().ok()),
        others_missed: ends.get("others_missed").and_then(|count| count.parse().ok()),
        topics: topics(&recording)?,
    })
}

/// Returns the mean rate of messages on a topic, given their number.
fn per_second(recording: &Recording, messages: u64) -> f64 {
    let (start, end) = recording.span();
    let seconds = end.saturating_sub(start).as_secs_f64();
    if seconds > 0.0 { messages.saturating_sub(1) as f64 / seconds } else { 0.0 }
}

/// Describes all topics.
fn topics(recording: &Recording) -> Result<Vec<TopicInfo>, ReadingError> {
    let sizes = sizes(recording)?;
    let mut topics = Vec::new();
    for topic in recording.topics() {
        let messages = recording.count(&topic);
        let Size { bytes, in_file } = sizes.get(&topic).copied().unwrap_or_default();
        topics.push(TopicInfo {
            name: topic.name(),
            messages,
            messages_per_s: per_second(recording, messages),
            bytes,
            bytes_in_file: in_file as u64,
        });
    }
    Ok(topics)
}

/// The size of a topic's messages.
#[derive(Clone, Copy, Debug, Default)]
struct Size {
    /// Bytes when they aren't compressed.
    bytes: u64,
    /// Bytes in the file: their part of each compressed chunk.
    in_file: f64,
}

/// Returns the sizes of all topics, from the message indexes. The definition of a channel counts
/// towards the message before it.
fn sizes(recording: &Recording) -> Result<BTreeMap<Topic, Size>, ReadingError> {
    let mut sizes: BTreeMap<Topic, Size> = BTreeMap::new();
    recording.chunks(|chunk, indexes| {
        let mut starts = Vec::new();
        for index in indexes {
            starts.extend(index.records.iter().map(|record| (record.offset, index.channel_id)));
        }
        starts.sort_unstable();
        let ends = starts.iter().skip(1).map(|(offset, _)| *offset);
        let ratio = chunk.compressed_size as f64 / (chunk.uncompressed_size as f64).max(1.0);
        for ((start, channel), end) in starts.iter().zip(ends.chain([chunk.uncompressed_size])) {
            if let Some(topic) = recording.topic(*channel) {
                let size = sizes.entry(topic.clone()).or_default();
                let bytes = end.saturating_sub(*start);
                size.bytes = size.bytes.saturating_add(bytes);
                size.in_file += bytes as f64 * ratio;
            }
        }
    })?;
    Ok(sizes)
}

/// Returns the first and the last tick, and the number of robots in the last frame.
fn frames(recording: &Recording) -> Result<(Option<[u64; 2]>, Option<u32>), ReadingError> {
    let mut reader = recording.read(&Selection::all_of(vec![Topic::Frames]))?;
    let Some(first) = reader.next()? else { return Ok((None, None)) };
    let frame = RecordedFrame::parse(first.message);
    let first = recording.located(first.topic, first.log_time, frame)?.header;
    let Some((time, message)) = recording.last_until(&Topic::Frames, u64::MAX)? else {
        return Ok((Some([first.tick, first.tick]), Some(first.robots)));
    };
    let last = recording.located(&Topic::Frames, time, RecordedFrame::parse(&message))?.header;
    Ok((Some([first.tick, last.tick]), Some(last.robots)))
}

/// The contents of a recording's worlds.
#[derive(Default)]
struct Worlds {
    /// The ids of all runs, in order.
    runs: Vec<u64>,
    /// The numbers of nodes and edges of the last world.
    nodes_and_edges: Option<(usize, usize)>,
}

fn worlds(recording: &Recording) -> Result<Worlds, ReadingError> {
    let mut worlds = Worlds::default();
    let mut reader = recording.read(&Selection::all_of(vec![Topic::World]))?;
    while let Some(entry) = reader.next()? {
        let world = decode::world(entry.message);
        let world = recording.located(entry.topic, entry.log_time, world)?;
        worlds.nodes_and_edges = Some((world.data.nodes.len(), world.data.edges.len()));
        if !worlds.runs.contains(&world.run_id) {
            worlds.runs.push(world.run_id);
        }
    }
    Ok(worlds)
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { start_s, end_s, frames, frames_per_s, .. } = self;
        writeln!(f, "file       {}, {}", self.file.display(), size(self.bytes as f64))?;
        let [fleet, began, version] = [&self.fleet, &self.began, &self.version]
            .map(|fact| fact.as_deref().unwrap_or("unknown"));
        writeln!(f, "fleet      {fleet}, recorded {began} by Regatta {version}")?;
        let seconds = end_s - start_s;
        writeln!(f, "time       {start_s:.2} s to {end_s:.2} s: {seconds:.2} s")?;
        write!(f, "frames     {frames}")?;
        if let Some([first, last]) = self.ticks {
            write!(f, ", ticks {first} to {last}")?;
        }
        writeln!(f, ", {frames_per_s:.1} per second")?;
        if let (Some(robots), Some(nodes), Some(edges)) = (self.robots, self.nodes, self.edges) {
            writeln!(f, "robots     {robots}, on {nodes} nodes and {edges} edges")?;
        }
        writeln!(f, "runs       {}", self.runs.join(", "))?;
        writeln!(f, "complete   {}", self.completeness())?;
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
            (false, ..) => "no: it was never closed; `regatta record --repair` closes it".into(),
            (true, Some(0), Some(0)) => "yes".into(),
            (true, Some(frames), others) => {
                let others = others.unwrap_or(0);
                format!("no: {frames} frames and {others} other messages were missed")
            }
            (true, None, _) => {
                "unknown: the recording goes on in another file, or was repaired".into()
            }
        }
    }
}

#[cfg(test)]
mod tests;
