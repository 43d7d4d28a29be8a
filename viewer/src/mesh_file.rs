//! Robot meshes from STL, OBJ and glTF files. STL and OBJ files are read with x forward and z up; glTF defines its axes.

use std::collections::HashSet;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::{Mat4, Vec3};

use crate::files;
use crate::mesh::{Mesh, Vertex};

/// The most triangles of a mesh, which may be drawn thousands of times.
const MAX_TRIANGLES: usize = 500_000;
/// The farthest that a vertex may be from the origin, in metres.
const MAX_EXTENT: f32 = 1e4;
/// The paint of files without colours: a light shell with a large share of the robot's colour.
const PLAIN: [u8; 4] = [150, 156, 162, 170];
/// The share of the robot's colour in a coloured mesh, of 255.
const TINT: u8 = 90;

/// The error of loading a mesh file.
#[derive(Debug, thiserror::Error)]
pub enum MeshFileError {
    /// The format is not supported.
    #[error("{}: unsupported mesh format; use a file that ends in .stl, .obj, .gltf or .glb", .0.display())]
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

/// Reads a mesh, scales it, and lifts it by `z` metres.
///
/// # Errors
/// [`MeshFileError`].
pub fn load(path: &Path, scale: f32, z: f32) -> Result<Mesh, MeshFileError> {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default().to_lowercase();
    let malformed = |reason: String| MeshFileError::Malformed { path: path.to_owned(), reason };
    files::check_regular(path).map_err(malformed)?;
    let corners = match extension.as_str() {
        "stl" => stl(path).map_err(malformed)?,
        "obj" => obj(path).map_err(malformed)?,
        "gltf" | "glb" => gltf(path).map_err(malformed)?,
        _ => return Err(MeshFileError::UnknownFormat(path.to_owned())),
    };
    let triangles = corners.len() / 3;
    if triangles == 0 || triangles > MAX_TRIANGLES {
        return Err(MeshFileError::Triangles { path: path.to_owned(), triangles });
    }
    if corners.iter().any(|corner| !corner.at.is_finite()) {
        return Err(malformed("a vertex position is not a number".to_owned()));
    }
    if corners.iter().any(|corner| (corner.at * scale).abs().max_element() > MAX_EXTENT) {
        let reason = format!("a vertex is farther than {MAX_EXTENT} m from the origin; use a smaller scale");
        return Err(malformed(reason));
    }
    Ok(build(&corners, scale, z))
}

fn build(corners: &[Corner], scale: f32, z: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for triangle in corners.chunks_exact(3) {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        let flat = (b.at - a.at).cross(c.at - a.at).normalize_or(Vec3::Z);
        for corner in [a, b, c] {
            let normal = corner.normal.try_normalize().unwrap_or(flat);
            mesh.indices.push(mesh.vertices.len() as u32);
            mesh.vertices.push(Vertex::new(corner.at * scale + Vec3::Z * z, normal, corner.paint));
        }
    }
    mesh
}

fn stl(path: &Path) -> Result<Vec<Corner>, String> {
    let mut file = BufReader::new(File::open(path).map_err(|error| error.to_string())?);
    let mesh = stl_io::read_stl(&mut file).map_err(|error| error.to_string())?;
    let corner = |index: &usize| {
        let at = mesh.vertices.get(*index)?;
        Some(Corner { at: Vec3::new(at[0], at[1], at[2]), normal: Vec3::ZERO, paint: PLAIN })
    };
    let corners = mesh.faces.iter().flat_map(|face| &face.vertices).map(corner).collect::<Option<_>>();
    corners.ok_or_else(|| "a triangle refers to a missing vertex".to_owned())
}

fn obj(path: &Path) -> Result<Vec<Corner>, String> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    let (models, materials) = tobj::load_obj(path, &options).map_err(|error| error.to_string())?;
    // The material file may be missing; the mesh is usable without it.
    let materials = materials.unwrap_or_default();
    let mut corners = Vec::new();
    for mesh in models.into_iter().map(|model| model.mesh) {
        let colour = mesh.material_id.and_then(|id| materials.get(id)?.diffuse);
        let paint = colour.map_or(PLAIN, paint_of);
        let triple = |values: &[f32], index: u32| {
            values.get(index as usize * 3..index as usize * 3 + 3).map(|three| Vec3::new(three[0], three[1], three[2]))
        };
        for index in &mesh.indices {
            let at = triple(&mesh.positions, *index).ok_or("a triangle refers to a missing vertex")?;
            corners.push(Corner { at, normal: triple(&mesh.normals, *index).unwrap_or(Vec3::ZERO), paint });
        }
    }
    Ok(corners)
}

fn gltf(path: &Path) -> Result<Vec<Corner>, String> {
    let (document, buffers, _) = gltf::import(path).map_err(|error| error.to_string())?;
    let scene = document.default_scene().or_else(|| document.scenes().next()).ok_or("the file has no scene")?;
    // In glTF, z is forward, y up and x left.
    let from_gltf = Mat4::from_cols_array(&[0., 1., 0., 0., 0., 0., 1., 0., 1., 0., 0., 0., 0., 0., 0., 1.]);
    let mut corners = Vec::new();
    let mut open: Vec<_> = scene.nodes().map(|node| (node, from_gltf)).collect();
    let mut seen = HashSet::new();
    while let Some((node, parent)) = open.pop() {
        if !seen.insert(node.index()) {
            return Err("the nodes are not a tree: a node has two parents, or is its own ancestor".to_owned());
        }
        let transform = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            if primitive.mode() == gltf::mesh::Mode::Triangles {
                add_primitive(&mut corners, &primitive, &buffers, transform)?;
            }
        }
        open.extend(node.children().map(|child| (child, transform)));
    }
    Ok(corners)
}

fn add_primitive(
    corners: &mut Vec<Corner>,
    primitive: &gltf::Primitive<'_>,
    buffers: &[gltf::buffer::Data],
    transform: Mat4,
) -> Result<(), String> {
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|data| &data.0[..]));
    let positions: Vec<_> = reader.read_positions().ok_or("a primitive has no positions")?.collect();
    let normals: Vec<_> = reader.read_normals().map(Iterator::collect).unwrap_or_default();
    let [red, green, blue, _] = primitive.material().pbr_metallic_roughness().base_color_factor();
    let paint = paint_of([red, green, blue]);
    let normal_transform = transform.inverse().transpose();
    let mut add = |index: u32| {
        let at = positions.get(index as usize).ok_or("a triangle refers to a missing vertex")?;
        let normal = normals.get(index as usize).map_or(Vec3::ZERO, |normal| Vec3::from(*normal));
        let normal = normal_transform.transform_vector3(normal);
        corners.push(Corner { at: transform.transform_point3(Vec3::from(*at)), normal, paint });
        Ok(())
    };
    match reader.read_indices() {
        Some(indices) => indices.into_u32().try_for_each(&mut add),
        None => (0..positions.len() as u32).try_for_each(&mut add),
    }
}

fn paint_of(colour: [f32; 3]) -> [u8; 4] {
    let [red, green, blue] = colour.map(|part| (part.clamp(0.0, 1.0) * 255.0) as u8);
    [red, green, blue, TINT]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load_text(name: &str, text: &str) -> Result<Mesh, MeshFileError> {
        let path = std::env::temp_dir().join(format!("regatta-model-{}-{name}", std::process::id()));
        std::fs::write(&path, text).expect("written");
        let mesh = load(&path, 2.0, 0.5);
        std::fs::remove_file(&path).expect("removed");
        mesh
    }

    #[test]
    fn a_triangle_of_each_format_is_read_scaled_and_lifted() {
        let stl = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
        let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        // The same triangle, in glTF's axes.
        let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,0,1]}],
            "bufferViews":[{"buffer":0,"byteLength":36}],
            "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAIA/AACAPwAAAAAAAAAA"}]}"#;
        for (name, text) in [("a.stl", stl), ("a.obj", obj), ("a.gltf", gltf)] {
            let mesh = load_text(name, text).unwrap_or_else(|error| panic!("{error}"));
            let corners: Vec<_> = mesh.vertices.iter().map(|vertex| vertex.position).collect();
            assert_eq!(corners, [[0.0, 0.0, 0.5], [2.0, 0.0, 0.5], [0.0, 2.0, 0.5]], "{name}");
            assert_eq!(mesh.vertices[0].normal, [0, 0, 127, 0], "{name}");
        }
    }

    /// A glTF file with two nodes, each the other's child.
    const CYCLE: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"children":[1]},{"children":[0]}]}"#;

    #[test]
    fn malformed_files_are_reported_without_a_panic() {
        let bad = [
            ("b.stl", "solid"),
            ("b.stl", ""),
            ("b.obj", "f 1 2 3\n"),
            ("b.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
            ("b.obj", "v 1e38 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
            ("b.gltf", "{}"),
            ("b.gltf", CYCLE),
            ("b.glb", "glTF"),
            ("b.fbx", "what"),
        ];
        for (name, text) in bad {
            let error = load_text(name, text).map(|_| ()).expect_err(name).to_string();
            assert!(error.contains("regatta-model") && !error.contains('\n'), "{name}: {error}");
        }
    }
}
