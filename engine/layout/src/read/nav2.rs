//! Graphs of Nav2's Route Server: GeoJSON. Points are nodes, line strings are directed edges.
//!
//! The Route Server takes an edge's ends from `startid` and `endid`, and drives straight from one
//! to the other. It ignores the geometry of lines. This reader reads a line with inner points as a
//! polyline.

mod feature;
mod metadata;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec2;
use regatta_base::bezier::CubicBezier;
use serde_json::value::RawValue;

use crate::check::validate::MIN_LENGTH;
use crate::model::finding::Report;
use crate::model::options::ReadOptions;
use crate::model::value::shorten;
use crate::read::file::{Ignored, Source, SyntaxError, offset_of};
use crate::read::layout::{DEFAULT_SPEED, Layout, LayoutEdge, LayoutNode, Shape};
use feature::{Feature, Geometry};
use metadata::Special;

/// The key by which our writer marks an edge that is another edge in reverse gear.
pub(crate) const REVERSE_OF: &str = "reverse_of";

/// The largest distance in metres of a line's end from its node.
const MAX_GAP: f64 = 0.01;

/// Reads a Route Server graph.
pub(crate) fn read<'text>(
    source: Source<'text>,
    options: &ReadOptions,
    report: &mut Report<'text>,
) -> Result<Layout, SyntaxError> {
    let root: BTreeMap<String, &RawValue> = serde_json::from_str(source.text)?;
    let mut reader = Reader {
        text: source.text,
        report,
        ignored: Ignored::default(),
        counts: Counts::default(),
    };
    reader.check_root(&root);
    let Some(features) = root.get("features") else {
        return Err(SyntaxError::new(
            1,
            "it has no `features`: a graph of Nav2 is a FeatureCollection of points and lines",
        ));
    };
    let features: Vec<&RawValue> = serde_json::from_str(features.get())?;
    let features: Vec<Feature> =
        features.into_iter().filter_map(|feature| reader.feature(feature)).collect();
    let mut layout = Layout { nodes: reader.nodes(&features), ..Layout::default() };
    layout.edges = reader.edges(&features, &layout.nodes);
    reader.finish();
    keep_level(&mut layout, options, report);
    Ok(layout)
}

/// Drops nodes and edges on other levels than the wanted one. Our writer gives the level.
fn keep_level(layout: &mut Layout, options: &ReadOptions, report: &mut Report<'_>) {
    let Some(wanted) = &options.level else { return };
    layout.nodes.retain(|node| node.tags.level.as_deref() == Some(wanted.as_str()));
    if layout.nodes.is_empty() {
        let message =
            format!("there is no level `{}`: graphs of Nav2 have no levels", shorten(wanted));
        report.file_error(0, message);
    }
    let kept: BTreeSet<&str> = layout.nodes.iter().map(|node| node.id.as_str()).collect();
    layout.edges.retain(|edge| kept.contains(&*edge.origin) && kept.contains(&*edge.destination));
}

/// The findings that are reported once, with the number of times.
#[derive(Debug, Default)]
struct Counts {
    /// The edges with each speed that isn't one.
    wrong_speeds: BTreeMap<String, Count>,
    /// The nodes, and the edges, with each key whose value isn't an angle, and the first value.
    wrong_angles: BTreeMap<(Kind, &'static str), (String, Count)>,
    relative_speeds: Count,
    polylines: Count,
    gaps: Count,
    flipped: Count,
    loops: Count,
    repeated: Count,
    frames: BTreeSet<String>,
}

/// A kind of elements of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, strum::Display)]
#[strum(serialize_all = "lowercase")]
enum Kind {
    Node,
    Edge,
}

#[derive(Debug, Default)]
struct Count {
    first: Option<(u32, String)>,
    count: usize,
}

impl Count {
    fn add(&mut self, at: u32, id: &str) {
        self.count += 1;
        self.first.get_or_insert_with(|| (at, id.to_owned()));
    }

    fn report(self, what: &str, report: &mut Report<'_>) {
        self.report_of(Kind::Edge, what, report);
    }

    fn report_of(self, kind: Kind, what: &str, report: &mut Report<'_>) {
        let Some((at, id)) = self.first else { return };
        let others = match self.count {
            1 => String::new(),
            count => format!(" and {} more", count - 1),
        };
        report.assumption(at, format!("{kind} `{}`{others}: {what}", shorten(&id)));
    }
}

struct Reader<'a, 'text> {
    text: &'text str,
    report: &'a mut Report<'text>,
    ignored: Ignored,
    counts: Counts,
}

impl<'text> Reader<'_, 'text> {
    fn check_root(&mut self, root: &BTreeMap<String, &'text RawValue>) {
        const KNOWN: [&str; 3] = ["type", "crs", "features"];
        for (key, value) in root.iter().filter(|(key, _)| !KNOWN.contains(&key.as_str())) {
            // Our writer gives this name to all files.
            if key != "name" || value.get() != "\"graph\"" {
                self.ignored.add_key(self.offset(value), key, "the file");
            }
        }
        let Some(crs) = root.get("crs") else { return };
        if ["CRS84", "4326"].iter().any(|degrees| crs.get().contains(degrees)) {
            let message = "its coordinate system is in degrees, but a graph of Nav2 is in metres: \
                           they are read as metres";
            self.report.file_warning(self.offset(crs), message);
        }
    }

    /// Returns the byte offset of a part of the text.
    fn offset(&self, value: &RawValue) -> u32 {
        offset_of(self.text, value.get()).unwrap_or_default() as u32
    }

    fn feature(&mut self, raw: &'text RawValue) -> Option<Feature> {
        let at = self.offset(raw);
        match Feature::parse(raw.get(), at, &mut self.ignored) {
            Ok(feature) => feature,
            Err(error) => {
                self.report.file_error(at, format!("a feature can't be read: {error}"));
                None
            }
        }
    }

    fn nodes(&mut self, features: &[Feature]) -> Vec<LayoutNode> {
        features.iter().filter_map(|feature| self.node(feature)).collect()
    }

    fn node(&mut self, feature: &Feature) -> Option<LayoutNode> {
        let Geometry::Point(position) = feature.geometry else { return None };
        let Some(id) = feature.id("id") else {
            self.report.file_error(feature.at, "a point has no `id`: give it a whole number");
            return None;
        };
        if position.is_none() {
            let message = format!("point `{}` needs two finite coordinates", shorten(&id));
            self.report.file_error(feature.at, message);
        }
        let frame = feature
            .properties
            .get("frame")
            .and_then(metadata::text)
            .unwrap_or_else(|| "map".to_owned());
        let (mut tags, special) = metadata::read(feature, &["id", "frame"], &mut self.ignored);
        self.count_wrong_angles(Kind::Node, &special, feature.at, &id);
        if frame != "map" {
            tags.set("frame", &frame);
        }
        if self.counts.frames.len() < 10 {
            self.counts.frames.insert(frame);
        }
        Some(LayoutNode {
            at: feature.at,
            id,
            position,
            heading: special.heading.or(special.map_heading()),
            role: special.role,
            tags,
        })
    }

    fn count_wrong_angles(&mut self, kind: Kind, special: &Special, at: u32, id: &str) {
        for (key, value) in &special.wrong_angles {
            let counted = self.counts.wrong_angles.entry((kind, key));
            counted.or_insert_with(|| (value.clone(), Count::default())).1.add(at, id);
        }
    }

    fn edges(&mut self, features: &[Feature], nodes: &[LayoutNode]) -> Vec<LayoutEdge> {
        let positions: BTreeMap<&str, DVec2> =
            nodes.iter().filter_map(|node| Some((node.id.as_str(), node.position?))).collect();
        let lines =
            || features.iter().filter(|feature| matches!(feature.geometry, Geometry::Line(_)));
        let mut free =
            lines().filter_map(|feature| feature.id("id")?.parse::<u32>().ok()).max().unwrap_or(0);
        let mut seen = BTreeSet::new();
        let mut edges = Vec::new();
        let mut reverse = Vec::new();
        for feature in lines() {
            let id = feature.id("id").filter(|id| seen.insert(id.clone())).unwrap_or_else(|| {
                free = free.saturating_add(1);
                self.counts.repeated.add(feature.at, &feature.id("id").unwrap_or_default());
                free.to_string()
            });
            let Some((edge, reverse_of)) = self.edge(feature, id, &positions) else { continue };
            match reverse_of {
                Some(of) => reverse.push((of, edge)),
                None => edges.push(edge),
            }
        }
        merge_reverse(reverse, &mut edges);
        edges
    }

    /// Returns an edge. If it is the reverse gear of another edge, also returns the id of that
    /// edge.
    fn edge(
        &mut self,
        feature: &Feature,
        id: String,
        positions: &BTreeMap<&str, DVec2>,
    ) -> Option<(LayoutEdge, Option<String>)> {
        let Geometry::Line(line) = &feature.geometry else { return None };
        let (Some(origin), Some(destination)) = (feature.id("startid"), feature.id("endid")) else {
            let message =
                format!("edge `{id}` lacks `startid` or `endid`: give the ids of two points");
            self.report.file_error(feature.at, message);
            return None;
        };
        if origin == destination {
            self.counts.loops.add(feature.at, &id);
            return None;
        }
        let (mut tags, special) =
            metadata::read(feature, &["id", "startid", "endid"], &mut self.ignored);
        if feature.id("id").is_some_and(|own| own != id) {
            tags.set("id", &feature.id("id").unwrap_or_default());
        }
        self.count_wrong_angles(Kind::Edge, &special, feature.at, &id);
        let has_speed = special.speed.is_some() || special.wrong_speed.is_some();
        if !has_speed && tags.properties.contains_key("speed_limit") {
            self.counts.relative_speeds.add(feature.at, &id);
        }
        let speed = special.speed.or_else(|| {
            let wrong_speed = special.wrong_speed?;
            self.counts.wrong_speeds.entry(wrong_speed).or_default().add(feature.at, &id);
            Some(DEFAULT_SPEED)
        });
        let ends = positions.get(&*origin).copied().zip(positions.get(&*destination).copied());
        let shape = ends.map_or(Shape::Straight, |ends| self.shape(feature.at, &id, line, ends));
        let edge = LayoutEdge {
            at: feature.at,
            id,
            origin,
            destination,
            shape,
            speed,
            orientation: special.orientation,
            tags,
            ..LayoutEdge::default()
        };
        Some((edge, special.reverse_of))
    }

    /// Returns the polyline through the inner points of a line, between the nodes.
    fn shape(&mut self, at: u32, id: &str, line: &[DVec2], (from, to): (DVec2, DVec2)) -> Shape {
        let [first, inner @ .., last] = line else { return Shape::Straight };
        let mut inner = inner.to_vec();
        let gap = first.distance(from).max(last.distance(to));
        if gap > MAX_GAP {
            // The line is drawn from its end to its start: the nodes give the direction.
            if first.distance(to).max(last.distance(from)) <= MAX_GAP {
                self.counts.flipped.add(at, id);
                inner.reverse();
            } else {
                self.counts.gaps.add(at, id);
            }
        }
        let mut points = vec![from];
        points.append(&mut inner);
        points.dedup_by(|after, before| after.distance(*before) < MIN_LENGTH);
        points.truncate(
            points
                .iter()
                .rposition(|point| point.distance(to) >= MIN_LENGTH)
                .map_or(1, |at| at + 1),
        );
        points.push(to);
        if points.len() < 3 {
            return Shape::Straight;
        }
        self.counts.polylines.add(at, id);
        Shape::Cubics(
            points.windows(2).map(|pair| CubicBezier::straight(pair[0], pair[1])).collect(),
        )
    }

    fn finish(self) {
        let Self { report, ignored, counts, .. } = self;
        ignored.report(report);
        for (value, count) in counts.wrong_speeds {
            let value = shorten(&value);
            let what = format!(
                "its `abs_speed_limit` `{value}` isn't a number of metres per second above 0: \
                 {DEFAULT_SPEED} m/s is used"
            );
            count.report(&what, report);
        }
        for ((kind, key), (value, count)) in counts.wrong_angles {
            let value = shorten(&value);
            let what = format!(
                "its `{key}` `{value}` isn't an angle in radians within a full turn: kept as a \
                 property, not used as a heading"
            );
            count.report_of(kind, &what, report);
        }
        counts.relative_speeds.report(
            "`speed_limit` is a share of the robot's own maximum: kept as a property; \
             `abs_speed_limit` gives metres per second",
            report,
        );
        counts.polylines.report(
            "its line has inner points and is read as a polyline; Nav2 itself drives straight",
            report,
        );
        counts.gaps.report(
            "its line doesn't begin and end at its nodes: moved there, as `startid` and `endid` \
             say",
            report,
        );
        counts.flipped.report("its line is drawn from its end to its start: reversed", report);
        counts.loops.report("it starts and ends at the same node: not used", report);
        counts.repeated.report("its id is missing or given twice: it gets another one", report);
        if counts.frames.len() > 1 {
            let frames: Vec<_> = counts.frames.iter().map(|frame| shorten(frame)).collect();
            let message = format!(
                "its points are in the frames {}: all are read as if in one",
                frames.join(", ")
            );
            report.file_warning(0, message);
        }
    }
}

/// Merges edges that are marked as the reverse gear of another edge into that edge. Others stay
/// separate edges.
fn merge_reverse(reverse: Vec<(String, LayoutEdge)>, edges: &mut Vec<LayoutEdge>) {
    let by_id: BTreeMap<String, usize> =
        edges.iter().enumerate().map(|(at, edge)| (edge.id.clone(), at)).collect();
    for (of, edge) in reverse {
        let forward = by_id.get(&of).and_then(|index| edges.get_mut(*index));
        match forward.filter(|forward| {
            forward.origin == edge.destination
                && forward.destination == edge.origin
                && forward.reverse_speed.is_none()
        }) {
            Some(forward) => forward.reverse_speed = Some(edge.speed.unwrap_or(DEFAULT_SPEED)),
            None => edges.push(edge),
        }
    }
}
