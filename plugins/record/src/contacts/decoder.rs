//! Decodes lists of contacts.

use prost::Message;
use regatta_plugin::contact::{ContactHeader, ContactRecord};

use super::{Trend, key, motion};
use crate::decode::{self, MessageError};
use crate::schema::{Topic, regatta};

/// The decoder of a recording's lists of contacts. It has the list decoded last.
#[derive(Debug, Default)]
pub(crate) struct ContactDecoder {
    header: ContactHeader,
    pairs: Vec<ContactRecord>,
    trends: Vec<Trend>,
    /// The number of the list; `None` if there is no list.
    number: Option<u64>,
}

impl ContactDecoder {
    /// Returns the list decoded last.
    pub fn list(&self) -> Option<(&ContactHeader, &[ContactRecord])> {
        self.number.map(|_| (&self.header, &self.pairs[..]))
    }

    /// Decodes a message on one of the two topics of lists. Returns whether there is a new list: an
    /// update of a list that is lost can't be decoded.
    pub fn decode(&mut self, topic: &Topic, message: &[u8]) -> Result<bool, MessageError> {
        match topic {
            Topic::Contacts => self.whole(message).map(|()| true),
            _ => self.update(&regatta::ContactUpdate::decode(message)?),
        }
    }

    fn whole(&mut self, message: &[u8]) -> Result<(), MessageError> {
        let (header, pairs, number) = decode::contacts(message)?;
        self.trends.clear();
        self.trends.resize(pairs.len(), Trend::default());
        (self.header, self.pairs, self.number) = (header, pairs, Some(number));
        Ok(())
    }

    fn update(&mut self, update: &regatta::ContactUpdate) -> Result<bool, MessageError> {
        if self.number.is_none_or(|number| number + 1 != update.number) {
            self.number = None;
            return Ok(false);
        }
        let kept = self.kept(update).ok_or(MessageError::ContactUpdate)?;
        let mut added = update.added.iter().map(decode::contact).peekable();
        let length = kept.len() + added.len();
        (self.pairs, self.trends) = (Vec::with_capacity(length), Vec::with_capacity(length));
        for (pair, trend) in kept {
            while let Some(new) = added.next_if(|new| key(new) < key(&pair)) {
                self.push(new, Trend::default());
            }
            self.push(pair, trend);
        }
        added.for_each(|new| self.push(new, Trend::default()));
        (self.header, self.number) = (decode::contact_update(update), Some(update.number));
        Ok(true)
    }

    fn push(&mut self, pair: ContactRecord, trend: Trend) {
        self.pairs.push(pair);
        self.trends.push(trend);
    }

    /// Returns the pairs that an update keeps, with their new positions, speeds and trends, or
    /// `None` if the update doesn't fit the list.
    fn kept(&self, update: &regatta::ContactUpdate) -> Option<Vec<(ContactRecord, Trend)>> {
        let mut before = self.pairs.iter().copied().zip(self.trends.iter().copied());
        let mut kept = Vec::with_capacity(update.x.len());
        for gap in &update.removed {
            let gap = *gap as usize;
            kept.extend(before.by_ref().take(gap));
            before.next()?;
        }
        kept.extend(before);
        let lengths = [update.x.len(), update.y.len(), update.relative_speed.len()];
        if lengths != [kept.len(); 3] {
            return None;
        }
        for (i, (pair, trend)) in kept.iter_mut().enumerate() {
            let from = motion(pair);
            let differences = [update.x[i], update.y[i], update.relative_speed[i]];
            *trend = std::array::from_fn(|axis| trend[axis].wrapping_add(differences[axis]));
            let to: [i32; 3] = std::array::from_fn(|axis| from[axis].wrapping_add(trend[axis]));
            [pair.x, pair.y, pair.relative_speed] =
                to.map(|bits| f32::from_bits(bits.cast_unsigned()));
        }
        Some(kept)
    }
}
