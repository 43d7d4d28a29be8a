//! Encodes lists of contacts.

use std::cmp::Ordering;

use prost::Message;
use regatta_plugin::contact::ContactRecord;

use super::{ContactList, Trend, key, motion};
use crate::encode;
use crate::schema::{Topic, regatta};

/// The number of updates after which a list is recorded whole.
const MOST_UPDATES: u32 = 100;
/// The time on the recording's clock after which a list is recorded whole, in nanoseconds.
const LONGEST_CHAIN: u64 = 10_000_000_000;

/// The encoder of a recording's lists of contacts.
#[derive(Debug, Default)]
pub(crate) struct ContactEncoder {
    /// The number of the list encoded last.
    number: u64,
    last: Vec<ContactRecord>,
    /// The trends of the pairs in `last`.
    trends: Vec<Trend>,
    /// The updates since the last whole list; `None` if the next list must be a whole one.
    updates: Option<u32>,
    /// The times of the last whole list and of the last list.
    whole_at: u64,
    last_at: u64,
}

impl ContactEncoder {
    /// Makes the next list a whole one.
    pub fn restart(&mut self) {
        self.updates = None;
    }

    /// Encodes a list, and returns the topic that it belongs to.
    pub fn encode(&mut self, log_time: u64, list: ContactList) -> (Topic, Vec<u8>) {
        self.number += 1;
        let is_sorted = list.pairs.is_sorted_by(|one, next| key(one) < key(next));
        let continues = self.updates.is_some_and(|updates| updates < MOST_UPDATES);
        let in_time =
            (self.last_at..self.whole_at.saturating_add(LONGEST_CHAIN)).contains(&log_time);
        self.last_at = log_time;
        let update = (is_sorted && continues && in_time).then(|| self.update(&list));
        let encoded = match update.filter(|update| 2 * update.added.len() <= list.pairs.len()) {
            Some(update) => {
                self.updates = self.updates.map(|updates| updates + 1);
                (Topic::ContactUpdates, update.encode_to_vec())
            }
            None => {
                // Readers don't update a list that isn't sorted.
                self.updates = is_sorted.then_some(0);
                self.whole_at = log_time;
                self.trends.clear();
                self.trends.resize(list.pairs.len(), Trend::default());
                (Topic::Contacts, encode::contacts(&list, self.number))
            }
        };
        self.last = list.pairs;
        encoded
    }

    /// Returns the changes from the last list to `list`, and advances the trends.
    fn update(&mut self, list: &ContactList) -> regatta::ContactUpdate {
        let mut update = encode::contact_update(&list.header, self.number);
        let mut trends = Vec::with_capacity(list.pairs.len());
        let mut before = self.last.iter().zip(&self.trends).peekable();
        let mut kept = 0;
        for pair in &list.pairs {
            // Pairs that aren't in the list any more, or are in it with something else changed.
            while before
                .next_if(|(last, _)| {
                    key(last) < key(pair) || (key(last) == key(pair) && !is_kept(last, pair))
                })
                .is_some()
            {
                update.removed.push(std::mem::take(&mut kept));
            }
            match before.next_if(|(last, _)| key(last).cmp(&key(pair)) == Ordering::Equal) {
                Some((last, trend)) => {
                    kept += 1;
                    let (from, to) = (motion(last), motion(pair));
                    let change: Trend = std::array::from_fn(|i| to[i].wrapping_sub(from[i]));
                    let [x, y, speed] = std::array::from_fn(|i| change[i].wrapping_sub(trend[i]));
                    update.x.push(x);
                    update.y.push(y);
                    update.relative_speed.push(speed);
                    trends.push(change);
                }
                None => {
                    update.added.push(encode::contact(pair));
                    trends.push(Trend::default());
                }
            }
        }
        for _ in before {
            update.removed.push(std::mem::take(&mut kept));
        }
        self.trends = trends;
        update
    }
}

/// Whether two records of a pair differ at most in their position and speed.
fn is_kept(last: &ContactRecord, pair: &ContactRecord) -> bool {
    (last.since_tick, last.since_nanos, last.edge) == (pair.since_tick, pair.since_nanos, pair.edge)
}
