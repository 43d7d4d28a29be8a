//! Statistics of a route graph.

use std::fmt;

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use regatta_base::graph::{EdgeIndex, NodeIndex};
use serde::Serialize;

use super::components::Components;
use super::facilities::{Door, Lift};
use super::route_graph::RouteGraph;
use super::value::{plural, shorten};

/// The statistics of a route graph.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Info {
    /// The number of nodes.
    pub nodes: usize,
    /// The number of edges.
    pub edges: usize,
    /// The number of edges that may also be driven in reverse gear.
    pub reversible_edges: usize,
    /// The number of nodes that no leg leaves. (A dead end is another thing: robots come out of it
    /// where they went in.)
    pub without_way_out: usize,
    /// The lengths of the edges in metres.
    pub length: Lengths,
    /// The smallest rectangle, in metres, that contains all nodes and curves.
    pub bounding_box: BoundingBox,
    /// The position of the graph's (0, 0) in the file, in metres.
    pub origin: [f64; 2],
    /// The speeds from origin to destination in metres per second, without the rides of lifts.
    pub speed: Range,
    /// The speeds in reverse gear in metres per second, of the edges that allow it; `None` if no
    /// edge does.
    pub reverse_speed: Option<Range>,
    /// The weakly connected components.
    pub weak_components: ComponentSummary,
    /// The strongly connected components.
    pub strong_components: ComponentSummary,
    /// The number of zones with a rule for the robots in them.
    pub zones: usize,
    /// The doors.
    pub doors: Vec<DoorInfo>,
    /// The lifts.
    pub lifts: Vec<LiftInfo>,
}

/// A door.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DoorInfo {
    /// The name.
    pub name: String,
    /// The number of edges that lead through it.
    pub edges: usize,
    /// Seconds from closed to open.
    pub opening_secs: f64,
    /// Seconds from open to closed.
    pub closing_secs: f64,
}

/// A lift.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LiftInfo {
    /// The name.
    pub name: String,
    /// The names of its levels, from the lowest to the highest.
    pub levels: Vec<String>,
    /// Seconds of the cabin from a level to the next.
    pub level_secs: f64,
    /// Seconds from closed to open of its doors.
    pub opening_secs: f64,
    /// Seconds from open to closed.
    pub closing_secs: f64,
    /// The largest number of robots in the cabin.
    pub capacity: u32,
}

/// The lengths of edges in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Lengths {
    /// The sum over all edges.
    pub total: f64,
    /// The shortest edge.
    pub shortest: f64,
    /// The longest edge.
    pub longest: f64,
}

/// An axis-parallel rectangle in metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BoundingBox {
    /// West.
    pub min_x: f64,
    /// South.
    pub min_y: f64,
    /// East.
    pub max_x: f64,
    /// North.
    pub max_y: f64,
}

/// The range of a set of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Range {
    /// The least number.
    pub least: f64,
    /// The greatest number.
    pub greatest: f64,
}

/// The number of components and the size of the largest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ComponentSummary {
    /// The number of components.
    pub count: usize,
    /// The number of nodes of the largest component.
    pub largest: u32,
}

impl Info {
    /// Computes the statistics of a graph.
    ///
    /// ```
    /// use regatta_layout::model::info::Info;
    /// use regatta_layout::{ReadOptions, parse};
    ///
    /// let text = "id,x,y\nA,0,0\nB,10,0\n\nfrom,to,speed\nA,B,1\n";
    /// let (graph, _) = parse(text, "road.csv", &ReadOptions::default())?;
    /// let info = Info::of(&graph);
    /// assert_eq!((info.nodes, info.without_way_out, info.strong_components.count), (2, 1, 2));
    /// # Ok::<(), regatta_layout::GraphError>(())
    /// ```
    pub fn of(graph: &RouteGraph) -> Self {
        let edges = graph.edges();
        let nodes = graph.nodes().len();
        // The rides of lifts have the speeds of cabins.
        let driven = (0..).map(EdgeIndex).zip(edges);
        let driven = driven.filter(|(index, _)| !graph.is_ride(*index));
        let reverse = driven.clone().filter_map(|(_, edge)| edge.reverse_speed);
        Self {
            nodes,
            edges: edges.len(),
            reversible_edges: edges.iter().filter(|edge| edge.reverse_speed.is_some()).count(),
            without_way_out: (0..nodes as u32)
                .filter(|&node| graph.departures(NodeIndex(node)).is_empty())
                .count(),
            length: Lengths::of(graph),
            bounding_box: BoundingBox::of(graph),
            origin: graph.origin().to_array(),
            speed: Range::of(driven.map(|(_, edge)| edge.speed)),
            reverse_speed: Some(Range::of(reverse)).filter(|range| range.least <= range.greatest),
            weak_components: ComponentSummary::of(&Components::weak(graph)),
            strong_components: ComponentSummary::of(&Components::strong(graph)),
            zones: graph.zones().len(),
            doors: graph.doors().iter().map(DoorInfo::of).collect(),
            lifts: graph.lifts().iter().map(LiftInfo::of).collect(),
        }
    }
}

impl DoorInfo {
    fn of(door: &Door) -> Self {
        Self {
            name: door.name.to_string(),
            edges: door.edges.len(),
            opening_secs: door.times.opening_secs,
            closing_secs: door.times.closing_secs,
        }
    }
}

impl LiftInfo {
    fn of(lift: &Lift) -> Self {
        Self {
            name: lift.name.to_string(),
            levels: lift.levels.iter().map(|level| level.name.to_string()).collect(),
            level_secs: lift.level_secs,
            opening_secs: lift.door_times.opening_secs,
            closing_secs: lift.door_times.closing_secs,
            capacity: lift.places().get(),
        }
    }
}

impl Lengths {
    fn of(graph: &RouteGraph) -> Self {
        let lengths: Vec<f64> = graph.edges().iter().map(|edge| edge.path.length()).collect();
        let Range { least, greatest } = Range::of(lengths.iter().copied());
        Self { total: lengths.iter().sum(), shortest: least, longest: greatest }
    }
}

impl BoundingBox {
    /// Returns the smallest rectangle that contains all nodes and curves of a graph.
    pub fn of(graph: &RouteGraph) -> Self {
        let nodes = graph.nodes().iter().map(|node| node.position);
        let (min, max) = graph
            .edges()
            .iter()
            .flat_map(|edge| edge.path.cubics().flat_map(extremes))
            .chain(nodes)
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), point| {
                (min.min(point), max.max(point))
            });
        Self { min_x: min.x, min_y: min.y, max_x: max.x, max_y: max.y }
    }

    /// Returns the smallest rectangle that also contains these points.
    pub fn with(self, points: impl Iterator<Item = DVec2>) -> Self {
        points.fold(self, |bounds, point| Self {
            min_x: bounds.min_x.min(point.x),
            min_y: bounds.min_y.min(point.y),
            max_x: bounds.max_x.max(point.x),
            max_y: bounds.max_y.max(point.y),
        })
    }

    /// Returns the extent from west to east and from south to north in metres.
    pub fn size(&self) -> DVec2 {
        DVec2::new(self.max_x - self.min_x, self.max_y - self.min_y)
    }
}

/// Returns the points where a curve can have its extremes in x and y: its ends and the zeros of p'x
/// and p'y.
fn extremes(curve: &CubicBezier) -> impl Iterator<Item = DVec2> + use<> {
    let curve = *curve;
    let [p0, p1, p2, p3] = curve.control_points;
    // p' / 3 = a λ² + b λ + c
    let (a, b, c) = (p3 - p0 - (p2 - p1) * 3.0, (p2 - p1 * 2.0 + p0) * 2.0, p1 - p0);
    let roots = [roots(a.x, b.x, c.x), roots(a.y, b.y, c.y)];
    roots.into_iter().flatten().chain([0.0, 1.0]).map(move |lambda| curve.position(lambda))
}

/// Returns the roots of a λ² + b λ + c clamped to [0, 1]; 0 in place of roots that don't exist.
fn roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let q = -0.5 * (b + (b * b - 4.0 * a * c).max(0.0).sqrt().copysign(b));
    [q / a, c / q].map(|root| if root.is_finite() { root.clamp(0.0, 1.0) } else { 0.0 })
}

impl Range {
    fn of(numbers: impl Iterator<Item = f64>) -> Self {
        numbers.fold(Self { least: f64::INFINITY, greatest: f64::NEG_INFINITY }, |range, number| {
            Self { least: range.least.min(number), greatest: range.greatest.max(number) }
        })
    }
}

impl ComponentSummary {
    fn of(components: &Components) -> Self {
        Self {
            count: components.sizes.len(),
            largest: components.sizes.iter().copied().max().unwrap_or(0),
        }
    }
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { length, bounding_box: bounds, .. } = self;
        let size = bounds.size();
        writeln!(f, "nodes       {} ({} without a way out)", self.nodes, self.without_way_out)?;
        writeln!(f, "edges       {} ({} also in reverse gear)", self.edges, self.reversible_edges)?;
        writeln!(
            f,
            "length      {:.1} m (an edge has {:.2} to {:.2} m)",
            length.total, length.shortest, length.longest
        )?;
        writeln!(
            f,
            "extent      {:.1} m × {:.1} m: x {:.2} to {:.2}, y {:.2} to {:.2}",
            size.x, size.y, bounds.min_x, bounds.max_x, bounds.min_y, bounds.max_y
        )?;
        if self.origin != [0.0; 2] {
            let [x, y] = self.origin;
            writeln!(f, "origin      x {x}, y {y} in the file: positions are relative to it")?;
        }
        writeln!(f, "speed       {} forward", self.speed)?;
        if let Some(backwards) = self.reverse_speed {
            writeln!(f, "            {backwards} backwards")?;
        }
        write!(
            f,
            "components  {}, {} strong",
            self.weak_components.count, self.strong_components.count
        )?;
        writeln!(f, " (the largest has {} nodes)", self.strong_components.largest)?;
        if self.zones > 0 {
            writeln!(f, "zones       {} with a rule, which the fleet manager keeps", self.zones)?;
        }
        write_list(f, "doors", &self.doors)?;
        write_list(f, "lifts", &self.lifts)
    }
}

/// The largest number of doors, and of lifts, that are listed.
const MAX_LISTED: usize = 20;

/// Writes a line for each item, with a heading before the first.
fn write_list<T: fmt::Display>(
    f: &mut fmt::Formatter<'_>,
    heading: &str,
    items: &[T],
) -> fmt::Result {
    for (index, item) in items.iter().take(MAX_LISTED).enumerate() {
        writeln!(f, "{:11} {item}", if index == 0 { heading } else { "" })?;
    }
    match items.len().saturating_sub(MAX_LISTED) {
        0 => Ok(()),
        more => writeln!(f, "{:11} and {more} more", ""),
    }
}

impl fmt::Display for DoorInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, opening_secs, closing_secs, .. } = self;
        let (name, edges) = (shorten(name), plural(self.edges, "edge"));
        write!(f, "{name} on {edges}, opens in {opening_secs:.1} s, closes in {closing_secs:.1} s")
    }
}

impl fmt::Display for LiftInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { level_secs, opening_secs, closing_secs, .. } = self;
        let levels: Vec<String> = self.levels.iter().map(|level| shorten(level)).collect();
        let robots = plural(self.capacity as usize, "robot");
        write!(
            f,
            "{} for {robots}, levels {}: {level_secs:.1} s a level, its doors open in \
             {opening_secs:.1} s and close in {closing_secs:.1} s",
            shorten(&self.name),
            levels.join(", ")
        )
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.least == self.greatest {
            return write!(f, "{} m/s", self.least);
        }
        write!(f, "{} to {} m/s", self.least, self.greatest)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::model::options::ReadOptions;
    use crate::parse;

    #[test]
    fn statistics_of_an_arch() {
        let text = "Vertices:\n- {Id: 1, X: 0, Y: 0, Theta: 1.5707963267948966}\n- {Id: 2, X: 4, Y: 0, Theta: -1.5707963267948966}\n\
            Edges:\n- {Id: 1, Origin_ID: 1, Destination_ID: 2, CurveType: Spline, ParamF: 4, ParamB: 4, VelocityForward: 2, VelocityBackwards: 1}\n";
        let info = Info::of(&parse(text, "g", &ReadOptions::default()).unwrap().0);
        let bounds = info.bounding_box;
        assert!(
            bounds.min_x.abs() < 1e-9
                && bounds.min_y.abs() < 1e-9
                && (bounds.max_x - 4.0).abs() < 1e-9
        );
        assert!(
            (bounds.max_y - 3.0).abs() < 1e-9,
            "the top is that of the arch, not of its handles"
        );
        assert_eq!(
            (info.nodes, info.edges, info.reversible_edges, info.without_way_out),
            (2, 1, 1, 0)
        );
        assert_eq!(info.strong_components, ComponentSummary { count: 1, largest: 2 });
        assert!(info.to_string().contains("2 m/s forward\n            1 m/s backwards"), "{info}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 256 }))]

        #[test]
        fn a_curve_stays_within_its_extremes(points in prop::array::uniform8(-9.0..9.0), lambda in 0.0..=1.0) {
            let at = |i: usize| DVec2::new(points[i], points[i + 1]);
            let curve = CubicBezier { control_points: [at(0), at(2), at(4), at(6)] };
            let point = curve.position(lambda);
            let least = extremes(&curve).fold(DVec2::INFINITY, DVec2::min) - DVec2::splat(1e-9);
            let most = extremes(&curve).fold(DVec2::NEG_INFINITY, DVec2::max) + DVec2::splat(1e-9);
            prop_assert!(point.cmpge(least).all() && point.cmple(most).all());
        }
    }
}
