//! Angles whose unit the file doesn't give.

use std::f64::consts::{FRAC_PI_4, PI};

use crate::model::finding::{Report, Subject};
use crate::model::raw::RawGraph;
use crate::model::value::plural;

/// An angle in radians, of a little more than a full turn, beyond which angles are probably in
/// degrees.
pub(crate) const SUSPICIOUS_ANGLE: f64 = 2.0 * PI + 0.01;

/// The distance in radians from a multiple of an eighth of a turn up to which an angle is one.
const NEARLY_ROUND: f64 = 2e-3;

/// Whether an angle is beyond a full turn in radians.
fn is_suspicious(angle: f64) -> bool {
    angle.abs() > SUSPICIOUS_ANGLE
}

/// Whether the angles of a file are degrees: some are beyond a full turn, and none is a fraction of
/// a turn as radians are.
pub(super) fn are_degrees(raw: &RawGraph) -> bool {
    raw.angles().any(is_suspicious) && !raw.angles().any(is_eighth_turn)
}

/// Whether an angle is a multiple of π/4, as radians are, and no whole number of degrees.
fn is_eighth_turn(angle: f64) -> bool {
    let eighths = angle / FRAC_PI_4;
    let distance = (eighths - eighths.round()).abs() * FRAC_PI_4;
    eighths.round() != 0.0 && !is_suspicious(angle) && distance < NEARLY_ROUND
}

/// Warns of headings beyond a full turn in radians, which are probably in degrees.
pub(super) fn warn_of_degrees(raw: &RawGraph, report: &mut Report<'_>) {
    if raw.degrees || raw.is_imported {
        return;
    }
    let nodes = raw.nodes.iter().filter_map(|node| Some((node, node.theta?)));
    let edges = raw.edges.iter().filter_map(|edge| Some((edge, edge.orientation.angle()?)));
    let mut nodes = nodes.filter(|(_, angle)| is_suspicious(*angle));
    let mut edges = edges.filter(|(_, angle)| is_suspicious(*angle));
    let (at, subject, what, angle, others) = match nodes.next() {
        Some((node, angle)) => {
            (node.at, Subject::Node(node.id), "Theta", angle, plural_more(nodes.count(), "node"))
        }
        None => {
            let Some((edge, angle)) = edges.next() else { return };
            let others = plural_more(edges.count(), "edge");
            (edge.at, Subject::Edge(edge.id), "its heading", angle, others)
        }
    };
    let message = format!(
        "{what} is {angle}, more than a full turn{others}: if the angles are in degrees, add \
         `AngleUnit: deg` to the file"
    );
    report.warning(at, subject, message);
}

fn plural_more(count: usize, noun: &str) -> String {
    match count {
        0 => String::new(),
        more => format!(" (and {})", plural(more, &format!("more {noun}"))),
    }
}
