//! The list of contacts after a jump: it is decoded from up to a hundred changes, on a thread of
//! its own, so that dragging the playhead stays smooth.

use std::path::Path;
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::{Duration, Instant};

use crate::contacts::ContactDecoder;
use crate::reading::Recording;

/// The time without another jump after which the list is decoded.
const AFTER: Duration = Duration::from_millis(150);

/// A list that is due, or is being decoded.
#[derive(Clone, Copy, Debug)]
enum Wanted {
    Since(Instant),
    Asked(u64),
}

/// The thread, and the list that it is to decode.
#[derive(Debug)]
pub(super) struct ContactSearch {
    requests: Sender<u64>,
    found: Receiver<(u64, ContactDecoder)>,
    wanted: Option<Wanted>,
}

impl ContactSearch {
    /// Starts the thread. It ends when this is dropped, or at the first damaged message.
    pub fn start(path: &Path) -> std::io::Result<Self> {
        let (requests, requested) = mpsc::channel::<u64>();
        let (find, found) = mpsc::channel();
        let path = path.to_owned();
        std::thread::Builder::new().name("contacts".into()).spawn(move || {
            let Ok(recording) = Recording::open_frames(&path) else { return };
            while let Ok(time) = requested.recv() {
                let time = requested.try_iter().last().unwrap_or(time);
                // The replay decodes the list again when it needs it, and reports the error.
                let Ok(decoder) = recording.contacts_before(time.saturating_add(1)) else { return };
                if find.send((time, decoder)).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self { requests, found, wanted: None })
    }

    /// Notes a jump.
    pub fn jump(&mut self) {
        self.wanted = Some(Wanted::Since(Instant::now()));
    }

    /// Requests the list at a time if it is due. Returns it once it is decoded.
    pub fn poll(&mut self, time: u64) -> Option<ContactDecoder> {
        match self.wanted? {
            Wanted::Since(jumped) => {
                if jumped.elapsed() > AFTER && self.requests.send(time).is_ok() {
                    self.wanted = Some(Wanted::Asked(time));
                }
                None
            }
            Wanted::Asked(asked) => {
                let (_, decoder) = self.found.try_iter().find(|(time, _)| *time == asked)?;
                self.wanted = None;
                Some(decoder)
            }
        }
    }

    /// Cancels the request for a list, and returns whether there was one.
    pub fn cancel(&mut self) -> bool {
        self.wanted.take().is_some()
    }
}
