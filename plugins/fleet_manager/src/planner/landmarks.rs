//! Lower bounds of driving times, from the driving times to and from some landmarks.
//!
//! By the triangle inequality, the driving time from a node to a goal is at least the difference of
//! their driving times to a landmark, or from one. A. Goldberg, C. Harrelson: Computing the
//! Shortest Path: A* Search Meets Graph Theory, SODA 2005. Landmarks are chosen as they propose for
//! graphs in the plane: one near the rim in each direction.

use glam::Vec2;
use regatta_base::cores::map_on;
use regatta_base::rows::Rows;

use crate::roads::{Roads, lower_costs};

/// The number of landmarks: the times of a node then fill a cache line.
const LANDMARKS: usize = 16;

/// Driving times in forward gear between all nodes and some landmarks.
#[derive(Clone, Debug, PartialEq)]
pub struct Landmarks {
    /// By node: the times to each landmark, and from each, in units; the largest number is also
    /// that of longer ways, and of ways that don't exist.
    times: Vec<[[u16; LANDMARKS]; 2]>,
    /// Seconds; a power of two.
    unit: f32,
}

impl Landmarks {
    /// Computes all driving times at once, on all cores. `delay` is, by edge, the least time that
    /// it takes beyond that on empty roads, in seconds.
    pub fn new(roads: &Roads, delay: &[f32]) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let mut survey = Survey::new(roads, delay);
        survey.go_on(usize::MAX, cores);
        survey.landmarks()
    }

    /// Returns a lower bound of the time between two nodes in forward gear, in seconds, for robots
    /// of any class. Along a leg it falls by no more than the leg's time.
    pub fn least_secs(&self, node: u32, goal: u32) -> f32 {
        let ([to, from], [goal_to, goal_from]) =
            (&self.times[node as usize], &self.times[goal as usize]);
        let mut least = 0;
        for landmark in 0..LANDMARKS {
            let towards = to[landmark].saturating_sub(goal_to[landmark]);
            let away = goal_from[landmark].saturating_sub(from[landmark]);
            least = least.max(towards).max(away);
        }
        f32::from(least) * self.unit
    }
}

/// The shortest unit of time, in seconds. Multiples of a power of two are exact.
const SHORTEST_UNIT: f32 = 1.0 / 32.0;
/// The longest time; also that of ways that don't exist.
const LONGEST: u16 = u16::MAX;

/// A computation of driving times that is under way.
#[derive(Clone, Debug)]
pub struct Survey {
    landmarks: Vec<u32>,
    /// The ways away from nodes, and those towards them.
    ways: [Ways; 2],
    /// To each landmark, and from each, alternately.
    trees: Vec<Vec<u16>>,
    unit: f32,
}

impl Survey {
    /// Begins with roads on which each edge takes at least so many seconds beyond the driving time
    /// on empty roads.
    pub fn new(roads: &Roads, delay: &[f32]) -> Self {
        let unit = SHORTEST_UNIT;
        let ways = [Ways::new(roads, true), Ways::new(roads, false)];
        let mut survey = Self { landmarks: choose(roads), ways, trees: Vec::new(), unit };
        survey.begin(roads, delay);
        survey
    }

    /// Starts again, with other delays.
    pub fn begin(&mut self, roads: &Roads, delay: &[f32]) {
        let fastest = roads.classes().iter().map(|class| class.max_speed).fold(0.0, f32::max);
        if self.trees.iter().flatten().any(|time| (LONGEST / 8 * 7..LONGEST).contains(time)) {
            self.unit *= 2.0;
        }
        self.trees.clear();
        // Rounded down leg by leg, and not way by way: so the bound falls by no more than a leg's
        // time along it.
        let times = roads.edges().iter().zip(delay).map(|(road, delay)| {
            let secs = road.length / road.speed.min(fastest) + road.delay_secs + delay;
            (secs / self.unit) as u32
        });
        let times: Vec<u32> = times.collect();
        for ways in &mut self.ways {
            for (way, edge) in ways.ways.values_mut().iter_mut().zip(&ways.edges) {
                way.time = times[*edge as usize];
            }
        }
    }

    /// Computes so many more trees, on some threads; returns whether there is none left.
    pub fn go_on(&mut self, trees: usize, threads: usize) -> bool {
        let (ways, landmarks) = (&self.ways, &self.landmarks);
        let first = self.trees.len();
        let count = (2 * landmarks.len() - first).min(trees);
        self.trees.extend(map_on(threads, count, |index| {
            let number = first + index;
            ways[number % 2].times(landmarks[number / 2])
        }));
        self.trees.len() == 2 * self.landmarks.len()
    }

    /// The result, after the last tree.
    pub fn landmarks(&self) -> Landmarks {
        let mut times = vec![[[0; LANDMARKS]; 2]; self.ways[0].ways.len()];
        for (number, tree) in self.trees.iter().enumerate() {
            for (times, &time) in times.iter_mut().zip(tree) {
                times[number % 2][number / 2] = time;
            }
        }
        Landmarks { times, unit: self.unit }
    }
}

/// Returns the landmarks: in each of as many sectors round the middle, the node that is farthest
/// out.
fn choose(roads: &Roads) -> Vec<u32> {
    let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for position in (0..roads.nodes()).map(|node| roads.position(node)) {
        (low, high) = (low.min(position), high.max(position));
    }
    let mut farthest = [(0.0, None); LANDMARKS];
    for node in 0..roads.nodes() {
        if roads.exits(node).is_empty() || roads.arrival(node).is_none() {
            continue;
        }
        // Plants that are much longer than wide have landmarks all round, too.
        let Vec2 { x, y } =
            (roads.position(node) - 0.5 * (low + high)) / (high - low).max(Vec2::ONE);
        let sector = (y.atan2(x) / core::f32::consts::TAU + 0.5) * LANDMARKS as f32;
        let best = &mut farthest[(sector as usize).min(LANDMARKS - 1)];
        if best.1.is_none() || x * x + y * y > best.0 {
            *best = (x * x + y * y, Some(node));
        }
    }
    farthest.into_iter().filter_map(|(_, node)| node).collect()
}

/// The ways between neighbours.
#[derive(Clone, Debug)]
struct Ways {
    /// By node.
    ways: Rows<Way>,
    /// The edge of each way.
    edges: Vec<u32>,
}

/// A way to a neighbour.
#[derive(Clone, Copy, Debug)]
struct Way {
    node: u32,
    /// In units.
    time: u32,
}

impl Ways {
    /// The ways away from nodes, or those towards them, without times.
    fn new(roads: &Roads, towards: bool) -> Self {
        let edges = (0..).zip(roads.edges()).filter(|(_, edge)| edge.speed > 0.0);
        let mut ways: Vec<[u32; 3]> = edges
            .map(|(index, edge)| match towards {
                true => [edge.destination, index, edge.origin],
                false => [edge.origin, index, edge.destination],
            })
            .collect();
        ways.sort_unstable();
        let edges = ways.iter().map(|[_, edge, _]| *edge).collect();
        let ways = ways.into_iter().map(|[from, _, node]| (from, Way { node, time: 0 }));
        Self { ways: Rows::of_sorted(roads.nodes() as usize, ways), edges }
    }

    /// Returns the times of all nodes from a landmark, or to it, in units.
    fn times(&self, landmark: u32) -> Vec<u16> {
        let mut times = vec![LONGEST; self.ways.len()];
        lower_costs(&mut times, [(landmark, 0)], |node, so_far: u16| {
            self.ways.row(node).iter().map(move |way| {
                (way.node, u16::try_from(way.time).unwrap_or(LONGEST).saturating_add(so_far))
            })
        });
        times
    }
}
