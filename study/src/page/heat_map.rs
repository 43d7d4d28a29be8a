//! The plan with the edges where robots wait, as SVG.

use glam::DVec2;
use regatta_base::svg::Svg;
use regatta_layout::{Apart, RouteGraph};

use super::plan::{MARGIN, Plan};
use crate::bottleneck::Bottleneck;
use crate::outcome::EdgeOutcome;

/// The height of the legend below the plan, and the least width of the picture, for the legend.
const LEGEND: f64 = 46.0;
const LEGEND_WIDTH: f64 = 920.0;
/// The ramp from little to much: viridis from its green end, by eighths (BSD 2-clause, matplotlib),
/// dark for much, on white.
const RAMP: [&str; 6] = ["#c2df23", "#51c56a", "#1e9b8a", "#2d708e", "#433e85", "#440154"];
/// The number of bottlenecks with a mark.
const MARKED: usize = 5;

/// Returns the plan: edges by the mean number of robots that wait there, and the worst places with
/// their ranks.
pub fn heat_map(
    graph: &RouteGraph,
    edges: &[EdgeOutcome],
    bottlenecks: &[Bottleneck],
    secs: u64,
) -> String {
    let apart = Apart::new(graph);
    let graph = &*apart.graph;
    let plan = Plan::of_roads(&apart, LEGEND_WIDTH);
    let most = edges.iter().map(|edge| edge.waiting_secs / secs as f64).fold(0.0, f64::max);
    let mut svg = Svg::new(0);
    svg.document(plan.size + DVec2::new(0.0, LEGEND), "")
        .set("font-family", "sans-serif")
        .set("font-size", 13)
        .open();
    svg.decimals = 1;
    svg.background("#fff");
    plan.draw_levels(&mut svg, &apart.levels);
    plan.draw_background(&mut svg, graph);
    let all = graph.edges().iter().map(|edge| plan.curves(edge));
    svg.element("path").fill("none").stroke("#dfe4ea", 1).curves(all);
    plan.draw_facilities(&mut svg, &apart);
    let mut by_class = [const { Vec::new() }; RAMP.len()];
    for edge in edges.iter().filter(|edge| edge.waiting_secs > 0.0) {
        if let Some(index) = graph.edge_by_id(edge.edge) {
            let class = class(edge.waiting_secs / secs as f64, most);
            by_class[class].push(plan.curves(graph.edge(index)));
        }
    }
    for (index, (curves, colour)) in by_class.into_iter().zip(RAMP).enumerate() {
        if !curves.is_empty() {
            let path = svg.element("path").fill("none");
            path.stroke(colour, 2.0 + 0.6 * index as f64).curves(curves);
        }
    }
    let marked = &bottlenecks[..bottlenecks.len().min(MARKED)];
    let marks: Vec<DVec2> =
        marked.iter().map(|bottleneck| plan.pixel(place(graph, bottleneck))).collect();
    plan.draw_stations(&mut svg, graph, &marks);
    for ((bottleneck, at), rank) in marked.iter().zip(marks).zip(1..) {
        svg.element("g").open();
        svg.element("title").content(format_args!(
            "{}: {:.2} robots wait for it, on average",
            bottleneck.place(),
            bottleneck.robots_waiting
        ));
        let disc = svg.circle(at, 11.0).fill("#fff").set("fill-opacity", 0.85);
        disc.stroke("#d55e00", 2);
        let text = svg.text(at + DVec2::new(0.0, 4.5)).set("text-anchor", "middle");
        text.fill("#a03c00").content(rank);
        svg.close();
    }
    write_legend(&mut svg, plan.size.y, most);
    svg.finish()
}

/// Returns the place of a bottleneck on a graph whose levels lie apart.
fn place(graph: &RouteGraph, bottleneck: &Bottleneck) -> DVec2 {
    let node = graph.node_by_id(bottleneck.node);
    node.map_or(bottleneck.position.into(), |node| graph.node(node).position)
}

/// Returns the class of a figure. Each class holds half of the figures of the next, since few
/// places have nearly all of the waiting.
fn class(value: f64, most: f64) -> usize {
    let halvings = if value > 0.0 { (most / value).log2() } else { f64::INFINITY };
    RAMP.len() - 1 - (halvings.floor().max(0.0) as usize).min(RAMP.len() - 1)
}

/// Writes the legend below the plan.
fn write_legend(svg: &mut Svg, top: f64, most: f64) {
    let title = svg.text(DVec2::new(MARGIN, top + 16.0)).fill("#1d2733");
    title.content("robots waiting, on average");
    for index in 0..=RAMP.len() {
        let at = DVec2::new(230.0 + 105.0 * index as f64, top);
        if let Some(colour) = RAMP.get(index) {
            svg.rect(at + DVec2::new(0.0, 8.0), DVec2::new(105.0, 8.0)).fill(colour);
        }
        let from = if index == 0 { 0.0 } else { most / 2.0_f64.powi((RAMP.len() - index) as i32) };
        let text = svg.text(at + DVec2::new(0.0, 32.0)).fill("#5a6875");
        text.content(format_args!("{from:.3}"));
    }
}

#[cfg(test)]
mod tests {
    use regatta_layout::{ReadOptions, parse};

    use super::*;

    #[test]
    fn doors_and_cabins_are_on_the_plan() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../graphs");
        let text =
            std::fs::read_to_string(folder.join("two-levels.yaml")).expect("a shipped plant");
        let graph = parse(&text, "two-levels.yaml", &ReadOptions::default()).expect("a graph").0;
        let svg = heat_map(&graph, &[], &[], 600);
        for name in ["hall", "store", "lift"] {
            assert!(svg.contains(&format!("<title>{name}</title>")), "{svg}");
        }
    }

    #[test]
    fn levels_lie_apart_on_the_plan_and_marks_lie_on_their_levels() {
        let text = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 0, Level: L1}\n\
            - {Id: 2, X: 9, Y: 0, Theta: 0, Level: L1}\n\
            - {Id: 3, X: 0, Y: 0, Theta: 0, Level: L2}\n\
            - {Id: 4, X: 9, Y: 0, Theta: 0, Level: L2}\nEdges:\n\
            - {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Linear, VelocityForward: 1}\n\
            - {Id: 2, Origin_ID: 3, Destination_ID: 4, CurveType: Linear, VelocityForward: 1}\n";
        let graph = parse(text, "g.yaml", &ReadOptions::default()).expect("a graph").0;
        let bottleneck = |node| Bottleneck {
            node,
            name: None,
            position: [9.0, 0.0],
            edges: Vec::new(),
            robots_waiting: 1.0,
            share: 0.5,
            facilities: Vec::new(),
        };
        let svg = heat_map(&graph, &[], &[bottleneck(2), bottleneck(4)], 600);
        assert!(svg.contains(">L1</text>") && svg.contains(">L2</text>"), "{svg}");
        let discs: Vec<_> = svg.match_indices("<circle").map(|(at, _)| &svg[at..at + 40]).collect();
        assert_eq!(discs.len(), 2, "{svg}");
        assert_ne!(discs[0], discs[1], "{svg}");
    }

    #[test]
    fn the_worst_edges_are_the_darkest() {
        assert_eq!(
            (class(8.0, 8.0), class(5.0, 8.0), class(4.0, 8.0), class(0.001, 8.0)),
            (5, 5, 4, 0)
        );
        let text = "id,x,y\nA,0,0\nB,10,0\nC,10,10\n\nfrom,to\nA,B\nB,C\nC,A\n";
        let graph = parse(text, "t.csv", &ReadOptions::default()).expect("a graph").0;
        let edge = |edge, waiting_secs| EdgeOutcome {
            edge,
            waiting_secs,
            caused_secs: 0.0,
            entered_per_hour: 1.0,
        };
        let svg = heat_map(
            &graph,
            &[edge(1, 600.0), edge(2, 10.0), edge(3, 0.0), edge(99, 5.0)],
            &[],
            600,
        );
        assert!(svg.contains("stroke=\"#440154\"") && svg.contains("stroke=\"#c2df23\""), "{svg}");
        assert!(!svg.contains("<title>"), "it has no doors");
        assert!(svg.contains("1.000") && svg.trim_end().ends_with("</svg>"), "{svg}");
    }
}
