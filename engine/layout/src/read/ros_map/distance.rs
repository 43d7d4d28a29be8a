//! The exact distance of each cell from the nearest cell that isn't free (Felzenszwalb and
//! Huttenlocher 2012).

use rayon::prelude::*;

use super::grid::{Cell, Grid};

/// Returns the squared distances between the centres of cells, in cells.
pub fn squared_distances(grid: &Grid) -> Vec<u32> {
    let vertical = vertical_distances(grid);
    let mut squares = vec![0; grid.cells.len()];
    let rows = squares.par_chunks_mut(grid.width).zip(vertical.par_chunks(grid.width));
    rows.for_each_init(Envelope::default, |envelope, (squares, vertical)| {
        envelope.row(vertical, squares)
    });
    squares
}

/// Returns the distance of each cell from the nearest one in its column that isn't free. The border
/// ensures that each column has one.
fn vertical_distances(grid: &Grid) -> Vec<u16> {
    let width = grid.width;
    let mut distances = vec![0u16; grid.cells.len()];
    for cell in width..distances.len() {
        if grid.cells[cell] == Cell::Free {
            distances[cell] = distances[cell - width] + 1;
        }
    }
    for cell in (0..distances.len() - width).rev() {
        distances[cell] = distances[cell].min(distances[cell + width] + 1);
    }
    distances
}

/// The lower envelope of the parabolas `(x - column)² + distance²` of a row.
#[derive(Default)]
struct Envelope {
    /// The columns of the parabolas, each with the x from which on it is the lowest.
    parabolas: Vec<(usize, f64)>,
}

impl Envelope {
    fn row(&mut self, vertical: &[u16], squares: &mut [u32]) {
        let height = |column: usize| f64::from(vertical[column]).powi(2) + (column as f64).powi(2);
        self.parabolas.clear();
        for column in 0..vertical.len() {
            let mut from = f64::NEG_INFINITY;
            while let Some(&(other, other_from)) = self.parabolas.last() {
                from = (height(column) - height(other)) / (2.0 * (column - other) as f64);
                if from > other_from {
                    break;
                }
                self.parabolas.pop();
                from = f64::NEG_INFINITY;
            }
            self.parabolas.push((column, from));
        }
        let mut lowest = 0;
        for (x, square) in squares.iter_mut().enumerate() {
            while self.parabolas.get(lowest + 1).is_some_and(|&(_, from)| from <= x as f64) {
                lowest += 1;
            }
            let column = self.parabolas[lowest].0;
            *square = (column.abs_diff(x) as u32).pow(2) + u32::from(vertical[column]).pow(2);
        }
    }
}
