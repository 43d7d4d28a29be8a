//! A uniform grid that finds tracks near each other.

use super::super::{Rectangle, cores};

/// Tracks by the cells that they sweep.
#[derive(Debug)]
pub struct Grid {
    origin: [f32; 2],
    cell: f32,
    columns: u32,
    rows: u32,
    /// Tracks in each cell: `tracks[starts[c]..starts[c + 1]]`, in ascending order.
    starts: Vec<u32>,
    tracks: Vec<u32>,
}

/// The largest number of cells; larger plants get larger cells.
const MOST_CELLS: f32 = 4e6;

impl Grid {
    /// Sorts tracks, each a list of rectangles, into cells of at least `cell` metres.
    pub fn new(tracks: &[&[Rectangle]], cell: f32) -> Self {
        let mut low = [f32::INFINITY; 2];
        let mut high = [f32::NEG_INFINITY; 2];
        for rectangle in tracks.iter().copied().flatten() {
            let radius = rectangle.radius();
            for axis in [0, 1] {
                low[axis] = low[axis].min(rectangle.centre[axis] - radius);
                high[axis] = high[axis].max(rectangle.centre[axis] + radius);
            }
        }
        let size = [0, 1].map(|axis| (high[axis] - low[axis]).max(1.0));
        let cell = cell
            .max((size[0] * size[1] / MOST_CELLS).sqrt())
            .max(size[0].max(size[1]) / MOST_CELLS);
        let [columns, rows] = size.map(|metres| (metres / cell) as u32 + 1);
        let mut grid =
            Self { origin: low, cell, columns, rows, starts: Vec::new(), tracks: Vec::new() };
        let cells = cores::map(tracks.len(), |track| grid.cells_of(tracks[track]));
        let mut ends = vec![0; columns as usize * rows as usize + 1];
        cells.iter().flatten().for_each(|cell| ends[*cell as usize + 1] += 1);
        (1..ends.len()).for_each(|cell| ends[cell] += ends[cell - 1]);
        grid.starts.clone_from(&ends);
        grid.tracks = vec![0; *ends.last().unwrap_or(&0) as usize];
        for (track, cells) in (0..).zip(cells) {
            for cell in cells {
                grid.tracks[ends[cell as usize] as usize] = track;
                ends[cell as usize] += 1;
            }
        }
        grid
    }

    /// Returns the tracks that share a cell with these rectangles, in ascending order.
    pub fn near(&self, rectangles: &[Rectangle]) -> Vec<u32> {
        let tracks = |cell: u32| {
            &self.tracks
                [self.starts[cell as usize] as usize..self.starts[cell as usize + 1] as usize]
        };
        let mut near: Vec<u32> =
            self.cells_of(rectangles).into_iter().flat_map(tracks).copied().collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    /// Returns the cells that the bounding boxes of rectangles lie in, in ascending order.
    fn cells_of(&self, rectangles: &[Rectangle]) -> Vec<u32> {
        let mut cells = Vec::with_capacity(16);
        for rectangle in rectangles {
            let radius = rectangle.radius();
            let at = |axis: usize, offset: f32, count: u32| {
                (((rectangle.centre[axis] + offset - self.origin[axis]) / self.cell) as u32)
                    .min(count - 1)
            };
            for row in at(1, -radius, self.rows)..=at(1, radius, self.rows) {
                let (first, last) = (at(0, -radius, self.columns), at(0, radius, self.columns));
                cells.extend((first..=last).map(|column| row * self.columns + column));
            }
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}
