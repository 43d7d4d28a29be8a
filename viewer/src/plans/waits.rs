//! Robots that wait for others, and the rings of robots that wait for each other.

use regatta_scene::plans::WaitArrow;

/// The entry of a robot that doesn't wait for another.
const NOBODY: u32 = u32::MAX;

/// Returns an arrow for each robot that waits. `waits_for` holds the id of the robot that each
/// robot waits for, or NaN; an id that no robot has counts as NaN. Arrows of rings come last, so
/// that they are drawn over the others.
pub fn arrows(waits_for: &[f32]) -> Vec<WaitArrow> {
    let next: Vec<u32> =
        (0..).zip(waits_for).map(|(robot, value)| target(*value, robot, waits_for.len())).collect();
    let mut all = Vec::new();
    for ((from, to), in_ring) in (0..).zip(&next).zip(on_rings(&next)) {
        if *to != NOBODY {
            all.push(WaitArrow { from, to: *to, in_ring: in_ring.into() });
        }
    }
    all.sort_by_key(|arrow| arrow.in_ring);
    all
}

fn target(value: f32, robot: u32, robots: usize) -> u32 {
    // NaN and negative numbers fail the first comparison.
    let is_robot = value >= 0.0 && value < robots as f32 && value as u32 != robot;
    if is_robot { value as u32 } else { NOBODY }
}

/// Returns for each element of a list whether following the list from it leads back to it. `next`
/// holds the index of the element after each one; an index beyond the end ends a chain. Takes time
/// in proportion to the elements.
pub fn on_rings(next: &[u32]) -> Vec<bool> {
    let mut is_on = vec![false; next.len()];
    // The walk that came by each element first; 0 for none.
    let mut walks = vec![0_u32; next.len()];
    for (walk, start) in (1..).zip(0..next.len()) {
        let mut at = start;
        while walks.get(at) == Some(&0) {
            walks[at] = walk;
            at = next[at] as usize;
        }
        // A walk that ends where it has been itself has found a ring; the rings of other walks are
        // known.
        while walks.get(at) == Some(&walk) && !is_on[at] {
            is_on[at] = true;
            at = next[at] as usize;
        }
    }
    is_on
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Follows the list from each element for as many steps as there are elements.
    fn on_rings_by_walking(next: &[u32]) -> Vec<bool> {
        let leads_back = |start: usize| {
            let mut at = start;
            (0..next.len()).any(|_| {
                at = next.get(at).map_or(usize::MAX, |next| *next as usize);
                at == start
            })
        };
        (0..next.len()).map(leads_back).collect()
    }

    #[test]
    fn rings_are_found_and_those_who_wait_for_a_ring_are_not_in_it() {
        // 0 → 1 → 2 → 0 is a ring; 3 → 4 → 0 waits for it; 5 ⇄ 6 is a second ring; 7 → 8, which
        // waits for nobody.
        let next = [1, 2, 0, 4, 0, 6, 5, 8, NOBODY];
        let wanted = [true, true, true, false, false, true, true, false, false];
        assert_eq!(on_rings(&next), wanted);
        assert!(on_rings(&[]).is_empty());
    }

    #[test]
    fn rings_of_any_list_are_those_found_by_walking() {
        let mut seed = 1_u64;
        let mut random = move |below: u64| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) % below
        };
        for robots in 1..40_u64 {
            for _ in 0..20 {
                let next: Vec<u32> = (0..robots)
                    .map(|_| if random(4) == 0 { NOBODY } else { random(robots) as u32 })
                    .collect();
                assert_eq!(on_rings(&next), on_rings_by_walking(&next), "{next:?}");
            }
        }
    }

    #[test]
    fn values_that_are_no_other_robot_have_no_arrow() {
        let nan = f32::NAN;
        let arrow = |from, to, in_ring| WaitArrow { from, to, in_ring };
        assert_eq!(arrows(&[nan, -1.0, 2.0, 99.0, f32::INFINITY]), []);
        assert_eq!(arrows(&[1.0, 2.0, 1.0, nan]), [arrow(0, 1, 0), arrow(1, 2, 1), arrow(2, 1, 1)]);
    }
}
