//! Looks up the line number of a byte offset without storing the start of every line.

use std::sync::Arc;

/// The number of bytes between two checkpoints: a look-up counts the line ends in at most one
/// stride.
const STRIDE: usize = 512;

/// The line numbers of a text. Clones are cheap.
#[derive(Clone)]
pub(crate) struct LineIndex<'text> {
    text: &'text [u8],
    /// `checkpoints[i]` is the number of line ends before byte `i * STRIDE`.
    checkpoints: Arc<[u32]>,
}

impl<'text> LineIndex<'text> {
    pub fn new(text: &'text str) -> Self {
        let text = text.as_bytes();
        let mut before = 0;
        let checkpoints = text
            .chunks(STRIDE)
            .map(|chunk| {
                let here = before;
                before += line_ends(chunk);
                here
            })
            .collect();
        Self { text, checkpoints }
    }

    /// Returns the line, from 1, of a byte offset; that of the last byte if the offset is beyond
    /// the end.
    pub fn line(&self, offset: u32) -> u32 {
        let offset = (offset as usize).min(self.text.len());
        let Some(&before) = self.checkpoints.get(offset / STRIDE).or(self.checkpoints.last())
        else {
            return 1;
        };
        let from = (offset / STRIDE).min(self.checkpoints.len() - 1) * STRIDE;
        1 + before + line_ends(&self.text[from..offset])
    }
}

fn line_ends(bytes: &[u8]) -> u32 {
    bytes.iter().map(|&byte| u32::from(byte == b'\n')).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_found() {
        let text: String = (1..=3000).map(|line| format!("{line}\n")).collect();
        let index = LineIndex::new(&text);
        for line in 1..=3000u32 {
            let offset = text.find(&format!("\n{line}\n")).map_or(0, |at| at + 1);
            assert_eq!(index.line(offset as u32), line);
        }
        assert_eq!(index.line(u32::MAX), 3001);
        assert_eq!(LineIndex::new("").line(0), 1);
        assert_eq!(LineIndex::new("").line(7), 1);
    }

    #[test]
    fn the_end_of_a_text_of_whole_strides_is_found() {
        let text = "\n".repeat(2 * STRIDE);
        assert_eq!(LineIndex::new(&text).line(2 * STRIDE as u32), 2 * STRIDE as u32 + 1);
    }
}
