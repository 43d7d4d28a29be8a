//! Work on all cores.

use std::panic::resume_unwind;

/// Fewer results than this take less time than it takes to start a thread.
const FEWEST: usize = 256;

/// Returns `work` of 0 to `count`, in that order.
///
/// # Panics
/// If `work` does.
pub(super) fn map<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    if cores == 1 || count < FEWEST {
        return (0..count).map(work).collect();
    }
    let chunk = count.div_ceil(cores);
    let (work, chunks) = (&work, (0..count).step_by(chunk));
    std::thread::scope(|scope| {
        let part = |first: usize| (first..(first + chunk).min(count)).map(work).collect::<Vec<T>>();
        let threads: Vec<_> = chunks.map(|first| scope.spawn(move || part(first))).collect();
        threads
            .into_iter()
            .flat_map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
            .collect()
    })
}
