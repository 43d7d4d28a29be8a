//! The numbers of nodes and edges whose ids are texts.

use super::LayoutNode;
use crate::model::finding::Report;
use crate::model::value::shorten;

/// The numbers that stand for the ids of a file.
pub(super) struct Numbering {
    /// By index; `None` if they are counted from 1.
    numbers: Option<Vec<u32>>,
}

impl Numbering {
    pub fn new<'id>(
        ids: impl Iterator<Item = (u32, &'id str)> + Clone,
        kind: &str,
        report: &mut Report<'_>,
    ) -> Self {
        let numbers: Option<Vec<u32>> = ids.clone().map(|(_, id)| number(id)).collect();
        if numbers.is_none() {
            let mut sorted: Vec<(&str, usize, u32)> =
                ids.enumerate().map(|(index, (at, id))| (id, index, at)).collect();
            sorted.sort_unstable();
            let repeated =
                sorted.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1]);
            let mut repeated: Vec<_> = repeated.collect();
            repeated.sort_unstable_by_key(|&(_, index, _)| index);
            for (id, _, at) in repeated {
                let message =
                    format!("{kind} `{}` is given twice: give each a unique id", shorten(id));
                report.file_error(at, message);
            }
        }
        Self { numbers }
    }

    pub fn number(&self, index: usize) -> Number {
        match &self.numbers {
            Some(numbers) => Number { number: numbers[index], is_id: true },
            None => Number { number: index as u32 + 1, is_id: false },
        }
    }
}

/// Returns an id as a number.
fn number(id: &str) -> Option<u32> {
    let is_canonical = id == "0" || !id.starts_with(['0', '+']);
    if is_canonical { id.parse().ok() } else { None }
}

/// Finds nodes by their ids.
pub(super) enum Index<'id> {
    /// Sorted by number, with the index.
    Numbers(Vec<(u32, usize)>),
    /// Sorted by id, with the index.
    Names(Vec<(&'id str, usize)>),
}

impl<'id> Index<'id> {
    pub fn new(nodes: &'id [LayoutNode], numbering: &Numbering) -> Self {
        fn sorted<Id: Ord>(ids: impl Iterator<Item = Id>) -> Vec<(Id, usize)> {
            let mut ids: Vec<_> = ids.zip(0..).collect();
            ids.sort_unstable();
            ids
        }
        match &numbering.numbers {
            Some(numbers) => Self::Numbers(sorted(numbers.iter().copied())),
            None => Self::Names(sorted(nodes.iter().map(|node| node.id.as_str()))),
        }
    }

    pub fn find(&self, id: &str) -> Option<usize> {
        match self {
            Self::Numbers(numbers) => {
                let number = number(id)?;
                numbers.binary_search_by_key(&number, |entry| entry.0).ok().map(|at| numbers[at].1)
            }
            Self::Names(names) => {
                names.binary_search_by_key(&id, |entry| entry.0).ok().map(|at| names[at].1)
            }
        }
    }
}

/// A number of a node or an edge.
#[derive(Clone, Copy)]
pub(super) struct Number {
    pub number: u32,
    /// Whether the number is the id in the file. Otherwise the id becomes the name.
    pub is_id: bool,
}
