//! The digest of a run: a hash over all frames, which is the same on every machine.

use regatta_plugin::frame::ColumnsMut;
use xxhash_rust::xxh3::Xxh3;

/// A hash over the tick numbers and columns of all frames so far (XXH3, 128 bits, little-endian
/// values).
#[derive(Default)]
pub struct Digest {
    hasher: Xxh3,
}

impl Digest {
    /// Adds the frame of a tick: the first `robots` rows of its columns.
    pub fn frame(&mut self, tick: u64, robots: usize, columns: &ColumnsMut<'_>) {
        self.hasher.update(&tick.to_le_bytes());
        for column in [&columns.x, &columns.y, &columns.theta, &columns.speed, &columns.s] {
            self.words(column[..robots].iter().map(|value| value.to_bits()));
        }
        self.words(columns.edge[..robots].iter().copied());
        self.hasher.update(&columns.state[..robots]);
    }

    /// Returns the digest of the frames added so far.
    pub fn value(&self) -> u128 {
        self.hasher.digest128()
    }

    fn words(&mut self, words: impl Iterator<Item = u32>) {
        for word in words {
            self.hasher.update(&word.to_le_bytes());
        }
    }
}
