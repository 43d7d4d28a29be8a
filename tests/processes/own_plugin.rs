//! The out-of-tree plugin that the README tells people to write: built as they would, run on the engine.

use std::process::Command;

use crate::fleet::{Fleet, Process, root};

#[test]
fn the_example_plugin_builds_by_itself_and_reads_the_fleet() {
    let example = root().join("examples/own-plugin");
    let target = root().join("target/own-plugin");
    let build = Command::new(env!("CARGO"))
        .args(["build", "--offline", "--manifest-path"])
        .arg(example.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(&target)
        .output()
        .expect("cargo starts");
    assert!(build.status.success(), "{}", String::from_utf8_lossy(&build.stderr));

    let fleet = Fleet::start("own-plugin", "thirty.yaml", &[]);
    let program = target.join("debug").join(format!("own-plugin{}", std::env::consts::EXE_SUFFIX));
    let plugin = Process::start(Command::new(program).args(["--fleet", &fleet.name.to_string()]));
    fleet.let_ticks_pass(100);
    let output = plugin.interrupt();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.lines().count() > 0, "it printed nothing");
}
