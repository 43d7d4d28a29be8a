//! Exported tables contain the recorded values bit for bit.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser;
use mcap::records::MessageHeader;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use prost::Message;
use regatta_plugin::column::ColumnHeader;
use regatta_plugin::frame::{ColumnsMut, FrameHeader, Line, NO_EDGE, frame_lines, stride_lines};
use regatta_plugin::{ColumnValues, Frame};
use tempfile::TempDir;

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

/// Records a fleet in which robot 2 is absent and robot 3 is on no edge. The name of its column `state` is also one of
/// the common titles.
fn recording(folder: &Path) -> PathBuf {
    let path = folder.join("run.mcap");
    let mut out = McapFile::create(fs::File::create(&path).unwrap(), Compression::Lz4, 500).unwrap();
    let at = |tick: u64| MessageHeader { channel_id: 0, sequence: 0, log_time: tick * 10_000_000, publish_time: 0 };
    let edge = |id| regatta::Edge { id, ..regatta::Edge::default() };
    let world = regatta::World { run_id: 1, edges: vec![edge(70), edge(71)], ..regatta::World::default() };
    out.write(&Topic::World, at(0), &world.encode_to_vec()).unwrap();
    for tick in 0..TICKS {
        out.write(&Topic::Frames, at(tick), &frame(tick)).unwrap();
        if tick.is_multiple_of(2) {
            let header = ColumnHeader { run_id: 1, tick, robots: ROBOTS as u32, ..ColumnHeader::default() };
            let values: Vec<_> = (0..ROBOTS).map(|robot| tick as f32 + robot as f32 / 7.0).collect();
            let column = encode::column(&ColumnValues { header: &header, values: &values, missed: 0 });
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
        assert_eq!((fields[2], fields[4], fields[10], fields[11]), (tick.to_string().as_str(), "1", "71", "held"));
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
    for (row, (tick, robot)) in rows.iter().zip((0..TICKS).flat_map(|tick| [0, 1, 3].map(|robot| (tick, robot)))) {
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
    assert!(error.to_string().contains("--csv") && error.to_string().contains("--parquet"), "{error}");
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
    for args in [&["--parquet", file][..], &["--csv", tables, "--long"]] {
        errors.push(run(&path, args).unwrap_err().to_string());
    }
    #[derive(Parser)]
    struct Plot {
        #[command(flatten)]
        args: PlotArgs,
    }
    let args = ["plot", file, "--robot", "0", "-o"];
    let draw = |output: &str| plot(&Plot::try_parse_from([&args[..], &[output]].concat()).unwrap().args);
    errors.push(draw(file).unwrap_err().to_string());
    for error in errors {
        assert!(error.contains("it is a recording"), "{error}");
    }
    assert_eq!(fs::read(&path).unwrap(), before);
    let picture = folder.path().join("0.svg");
    for _ in 0..2 {
        draw(picture.to_str().unwrap()).expect("a file that isn't a recording is overwritten");
    }
}
