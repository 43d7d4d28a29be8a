//! Lines of a layout's background, by what they stand for: files don't say so.

use glam::DVec2;

/// The least and the greatest mean width in metres of an outline that is a rack: a thinner one is
/// that of a wall, a wider one that of a room.
const LEAST_RACK: f64 = 0.5;
const MOST_RACK: f64 = 2.6;
/// The distance in metres by which a line may lie outside of the rack that it belongs to.
const BESIDE: f64 = 0.05;

/// The meaning of a line of the background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineKind {
    /// A wall, or the outline of a floor or a room: robots drive on either side, or inside.
    Wall,
    /// A rack, or another block that robots drive around: an outline without a node inside, and the
    /// lines within it.
    Rack,
}

/// A rectangle with sides along the axes.
#[derive(Clone, Copy, Debug)]
struct Rectangle {
    low: DVec2,
    high: DVec2,
}

/// Returns the kinds of lines, given the nodes of the route graph beside them.
pub fn kinds(lines: &[Vec<DVec2>], nodes: impl IntoIterator<Item = DVec2>) -> Vec<LineKind> {
    let mut nodes: Vec<DVec2> = nodes.into_iter().collect();
    nodes.sort_by(|a, b| a.x.total_cmp(&b.x));
    let is_block: Vec<bool> = lines.iter().map(|line| is_block(line, &nodes)).collect();
    let blocks = lines.iter().zip(&is_block).filter(|(_, is_block)| **is_block);
    let mut blocks: Vec<Rectangle> = blocks.map(|(line, _)| Rectangle::around(line)).collect();
    blocks.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
    let widest = blocks.iter().map(|block| block.high.x - block.low.x).fold(0.0, f64::max);
    let lines = lines.iter().zip(is_block);
    let kinds = lines.map(|(line, is_block)| {
        let is_rack = is_block || is_within(&Rectangle::around(line), &blocks, widest);
        if is_rack { LineKind::Rack } else { LineKind::Wall }
    });
    kinds.collect()
}

/// Whether a line is the outline of a block that robots drive around. Nodes are sorted by x.
fn is_block(line: &[DVec2], nodes: &[DVec2]) -> bool {
    let is_closed = line.len() > 3 && line.first() == line.last();
    if !is_closed || !(LEAST_RACK..=MOST_RACK).contains(&mean_width(line)) {
        return false;
    }
    let Rectangle { low, high } = Rectangle::around(line);
    let first = nodes.partition_point(|node| node.x < low.x);
    let near = nodes[first..].iter().take_while(|node| node.x <= high.x);
    !near.filter(|node| node.y >= low.y && node.y <= high.y).any(|node| contains(line, *node))
}

/// Whether a rectangle lies in one of some blocks, which are sorted by their left sides. None is
/// wider than `widest`.
fn is_within(inner: &Rectangle, blocks: &[Rectangle], widest: f64) -> bool {
    let first = blocks.partition_point(|block| block.low.x < inner.low.x - widest - BESIDE);
    let mut near = blocks[first..].iter().take_while(|block| block.low.x <= inner.low.x + BESIDE);
    near.any(|block| {
        block.low.cmple(inner.low + BESIDE).all() && block.high.cmpge(inner.high - BESIDE).all()
    })
}

/// The area of an outline over half of its length: nearly the width of a long rectangle.
fn mean_width(line: &[DVec2]) -> f64 {
    let sides = line.windows(2).map(|ends| (ends[0], ends[1]));
    let twice_area: f64 = sides.clone().map(|(from, to)| from.perp_dot(to)).sum();
    let length: f64 = sides.map(|(from, to)| from.distance(to)).sum();
    if length > 0.0 { twice_area.abs() / length } else { 0.0 }
}

/// Whether a point is inside an outline: a ray from it to the east crosses it an odd number of
/// times.
fn contains(line: &[DVec2], point: DVec2) -> bool {
    let crossings = line.windows(2).filter(|ends| {
        let (from, to) = (ends[0], ends[1]);
        (from.y > point.y) != (to.y > point.y)
            && point.x < from.x + (to.x - from.x) * (point.y - from.y) / (to.y - from.y)
    });
    crossings.count() % 2 == 1
}

impl Rectangle {
    fn around(line: &[DVec2]) -> Self {
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in line {
            (low, high) = (low.min(*point), high.max(*point));
        }
        Self { low, high }
    }
}

#[cfg(test)]
mod tests {
    use glam::dvec2;

    use super::*;

    fn outline(low: (f64, f64), high: (f64, f64)) -> Vec<DVec2> {
        let corners = [low, (high.0, low.1), high, (low.0, high.1), low];
        corners.map(DVec2::from).to_vec()
    }

    #[test]
    fn racks_are_outlines_that_robots_drive_around_and_the_lines_within() {
        let (floor, rack) = (outline((-4.0, -4.0), (40.0, 20.0)), outline((1.0, 1.0), (3.4, 15.0)));
        let bays = vec![dvec2(1.0, 5.0), dvec2(3.4, 5.0), dvec2(2.2, 15.0), dvec2(2.2, 1.0)];
        let wall = vec![dvec2(10.0, 0.0), dvec2(10.0, 9.0)];
        let thin = outline((12.0, 0.0), (12.3, 9.0));
        let room = outline((20.0, 0.0), (30.0, 9.0));
        let locked = outline((31.0, 0.0), (39.0, 9.0));
        let nodes = [(0.0, 0.0), (25.0, 5.0), (2.0, 17.0)].map(DVec2::from);
        let lines = [bays, floor, rack, wall, thin, room, locked, Vec::new()];
        use LineKind::{Rack, Wall};
        assert_eq!(kinds(&lines, nodes), [Rack, Wall, Rack, Wall, Wall, Wall, Wall, Wall]);
    }

    #[test]
    fn without_a_route_graph_outlines_are_racks_unless_they_are_thin() {
        let lines = [outline((0.0, 0.0), (5.0, 5.0)), outline((0.0, 0.0), (5.0, 0.2))];
        assert_eq!(kinds(&lines, []), [LineKind::Rack, LineKind::Rack], "it lies in the first");
        assert_eq!(kinds(&lines[1..], []), [LineKind::Wall]);
    }
}
