//! `regatta validate`: judges a recording.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use regatta_record::{Published, play};
use regatta_validator::{Judge, JudgeOptions};

use crate::failure::Failure;

/// Options of `regatta validate`.
#[derive(Args)]
pub struct ValidateArgs {
    /// The recording
    file: PathBuf,
    #[command(flatten)]
    judge: JudgeOptions,
}

pub fn run(args: &ValidateArgs) -> Result<ExitCode, Failure> {
    let mut judge = Judge::new(args.judge.settings());
    play(&args.file, |published| match published {
        Published::World(world) => judge.take_world(&world),
        Published::Types(types) => judge.take_types(types),
        Published::Events(header, events) => judge.take_events(&header, events, false),
        Published::Tasks(header, missed, tasks) => judge.take_tasks(&header, missed, tasks),
        Published::Frame(frame) => judge.take_frame(&frame),
    })?;
    let report = judge.finish();
    print!("{report}");
    args.judge.conclude(&report)?;
    Ok(ExitCode::SUCCESS)
}
