//! Blocks: groups of points, paths and locations.

use std::collections::BTreeMap;

use super::element::Element;
use super::{Reader, take_own};
use crate::model::tags::Tags;
use crate::model::value::shorten;
use crate::model::zones::ZoneRule;
use crate::read::file::MAX_NAME;
use crate::read::layout::{LayoutEdge, LayoutNode, LayoutZone};

/// The largest number of blocks of a point, path or location that are listed.
const MAX_BLOCKS: usize = 20;

/// The blocks of a model: groups of points, paths and locations.
#[derive(Default)]
pub(super) struct Blocks {
    pub list: Vec<Block>,
    /// The indices of the first blocks of a point, path or location.
    pub by_member: BTreeMap<String, Vec<usize>>,
}

pub(super) struct Block {
    at: u32,
    pub name: String,
    kind: String,
}

impl Blocks {
    /// Sets the zone to the first block of a member.
    pub fn tag(&self, member: &str, tags: &mut Tags) {
        let first = self.by_member.get(member).and_then(|indices| self.list.get(*indices.first()?));
        let name = first.map_or("", |block| &block.name);
        tags.zone = (!name.is_empty()).then(|| name.into());
        tags.zone = take_own(&mut tags.properties, "zone").or(tags.zone.take());
        tags.level = take_own(&mut tags.properties, "level");
    }

    /// Returns the blocks as zones; without those that have no points and no paths. `nodes` and
    /// `edges` are those of all points and paths, with their names as ids.
    pub fn zones(&self, nodes: &[LayoutNode], edges: &[LayoutEdge]) -> Vec<LayoutZone> {
        let mut zones: Vec<LayoutZone> = self.list.iter().map(Block::zone).collect();
        for (index, node) in nodes.iter().enumerate() {
            for &block in self.by_member.get(&node.id).into_iter().flatten() {
                zones[block].nodes.push(index);
            }
        }
        for (index, edge) in edges.iter().enumerate() {
            for &block in self.by_member.get(&edge.id).into_iter().flatten() {
                zones[block].edges.push(index);
            }
        }
        zones.retain(|zone| !zone.name.is_empty() && zone.nodes.len() + zone.edges.len() > 0);
        zones
    }
}

impl Block {
    /// Returns the zone without members. Models of old versions know only blocks for one vehicle.
    fn zone(&self) -> LayoutZone {
        let rule = match self.kind.as_str() {
            "SAME_DIRECTION_ONLY" => ZoneRule::SameDirection,
            _ => ZoneRule::EXCLUSIVE,
        };
        let (nodes, edges) = (Vec::new(), Vec::new());
        LayoutZone { at: self.at, name: self.name.clone(), rule, nodes, edges }
    }
}

impl Reader<'_, '_> {
    /// Takes the blocks of a model.
    pub fn blocks(&mut self, model: &mut Element<'_>) -> Blocks {
        let mut blocks = Blocks::default();
        for mut element in model.take_children("block") {
            let (name, kind) = (element.take_text("name"), element.take_text("type"));
            if name.len().max(kind.len()) > MAX_NAME {
                let message = format!(
                    "block `{}` has a name or a type of more than {MAX_NAME} bytes: shorten it",
                    shorten(&name)
                );
                self.report.file_error(element.at, message);
                continue;
            }
            for mut member in element.take_children("member") {
                let indices = blocks.by_member.entry(member.take_text("name")).or_default();
                if indices.last() == Some(&blocks.list.len()) {
                    continue;
                }
                if indices.len() < MAX_BLOCKS {
                    indices.push(blocks.list.len());
                } else {
                    self.ignored
                        .add(element.at, format!("block whose member is in {MAX_BLOCKS} others"));
                }
            }
            blocks.list.push(Block { at: element.at, name, kind });
            for property in self.properties(&mut element, "a block").into_keys() {
                self.ignored
                    .add(element.at, format!("property `{}` of a block", shorten(&property)));
            }
            element.ignore_rest("a block", &mut self.ignored);
        }
        blocks
    }
}
