//! Ids that are unique in the file, even if several layouts use the same id.

use std::collections::BTreeMap;

use super::Sheet;
use super::object::{Raw, plain};

/// The ids of the nodes, edges or stations of all layouts.
pub(super) struct Ids {
    /// By id: the indices of the layouts that have it, ascending.
    homes: BTreeMap<String, Vec<usize>>,
    /// By layout: its unique name.
    prefixes: Vec<String>,
    /// By layout: whether it is read.
    is_read: Vec<bool>,
}

/// The target of an id.
pub(super) enum Target {
    /// The unique id of a target that is read, or that doesn't exist.
    Known(String),
    /// The target is in a layout that isn't read.
    Elsewhere,
}

impl Ids {
    /// Collects the values of `key` in the objects that `list` returns.
    pub fn new<'s, 'text: 's>(
        sheets: &'s [Sheet<'text>],
        key: &str,
        list: impl Fn(&'s Sheet<'text>) -> &'s [Raw<'text>],
    ) -> Self {
        let mut homes: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        // Most files have a single layout, whose ids can't clash.
        for (index, sheet) in sheets.iter().enumerate().filter(|_| sheets.len() > 1) {
            for id in list(sheet).iter().filter_map(|raw| id(raw, key)) {
                let homes = homes.entry(id).or_default();
                if homes.last() != Some(&index) {
                    homes.push(index);
                }
            }
        }
        let is_read = sheets.iter().map(|sheet| sheet.is_read).collect();
        Self { homes, prefixes: prefixes(sheets), is_read }
    }

    /// Returns the unique id for an id of a layout.
    pub fn unique(&self, id: String, layout: usize) -> String {
        let is_shared = self.homes.get(&id).is_some_and(|homes| self.read(homes).nth(1).is_some());
        if is_shared { format!("{}/{id}", self.prefixes[layout]) } else { id }
    }

    /// Looks up the target of an id in a layout: first in that layout, then in the others.
    pub fn resolve(&self, id: String, layout: usize) -> Target {
        let homes = self.homes.get(&id).map(Vec::as_slice).unwrap_or_default();
        let home = if homes.binary_search(&layout).is_ok() {
            Some(layout)
        } else {
            self.read(homes).next()
        };
        match home {
            Some(home) => Target::Known(self.unique(id, home)),
            None if homes.is_empty() => Target::Known(id),
            None => Target::Elsewhere,
        }
    }

    /// Returns the first id that several layouts have, and the number of such ids.
    pub fn shared(&self) -> Option<(&str, usize)> {
        let mut shared = self.homes.iter().filter(|(_, homes)| self.read(homes).nth(1).is_some());
        let (first, _) = shared.next()?;
        Some((first, 1 + shared.count()))
    }

    /// Returns those layouts that are read.
    fn read(&self, layouts: &[usize]) -> impl Iterator<Item = usize> {
        layouts.iter().copied().filter(|layout| self.is_read[*layout])
    }
}

fn id(raw: Raw<'_>, key: &str) -> Option<String> {
    let mut fields: BTreeMap<String, Raw<'_>> = serde_json::from_str(raw.get()).ok()?;
    plain(fields.remove(key)?)
}

/// Returns the id of each layout, with its number if that is missing or not unique.
fn prefixes(sheets: &[Sheet<'_>]) -> Vec<String> {
    let ids: Vec<&str> =
        sheets.iter().map(|sheet| sheet.names[0].as_deref().unwrap_or("layout")).collect();
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for &id in &ids {
        *counts.entry(id).or_default() += 1;
    }
    let numbered = (1..).zip(ids);
    numbered
        .map(|(number, id)| if counts[id] == 1 { id.to_owned() } else { format!("{id}#{number}") })
        .collect()
}
