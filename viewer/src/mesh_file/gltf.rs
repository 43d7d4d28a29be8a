//! glTF files. Whatever is used is checked first, because the crate `gltf` panics where an index, a
//! type or a size is wrong.

use std::collections::HashSet;
use std::path::Path;

use glam::{Mat4, Vec3};
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Data, Source, View};
use gltf::{Document, Gltf, Primitive, Semantic};

use super::{Corner, MAX_TRIANGLES, paint_of};
use crate::files;

/// The bytes of a binary file's header.
const GLB_HEADER: u32 = 12;

/// Reads the triangles of a file's scene.
pub(super) fn read(path: &Path) -> Result<Vec<Corner>, String> {
    let bytes = files::read(path)?;
    check_length(&bytes)?;
    let Gltf { document, mut blob } =
        Gltf::from_slice_without_validation(&bytes).map_err(|error| error.to_string())?;
    let document = validate(document)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let buffers = document.buffers().map(|buffer| read_buffer(&buffer, folder, &mut blob));
    let buffers = buffers.collect::<Result<Vec<_>, String>>()?;
    let scene = document
        .default_scene()
        .or_else(|| document.scenes().next())
        .ok_or("the file has no scene")?;
    // In glTF, z is forward, y up and x left.
    let from_gltf =
        Mat4::from_cols_array(&[0., 1., 0., 0., 0., 0., 1., 0., 1., 0., 0., 0., 0., 0., 0., 1.]);
    let mut corners = Vec::new();
    let mut open: Vec<_> = scene.nodes().map(|node| (node, from_gltf)).collect();
    let mut seen = HashSet::new();
    while let Some((node, parent)) = open.pop() {
        if !seen.insert(node.index()) {
            return Err("the nodes are not a tree: a node has two parents, or is its own ancestor"
                .to_owned());
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

/// Refuses a binary file that states a length of less than its header.
fn check_length(bytes: &[u8]) -> Result<(), String> {
    let length = bytes.get(8..12).and_then(|length| length.try_into().ok()).map(u32::from_le_bytes);
    if bytes.starts_with(b"glTF") && length.is_some_and(|length| length < GLB_HEADER) {
        return Err("the binary header is invalid".to_owned());
    }
    Ok(())
}

/// Checks that all indices exist and all values are known.
fn validate(document: Document) -> Result<Document, String> {
    let json = document.into_json();
    // The crate's own check of a primitive assumes this.
    let mut named = json
        .meshes
        .iter()
        .flat_map(|mesh| &mesh.primitives)
        .flat_map(|part| part.attributes.values());
    if let Some(missing) = named.find(|accessor| accessor.value() >= json.accessors.len()) {
        return Err(format!("a primitive names accessor {}, which doesn't exist", missing.value()));
    }
    Document::from_json(json).map_err(|error| match error {
        gltf::Error::Validation(errors) => {
            let first = errors.first().map(|(path, error)| format!("{path}: {error}"));
            first.unwrap_or_default().to_lowercase()
        }
        other => other.to_string(),
    })
}

fn read_buffer(
    buffer: &gltf::Buffer<'_>,
    folder: &Path,
    blob: &mut Option<Vec<u8>>,
) -> Result<Vec<u8>, String> {
    let data = match buffer.source() {
        Source::Bin => blob.take().ok_or("the file has no binary part")?,
        Source::Uri(uri) if uri.starts_with("data:") => {
            Data::from_source(buffer.source(), None)
                .map_err(|error| format!("invalid data in a buffer ({error})"))?
                .0
        }
        Source::Uri(uri) => {
            let file =
                uri.strip_prefix("file://").or_else(|| uri.strip_prefix("file:")).unwrap_or(uri);
            let path = folder.join(decode(file)?);
            files::read(&path).map_err(|reason| format!("buffer {}: {reason}", path.display()))?
        }
    };
    if data.len() < buffer.length() {
        return Err(format!(
            "buffer {} has {} bytes of {}",
            buffer.index(),
            data.len(),
            buffer.length()
        ));
    }
    Ok(data)
}

/// Replaces `%20` and the like by the bytes that they stand for.
fn decode(uri: &str) -> Result<String, String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        match part.get(..2).and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                bytes.extend_from_slice(&part.as_bytes()[2..]);
            }
            None => bytes.extend_from_slice(format!("%{part}").as_bytes()),
        }
    }
    String::from_utf8(bytes).map_err(|_| format!("invalid address {uri:?} of a buffer"))
}

fn add_primitive(
    corners: &mut Vec<Corner>,
    primitive: &Primitive<'_>,
    buffers: &[Vec<u8>],
    transform: Mat4,
) -> Result<(), String> {
    let vectors = [Semantic::Positions, Semantic::Normals].map(|semantic| primitive.get(&semantic));
    for accessor in vectors.into_iter().flatten() {
        check_accessor(&accessor, Dimensions::Vec3, &[DataType::F32])?;
    }
    if let Some(accessor) = primitive.indices() {
        check_accessor(
            &accessor,
            Dimensions::Scalar,
            &[DataType::U8, DataType::U16, DataType::U32],
        )?;
    }
    let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(|data| &data[..]));
    let positions: Vec<_> =
        reader.read_positions().ok_or("a primitive has no positions")?.collect();
    let normals: Vec<_> = reader.read_normals().map(Iterator::collect).unwrap_or_default();
    let [red, green, blue, _] = primitive.material().pbr_metallic_roughness().base_color_factor();
    let paint = paint_of([red, green, blue]);
    let normal_transform = transform.inverse().transpose();
    let indices: Vec<u32> = match reader.read_indices() {
        Some(indices) => indices.into_u32().collect(),
        None => (0..positions.len() as u32).collect(),
    };
    for index in indices {
        let at = positions.get(index as usize).ok_or("a triangle refers to a missing vertex")?;
        let normal = normals.get(index as usize).map_or(Vec3::ZERO, |normal| Vec3::from(*normal));
        let normal = normal_transform.transform_vector3(normal);
        corners.push(Corner { at: transform.transform_point3(Vec3::from(*at)), normal, paint });
    }
    Ok(())
}

/// Checks that an accessor has the expected type, and that all of its elements are within its
/// buffers.
fn check_accessor(
    accessor: &Accessor<'_>,
    dimensions: Dimensions,
    types: &[DataType],
) -> Result<(), String> {
    let (index, count, size) = (accessor.index(), accessor.count(), accessor.size());
    if accessor.dimensions() != dimensions || !types.contains(&accessor.data_type()) {
        return Err(format!("accessor {index} has a type that is not supported there"));
    }
    let base = accessor.view().is_none_or(|view| fits(&view, accessor.offset(), count, size));
    let sparse = accessor.sparse().is_none_or(|sparse| {
        let (indices, values) = (sparse.indices(), sparse.values());
        fits(&indices.view(), indices.offset(), sparse.count(), indices.index_type().size())
            && fits(&values.view(), values.offset(), sparse.count(), size)
    });
    if !base || !sparse || count > 3 * MAX_TRIANGLES {
        return Err(format!("accessor {index} has too many elements, or none"));
    }
    Ok(())
}

/// Whether a view has room for `count` elements of `size` bytes, and its buffer for the view.
fn fits(view: &View<'_>, offset: usize, count: usize, size: usize) -> bool {
    let stride = view.stride().unwrap_or(size);
    let before_last = count.checked_sub(1).and_then(|count| count.checked_mul(stride));
    let end = before_last.and_then(|bytes| bytes.checked_add(size)?.checked_add(offset));
    let end_of_view = view.offset().checked_add(view.length());
    stride >= size
        && end.is_some_and(|end| end <= view.length())
        && end_of_view.is_some_and(|end| end <= view.buffer().length())
}
