//! The texts of a world: names of nodes and edges, of levels and zones.

use std::collections::HashMap;

use crate::records::cut;

/// Texts, each stored once: UTF-8 after its length in bytes as a little-endian `u16`. Records refer
/// to a text by the offset of its length in bytes; offset 0 is the empty text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Texts {
    bytes: Vec<u8>,
    offsets: HashMap<Box<str>, u32>,
}

impl Texts {
    /// Adds a text unless it is there already, and returns its offset. Texts of more than 65 535
    /// bytes are cut.
    pub fn add(&mut self, text: &str) -> u32 {
        let text = cut(text, usize::from(u16::MAX));
        if text.is_empty() {
            return 0;
        }
        if let Some(offset) = self.offsets.get(text) {
            return *offset;
        }
        if self.bytes.is_empty() {
            self.append("");
        }
        let offset = u32::try_from(self.bytes.len()).unwrap_or(0);
        // Beyond the range of offsets, texts are left out: 4 GB of names have no room in shared
        // memory anyway.
        if offset == 0 || u32::try_from(self.bytes.len() + 2 + text.len()).is_err() {
            return 0;
        }
        self.append(text);
        self.offsets.insert(text.into(), offset);
        offset
    }

    /// Returns the text at an offset; the empty text if there is none.
    pub fn get(&self, offset: u32) -> &str {
        text_at(&self.bytes, offset)
    }

    /// Returns texts with their lengths, as [`as_bytes`](Self::as_bytes) gave them. A text that is
    /// added later may be there twice.
    pub(super) fn from_bytes(bytes: Vec<u8>) -> Self {
        Self { bytes, offsets: HashMap::new() }
    }

    /// The texts with their lengths, as records refer to them; empty if there are no texts.
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn append(&mut self, text: &str) {
        self.bytes.extend((text.len() as u16).to_le_bytes());
        self.bytes.extend(text.as_bytes());
    }
}

/// Returns the text at an offset; the empty text if there is none, or it isn't UTF-8.
pub(super) fn text_at(bytes: &[u8], offset: u32) -> &str {
    let length = bytes.get(offset as usize..).and_then(<[u8]>::split_first_chunk::<2>);
    let Some((length, rest)) = length.filter(|_| offset != 0) else { return "" };
    let text = rest.get(..usize::from(u16::from_le_bytes(*length))).unwrap_or_default();
    core::str::from_utf8(text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_texts_are_stored_once() {
        let mut texts = Texts::default();
        assert_eq!((texts.add(""), texts.as_bytes().len()), (0, 0));
        let offsets = ["ground floor", "dock é", "ground floor", ""].map(|text| texts.add(text));
        assert_eq!(offsets, [2, 16, 2, 0]);
        assert_eq!(
            offsets.map(|offset| texts.get(offset)),
            ["ground floor", "dock é", "ground floor", ""]
        );
        assert_eq!(texts.as_bytes().len(), 2 + 2 + 12 + 2 + 7);
    }

    #[test]
    fn long_texts_are_cut_at_whole_characters() {
        let mut texts = Texts::default();
        let offset = texts.add(&"é".repeat(40_000));
        assert_eq!(texts.get(offset).len(), 65_534);
    }

    #[test]
    fn offsets_of_no_text_are_empty() {
        let mut texts = Texts::default();
        let offset = texts.add("abc");
        for wrong in [1, 3, offset + 1, 6, 7, 1_000, u32::MAX] {
            assert!(texts.get(wrong).len() < 3, "offset {wrong}");
        }
        assert_eq!(text_at(&[0, 0, 2, 0, 0xff, 0xff], 2), "", "not UTF-8");
        assert_eq!(text_at(&[0, 0, 200, 0, b'a'], 2), "", "shorter than its length");
        assert_eq!(text_at(&[], 0), "");
        assert_eq!(text_at(&[1, 0, b'a'], 0), "", "offset 0 is always the empty text");
    }
}
