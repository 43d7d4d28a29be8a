//! Every shader is sound, as far as can be told without an adapter.

use std::fs;
use std::path::Path;

use naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn every_shader_is_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu/shaders");
    let view = fs::read_to_string(folder.join("view.wgsl")).expect("view.wgsl");
    let mut checked = 0;
    for entry in fs::read_dir(&folder).expect("the folder").map(|entry| entry.expect("an entry")) {
        let name = entry.file_name();
        let text = fs::read_to_string(entry.path()).expect("readable");
        let source = if name == "view.wgsl" { text } else { format!("{view}{text}") };
        let module = naga::front::wgsl::parse_str(&source)
            .unwrap_or_else(|error| panic!("{}: {}", name.display(), error.emit_to_string(&source)));
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::SHADER_FLOAT16_IN_FLOAT32);
        if let Err(error) = validator.validate(&module) {
            panic!("{}: {}", name.display(), error.emit_to_string(&source));
        }
        checked += 1;
    }
    assert!(checked >= 4, "{checked} shaders in {}", folder.display());
}
