//! Variants with a relief.

use regatta_layout::{EdgeChange, RouteGraph};
use serde_json::{Number, Value, json};

use super::load::{self, Labels};
use super::roads::CLEARANCE;
use super::{Candidate, FASTER, FASTER_REPAIR, FASTER_ROBOTS, Remedy, stops, track};
use crate::plan::Variant;

impl Candidate {
    /// Returns a variant with the change; `None` if it isn't possible there, or if orders would go
    /// elsewhere.
    pub fn applied(&self, variant: &Variant) -> Option<Variant> {
        let mut relieved = variant.clone();
        relieved.name = format!("with {}", self.words);
        match &self.remedy {
            Remedy::Operator(nodes) => of_station(&mut relieved, *nodes.first()?, &self.remedy)?,
            Remedy::Buffer(node) => of_station(&mut relieved, *node, &self.remedy)?,
            Remedy::Place(node) => add_place(&mut relieved, *node)?,
            Remedy::Queue(node) => add_queue(&mut relieved, *node)?,
            Remedy::Charger(node) => {
                let (graph, _) = stops::with_place(relieved.whole(), *node, size(variant))?;
                relieved.set_whole(graph).ok()?;
            }
            Remedy::SecondTrack(nodes) => {
                let graph = track::with_second_track(relieved.whole(), nodes, variant.max_width())?;
                relieved.set_whole(graph).ok()?;
            }
            Remedy::PassingPlace(edges) => {
                let graph = track::with_passing_place(relieved.whole(), *edges, size(variant))?;
                relieved.set_whole(graph).ok()?;
            }
            Remedy::Reversed(edges) => relieved.change(edges, EdgeChange::Reverse).ok()?,
            Remedy::UsualSpeed { edges, speed } => {
                relieved.change(edges, EdgeChange::AtLeast(*speed)).ok()?;
            }
            Remedy::Faster(edges) => relieved.change(edges, EdgeChange::Speed(FASTER)).ok()?,
            Remedy::Second(edge) => {
                let metres = variant.max_width() + CLEARANCE;
                relieved.change(&[*edge], EdgeChange::Double(metres)).ok()?;
            }
            Remedy::FasterRobots => faster_robots(&mut relieved)?,
            Remedy::Repair => faster_repair(&mut relieved)?,
        }
        // Fewer stops would be less work.
        (relieved.left_out == variant.left_out && relieved.other_stops == variant.other_stops)
            .then_some(relieved)
    }
}

/// The length and the width of the robots, in metres.
fn size(variant: &Variant) -> [f64; 2] {
    [variant.max_length(), variant.max_width()]
}

fn labels(variant: &Variant, node: u32) -> Option<Labels> {
    let graph: &RouteGraph = &variant.graph;
    Some(Labels::of(variant.load_entry()?, graph, graph.node_by_id(node)?))
}

fn of_station(variant: &mut Variant, node: u32, remedy: &Remedy) -> Option<()> {
    let labels = labels(variant, node)?;
    let load = variant.load_entry_mut()?;
    let index = load::entry(load, &labels)?.index();
    load::change(load, index, remedy)
}

fn add_place(variant: &mut Variant, node: u32) -> Option<()> {
    // The orders of a day name their stops one by one.
    if variant.is_day() {
        return None;
    }
    let labels = labels(variant, node)?;
    let (graph, place) = stops::with_place(variant.whole(), node, size(variant))?;
    if !variant.is_load_made_up() && !load::add_place(variant.load_entry_mut()?, &labels, place) {
        return None;
    }
    variant.set_whole(graph).ok()
}

fn add_queue(variant: &mut Variant, node: u32) -> Option<()> {
    let labels = labels(variant, node)?;
    let (graph, places) = stops::with_queue(variant.whole(), node, size(variant))?;
    variant.set_whole(graph).ok()?;
    load::add_queue(variant.load_entry_mut()?, &labels, &places)
}

/// Raises the speed of all robots, and their power while they drive: a metre takes the same energy.
fn faster_robots(variant: &mut Variant) -> Option<()> {
    for kind in variant.robot_types_mut()? {
        let speed = kind.max_speed()? * FASTER_ROBOTS;
        kind.max_speed = Number::from_f64(speed);
        let battery = kind.rest.get_mut("battery").and_then(Value::as_object_mut);
        if let Some(watts) = battery.and_then(|battery| battery.get_mut("drain_moving")) {
            *watts = json!(watts.as_f64()? * FASTER_ROBOTS);
        }
    }
    Some(())
}

fn faster_repair(variant: &mut Variant) -> Option<()> {
    let breakdowns = variant.breakdowns_mut()?;
    let secs = breakdowns.repair_secs.as_ref()?.as_f64()? * FASTER_REPAIR;
    breakdowns.repair_secs = Number::from_f64(secs);
    Some(())
}
