//! Lists of contacts, recorded as changes from list to list.
//!
//! With many robots, most pairs stay in the list for many ticks, and their positions and speeds
//! change evenly. An update therefore holds only the difference from an even change: mostly one
//! byte per number. A whole list now and then lets readers start in the middle, and limits the cost
//! of damage.

use glam::IVec3;
use prost::Message;
use regatta_plugin::contact::{ContactHeader, ContactRecord};

use crate::decode::{self, MessageError};
use crate::encode;
use crate::schema::{Topic, regatta};

/// The number of updates after which a list is recorded whole.
const MOST_UPDATES: u32 = 100;
/// The time on the recording's clock after which a list is recorded whole, in nanoseconds.
const LONGEST_CHAIN: u64 = 10_000_000_000;

/// A list of contacts as it was published.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ContactList {
    pub header: ContactHeader,
    pub pairs: Vec<ContactRecord>,
}

/// Returns the bits of a pair's `x`, `y` and `relative_speed` as integers.
fn motion(pair: &ContactRecord) -> IVec3 {
    let bits = [pair.x, pair.y, pair.relative_speed].map(|value| value.to_bits().cast_signed());
    IVec3::from_array(bits)
}

/// The order of lists: by level, touching pairs first, then by robots.
fn key(pair: &ContactRecord) -> (u32, [u32; 2]) {
    (u32::MAX - pair.level, pair.robots)
}

/// The encoder of a recording's lists of contacts.
#[derive(Debug, Default)]
pub(crate) struct ContactEncoder {
    /// The number of the list encoded last.
    number: u64,
    last: Vec<ContactRecord>,
    /// The latest change of the motion of each pair in `last`.
    trends: Vec<IVec3>,
    /// The updates since the last whole list; `None` if the next list must be a whole one.
    updates: Option<u32>,
    /// The time of the last whole list.
    whole_at: u64,
    /// The time of the last list.
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
                self.trends.resize(list.pairs.len(), IVec3::ZERO);
                (
                    Topic::Contacts,
                    encode::contacts(&list.header, &list.pairs, self.number).encode_to_vec(),
                )
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
            while before.next_if(|(last, _)| is_removed_before(last, pair)).is_some() {
                update.removed.push(std::mem::take(&mut kept));
            }
            if let Some((last, trend)) = before.next_if(|(last, _)| key(last) == key(pair)) {
                kept += 1;
                let change = motion(pair).wrapping_sub(motion(last));
                let difference = change.wrapping_sub(*trend);
                update.x.push(difference.x);
                update.y.push(difference.y);
                update.relative_speed.push(difference.z);
                trends.push(change);
            } else {
                update.added.push(encode::contact(pair));
                trends.push(IVec3::ZERO);
            }
        }
        for _ in before {
            update.removed.push(std::mem::take(&mut kept));
        }
        self.trends = trends;
        update
    }
}

/// Whether a pair of the last list comes before `pair` and isn't kept: it isn't in the new list, or
/// something else than its position and speed has changed.
fn is_removed_before(last: &ContactRecord, pair: &ContactRecord) -> bool {
    let is_changed = (last.since_tick, last.since_nanos, last.edge)
        != (pair.since_tick, pair.since_nanos, pair.edge);
    key(last) < key(pair) || (key(last) == key(pair) && is_changed)
}

/// The decoder of a recording's lists of contacts. It holds the list decoded last.
#[derive(Debug, Default)]
pub(crate) struct ContactDecoder {
    header: ContactHeader,
    pairs: Vec<ContactRecord>,
    /// The latest change of each pair's motion.
    trends: Vec<IVec3>,
    /// The number of the list; `None` if there is no list.
    number: Option<u64>,
}

impl ContactDecoder {
    /// Returns the list decoded last.
    pub fn list(&self) -> Option<(&ContactHeader, &[ContactRecord])> {
        self.number.map(|_| (&self.header, &self.pairs[..]))
    }

    /// Decodes a message on one of the two topics of lists. Returns whether there is a new list: an
    /// update of a lost list can't be decoded.
    pub fn decode(&mut self, topic: &Topic, message: &[u8]) -> Result<bool, MessageError> {
        let update = regatta::ContactUpdate::decode(message)?;
        if *topic == Topic::Contacts {
            self.pairs = update.added.iter().map(decode::contact).collect();
            self.trends.clear();
            self.trends.resize(self.pairs.len(), IVec3::ZERO);
        } else if self.number.is_some_and(|number| number.checked_add(1) == Some(update.number)) {
            self.update(&update)?;
        } else {
            self.number = None;
            return Ok(false);
        }
        (self.header, self.number) = (decode::contact_header(&update), Some(update.number));
        Ok(true)
    }

    /// Merges the kept and the added pairs.
    fn update(&mut self, update: &regatta::ContactUpdate) -> Result<(), MessageError> {
        let kept = self.kept(update).ok_or(MessageError::ContactUpdate)?;
        let mut added = update.added.iter().map(decode::contact).peekable();
        let length = kept.len() + added.len();
        (self.pairs, self.trends) = (Vec::with_capacity(length), Vec::with_capacity(length));
        for (pair, trend) in kept {
            while let Some(new) = added.next_if(|new| key(new) < key(&pair)) {
                self.pairs.push(new);
                self.trends.push(IVec3::ZERO);
            }
            self.pairs.push(pair);
            self.trends.push(trend);
        }
        self.pairs.extend(added);
        self.trends.resize(length, IVec3::ZERO);
        Ok(())
    }

    /// Returns the pairs that an update keeps, with their new positions, speeds and trends, or
    /// `None` if the update doesn't fit the list.
    fn kept(&self, update: &regatta::ContactUpdate) -> Option<Vec<(ContactRecord, IVec3)>> {
        let mut before = self.pairs.iter().copied().zip(self.trends.iter().copied());
        let mut kept = Vec::with_capacity(update.x.len());
        for gap in &update.removed {
            kept.extend(before.by_ref().take(*gap as usize));
            before.next()?;
        }
        kept.extend(before);
        let lengths = [update.x.len(), update.y.len(), update.relative_speed.len()];
        if lengths != [kept.len(); 3] {
            return None;
        }
        for (i, (pair, trend)) in kept.iter_mut().enumerate() {
            let difference = IVec3::new(update.x[i], update.y[i], update.relative_speed[i]);
            *trend = trend.wrapping_add(difference);
            let bits = motion(pair).wrapping_add(*trend).to_array();
            [pair.x, pair.y, pair.relative_speed] =
                bits.map(|bits| f32::from_bits(bits.cast_unsigned()));
        }
        Some(kept)
    }
}

#[cfg(test)]
mod tests;
