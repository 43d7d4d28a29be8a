//! Writes an MCAP file with the topics of a recording.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapResult, WriteOptions, Writer};

use crate::schema::{PROTOBUF, Topic};

/// The compression of chunks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Compression {
    /// Fast.
    #[default]
    Lz4,
    /// Smaller files, but slower.
    Zstd,
    /// No compression.
    None,
}

/// The writer of an MCAP file.
pub(crate) struct McapFile {
    pub writer: Writer<NoSeek<File>>,
    /// The channel and the number of messages of each topic.
    channels: HashMap<Topic, (u16, u32)>,
}

impl McapFile {
    pub fn create(file: File, compression: Compression, chunk_bytes: u64) -> McapResult<Self> {
        let compression = match compression {
            Compression::Lz4 => Some(mcap::Compression::Lz4),
            Compression::Zstd => Some(mcap::Compression::Zstd),
            Compression::None => None,
        };
        let writer = WriteOptions::new()
            .library(concat!("regatta ", env!("CARGO_PKG_VERSION")))
            .compression(compression)
            .compression_level(1)
            .compression_threads(0)
            .chunk_size(Some(chunk_bytes))
            // Chunks are assembled in memory and written in one piece, so that a kill rarely leaves
            // a partial chunk.
            .disable_seeking(true)
            .create(NoSeek::new(file))?;
        Ok(Self { writer, channels: HashMap::new() })
    }

    /// Returns the channel of a topic and the number of its messages. Defines the channel first if
    /// it is new.
    pub fn channel(&mut self, topic: &Topic) -> McapResult<&mut (u16, u32)> {
        if !self.channels.contains_key(topic) {
            let schema = self.writer.add_schema(topic.schema(), PROTOBUF, topic.descriptors())?;
            let channel =
                self.writer.add_channel(schema, &topic.name(), PROTOBUF, &BTreeMap::new())?;
            self.channels.insert(topic.clone(), (channel, 0));
        }
        Ok(self.channels.get_mut(topic).expect("it was just inserted"))
    }

    /// Writes a message. Sets the channel and sequence number of its header.
    pub fn write(
        &mut self,
        topic: &Topic,
        header: MessageHeader,
        message: &[u8],
    ) -> McapResult<()> {
        let (channel_id, count) = self.channel(topic)?;
        *count = count.wrapping_add(1);
        let header = MessageHeader { channel_id: *channel_id, sequence: *count, ..header };
        self.writer.write_to_known_channel(&header, message)
    }
}
