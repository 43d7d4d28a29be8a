//! The state of a recording at a time: what was valid then.

use mcap::sans_io::IndexedReaderOptions;
use mcap::sans_io::indexed_reader::ReadOrder;

use super::{Entry, ReadingError, Recording};
use crate::contacts::ContactDecoder;
use crate::decode;
use crate::recorded::RecordedColumn;
use crate::schema::Topic;

impl Recording {
    /// Returns the time and the bytes of the last message on a topic at or before `time`.
    pub(crate) fn last_until(
        &self,
        topic: &Topic,
        time: u64,
    ) -> Result<Option<(u64, Vec<u8>)>, ReadingError> {
        let options =
            IndexedReaderOptions::new().ending_at(time).with_order(ReadOrder::ReverseLogTime);
        let mut reader = self.reader(options, std::slice::from_ref(topic))?;
        Ok(reader.next()?.map(|entry| (entry.log_time, entry.message.to_vec())))
    }

    /// Returns the time and the bytes of the state of a topic before `time`. If that is lost, a
    /// repetition of it after `time` serves as well.
    pub(crate) fn state_before(
        &self,
        topic: &Topic,
        time: u64,
    ) -> Result<Option<(u64, Vec<u8>)>, ReadingError> {
        let before =
            time.checked_sub(1).map_or(Ok(None), |before| self.last_until(topic, before))?;
        if before.is_some() {
            return Ok(before);
        }
        let mut reader = self
            .reader(IndexedReaderOptions::new().starting_at(time), std::slice::from_ref(topic))?;
        let Some(Entry { log_time, message, .. }) = reader.next()? else { return Ok(None) };
        let is_repeated = match topic {
            Topic::World => decode::world(message).map(|world| world.is_repeated),
            Topic::Column(_) => RecordedColumn::parse(message).map(|column| column.is_repeated),
            _ => Ok(false),
        };
        let is_repeated = is_repeated.map_err(|reason| self.malformed(topic, log_time, reason))?;
        Ok(is_repeated.then(|| (log_time, message.to_vec())))
    }

    /// Returns a decoder with the list of contacts before `time`.
    pub(crate) fn contacts_before(&self, time: u64) -> Result<ContactDecoder, ReadingError> {
        let mut decoder = ContactDecoder::default();
        let Some(before) = time.checked_sub(1) else { return Ok(decoder) };
        let Some((from, _)) = self.last_until(&Topic::Contacts, before)? else {
            return Ok(decoder);
        };
        let options = IndexedReaderOptions::new().starting_at(from).ending_at(before);
        let mut reader = self.reader(options, &[Topic::Contacts, Topic::ContactUpdates])?;
        while let Some(Entry { topic, log_time, message }) = reader.next()? {
            decoder
                .decode(topic, message)
                .map_err(|reason| self.malformed(topic, log_time, reason))?;
        }
        Ok(decoder)
    }
}
