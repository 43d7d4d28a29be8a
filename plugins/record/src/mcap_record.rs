//! Finds and reads the records of an MCAP file.

use std::io::{self, Read, Seek, SeekFrom};

use mcap::{McapError, McapResult};

/// The size of the opcode and the length before each record's content, in bytes.
pub(crate) const RECORD_HEADER: u64 = 9;

/// The largest valid chunk or record, in bytes. One that claims to be larger is damaged.
pub(crate) const MAX_RECORD: usize = 1 << 30;

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
        if start + RECORD_HEADER > limit {
            return Ok(None);
        }
        let room = limit - (start + RECORD_HEADER);
        file.seek(SeekFrom::Start(start))?;
        let mut header = [0; RECORD_HEADER as usize];
        file.read_exact(&mut header)?;
        let [opcode, length @ ..] = header;
        let length = u64::from_le_bytes(length);
        Ok((length <= room).then_some(Self { opcode, start, length }))
    }

    /// Returns the offset of the next record.
    pub fn end(&self) -> u64 {
        self.start + RECORD_HEADER + self.length
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
