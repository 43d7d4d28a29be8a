use super::*;

fn load_text(name: &str, text: &str) -> Result<Mesh, MeshFileError> {
    load_bytes(name, text.as_bytes())
}

fn load_bytes(name: &str, bytes: &[u8]) -> Result<Mesh, MeshFileError> {
    let path = std::env::temp_dir().join(format!("regatta-model-{}-{name}", std::process::id()));
    std::fs::write(&path, bytes).expect("written");
    let mesh = load(&path, MeshPlacement { scale: 2.0, z: 0.5, yaw: 0.0 });
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

/// A glTF file that uses everything that is read: an indexed triangle with normals, a colour and a
/// sparse position.
const RICH: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"children":[1]},{"mesh":0,"translation":[0,0,1]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1},"indices":2,"material":0,"mode":4}]}],
    "materials":[{"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1]}}],
    "accessors":[
        {"bufferView":0,"byteOffset":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,0,1],
         "sparse":{"count":1,"indices":{"bufferView":3,"byteOffset":0,"componentType":5121},"values":{"bufferView":4,"byteOffset":0}}},
        {"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"},
        {"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}],
    "bufferViews":[
        {"buffer":0,"byteOffset":0,"byteLength":36,"byteStride":12},
        {"buffer":0,"byteOffset":36,"byteLength":36,"byteStride":12},
        {"buffer":0,"byteOffset":72,"byteLength":6},
        {"buffer":0,"byteOffset":80,"byteLength":1},
        {"buffer":0,"byteOffset":84,"byteLength":12}],
    "buffers":[{"byteLength":96,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAIA/AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAABAAIAAAABAAAAAAAAAAAAAAAAAABA"}]}"#;

/// Returns copies of a text, in each of which one of its whole numbers is replaced.
fn with_another_number<'a>(text: &'a str, number: &'a str) -> impl Iterator<Item = String> + 'a {
    let is_digit = |i: usize| text.as_bytes().get(i).is_some_and(u8::is_ascii_digit);
    // Numbers follow a colon, a comma or a bracket; those of the data and of versions don't.
    let starts =
        (1..text.len()).filter(move |i| is_digit(*i) && b":,[".contains(&text.as_bytes()[*i - 1]));
    starts.map(move |start| {
        let end = (start..).find(|i| !is_digit(*i)).unwrap_or(text.len());
        [&text[..start], number, &text[end..]].concat()
    })
}

#[test]
fn a_gltf_file_with_any_wrong_number_is_read_or_refused() {
    let mesh = load_text("rich.gltf", RICH).unwrap_or_else(|error| panic!("{error}"));
    let corners: Vec<_> = mesh.vertices.iter().map(|vertex| vertex.position).collect();
    assert_eq!(corners, [[2.0, 0.0, 0.5], [6.0, 0.0, 0.5], [2.0, 2.0, 0.5]]);
    assert_eq!(mesh.vertices[0].paint, paint_of([1.0, 0.0, 0.0]));
    let mut refused = 0;
    for number in [
        "0",
        "1",
        "2",
        "3",
        "7",
        "35",
        "5121",
        "5125",
        "5126",
        "4294967295",
        "18446744073709551615",
        "-1",
    ] {
        for (index, text) in with_another_number(RICH, number).enumerate() {
            match load_text("wrong.gltf", &text) {
                Ok(mesh) => assert!(mesh.vertices.len() <= 300, "{index}: {number}"),
                Err(error) => {
                    refused += 1;
                    let error = error.to_string();
                    assert!(
                        error.contains("wrong.gltf") && !error.contains('\n'),
                        "{index}: {number}: {error}"
                    );
                }
            }
        }
    }
    assert!(refused > 150, "{refused}");
}

#[test]
fn a_gltf_file_that_lacks_a_part_is_refused() {
    let missing = RICH.replace("\"POSITION\":0", "\"POSITION\":9");
    let error = load_text("missing.gltf", &missing)
        .map(|_| ())
        .expect_err("it names a missing accessor")
        .to_string();
    assert!(error.contains("accessor 9") && !error.contains('\n'), "{error}");
    for uri in [
        "%ff.bin",
        "no-such-file.bin",
        "http://a/b.bin",
        "data:;base64,!!",
        "data:;base64,AAAA",
        "",
    ] {
        let start = RICH.find("data:").expect("an address");
        let end = start + RICH[start..].find('"').expect("its end");
        let text = [&RICH[..start], uri, &RICH[end..]].concat();
        let error = load_text("lacks.gltf", &text).map(|_| ()).expect_err(uri).to_string();
        assert!(error.contains("lacks.gltf") && !error.contains('\n'), "{uri}: {error}");
    }
}

#[test]
fn a_binary_gltf_file_cut_anywhere_is_refused() {
    let json = br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":
        [{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
        "min":[0,0,0],"max":[1,0,1]}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}]}   "#;
    let json = &json[..json.len() / 4 * 4];
    let positions =
        [0.0_f32, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0].map(f32::to_le_bytes).concat();
    let chunk =
        |kind: &[u8], data: &[u8]| [&(data.len() as u32).to_le_bytes(), kind, data].concat();
    let chunks = [chunk(b"JSON", json), chunk(b"BIN\0", &positions)].concat();
    let header = |length: u32| [&b"glTF"[..], &2_u32.to_le_bytes(), &length.to_le_bytes()].concat();
    let whole = [header(12 + chunks.len() as u32), chunks.clone()].concat();
    assert_eq!(
        load_bytes("whole.glb", &whole).map(|mesh| mesh.vertices.len()).map_err(|e| e.to_string()),
        Ok(3)
    );
    for length in 0..whole.len() {
        load_bytes("cut.glb", &whole[..length]).map(|_| ()).expect_err("it is cut");
    }
    for length in [0, 11, u32::MAX] {
        load_bytes("length.glb", &[header(length), chunks.clone()].concat())
            .map(|_| ())
            .expect_err("a wrong length");
    }
}

#[test]
fn materials_of_an_obj_file_colour_it_unless_they_are_broken() {
    let folder = std::env::temp_dir().join(format!("regatta-materials-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("made");
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    std::fs::write(folder.join("a.obj"), obj).expect("written");
    let red = paint_of([1.0, 0.0, 0.0]);
    for (materials, paint) in [
        ("newmtl a\nKd 1 0 0\n", red),
        ("newmtl a\nKa 1\n  Ks 1 1\nKd 1 0 0\n", red),
        ("newmtl a\nKd 0.5\n", PLAIN),
        ("newmtl a\nKd\n", PLAIN),
        ("Kd a b c\n", PLAIN),
    ] {
        std::fs::write(folder.join("a.mtl"), materials).expect("written");
        let mesh = load(&folder.join("a.obj"), MeshPlacement { scale: 1.0, z: 0.0, yaw: 0.0 })
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(mesh.vertices[0].paint, paint, "{materials}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn a_mesh_only_shades_the_robots_colour() {
    for colour in [[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0; 3], [f32::NAN, 9.0, -1.0]] {
        let [hue @ .., share] = paint_of(colour);
        assert!(hue == [0; 3] && share >= 140, "{colour:?}: {share}");
    }
    assert_eq!(paint_of([1.0; 3]), PLAIN);
    assert!(paint_of([0.2; 3])[3] < paint_of([0.6; 3])[3], "dark parts stay darker");
}

#[test]
fn a_mesh_is_turned_about_the_vertical_axis() {
    let corner = Corner { at: Vec3::new(1.0, 0.0, 0.5), normal: Vec3::X, paint: PLAIN };
    let mesh = build(
        &[corner; 3],
        MeshPlacement { scale: 2.0, z: 0.25, yaw: core::f32::consts::FRAC_PI_2 },
    );
    let [x, y, z] = mesh.vertices[0].position;
    assert!(x.abs() < 1e-6 && (y - 2.0).abs() < 1e-6 && (z - 1.25).abs() < 1e-6, "{x} {y} {z}");
    assert_eq!(mesh.vertices[0].normal, [0, 127, 0, 0]);
}

/// Returns copies of a file in each of which some bytes are replaced, removed or repeated, always
/// the same ones.
fn damaged(bytes: &[u8], copies: u64) -> impl Iterator<Item = Vec<u8>> + '_ {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move |below: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below.max(1)
    };
    (0..copies).map(move |_| {
        let mut copy = bytes.to_vec();
        for _ in 0..=random(3) {
            let (at, length) = (random(copy.len()), random(9));
            let end = (at + length).min(copy.len());
            match random(3) {
                0 => copy[at] = random(256) as u8,
                1 => drop(copy.drain(at..end)),
                _ => {
                    let part = copy[at..end].to_vec();
                    copy.splice(at..at, part);
                }
            }
            if copy.is_empty() {
                copy.push(0);
            }
        }
        copy
    })
}

#[test]
fn damaged_files_of_each_format_are_read_or_refused() {
    let facet = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]
        .map(f32::to_le_bytes)
        .concat();
    let stl = [&[b' '; 80][..], &2_u32.to_le_bytes(), &facet, &[0; 2], &facet, &[0; 2]].concat();
    let obj =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf -3//1 -2//1 -1//1\n";
    let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let files = [
        ("d.gltf", RICH.as_bytes(), 3000),
        ("d.stl", &stl[..], 1000),
        ("e.stl", text.as_bytes(), 1000),
        ("d.obj", obj.as_bytes(), 1000),
    ];
    for (name, bytes, copies) in files {
        let refused = damaged(bytes, copies).filter(|copy| match load_bytes(name, copy) {
            Ok(mesh) => mesh.vertices.len() > 3 * MAX_TRIANGLES,
            Err(error) => !error.to_string().contains('\n'),
        });
        assert!(refused.count() > copies as usize / 10, "{name}");
    }
}
