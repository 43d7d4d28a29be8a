//! Parses records of a recording. The library reserves memory for a text before it reads it, up to
//! 4 GiB: where memory is limited, a damaged length would end the process.

use mcap::records::{Record, op};
use mcap::{McapError, McapResult};

/// A field of a record, up to its last text.
enum Field {
    /// So many bytes.
    Bytes(usize),
    /// A text, or anything else after its length.
    Sized,
    /// Texts after their length together.
    Texts,
}

/// Parses the content of a record.
///
/// # Errors
/// Those of the library, and that a text reaches beyond the record.
pub(crate) fn parse_record(opcode: u8, content: &[u8]) -> McapResult<Record<'_>> {
    let mut rest = content;
    for field in fields(opcode) {
        let left = match field {
            Field::Bytes(length) => rest.get(*length..),
            Field::Sized => after_sized(rest),
            Field::Texts => sized(rest).and_then(after_texts),
        };
        rest = left.ok_or(McapError::UnexpectedEof)?;
    }
    mcap::parse_record(opcode, content)
}

/// Returns the fields of a record up to its last text.
fn fields(opcode: u8) -> &'static [Field] {
    use Field::{Bytes, Sized, Texts};
    match opcode {
        op::HEADER => &[Sized, Sized],
        op::SCHEMA => &[Bytes(2), Sized, Sized],
        op::CHANNEL => &[Bytes(4), Sized, Sized, Texts],
        op::CHUNK => &[Bytes(28), Sized],
        op::CHUNK_INDEX => &[Bytes(32), Sized, Bytes(8), Sized],
        op::METADATA => &[Sized, Texts],
        op::METADATA_INDEX => &[Bytes(16), Sized],
        op::ATTACHMENT => &[Bytes(16), Sized, Sized],
        op::ATTACHMENT_INDEX => &[Bytes(40), Sized, Sized],
        _ => &[],
    }
}

/// Returns the bytes that begin with their length.
fn sized(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.get(..u32::from_le_bytes(*length) as usize)
}

/// Returns what follows bytes that begin with their length.
fn after_sized(bytes: &[u8]) -> Option<&[u8]> {
    bytes.get(4 + sized(bytes)?.len()..)
}

/// Returns nothing, after texts that fill all bytes.
fn after_texts(mut bytes: &[u8]) -> Option<&[u8]> {
    while !bytes.is_empty() {
        bytes = after_sized(bytes)?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_that_reaches_beyond_its_record_takes_no_memory() {
        let whole = [&[3, 0, 0, 0], &b"abc"[..], &[0; 4]].concat();
        assert!(parse_record(op::HEADER, &whole).is_ok());
        for at in 0..4 {
            let mut damaged = whole.clone();
            damaged[at] = 0xff;
            let error = parse_record(op::HEADER, &damaged).expect_err("damaged");
            assert!(matches!(error, McapError::UnexpectedEof), "{error}");
        }
        let metadata = [&[1, 0, 0, 0], &b"a"[..], &[8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]].concat();
        assert!(parse_record(op::METADATA, &metadata).is_ok());
        let mut damaged = metadata.clone();
        damaged[16] = 0xff;
        assert!(parse_record(op::METADATA, &damaged).is_err());
        for length in 0..metadata.len() {
            assert!(parse_record(op::METADATA, &metadata[..length]).is_err(), "{length} bytes");
        }
    }
}
