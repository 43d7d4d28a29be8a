//! Writes MCAP files, and finds the records in them.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, McapResult, WriteOptions, Writer};

use crate::schema::{PROTOBUF, Topic};

/// Returns the topic of a channel, if this version knows it. Up to version 10 of the contract,
/// commands were called orders, and transport orders were called tasks.
pub(crate) fn topic_of(channel: &mcap::Channel) -> Option<Topic> {
    let schema = channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
    match (channel.topic.as_str(), schema) {
        ("/orders", "regatta.Orders") => Some(Topic::Commands),
        ("/tasks", "regatta.Tasks") => Some(Topic::Orders),
        (name, _) => Topic::from_name(name),
    }
}

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

/// The size of the opcode and the length before each record's content, in bytes.
pub(crate) const RECORD_HEADER: u64 = 9;

/// The largest valid chunk or record, in bytes. One that claims to be larger is damaged.
pub(crate) const MAX_RECORD: usize = 1 << 30;

/// Returns the most bytes that all chunks of a file may hold, decompressed. Each message has an
/// entry in an index that isn't compressed, so that no recording of a fleet comes near; a small file
/// that claims more would keep its readers busy for nothing.
pub(crate) fn most_content(file_bytes: u64) -> u64 {
    (256 << 20) + file_bytes.saturating_mul(1000)
}

/// The position of a record in a file.
pub(crate) struct RecordSpan {
    pub opcode: u8,
    /// The offset of the opcode.
    pub start: u64,
    /// The length of the content.
    pub length: u64,
}

impl RecordSpan {
    /// Reads the header of the record that starts at `start`. Returns `None` if the record reaches
    /// beyond `limit`.
    pub fn read(file: &mut (impl Read + Seek), start: u64, limit: u64) -> io::Result<Option<Self>> {
        if limit.checked_sub(RECORD_HEADER).is_none_or(|last| start > last) {
            return Ok(None);
        }
        let room = limit - start - RECORD_HEADER;
        file.seek(SeekFrom::Start(start))?;
        let mut header = [0; RECORD_HEADER as usize];
        file.read_exact(&mut header)?;
        let [opcode, length @ ..] = header;
        let length = u64::from_le_bytes(length);
        Ok((length <= room).then_some(Self { opcode, start, length }))
    }

    /// Returns the offset of the next record.
    pub fn end(&self) -> u64 {
        (self.start + RECORD_HEADER).saturating_add(self.length)
    }

    /// Reads the record's content.
    pub fn read_content(&self, file: &mut (impl Read + Seek)) -> McapResult<Vec<u8>> {
        if self.length > MAX_RECORD as u64 {
            return Err(McapError::RecordTooLarge { opcode: self.opcode, len: self.length });
        }
        file.seek(SeekFrom::Start(self.start + RECORD_HEADER))?;
        let mut content = vec![0; self.length as usize];
        file.read_exact(&mut content)?;
        Ok(content)
    }
}
