//! Certificates against brute force: random small layouts, and the search of all states of the
//! model.

mod conflicts;
mod layouts;
mod model;
mod remarks;
mod room;
mod verdicts;
