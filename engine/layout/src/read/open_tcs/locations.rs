//! Locations of a plant model: stations, whose roles follow from the names of their operations.

use std::collections::BTreeMap;

use super::element::Element;
use super::{Blocks, Properties, Reader, take_own};
use crate::model::tags::{Role, Tags};
use crate::read::layout::LayoutStation;

/// The first words of operations, by role, as in `Load cargo` or `unload_cargo`.
const WORDS: [(Role, &[&str]); 4] = [
    (Role::Charge, &["charge", "charging", "recharge"]),
    (Role::Pick, &["load", "pick", "collect", "fetch", "take", "get"]),
    (Role::Drop, &["unload", "drop", "deliver", "deposit", "put", "place"]),
    (Role::Park, &["park"]),
];

/// The largest number of bytes that all locations inherit from their types. Large types could take
/// much memory, once for each of their locations.
const MAX_INHERITED: usize = 16 << 20;

/// The attribute of a location to which no transport order may lead.
const LOCKED: &str = "locked";

/// The overhead of a text in bytes.
const BYTES_PER_TEXT: usize = 64;

/// A type of locations.
#[derive(Default)]
struct LocationType {
    operations: Vec<String>,
    peripheral_operations: Vec<String>,
    properties: Properties,
    /// The memory that each location of the type takes.
    bytes: usize,
}

impl Reader<'_, '_> {
    pub(super) fn stations(
        &mut self,
        model: &mut Element<'_>,
        blocks: &Blocks,
    ) -> Vec<LayoutStation> {
        let types: BTreeMap<_, _> = model
            .take_children("locationType")
            .into_iter()
            .map(|element| self.location_type(element))
            .collect();
        let locations = model.take_children("location").into_iter();
        let stations = locations.map(|element| self.station(element, &types, blocks)).collect();
        let locked = std::mem::take(&mut self.locked);
        self.report_all(
            "location",
            &locked,
            "locked: no role, so that no generated order goes there",
        );
        stations
    }

    fn location_type(&mut self, mut element: Element<'_>) -> (String, LocationType) {
        let name = element.take_text("name");
        let operations = ["allowedOperation", "allowedPeripheralOperation"]
            .map(|kind| operations(&mut element, kind));
        let properties = self.properties(&mut element, "a location type");
        let texts = operations.iter().flatten().map(String::len);
        let texts = texts.chain(properties.iter().map(|(key, value)| key.len() + value.len()));
        let bytes = texts.map(|length| length + BYTES_PER_TEXT).sum();
        let [operations, peripheral_operations] = operations;
        let kind = LocationType { operations, peripheral_operations, properties, bytes };
        element.ignore_rest("a location type", &mut self.ignored);
        (name, kind)
    }

    fn station(
        &mut self,
        mut element: Element<'_>,
        types: &BTreeMap<String, LocationType>,
        blocks: &Blocks,
    ) -> LayoutStation {
        let at = element.at;
        let name = element.take_text("name");
        let has_position = element.get("positionX").or(element.get("xPosition")).is_some();
        let position = match has_position {
            true => self.position(&mut element, &format!("location `{name}`")),
            false => None,
        };
        let kind_name = element.take_text("type");
        let kind = types.get(&kind_name).filter(|kind| self.inherits(kind, at));
        let (nodes, linked) = self.links(&mut element, kind);
        let mut tags = self.tags(&mut element, "a location");
        let is_locked = matches!(element.take(&[LOCKED]).as_deref(), Some("true" | "1"));
        self.rest(element, "a location", &mut tags);
        if is_locked {
            tags.set(LOCKED, "true");
            self.locked.push((at, name.clone()));
        }
        tags.set("type", &kind_name);
        tags.set("operations", &linked.join(", "));
        tags.set(
            "peripheralOperations",
            &kind.map_or(String::new(), |kind| kind.peripheral_operations.join(", ")),
        );
        for (key, value) in kind.iter().flat_map(|kind| &kind.properties) {
            tags.properties.entry(key.clone()).or_insert_with(|| value.clone());
        }
        let mut block = Tags::default();
        blocks.tag(&name, &mut block);
        tags.set("block", block.zone.as_deref().unwrap_or_default());
        if block.zone.is_some() {
            self.ignored.add(at, "location that is a member of a block: no robot drives on it");
        }
        let name = take_own(&mut tags.properties, "name").map_or(name, Into::into);
        LayoutStation {
            at,
            name,
            // No transport order may lead to a locked location.
            role: if is_locked { Role::None } else { role(&linked) },
            nodes,
            position,
            properties: tags.properties,
        }
    }

    /// Whether a location at a byte offset inherits the properties of its type, within the limit of
    /// all locations.
    fn inherits(&mut self, kind: &LocationType, at: u32) -> bool {
        self.inherited = self.inherited.saturating_add(kind.bytes);
        if self.inherited > MAX_INHERITED {
            self.ignored
                .add(at, "type of a location, since there are too many large types and locations");
        }
        self.inherited <= MAX_INHERITED
    }

    /// Returns the linked points, and the operations that are possible at one of them or more.
    fn links(
        &mut self,
        element: &mut Element<'_>,
        kind: Option<&LocationType>,
    ) -> (Vec<String>, Vec<String>) {
        let all = kind.map(|kind| kind.operations.as_slice()).unwrap_or_default();
        let links = element.take_children("link");
        let (mut nodes, mut allowed) = (Vec::new(), Vec::new());
        let mut allows_all = links.is_empty();
        for mut link in links {
            nodes.push(link.take_text("point"));
            let here = operations(&mut link, "allowedOperation");
            if !here.is_empty() && (!all.iter().all(|name| here.contains(name))) {
                self.ignored.add(link.at, "operations of a link alone: all links have them");
            }
            // A link without operations allows all operations of the type.
            allows_all |= here.is_empty();
            allowed.extend(here);
            link.ignore_rest("a link", &mut self.ignored);
        }
        allowed.extend(all.iter().filter(|_| allows_all).cloned());
        allowed.sort();
        allowed.dedup();
        (nodes, allowed)
    }
}

fn operations(element: &mut Element<'_>, name: &str) -> Vec<String> {
    element.take_children(name).iter_mut().map(|operation| operation.take_text("name")).collect()
}

/// Returns the role of the operations; of several roles, the first in [`WORDS`], but
/// [`Role::Transfer`] if loads are picked up and dropped.
pub(super) fn role(operations: &[String]) -> Role {
    let named = WORDS.into_iter().filter(|(_, starts)| {
        operations.iter().any(|operation| has_word(&operation.to_lowercase(), starts))
    });
    named.fold(Role::None, |role, (other, _)| role.and(other))
}

/// Whether a word of an operation begins in one of some ways.
fn has_word(operation: &str, starts: &[&str]) -> bool {
    let mut words = operation.split(|letter: char| !letter.is_alphanumeric());
    words.any(|word| starts.iter().any(|start| word.starts_with(start)))
}
