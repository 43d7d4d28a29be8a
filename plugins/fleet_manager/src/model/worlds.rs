//! Worlds to drive in.

use regatta_plugin::world::{
    CurveRecord, EdgeRecord, NodeRecord, Orientation, RobotTypeRecord, WorldData,
};

/// A world of straight edges between points, for robots of some length and width, in metres; all
/// drive at 1 m/s.
pub fn straight(
    points: &[[f32; 2]],
    edges: &[[u32; 2]],
    size: [f32; 2],
    orientation: Orientation,
) -> WorldData {
    let mut world = WorldData {
        robot_types: vec![RobotTypeRecord::new("", size[0], size[1])],
        ..WorldData::default()
    };
    world.robot_types[0].max_rotation_speed = 0.0;
    for (id, &[x, y]) in (0..).zip(points) {
        world.nodes.push(NodeRecord { id, x, y, ..NodeRecord::default() });
    }
    for (id, &[origin, destination]) in (0..).zip(edges) {
        let [from, to] = [origin, destination].map(|node| points[node as usize]);
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let edge =
            EdgeRecord { id, origin, destination, length, speed: 1.0, ..EdgeRecord::default() };
        world.add_edge(edge.with_orientation(orientation), [CurveRecord::straight(from, to)]);
    }
    world
}

/// One-way streets on a square grid, each row and column against its neighbours.
pub fn streets(side: u32, spacing: f32, turns: bool) -> WorldData {
    let node = |column: u32, row: u32| row * side + column;
    let points: Vec<[f32; 2]> = (0..side * side)
        .map(|node| [spacing * (node % side) as f32, spacing * (node / side) as f32])
        .collect();
    let mut edges = Vec::new();
    for (line, step) in (0..side).flat_map(|line| (0..side - 1).map(move |step| (line, step))) {
        let [a, b] = if line % 2 == 0 { [step, step + 1] } else { [step + 1, step] };
        edges.push([node(a, line), node(b, line)]);
        edges.push([node(line, b), node(line, a)]);
    }
    let mut world = straight(&points, &edges, [0.9, 0.6], Orientation::Tangential);
    world.robot_types[0].max_rotation_speed = if turns { 1.0 } else { 0.0 };
    world
}

/// A grid of 1 m cells with edges in both directions, for squares of 0.6 m that don't rotate.
pub fn cells(side: u32) -> WorldData {
    let node = |column: u32, row: u32| row * side + column;
    let points: Vec<[f32; 2]> =
        (0..side * side).map(|node| [(node % side) as f32, (node / side) as f32]).collect();
    let mut edges = Vec::new();
    for (line, step) in (0..side).flat_map(|line| (0..side - 1).map(move |step| (line, step))) {
        for [a, b] in [[step, step + 1], [step + 1, step]] {
            edges.push([node(a, line), node(b, line)]);
            edges.push([node(line, a), node(line, b)]);
        }
    }
    straight(&points, &edges, [0.6, 0.6], Orientation::Fixed(0.0))
}

/// A track of 4 m sections that is driven both ways, with a second track beside each third section,
/// and one more beside the last. Robots don't rotate.
pub fn single_track(sections: u32) -> WorldData {
    let mut points: Vec<[f32; 2]> =
        (0..=sections).map(|section| [4.0 * section as f32, 0.0]).collect();
    let mut edges: Vec<[u32; 2]> = (0..sections)
        .flat_map(|section| [[section, section + 1], [section + 1, section]])
        .collect();
    let mut join = |points: &mut Vec<[f32; 2]>, [a, b]: [u32; 2], [x, y]: [f32; 2]| {
        let middle = points.len() as u32;
        points.push([x, y]);
        edges.extend([[a, middle], [middle, a], [middle, b], [b, middle]]);
    };
    for section in (0..sections).filter(|section| section % 3 == 0) {
        join(&mut points, [section, section + 1], [4.0 * section as f32 + 2.0, 3.0]);
    }
    let end = [4.0 * (sections - 1) as f32 + 2.0, -3.0];
    join(&mut points, [sections - 1, sections], end);
    straight(&points, &edges, [0.9, 0.6], Orientation::Fixed(0.0))
}

/// A one-way ring of eight edges of 6 m, with a dead end of 5 m sections that is driven both ways.
/// Robots don't rotate.
pub fn ring_with_stub(sections: u32) -> WorldData {
    let ring = [[0, 0], [1, 0], [2, 0], [2, 1], [2, 2], [1, 2], [0, 2], [0, 1]];
    let mut points: Vec<[f32; 2]> =
        ring.iter().map(|&[x, y]| [6.0 * x as f32, 6.0 * y as f32]).collect();
    let mut edges: Vec<[u32; 2]> = (0..8).map(|node| [node, (node + 1) % 8]).collect();
    for section in 1..=sections {
        points.push([6.0, -5.0 * section as f32]);
        let (inner, outer) = (if section == 1 { 1 } else { 6 + section }, 7 + section);
        edges.extend([[inner, outer], [outer, inner]]);
    }
    straight(&points, &edges, [0.9, 0.6], Orientation::Fixed(0.0))
}

/// The graph of the dissertation, for robots of 0.9 m by 0.6 m.
pub fn porto() -> WorldData {
    let text = include_str!("../../../../graphs/porto.yaml");
    let mut world =
        WorldData { robot_types: vec![RobotTypeRecord::new("", 0.9, 0.6)], ..WorldData::default() };
    world.robot_types[0].max_rotation_speed = 0.0;
    for line in text.lines().filter(|line| line.starts_with("- {") && line.contains("Theta:")) {
        let [x, y, theta] = ["X", "Y", "Theta"].map(|key| number(line, key));
        world.nodes.push(NodeRecord {
            id: number(line, "Id") as u32,
            x,
            y,
            theta,
            ..NodeRecord::default()
        });
    }
    for line in text.lines().filter(|line| line.starts_with("- {") && line.contains("Origin_ID:")) {
        let node = |key: &str| {
            let id = number(line, key) as u32;
            world.nodes.iter().position(|node| node.id == id).expect("a node")
        };
        let [origin, destination] = [node("Origin_ID"), node("Destination_ID")];
        let [a, b] = [origin, destination]
            .map(|index| (world.nodes[index].x, world.nodes[index].y, world.nodes[index].theta));
        let curve = if line.contains("spline") {
            let [out, into] = [number(line, "ParamB"), number(line, "ParamF")];
            let first = [a.0 + out * a.2.cos(), a.1 + out * a.2.sin()];
            let second = [b.0 - into * b.2.cos(), b.1 - into * b.2.sin()];
            CurveRecord { control_points: [[a.0, a.1], first, second, [b.0, b.1]] }
        } else {
            CurveRecord::straight([a.0, a.1], [b.0, b.1])
        };
        let edge = EdgeRecord {
            id: number(line, "Id") as u32,
            origin: origin as u32,
            destination: destination as u32,
            speed: number(line, "VelocityForward"),
            reverse_speed: number(line, "VelocityBackwards"),
            ..EdgeRecord::default()
        };
        world.add_edge(edge, [curve]);
    }
    world
}

/// The number behind a key in a line of YAML.
fn number(line: &str, key: &str) -> f32 {
    let rest = line.split_once(&format!("{key}:")).map(|(_, rest)| rest).expect("the key");
    rest.split([',', '}']).next().and_then(|value| value.trim().parse().ok()).expect("a number")
}
