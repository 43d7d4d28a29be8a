//! scratch
use clap::{Args, FromArgMatches};
fn main() -> regatta_plugin::Result {
    let m = regatta_viewer::Options::augment_args(clap::Command::new("viewer")).get_matches();
    regatta_viewer::run(&regatta_viewer::Options::from_arg_matches(&m).unwrap())
}
