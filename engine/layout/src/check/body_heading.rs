//! The key `ThetaHolonomic`: the heading of a robot's body at a node. `Theta` is the heading of the
//! curve.

use regatta_base::graph::NodeIndex;

use super::validate::to_radians;
use crate::model::angle::normalize_angle;
use crate::model::finding::{Report, Severity};
use crate::model::raw::{RawEdge, RawGraph};
use crate::model::route_graph::Edge;
use crate::model::tags::Orientation;
use crate::model::value::plural;

/// Angles in radians that differ by at most this much count as equal: files round them.
const TOLERANCE: f64 = 0.01;

/// Sets the orientation of edges that have none, from the body headings at their ends. `edges` are
/// in the order of `raw`.
pub(crate) fn orient(raw: &RawGraph, edges: &mut [Option<Edge>], report: &mut Report<'_>) {
    let (mut varying, mut incomplete) = (Vec::new(), Vec::new());
    for (edge, raw_edge) in edges.iter_mut().zip(&raw.edges) {
        let Some(edge) = edge else { continue };
        if raw_edge.orientation != Orientation::Tangential {
            continue;
        }
        match (body_heading(raw, edge.origin), body_heading(raw, edge.destination)) {
            (None, None) => {}
            (Some(start), Some(end)) => match orientation(edge, start, end) {
                Some(orientation) => edge.orientation = orientation,
                None => varying.push(raw_edge),
            },
            _ => incomplete.push(raw_edge),
        }
    }
    let reason = "ThetaHolonomic at its ends makes the heading of robots vary along it otherwise \
                  than its tangent does, which isn't supported";
    warn(&varying, reason, report);
    warn(&incomplete, "only one of its nodes has a ThetaHolonomic", report);
}

/// Reports one warning for all edges that are driven along their tangents for the same reason.
fn warn(edges: &[&RawEdge], reason: &str, report: &mut Report<'_>) {
    let Some((first, others)) = edges.split_first() else { return };
    let others = match others.len() {
        0 => String::new(),
        count => format!(" (and {})", plural(count, "more edge")),
    };
    let message = format!(
        "{reason}{others}: robots head along the tangent there; give such edges a HeadingOffset or \
         a Heading, or correct the nodes"
    );
    first.report(Severity::Warning, &message, report);
}

/// Returns the body heading at a node in radians, in (-π, π].
fn body_heading(raw: &RawGraph, node: NodeIndex) -> Option<f64> {
    Some(to_radians(raw.nodes[node.0 as usize].body_heading?, raw.degrees))
}

/// Returns the orientation for which an edge has these headings at its ends; `None` if there is
/// none.
fn orientation(edge: &Edge, start: f64, end: f64) -> Option<Orientation> {
    let offset = normalize_angle(start - edge.path.start_tangent().to_angle());
    let end_offset = normalize_angle(end - edge.path.end_tangent().to_angle());
    if let Some(offset) = mean_if_equal(offset, end_offset) {
        return Some(if offset.abs() <= TOLERANCE {
            Orientation::Tangential
        } else {
            Orientation::Offset(offset)
        });
    }
    mean_if_equal(start, end).map(Orientation::Fixed)
}

/// Returns the middle of two angles; `None` if they aren't equal.
fn mean_if_equal(a: f64, b: f64) -> Option<f64> {
    let difference = normalize_angle(b - a);
    (difference.abs() <= TOLERANCE).then(|| normalize_angle(a + difference / 2.0))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use crate::model::finding::Findings;
    use crate::model::options::ReadOptions;
    use crate::model::route_graph::RouteGraph;
    use crate::model::tags::Orientation;
    use crate::parse;

    const QUARTER: &str = "CurveType: Spline, ParamF: 2.761, ParamB: 2.761, VelocityForward: 1";
    const STRAIGHT: &str = "CurveType: Linear, VelocityForward: 1";

    /// A curve from (0, 0) heading east to (5, 5) heading north, or a straight edge; with more keys
    /// of the nodes.
    fn read(edge: &str, first: &str, second: &str) -> (RouteGraph, Findings) {
        let text = format!(
            "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0{first}}}\n- {{Id: 2, X: 5, Y: 5, Theta: \
             {FRAC_PI_2}{second}}}\n\
             Edges:\n- {{Id: 7, Origin_ID: 1, Destination_ID: 2, {edge}}}\n"
        );
        parse(&text, "g", &ReadOptions::default()).expect("a graph")
    }

    fn orientation(edge: &str, first: f64, second: f64) -> Orientation {
        let key = |angle| format!(", ThetaHolonomic: {angle}");
        read(edge, &key(first), &key(second)).0.edges()[0].orientation
    }

    /// The warnings about the edge, without those of its end.
    fn warnings(findings: &Findings) -> Vec<String> {
        let lines = findings.as_slice().iter().map(ToString::to_string);
        lines.filter(|line| line.contains("edge 7")).collect()
    }

    #[test]
    fn equal_angles_to_the_tangent_are_an_offset() {
        let found = orientation(QUARTER, 1.0, 1.0 + FRAC_PI_2);
        assert!(
            matches!(found, Orientation::Offset(angle) if (angle - 1.0).abs() < 1e-9),
            "{found:?}"
        );
        // Across the cut at π, and rounded.
        let found = orientation(QUARTER, PI - 0.002, -FRAC_PI_2 - 0.002);
        assert!(
            matches!(found, Orientation::Offset(angle) if (angle - PI).abs() < 0.01),
            "{found:?}"
        );
        assert_eq!(orientation(QUARTER, 0.001, FRAC_PI_2), Orientation::Tangential);
    }

    #[test]
    fn equal_headings_on_the_map_are_a_fixed_heading() {
        let found = orientation(QUARTER, 1.0, 1.004);
        assert!(
            matches!(found, Orientation::Fixed(heading) if (heading - 1.002).abs() < 1e-9),
            "{found:?}"
        );
        // On a straight edge both are the same; the offset is what is left if the edge is moved.
        let found = orientation(STRAIGHT, 1.0, 1.0);
        assert!(
            matches!(found, Orientation::Offset(angle) if (angle - (1.0 - PI / 4.0)).abs() < 1e-9),
            "{found:?}"
        );
    }

    #[test]
    fn an_orientation_of_the_edge_counts_more() {
        let key = ", ThetaHolonomic: 1.0";
        for (own, expected) in [
            ("HeadingOffset: 0", Orientation::Tangential),
            ("HeadingOffset: 0.5", Orientation::Offset(0.5)),
            ("Heading: 2", Orientation::Fixed(2.0)),
        ] {
            let (graph, findings) = read(&format!("{QUARTER}, {own}"), key, key);
            assert_eq!((graph.edges()[0].orientation, warnings(&findings).len()), (expected, 0));
        }
    }

    #[test]
    fn a_heading_that_varies_otherwise_is_told() {
        let (graph, findings) = read(QUARTER, ", ThetaHolonomic: 0.5", ", ThetaHolomonic: 1.5");
        assert_eq!(graph.edges()[0].orientation, Orientation::Tangential);
        let [warning] = warnings(&findings).try_into().expect("one warning");
        assert!(
            warning.starts_with("g:5: warning: edge 7: ThetaHolonomic at its ends makes"),
            "{warning}"
        );
        assert!(
            warning.contains("isn't supported: robots head along the tangent there; give"),
            "{warning}"
        );
    }

    #[test]
    fn a_node_without_the_key_is_told() {
        for keys in [["", ", ThetaHolonomic: 1"], [", ThetaHolonomic: 1", ""]] {
            let (graph, findings) = read(QUARTER, keys[0], keys[1]);
            assert_eq!(graph.edges()[0].orientation, Orientation::Tangential);
            let [warning] = warnings(&findings).try_into().expect("one warning");
            assert!(
                warning.contains("only one of its nodes has a ThetaHolonomic: robots head"),
                "{warning}"
            );
        }
        assert_eq!(
            warnings(&read(QUARTER, ", ThetaHolonomic: ~", "").1),
            Vec::<String>::new(),
            "an empty one is none"
        );
    }

    #[test]
    fn the_unit_and_the_type_are_checked() {
        let text = |angle: &str| {
            format!(
                "AngleUnit: deg\nVertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0, ThetaHolonomic: \
                 {angle}}}\n\
                 - {{Id: 2, X: 5, Y: 0, Theta: 0, ThetaHolonomic: 90}}\n\
                 Edges:\n- {{Id: 7, Origin_ID: 1, Destination_ID: 2, {STRAIGHT}}}\n"
            )
        };
        let (graph, _) = parse(&text("90"), "g", &ReadOptions::default()).expect("a graph");
        assert_eq!(graph.edges()[0].orientation, Orientation::Offset(FRAC_PI_2));
        for (angle, problem) in [
            ("left", "ThetaHolonomic is `left`: it must be"),
            ("1e9", "ThetaHolonomic is 1000000000:"),
        ] {
            let error = parse(&text(angle), "g", &ReadOptions::default())
                .expect_err("no angle")
                .to_string();
            assert!(
                error.starts_with("g:3: error: node 1: ") && error.contains(problem),
                "{error}"
            );
        }
    }

    #[test]
    fn the_key_is_kept_and_our_writer_keeps_the_orientation() {
        let (graph, _) = read(QUARTER, ", ThetaHolonomic: 1", ", ThetaHolonomic: 1");
        let property = |graph: &RouteGraph| {
            graph.nodes()[0].tags.as_ref().expect("tags").properties["ThetaHolonomic"].clone()
        };
        let text = crate::write::regatta::write(&graph).text;
        let (again, _) = parse(&text, "g", &ReadOptions::default()).expect("a graph");
        assert_eq!((&*property(&graph), &*property(&again)), ("1", "1"));
        assert_eq!(again.edges()[0].orientation, Orientation::Fixed(1.0));
    }
}
