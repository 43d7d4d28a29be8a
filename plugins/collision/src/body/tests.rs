//! Distances and nearest points against the polygons of the reference.

use proptest::prelude::*;

use super::*;
use crate::geometry_reference::{bodies, distance, outline, position};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn a_gap_is_the_distance_of_the_polygons(a in bodies(), b in bodies()) {
        let (gap_ab, gap_ba) = (gap(&a, &b, f64::INFINITY), gap(&b, &a, f64::INFINITY));
        prop_assert!((gap_ab - gap_ba).abs() < 1e-9, "{gap_ab} {gap_ba}");
        let exact = distance(&outline(&a, position(&a), a.heading), &outline(&b, position(&b), b.heading));
        prop_assert!((gap_ab - exact).abs() < 1e-5, "{gap_ab} {exact}");
    }

    #[test]
    fn a_reach_does_not_change_gaps_within_it(a in bodies(), b in bodies(), reach in 0.0_f64..3.0) {
        let (exact, found) = (gap(&a, &b, f64::INFINITY), gap(&a, &b, reach));
        prop_assert!(if exact <= reach { found == exact } else { found > reach }, "{exact} {found} {reach}");
    }

    #[test]
    fn a_nearest_point_lies_between_the_positions(a in bodies(), b in bodies()) {
        let [x, y] = nearest_point(&a, &b).as_dvec2().to_array();
        let far = |body: &Body| (x - position(body)[0]).hypot(y - position(body)[1]);
        let [one, other] = [position(&a), position(&b)];
        let whole = (one[0] - other[0]).hypot(one[1] - other[1]);
        prop_assert!(far(&a) + far(&b) < whole + 1e-3, "between the two");
    }
}
