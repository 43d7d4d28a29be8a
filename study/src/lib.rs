//! Study: many runs of a plant, one answer.
//!
//! A [`plan`] makes [`job`]s: self-contained files that [`workers`] turn into [`outcome`]s on any
//! machine. The [`store`] keeps them, with a [`seal`] on each result. The [`sweep`] selects the next
//! jobs by the outcomes so far, and [`conduct`] drives it. The [`answer`] summarises the outcomes by
//! [`statistics`], [`bottleneck`]s and [`relief`]s, with the [`certificate`] of the layout, and the
//! [`page`] shows it, in the [`words`] that each figure's interval allows.
//!
//! Masters of VDA 5050 work in real time: [`master`] has the studies of those.
//!
//! The next jobs depend on finished rounds alone, never on the order in which runs end, so the same
//! study gives the same answer on any machine.

pub mod answer;
pub mod bottleneck;
pub mod certificate;
pub mod conduct;
pub mod job;
pub mod master;
pub mod outcome;
pub mod page;
pub mod plan;
pub mod relief;
pub mod seal;
pub mod statistics;
pub mod store;
pub mod sweep;
pub mod words;
pub mod workers;
