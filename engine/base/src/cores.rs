//! Work on all cores.

use std::panic::resume_unwind;

/// Fewer results than this take less time than it takes to start a thread.
const FEWEST: usize = 256;

/// Returns `work` of 0 to `count`, in that order.
///
/// # Panics
/// If `work` does.
pub fn map<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    map_on(if count < FEWEST { 1 } else { cores }, count, work)
}

/// As [`map`], on so many threads.
///
/// # Panics
/// If `work` does.
pub fn map_on<T: Send>(threads: usize, count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    if threads == 1 || count < 2 {
        return (0..count).map(work).collect();
    }
    let chunk = count.div_ceil(threads);
    let (work, chunks) = (&work, (0..count).step_by(chunk));
    std::thread::scope(|scope| {
        let mut threads = Vec::new();
        for first in chunks {
            let part = (first..(first + chunk).min(count)).map(work);
            threads.push(scope.spawn(move || part.collect::<Vec<T>>()));
        }
        threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
            .collect()
    })
}
