//! Compiles the message definitions in `proto/` to Rust types, and to the descriptors that each recording contains so
//! that any program can read it.

use std::env;
use std::error::Error;
use std::fs;
use std::path::PathBuf;

use prost::Message;
use prost_build::Config;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=proto");
    let out = PathBuf::from(env::var("OUT_DIR")?);
    for (name, files) in [
        ("regatta", &["regatta.proto"][..]),
        ("foxglove", &["foxglove/PointCloud.proto", "foxglove/PosesInFrame.proto", "foxglove/SceneUpdate.proto"]),
    ] {
        let mut descriptors = protox::compile(files, ["proto"])?;
        Config::new().compile_fds(descriptors.clone())?;
        // Recordings don't need comments and line numbers.
        descriptors.file.iter_mut().for_each(|file| file.source_code_info = None);
        fs::write(out.join(format!("{name}.descriptors")), descriptors.encode_to_vec())?;
    }
    Ok(())
}
