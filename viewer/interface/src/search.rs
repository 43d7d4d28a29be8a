//! The search for places and orders by a text.

use regatta_plugin::World;

use super::view_model::Item;

/// Something that is found by a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// A node or an edge.
    Place(Item),
    /// A transport order, by its number.
    Order(u64),
}

/// Finds a place by `n12` or `e12`, as labels have it, or by the name of a node, a station or an
/// edge, and an order by `o12`.
pub(super) fn find(world: &World<'_>, text: &str) -> Option<Found> {
    let text = text.trim();
    by_number(world, text).or_else(|| by_name(world, text).map(Found::Place))
}

fn by_number(world: &World<'_>, text: &str) -> Option<Found> {
    let (kind, number) = text.split_at_checked(1)?;
    let number: u64 = number.parse().ok()?;
    match kind {
        "n" => index(world.nodes().iter().map(|node| node.id), number).map(Item::Node),
        "e" => index(world.edges().iter().map(|edge| edge.id), number).map(Item::Edge),
        "o" => return Some(Found::Order(number)),
        _ => None,
    }
    .map(Found::Place)
}

fn index(mut ids: impl Iterator<Item = u32>, number: u64) -> Option<u32> {
    ids.position(|id| u64::from(id) == number).map(|index| index as u32)
}

/// Finds a name, whatever the case of its letters: one that is equal, or else one that begins so.
fn by_name(world: &World<'_>, text: &str) -> Option<Item> {
    if text.is_empty() {
        return None;
    }
    let nodes = (0..).zip(world.nodes()).map(|(index, node)| (Item::Node(index), node.name));
    let stations = world.other_names().iter().map(|other| (Item::Node(other.node), other.name));
    let edges = (0..).zip(world.edges()).map(|(index, edge)| (Item::Edge(index), edge.name));
    let wanted = text.to_lowercase();
    let mut beginning = None;
    for (item, name) in nodes.chain(stations).chain(edges) {
        let name = world.text(name).to_lowercase();
        if name == wanted {
            return Some(item);
        }
        if beginning.is_none() && name.starts_with(&wanted) {
            beginning = Some(item);
        }
    }
    beginning
}

#[cfg(test)]
mod tests {
    use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};

    use super::*;

    #[test]
    fn places_are_found_by_number_and_by_name_and_orders_by_number() {
        let mut world = WorldData::default();
        let (dock, ramp) = (world.texts.add("Dock 12"), world.texts.add("ramp"));
        world.nodes = vec![
            NodeRecord { id: 7, ..NodeRecord::default() },
            NodeRecord { id: 9, name: dock, ..NodeRecord::default() },
        ];
        let edge = EdgeRecord { id: 9, name: ramp, ..EdgeRecord::default() };
        world.add_edge(edge, [CurveRecord::straight([0.0, 0.0], [4.0, 0.0])]);
        let view = world.view(1, 1);
        for (text, found) in [
            ("n7", Some(Found::Place(Item::Node(0)))),
            (" e9 ", Some(Found::Place(Item::Edge(0)))),
            ("dock 12", Some(Found::Place(Item::Node(1)))),
            ("DOCK", Some(Found::Place(Item::Node(1)))),
            ("ramp", Some(Found::Place(Item::Edge(0)))),
            ("o123", Some(Found::Order(123))),
            ("n8", None),
            ("e", None),
            ("", None),
            ("ü", None),
        ] {
            assert_eq!(find(&view, text), found, "{text}");
        }
    }
}
