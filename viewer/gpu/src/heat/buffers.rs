//! The heat map's data on the GPU.

use glam::{UVec2, Vec4};
use regatta_scene::heat::{HeatMap, HotCurve};
use regatta_scene::palette::COLOURS;
use wgpu::{BindGroup, BindGroupLayout, Buffer, BufferUsages, CommandEncoder};

use crate::bindings::bind_group;
use crate::device::Gpu;
use crate::resources::buffer;

/// Steps of heat; the same as in heat.wgsl.
const STEPS: usize = 16;
/// The words of the shader's `starts`.
const STARTS: usize = 36;
/// The size of the arguments of an indirect draw.
const DRAW_BYTES: usize = 16;
/// The most curves: those beyond are left out.
const MAX_CURVES: usize = 4 << 20;

/// The curves, coldest first, and what a picture makes of them.
#[derive(Debug)]
pub struct Buffers {
    layouts: [BindGroupLayout; 2],
    /// For sorting and for drawing; `None` after a buffer was replaced.
    groups: Option<[BindGroup; 2]>,
    all: Buffer,
    visible: Buffer,
    starts: Buffer,
    counts: Buffer,
    arguments: Buffer,
    pixels: Buffer,
    ramp: Buffer,
    curves: u32,
    /// Steps that have curves, of straight and of bent ones.
    is_used: [[bool; STEPS]; 2],
}

impl Buffers {
    /// Creates small buffers. The layouts are those of the groups for sorting and for drawing.
    pub fn new(gpu: &Gpu, sorting: BindGroupLayout, drawing: BindGroupLayout) -> Self {
        let storage =
            |label, bytes, usage| buffer(gpu, label, bytes, BufferUsages::STORAGE | usage);
        let none = BufferUsages::empty();
        Self {
            layouts: [sorting, drawing],
            groups: None,
            all: storage("hot curves", size_of::<HotCurve>(), none),
            visible: storage("hot curves in sight", size_of::<u32>(), none),
            starts: buffer(gpu, "steps of heat", STARTS * size_of::<u32>(), BufferUsages::UNIFORM),
            counts: storage("counts of heat", (2 * STEPS + 1) * size_of::<u32>(), none),
            arguments: storage(
                "draws of heat",
                (2 * STEPS + 1) * DRAW_BYTES,
                BufferUsages::INDIRECT,
            ),
            pixels: storage("pixels of heat", size_of::<u32>(), none),
            ramp: buffer(gpu, "heat ramp", COLOURS * size_of::<Vec4>(), BufferUsages::UNIFORM),
            curves: 0,
            is_used: [[false; STEPS]; 2],
        }
    }

    /// Replaces the curves. The buffers grow as needed.
    pub fn set(&mut self, gpu: &Gpu, map: Option<&HeatMap>) {
        let all: Vec<HotCurve> = map
            .iter()
            .flat_map(|map| map.straight.iter().chain(&map.bent))
            .copied()
            .take(MAX_CURVES)
            .collect();
        let straight = map.map_or(0, |map| map.straight.len()).min(all.len());
        self.curves = all.len() as u32;
        if size_of_val(&all[..]) as u64 > self.all.size() {
            let room = all.len().next_power_of_two();
            self.all =
                buffer(gpu, "hot curves", room * size_of::<HotCurve>(), BufferUsages::STORAGE);
            self.visible =
                buffer(gpu, "hot curves in sight", room * size_of::<u32>(), BufferUsages::STORAGE);
            self.groups = None;
        }
        if all.is_empty() {
            return;
        }
        let starts = starts(&all, straight);
        self.is_used = [0, STEPS].map(|first| {
            std::array::from_fn(|step| starts[first + step] < starts[first + step + 1])
        });
        gpu.queue.write_buffer(&self.all, 0, bytemuck::cast_slice(&all));
        gpu.queue.write_buffer(&self.starts, 0, bytemuck::cast_slice(&starts));
    }

    /// Uploads the colours from cold to hot.
    pub fn set_ramp(&self, gpu: &Gpu, colours: &[Vec4; COLOURS]) {
        gpu.queue.write_buffer(&self.ramp, 0, bytemuck::cast_slice(colours));
    }

    /// The number of curves.
    pub fn curves(&self) -> u32 {
        self.curves
    }

    /// Clears what the picture before has left, and makes room for the pixels of a picture of
    /// `size`, if ribbons are drawn into them. Returns the group for sorting.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        size: Option<UVec2>,
    ) -> &BindGroup {
        encoder.clear_buffer(&self.counts, 0, None);
        if let Some(size) = size {
            let bytes = u64::from(size.x) * u64::from(size.y) * size_of::<u32>() as u64;
            if bytes > self.pixels.size() {
                self.pixels = buffer(gpu, "pixels of heat", bytes as usize, BufferUsages::STORAGE);
                self.groups = None;
            }
            encoder.clear_buffer(&self.pixels, 0, Some(bytes));
        }
        let groups = self.groups.take().unwrap_or_else(|| self.bind(gpu));
        &self.groups.insert(groups)[0]
    }

    fn bind(&self, gpu: &Gpu) -> [BindGroup; 2] {
        let Self {
            layouts: [sorting, drawing],
            all,
            visible,
            starts,
            counts,
            arguments,
            pixels,
            ramp,
            ..
        } = self;
        let sorted =
            [(0, all), (1, starts), (2, visible), (3, counts), (4, arguments), (5, pixels)];
        let drawn = [(0, all), (6, ramp), (7, visible), (8, pixels)];
        [bind_group(gpu, sorting, &sorted), bind_group(gpu, drawing, &drawn)]
    }

    /// The group for drawing, after [`prepare`](Self::prepare).
    pub fn drawing(&self) -> Option<&BindGroup> {
        self.groups.as_ref().map(|[_, drawing]| drawing)
    }

    /// The arguments of the draws.
    pub fn arguments(&self) -> &Buffer {
        &self.arguments
    }

    /// Where the arguments of the draw of ribbons in pixels are.
    pub fn splatted_draw(&self) -> u64 {
        (2 * STEPS * DRAW_BYTES) as u64
    }

    /// Where the arguments of each draw are, of straight and of bent curves, the coldest first.
    pub fn draws(&self) -> [Vec<u64>; 2] {
        let at = |first: usize, used: [bool; STEPS]| {
            (0..STEPS)
                .filter(|step| used[*step])
                .map(|step| ((first + step) * DRAW_BYTES) as u64)
                .collect()
        };
        [at(0, self.is_used[0]), at(STEPS, self.is_used[1])]
    }
}

/// Returns where each step of heat begins: of the straight curves, which come first, then of the
/// bent ones; then the end. Both are sorted by heat.
fn starts(all: &[HotCurve], straight: usize) -> [u32; STARTS] {
    let step = |hot: &HotCurve| ((hot.level * STEPS as f32) as usize).min(STEPS - 1);
    let mut starts = [all.len() as u32; STARTS];
    for (kind, (curves, first)) in
        [(&all[..straight], 0), (&all[straight..], straight)].into_iter().enumerate()
    {
        for number in 0..STEPS {
            starts[kind * STEPS + number] =
                (first + curves.partition_point(|hot| step(hot) < number)) as u32;
        }
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_heat_begin_where_their_curves_do() {
        let hot = |level| HotCurve { curve: 0, level };
        let all = [0.0, 0.05, 0.07, 0.5, 1.0, 0.0, 0.99].map(hot);
        let starts = starts(&all, 5);
        assert_eq!(starts[..3], [0, 2, 3], "two of the first step, one of the second");
        assert_eq!((starts[8], starts[9], starts[15], starts[16]), (3, 4, 4, 5));
        assert_eq!(
            (starts[17], starts[31], starts[32]),
            (6, 6, 7),
            "then the bent ones, and the end"
        );
    }
}
