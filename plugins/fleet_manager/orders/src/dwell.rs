//! Dwell times: how long robots stand at the stops of orders.
//!
//! ```yaml
//! dwell: {min: 5, max: 15}     # at all stops, a distribution
//! dwell:
//!   pick: {mean: 12, sd: 3}    # by the action of the stop: pick, drop, other
//!   drop: 8
//!   at: {S4: {mean: 40, sd: 9}, S5: 20}   # at these stations, whatever the action
//! ```

use std::collections::BTreeMap;

use regatta_base::random::Random;
use regatta_base::yaml::{self, Node};

use super::distribution::Distribution;
use super::order::Action;
use super::places::Places;

const KEYS: [&str; 4] = ["pick", "drop", "other", "at"];

/// The dwell times of the stops of some orders.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Dwell {
    pick: Distribution,
    drop: Distribution,
    other: Distribution,
    /// By node.
    at: BTreeMap<u32, Distribution>,
}

impl Dwell {
    /// Reads dwell times.
    pub(super) fn read(value: &Node, places: &Places) -> Result<Self, yaml::Error> {
        let by_kind = value.is_map() && value.pairs()?.iter().any(|(key, _)| is_key(key));
        if !by_kind {
            let all = Distribution::read(value)?;
            let (pick, drop, other) = (all.clone(), all.clone(), all);
            return Ok(Self { pick, drop, other, at: BTreeMap::new() });
        }
        let fields = value.fields(&KEYS)?;
        let mut at = BTreeMap::new();
        for (name, distribution) in fields.optional("at", Node::pairs)?.unwrap_or_default() {
            let node = places.find_one(&name).map_err(|error| value.error(error.to_string()))?;
            at.insert(node, Distribution::read(distribution)?);
        }
        Ok(Self {
            pick: fields.optional("pick", Distribution::read)?.unwrap_or_default(),
            drop: fields.optional("drop", Distribution::read)?.unwrap_or_default(),
            other: fields.optional("other", Distribution::read)?.unwrap_or_default(),
            at,
        })
    }

    /// Returns the dwell time of a stop in seconds. The same draw gives the same time.
    pub(super) fn secs(&self, node: u32, action: Action, random: Random, draw: u64) -> f64 {
        let of_action = match action {
            Action::Pick => &self.pick,
            Action::Drop => &self.drop,
            _ => &self.other,
        };
        self.at.get(&node).unwrap_or(of_action).secs(random, draw)
    }
}

fn is_key(key: &str) -> bool {
    KEYS.contains(&key)
}
