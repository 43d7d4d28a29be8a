//! `regatta info` and `validate`: describe and judge recordings.

use std::path::PathBuf;

use clap::Args;
use regatta_record::{Published, play};
use regatta_validator::{Judge, JudgeOptions};

use crate::failure::Failure;
use crate::output::show;

/// Options of `regatta info`.
#[derive(Args)]
pub struct InfoArgs {
    /// Recording
    file: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs `regatta info`.
pub fn info(args: &InfoArgs) -> Result<(), Failure> {
    let info = regatta_record::info(&args.file)?;
    match args.json {
        true => println!("{}", serde_json::to_string_pretty(&info)?),
        false => show(info),
    }
    Ok(())
}

/// Options of `regatta validate`.
#[derive(Args)]
pub struct ValidateArgs {
    /// Recording
    file: PathBuf,
    #[command(flatten)]
    judge: JudgeOptions,
}

/// Runs `regatta validate`.
pub fn validate(args: &ValidateArgs) -> Result<(), Failure> {
    let mut judge = Judge::new(args.judge.settings());
    play(&args.file, |published| match published {
        Published::World(world) => judge.take_world(world),
        Published::Types(types) => judge.take_types(types),
        Published::Activities(activities) => judge.take_activities(activities),
        Published::Events(header, events) => judge.take_events(&header, events, false),
        Published::Orders(header, missed, orders) => judge.take_orders(&header, missed, orders),
        Published::Frame(frame) => judge.take_frame(&frame),
    })?;
    let report = judge.finish();
    show(&report);
    args.judge.conclude(&report)?;
    Ok(())
}
