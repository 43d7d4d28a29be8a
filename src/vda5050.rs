//! `regatta vda5050`: judges the traffic of an MQTT broker by the standard VDA 5050, and shows the
//! vehicles there as a fleet.

pub mod live;
pub mod vehicles;

use std::ffi::OsString;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Subcommand};
use regatta_plugin::Termination;
use regatta_vda5050::judge::traffic::Recording;
use regatta_vda5050::judge::{Finding, Judge, Protocol, Report, Strictness};

use self::live::LiveArgs;
use self::vehicles::VehiclesArgs;
use crate::failure::{Failure, plugin_failure};
use crate::output::{Force, STANDARD_STREAM, check_file, show, write_file};

/// The largest recording in bytes. It is read message by message.
const MOST_BYTES: u64 = 1 << 40;

/// A subcommand of `regatta vda5050`.
#[derive(Debug, Subcommand)]
pub enum Vda5050Command {
    /// List the breaches of the standard by master and vehicles, on a broker or in a recording;
    /// exit code 0 if there are no errors
    Check(Box<CheckArgs>),
    /// Publish the vehicles of a broker as a fleet, which a fleet manager can steer and all readers
    /// can read; regatta master starts both
    Vehicles(Box<VehiclesArgs>),
}

/// Options of `regatta vda5050 check`.
#[derive(Args, Debug)]
pub struct CheckArgs {
    /// Recording as mosquitto_sub prints it, with -v, -F '%U %t %p' or '%U %q %r %t %p', or
    /// -F %j; - for standard input; or a broker to listen to, until Ctrl-C
    #[arg(value_name = "FILE|mqtt://[USER@]HOST[:PORT]")]
    source: OsString,
    #[command(flatten)]
    live: LiveArgs,
    /// Version of the standard to check against: auto (that of each message's header), 2.0, 2.1 or
    /// 3.0
    #[arg(long, value_name = "VERSION", default_value_t = Protocol::Auto)]
    protocol: Protocol,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Write JUnit XML to a file, for CI: a test case for each rule
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Fail on warnings, too
    #[arg(long)]
    strict: bool,
    /// Number of findings to print for each rule; all are counted
    #[arg(long, value_name = "N", default_value_t = 20)]
    examples: usize,
    #[command(flatten)]
    force: Force,
}

/// Runs `regatta vda5050`.
pub fn run(command: &Vda5050Command) -> Result<ExitCode, Failure> {
    match command {
        Vda5050Command::Check(args) => check(args),
        Vda5050Command::Vehicles(args) => vehicles::run(args).map(|()| ExitCode::SUCCESS),
    }
}

fn check(args: &CheckArgs) -> Result<ExitCode, Failure> {
    if let Some(path) = &args.junit {
        check_file(path, args.force)?;
    }
    let report = judged(args)?;
    let strictness = if args.strict { Strictness::Warnings } else { Strictness::Errors };
    match args.json {
        true => show(report.json() + "\n"),
        false => show(&report),
    }
    if let Some(path) = &args.junit {
        write_file(path, report.junit(strictness).as_bytes(), args.force)?;
    }
    Ok(if report.fails(strictness) { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Judges all messages of the source, and prints findings as they come.
fn judged(args: &CheckArgs) -> Result<Report, Failure> {
    let source = args.source.to_string_lossy();
    if source.starts_with("mqtt://") || source.starts_with("mqtts://") {
        let (judge, mut report) = live::listen(args, &source.parse()?)?;
        report.conclude(&judge, 0);
        return Ok(report);
    }
    if args.source == STANDARD_STREAM {
        // Ctrl-C ends the program that writes, too: what it has written is reported.
        Termination::watch().map_err(plugin_failure)?;
        return read(args, io::stdin().lock(), Path::new("standard input"));
    }
    let path = Path::new(&args.source);
    let file = regatta_base::file::open(path, MOST_BYTES)
        .map_err(|error| format!("{}: can't read: {error}", path.display()))?;
    read(args, BufReader::new(file), path)
}

fn read(args: &CheckArgs, input: impl BufRead, path: &Path) -> Result<Report, Failure> {
    let mut recording = Recording::new(input);
    let (mut judge, mut report) = (Judge::new(args.protocol), Report::new(args.examples));
    while let Some(message) =
        recording.read().map_err(|error| format!("{}: can't read on: {error}", path.display()))?
    {
        let findings = judge.take(&message.seen());
        findings.into_iter().for_each(|finding| take(args, &mut report, finding));
    }
    report.conclude(&judge, recording.unread_lines());
    if judge.tally().judged == 0 {
        return Err(nothing_to_judge(path, recording.unread_lines()));
    }
    Ok(report)
}

/// Adds a finding to the report, and prints it.
fn take(args: &CheckArgs, report: &mut Report, finding: Finding) {
    if let Some(finding) = report.add(finding).filter(|_| !args.json) {
        show(format_args!("{finding}\n"));
    }
}

fn nothing_to_judge(path: &Path, lines: u64) -> Failure {
    let path = path.display();
    format!(
        "{path}: no message of VDA 5050 in {lines} lines: record topics like \
         uagv/v2/MANUFACTURER/SERIAL/state by mosquitto_sub -v (see docs/vda5050-check.md)"
    )
    .into()
}
