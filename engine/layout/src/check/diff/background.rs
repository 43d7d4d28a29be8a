//! The differences between the lines of two backgrounds, which have no names.

use std::collections::BTreeMap;

use super::{Difference, DifferenceKind, TOLERANCE};
use crate::model::route_graph::RouteGraph;

/// A line, with its points in units of the tolerance.
type Line<'g> = (Option<&'g str>, Vec<[i64; 2]>);

/// Returns the difference between two backgrounds; `None` if both have the same lines in any order.
pub(super) fn difference(first: &RouteGraph, second: &RouteGraph) -> Option<Difference> {
    let (mut fewer, mut more) = (0, 0);
    for surplus in surplus(first, second).into_values() {
        match surplus {
            ..0 => fewer -= surplus,
            _ => more += surplus,
        }
    }
    let changes: Vec<String> = [(fewer, "fewer"), (more, "more")]
        .into_iter()
        .filter(|(lines, _)| *lines > 0)
        .map(|(lines, which)| match lines {
            1 => format!("1 line {which}"),
            _ => format!("{lines} lines {which}"),
        })
        .collect();
    let difference =
        Difference { kind: DifferenceKind::Changed, subject: "background".to_owned(), changes };
    (!difference.changes.is_empty()).then_some(difference)
}

/// Returns how many times more the second graph has each line.
fn surplus<'g>(first: &'g RouteGraph, second: &'g RouteGraph) -> BTreeMap<Line<'g>, i64> {
    let mut surplus = BTreeMap::new();
    for (graph, sign) in [(first, -1), (second, 1)] {
        for line in graph.background() {
            let points = line.points.iter().map(|point| {
                let point = (point + graph.origin()) / TOLERANCE;
                [point.x.round() as i64, point.y.round() as i64]
            });
            *surplus.entry((line.level.as_deref(), points.collect())).or_default() += sign;
        }
    }
    surplus
}
