//! Compiles `proto/` to the Rust types of messages, and to the descriptors that recordings
//! contain and live views announce, so that any program can read them.

use std::error::Error;
use std::path::PathBuf;
use std::{env, fs};

use prost::Message;
use prost_build::Config;

/// The packages, and the files that define them.
const PACKAGES: [(&str, &[&str]); 2] = [
    ("regatta", &["regatta.proto"]),
    (
        "foxglove",
        &[
            "foxglove/Log.proto",
            "foxglove/PointCloud.proto",
            "foxglove/PosesInFrame.proto",
            "foxglove/SceneUpdate.proto",
        ],
    ),
];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=proto");
    let out = PathBuf::from(env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR")?);
    for (name, files) in PACKAGES {
        let mut descriptors = protox::compile(files, ["proto"])?;
        Config::new().out_dir(&out).compile_fds(descriptors.clone())?;
        // Readers don't need comments and line numbers.
        for file in &mut descriptors.file {
            file.source_code_info = None;
        }
        fs::write(out.join(format!("{name}.descriptors")), descriptors.encode_to_vec())?;
    }
    Ok(())
}
