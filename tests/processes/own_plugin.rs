//! The out-of-tree plugin that the README tells people to write: built as they would, run on the
//! engine.

use std::process::Command;

use regatta_plugin::{ColumnReader, Commands, Participant};

use crate::fleet::{Fleet, Process, build_example, eventually};

#[test]
fn the_example_plugin_builds_by_itself_and_reads_the_fleet() {
    // Built before the fleet starts: its robots drive for a few seconds only, and the build takes a
    // minute or two.
    let program = build_example("own-plugin");
    let fleet = Fleet::start("own-plugin", "thirty.yaml", &[]);
    let plugin = Process::start(Command::new(program).args(["--fleet", &fleet.name.to_string()]));
    let participant = Participant::join(&fleet.name, "test").expect("joined");
    let mut column = ColumnReader::open_on(&participant, "standing").expect("opened");
    let mut commands = Commands::open_on(&participant).expect("opened");
    commands.hold(7);
    commands.send().expect("sent");
    eventually("robot 7 stands for a second, and others drive on", || {
        let standing = column.latest().expect("readable")?.values;
        (standing.len() == 30 && standing[7] > 1.0 && standing.contains(&0.0)).then_some(())
    });
    let output = plugin.interrupt();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(
        text.lines().any(|line| line.contains("robot ") && line.contains("has stood for")),
        "{text}"
    );
}
