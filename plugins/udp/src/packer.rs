//! Packs lines into datagrams, and datagrams into batches that are sent with one system call.

use crate::line::{LineFormat, MAX_LINE_BYTES, PoseLine};

/// The largest payload of a UDP datagram over IPv4, in bytes, which is also the limit of one system
/// call.
pub const MAX_DATAGRAM_BYTES: usize = 65_507;
/// The smallest accepted length of datagrams, in bytes, into which every line fits.
pub const MIN_DATAGRAM_BYTES: usize = 200;
const _: () = assert!(MIN_DATAGRAM_BYTES >= MAX_LINE_BYTES);

/// A batch of contiguous datagrams.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'packer> {
    /// The datagrams. Each is [`datagram_bytes`](Self::datagram_bytes) long, except that the last
    /// may be shorter.
    pub bytes: &'packer [u8],
    /// The length of a datagram in bytes.
    pub datagram_bytes: usize,
    /// The number of lines in the batch.
    pub lines: u64,
}

/// A packer of lines into datagrams of equal length. Lines are never split.
///
/// The system can send many datagrams in one call if they have the same length (generic
/// segmentation offload). Therefore the angle in the last line of a full datagram is padded with
/// zeros, which don't change the number.
#[derive(Debug)]
pub struct Packer {
    format: LineFormat,
    datagram_bytes: usize,
    batch_bytes: usize,
    text: Vec<u8>,
    /// The offset of the current datagram.
    start: usize,
    lines: u64,
    line: Vec<u8>,
}

impl Packer {
    /// Creates a packer of datagrams of `datagram_bytes` bytes.
    ///
    /// # Panics
    /// Panics if `datagram_bytes` is not in [`MIN_DATAGRAM_BYTES`]..=[`MAX_DATAGRAM_BYTES`], or the
    /// format has no decimals.
    pub fn new(format: LineFormat, datagram_bytes: usize) -> Self {
        assert!(
            (MIN_DATAGRAM_BYTES..=MAX_DATAGRAM_BYTES).contains(&datagram_bytes),
            "{datagram_bytes} bytes"
        );
        assert!(format.theta_decimals > 0, "without decimals, padding would change the number");
        let batch_bytes = MAX_DATAGRAM_BYTES / datagram_bytes * datagram_bytes;
        Self {
            format,
            datagram_bytes,
            batch_bytes,
            text: Vec::with_capacity(batch_bytes),
            start: 0,
            lines: 0,
            line: Vec::with_capacity(MAX_LINE_BYTES),
        }
    }

    /// Adds a line. If it doesn't fit in the current batch, calls `flush` with that batch first.
    pub fn push(&mut self, line: &PoseLine, flush: impl FnOnce(Batch<'_>)) {
        self.line.clear();
        line.write(&mut self.line, self.format);
        if self.text.len() - self.start + self.line.len() > self.datagram_bytes {
            self.close_datagram();
            if self.text.len() == self.batch_bytes {
                self.flush(flush);
            }
        }
        self.text.extend_from_slice(&self.line);
        self.lines += 1;
    }

    /// Calls `flush` with the current batch, unless it is empty.
    pub fn flush(&mut self, flush: impl FnOnce(Batch<'_>)) {
        if !self.text.is_empty() {
            flush(Batch {
                bytes: &self.text,
                datagram_bytes: self.datagram_bytes,
                lines: self.lines,
            });
        }
        self.text.clear();
        (self.start, self.lines) = (0, 0);
    }

    /// Pads the current datagram to its full length.
    fn close_datagram(&mut self) {
        // The padding replaces the newline of the last line.
        self.text.pop();
        self.text.resize(self.start + self.datagram_bytes - 1, b'0');
        self.text.push(b'\n');
        self.start = self.text.len();
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::line::{AngleUnit, Separator, lines};

    fn format() -> LineFormat {
        LineFormat::new(Separator::Comma, 3, AngleUnit::Degrees)
    }

    /// Packs lines into datagrams.
    fn datagrams(all: &[PoseLine], datagram_bytes: usize) -> Vec<Vec<u8>> {
        let mut packer = Packer::new(format(), datagram_bytes);
        let (mut datagrams, mut counted) = (Vec::new(), 0);
        let mut take = |batch: Batch<'_>| {
            counted += batch.lines;
            assert!(batch.bytes.len() <= MAX_DATAGRAM_BYTES);
            datagrams.extend(batch.bytes.chunks(batch.datagram_bytes).map(<[u8]>::to_vec));
        };
        all.iter().for_each(|line| packer.push(line, &mut take));
        packer.flush(&mut take);
        packer.flush(|_| panic!("nothing is left"));
        assert_eq!(counted, all.len() as u64);
        datagrams
    }

    proptest! {
        #[test]
        fn lines_are_packed_whole_and_in_order(
            poses in prop::collection::vec((0_u32..2_000_000, -900.0_f32..900.0, -9.0_f32..9.0, -180.0_f32..180.0), 0..9_000),
            datagram_bytes in MIN_DATAGRAM_BYTES..3_000,
        ) {
            let all: Vec<_> = poses.iter().map(|&(id, x, y, theta)| PoseLine { id, x, y, theta }).collect();
            let datagrams = datagrams(&all, datagram_bytes);
            let mut read = Vec::new();
            for datagram in &datagrams {
                prop_assert!(datagram.len() <= datagram_bytes && datagram.last() == Some(&b'\n'));
                read.extend(lines(datagram).map(|line| PoseLine::parse(line, Separator::Comma).expect("whole")));
            }
            prop_assert_eq!(read.len(), all.len());
            for (read, sent) in read.iter().zip(&all) {
                let near = |a: f32, b: f32| (a - b).abs() < 0.000_6;
                prop_assert!(read.id == sent.id && near(read.x, sent.x) && near(read.y, sent.y));
                prop_assert!(near(read.theta, sent.theta));
            }
            // All datagrams but the last have the full length, so that the system can split batches
            // into datagrams.
            let full = datagrams.iter().filter(|datagram| datagram.len() == datagram_bytes).count();
            prop_assert!(full + 1 >= datagrams.len());
        }
    }

    #[test]
    fn the_longest_line_fits_in_the_shortest_datagram() {
        let line = PoseLine { id: u32::MAX, x: f32::MIN, y: f32::MIN, theta: f32::MIN };
        let datagrams = datagrams(&[line; 3], MIN_DATAGRAM_BYTES);
        assert_eq!(datagrams.len(), 3);
    }
}
