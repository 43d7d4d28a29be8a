//! Building blocks that the plugins of Regatta share, on top of the contract (`regatta_plugin`).
//!
//! | module | |
//! |---|---|
//! | [`command_line`] | the `main` of a plugin with options of its own |
//! | [`csv_file`] | a CSV file to which rows are appended, and which may be rotated |
//! | [`whole_file`] | files that appear under their name only once they are complete |
//! | [`dispatch`], [`way`] | commands with answers; the fastest way to a node |
//! | [`edges`] | edges by id, name or nodes |
//! | [`history`] | hot spots of a run, and its figures over time |
//! | `server`, `private` | a web server, and the token of this user; they need the feature `server` |

pub mod command_line;
pub mod csv_file;
pub mod dispatch;
pub mod edges;
pub mod history;
#[cfg(feature = "server")]
pub mod private;
#[cfg(feature = "server")]
pub mod server;
pub mod way;
pub mod whole_file;

pub use command_line::{parse, run_from};
pub use csv_file::{CsvChange, CsvError, CsvFile, RowCounts};
pub use dispatch::{DispatchError, Dispatcher};
pub use edges::{EdgeError, find_edge, find_leg};
pub use history::{RunHistory, series::Series, spots::Spots};
pub use way::{WayError, find_node};
pub use whole_file::WholeFile;
