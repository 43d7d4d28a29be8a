//! Tests of the layout crate by its public interface.

mod findings;
mod generate;
mod reader_never_panics;
