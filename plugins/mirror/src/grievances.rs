//! Faults in messages of peers: all are counted, and the first of each kind is told.

use std::collections::HashSet;
use std::mem::{Discriminant, discriminant};

use crate::wire::WireError;

/// The faults that were told already.
#[derive(Debug, Default)]
pub struct Grievances {
    told: HashSet<(&'static str, Discriminant<WireError>)>,
    /// The number of faults.
    pub count: u64,
}

impl Grievances {
    /// Counts a fault of a message, and tells the user about the first of its kind.
    pub fn note(&mut self, what: &'static str, error: WireError) {
        self.count += 1;
        if self.told.insert((what, discriminant(&error))) {
            regatta_plugin::tell!("mirror: {what} of the other host is ignored: {error}");
        }
    }

    /// Returns the content of a message, or notes its fault.
    pub fn accept<T>(&mut self, what: &'static str, parsed: Result<T, WireError>) -> Option<T> {
        match parsed {
            Ok(content) => Some(content),
            Err(error) => {
                self.note(what, error);
                None
            }
        }
    }
}
