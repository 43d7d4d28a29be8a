//! Free areas whose skeleton is a point: no road leads there.

use std::collections::BTreeSet;

use super::skeleton::NEIGHBOURS;

/// Returns the first cell of each connected part of a skeleton that has no chain of cells.
pub fn without_chain(cells: &[u32], width: usize, chains: &[Vec<u32>]) -> Vec<u32> {
    let mut left: BTreeSet<u32> = cells.iter().copied().collect();
    for &cell in chains.iter().flatten() {
        take_part(&mut left, width, cell);
    }
    let mut found = Vec::new();
    while let Some(&first) = left.first() {
        take_part(&mut left, width, first);
        found.push(first);
    }
    found
}

/// Removes a cell with all that are connected with it.
fn take_part(left: &mut BTreeSet<u32>, width: usize, cell: u32) {
    let mut open = vec![cell];
    while let Some(cell) = open.pop() {
        if left.remove(&cell) {
            let around = NEIGHBOURS.map(|[x, y]| i64::from(cell) + (x + y * width as isize) as i64);
            open.extend(around.into_iter().filter_map(|other| u32::try_from(other).ok()));
        }
    }
}
