//! Exported tables contain the recorded values bit for bit.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use mcap::records::MessageHeader;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use prost::Message;
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::contact::{ContactHeader, ContactRecord};
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, NO_EDGE, frame_lines, stride_lines};
use regatta_plugin::{ColumnValues, Frame};
use tempfile::TempDir;

use crate::contacts::{ContactEncoder, ContactList};
use crate::encode;
use crate::export::{ExportArgs, ExportError, export};
use crate::mcap_file::{Compression, McapFile};
use crate::plot::{PlotArgs, plot};
use crate::schema::{Topic, regatta};

const ROBOTS: usize = 4;
const TICKS: u64 = 6;

/// The x of a robot at a tick: values that need all digits.
fn x(tick: u64, robot: usize) -> f32 {
    (tick as f32 + 1.0) / (robot as f32 + 3.0)
}

/// Records a fleet in which robot 2 is absent and robot 3 is on no edge. The name of its column
/// `state` is also one of the common titles.
fn recording(folder: &Path) -> PathBuf {
    let path = folder.join("run.mcap");
    let mut out =
        McapFile::create(fs::File::create(&path).unwrap(), Compression::Lz4, 500).unwrap();
    let at = |tick: u64| MessageHeader {
        channel_id: 0,
        sequence: 0,
        log_time: tick * 10_000_000,
        publish_time: 0,
    };
    let edge = |id| regatta::Edge { id, ..regatta::Edge::default() };
    let world =
        regatta::World { run_id: 1, edges: vec![edge(70), edge(71)], ..regatta::World::default() };
    out.write(&Topic::World, at(0), &world.encode_to_vec()).unwrap();
    for tick in 0..TICKS {
        out.write(&Topic::Frames, at(tick), &frame(tick)).unwrap();
        if tick.is_multiple_of(2) {
            let header =
                ColumnHeader { run_id: 1, tick, robots: ROBOTS as u32, ..ColumnHeader::default() };
            let values: Vec<_> =
                (0..ROBOTS).map(|robot| tick as f32 + robot as f32 / 7.0).collect();
            let column =
                encode::column(&ColumnValues { header: &header, values: &values, missed: 0 });
            out.write(&Topic::Column("state".parse().unwrap()), at(tick), &column).unwrap();
        }
    }
    out.writer.finish().unwrap();
    path
}

fn frame(tick: u64) -> Vec<u8> {
    let mut lines = vec![Line::default(); frame_lines(ROBOTS)];
    let columns = ColumnsMut::split(&mut lines, ROBOTS);
    columns.x.iter_mut().enumerate().for_each(|(robot, value)| *value = x(tick, robot));
    columns.edge[..ROBOTS].copy_from_slice(&[0, 1, 0, NO_EDGE]);
    columns.state[..ROBOTS].copy_from_slice(&[1, 3, 255, 0]);
    let header = FrameHeader {
        run_id: 1,
        tick,
        sim_time_nanos: tick * 10_000_000,
        robots: ROBOTS as u32,
        stride_lines: stride_lines(ROBOTS) as u32,
        ..FrameHeader::default()
    };
    encode::frame(&Frame::new(&header, &lines).unwrap())
}

#[derive(Debug, Parser)]
struct Cli {
    #[command(flatten)]
    args: ExportArgs,
}

fn parse(recording: &Path, args: &[&str]) -> Result<Cli, clap::Error> {
    Cli::try_parse_from([&["export", recording.to_str().unwrap()], args].concat())
}

fn run(recording: &Path, args: &[&str]) -> Result<String, ExportError> {
    export(&parse(recording, args).unwrap().args)
}

#[test]
fn each_robot_has_a_file_with_one_line_per_frame() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("tables/csv");
    let summary = run(&recording(folder.path()), &["--csv", out.to_str().unwrap()]).unwrap();
    assert!(summary.starts_with("18 rows in 3 files"), "{summary}");
    assert!(!out.join("robot-2.csv").exists(), "an absent robot has no file");
    let text = fs::read_to_string(out.join("robot-1.csv")).unwrap();
    let mut lines = text.lines();
    let header = "time_s,run,tick,sim_time_s,robot,x_m,y_m,theta_rad,speed_m_per_s,s_m,edge,state,column_state";
    assert_eq!(lines.next(), Some(header));
    for (tick, line) in lines.enumerate() {
        let fields: Vec<_> = line.split(',').collect();
        assert_eq!(
            (fields[2], fields[4], fields[10], fields[11]),
            (tick.to_string().as_str(), "1", "71", "held")
        );
        assert_eq!(fields[5].parse::<f32>().unwrap().to_bits(), x(tick as u64, 1).to_bits());
        let newest = (tick - tick % 2) as f32 + 1.0 / 7.0;
        assert_eq!(fields[12].parse::<f32>().unwrap().to_bits(), newest.to_bits());
    }
    assert_eq!(text.lines().count(), 1 + TICKS as usize);
    let without_edge = fs::read_to_string(out.join("robot-3.csv")).unwrap();
    assert!(without_edge.lines().nth(1).unwrap().contains(",,idle,"), "{without_edge}");
}

#[test]
fn one_table_of_all_robots_is_sorted_by_time() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().to_str().unwrap();
    run(&recording(folder.path()), &["--csv", out, "--long", "--robots", "0,3..9"]).unwrap();
    let text = fs::read_to_string(folder.path().join("robots.csv")).unwrap();
    let keys = text.lines().skip(1).map(|line| {
        let fields: Vec<_> = line.split(',').collect();
        (fields[2].parse().unwrap(), fields[4].parse().unwrap())
    });
    let expected: Vec<(u64, u64)> = (0..TICKS).flat_map(|tick| [(tick, 0), (tick, 3)]).collect();
    assert_eq!(keys.collect::<Vec<_>>(), expected);
}

#[test]
fn a_parquet_file_contains_the_same_rows() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("run.parquet");
    run(&recording(folder.path()), &["--parquet", out.to_str().unwrap()]).unwrap();
    let reader = SerializedFileReader::new(fs::File::open(&out).unwrap()).unwrap();
    let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 18);
    for (row, (tick, robot)) in
        rows.iter().zip((0..TICKS).flat_map(|tick| [0, 1, 3].map(|robot| (tick, robot))))
    {
        let fields: Vec<_> = row.get_column_iter().map(|(_, field)| field.clone()).collect();
        assert_eq!((&fields[2], &fields[4]), (&Field::ULong(tick), &Field::UInt(robot as u32)));
        assert_eq!(fields[5], Field::Float(x(tick, robot)));
        let edge = [Field::UInt(70), Field::UInt(71), Field::Null, Field::Null][robot].clone();
        assert_eq!(fields[10], edge);
        assert_eq!(fields[12], Field::Float((tick - tick % 2) as f32 + robot as f32 / 7.0));
    }
}

#[test]
fn requests_for_data_that_was_not_recorded_are_rejected() {
    let folder = TempDir::new().unwrap();
    let (recording, out) = (recording(folder.path()), folder.path().join("out"));
    let out = out.to_str().unwrap();
    let error = run(&recording, &["--csv", out, "--columns", "load"]).unwrap_err().to_string();
    assert_eq!(error, "the recording has no column 'load'; its columns are: state");
    let error = run(&recording, &["--csv", out, "--robots", "40..50"]).unwrap_err().to_string();
    assert!(error.contains("from 0 to 3"), "{error}");
}

#[test]
fn an_export_without_a_target_is_rejected() {
    let error = parse(Path::new("run.mcap"), &["--robots", "1"]).unwrap_err();
    assert_eq!(error.kind(), clap::error::ErrorKind::MissingRequiredArgument);
    assert!(
        error.to_string().contains("--output") && error.to_string().contains("--parquet"),
        "{error}"
    );
    assert!(parse(Path::new("run.mcap"), &["--csv", "a", "--parquet", "b"]).is_ok());
}

#[test]
fn a_recording_is_never_overwritten() {
    let folder = TempDir::new().unwrap();
    let path = recording(folder.path());
    let before = fs::read(&path).unwrap();
    fs::hard_link(&path, folder.path().join("robots.csv")).unwrap();
    let (file, tables) = (path.to_str().unwrap(), folder.path().to_str().unwrap());
    let mut errors = Vec::new();
    for args in [&["--parquet", file, "--force"][..], &["--csv", tables, "--long", "--force"]] {
        errors.push(run(&path, args).unwrap_err().to_string());
    }
    #[derive(Parser)]
    struct Plot {
        #[command(flatten)]
        args: PlotArgs,
    }
    let args = ["plot", file, "--robot", "0", "-o"];
    let draw =
        |output: &[&str]| plot(&Plot::try_parse_from([&args[..], output].concat()).unwrap().args);
    let linked = folder.path().join("linked.svg");
    fs::hard_link(&path, &linked).unwrap();
    errors.push(draw(&[linked.to_str().unwrap(), "--force"]).unwrap_err().to_string());
    for error in errors {
        assert!(error.contains("it is a recording"), "{error}");
    }
    assert_eq!(fs::read(&path).unwrap(), before);
    for name in ["0.svg", "0.png"] {
        let picture = folder.path().join(name);
        let picture = picture.to_str().unwrap();
        draw(&[picture]).unwrap();
        let error = draw(&[picture]).unwrap_err().to_string();
        assert!(error.contains("it exists already") && error.contains("--force"), "{error}");
        draw(&[picture, "--force"]).unwrap();
    }
    assert!(fs::read(folder.path().join("0.png")).unwrap().starts_with(b"\x89PNG"));
    let error = draw(&["0.jpeg"]).unwrap_err().to_string();
    assert!(error.contains("ends with .png or .svg"), "{error}");
}

#[test]
fn an_existing_table_is_only_overwritten_on_request() {
    let folder = TempDir::new().unwrap();
    let recording = recording(folder.path());
    let table = folder.path().join("robots.csv");
    fs::write(&table, "precious").unwrap();
    let out = ["-o", table.to_str().unwrap()];
    let error = run(&recording, &out).unwrap_err().to_string();
    assert!(error.contains("it exists already") && error.contains("--force"), "{error}");
    assert_eq!(fs::read_to_string(&table).unwrap(), "precious");
    run(&recording, &[&out[..], &["--force"]].concat()).unwrap();
    assert_eq!(fs::read_to_string(&table).unwrap().lines().count(), 19);
}

/// Returns the names of the files in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn nothing_is_left_of_an_export_that_fails() {
    let folder = TempDir::new().unwrap();
    let path = recording(folder.path());
    let out = folder.path().join("new/tables");
    // The second of the two files exists already.
    fs::write(folder.path().join("robots.parquet"), "precious").unwrap();
    let parquet = folder.path().join("robots.parquet");
    let args = ["--csv", out.to_str().unwrap(), "--parquet", parquet.to_str().unwrap()];
    assert!(run(&path, &args).is_err());
    // The last chunk is damaged.
    let mut bytes = fs::read(&path).unwrap();
    let chunk = mcap::Summary::read(&bytes).unwrap().unwrap().chunk_indexes.pop().unwrap();
    let end = (chunk.chunk_start_offset + chunk.chunk_length) as usize;
    bytes[end - chunk.compressed_size as usize..end].fill(0xa5);
    fs::write(&path, &bytes).unwrap();
    for format in ["csv", "parquet"] {
        assert!(run(&path, &["-o", out.to_str().unwrap(), "--format", format]).is_err());
    }
    assert_eq!(names(folder.path()), ["robots.parquet", "run.mcap"]);
    assert_eq!(fs::read_to_string(&parquet).unwrap(), "precious");
}

/// Adds a second recording with events, a command with a leg, and contacts of two ticks, the second
/// as an update.
fn recording_of_messages(folder: &Path) -> PathBuf {
    let path = folder.join("messages.mcap");
    let mut out =
        McapFile::create(fs::File::create(&path).unwrap(), Compression::Lz4, 500).unwrap();
    let at = |tick: u64| MessageHeader {
        channel_id: 0,
        sequence: 0,
        log_time: tick * 10_000_000,
        publish_time: 0,
    };
    let edge = |id| regatta::Edge { id, ..regatta::Edge::default() };
    let world =
        regatta::World { run_id: 1, edges: vec![edge(70), edge(71)], ..regatta::World::default() };
    out.write(&Topic::World, at(0), &world.encode_to_vec()).unwrap();
    let event =
        |kind, robot, id, detail| regatta::Event { token: 5, kind, robot, id, detail, cause: 0 };
    let flat = regatta::Event { cause: 1, ..event(13, 3, 0, 0) };
    let closed = event(15, u32::MAX, 71, 0);
    let events = vec![
        event(1, 3, 12, 0),
        event(7, 4, 99, 2),
        event(2, 3, 0, 0),
        flat,
        event(13, 5, 0, 0),
        closed,
    ];
    let events = regatta::Events { run_id: 1, tick: 2, events, ..regatta::Events::default() };
    out.write(&Topic::Events, at(2), &events.encode_to_vec()).unwrap();
    let command = |kind, legs| regatta::Command {
        token: 8,
        kind,
        robot: 3,
        legs,
        id: 71,
        s: 0.1,
        ..regatta::Command::default()
    };
    let commands = vec![command(1, 1), command(0, 0)];
    let commands =
        regatta::Commands { run_id: 1, tick: 3, commands, ..regatta::Commands::default() };
    out.write(&Topic::Commands, at(3), &commands.encode_to_vec()).unwrap();
    let mut encoder = ContactEncoder::default();
    for tick in 4..6 {
        let pair = |robot, level, edge| ContactRecord {
            since_tick: 1,
            since_nanos: 10_000_000,
            robots: [robot, robot + 2],
            level,
            edge,
            x: 0.1 * tick as f32,
            ..ContactRecord::default()
        };
        let header = ContactHeader { run_id: 1, tick, ..ContactHeader::default() };
        let list = ContactList { header, pairs: vec![pair(1, 2, 1), pair(7, 1, NO_EDGE)] };
        let (topic, message) = encoder.encode(tick * 10_000_000, list);
        out.write(&topic, at(tick), &message).unwrap();
    }
    let ended = regatta::ContactEvent {
        tick: 6,
        robot: 1,
        other_robot: 3,
        level: 2,
        change: 2,
        ..Default::default()
    };
    let ended =
        regatta::ContactEvents { run_id: 1, tick: 6, events: vec![ended], ..Default::default() };
    out.write(&Topic::ContactEvents, at(6), &ended.encode_to_vec()).unwrap();
    out.writer.finish().unwrap();
    path
}

const EVENTS: &str = "time_s,run,tick,robot,kind,id,token,refusal,cause
0.02,0,2,3,reached_node,12,5,,
0.02,0,2,4,refused,99,5,unknown_edge,
0.02,0,2,3,route_done,,5,,
0.02,0,2,3,broken_down,,5,,flat_battery
0.02,0,2,5,broken_down,,5,,unknown
0.02,0,2,4294967295,edge_closed,71,5,,
";
const COMMANDS: &str = "time_s,run,tick,robot,kind,id,s_m,reverse,released,robot_type,legs,token
0.03,0,3,3,assign,71,0.1,0,0,0,1,8
0.03,0,3,3,leg,71,0.1,0,0,0,0,8
";
const CONTACTS: &str =
    "time_s,run,tick,robot,other_robot,level,since_tick,since_s,edge,x_m,y_m,relative_speed_m_per_s
0.04,0,4,1,3,touching,1,0.01,71,0.4,0,0
0.04,0,4,7,9,possible,1,0.01,,0.4,0,0
0.05,0,5,1,3,touching,1,0.01,71,0.5,0,0
0.05,0,5,7,9,possible,1,0.01,,0.5,0,0
";
const CONTACT_EVENTS: &str =
    "time_s,run,tick,robot,other_robot,level,change,edge,x_m,y_m,relative_speed_m_per_s
0.06,0,6,1,3,touching,ended,70,0,0,0
";

#[test]
fn events_commands_and_contacts_are_exported() {
    let folder = TempDir::new().unwrap();
    let (recording, out) = (recording_of_messages(folder.path()), folder.path().join("tables"));
    let topics = "contacts,events,commands,contact_events";
    run(&recording, &["-o", out.to_str().unwrap(), "--topics", topics]).unwrap();
    let tables = [
        ("commands.csv", COMMANDS),
        ("contact_events.csv", CONTACT_EVENTS),
        ("contacts.csv", CONTACTS),
        ("events.csv", EVENTS),
    ];
    assert_eq!(names(&out), tables.map(|(name, _)| name));
    for (name, text) in tables {
        assert_eq!(fs::read_to_string(out.join(name)).unwrap(), text);
    }
    run(&recording, &["-o", out.to_str().unwrap(), "--topics", topics, "--format", "parquet"])
        .unwrap();
    for (name, text) in tables {
        let file = fs::File::open(out.join(name.replace("csv", "parquet"))).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows.len(), text.lines().count() - 1, "{name}");
        let titles: Vec<_> = rows[0].get_column_iter().map(|(title, _)| title.as_str()).collect();
        assert_eq!(Some(&titles.join(",")[..]), text.lines().next());
        let robot = rows[0]
            .get_column_iter()
            .find(|(title, _)| *title == "robot")
            .map(|(_, field)| field.clone());
        let column = titles.iter().position(|title| *title == "robot").unwrap();
        let expected =
            text.lines().nth(1).unwrap().split(',').nth(column).unwrap().parse().unwrap();
        assert_eq!(robot, Some(Field::UInt(expected)), "{name}");
    }
}

#[test]
fn robots_and_times_limit_the_rows() {
    let folder = TempDir::new().unwrap();
    let (messages, frames) = (recording_of_messages(folder.path()), recording(folder.path()));
    let lines = |recording: &Path, args: &[&str]| {
        let table = folder.path().join("table.csv");
        run(recording, &[&["-o", table.to_str().unwrap(), "--force"], args].concat()).unwrap();
        fs::read_to_string(&table).unwrap().lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(
        lines(&messages, &["--topics", "contacts", "--robots", "9", "--from", "50ms"]).len(),
        1
    );
    assert_eq!(lines(&messages, &["--topics", "events", "--robots", "4"]).len(), 1);
    let some = lines(&frames, &["--robots", "1", "--from", "25ms", "--to", "40ms"]);
    assert_eq!(some.len(), 2, "{some:?}");
    // The column of tick 2 is still valid at tick 3.
    assert!(
        some[0].starts_with("0.03,") && some[0].ends_with(&format!(",{}", 2.0_f32 + 1.0 / 7.0)),
        "{some:?}"
    );
}

#[test]
fn several_tables_need_a_folder_and_only_recorded_ones_are_exported() {
    let folder = TempDir::new().unwrap();
    let recording = recording(folder.path());
    let out = folder.path().join("all.csv");
    let error = run(&recording, &["-o", out.to_str().unwrap(), "--topics", "frames,events"])
        .unwrap_err()
        .to_string();
    assert!(error.contains("only one table; give a folder"), "{error}");
    let error = run(&recording, &["-o", out.to_str().unwrap(), "--topics", "commands"])
        .unwrap_err()
        .to_string();
    assert_eq!(
        error,
        "the recording has no commands; its topics are: /world, /frames, /columns/state"
    );
}
