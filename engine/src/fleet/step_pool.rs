//! The threads that share a step: each processes a contiguous range of blocks.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use regatta_motion::{BLOCK, Motion, PoseColumns, Rows};

use super::EventBuffer;

/// The time for which the calling thread doesn't sleep while it waits for the others: as a rule
/// they end sooner than it would wake up.
const SPIN: Duration = Duration::from_micros(200);

/// The threads of a fleet, each with its own buffer of events. The thread that calls
/// [`step`](Self::step) is one of them.
#[derive(Debug)]
pub(super) struct StepPool {
    others: rayon::ThreadPool,
    events: Vec<EventBuffer>,
}

impl StepPool {
    /// Starts the threads, at least two; `None` if that fails.
    pub fn new(threads: usize) -> Option<Self> {
        let others = rayon::ThreadPoolBuilder::new()
            .num_threads(threads - 1)
            .thread_name(|number| format!("motion-{number}"))
            .build()
            .ok()?;
        Some(Self { others, events: vec![EventBuffer::new(0); threads] })
    }

    /// Does what [`Motion::step`] does, on all threads that get a block. Events are in the order of
    /// rows, as from one thread.
    pub fn step(
        &mut self,
        motion: &Motion,
        mut rows: Rows,
        mut columns: Option<PoseColumns>,
        events: &mut EventBuffer,
    ) {
        for part in &mut self.events {
            part.reset_like(events);
        }
        let blocks = rows.len().div_ceil(BLOCK);
        let threads = self.events.len().min(blocks);
        let Some((first, others)) = self.events[..threads].split_first_mut() else { return };
        let running = &AtomicUsize::new(0);
        self.others.in_place_scope(|scope| {
            for (number, part) in others.iter_mut().enumerate().rev() {
                let start = BLOCK * (blocks * (number + 1) / threads);
                let (before, part_rows) = rows.split_at(start);
                let (columns_before, part_columns) =
                    columns.map(|columns| columns.split_at(start)).unzip();
                (rows, columns) = (before, columns_before);
                running.fetch_add(1, Ordering::Relaxed);
                scope.spawn(move |_| {
                    motion.step(part_rows, part_columns, part);
                    running.fetch_sub(1, Ordering::Release);
                });
            }
            motion.step(rows, columns, first);
            spin_while_any(running);
        });
        for part in &mut self.events {
            events.append(part);
        }
    }
}

/// Waits for the other threads without sleeping, for a while.
fn spin_while_any(running: &AtomicUsize) {
    let end = Instant::now() + SPIN;
    while running.load(Ordering::Acquire) > 0 && Instant::now() < end {
        std::hint::spin_loop();
    }
}
