//! The labels of the hottest places of a heat map: their names and values, each beside its place
//! or, where others are in the way, at the end of a line to it.

use core::f32::consts::TAU;

use egui::{Align2, Context, FontId, LayerId, Pos2, Rect, Stroke, Vec2, vec2};
use regatta_plugin::World;
use regatta_scene::camera::Camera;
use regatta_scene::curves::midpoint;
use regatta_scene::heat::{Figure, HotEdge, LABELLED};
use regatta_scene::is_on_level;
use regatta_scene::names::titled_edge;
use regatta_scene::palette::Theme;

use super::levels::PictureArea;
use super::placement::Placement;
use super::plan::within_rulers;
use super::{ramp, style};

/// The distance of a label from its place if it is near it, in points.
const NEAR: f32 = 16.0;
/// The distances farther away, each by so much greater than the one before.
const FARTHER: f32 = 1.4;
const DISTANCES: i32 = 11;
/// The number of directions in which a label may lie.
const DIRECTIONS: u8 = 24;
/// The least distance between labels, and from a label to another one's place, in points.
const GAP: f32 = 4.0;
/// The space around the text, in points.
const MARGIN: Vec2 = vec2(5.0, 2.0);
/// The size of the letters, in points.
const LETTER: f32 = 12.0;
/// The number of parts of a line in which it is compared with a label.
const PARTS: u8 = 24;
/// The names of the labels among the elements over a picture.
const NAMES: [&str; LABELLED] = ["hottest 1", "hottest 2", "hottest 3", "hottest 4", "hottest 5"];

/// The hottest places of a heat map.
#[derive(Clone, Copy, Debug)]
pub struct Hottest<'a> {
    /// The places, the hottest first.
    pub places: &'a [HotEdge],
    /// The figure of the heat map.
    pub figure: Figure,
    /// The world of the edges.
    pub world: &'a World<'a>,
    /// The only level that is shown, if there is one.
    pub level: Option<&'a str>,
    /// The offset of all positions, in metres.
    pub offset: glam::Vec2,
    /// The camera.
    pub camera: &'a Camera,
    /// The theme.
    pub theme: Theme,
}

/// A label, and its place in the picture.
struct Label {
    text: String,
    at: Pos2,
}

/// A place that is labelled, and the size of its label.
#[derive(Clone, Copy, Debug)]
struct Spot {
    at: Pos2,
    size: Vec2,
}

/// A label that has room, and the line to its place.
#[derive(Clone, Copy, Debug)]
struct Placed {
    frame: Rect,
    line: [Pos2; 2],
}

impl Hottest<'_> {
    /// Draws the labels over a picture, beside the elements that lie over it.
    pub fn draw(&self, ctx: &Context, area: PictureArea, placement: &mut Placement) {
        let colours = style::colours(self.theme);
        let clip = if self.camera.is_plan() { within_rulers(area.visible) } else { area.visible };
        let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(clip);
        let labels: Vec<_> = self.labels(area, clip);
        let texts: Vec<_> = labels
            .iter()
            .map(|label| {
                let font = FontId::proportional(LETTER);
                painter.layout_no_wrap(label.text.clone(), font, colours.text)
            })
            .collect();
        let spots = labels.iter().zip(&texts);
        let spots =
            spots.map(|(label, text)| Spot { at: label.at, size: text.size() + 2.0 * MARGIN });
        let placed = place(clip.shrink(GAP), placement, &spots.collect::<Vec<_>>());
        let line = Stroke::new(1.0, colours.text);
        for Placed { line: ends, .. } in placed.iter().flatten() {
            painter.line_segment(*ends, line);
            painter.circle_filled(ends[1], 2.5, colours.text);
        }
        for ((placed, text), name) in placed.into_iter().zip(texts).zip(NAMES) {
            let Some(Placed { frame, .. }) = placed else { continue };
            placement.take_exactly(name, frame);
            painter.rect(frame, 4.0, colours.panel, line, egui::StrokeKind::Inside);
            painter.galley(frame.min + MARGIN, text, colours.text);
        }
    }

    /// The labels of the places in sight.
    fn labels(&self, area: PictureArea, clip: Rect) -> Vec<Label> {
        let edges = self.places.iter().filter_map(|hot| {
            let edge = self.world.edges().get(hot.edge as usize)?;
            is_on_level(self.world, edge.level, self.level).then_some((hot, edge))
        });
        let labels = edges.take(LABELLED).filter_map(|(hot, edge)| {
            let place = (midpoint(self.world, edge)? + self.offset).extend(0.0);
            let at = area.place(self.camera, place).filter(|at| clip.contains(*at))?;
            let name = titled_edge(self.world, edge);
            Some(Label { text: format!("{name} · {}", value(self.figure, hot)), at })
        });
        labels.collect()
    }
}

/// Returns where labels lie in a room, the first ones the nearest to their places. None lies over
/// an element of the picture, over another label or over a place, nor over the line to one if that
/// can be avoided. One without room has no place.
fn place(room: Rect, placement: &Placement, spots: &[Spot]) -> Vec<Option<Placed>> {
    let mut placed: Vec<Option<Placed>> = Vec::new();
    for spot in spots {
        let next = place_next(*spot, room, placement, spots, &placed);
        placed.push(next);
    }
    placed
}

/// Returns where the label of a spot lies, given those that have a place.
fn place_next(
    spot: Spot,
    room: Rect,
    placement: &Placement,
    spots: &[Spot],
    placed: &[Option<Placed>],
) -> Option<Placed> {
    let mut clear = candidates(spot).filter(|candidate| {
        let frame = candidate.frame.expand(GAP);
        room.contains_rect(candidate.frame)
            && placement.is_clear(frame)
            && !spots.iter().any(|other| frame.contains(other.at))
            && !placed.iter().flatten().any(|other| frame.intersects(other.frame))
    });
    let first = clear.next()?;
    let mut all = std::iter::once(first).chain(clear);
    let best =
        all.find(|candidate| !placed.iter().flatten().any(|other| is_in_the_way(candidate, other)));
    Some(best.unwrap_or(first))
}

/// The frames in which a label may lie, the nearest first, above its place before others.
fn candidates(Spot { at, size }: Spot) -> impl Iterator<Item = Placed> {
    let distances = (0..DISTANCES).map(|step| NEAR * FARTHER.powi(step));
    distances.flat_map(move |distance| {
        (0..DIRECTIONS).map(move |direction| {
            let turn = TAU * f32::from(direction) / f32::from(DIRECTIONS);
            let towards = vec2(turn.sin(), -turn.cos());
            let half = 0.5 * (towards.x.abs() * size.x + towards.y.abs() * size.y);
            let frame = Align2::CENTER_CENTER.anchor_size(at + towards * (distance + half), size);
            Placed { frame, line: [frame.clamp(at), at] }
        })
    })
}

/// Whether one of two labels lies over the other one's line.
fn is_in_the_way(one: &Placed, other: &Placed) -> bool {
    crosses(one.line, other.frame) || crosses(other.line, one.frame)
}

fn crosses([from, to]: [Pos2; 2], frame: Rect) -> bool {
    let frame = frame.expand(1.0);
    (0..=PARTS).any(|part| frame.contains(from.lerp(to, f32::from(part) / f32::from(PARTS))))
}

/// The value of an edge with its unit.
fn value(figure: Figure, hot: &HotEdge) -> String {
    let number = ramp::short(hot.value);
    match figure {
        Figure::Occupancy => format!("{number} robots"),
        Figure::Throughput => format!("{number} an hour"),
        Figure::Speed => format!("{number} % of its speed"),
        Figure::Waiting => format!("{number} s waiting"),
        Figure::Contacts => format!("{number} s in contact"),
        Figure::Routes => format!("{number} routes"),
    }
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn values_have_their_units() {
        let hot = HotEdge { edge: 0, value: 1234.0 };
        let texts: Vec<_> = Figure::ALL.into_iter().map(|figure| value(figure, &hot)).collect();
        assert!(texts.contains(&"1,234 s waiting".to_owned()), "{texts:?}");
        assert!(texts.iter().all(|text| text.starts_with("1,234 ")), "{texts:?}");
    }

    #[test]
    fn labels_of_places_close_together_lie_apart_from_each_other_and_from_elements() {
        let room = Rect::from_min_size(pos2(0.0, 0.0), vec2(560.0, 420.0));
        // In the middle, at the end of the room, and beside the legend; alone and all at one place.
        for centre in [pos2(280.0, 210.0), pos2(556.0, 6.0), pos2(225.0, 300.0)] {
            for apart in [0.0, 3.0, 12.0, 40.0] {
                let mut placement = Placement::new(room);
                let legend = Rect::from_min_size(pos2(10.0, 160.0), vec2(200.0, 250.0));
                assert!(placement.take_exactly("legend", legend));
                let spot = |number: u8| {
                    let towards = (centre - room.center()).normalized();
                    let by = if towards.is_finite() { -towards } else { vec2(1.0, 0.0) };
                    let at = centre + by * apart * f32::from(number);
                    Spot { at, size: vec2(150.0, 20.0) }
                };
                let spots: Vec<_> = (0..5).map(spot).collect();
                let placed = place(room, &placement, &spots);
                let frames: Vec<_> = placed.iter().flatten().map(|placed| placed.frame).collect();
                assert_eq!(frames.len(), 5, "{centre} {apart}: {frames:?}");
                for (index, frame) in frames.iter().enumerate() {
                    assert!(room.contains_rect(*frame) && !frame.intersects(legend), "{frame}");
                    let others = &frames[..index];
                    assert!(!others.iter().any(|other| other.intersects(*frame)), "{frames:?}");
                }
            }
        }
    }

    #[test]
    fn a_label_alone_is_above_its_place() {
        let room = Rect::from_min_size(pos2(0.0, 0.0), vec2(400.0, 400.0));
        let spot = Spot { at: pos2(200.0, 200.0), size: vec2(100.0, 20.0) };
        let placed = place(room, &Placement::new(room), &[spot])[0].map(|placed| placed.frame);
        let above = Rect::from_min_size(pos2(150.0, 164.0), vec2(100.0, 20.0));
        assert!(placed.is_some_and(|frame| frame.min.distance(above.min) < 0.1), "{placed:?}");
    }
}
