//! The check that a route graph fits the memory of this machine.

use regatta_layout::RouteGraph;
use regatta_motion::MAX_PIECES;

use super::FleetError;
use crate::arc_length;

/// Checks that a graph can be compiled: before that, because it takes memory.
///
/// # Errors
/// [`FleetError::TooManyPieces`] or [`FleetError::GraphTooLarge`].
pub fn check_size(graph: &RouteGraph) -> Result<(), FleetError> {
    let pieces = arc_length::least_pieces(graph);
    if pieces > MAX_PIECES as u64 {
        let pieces = usize::try_from(pieces).unwrap_or(usize::MAX);
        return Err(FleetError::TooManyPieces { pieces, max: MAX_PIECES });
    }
    let needed = pieces * arc_length::BYTES_PER_PIECE;
    match available_memory() {
        Some(available) if needed > available => Err(FleetError::GraphTooLarge {
            pieces,
            needed_mb: needed >> 20,
            available_mb: available >> 20,
        }),
        _ => Ok(()),
    }
}

/// Returns the available memory in bytes; `None` if the system doesn't report it.
fn available_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes << 10)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::tests::support::{chain, town};

    #[test]
    fn graphs_that_no_memory_holds_are_refused_before_they_are_compiled() {
        assert!(check_size(&chain(&[(1e6, 1.0)])).is_ok());
        // A hundred million kilometres; in both gears.
        let error =
            check_size(&chain(&[(1.0, 1.0), (1e11, 1.0)])).expect_err("too long").to_string();
        assert!(
            error.starts_with("the route graph compiles to 24999999")
                && error.contains("in metres?"),
            "{error}"
        );
        assert!(matches!(
            check_size(&chain(&[(1e300, 1.0)])),
            Err(FleetError::TooManyPieces { .. })
        ));
    }

    #[test]
    fn the_least_number_of_pieces_is_at_most_the_number_and_of_its_size() {
        for graph in [chain(&[(100.0, 1.0), (8.0, 1.0), (0.5, 1.0), (1e4, 1.0)]), town(12, 30.0)] {
            let (least, compiled) = (
                arc_length::least_pieces(&graph),
                arc_length::compile(&graph).pieces().len() as u64,
            );
            assert!(least <= compiled && compiled <= 4 * least, "{least}, {compiled}");
        }
    }
}
