//! The fleet as Open-RMF's fleet adapters see one: states of robots, doors and lifts, and requests.

mod requests;
mod states;

use std::collections::HashMap;
use std::sync::Arc;

use parking_lot::Mutex;

pub(crate) use requests::Requests;
pub(crate) use states::States;

/// The task of each robot's last request, which its state repeats.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tasks(Arc<Mutex<HashMap<u32, Task>>>);

/// A task, as a request names it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Task {
    pub id: String,
    /// The number of the last request of a mode.
    pub mode_request: u64,
}

impl Tasks {
    fn of(&self, robot: u32) -> Task {
        self.0.lock().get(&robot).cloned().unwrap_or_default()
    }

    fn set(&self, robot: u32, id: &str, mode_request: Option<u64>) {
        let mut tasks = self.0.lock();
        let task = tasks.entry(robot).or_default();
        task.id = id.to_owned();
        if let Some(number) = mode_request {
            task.mode_request = number;
        }
    }
}
