//! Lines into datagrams, and datagrams into batches that the system takes in one call.

use crate::line::{LineFormat, MAX_LINE_BYTES, PoseLine};

/// Most bytes that a UDP datagram can carry over IPv4, and most that one call can hand to the system.
pub const MAX_DATAGRAM_BYTES: usize = 65_507;
/// The smallest limit of a datagram's length for which every line fits.
pub const MIN_DATAGRAM_BYTES: usize = 200;
const _: () = assert!(MIN_DATAGRAM_BYTES >= MAX_LINE_BYTES);

/// Some datagrams, end to end.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'packer> {
    /// All datagrams; each is [`datagram_bytes`](Self::datagram_bytes) long, but the last may be shorter.
    pub bytes: &'packer [u8],
    /// Length of a datagram.
    pub datagram_bytes: usize,
    /// Lines in all of them.
    pub lines: u64,
}

/// Packs lines into datagrams of one length, and never splits a line.
///
/// The system sends many datagrams in one call if they are equally long (generic segmentation offload). So the last
/// line of a full datagram gets more zeros behind the decimals of its angle, which are the same number.
#[derive(Debug)]
pub struct Packer {
    format: LineFormat,
    datagram_bytes: usize,
    batch_bytes: usize,
    text: Vec<u8>,
    /// Where the datagram that is being filled starts.
    start: usize,
    lines: u64,
    line: Vec<u8>,
}

impl Packer {
    /// A packer of datagrams of that length.
    ///
    /// # Panics
    /// If `datagram_bytes` is not in [`MIN_DATAGRAM_BYTES`]..=[`MAX_DATAGRAM_BYTES`], or the form has no decimals.
    pub fn new(format: LineFormat, datagram_bytes: usize) -> Self {
        assert!((MIN_DATAGRAM_BYTES..=MAX_DATAGRAM_BYTES).contains(&datagram_bytes), "{datagram_bytes} bytes");
        assert!(format.theta_decimals > 0, "without decimals, zeros would change the number");
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

    /// Adds a line. When that fills a batch, hands the batch to `flush` first.
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

    /// Hands over what is left, if anything.
    pub fn flush(&mut self, flush: impl FnOnce(Batch<'_>)) {
        if !self.text.is_empty() {
            flush(Batch { bytes: &self.text, datagram_bytes: self.datagram_bytes, lines: self.lines });
        }
        self.text.clear();
        (self.start, self.lines) = (0, 0);
    }

    /// Fills the datagram up to its length.
    fn close_datagram(&mut self) {
        // The end of its last line.
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

    /// The datagrams that so many lines become.
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
        fn every_line_arrives_whole_and_in_order(
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
            // All but the last of each batch, or else the system couldn't cut them apart; no more than needed.
            let full = datagrams.iter().filter(|datagram| datagram.len() == datagram_bytes).count();
            prop_assert!(full + 1 >= datagrams.len());
        }
    }

    #[test]
    fn the_longest_lines_fit_the_shortest_datagram() {
        let line = PoseLine { id: u32::MAX, x: f32::MIN, y: f32::MIN, theta: f32::MIN };
        let datagrams = datagrams(&[line; 3], MIN_DATAGRAM_BYTES);
        assert_eq!(datagrams.len(), 3);
    }
}
