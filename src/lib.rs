//! The parts of the command line that `regatta-bench` uses too: processes of this program, the
//! files that commands write, progress, and experiments with their reports. It isn't a library for
//! other programs: those use the crates of the engine, the contract and the plugins.

pub mod arguments;
pub mod experiment;
pub mod failure;
pub mod lockstep_run;
pub mod output;
pub mod output_error;
pub mod program;
pub mod progress;
pub mod supervisor;
pub mod version;
