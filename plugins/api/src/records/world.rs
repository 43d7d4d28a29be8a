//! The world: the route graph and the robot types, published once per change on `regatta/F/world`.
//! A sample is a block of lines: nodes, edges and robot types, each section starting on a whole line.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use super::frame::{BYTES_PER_LINE, Line};
use super::sequence::Sequenced;
use super::{padded, text};

/// The iceoryx2 user header of `regatta/F/world`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_WorldHeader")]
pub struct WorldHeader {
    /// The run that this world belongs to.
    pub run_id: u64,
    /// Counts the worlds of a run, from 1.
    pub revision: u64,
    /// Number of [`NodeRecord`]s.
    pub nodes: u32,
    /// Number of [`EdgeRecord`]s.
    pub edges: u32,
    /// Number of [`RobotTypeRecord`]s.
    pub robot_types: u32,
    /// Zero.
    pub reserved: u32,
}

/// A node of the route graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_NodeRecord")]
pub struct NodeRecord {
    /// Id in the route graph's file.
    pub id: u32,
    /// Metres east.
    pub x: f32,
    /// Metres north.
    pub y: f32,
    /// Radians in (-π, π].
    pub theta: f32,
}

/// An edge of the route graph: a cubic Bézier curve. Straight edges are written as one too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_EdgeRecord")]
pub struct EdgeRecord {
    /// Id in the route graph's file.
    pub id: u32,
    /// Index of the origin in the world's nodes.
    pub origin: u32,
    /// Index of the destination in the world's nodes.
    pub destination: u32,
    /// Arc length in metres.
    pub length: f32,
    /// Control points P0 to P3, each x and y in metres.
    pub control_points: [[f32; 2]; 4],
    /// Metres per second from origin to destination.
    pub velocity_forward: f32,
    /// Metres per second from destination to origin in reverse gear; 0 if that is not allowed.
    pub velocity_backwards: f32,
    /// Zero.
    pub reserved: [u32; 2],
}

/// A robot type.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("regatta_RobotTypeRecord")]
pub struct RobotTypeRecord {
    /// Name in UTF-8, padded with zeros.
    pub name: [u8; 44],
    /// A [`Shape`].
    pub shape: u32,
    /// Metres along the heading; of a circle, its diameter.
    pub length: f32,
    /// Metres across it.
    pub width: f32,
    /// Metres per second; `f32::INFINITY` for no limit.
    pub max_speed: f32,
    /// Metres per second squared; `f32::INFINITY` for no limit.
    pub max_acceleration: f32,
}

/// The footprint of a robot, about its pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Shape {
    /// `length` along the heading, `width` across it.
    #[default]
    Rectangle = 0,
    /// A circle of diameter `length`.
    Circle = 1,
}

/// The sections of a world in its block of lines: each starts on a whole line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WorldLayout {
    pub(crate) nodes: usize,
    pub(crate) edges: usize,
    pub(crate) robot_types: usize,
}

impl WorldLayout {
    fn of(header: &WorldHeader) -> Self {
        Self { nodes: header.nodes as usize, edges: header.edges as usize, robot_types: header.robot_types as usize }
    }

    pub(crate) fn header(self, run_id: u64, revision: u64) -> WorldHeader {
        WorldHeader {
            run_id,
            revision,
            nodes: self.nodes as u32,
            edges: self.edges as u32,
            robot_types: self.robot_types as u32,
            reserved: 0,
        }
    }

    /// Returns the number of lines before the edges, before the robot types, and in all.
    fn ends(self) -> [usize; 3] {
        let nodes = (self.nodes * size_of::<NodeRecord>()).div_ceil(BYTES_PER_LINE);
        let edges = nodes + (self.edges * size_of::<EdgeRecord>()).div_ceil(BYTES_PER_LINE);
        [nodes, edges, edges + (self.robot_types * size_of::<RobotTypeRecord>()).div_ceil(BYTES_PER_LINE)]
    }

    pub(crate) fn lines(self) -> usize {
        self.ends()[2]
    }

    pub(crate) fn write(
        self,
        lines: &mut [Line],
        nodes: &[NodeRecord],
        edges: &[EdgeRecord],
        robot_types: &[RobotTypeRecord],
    ) {
        let [edges_at, types_at, _] = self.ends();
        let (nodes_lines, rest) = lines.split_at_mut(edges_at);
        let (edges_lines, types_lines) = rest.split_at_mut(types_at - edges_at);
        bytemuck::cast_slice_mut::<Line, NodeRecord>(nodes_lines)[..self.nodes].copy_from_slice(nodes);
        bytemuck::cast_slice_mut::<Line, EdgeRecord>(edges_lines)[..self.edges].copy_from_slice(edges);
        bytemuck::cast_slice_mut::<Line, RobotTypeRecord>(types_lines)[..self.robot_types].copy_from_slice(robot_types);
    }
}

/// A reader's view of the world: slices of shared memory, not copies.
#[derive(Clone, Copy, Debug)]
pub struct World<'sample> {
    header: &'sample WorldHeader,
    nodes: &'sample [NodeRecord],
    edges: &'sample [EdgeRecord],
    robot_types: &'sample [RobotTypeRecord],
}

impl<'sample> World<'sample> {
    /// Splits a block of lines into its sections. Returns `None` if it has fewer lines than the header implies.
    pub(crate) fn split(header: &'sample WorldHeader, lines: &'sample [Line]) -> Option<Self> {
        let layout = WorldLayout::of(header);
        let [edges_at, types_at, end] = layout.ends();
        if lines.len() < end {
            return None;
        }
        Some(Self {
            header,
            nodes: &bytemuck::cast_slice(&lines[..edges_at])[..layout.nodes],
            edges: &bytemuck::cast_slice(&lines[edges_at..types_at])[..layout.edges],
            robot_types: &bytemuck::cast_slice(&lines[types_at..end])[..layout.robot_types],
        })
    }

    /// The run that the world belongs to.
    pub fn run_id(&self) -> u64 {
        self.header.run_id
    }

    /// Counts the worlds of a run, from 1.
    pub fn revision(&self) -> u64 {
        self.header.revision
    }

    /// The nodes of the route graph.
    pub fn nodes(&self) -> &'sample [NodeRecord] {
        self.nodes
    }

    /// The edges of the route graph; a frame's `edge` column holds indices into them.
    pub fn edges(&self) -> &'sample [EdgeRecord] {
        self.edges
    }

    /// The robot types; the column `type` holds indices into them.
    pub fn robot_types(&self) -> &'sample [RobotTypeRecord] {
        self.robot_types
    }
}

impl RobotTypeRecord {
    /// The name, up to the first byte that is not UTF-8.
    pub fn name(&self) -> &str {
        text(&self.name)
    }

    /// The footprint. An unknown number counts as a rectangle.
    pub fn shape(&self) -> Shape {
        if self.shape == Shape::Circle as u32 { Shape::Circle } else { Shape::Rectangle }
    }

    /// Returns `name` as the record holds it: cut to 44 bytes, padded with zeros.
    pub fn padded_name(name: &str) -> [u8; 44] {
        padded(name)
    }
}

impl Sequenced for WorldHeader {
    fn run_id(&self) -> u64 {
        self.run_id
    }

    fn sequence(&self) -> u64 {
        self.revision
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_is_cut_where_it_was_joined() {
        let nodes: Vec<_> = (0..5).map(|id| NodeRecord { id, x: id as f32, ..NodeRecord::default() }).collect();
        let edges: Vec<_> = (0..3).map(|id| EdgeRecord { id, length: 2.0, ..EdgeRecord::default() }).collect();
        let types = [RobotTypeRecord { name: padded("tug"), ..Zeroable::zeroed() }];
        let layout = WorldLayout { nodes: 5, edges: 3, robot_types: 1 };
        let mut lines = vec![Line::default(); layout.lines()];
        layout.write(&mut lines, &nodes, &edges, &types);
        let header = layout.header(7, 1);
        let world = World::split(&header, &lines).unwrap();
        assert_eq!((world.nodes(), world.edges()), (&nodes[..], &edges[..]));
        assert_eq!(world.robot_types()[0].name(), "tug");
        assert!(World::split(&header, &lines[1..]).is_none(), "a line is missing");
    }
}
