//! The warnings about a scenario and its layout.

use regatta_layout::{Detail, Findings};

/// The largest number of warnings about a layout that are told, unless all are wanted.
const MOST_TOLD: usize = 20;

/// Warnings about a scenario and its layout.
#[derive(Clone, Debug, Default)]
pub struct Warnings {
    /// Those about the scenario, one line each.
    pub of_scenario: Vec<String>,
    /// Those about the layout, without those that don't concern the scenario's robots.
    pub of_layout: Findings,
}

impl Warnings {
    /// Returns lines for a user: those about the scenario, then those about the layout, the most
    /// important first. Unless all are wanted, the least important ones share a line.
    pub fn told(&self, wanted: Told) -> Vec<String> {
        let detail = match wanted {
            Told::All => Detail::Each,
            Told::MostImportant => Detail::Grouped { most: MOST_TOLD },
        };
        self.of_scenario.iter().cloned().chain(self.of_layout.told(detail)).collect()
    }
}

/// The warnings that a user wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Told {
    /// The most important ones have a line each, the others share a line.
    MostImportant,
    /// All have a line each.
    All,
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{Overrides, Scenario};

    #[test]
    fn a_layout_with_many_warnings_has_some_of_them_and_their_number() {
        // Each edge has a curve that doesn't end at its node.
        let edges: String = (1..=30)
            .map(|id| {
                format!(
                    "- {{Id: {id}, Origin_ID: 1, Destination_ID: 2, CurveType: Bezier, \
                     VelocityForward: 1, ControlPoints: [[0, 0], [1, 0], [2, 0], [3, 0]]}}\n"
                )
            })
            .collect();
        let layout = format!(
            "Vertices:\n- {{Id: 1, X: 0, Y: 0, Theta: 0}}\n- {{Id: 2, X: 4, Y: 0, Theta: 0}}\n\
             Edges:\n{edges}"
        );
        let scenario = Scenario::from_texts(
            "graph: g.yaml\nrobots: [{node: 1}]\n",
            &layout,
            Path::new("s.yaml"),
            &Overrides::default(),
        )
        .expect("a scenario");
        let lines = scenario.warnings.told(Told::MostImportant);
        assert_eq!(lines.len(), MOST_TOLD + 1, "{lines:?}");
        assert!(lines[MOST_TOLD].contains(" more warnings: `regatta graph check` lists them"));
        assert!(scenario.warnings.told(Told::All).len() >= 30);
    }
}
