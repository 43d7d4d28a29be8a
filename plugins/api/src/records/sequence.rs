//! Sequence numbers: the one way in which readers count lost samples.

/// A header that numbers the samples of a run.
pub trait Sequenced {
    /// The run that the sample belongs to.
    fn run_id(&self) -> u64;

    /// The number of the sample within its run, counted by the publisher from 1.
    fn sequence(&self) -> u64;

    /// Sets the number of the sample.
    fn set_sequence(&mut self, sequence: u64);
}

/// Implements [`Sequenced`] by the field `run_id` and the named field.
macro_rules! sequenced {
    ($header:ty: $sequence:ident) => {
        impl Sequenced for $header {
            fn run_id(&self) -> u64 {
                self.run_id
            }

            fn sequence(&self) -> u64 {
                self.$sequence
            }

            fn set_sequence(&mut self, sequence: u64) {
                self.$sequence = sequence;
            }
        }
    };
}

pub(super) use sequenced;

/// Counts the samples of a service that a reader never got, exactly.
///
/// ```
/// use regatta_plugin::frame::FrameHeader;
/// use regatta_plugin::sequence::LostSamples;
///
/// let frame = |run_id, sequence| FrameHeader { run_id, sequence, ..FrameHeader::default() };
/// let mut lost = LostSamples::default();
/// assert_eq!(lost.before(&frame(1, 70)), 0, "the reader joined here");
/// assert_eq!(lost.before(&frame(1, 73)), 2);
/// assert_eq!(lost.before(&frame(2, 1)), 0, "another run counts from 1");
/// assert_eq!(lost.total(), 2);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct LostSamples {
    run_id: u64,
    sequence: u64,
    total: u64,
}

impl LostSamples {
    /// Records a received sample, and returns the number of samples that were lost since the one
    /// before.
    ///
    /// Samples that were published before the reader joined are not lost. When the run changes, the
    /// samples of the new run before this one are; the number of missing last ones of the old run
    /// is unknown, and counts as none. A lower number than before within a run means that the
    /// publisher was replaced; nothing counts as lost then.
    pub fn before(&mut self, header: &impl Sequenced) -> u64 {
        let (run_id, sequence) = (header.run_id(), header.sequence());
        let lost = if self.run_id == run_id {
            sequence.saturating_sub(self.sequence + 1)
        } else if self.run_id == 0 {
            0
        } else {
            sequence.saturating_sub(1)
        };
        *self = Self { run_id, sequence, total: self.total + lost };
        lost
    }

    /// The number of samples that were lost so far, in all runs.
    pub fn total(&self) -> u64 {
        self.total
    }
}
