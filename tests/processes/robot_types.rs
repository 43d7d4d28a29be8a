//! Orders for robot types: no other robot gets them.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use clap::Parser;
use regatta_plugin::order::OrderKind;
use regatta_plugin::{Frame, OrderReader, Participant, Plugin, ReadError, Result, World};
use regatta_run::Run;
use regatta_scenario::{Overrides, Scenario};

use crate::fleet::graphs;
use crate::study_theory::LOOP;

/// Writes down which robots got the orders that begin at some nodes, and how many each finished.
#[derive(Default)]
struct Clerk {
    log: Option<OrderReader>,
    /// The names of stations by the id of their node.
    names: BTreeMap<u32, String>,
    /// The first stop of each order.
    first: BTreeMap<u64, u32>,
    /// The robots that got orders, by the station where these begin.
    robots: BTreeMap<String, BTreeSet<u32>>,
    /// Finished orders by robot.
    finished: BTreeMap<u32, u32>,
}

impl Clerk {
    fn take(&mut self) -> Result {
        let Some(log) = &mut self.log else { return Ok(()) };
        log.take(|tick| {
            for record in tick.records {
                match record.kind() {
                    Some(OrderKind::Stop) if record.stop == 0 => {
                        self.first.insert(record.order, record.node);
                    }
                    Some(OrderKind::Assigned) => {
                        let name = &self.names[&self.first[&record.order]];
                        self.robots.entry(name.clone()).or_default().insert(record.robot);
                    }
                    Some(OrderKind::Finished) => {
                        *self.finished.entry(record.robot).or_default() += 1;
                    }
                    _ => {}
                }
            }
            Ok::<_, ReadError>(())
        })?;
        Ok(())
    }

    /// The robots that got orders which begin at stations whose name begins so.
    fn robots_of(&self, prefix: &str) -> BTreeSet<u32> {
        let stations = self.robots.iter().filter(|(name, _)| name.starts_with(prefix));
        stations.flat_map(|(_, robots)| robots.iter().copied()).collect()
    }
}

impl Plugin for Clerk {
    fn on_start(&mut self, fleet: &Participant) -> Result {
        self.log = Some(OrderReader::open_on(fleet)?);
        Ok(())
    }

    fn on_world(&mut self, world: &World<'_>) -> Result {
        let nodes = world.nodes();
        for node in nodes {
            self.names.insert(node.id, world.text(node.name).to_owned());
        }
        for other in world.other_names() {
            let id = nodes[other.node as usize].id;
            self.names.insert(id, world.text(other.name).to_owned());
        }
        Ok(())
    }

    fn on_frame(&mut self, _frame: &Frame<'_>) -> Result {
        self.take()
    }
}

/// Runs a scenario under the fleet manager for some ticks.
fn run(path: &Path, ticks: u64) -> Clerk {
    let scenario = Scenario::read(path, &Overrides::default()).expect("a scenario");
    let load = format!("--load={}", path.display());
    let words = ["fleet-manager", "--no-cache", &load];
    let manager = regatta_fleet_manager::plugin(regatta_fleet_manager::Cli::parse_from(words));
    let mut clerk = Clerk::default();
    let run = Run::new(scenario).with_named("fleet-manager", &[], manager.expect("a plugin"));
    run.with_named("clerk", &["fleet-manager"], &mut clerk).for_ticks(ticks).expect("a run");
    clerk.take().expect("readable");
    clerk
}

#[test]
fn the_shipped_scenario_has_orders_for_two_types() {
    // 20 minutes at 50 ticks a second.
    let clerk = run(&graphs("mixed.yaml"), 60_000);
    let (forklifts, amrs) = (BTreeSet::from([0, 1, 2]), BTreeSet::from([3, 4, 5, 6]));
    let pallets = clerk.robots_of("Goods in");
    assert!(!pallets.is_empty() && pallets.is_subset(&forklifts), "{pallets:?}");
    let totes = clerk.robots_of("Storage");
    assert!(!totes.is_empty() && totes.is_subset(&amrs), "{totes:?}");
    assert!(!clerk.robots_of("Working station").is_empty(), "boxes are for both types");
}

#[test]
fn a_robot_of_the_type_carries_all_orders_at_its_own_pace() {
    let folder = tempfile::tempdir().expect("a folder");
    // The loop of 40 m, and a spur where a robot of another type stands.
    let layout = LOOP.replace("\n\nfrom", "\nE,20,10,\n\nfrom") + "C,E,1\nE,C,1\n";
    std::fs::write(folder.path().join("plant.csv"), layout).expect("written");
    let scenario = "graph: plant.csv\nrate: 50\n\
         robot_types:\n- {name: amr, length: 0.9, width: 0.6}\n\
         - {name: forklift, length: 0.9, width: 0.6}\n\
         robots: [{node: \"E\", type: amr}, {node: \"B\", type: forklift}]\n\
         load: {endless: robots, from: pick, to: drop, dwell: 10, robot_types: forklift}\n";
    let path = folder.path().join("types.yaml");
    std::fs::write(&path, scenario).expect("written");
    let clerk = run(&path, 3600 * 50);
    // 40 m at 1 m/s and two stops of 10 s: 60 s an order, but for some ticks of the manager. The
    // first one begins 30 m before the pick, and takes 70 s.
    let finished: Vec<(u32, u32)> = clerk.finished.into_iter().collect();
    let [(1, orders)] = finished[..] else { panic!("robot 1 alone: {finished:?}") };
    assert!((58..=60).contains(&orders), "{orders} orders in an hour");
}
