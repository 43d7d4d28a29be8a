//! The manager against a model of a fleet.

use crate::model::managed::Managed;
use crate::model::worlds;

/// A block with one way in and one way out, and streets round it.
const LOAD: &str =
    "load: {seed: 1, groups: {in: [0], out: [23]}, generators: [{name: a, from: in, to: out, per_hour: 90, dwell: 5}]}";

#[test]
fn breakdowns_that_are_repaired_only_delay_orders() {
    let world = worlds::streets(6, 6.0, true);
    for seed in 1..4 {
        let mut fleet = Managed::new(&world, 12, seed, LOAD);
        // Two breakdowns of each robot in an hour, of two minutes each.
        fleet.run(72_000, 56, 1_200);
        let figures = fleet.manager.tasks().figures(7_200.0);
        assert_eq!(figures.orders.failed, 0, "{figures:?}");
        assert!(figures.orders.finished > 140 && figures.service.longest_secs < 1_800.0, "{figures:?}");
        // Once all are repaired, all orders are carried out.
        let created = figures.orders;
        fleet.run(12_000, 0, 0);
        let open = fleet.manager.tasks().figures(8_400.0).orders;
        assert_eq!(open.unroutable, 0, "{created:?} {open:?}");
        assert!(open.waiting < 10, "{created:?} {open:?}");
    }
}
