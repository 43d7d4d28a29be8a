//! Numbers as bytes, little-endian, each of four bytes.

/// Writes numbers.
#[derive(Debug, Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    /// Writes a list of numbers, with its length.
    pub fn list(&mut self, words: impl ExactSizeIterator<Item = u32>) {
        self.0.extend((words.len() as u32).to_le_bytes());
        for word in words {
            self.0.extend(word.to_le_bytes());
        }
    }

    /// Writes a list of numbers, with its length.
    pub fn floats(&mut self, floats: impl ExactSizeIterator<Item = f32>) {
        self.list(floats.map(f32::to_bits));
    }

    pub fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

/// Reads what a [`Writer`] has written.
#[derive(Clone, Debug)]
pub struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Reads a list; `None` if there are fewer numbers than it says.
    pub fn list(&mut self) -> Option<Vec<u32>> {
        let (length, rest) = self.0.split_first_chunk::<4>()?;
        let (list, rest) = rest.split_at_checked(4 * u32::from_le_bytes(*length) as usize)?;
        self.0 = rest;
        Some(
            list.chunks_exact(4)
                .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
                .collect(),
        )
    }

    /// Reads a list of so many numbers.
    pub fn list_of(&mut self, length: usize) -> Option<Vec<u32>> {
        self.list().filter(|list| list.len() == length)
    }

    /// Reads a list of so many numbers.
    pub fn floats(&mut self, length: usize) -> Option<Vec<f32>> {
        Some(self.list_of(length)?.into_iter().map(f32::from_bits).collect())
    }

    /// Reads the start of each of so many parts of a list, and the end of the last one.
    pub fn starts(&mut self, parts: usize) -> Option<Vec<u32>> {
        self.list_of(parts + 1).filter(|starts| starts[0] == 0 && starts.is_sorted())
    }

    pub fn is_at_end(&self) -> bool {
        self.0.is_empty()
    }
}
