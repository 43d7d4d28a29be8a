//! The number of places of a plane that can be taken at once, if some are too near to each other.

use std::collections::BTreeMap;

use glam::DVec2;

/// Returns a number that the number of places which can be taken at once never exceeds, whatever
/// the order: all places are in so many groups, in each of which every two are too near to each
/// other. `are_near` tells of two indices whether they are; places `reach` apart or more never are.
pub fn most_apart(
    positions: &[DVec2],
    reach: f64,
    are_near: impl Fn(usize, usize) -> bool,
) -> usize {
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|one, other| {
        let [one, other] = [one, other].map(|index| positions[*index]);
        one.x.total_cmp(&other.x).then(one.y.total_cmp(&other.y))
    });
    let mut groups: Vec<Vec<usize>> = Vec::new();
    // By cell of the first place.
    let mut by_cell: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    for place in order {
        let [column, row] = cell(positions[place], reach);
        let cells = (-1..=1).flat_map(|x| (-1..=1).map(move |y| [column + x, row + y]));
        let near = cells.filter_map(|cell| by_cell.get(&cell)).flatten().copied();
        let mut fitting =
            near.filter(|group| groups[*group].iter().all(|other| are_near(*other, place)));
        match fitting.next() {
            Some(group) => groups[group].push(place),
            None => {
                by_cell.entry([column, row]).or_default().push(groups.len());
                groups.push(vec![place]);
            }
        }
    }
    groups.len()
}

fn cell(position: DVec2, size: f64) -> [i64; 2] {
    (position / size).floor().to_array().map(|cell| cell as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn most(xs: &[f64]) -> usize {
        let positions: Vec<DVec2> = xs.iter().map(|x| DVec2::new(*x, 0.0)).collect();
        most_apart(&positions, 1.0, |a, b| positions[a].distance(positions[b]) < 1.0)
    }

    #[test]
    fn no_order_takes_more_places() {
        assert_eq!(most(&[]), 0);
        assert_eq!(most(&[0.0, 0.0, 0.5, 10.0]), 2);
        assert_eq!(most(&[1.5, 0.5, 0.0, 1.0]), 2);
        assert_eq!(most(&[0.0, 1.0, 2.0]), 3);
        let random = crate::random::Random::new(3);
        for round in 0..50 {
            let xs: Vec<f64> = (0..9).map(|n| 4.0 * random.part(round).unit(n)).collect();
            let bound = most(&xs);
            let taken = |subset: u32| (0..9).filter(move |n| subset >> n & 1 == 1);
            let is_apart = |subset: &u32| {
                taken(*subset)
                    .all(|a| taken(*subset).all(|b| a == b || (xs[a] - xs[b]).abs() >= 1.0))
            };
            let best = (0..1_u32 << 9).filter(is_apart).map(u32::count_ones).max();
            assert!(bound >= best.unwrap_or(0) as usize, "{xs:?}");
        }
    }
}
