//! The threads that share a step: each processes a contiguous range of blocks.

use regatta_motion::{BLOCK, Motion, PoseColumns, Rows};

use super::EventBuffer;

/// The threads of a fleet, each with its own buffer of events.
#[derive(Debug)]
pub(super) struct StepPool {
    pool: rayon::ThreadPool,
    events: Vec<EventBuffer>,
}

impl StepPool {
    /// Starts the threads; `None` if that fails.
    pub fn new(threads: usize) -> Option<Self> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|number| format!("motion-{number}"))
            .build()
            .ok()?;
        Some(Self { pool, events: vec![EventBuffer::new(0); threads] })
    }

    /// Does what [`Motion::step`] does, on all threads. Events are in the order of rows, as
    /// from one thread.
    pub fn step(
        &mut self,
        motion: &Motion,
        rows: Rows,
        columns: Option<PoseColumns>,
        events: &mut EventBuffer,
    ) {
        for part in &mut self.events {
            part.reset_like(events);
        }
        self.pool.install(|| step_parts(motion, rows, columns, &mut self.events));
        for part in &mut self.events {
            events.append(part);
        }
    }
}

/// Steps one part of the rows for each buffer of events.
fn step_parts(
    motion: &Motion,
    rows: Rows,
    columns: Option<PoseColumns>,
    events: &mut [EventBuffer],
) {
    if let [events] = events {
        return motion.step(rows, columns, events);
    }
    let blocks = rows.len().div_ceil(BLOCK);
    let (first, second) = events.split_at_mut(events.len() / 2);
    let middle = BLOCK * (blocks * first.len() / (first.len() + second.len()));
    let (rows, more_rows) = rows.split_at(middle);
    let (columns, more_columns) = columns.map(|columns| columns.split_at(middle)).unzip();
    rayon::join(
        || step_parts(motion, rows, columns, first),
        || step_parts(motion, more_rows, more_columns, second),
    );
}
