//! Messages from the other host that wait for the producer: the newest frame, world and columns,
//! and as many events as have room.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use parking_lot::{Condvar, Mutex};
use regatta_plugin::control::ControlResponse;
use regatta_plugin::records::name::ColumnName;
use zenoh::bytes::ZBytes;

/// The largest number of bytes of events that wait.
const MAX_EVENT_BYTES: usize = 64 << 20;
/// The largest number of columns.
const MAX_COLUMNS: usize = 64;

/// Messages that have arrived.
#[derive(Debug, Default)]
pub struct Mail {
    /// The newest frame.
    pub frame: Option<ZBytes>,
    /// The newest world.
    pub world: Option<ZBytes>,
    /// The events, oldest first.
    pub events: VecDeque<ZBytes>,
    /// The bytes of all events.
    event_bytes: usize,
    /// Messages of events that had no room.
    pub events_lost: u64,
    /// The newest values of each column.
    pub columns: BTreeMap<ColumnName, ZBytes>,
    /// Answers to control requests, by their tickets.
    pub answers: Vec<(u64, ControlResponse)>,
}

impl Mail {
    fn is_empty(&self) -> bool {
        self.frame.is_none()
            && self.world.is_none()
            && self.events.is_empty()
            && self.columns.is_empty()
            && self.answers.is_empty()
    }
}

/// Takes messages from the threads of zenoh, none of which ever waits for the producer.
#[derive(Debug, Default)]
pub struct Mailbox {
    mail: Mutex<Mail>,
    bell: Condvar,
}

impl Mailbox {
    /// Puts a frame in place of the one before.
    pub fn put_frame(&self, frame: ZBytes) {
        self.mail.lock().frame = Some(frame);
        self.bell.notify_one();
    }

    /// Puts a world in place of the one before.
    pub fn put_world(&self, world: ZBytes) {
        self.mail.lock().world = Some(world);
        self.bell.notify_one();
    }

    /// Puts the events of a tick. The oldest go when there is no room.
    pub fn put_events(&self, events: ZBytes) {
        let mut mail = self.mail.lock();
        mail.event_bytes += events.len();
        mail.events.push_back(events);
        while mail.event_bytes > MAX_EVENT_BYTES
            && let Some(oldest) = mail.events.pop_front()
        {
            mail.event_bytes -= oldest.len();
            mail.events_lost += 1;
        }
        drop(mail);
        self.bell.notify_one();
    }

    /// Puts values of a column in place of those before.
    pub fn put_column(&self, name: ColumnName, values: ZBytes) {
        let mut mail = self.mail.lock();
        if mail.columns.len() < MAX_COLUMNS || mail.columns.contains_key(&name) {
            mail.columns.insert(name, values);
        }
        drop(mail);
        self.bell.notify_one();
    }

    /// Puts the answer to a control request.
    pub fn put_answer(&self, ticket: u64, response: ControlResponse) {
        self.mail.lock().answers.push((ticket, response));
        self.bell.notify_one();
    }

    /// Takes everything that has arrived; waits for something for `timeout` at most.
    pub fn take(&self, timeout: Duration) -> Mail {
        let mut mail = self.mail.lock();
        if mail.is_empty() {
            self.bell.wait_for(&mut mail, timeout);
        }
        std::mem::take(&mut *mail)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mail_is_bounded_and_keeps_the_newest() {
        let mailbox = Mailbox::default();
        let part = vec![0_u8; MAX_EVENT_BYTES / 4];
        for _ in 0..9 {
            mailbox.put_events(part.clone().into());
            mailbox.put_frame(vec![1].into());
        }
        mailbox.put_frame(vec![2].into());
        for number in 0..2 * MAX_COLUMNS {
            let name = format!("c{number}").parse().expect("a name");
            mailbox.put_column(name, ZBytes::default());
        }
        let mail = mailbox.take(Duration::ZERO);
        assert_eq!((mail.events.len(), mail.events_lost), (4, 5));
        assert_eq!(mail.frame.expect("a frame").to_bytes(), [2].as_slice());
        assert_eq!(mail.columns.len(), MAX_COLUMNS);
        assert!(mailbox.take(Duration::ZERO).is_empty());
    }
}
