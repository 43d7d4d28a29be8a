//! `lanes` against the model of a fleet, on roads with a dead end.

use super::{Lanes, LanesSettings};
use crate::model::{Maker, drive, worlds};

const LANES: Maker = |roads| Box::new(Lanes::new(roads, LanesSettings::default()));

#[test]
fn robots_take_turns_in_a_dead_end() {
    // Up to a third of all goals lie in the dead end, where no two robots can pass each other.
    for (sections, robots, seed) in [(1, 4, 3), (3, 4, 3), (3, 5, 1), (2, 6, 2)] {
        let model =
            drive("stub, lanes", &worlds::ring_with_stub(sections), (robots, seed), 1_800, LANES);
        assert!(
            model.arrivals.iter().all(|&goals| goals >= 20),
            "{sections} sections: {:?}",
            model.arrivals
        );
        assert!(model.longest_secs() < 300.0, "{sections} sections: {} s", model.longest_secs());
    }
}
