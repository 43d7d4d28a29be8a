//! The plan round robots that made no progress, as SVG: who waits for whom.

use std::collections::BTreeMap;

use glam::DVec2;
use regatta_base::svg::Svg;
use regatta_layout::{Apart, RouteGraph};

use super::plan::Plan;
use crate::outcome::Stall;

/// Metres of roads that are shown round the robots.
const AROUND: f64 = 3.0;
/// The least width and height of the plan, in metres.
const LEAST: DVec2 = DVec2::new(24.0, 9.0);
/// The radius of a robot in pixels.
const RADIUS: f64 = 12.0;
/// The most nodes whose names are drawn.
const MOST_NAMES: usize = 60;
/// The length and half of the width of an arrow's head, in pixels.
const HEAD: DVec2 = DVec2::new(9.0, 4.5);
const ROADS: &str = "#c3cad2";
const STANDS: &str = "#d55e00";
const OTHER: &str = "#5a6875";
const ARROW: &str = "#1d2733";

/// Returns the plan round the robots of a stall: those that made no progress in orange, others that
/// they waited for in grey, and an arrow from each to the robot that it waited for. `None` if it
/// isn't known where they were.
pub fn stall_map(graph: &RouteGraph, stall: &Stall) -> Option<String> {
    if stall.places.is_empty() {
        return None;
    }
    let apart = Apart::new(graph);
    let places = places(graph, &apart, stall);
    let around = [DVec2::splat(-AROUND), DVec2::splat(AROUND)];
    let points = places.values().flat_map(|centre| around.map(|offset| *centre + offset));
    let plan = Plan::of_part(points, LEAST);
    let mut svg = Svg::new(0);
    svg.document(plan.size, "").set("font-family", "sans-serif").set("font-size", 12).open();
    svg.decimals = 1;
    svg.background("#fff");
    plan.draw_levels(&mut svg, &apart.levels);
    plan.draw_background(&mut svg, &apart.graph);
    let roads = apart.graph.edges().iter().map(|edge| plan.curves(edge));
    svg.element("path").fill("none").stroke(ROADS, 2).curves(roads);
    plan.draw_facilities(&mut svg, &apart);
    draw_nodes(&mut svg, &apart.graph, &plan);
    draw_robots(&mut svg, stall, &places, &plan);
    Some(svg.finish())
}

/// Returns the places of the robots of a stall on a graph whose levels lie apart.
fn places(graph: &RouteGraph, apart: &Apart<'_>, stall: &Stall) -> BTreeMap<u32, DVec2> {
    let mut places = BTreeMap::new();
    for (robot, [x, y]) in &stall.places {
        let edge = stall.edges.get(robot).and_then(|edge| graph.edge_by_id(*edge));
        let moved = edge.map_or(DVec2::ZERO, |edge| {
            apart.graph.edge(edge).path.start() - graph.edge(edge).path.start()
        });
        places.insert(*robot, DVec2::new((*x).into(), (*y).into()) + moved);
    }
    places
}

/// Draws robots with their numbers, and the arrows between them.
fn draw_robots(svg: &mut Svg, stall: &Stall, places: &BTreeMap<u32, DVec2>, plan: &Plan) {
    for (robot, place) in places {
        let at = plan.pixel(*place);
        let colour = if stall.robots.contains(robot) { STANDS } else { OTHER };
        svg.circle(at, RADIUS).fill(colour).stroke("#fff", 1.5);
        let text = svg.text(at + DVec2::new(0.0, 4.5)).set("text-anchor", "middle");
        text.fill("#fff").content(robot);
    }
    for (robot, other) in &stall.waits_for {
        if let (Some(from), Some(to)) = (places.get(robot), places.get(other)) {
            arrow(svg, plan.pixel(*from), plan.pixel(*to));
        }
    }
}

/// Draws the nodes on the plan, with their names or ids unless there are too many.
fn draw_nodes(svg: &mut Svg, graph: &RouteGraph, plan: &Plan) {
    let nodes = graph.nodes().iter().map(|node| (plan.pixel(node.position), node));
    let nodes: Vec<_> = nodes.filter(|(at, _)| plan.contains(*at)).collect();
    let has_names = nodes.len() <= MOST_NAMES;
    for (at, node) in nodes {
        svg.circle(at, 2.5).fill(OTHER);
        if has_names {
            let text = svg.text(at + DVec2::new(0.0, -RADIUS - 4.0)).set("text-anchor", "middle");
            let text = text.fill(OTHER);
            match node.name() {
                Some(name) => text.content(name),
                None => text.content(node.id),
            }
        }
    }
}

/// Draws an arrow from the rim of a robot to that of another one.
fn arrow(svg: &mut Svg, from: DVec2, to: DVec2) {
    let Some(along) = (to - from).try_normalize() else { return };
    // Two robots that wait for each other have an arrow each, side by side.
    let aside = along.perp() * HEAD.y;
    let (from, to) = (from + along * RADIUS + aside, to - along * RADIUS + aside);
    let neck = to - along * HEAD.x;
    svg.line(from, neck).stroke(ARROW, 2);
    let head = [to, neck + along.perp() * HEAD.y, neck - along.perp() * HEAD.y];
    svg.element("polygon").fill(ARROW).points(head);
}

#[cfg(test)]
mod tests {
    use regatta_layout::{ReadOptions, parse};

    use super::*;
    use crate::outcome::StallKind;

    #[test]
    fn robots_and_the_ones_that_they_wait_for_are_drawn() {
        let text = "id,x,y\nA,0,0\nB,10,0\n\nfrom,to\nA,B\nB,A\n";
        let graph = parse(text, "t.csv", &ReadOptions::default()).expect("a graph").0;
        let mut stall = Stall {
            kind: StallKind::Standstill,
            from_secs: 60.0,
            until_secs: None,
            robots: vec![0, 3],
            place: None,
            seen_secs: None,
            waits_for: BTreeMap::from([(0, 7), (3, 0)]),
            places: BTreeMap::from([(0, [2.0, 0.0]), (3, [4.0, 0.0]), (7, [0.0, 0.0])]),
            edges: BTreeMap::new(),
            out_of_service: Vec::new(),
        };
        let svg = stall_map(&graph, &stall).expect("a picture");
        let count = |part: &str| svg.matches(part).count();
        assert_eq!((count("<circle"), count("<polygon"), count("<line")), (5, 2, 2), "{svg}");
        assert_eq!(count(STANDS), 2, "{svg}");
        assert!([">0<", ">3<", ">7<"].iter().all(|robot| svg.contains(robot)), "{svg}");
        stall.places.clear();
        assert_eq!(stall_map(&graph, &stall), None);
    }

    #[test]
    fn robots_above_each_other_stand_on_their_levels() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs");
        let text =
            std::fs::read_to_string(folder.join("two-levels.yaml")).expect("a shipped plant");
        let graph = parse(&text, "g.yaml", &ReadOptions::default()).expect("a graph").0;
        let stall = Stall {
            kind: StallKind::Standstill,
            from_secs: 60.0,
            until_secs: None,
            robots: vec![0, 1],
            place: None,
            seen_secs: None,
            waits_for: BTreeMap::new(),
            places: BTreeMap::from([(0, [22.0, 4.0]), (1, [22.0, 4.0])]),
            edges: BTreeMap::from([(0, 10), (1, 15)]),
            out_of_service: Vec::new(),
        };
        let places = places(&graph, &Apart::new(&graph), &stall);
        assert!(places[&0].distance(places[&1]) > 10.0, "{places:?}");
        let svg = stall_map(&graph, &stall).expect("a picture");
        assert!(svg.contains(">ground</text>") && svg.contains(">upper</text>"), "{svg}");
    }
}
