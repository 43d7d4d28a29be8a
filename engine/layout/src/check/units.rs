//! Lengths in another unit than metres.

use glam::DVec2;

use super::validate::MAX_EXTENT;
use crate::model::finding::Report;
use crate::model::options::LengthUnit;
use crate::model::raw::RawGraph;

/// The length in metres that half of a plant's edges don't exceed: no plant has stops so far apart.
const LONG_EDGE: f64 = 150.0;
/// The least length in metres of the longer side of a plant.
const SMALL_PLANT: f64 = 5.0;

/// Tells that the lengths of a graph look like another unit than metres. Returns `false` if the
/// graph is too large to be anything else.
pub(crate) fn check(raw: &RawGraph, report: &mut Report<'_>) -> bool {
    let Some(median) = median_length(raw).filter(|median| *median > LONG_EDGE) else { return true };
    let size = extent(raw);
    let longer = size.max_element();
    if longer * LengthUnit::Centimetre.metres() < SMALL_PLANT {
        return true;
    }
    let is_small = longer * LengthUnit::Millimetre.metres() < SMALL_PLANT;
    let (unit, name) = match is_small {
        true => (LengthUnit::Centimetre, "centimetres"),
        false => (LengthUnit::Millimetre, "millimetres"),
    };
    let meant = size * unit.metres();
    let message = format!(
        "the nodes lie in {:.0} m × {:.0} m, and half of the edges have {median:.0} m or more: \
         these look like {name} ({:.1} m × {:.1} m); if they are, give `--units {}`",
        size.x,
        size.y,
        meant.x,
        meant.y,
        unit.name()
    );
    let is_possible = longer <= MAX_EXTENT;
    if is_possible {
        report.file_warning(0, message);
    } else {
        report.file_error(0, message);
    }
    is_possible
}

/// Returns the length of a graph's edges, from end to end, that half of them exceed.
fn median_length(raw: &RawGraph) -> Option<f64> {
    let places: std::collections::BTreeMap<u32, DVec2> =
        raw.nodes.iter().filter_map(|node| Some((node.id?, node.position()?))).collect();
    let lengths = raw.edges.iter().filter_map(|edge| {
        let [from, to] = [edge.origin?, edge.destination?].map(|id| places.get(&id));
        Some(from?.distance(*to?))
    });
    let mut lengths: Vec<f64> = lengths.collect();
    lengths.sort_unstable_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied()
}

fn extent(raw: &RawGraph) -> DVec2 {
    let places = raw.nodes.iter().filter_map(crate::model::raw::RawNode::position);
    let (min, max) = places
        .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), at| (min.min(at), max.max(at)));
    max - min
}

#[cfg(test)]
mod tests {
    use crate::model::options::{LengthUnit, ReadOptions};
    use crate::parse;

    const ROADS: &str = "\n\nfrom,to\nA,B\nB,C\nC,A\n";

    fn messages(text: &str, name: &str, options: &ReadOptions) -> (bool, Vec<String>) {
        match parse(text, name, options) {
            Ok((_, findings)) => {
                (true, findings.as_slice().iter().map(ToString::to_string).collect())
            }
            Err(error) => (false, error.to_string().lines().map(str::to_owned).collect()),
        }
    }

    #[test]
    fn millimetres_are_told_first_and_once_with_the_option() {
        for (size, unit, is_read) in
            [("40000", "mm", false), ("9000", "mm", true), ("1200", "cm", true)]
        {
            let text = format!("id,x,y\nA,0,0\nB,{size},0\nC,{size},{size}{ROADS}");
            let (was_read, messages) = messages(&text, "plant.csv", &ReadOptions::default());
            assert_eq!(was_read, is_read, "{messages:?}");
            let hint = format!("`--units {unit}`");
            assert!(messages[0].contains(&hint), "{messages:?}");
            assert_eq!(messages.iter().filter(|line| line.contains("--units")).count(), 1);
            assert!(is_read || messages.len() == 1, "{messages:?}");
        }
    }

    #[test]
    fn long_roads_outdoors_are_in_metres() {
        let text = "id,x,y\nA,0,0\nB,400,0\n\nfrom,to\nA,B\nB,A\n";
        let (was_read, told) = messages(text, "roads.csv", &ReadOptions::default());
        assert!(was_read && !told.iter().any(|line| line.contains("--units")), "{told:?}");
    }

    #[test]
    fn the_option_is_taken_for_formats_whose_lengths_are_in_metres() {
        let csv = format!("id,x,y\nA,0,0\nB,40000,0\nC,40000,30000{ROADS}");
        let node = |id, x, y| format!("- {{Id: {id}, X: {x}, Y: {y}, Theta: 0}}\n");
        let edge = |id, from, to| {
            format!(
                "- {{Id: {id}, Origin_ID: {from}, Destination_ID: {to}, VelocityForward: 1, \
                 CurveType: Linear}}\n"
            )
        };
        let nodes = [node(1, 0, 0), node(2, 40000, 0), node(3, 40000, 30000)].concat();
        let edges = [edge(1, 1, 2), edge(2, 2, 3), edge(3, 3, 1)].concat();
        let yaml = format!("Vertices:\n{nodes}Edges:\n{edges}");
        let options = ReadOptions { units: Some(LengthUnit::Millimetre), ..ReadOptions::default() };
        for (text, name) in [(csv.as_str(), "plant.csv"), (yaml.as_str(), "plant.yaml")] {
            let (was_read, told) = messages(text, name, &ReadOptions::default());
            assert!(!was_read && told[0].contains("`--units mm`"), "{told:?}");
            let (graph, findings) = parse(text, name, &options).expect("a graph");
            let lengths: Vec<f64> = graph.edges().iter().map(|edge| edge.path.length()).collect();
            assert_eq!(lengths.iter().map(|length| length.round()).sum::<f64>(), 120.0);
            let told = findings.as_slice().iter().any(|found| found.message.contains("--units"));
            assert!(!told, "{findings:?}");
        }
    }
}
