//! The share that a tick reaches of the limit that memory sets.
//!
//! A tick can't be faster than the bytes that it moves can be stored past the cache. The rates and
//! the ticks are measured in turn, in one run: a machine's memory isn't equally fast at all times.

use std::hint::black_box;
use std::time::Instant;

use regatta_bench::{FrameRing, World, unread_events};
use regatta_motion::{AlignedVec, Isa, ROW_GROUP, SupportedIsa};

/// The bytes of a robot that a tick reads or writes: of the fleet's columns it reads five words and
/// a byte and writes one word back, of the frame it writes six words and a byte; the rest is the
/// share of a hand-over.
const BYTES_PER_ROBOT: f64 = 54.0;

/// The bytes of each buffer that the rates are measured with; more than a processor's own caches
/// hold.
const BUFFER_BYTES: usize = 25_600_000;

/// The number of measurements, of which the median counts.
const ROUNDS: usize = 31;

/// Memory that is filled and copied.
struct Buffers {
    isa: SupportedIsa,
    from: AlignedVec<f32>,
    to: AlignedVec<f32>,
}

impl Buffers {
    fn new(isa: SupportedIsa) -> Self {
        let groups = BUFFER_BYTES / (ROW_GROUP * size_of::<f32>());
        let (mut from, mut to) = (AlignedVec::new(), AlignedVec::new());
        from.resize(groups, 1.0);
        to.resize(groups, 0.0);
        Self { isa, from, to }
    }

    /// The bytes of one buffer.
    fn bytes(&self) -> f64 {
        size_of_val(&*self.to) as f64
    }

    fn stream(&mut self) {
        self.isa.fill_past_cache(&mut self.to, 2.0);
    }

    fn copy(&mut self) {
        self.to.copy_from_slice(black_box(&self.from));
    }
}

/// The seconds that each measurement took.
#[derive(Default)]
struct Times(Vec<f64>);

impl Times {
    fn measure(&mut self, work: impl FnOnce()) {
        let start = Instant::now();
        work();
        self.0.push(start.elapsed().as_secs_f64());
    }

    fn median(mut self) -> f64 {
        self.0.sort_by(f64::total_cmp);
        self.0[self.0.len() / 2]
    }
}

/// Measures and prints the rates of memory and the share of the limit that one thread reaches with
/// that many robots.
pub fn print_share(world: &World, robots: usize, isa: Isa) {
    let supported = SupportedIsa::detect(isa).expect("a supported instruction set");
    let mut buffers = Buffers::new(supported);
    let mut fleet = world.fleet(robots, isa, 1, f32::INFINITY);
    let (mut ring, mut events) = (FrameRing::new(robots), unread_events());
    let (mut stream, mut copy, mut tick) = (Times::default(), Times::default(), Times::default());
    for _ in 0..ROUNDS {
        stream.measure(|| buffers.stream());
        copy.measure(|| buffers.copy());
        // The first tick after that finds nothing in the cache.
        fleet.step(Some(ring.loan()), &mut events);
        tick.measure(|| fleet.step(Some(ring.loan()), &mut events));
    }
    let rate = buffers.bytes() / stream.median();
    let (limit, tick) = (BYTES_PER_ROBOT * robots as f64 / rate, tick.median());
    println!(
        "{robots} robots, {isa}: memory takes {:.1} GB/s of stores past the cache and copies \
         {:.1} GB/s; a tick takes {:.3} ms, at least {:.3} ms by that rate: {:.0} % of the limit",
        rate * 1e-9,
        buffers.bytes() / copy.median() * 1e-9,
        tick * 1e3,
        limit * 1e3,
        100.0 * limit / tick,
    );
}
