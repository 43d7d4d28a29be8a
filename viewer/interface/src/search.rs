//! The search for places and orders by a text.

use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Id, Ui};
use regatta_plugin::World;
use regatta_scene::stations::{is_station, served};

use super::context::{PanelContext, Request};
use super::style;
use super::view_model::Item;
use crate::text::with_plural;

/// The largest number of places that are listed.
const SUGGESTED: usize = 12;

/// Something that is found by a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// A node or an edge.
    Place(Item),
    /// A transport order, by its number.
    Order(u64),
}

/// Finds a place by `n12` or `e12`, as commands do, or by the name of a node, a station or an edge,
/// and an order by `o12`. Whole words stand for the letters: `node 12`.
pub(super) fn find(world: &World<'_>, text: &str) -> Option<Found> {
    let text = text.trim();
    by_number(world, text).or_else(|| by_name(world, text).map(Found::Place))
}

fn by_number(world: &World<'_>, text: &str) -> Option<Found> {
    let digits = text.find(|letter: char| letter.is_ascii_digit())?;
    let (kind, number) = text.split_at(digits);
    let number: u64 = number.parse().ok()?;
    match kind.trim_end() {
        "n" | "node" => index(world.nodes().iter().map(|node| node.id), number).map(Item::Node),
        "e" | "edge" => index(world.edges().iter().map(|edge| edge.id), number).map(Item::Edge),
        "o" | "order" => return Some(Found::Order(number)),
        _ => None,
    }
    .map(Found::Place)
}

fn index(mut ids: impl Iterator<Item = u32>, number: u64) -> Option<u32> {
    ids.position(|id| u64::from(id) == number).map(|index| index as u32)
}

/// Finds a name, whatever the case of its letters: one that is equal, or else one that begins so,
/// or else one that contains the text.
fn by_name(world: &World<'_>, text: &str) -> Option<Item> {
    let mut found = places(world, text);
    found.sort_by_key(|place| place.fit);
    found.first().map(|place| place.item)
}

/// The degree to which a name fits a text, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fit {
    Equal,
    Beginning,
    Part,
}

/// A place whose name fits a text.
#[derive(Clone, Debug)]
struct NamedPlace {
    item: Item,
    kind: &'static str,
    name: String,
    fit: Fit,
}

/// Returns the nodes, stations and edges whose names contain a text, whatever the case of its
/// letters.
fn places(world: &World<'_>, text: &str) -> Vec<NamedPlace> {
    let wanted = text.trim().to_lowercase();
    if wanted.is_empty() {
        return Vec::new();
    }
    let served = served(world);
    let nodes = (0..).zip(world.nodes()).map(|(index, node)| {
        let kind = if is_station(node, index, &served) { "station" } else { "node" };
        (Item::Node(index), kind, node.name)
    });
    let stations = world.other_names().iter();
    let stations = stations.map(|other| (Item::Node(other.node), "station", other.name));
    let edges = (0..).zip(world.edges());
    let edges = edges.map(|(index, edge)| (Item::Edge(index), "edge", edge.name));
    let named = nodes.chain(stations).chain(edges).filter_map(|(item, kind, name)| {
        let name = world.text(name);
        let lower = name.to_lowercase();
        let fit = match lower.find(&wanted)? {
            0 if lower == wanted => Fit::Equal,
            0 => Fit::Beginning,
            _ => Fit::Part,
        };
        Some(NamedPlace { item, kind, name: name.to_owned(), fit })
    });
    named.collect()
}

/// The places whose names contain the text of the search, which are shown where no robot matches.
#[derive(Clone, Debug, Default)]
pub(super) struct Suggestions {
    /// The text, and the number of nodes of the world in which places were looked up.
    of: (String, usize),
    places: Vec<NamedPlace>,
}

impl Suggestions {
    /// Shows the places, or what to do instead. Returns the one that was clicked.
    pub fn show(&mut self, context: &PanelContext<'_>, text: &str, ui: &mut Ui) -> Option<Found> {
        let world = &context.model.world;
        let wanted = (text.to_owned(), world.nodes().len());
        if self.of != wanted {
            (self.of, self.places) = (wanted, places(world, text));
            self.places.sort_by(|a, b| (a.fit, &a.name).cmp(&(b.fit, &b.name)));
        }
        let number = by_number(world, text.trim());
        ui.label(style::faint(ui, told(number, self.places.len())));
        let mut clicked = None;
        for place in self.places.iter().take(SUGGESTED) {
            if ui.link(format!("{} {}", place.kind, place.name)).clicked() {
                clicked = Some(Found::Place(place.item));
            }
        }
        clicked
    }
}

/// Returns what matches a search that no robot matches, as a text.
fn told(number: Option<Found>, places: usize) -> String {
    match (number, places) {
        (Some(Found::Order(_)), _) => {
            "No robot matches. Press Enter to see the robot with this order.".to_owned()
        }
        (Some(Found::Place(_)), _) => "No robot matches. Press Enter to go there.".to_owned(),
        (None, 0) => {
            "No robot and no place matches. Press Enter to look for an order of this name."
                .to_owned()
        }
        (None, count) if count > SUGGESTED => {
            format!(
                "No robot matches. The first {SUGGESTED} of {} are:",
                with_plural(count as u64, "place")
            )
        }
        (None, _) => "No robot matches. Places with this name are:".to_owned(),
    }
}

/// Selects something, and flies there.
pub(super) fn go_to(context: &PanelContext<'_>, item: Item) {
    context.ask(Request::Select(Some(item)));
    context.ask(Request::FlyToSelected);
}

/// Selects the text of a field, so that the next letter replaces it.
pub(super) fn select_all(ui: &Ui, field: Id, text: &str) {
    let mut state = TextEditState::load(ui.ctx(), field).unwrap_or_default();
    let end = CCursor::new(text.chars().count());
    state.cursor.set_char_range(Some(CCursorRange::two(CCursor::default(), end)));
    state.store(ui.ctx(), field);
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, Role, WorldData};

    use super::*;

    #[test]
    fn places_are_found_by_number_and_by_name_and_orders_by_number() {
        let mut world = WorldData::default();
        let (dock, ramp) = (world.texts.add("Dock 12"), world.texts.add("ramp"));
        world.nodes = vec![
            NodeRecord { id: 7, ..NodeRecord::default() },
            NodeRecord { id: 9, name: dock, role: Role::Drop as u32, ..NodeRecord::default() },
        ];
        let edge = EdgeRecord { id: 9, name: ramp, ..EdgeRecord::default() };
        world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [4.0, 0.0])]);
        let view = world.view(1, 1);
        for (text, found) in [
            ("n7", Some(Found::Place(Item::Node(0)))),
            (" e9 ", Some(Found::Place(Item::Edge(0)))),
            ("dock 12", Some(Found::Place(Item::Node(1)))),
            ("DOCK", Some(Found::Place(Item::Node(1)))),
            ("ock 1", Some(Found::Place(Item::Node(1)))),
            ("ramp", Some(Found::Place(Item::Edge(0)))),
            ("o123", Some(Found::Order(123))),
            ("node 7", Some(Found::Place(Item::Node(0)))),
            ("edge 9", Some(Found::Place(Item::Edge(0)))),
            ("order 123", Some(Found::Order(123))),
            ("n8", None),
            ("e", None),
            ("", None),
            ("ü", None),
        ] {
            assert_eq!(find(&view, text), found, "{text}");
        }
        let kinds: Vec<_> = places(&view, "d").iter().map(|place| place.kind).collect();
        assert_eq!(kinds, ["station"], "Dock 12 has a role");
    }
}
