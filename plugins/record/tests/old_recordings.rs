//! Recordings of older versions are read.

use std::fs;
use std::path::Path;

use clap::Parser;
use regatta_plugin::order::OrderKind;
use regatta_record::{ExportArgs, Published, export, info, play};
use tempfile::TempDir;

/// A recording of version 10 of the contract, which called commands orders, and transport orders
/// tasks. A robot drives on `graphs/square.yaml` under the fleet manager; it is held and resumed,
/// and the hold of a robot 99 is refused.
const VERSION_10: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/version-10.mcap");

#[derive(Parser)]
struct Cli {
    #[command(flatten)]
    args: ExportArgs,
}

#[test]
fn topics_of_version_10_have_the_names_of_today() {
    let info = info(Path::new(VERSION_10)).expect("a recording");
    assert_eq!(info.contract.as_deref(), Some("10"));
    let messages = |name: &str| {
        info.topics.iter().find(|topic| topic.name == name).map_or(0, |topic| topic.messages)
    };
    assert_eq!(["/commands", "/orders", "/tasks"].map(messages), [22, 8, 0]);
}

#[test]
fn commands_and_orders_of_version_10_are_exported() {
    let folder = TempDir::new().expect("a folder");
    let out = folder.path().to_str().expect("a path");
    let arguments = ["export", VERSION_10, "--topics", "commands,orders", "-o", out];
    export(&Cli::parse_from(arguments).args).expect("exported");
    let rows = |table: &str| {
        let text = fs::read_to_string(folder.path().join(table)).expect("a table");
        text.lines().map(str::to_owned).collect::<Vec<_>>()
    };
    let commands = rows("commands.csv");
    assert_eq!(commands.len(), 33);
    assert!(commands[8].starts_with("2.95,0,59,0,hold,"), "{}", commands[8]);
    assert!(commands[9].starts_with("3,0,60,99,hold,"), "{}", commands[9]);
    let orders = rows("orders.csv");
    assert_eq!(orders[0], "time_s,run,tick,order,kind,robot,stop,node,action,dwell_s,detail");
    assert_eq!(orders[1], "0.5,0,10,1,created,,0,0,none,0,2");
    assert_eq!(orders.len(), 31);
}

#[test]
fn orders_of_version_10_are_played() {
    let mut kinds = Vec::new();
    play(Path::new(VERSION_10), |published| {
        if let Published::Orders(_, _, records) = published {
            kinds.extend(
                records.iter().filter(|record| record.order == 1).map(|record| record.kind()),
            );
        }
    })
    .expect("played");
    let expected = [
        OrderKind::Created,
        OrderKind::Stop,
        OrderKind::Stop,
        OrderKind::Assigned,
        OrderKind::Arrived,
        OrderKind::Handled,
    ];
    assert_eq!(kinds, expected.map(Some));
}
