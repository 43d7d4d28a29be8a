//! The skeleton of the free space: lines one cell wide in its middle. It is computed by thinning in
//! the order of the exact distance of each cell from the nearest one that isn't free (Felzenszwalb
//! and Huttenlocher 2012).

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

/// Cells with a smaller gradient of the distance are in the middle between two walls. The gradient
/// is 1 beside one wall, 0 in the middle of a corridor, and √½ on the line into the corner of a
/// room, which isn't a road.
const RIDGE: f32 = 0.6;

/// The largest number of passes over the remaining cells.
const MAX_PASSES: usize = 100;

/// The neighbours of a cell, counter-clockwise: columns and rows.
pub const NEIGHBOURS: [[isize; 2]; 8] =
    [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];

/// Returns the cells of the skeleton, ascending. Only cells with at least the squared distance
/// `least` count, which the border doesn't have.
pub fn skeleton(squares: &[u32], width: usize, least: u32) -> Vec<u32> {
    let offsets = NEIGHBOURS.map(|[x, y]| x + y * width as isize);
    let mut thinning =
        Thinning { inside: squares.iter().map(|&square| square >= least).collect(), offsets };
    let mut cells: Vec<u32> =
        (0..squares.len() as u32).filter(|&cell| thinning.inside[cell as usize]).collect();
    cells.par_sort_unstable_by_key(|&cell| (squares[cell as usize], cell));
    // The first pass thins to lines as wide as the ridges, and keeps their ends. The second thins
    // to lines of one cell.
    thinning.thin(&mut cells, |cell, _| is_ridge(squares, width, cell));
    thinning.thin(&mut cells, |_, neighbours| neighbours.count_ones() <= 1);
    cells.sort_unstable();
    cells
}

fn is_ridge(squares: &[u32], width: usize, cell: usize) -> bool {
    let [east, west, north, south] =
        [cell + 1, cell - 1, cell + width, cell - width].map(|cell| (squares[cell] as f32).sqrt());
    (east - west).hypot(north - south) / 2.0 < RIDGE
}

/// Removes cells without changing the connectivity of the rest.
struct Thinning {
    inside: Vec<bool>,
    offsets: [isize; 8],
}

impl Thinning {
    /// Removes cells in order, except those to keep, until no more can be removed.
    fn thin(&mut self, cells: &mut Vec<u32>, keep: impl Fn(usize, u8) -> bool) {
        for _ in 0..MAX_PASSES {
            let before = cells.len();
            cells.retain(|&cell| {
                let cell = cell as usize;
                let neighbours = self.neighbours(cell);
                let stays = !is_simple(neighbours) || keep(cell, neighbours);
                self.inside[cell] = stays;
                stays
            });
            if cells.len() == before {
                return;
            }
        }
    }

    /// Returns a bit for each of [`NEIGHBOURS`] that is inside.
    fn neighbours(&self, cell: usize) -> u8 {
        let bits = self.offsets.iter().enumerate();
        bits.fold(0, |bits, (bit, &offset)| {
            bits | u8::from(self.inside[cell.wrapping_add_signed(offset)]) << bit
        })
    }
}

/// Whether a cell can be removed: its neighbours inside are connected without it, and one beside,
/// above or below it is outside.
fn is_simple(neighbours: u8) -> bool {
    // There must be exactly one run of outside neighbours that contains one beside, above or below.
    let outside = !neighbours;
    let sides = outside & 0b0101_0101;
    // A side starts a run unless the neighbours before it connect it to the side before.
    let connected = sides & outside.rotate_left(1) & sides.rotate_left(2);
    let runs = sides.count_ones() - connected.count_ones();
    runs == 1
}
