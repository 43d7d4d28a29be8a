//! The load of a variant: where orders go.

use regatta_layout::model::components::Components;
use regatta_layout::{NodeIndex, Role};
use serde_json::{Value, json};

use super::{IN_TURN, Variant};
use crate::job::Manager;
use crate::plan::{PlanError, Setting};

impl Variant {
    /// Gives every robot an order to the stations of the plant, as soon as it has finished one.
    pub(super) fn make_load_up(&mut self) -> Result<(), PlanError> {
        let with_role = |role| -> Vec<NodeIndex> {
            let nodes = (0..).map(NodeIndex).zip(self.graph.nodes());
            nodes.filter(|(_, node)| node.role == role).map(|(index, _)| index).collect()
        };
        let (picks, drops) = (with_role(Role::Pick), with_role(Role::Drop));
        let stations: Vec<NodeIndex> = self
            .graph
            .stations()
            .iter()
            .flat_map(|station| station.nodes.iter().copied())
            .collect();
        let (load, words) = if !picks.is_empty() && !drops.is_empty() {
            self.check_connected(&[picks, drops].concat())?;
            (
                json!({"endless": "robots", "from": "pick", "to": "drop"}),
                "from stations to pick at to stations to drop at",
            )
        } else if stations.len() > 1 {
            self.check_connected(&stations)?;
            let ids: Vec<u32> = stations.iter().map(|node| self.graph.node(*node).id).collect();
            let load =
                json!({"groups": {"stations": ids}, "endless": "robots", "among": "stations"});
            (load, "from one station to the next")
        } else {
            (
                json!({"endless": "robots"}),
                "from one node to the next, since the layout names no stations",
            )
        };
        self.scenario["load"] = load;
        self.load = format!("each robot has an order at any time, {words}");
        self.is_load_made_up = true;
        match &mut self.manager {
            Manager::BuiltIn(args) if !args.iter().any(|arg| arg == IN_TURN) => {
                args.push(IN_TURN.to_owned())
            }
            _ => {}
        }
        Ok(())
    }

    /// Checks that all of some nodes can be reached from each other.
    fn check_connected(&self, nodes: &[NodeIndex]) -> Result<(), PlanError> {
        let components = Components::strong(&self.graph);
        let of = |node: &NodeIndex| components.of_node[node.0 as usize];
        let count = |component: u32| nodes.iter().filter(|node| of(node) == component).count();
        let most = nodes.iter().map(of).max_by_key(|component| count(*component)).unwrap_or(0);
        match nodes.iter().find(|node| of(node) != most) {
            None => Ok(()),
            Some(node) => {
                let node = self.graph.node(*node);
                let station = node
                    .name()
                    .map_or_else(|| format!("node {}", node.id), |name| format!("station {name}"));
                Err(PlanError::Unreachable { file: self.file.clone(), station })
            }
        }
    }

    pub(super) fn take_load(&mut self, value: &Value) -> Result<(), PlanError> {
        if !value.is_object() {
            let message = format!(
                "invalid load {value}: give a mapping as under `load` in a scenario, such as {{\"per_hour\": 100}}"
            );
            return Err(PlanError::setting(Setting::Load, message));
        }
        self.scenario["load"] = value.clone();
        (self.is_load_made_up, self.load) = (false, "that of the setting `load`".to_owned());
        Ok(())
    }

    pub(super) fn dwell(&mut self, value: &Value) -> Result<(), PlanError> {
        let range =
            [value, value].map(|value| value.as_f64()).into_iter().collect::<Option<Vec<f64>>>();
        let range = range.or_else(|| Some(vec![value["min"].as_f64()?, value["max"].as_f64()?]));
        if !range.is_some_and(|range| 0.0 <= range[0] && range[0] <= range[1]) {
            let message = format!(
                "invalid time {value}: give seconds, or a range such as {{\"min\": 5, \"max\": 15}}"
            );
            return Err(PlanError::setting(Setting::Dwell, message));
        }
        let load = &mut self.scenario["load"];
        match load.get_mut("generators").and_then(Value::as_array_mut) {
            Some(generators) => {
                generators.iter_mut().for_each(|generator| generator["dwell"] = value.clone())
            }
            None => load["dwell"] = value.clone(),
        }
        Ok(())
    }
}
