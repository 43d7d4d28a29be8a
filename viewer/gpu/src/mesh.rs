//! Robot meshes, and the built-in ones. x is forward, y left, z up.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{Buffer, BufferUsages};

use super::device::Gpu;

/// The number of points of a rounded corner.
const CORNER: usize = 5;

/// A vertex of a mesh, in the layout of the GPU's vertex buffer.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// Position in metres, or for built-in meshes in units of the robot's length, width and height.
    pub position: [f32; 3],
    /// Normal of length 127; the last component is padding.
    pub normal: [i8; 4],
    /// Linear red, green and blue, and the share of the robot's own colour that replaces them; each
    /// from 0 to 255.
    pub paint: [u8; 4],
}

/// A triangle mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Three indices per triangle, counter-clockwise as seen from outside.
    pub indices: Vec<u32>,
}

/// A mesh's vertex and index buffers.
#[derive(Debug)]
pub(super) struct MeshBuffers {
    pub vertices: Buffer,
    pub indices: Buffer,
    /// The number of indices.
    pub count: u32,
}

impl MeshBuffers {
    /// Uploads a mesh.
    pub fn new(gpu: &Gpu, mesh: &Mesh) -> Self {
        let [vertices, indices] = [
            (bytemuck::cast_slice(&mesh.vertices), BufferUsages::VERTEX),
            (bytemuck::cast_slice(&mesh.indices), BufferUsages::INDEX),
        ]
        .map(|(contents, usage)| {
            let descriptor = BufferInitDescriptor { label: Some("mesh"), contents, usage };
            gpu.device.create_buffer_init(&descriptor)
        });
        Self { vertices, indices, count: mesh.indices.len() as u32 }
    }
}

/// A [`Vertex::paint`].
type Paint = [u8; 4];

const RUBBER: Paint = [6, 7, 8, 0];
const SHELL: Paint = [150, 156, 162, 0];
const TRIM: Paint = [16, 18, 21, 0];
const OWN: Paint = [0, 0, 0, 255];
/// The stripe in front of a block: a darker shade of its own colour, so that blocks keep the hue of
/// the legend.
const NOSE: Paint = [0, 0, 0, 110];
const OWN_DEEP: Paint = [4, 5, 6, 190];
const MARKER: Paint = [235, 240, 245, 0];

impl Mesh {
    /// Returns a mobile robot with a rectangular deck, in units of its length, width and height.
    pub fn amr() -> Self {
        Self::deck(&|inset| rounded_rectangle(Vec2::splat(0.5 - inset), 0.16 - inset * 0.6))
    }

    /// Returns a mobile robot on a round base.
    pub fn round_amr() -> Self {
        Self::deck(&|inset| rounded_rectangle(Vec2::splat(0.5 - inset), 0.5 - inset))
    }

    fn deck(outline: &dyn Fn(f32) -> Vec<Vec2>) -> Self {
        let mut mesh = Self::default();
        mesh.loft(&[(outline(0.05), 0.0), (outline(0.05), 0.14)], RUBBER);
        mesh.loft(&[(outline(0.0), 0.14), (outline(0.0), 0.30)], SHELL);
        mesh.loft(&[(outline(0.0), 0.30), (outline(0.0), 0.62)], OWN);
        mesh.loft(&[(outline(0.0), 0.62), (outline(0.0), 0.80), (outline(0.035), 0.90)], SHELL);
        mesh.loft(&[(outline(0.05), 0.14), (outline(0.0), 0.14)], RUBBER);
        mesh.loft(&[(outline(0.035), 0.90), (outline(0.06), 0.90)], TRIM);
        mesh.cap(&outline(0.06), 0.90, OWN);
        // A plate on the deck, and an arrow that points forward.
        mesh.cap(
            &[(-0.36, -0.30), (0.02, -0.30), (0.02, 0.30), (-0.36, 0.30)].map(Vec2::from),
            0.905,
            OWN_DEEP,
        );
        mesh.cap(
            &[(0.19, 0.0), (0.10, -0.26), (0.40, 0.0), (0.10, 0.26)].map(Vec2::from),
            0.906,
            MARKER,
        );
        let puck = circle(Vec2::new(0.31, 0.0), 0.05);
        mesh.loft(&[(puck.clone(), 0.906), (puck.clone(), 1.0)], TRIM);
        mesh.cap(&puck, 1.0, TRIM);
        mesh
    }

    /// Returns a box with a darker stripe in front, in units of its length, width and height.
    pub fn block() -> Self {
        let mut mesh = Self::default();
        let square = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(Vec2::from).to_vec();
        mesh.loft(&[(square.clone(), 0.0), (square, 0.9)], [30, 32, 35, 190]);
        mesh.cap(&[(-0.5, -0.5), (0.18, -0.5), (0.18, 0.5), (-0.5, 0.5)].map(Vec2::from), 0.9, OWN);
        mesh.cap(&[(0.18, -0.5), (0.5, -0.5), (0.5, 0.5), (0.18, 0.5)].map(Vec2::from), 0.9, NOSE);
        mesh
    }

    /// Returns the block of a round robot: a cylinder with a darker stripe in front.
    pub fn round_block() -> Self {
        let rim = circle(Vec2::ZERO, 0.5);
        let mut mesh = Self::default();
        mesh.loft(&[(rim.clone(), 0.0), (rim.clone(), 0.9)], [30, 32, 35, 190]);
        mesh.cap(&rim, 0.9, OWN);
        mesh.cap(
            &[(0.15, -0.4), (0.4, -0.2), (0.4, 0.2), (0.15, 0.4)].map(Vec2::from),
            0.905,
            NOSE,
        );
        mesh
    }

    /// Adds walls between consecutive rings, which have the same number of points, each at its
    /// height. Normals are smooth around the rings.
    fn loft(&mut self, rings: &[(Vec<Vec2>, f32)], paint: Paint) {
        for pair in rings.windows(2) {
            let [(low, z0), (high, z1)] = pair else { continue };
            let count = low.len();
            // Vertices are not shared: a sharp corner needs a normal for each of its sides.
            for i in 0..count {
                let j = (i + 1) % count;
                let corners = [
                    low[i].extend(*z0),
                    low[j].extend(*z0),
                    high[j].extend(*z1),
                    high[i].extend(*z1),
                ];
                let flat =
                    (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalize_or(Vec3::Z);
                let normals = [i, j, j, i].map(|at| smooth(low, at, flat));
                let base = self.vertices.len() as u32;
                for (at, normal) in corners.into_iter().zip(normals) {
                    self.vertices.push(Vertex::new(at, normal, paint));
                }
                self.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| base + corner));
            }
        }
    }

    /// Adds a horizontal polygon that faces up, as a triangle fan around its first point.
    fn cap(&mut self, outline: &[Vec2], z: f32, paint: Paint) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(outline.iter().map(|at| Vertex::new(at.extend(z), Vec3::Z, paint)));
        let count = outline.len() as u32;
        self.indices.extend((1..count - 1).flat_map(|i| [base, base + i, base + i + 1]));
    }
}

/// Returns the normal at a ring's point: the mean of the adjacent walls' normals, or the flat one
/// at a sharp corner.
fn smooth(ring: &[Vec2], at: usize, flat: Vec3) -> Vec3 {
    let count = ring.len();
    let (before, after) = (ring[(at + count - 1) % count], ring[(at + 1) % count]);
    let [one, other] = [ring[at] - before, after - ring[at]]
        .map(|along| Vec2::new(along.y, -along.x).normalize_or_zero());
    if one.dot(other) < 0.8 || flat.z.abs() > 0.99 {
        return flat;
    }
    let level = (one + other).normalize_or_zero() * flat.truncate().length();
    level.extend(flat.z).normalize_or(flat)
}

fn rounded_rectangle(half: Vec2, radius: f32) -> Vec<Vec2> {
    let radius = radius.min(half.x).min(half.y);
    let centres = [Vec2::new(1.0, -1.0), Vec2::ONE, Vec2::new(-1.0, 1.0), Vec2::NEG_ONE];
    let mut points = Vec::with_capacity(4 * CORNER);
    for (quarter, centre) in centres.into_iter().enumerate() {
        for i in 0..CORNER {
            let quarters = quarter as f32 - 1.0 + i as f32 / (CORNER - 1) as f32;
            let outward = Vec2::from_angle(quarters * std::f32::consts::FRAC_PI_2);
            points.push(centre * (half - radius) + outward * radius);
        }
    }
    points
}

fn circle(centre: Vec2, radius: f32) -> Vec<Vec2> {
    (0..12)
        .map(|i| centre + Vec2::from_angle(i as f32 * std::f32::consts::TAU / 12.0) * radius)
        .collect()
}

impl Vertex {
    /// Creates a vertex from a normal of length 1.
    pub fn new(position: Vec3, normal: Vec3, paint: [u8; 4]) -> Self {
        let [x, y, z] = (normal * 127.0).round().to_array().map(|part| part as i8);
        Self { position: position.to_array(), normal: [x, y, z, 0], paint }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_meshes_fit_the_unit_box_and_face_outwards() {
        for mesh in [Mesh::amr(), Mesh::round_amr(), Mesh::block(), Mesh::round_block()] {
            assert!(mesh.indices.len().is_multiple_of(3));
            for vertex in &mesh.vertices {
                let [x, y, z] = vertex.position;
                assert!(
                    x.abs() < 0.501 && y.abs() < 0.501 && (0.0..=1.0).contains(&z),
                    "{vertex:?}"
                );
            }
            for triangle in mesh.indices.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[triangle[i] as usize]);
                let [p, q, r] = [a, b, c].map(|vertex| Vec3::from(vertex.position));
                let facing = (q - p).cross(r - p);
                let normal = Vec3::new(
                    f32::from(a.normal[0]),
                    f32::from(a.normal[1]),
                    f32::from(a.normal[2]),
                );
                assert!(
                    facing.length() < 1e-6 || facing.dot(normal) > 0.0,
                    "{p} {q} {r} faces {facing}, not {normal}"
                );
            }
        }
    }
}
