//! The newest world and columns of a recording, which are repeated in it, so that neither damage
//! nor a reader that starts in the middle misses them.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::part::Queued;
use crate::encode::mark_repeated;
use crate::schema::Topic;

/// The time after which a state that hasn't changed is repeated.
const REPEAT_PERIOD: Duration = Duration::from_mins(1);

/// The number of copies, in different chunks, that are written as soon as possible, so that no
/// damaged chunk has the only one.
const ENOUGH: u8 = 2;

/// The newest message of each topic that is worth repeating.
#[derive(Default)]
pub(super) struct Kept {
    states: BTreeMap<Topic, State>,
}

struct State {
    state: Queued,
    written: Instant,
    /// The number of its copies in the current file, up to [`ENOUGH`].
    copies: u8,
}

impl Kept {
    /// Keeps messages that were written.
    pub fn keep(&mut self, written: Vec<Queued>) {
        let now = Instant::now();
        for state in written.into_iter().filter(|message| message.topic.is_repeated()) {
            let copies = match &state.topic {
                // A column that changes often needs no copies.
                Topic::Column(_) => {
                    self.states.get(&state.topic).map_or(0, |before| before.copies) + 1
                }
                _ => 1,
            };
            self.states.insert(
                state.topic.clone(),
                State { state, written: now, copies: copies.min(ENOUGH) },
            );
        }
    }

    /// Starts another file, which has none of the states yet.
    pub fn start_file(&mut self) {
        self.states.values_mut().for_each(|state| state.copies = 0);
    }

    /// Returns the states to repeat now, in a chunk of their own: those that the file, whose first
    /// and newest times are given, doesn't have yet. With `again`, also those that it has only
    /// once, or that haven't been written for a while.
    pub fn due(&mut self, (first, newest): (u64, u64), again: bool) -> Vec<Queued> {
        let now = Instant::now();
        let is_due = |state: &&mut State| {
            let is_old =
                state.copies < ENOUGH || now.duration_since(state.written) >= REPEAT_PERIOD;
            state.copies == 0 || (again && is_old)
        };
        let repeat = |state: &mut State| {
            let mut repeated = state.state.clone();
            let log_time = if state.copies == 0 { first } else { newest };
            repeated.header.log_time = log_time.max(repeated.header.log_time);
            if matches!(repeated.topic, Topic::World | Topic::Column(_)) {
                mark_repeated(&mut repeated.message);
            }
            (state.written, state.copies) = (now, (state.copies + 1).min(ENOUGH));
            repeated
        };
        self.states.values_mut().filter(is_due).map(repeat).collect()
    }
}
