//! Numbers of robots that don't fit on a layout.

use serde::Serialize;

use crate::sweep::Known;
use crate::workers::RunFailure;

/// A number of robots that doesn't fit on the layout.
#[derive(Clone, Debug, Serialize)]
pub struct NoRoom {
    /// The number of robots.
    pub robots: u32,
    /// The seeds with which they don't fit; with others they may.
    pub seeds: Vec<u64>,
    /// The reason, with the first of these seeds.
    pub reason: String,
}

impl NoRoom {
    /// Returns the numbers of robots that don't fit, in ascending order.
    pub(super) fn of(known: &Known) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        // Runs are in the order of robots, then of seeds.
        for ((robots, seed), run) in known {
            let Err(RunFailure::NoRoom(reason)) = run else { continue };
            match found.last_mut().filter(|last| last.robots == *robots) {
                Some(last) => last.seeds.push(*seed),
                None => {
                    found.push(Self { robots: *robots, seeds: vec![*seed], reason: reason.clone() })
                }
            }
        }
        found
    }
}
