//! Nodes at one place.

use std::collections::BTreeMap;

use regatta_base::graph::NodeIndex;

use super::validate::MIN_LENGTH;
use crate::model::route_graph::RouteGraph;

/// Returns the nodes at the place of an earlier node of their level, in ascending order.
pub(crate) fn nodes(graph: &RouteGraph) -> Vec<NodeIndex> {
    let mut first = BTreeMap::new();
    let mut found = Vec::new();
    for (index, node) in (0..).map(NodeIndex).zip(graph.nodes()) {
        let level = node.tags.as_ref().and_then(|tags| tags.level.as_deref());
        let cell = (node.position / MIN_LENGTH).round();
        let place = (level, cell.x as i64, cell.y as i64);
        if *first.entry(place).or_insert(index) != index {
            found.push(index);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use crate::model::options::ReadOptions;
    use crate::parse;

    #[test]
    fn nodes_at_one_place_are_told_once_unless_they_are_on_different_levels() {
        let told = |levels: [&str; 2]| {
            let [a, b] = levels;
            let text = format!(
                "id,x,y,level\nA,0,0,{a}\nB,9,0,{a}\nC,0,0,{b}\nD,9,0,{b}\n\n\
                 from,to\nA,B\nB,A\nC,D\nD,C\n"
            );
            let (_, findings) = parse(&text, "p.csv", &ReadOptions::default()).expect("a graph");
            let findings = findings.as_slice().iter().map(ToString::to_string);
            findings.filter(|line| line.contains("at the same place as another node")).collect()
        };
        let same: Vec<String> = told(["", ""]);
        assert_eq!(same.len(), 1, "{same:?}");
        assert!(same[0].contains("`C`") && same[0].contains("1 more node: `D`"), "{same:?}");
        assert_eq!(told(["1", "2"]), Vec::<String>::new());
    }
}
