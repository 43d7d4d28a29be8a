//! The outlines of the occupied cells.

use super::grid::{Cell, Grid};

/// The largest number of corners of all outlines.
pub const MAX_POINTS: usize = 4_000_000;

/// The steps along the sides of cells: to the right, up, to the left, down.
const STEPS: [[i32; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// Returns closed lines around the occupied cells, through the corners of cells, with the occupied
/// side on the left; `None` if there are too many.
pub fn outlines(grid: &Grid) -> Option<Vec<Vec<[u32; 2]>>> {
    let mut sides = sides(grid);
    let (mut lines, mut points) = (Vec::new(), 0);
    for start in 0..sides.len() {
        while sides[start] != 0 {
            let line = trace(&mut sides, start, grid.width + 1);
            points += line.len();
            if points > MAX_POINTS {
                return None;
            }
            lines.push(line);
        }
    }
    Some(lines)
}

/// Returns, for each corner of cells, a bit for each of [`STEPS`] in which an outline leaves it.
fn sides(grid: &Grid) -> Vec<u8> {
    let (width, corners) = (grid.width, grid.width + 1);
    let mut sides = vec![0; corners * (grid.height + 1)];
    // The border isn't occupied, so that all neighbours exist.
    for row in 1..grid.height - 1 {
        for column in 1..width - 1 {
            let cell = row * width + column;
            if grid.cells[cell] != Cell::Occupied {
                continue;
            }
            let corner = row * corners + column;
            let neighbours = [cell - width, cell + 1, cell + width, cell - 1];
            let starts = [corner, corner + 1, corner + corners + 1, corner + corners];
            for (step, (neighbour, start)) in neighbours.into_iter().zip(starts).enumerate() {
                if grid.cells[neighbour] != Cell::Occupied {
                    sides[start] |= 1 << step;
                }
            }
        }
    }
    sides
}

/// Follows an outline from a corner until it closes, and removes it. Collinear sides are one.
fn trace(sides: &mut [u8], start: usize, corners: usize) -> Vec<[u32; 2]> {
    let mut line = vec![point(start, corners)];
    let (mut corner, mut step) = (start, sides[start].trailing_zeros() as usize);
    loop {
        sides[corner] &= !(1 << step);
        let [x, y] = STEPS[step];
        corner = corner.wrapping_add_signed(x as isize + y as isize * corners as isize);
        // The left turn comes first. It stays at the same cell where two cells touch at a corner.
        let next = [1, 0, 3]
            .map(|turn| (step + turn) % 4)
            .into_iter()
            .find(|&next| sides[corner] & (1 << next) != 0);
        match next {
            Some(next) if next == step => {}
            Some(next) => {
                line.push(point(corner, corners));
                step = next;
            }
            None => {
                line.push(point(corner, corners));
                return line;
            }
        }
    }
}

/// Returns the column and the row of a corner; a row has `corners` of them.
fn point(corner: usize, corners: usize) -> [u32; 2] {
    [(corner % corners) as u32, (corner / corners) as u32]
}
