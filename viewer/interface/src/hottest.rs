//! The labels of the hottest places of a heat map: their ranks, names and values.

use egui::{Align2, FontId, LayerId, Rect, Stroke, pos2, vec2};
use regatta_scene::curves::midpoint;
use regatta_scene::heat::{Figure, HotEdge};

use super::context::PanelContext;
use super::levels::PictureArea;
use super::ramp;

/// The distance of a label from its place, in points.
const ABOVE: f32 = 16.0;
/// The space around the text, in points.
const MARGIN: egui::Vec2 = vec2(5.0, 2.0);

/// Draws the labels over the picture. One that would cover another is left out.
pub(super) fn draw(
    context: &PanelContext<'_>,
    ctx: &egui::Context,
    area: PictureArea,
    taken: &[Rect],
) {
    let Some(facts) = context.model.jams.heat else { return };
    let colours = context.colours;
    let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(area.visible);
    let mut drawn: Vec<Rect> = taken.to_vec();
    for (rank, hot) in (1..).zip(&context.model.jams.hottest) {
        let world = &context.model.world;
        let Some(edge) = world.edges().get(hot.edge as usize) else { continue };
        let place = midpoint(world, edge).map(|place| (place + context.offset).extend(0.0));
        let Some(at) = place.and_then(|place| area.place(&context.camera, place)) else { continue };
        let name = match world.text(edge.name) {
            "" => format!("e{}", edge.id),
            name => name.to_owned(),
        };
        let text = format!("{rank}  {name}  {}", value(facts.heat.figure, hot));
        let text = painter.layout_no_wrap(text, FontId::proportional(12.0), colours.text);
        let label = Align2::CENTER_BOTTOM.anchor_size(at - vec2(0.0, ABOVE), text.size());
        let frame = label.expand2(MARGIN);
        if !area.visible.contains_rect(frame) || drawn.iter().any(|other| other.intersects(frame)) {
            continue;
        }
        drawn.push(frame);
        let line = Stroke::new(1.0, colours.text);
        painter.line_segment([pos2(at.x, frame.bottom()), at], line);
        painter.circle_filled(at, 2.5, colours.text);
        painter.rect(frame, 4.0, colours.panel, line, egui::StrokeKind::Inside);
        painter.galley(label.min, text, colours.text);
    }
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
    use super::*;

    #[test]
    fn values_have_their_units() {
        let hot = HotEdge { edge: 0, value: 12.0 };
        let texts: Vec<_> = Figure::ALL.into_iter().map(|figure| value(figure, &hot)).collect();
        assert!(texts.contains(&"12 s waiting".to_owned()), "{texts:?}");
        assert!(texts.iter().all(|text| text.starts_with("12 ")), "{texts:?}");
    }
}
