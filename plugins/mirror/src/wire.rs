//! The messages between two hosts: plain data of the contract, little-endian, under a prefix that
//! names the version of the contract.
//!
//! ```text
//! offset  bytes  field
//!      0      4  "RGTM"
//!      4      4  version of the contract
//!      8      4  kind of the message
//!     12      4  zero
//!     16      …  the header of the record, as in shared memory
//!      …      …  the records or columns, packed
//! ```
//!
//! Messages of peers are checked here once: their lengths are compared with those that the header
//! implies, before anything is allocated. Readers of the contract check references themselves.

mod frame;
mod records;

use bytemuck::Pod;
use regatta_plugin::frame::CONTRACT_VERSION;

pub use frame::{Columns, Encoding, FrameMessage, encode_frame};
pub use records::{
    ColumnMessage, MAX_RECORDS, control_request, control_response, decode_column, decode_commands,
    decode_events, decode_world, encode_column, encode_commands, encode_control_request,
    encode_control_response, encode_events, encode_world,
};

/// The first bytes of every message.
const MAGIC: [u8; 4] = *b"RGTM";
/// Bytes before the header of a record.
const PREFIX_BYTES: usize = 16;
/// The largest number of robots in a message.
pub const MAX_ROBOTS: u32 = 1 << 24;

/// The kind of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Kind {
    /// A frame, each value as in shared memory.
    RawFrame = 1,
    /// A frame in steps of 1/65535 of its extent.
    Q16Frame = 2,
    /// A world.
    World = 3,
    /// The events of a tick.
    Events = 4,
    /// A column.
    Column = 5,
    /// Commands.
    Commands = 6,
    /// A control request.
    ControlRequest = 7,
    /// The answer to a control request.
    ControlResponse = 8,
}

/// The fault of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum WireError {
    /// It isn't one of Regatta's.
    #[error("it isn't a message of Regatta")]
    Foreign,
    /// The peer has another contract.
    #[error(
        "the other host has version {version} of the contract, this one {CONTRACT_VERSION}; \
             run the same version of Regatta on both"
    )]
    OtherVersion {
        /// The peer's version.
        version: u32,
    },
    /// It is of another kind than its key says.
    #[error("it is of kind {kind}")]
    OtherKind {
        /// The number of the kind.
        kind: u32,
    },
    /// Its length isn't the one that its header implies.
    #[error("its length contradicts its header")]
    Length,
    /// It has more robots or records than any fleet.
    #[error("it holds {count} rows; {max} are allowed")]
    TooMany {
        /// The number of rows.
        count: u64,
        /// The largest number.
        max: u64,
    },
    /// A value isn't allowed.
    #[error("a value is out of range")]
    Value,
}

/// Returns a message of a header and parts, with the prefix.
fn message<H: Pod>(kind: Kind, header: &H, parts: &[&[u8]]) -> Vec<u8> {
    let body: usize = parts.iter().map(|part| part.len()).sum();
    let mut bytes = Vec::with_capacity(PREFIX_BYTES + size_of::<H>() + body);
    bytes.extend(MAGIC);
    for word in [CONTRACT_VERSION, kind as u32, 0] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend_from_slice(bytemuck::bytes_of(header));
    for part in parts {
        bytes.extend_from_slice(part);
    }
    bytes
}

/// Returns the header and the body of a message.
fn split<H: Pod>(bytes: &[u8], kind: Kind) -> Result<(H, &[u8]), WireError> {
    let (prefix, rest) = bytes.split_first_chunk::<PREFIX_BYTES>().ok_or(WireError::Foreign)?;
    let words: [u32; 4] = bytemuck::cast(*prefix);
    if prefix[..4] != MAGIC {
        return Err(WireError::Foreign);
    }
    if words[1] != CONTRACT_VERSION {
        return Err(WireError::OtherVersion { version: words[1] });
    }
    if words[2] != kind as u32 {
        return Err(WireError::OtherKind { kind: words[2] });
    }
    let (header, body) = rest.split_at_checked(size_of::<H>()).ok_or(WireError::Length)?;
    Ok((bytemuck::pod_read_unaligned(header), body))
}

/// Copies values out of bytes of the same length, which may be anywhere in memory.
fn values<T: Pod>(bytes: &[u8]) -> Vec<T> {
    bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect()
}

/// Returns the number of rows that a header gives, if it is at most `max`.
fn rows(count: u32, max: u32) -> Result<usize, WireError> {
    if count > max {
        return Err(WireError::TooMany { count: count.into(), max: max.into() });
    }
    Ok(count as usize)
}

#[cfg(test)]
mod tests;
