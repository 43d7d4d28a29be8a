//! `src/generated` is what `proto/` compiles to: Rust types, and the descriptors that each recording contains so that any
//! program can read it. It is committed, so that a build needs no compiler of protocol buffers. After a change of
//! `proto/`, write it anew:
//!
//! ```console
//! $ REGATTA_WRITE_GENERATED=1 cargo test -p regatta-record --test generated
//! ```

use std::error::Error;
use std::fs;
use std::path::Path;

use prost::Message;
use prost_build::Config;
use tempfile::TempDir;

/// The packages, and the files that they are in.
const PACKAGES: [(&str, &[&str]); 2] = [
    ("regatta", &["regatta.proto"]),
    (
        "foxglove",
        &["foxglove/PointCloud.proto", "foxglove/PosesInFrame.proto", "foxglove/SceneUpdate.proto"],
    ),
];

fn generate(proto: &Path, out: &Path) -> Result<(), Box<dyn Error>> {
    for (name, files) in PACKAGES {
        let mut descriptors = protox::compile(files, [proto])?;
        Config::new().out_dir(out).compile_fds(descriptors.clone())?;
        // Recordings don't need comments and line numbers.
        descriptors.file.iter_mut().for_each(|file| file.source_code_info = None);
        fs::write(out.join(format!("{name}.descriptors")), descriptors.encode_to_vec())?;
    }
    Ok(())
}

#[test]
fn the_generated_files_are_current() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (proto, committed) = (package.join("proto"), package.join("src/generated"));
    if std::env::var_os("REGATTA_WRITE_GENERATED").is_some() {
        generate(&proto, &committed).expect("generated");
    }
    let out = TempDir::new().expect("a folder");
    generate(&proto, out.path()).expect("generated");
    let mut names: Vec<_> = fs::read_dir(out.path())
        .expect("listed")
        .map(|entry| entry.expect("listed").file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["foxglove.descriptors", "foxglove.rs", "regatta.descriptors", "regatta.rs"]);
    for name in names {
        let [expected, found] =
            [out.path(), &committed].map(|folder| fs::read(folder.join(&name)).expect("readable"));
        assert!(
            expected == found,
            "{} is not what proto/ compiles to: see the top of this file",
            name.display()
        );
    }
}
