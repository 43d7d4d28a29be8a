//! The plan with the edges where robots wait, as SVG.

use regatta_layout::{Edge, RouteGraph};

use crate::bottleneck::Bottleneck;
use crate::outcome::EdgeOutcome;

/// The longer side of the plan in pixels.
const LONGER_SIDE: f64 = 1100.0;
const MARGIN: f64 = 24.0;
/// The height of the legend below the plan.
const LEGEND: f64 = 46.0;
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
    let plan = Plan::new(graph);
    let most = edges.iter().map(|edge| edge.waiting_secs / secs as f64).fold(0.0, f64::max);
    let (width, height) = (plan.width, plan.height + LEGEND);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         width=\"{width:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    let all: String = graph.edges().iter().map(|edge| plan.path(edge)).collect();
    svg += &format!("<path fill=\"none\" stroke=\"#dfe4ea\" d=\"{all}\"/>\n");
    let mut by_class: [String; RAMP.len()] = Default::default();
    for edge in edges.iter().filter(|edge| edge.waiting_secs > 0.0) {
        if let Some(index) = graph.edge_by_id(edge.edge) {
            by_class[class(edge.waiting_secs / secs as f64, most)] += &plan.path(graph.edge(index));
        }
    }
    for (index, (paths, colour)) in by_class.iter().zip(RAMP).enumerate() {
        if !paths.is_empty() {
            let width = 2.0 + 0.6 * index as f64;
            svg += &format!(
                "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" d=\"{paths}\"/>\n"
            );
        }
    }
    for (bottleneck, rank) in bottlenecks.iter().zip(1..).take(MARKED) {
        let [x, y] = bottleneck.position;
        let Pixel { x, y } = plan.pixel(x, y);
        svg += &format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"11\" fill=\"#fff\" fill-opacity=\"0.85\" \
             stroke=\"#d55e00\" stroke-width=\"2\"/><text x=\"{x:.1}\" y=\"{:.1}\" \
             text-anchor=\"middle\" fill=\"#a03c00\">{rank}</text>\n",
            y + 4.5
        );
    }
    svg + &legend(plan.height, most) + "</svg>\n"
}

/// Returns the class of a figure. Each class holds half of the figures of the next, since few
/// places have nearly all of the waiting.
fn class(value: f64, most: f64) -> usize {
    let halvings = if value > 0.0 { (most / value).log2() } else { f64::INFINITY };
    RAMP.len() - 1 - (halvings.floor().max(0.0) as usize).min(RAMP.len() - 1)
}

/// Returns the legend below the plan.
fn legend(top: f64, most: f64) -> String {
    let (bar, baseline) = (top + 8.0, top + 32.0);
    let mut svg = format!(
        "<text x=\"{MARGIN}\" y=\"{:.0}\" fill=\"#1d2733\">robots waiting, on average</text>\n",
        top + 16.0
    );
    for (index, colour) in RAMP.iter().enumerate() {
        let from = if index == 0 { 0.0 } else { most / 2.0_f64.powi((RAMP.len() - index) as i32) };
        let x = 230.0 + 105.0 * index as f64;
        svg += &format!(
            "<rect x=\"{x}\" y=\"{bar:.0}\" width=\"105\" height=\"8\" fill=\"{colour}\"/>\
             <text x=\"{x}\" y=\"{baseline:.0}\" fill=\"#5a6875\">{from:.3}</text>\n"
        );
    }
    let x = 230.0 + 105.0 * RAMP.len() as f64;
    svg + &format!("<text x=\"{x}\" y=\"{baseline:.0}\" fill=\"#5a6875\">{most:.3}</text>\n")
}

/// The place of the layout in the picture.
struct Plan {
    west: f64,
    north: f64,
    /// Pixels per metre.
    scale: f64,
    width: f64,
    height: f64,
}

/// A point of the picture.
struct Pixel {
    x: f64,
    y: f64,
}

impl Plan {
    fn new(graph: &RouteGraph) -> Self {
        let (mut west, mut east) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut south, mut north) = (f64::INFINITY, f64::NEG_INFINITY);
        for point in graph.edges().iter().flat_map(|edge| edge.path.control_points()) {
            (west, east) = (west.min(point.x), east.max(point.x));
            (south, north) = (south.min(point.y), north.max(point.y));
        }
        let (width, height) = ((east - west).max(0.1), (north - south).max(0.1));
        let scale = (LONGER_SIDE - 2.0 * MARGIN) / width.max(height);
        // At least as wide as the legend.
        let width = (width * scale + 2.0 * MARGIN).max(920.0);
        Self { west, north, scale, width, height: height * scale + 2.0 * MARGIN }
    }

    /// Returns the place of a point, given in metres east and north.
    fn pixel(&self, x: f64, y: f64) -> Pixel {
        Pixel {
            x: (x - self.west) * self.scale + MARGIN,
            y: (self.north - y) * self.scale + MARGIN,
        }
    }

    /// Returns the commands of an edge's curve.
    fn path(&self, edge: &Edge) -> String {
        let mut text = String::new();
        for (index, cubic) in edge.path.cubics().enumerate() {
            let [a, b, c, d] = cubic.control_points.map(|point| self.pixel(point.x, point.y));
            if index == 0 {
                text += &format!("M{:.1} {:.1}", a.x, a.y);
            }
            text += &format!("C{:.1} {:.1} {:.1} {:.1} {:.1} {:.1}", b.x, b.y, c.x, c.y, d.x, d.y);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use regatta_layout::{ReadOptions, parse};

    use super::*;

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
        assert!(svg.contains("1.000") && svg.trim_end().ends_with("</svg>"), "{svg}");
    }
}
