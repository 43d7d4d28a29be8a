//! The stops of a generator's orders.

use regatta_base::random::Random;
use regatta_base::yaml::{self, Fields, Node};
use regatta_plugin::world::Role;

use super::arrival::Arrival;
use super::groups::Groups;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Stops {
    /// A node of the group.
    One(Vec<u32>),
    /// A pick, stops between, and a drop.
    Transport(Transport),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Transport {
    /// At least one.
    pub(crate) flows: Vec<Flow>,
    /// The groups of the stops between.
    pub(crate) via: Vec<Vec<u32>>,
}

/// Orders from a node of one group to another node of a second one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Flow {
    pub(crate) from: Vec<u32>,
    pub(crate) to: Vec<u32>,
    /// Its share of all orders, relative to that of the other flows; above 0.
    share: f64,
}

impl Transport {
    /// Returns a flow, each as often as its share says.
    pub(crate) fn flow(&self, random: Random, draw: u64) -> &Flow {
        let mut rest = random.unit(draw) * self.flows.iter().map(|flow| flow.share).sum::<f64>();
        let chosen = self.flows.iter().position(|flow| {
            rest -= flow.share;
            rest <= 0.0
        });
        // Rounding has left nothing for the last one.
        &self.flows[chosen.unwrap_or(self.flows.len() - 1)]
    }
}

impl Stops {
    pub(super) fn read(
        value: &Node,
        fields: &Fields<'_, '_>,
        arrival: &Arrival,
        groups: &Groups<'_>,
    ) -> Result<Self, yaml::Error> {
        let has_two = ["from", "to", "flows", "via"].iter().any(|key| fields.get(key).is_some());
        if matches!(arrival, Arrival::Endless(_)) && !has_two {
            return Ok(Self::One(groups.find_nodes(fields.get("among"))?));
        }
        if fields.get("among").is_some() {
            return Err(value.error(
                "`among` is for an endless load of orders with one stop, without `from` and `to`",
            ));
        }
        let flows = match fields.get("flows") {
            None => vec![flow(value, fields, groups, 1.0)?],
            Some(_) if fields.get("from").is_some() || fields.get("to").is_some() => {
                return Err(value.error("give either `flows`, or `from` and `to`, not both"));
            }
            Some(list) => flows(list, groups)?,
        };
        let mut via = Vec::new();
        if let Some(list) = fields.get("via") {
            for group in list.list()? {
                via.push(groups.find_nodes(Some(group))?);
            }
        }
        Ok(Self::Transport(Transport { flows, via }))
    }

    /// The nodes of all stops, and those at which orders end.
    pub(crate) fn nodes(&self) -> (Vec<u32>, Vec<u32>) {
        let transport = match self {
            Self::One(among) => return (among.clone(), among.clone()),
            Self::Transport(transport) => transport,
        };
        let last: Vec<u32> = transport.flows.iter().flat_map(|flow| flow.to.clone()).collect();
        let first = transport.flows.iter().flat_map(|flow| flow.from.clone());
        let between = transport.via.iter().flatten().copied();
        (first.chain(between).chain(last.clone()).collect(), last)
    }
}

fn flows(list: &Node, groups: &Groups<'_>) -> Result<Vec<Flow>, yaml::Error> {
    let mut flows = Vec::new();
    for entry in list.list()? {
        let fields = entry.fields(&["from", "to", "share"])?;
        let share = fields.optional("share", Node::non_negative)?.unwrap_or(1.0);
        flows.push(flow(entry, &fields, groups, share)?);
    }
    flows.retain(|flow: &Flow| flow.share > 0.0);
    if flows.is_empty() {
        return Err(list.error("no flow has a share above 0"));
    }
    Ok(flows)
}

fn flow(
    value: &Node,
    fields: &Fields<'_, '_>,
    groups: &Groups<'_>,
    share: f64,
) -> Result<Flow, yaml::Error> {
    let from = groups.find(fields.get("from"), Role::Pick)?;
    let to = groups.find(fields.get("to"), Role::Drop)?;
    if from.len() == 1 && from == to {
        return Err(value.error("`from` and `to` are the same single node"));
    }
    Ok(Flow { from, to, share })
}
