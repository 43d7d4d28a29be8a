//! Sizes of a recording's topics, from its message indexes.

use std::collections::BTreeMap;

use crate::reading::{ReadingError, Recording};
use crate::schema::Topic;

/// The size of a topic's messages.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Size {
    /// Bytes when they aren't compressed.
    pub bytes: u64,
    /// Bytes in the file: their part of each compressed chunk.
    pub in_file: f64,
}

/// Returns the sizes of all topics. Channels' definitions count to the message before them.
pub(super) fn of(recording: &Recording) -> Result<BTreeMap<Topic, Size>, ReadingError> {
    let mut sizes: BTreeMap<Topic, Size> = BTreeMap::new();
    recording.chunks(|chunk, indexes| {
        let entries = |index: &mcap::records::MessageIndex| {
            let channel = index.channel_id;
            index.records.iter().map(move |record| (record.offset, channel)).collect::<Vec<_>>()
        };
        let mut starts: Vec<_> = indexes.iter().flat_map(entries).collect();
        starts.sort_unstable();
        let ends =
            starts.iter().skip(1).map(|(offset, _)| *offset).chain([chunk.uncompressed_size]);
        let ratio = chunk.compressed_size as f64 / (chunk.uncompressed_size as f64).max(1.0);
        for ((start, channel), end) in starts.iter().zip(ends) {
            if let Some(topic) = recording.topic(*channel) {
                let size = sizes.entry(topic.clone()).or_default();
                let bytes = end.saturating_sub(*start);
                size.bytes += bytes;
                size.in_file += bytes as f64 * ratio;
            }
        }
    })?;
    Ok(sizes)
}
