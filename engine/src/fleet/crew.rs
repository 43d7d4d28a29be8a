//! The threads that share a step: each takes a contiguous range of blocks.

use regatta_plugin::frame::ColumnsMut;

use super::{Events, FleetError};
use crate::motion::{BLOCK, Motion, Rows, split_frame};

/// The threads of a fleet, each with room for its events.
#[derive(Debug)]
pub(super) struct Crew {
    pool: rayon::ThreadPool,
    events: Vec<Events>,
}

impl Crew {
    pub fn new(threads: usize) -> Result<Self, FleetError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|number| format!("motion-{number}"))
            .build()
            .map_err(|_| FleetError::Threads(threads))?;
        Ok(Self { pool, events: vec![Events::new(0); threads] })
    }

    /// [`Motion::step`], by all threads. Events come in the order of rows, as from one thread.
    pub fn step(&mut self, motion: &Motion, rows: Rows, columns: Option<ColumnsMut>, events: &mut Events) {
        self.events.iter_mut().for_each(|part| part.take_over(events));
        self.pool.install(|| share(motion, rows, columns, &mut self.events));
        self.events.iter_mut().for_each(|part| events.append(part));
    }
}

fn share(motion: &Motion, rows: Rows, columns: Option<ColumnsMut>, events: &mut [Events]) {
    if let [events] = events {
        return motion.step(rows, columns, events);
    }
    let blocks = rows.len().div_ceil(BLOCK);
    let (first, second) = events.split_at_mut(events.len() / 2);
    let middle = BLOCK * (blocks * first.len() / (first.len() + second.len()));
    let (rows, more_rows) = rows.split_at(middle);
    let (columns, more_columns) = columns.map(|columns| split_frame(columns, middle)).unzip();
    rayon::join(|| share(motion, rows, columns, first), || share(motion, more_rows, more_columns, second));
}
