//! What a file says that isn't understood: reported once per kind, with the number of times.

use std::collections::BTreeMap;

use crate::graph::finding::{Report, Subject};

/// The largest number of kinds that are told apart.
const MAX_KINDS: usize = 100;

/// Kinds of things that a reader doesn't understand.
#[derive(Debug, Default)]
pub(in crate::graph) struct Ignored {
    /// The byte offset of the first, and the number of all.
    kinds: BTreeMap<String, (u32, usize)>,
}

impl Ignored {
    /// Counts a thing of a kind, such as "key `foo` of a node".
    pub fn add(&mut self, at: u32, kind: impl Into<String>) {
        let kind = kind.into();
        if let Some((_, count)) = self.kinds.get_mut(&kind) {
            *count += 1;
        } else if self.kinds.len() < MAX_KINDS {
            self.kinds.insert(kind, (at, 1));
        }
    }

    /// Reports a warning for each kind.
    pub fn report(self, report: &mut Report<'_>) {
        for (kind, (at, count)) in self.kinds {
            let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
            report.warning(at, Subject::File, format!("{kind}: not used{times}"));
        }
    }
}
