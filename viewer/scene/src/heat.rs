//! The heat map: which curves are drawn, and how hot, for a figure of the traffic on edges.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use bytemuck::{Pod, Zeroable};
use regatta_base::round;
use regatta_plugin::traffic::EdgeTraffic;
use regatta_plugin::{Traffic, World};
use serde::{Deserialize, Serialize};

use crate::curves::midpoint;

/// The share of edges with a value that are hotter than the hot end of the scale: a few extremes
/// would leave the rest cold.
const BEYOND: f32 = 0.01;

/// A figure of the traffic on an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Figure {
    /// The mean number of robots.
    Occupancy,
    /// Robots that enter, per hour.
    Throughput,
    /// The mean speed over the speed limit. Slow is hot.
    Speed,
    /// Seconds that robots have waited.
    #[default]
    Waiting,
    /// Seconds that robots have touched others.
    Contacts,
    /// Robots whose routes lead over it, released or planned.
    Routes,
}

/// The period of a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Period {
    /// The last minute.
    Minute,
    /// The last ten minutes.
    #[default]
    TenMinutes,
    /// The run so far.
    Run,
}

/// The content of a heat map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heat {
    /// The figure.
    pub figure: Figure,
    /// Its period.
    pub period: Period,
}

/// The error of parsing a [`Heat`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is not a heat map such as waiting:10min; figures are occupancy, throughput, speed, \
     waiting, contacts and routes, windows are minute, 10min and run"
)]
pub struct HeatError(String);

impl Figure {
    /// All figures, in the order of menus.
    pub const ALL: [Self; 6] = [
        Self::Occupancy,
        Self::Throughput,
        Self::Speed,
        Self::Waiting,
        Self::Contacts,
        Self::Routes,
    ];

    /// The name in options and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Occupancy => "occupancy",
            Self::Throughput => "throughput",
            Self::Speed => "speed",
            Self::Waiting => "waiting",
            Self::Contacts => "contacts",
            Self::Routes => "routes",
        }
    }

    /// The name and the unit for people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Occupancy => "robots on the edge",
            Self::Throughput => "robots per hour",
            Self::Speed => "mean speed, % of the limit",
            Self::Waiting => "waiting, s",
            Self::Contacts => "contact, s",
            Self::Routes => "routes over the edge",
        }
    }

    /// Returns the value of an edge, in the unit of the title; `None` if it has none.
    pub fn value(self, edge: &EdgeTraffic) -> Option<f32> {
        let value = match self {
            Self::Occupancy => edge.occupancy,
            Self::Throughput => edge.entered_per_hour,
            // A standing robot has a speed, which an edge without robots has not.
            Self::Speed => return (edge.occupancy > 0.0).then_some(100.0 * edge.relative_speed),
            Self::Waiting => edge.waiting_secs,
            Self::Contacts => edge.contact_secs,
            Self::Routes => edge.released + edge.planned,
        };
        (value > 0.0).then_some(value)
    }

    /// Compares two edges: the hotter one comes first.
    fn compare(self, one: &HotEdge, other: &HotEdge) -> Ordering {
        match self {
            Self::Speed => one.value.total_cmp(&other.value),
            _ => other.value.total_cmp(&one.value),
        }
    }
}

impl Period {
    /// All periods, the shortest first, as in [`Traffic::periods`].
    pub const ALL: [Self; 3] = [Self::Minute, Self::TenMinutes, Self::Run];

    /// The name in options and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Minute => "minute",
            Self::TenMinutes => "10min",
            Self::Run => "run",
        }
    }

    /// Its length in simulated seconds, if it has one.
    pub fn length_secs(self) -> Option<u64> {
        match self {
            Self::Minute => Some(60),
            Self::TenMinutes => Some(600),
            Self::Run => None,
        }
    }

    /// The name for people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Minute => "last minute",
            Self::TenMinutes => "last ten minutes",
            Self::Run => "the run so far",
        }
    }
}

impl fmt::Display for Heat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.figure.name(), self.period.name())
    }
}

impl FromStr for Heat {
    type Err = HeatError;

    fn from_str(text: &str) -> Result<Self, HeatError> {
        let (figure, period) = text.split_once(':').unwrap_or((text, Period::default().name()));
        let figure = Figure::ALL.into_iter().find(|known| known.name() == figure);
        let period = Period::ALL.into_iter().find(|known| known.name() == period);
        let (Some(figure), Some(period)) = (figure, period) else {
            return Err(HeatError(text.to_owned()));
        };
        Ok(Self { figure, period })
    }
}

/// A curve of an edge with a value: an instance of heat.wgsl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct HotCurve {
    /// Index of the curve in the world.
    pub curve: u32,
    /// From 0, cold, to 1, hot.
    pub level: f32,
}

/// The scale of a heat map, and the sources of its figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatFacts {
    /// The figure and its period.
    pub heat: Heat,
    /// The values of the coldest and of the hottest colour.
    pub ends: [f32; 2],
    /// Whether some edges are beyond the hot end.
    pub is_exceeded: bool,
    /// The number of edges that have a value.
    pub edges: u32,
    /// The length of the period so far, in simulated seconds.
    pub secs: f32,
    /// Whether a collision checker runs.
    pub has_contacts: bool,
    /// Whether routes are known.
    pub has_routes: bool,
}

/// The heat map, to be drawn: the hottest curves last, so that they are over the others.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// Curves that are straight.
    pub straight: Vec<HotCurve>,
    /// The other ones.
    pub bent: Vec<HotCurve>,
    /// The hottest places, the hottest first, at most [`LABELLED`] on each level.
    pub hottest: Vec<HotEdge>,
    /// The scale.
    pub facts: HeatFacts,
}

/// An edge that is hotter than those around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HotEdge {
    /// Its index in the world.
    pub edge: u32,
    /// Its value, in the unit of the figure's title.
    pub value: f32,
}

/// The number of places of a heat map that are labelled.
pub const LABELLED: usize = 5;
/// The part of the layout's extent within which two edges are one hot place, unless a level has too
/// few places then.
const ONE_PLACE: f32 = 0.06;
/// The distance in metres within which two edges are one place in any case, as two ways of a street
/// are.
const SAME_PLACE: f32 = 1.0;

impl HeatMap {
    /// Works out the heat map of a world's edges.
    pub fn new(heat: Heat, traffic: &Traffic<'_>, world: &World<'_>) -> Self {
        let period =
            Period::ALL.iter().position(|period| *period == heat.period).unwrap_or_default();
        let figures = traffic.periods[period];
        let edges = world.edges().iter().zip(figures);
        let values: Vec<f32> =
            edges.clone().filter_map(|(_, figures)| heat.figure.value(figures)).collect();
        let (ends, is_exceeded) = scale(heat.figure, &values);
        // Heat and curve in one number, which is sorted faster than pairs.
        let mut all = Vec::with_capacity(values.len());
        for (edge, figures) in edges {
            let Some(value) = heat.figure.value(figures) else { continue };
            // Not a negative zero, whose bits are not those of the least number.
            let level = ((value - ends[0]) / (ends[1] - ends[0])).clamp(0.0, 1.0) + 0.0;
            let curves = edge.first_curve..edge.first_curve + world.curves(edge).len() as u32;
            all.extend(curves.map(|curve| u64::from(level.to_bits()) << 32 | u64::from(curve)));
        }
        all.sort_unstable();
        let hot = all
            .into_iter()
            .map(|key| HotCurve { curve: key as u32, level: f32::from_bits((key >> 32) as u32) });
        let is_straight =
            |hot: &HotCurve| world.all_curves().get(hot.curve as usize).is_some_and(is_straight);
        let (straight, bent) = hot.partition(is_straight);
        let facts = HeatFacts {
            heat,
            ends,
            is_exceeded,
            edges: values.len() as u32,
            secs: traffic.header.period_secs[period],
            has_contacts: traffic.header.has_contacts != 0,
            has_routes: traffic.header.has_routes != 0,
        };
        let hottest = hottest(heat.figure, figures, world);
        Self { straight, bent, hottest, facts }
    }
}

/// Returns the hottest edges of a world, one for each place.
fn hottest(figure: Figure, figures: &[EdgeTraffic], world: &World<'_>) -> Vec<HotEdge> {
    let mut levels: BTreeMap<u32, Vec<(HotEdge, glam::Vec2)>> = BTreeMap::new();
    for ((index, edge), figures) in (0..).zip(world.edges()).zip(figures) {
        let (Some(value), Some(middle)) = (figure.value(figures), midpoint(world, edge)) else {
            continue;
        };
        levels.entry(edge.level).or_default().push((HotEdge { edge: index, value }, middle));
    }
    let reach = ONE_PLACE * extent(world);
    let mut found: Vec<HotEdge> = Vec::new();
    for mut edges in levels.into_values() {
        edges.sort_by(|(one, _), (other, _)| figure.compare(one, other));
        found.extend(hottest_of_level(&edges, reach));
    }
    found.sort_by(|one, other| figure.compare(one, other));
    found
}

/// Returns the hottest edges of a level, which are sorted: as far apart as a reach, or nearer to
/// each other if there are too few of them.
fn hottest_of_level(edges: &[(HotEdge, glam::Vec2)], mut reach: f32) -> Vec<HotEdge> {
    loop {
        let found = apart(edges, reach.max(SAME_PLACE));
        if found.len() == LABELLED || reach <= SAME_PLACE {
            return found;
        }
        reach *= 0.5;
    }
}

/// Returns the first edges whose middles are farther apart than a reach.
fn apart(edges: &[(HotEdge, glam::Vec2)], reach: f32) -> Vec<HotEdge> {
    let mut found: Vec<(HotEdge, glam::Vec2)> = Vec::new();
    for (hot, middle) in edges {
        if found.iter().all(|(_, other)| other.distance(*middle) > reach) {
            found.push((*hot, *middle));
        }
        if found.len() == LABELLED {
            break;
        }
    }
    found.into_iter().map(|(hot, _)| hot).collect()
}

/// The longer side of the rectangle round all nodes, in metres.
fn extent(world: &World<'_>) -> f32 {
    let places = world.nodes().iter().map(|node| glam::Vec2::new(node.x, node.y));
    let corners = places.fold(None, |corners, at| match corners {
        None => Some((at, at)),
        Some((low, high)) => Some((at.min(low), at.max(high))),
    });
    corners.map_or(0.0, |(low, high): (glam::Vec2, glam::Vec2)| (high - low).max_element())
}

/// Whether no point of a curve is farther from its chord than a millimetre.
fn is_straight(curve: &regatta_plugin::world::CurveRecord) -> bool {
    let [start, a, b, end] = curve.control_points.map(glam::Vec2::from);
    let chord = (end - start).normalize_or_zero();
    [a, b].iter().all(|point| chord.perp_dot(*point - start).abs() < 1e-3)
}

/// Returns the values of the cold and the hot end, and whether a value is beyond the hot one. The
/// hot end is a round number, so that it seldom changes.
fn scale(figure: Figure, values: &[f32]) -> ([f32; 2], bool) {
    if figure == Figure::Speed {
        return ([100.0, 0.0], false);
    }
    let mut values = values.to_vec();
    let beyond = (values.len() as f32 * BEYOND) as usize;
    let index = values.len().checked_sub(1 + beyond);
    let most = index.map_or(0.0, |index| *values.select_nth_unstable_by(index, f32::total_cmp).1);
    let hot = if most > 0.0 { round::up(most * 0.9999) as f32 } else { 1.0 };
    ([0.0, hot], values.iter().any(|value| *value > hot))
}

#[cfg(test)]
mod tests {
    use regatta_plugin::traffic::TrafficHeader;
    use regatta_plugin::world::{CurveRecord, EdgeRecord, NodeRecord, WorldData};

    use super::*;

    #[test]
    fn heat_maps_are_parsed_as_they_are_printed() {
        for figure in Figure::ALL {
            for period in Period::ALL {
                let heat = Heat { figure, period };
                assert_eq!(heat.to_string().parse(), Ok(heat));
            }
        }
        let speed = Heat { figure: Figure::Speed, period: Period::TenMinutes };
        assert_eq!("speed".parse(), Ok(speed), "ten minutes unless told otherwise");
        for bad in ["", "speed:", "speed:hour", "heat:run", ":run"] {
            assert!(bad.parse::<Heat>().is_err(), "{bad}");
        }
    }

    #[test]
    fn scales_end_at_round_numbers_and_a_few_extremes_do_not_stretch_them() {
        let ends = |values: &[f32]| scale(Figure::Waiting, values);
        assert_eq!(ends(&[]), ([0.0, 1.0], false));
        assert_eq!(ends(&[0.3, 13.0]), ([0.0, 20.0], false));
        assert_eq!(ends(&[5.0]), ([0.0, 5.0], false));
        let mut many = vec![30.0; 200];
        many.push(9_000.0);
        assert_eq!(ends(&many), ([0.0, 50.0], true));
        assert_eq!(scale(Figure::Speed, &[3.0]), ([100.0, 0.0], false));
    }

    #[test]
    fn the_hottest_edges_come_last_and_edges_without_a_value_not_at_all() {
        let mut world = WorldData::default();
        for x in [0.0, 100.0] {
            world.nodes.push(NodeRecord { x, ..NodeRecord::default() });
        }
        let line = CurveRecord::straight([0.0, 0.0], [4.0, 0.0]);
        let bent = CurveRecord { control_points: [[0.0, 0.0], [1.0, 1.0], [3.0, 1.0], [4.0, 0.0]] };
        for curves in [vec![line], vec![line, bent], vec![line]] {
            world.add_edge(EdgeRecord::default(), curves);
        }
        let edge = |waiting_secs, relative_speed, occupancy| EdgeTraffic {
            waiting_secs,
            relative_speed,
            occupancy,
            ..EdgeTraffic::default()
        };
        let edges = [edge(10.0, 0.25, 1.0), edge(2.0, 1.0, 1.0), edge(0.0, 0.0, 0.0)];
        let header =
            TrafficHeader { period_secs: [60.0, 300.0, 300.0], ..TrafficHeader::default() };
        let traffic = Traffic { header: &header, periods: [&edges; 3], missed: 0 };
        let map = |text: &str| {
            HeatMap::new(text.parse().expect("a heat map"), &traffic, &world.view(1, 1))
        };
        let hot = |curve, level| HotCurve { curve, level };
        let waiting = map("waiting");
        assert_eq!(
            (&waiting.straight[..], &waiting.bent[..]),
            (&[hot(1, 0.2), hot(0, 1.0)][..], &[hot(2, 0.2)][..])
        );
        assert_eq!((waiting.facts.secs, waiting.facts.edges), (300.0, 2));
        let edges: Vec<_> = waiting.hottest.iter().map(|hot| (hot.edge, hot.value)).collect();
        assert_eq!(edges, [(0, 10.0), (1, 2.0)], "close together, but there are no others");
        let speed = map("speed:minute");
        assert_eq!(
            speed.straight,
            [hot(1, 0.0), hot(0, 0.75)],
            "slow is hot, and nothing is known of an empty edge"
        );
    }

    #[test]
    fn five_places_are_hot_even_if_all_are_close_together_and_two_ways_of_a_street_are_one() {
        let mut world = WorldData::default();
        for x in [0.0, 1000.0] {
            world.nodes.push(NodeRecord { x, ..NodeRecord::default() });
        }
        let upstairs = world.texts.add("upstairs");
        // Streets of both ways, 4 m apart; then a hotter one on another level.
        for (street, level) in [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0), (0, upstairs)] {
            let y = 4.0 * street as f32;
            for ends in [[[0.0, y], [9.0, y]], [[9.0, y], [0.0, y]]] {
                let line = CurveRecord::straight(ends[0], ends[1]);
                world.add_edge(EdgeRecord { level, ..EdgeRecord::default() }, [line]);
            }
        }
        let figures: Vec<_> = (0..14)
            .map(|edge| EdgeTraffic { waiting_secs: edge as f32 + 1.0, ..EdgeTraffic::default() })
            .collect();
        let places = hottest(Figure::Waiting, &figures, &world.view(1, 1));
        let edges: Vec<_> = places.iter().map(|hot| hot.edge).collect();
        assert_eq!(edges, [13, 11, 9, 7, 5, 3], "one upstairs, and five below");
    }
}
