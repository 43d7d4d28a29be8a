//! A uniform grid that finds tracks near each other.

use glam::{Vec2, uvec2};

use super::Rectangle;
use crate::cores;
use crate::rows::Rows;

/// Tracks by the cells that they sweep.
#[derive(Debug)]
pub struct Grid {
    origin: Vec2,
    cell: f32,
    columns: u32,
    rows: u32,
    /// By cell: the tracks in it, in ascending order.
    tracks: Rows<u32>,
}

/// The largest number of cells; larger plants get larger cells.
const MOST_CELLS: f32 = 4e6;

impl Grid {
    /// Sorts tracks, each a list of rectangles, into cells of at least `cell` metres.
    pub fn new(tracks: &[&[Rectangle]], cell: f32) -> Self {
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for rectangle in tracks.iter().copied().flatten() {
            let radius = rectangle.radius();
            low = low.min(rectangle.centre - radius);
            high = high.max(rectangle.centre + radius);
        }
        let size = (high - low).max(Vec2::ONE);
        let cell =
            cell.max((size.x * size.y / MOST_CELLS).sqrt()).max(size.max_element() / MOST_CELLS);
        let [columns, rows] = size.to_array().map(|metres| (metres / cell) as u32 + 1);
        let mut grid =
            Self { origin: low, cell, columns, rows, tracks: Rows::of_parts(vec![0], Vec::new()) };
        let cells = cores::map(tracks.len(), |track| grid.cells_of(tracks[track]));
        let pairs = (0..)
            .zip(cells)
            .flat_map(|(track, cells)| cells.into_iter().map(move |cell| (cell, track)));
        grid.tracks = Rows::new(columns as usize * rows as usize, pairs.collect());
        grid
    }

    /// Returns the tracks that share a cell with these rectangles, in ascending order.
    pub fn near(&self, rectangles: &[Rectangle]) -> Vec<u32> {
        let cells = self.cells_of(rectangles);
        let mut near: Vec<u32> =
            cells.into_iter().flat_map(|cell| self.tracks.row(cell)).copied().collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    /// Returns the cells that the bounding boxes of rectangles lie in, in ascending order.
    fn cells_of(&self, rectangles: &[Rectangle]) -> Vec<u32> {
        let mut cells = Vec::with_capacity(16);
        for rectangle in rectangles {
            let radius = rectangle.radius();
            let [low, high] = [-radius, radius].map(|offset| {
                ((rectangle.centre + offset - self.origin) / self.cell)
                    .as_uvec2()
                    .min(uvec2(self.columns - 1, self.rows - 1))
            });
            for row in low.y..=high.y {
                cells.extend((low.x..=high.x).map(|column| row * self.columns + column));
            }
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }
}
