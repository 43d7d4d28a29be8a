//! Robot meshes from STL, OBJ and glTF files. STL and OBJ files are read with x forward and z up;
//! glTF defines its axes.

mod gltf;

use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::{Quat, Vec3};
use regatta_gpu::mesh::{Mesh, Vertex};
use regatta_interface::settings::MeshPlacement;

use crate::files;

/// The maximum number of triangles of a mesh, which may be drawn thousands of times.
const MAX_TRIANGLES: usize = 500_000;
/// The farthest that a vertex may be from the origin, in metres.
const MAX_EXTENT: f32 = 1e4;
/// The paint of files without colours: the robot's colour.
const PLAIN: [u8; 4] = [0, 0, 0, 255];
/// The share of the robot's colour, of 255, in black parts of a mesh.
const DARKEST: f32 = 140.0;

/// The error of loading a mesh file.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// The format is not supported.
    #[error(
        "{}: unsupported mesh format; use a file that ends in .stl, .obj, .gltf or .glb",
        .0.display()
    )]
    UnknownFormat(PathBuf),
    /// The file can't be read, or is malformed.
    #[error("{}: {reason}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// The mesh has no or too many triangles.
    #[error("{}: {triangles} triangles; a mesh may have from 1 to {MAX_TRIANGLES}", path.display())]
    Triangles {
        /// The file.
        path: PathBuf,
        /// The number of triangles.
        triangles: usize,
    },
}

/// A corner of a triangle.
#[derive(Clone, Copy)]
struct Corner {
    at: Vec3,
    /// Zero if the file has no normals.
    normal: Vec3,
    paint: [u8; 4],
}

/// Reads a mesh, scales it, turns it and lifts it.
///
/// # Errors
/// [`MeshFileError`].
pub fn load(path: &Path, placement: MeshPlacement) -> Result<Mesh, MeshFileError> {
    let extension = path
        .extension()
        .and_then(|extension| extension.to_str())
        .unwrap_or_default()
        .to_lowercase();
    let malformed = |reason: String| MeshFileError::Malformed { path: path.to_owned(), reason };
    let corners = match extension.as_str() {
        "stl" => stl(path).map_err(malformed)?,
        "obj" => obj(path).map_err(malformed)?,
        "gltf" | "glb" => gltf::read(path).map_err(malformed)?,
        _ => return Err(MeshFileError::UnknownFormat(path.to_owned())),
    };
    let triangles = corners.len() / 3;
    if triangles == 0 || triangles > MAX_TRIANGLES {
        return Err(MeshFileError::Triangles { path: path.to_owned(), triangles });
    }
    if corners.iter().any(|corner| !corner.at.is_finite()) {
        return Err(malformed("a vertex position is not a number".to_owned()));
    }
    if corners.iter().any(|corner| (corner.at * placement.scale).abs().max_element() > MAX_EXTENT) {
        let reason =
            format!("a vertex is farther than {MAX_EXTENT} m from the origin; use a smaller scale");
        return Err(malformed(reason));
    }
    Ok(build(&corners, placement))
}

fn build(corners: &[Corner], MeshPlacement { scale, z, yaw }: MeshPlacement) -> Mesh {
    let (mut mesh, turn) = (Mesh::default(), Quat::from_rotation_z(yaw));
    for triangle in corners.chunks_exact(3) {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        let flat = (b.at - a.at).cross(c.at - a.at).normalize_or(Vec3::Z);
        for corner in [a, b, c] {
            let normal = corner.normal.try_normalize().unwrap_or(flat);
            mesh.indices.push(mesh.vertices.len() as u32);
            mesh.vertices.push(Vertex::new(
                turn * corner.at * scale + Vec3::Z * z,
                turn * normal,
                corner.paint,
            ));
        }
    }
    mesh
}

fn stl(path: &Path) -> Result<Vec<Corner>, String> {
    let mut file = BufReader::new(files::open(path)?);
    let mesh = stl_io::read_stl(&mut file).map_err(|error| error.to_string())?;
    let mut corners = Vec::new();
    for index in mesh.faces.iter().flat_map(|face| &face.vertices) {
        let at = mesh.vertices.get(*index).ok_or("a triangle refers to a missing vertex")?;
        let at = Vec3::new(at[0], at[1], at[2]);
        corners.push(Corner { at, normal: Vec3::ZERO, paint: PLAIN });
    }
    Ok(corners)
}

fn obj(path: &Path) -> Result<Vec<Corner>, String> {
    let options =
        tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    let mut file = BufReader::new(files::open(path)?);
    let folder = path.parent().unwrap_or(Path::new(""));
    let loaded = tobj::load_obj_buf(&mut file, &options, |name| obj_materials(&folder.join(name)));
    let (models, materials) = loaded.map_err(|error| error.to_string())?;
    // The material file may be missing; the mesh is usable without it.
    let materials = materials.unwrap_or_default();
    let mut corners = Vec::new();
    for mesh in models.into_iter().map(|model| model.mesh) {
        let colour = mesh.material_id.and_then(|id| materials.get(id)?.diffuse);
        let paint = colour.map_or(PLAIN, paint_of);
        for index in &mesh.indices {
            let at =
                triple(&mesh.positions, *index).ok_or("a triangle refers to a missing vertex")?;
            corners.push(Corner {
                at,
                normal: triple(&mesh.normals, *index).unwrap_or(Vec3::ZERO),
                paint,
            });
        }
    }
    Ok(corners)
}

/// Returns the vector at an index of a list of coordinates, three for each vector.
fn triple(coordinates: &[f32], index: u32) -> Option<Vec3> {
    let three = coordinates.get(index as usize * 3..index as usize * 3 + 3)?;
    Some(Vec3::new(three[0], three[1], three[2]))
}

/// Reads the materials of an OBJ file, except for colours of fewer than three parts, at which the
/// crate `tobj` panics.
fn obj_materials(path: &Path) -> tobj::MTLLoadResult {
    let text = files::read_text(path).map_err(|_| tobj::LoadError::OpenFileFailed)?;
    let is_whole =
        |line: &&str| !line.trim_start().starts_with('K') || line.split_whitespace().count() > 3;
    let lines: Vec<_> = text.lines().filter(is_whole).collect();
    tobj::load_mtl_buf(&mut lines.join("\n").as_bytes())
}

/// Returns the paint of a material. The robot's colour shows its state, so a mesh adds no other hue
/// to it. Only the lightness of the material is kept, as a shade of the robot's colour.
fn paint_of(colour: [f32; 3]) -> [u8; 4] {
    let [red, green, blue] =
        colour.map(|part| if part.is_finite() { part.clamp(0.0, 1.0) } else { 1.0 });
    let lightness = (0.2126 * red + 0.7152 * green + 0.0722 * blue).sqrt();
    [0, 0, 0, (DARKEST + (255.0 - DARKEST) * lightness).round() as u8]
}

#[cfg(test)]
mod tests;
