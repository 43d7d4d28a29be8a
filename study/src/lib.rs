//! Study: many runs of a plant, one answer.
//!
//! A [`plan`] says what is asked. It makes [`job`]s: self-contained files that [`workers`] turn
//! into [`outcome`]s anywhere, which the [`store`] keeps. The [`sweep`] decides by what is known
//! which jobs come next, and the [`answer`] says what they tell, with the [`statistics`] that it
//! takes; [`page`] shows it.
//!
//! What a study does next depends on finished rounds alone, never on which run ended first: the
//! same study gives the same answer on any machine.

pub mod answer;
pub mod conduct;
pub mod job;
pub mod outcome;
pub mod page;
pub mod plan;
pub mod statistics;
pub mod store;
pub mod sweep;
pub mod workers;
