//! The drawing of the timeline: the bar, the marks, and the text about the time under the pointer.

use egui::{Align2, FontId, Painter, Pos2, Rect, pos2, vec2};
use regatta_plugin::recording::{MarkKind, RecordingMark};

use super::timeline::{KINDS, LANE, TimelinePanel};
use crate::style::ThemeColours;
use crate::transport::clock_text;
use crate::view_model::Timeline;

/// Returns a time, and what happened near it.
pub(super) fn describe(timeline: &Timeline<'_>, rect: Rect, time: u64) -> String {
    let near =
        (timeline.end.saturating_sub(timeline.start) as f32 / rect.width().max(1.0) * 3.0) as u64;
    let mut text = clock_text(time as f64 * 1e-9);
    for (kind, name) in KINDS {
        let marks = timeline.marks.iter().filter(|mark| mark.kind() == Some(kind));
        let near: Vec<&RecordingMark> =
            marks.filter(|mark| mark.time_nanos.abs_diff(time) <= near).collect();
        let count: u32 = near.iter().map(|mark| mark.count).sum();
        match near.first() {
            Some(_) if kind == MarkKind::Note => text += &format!("\n{count} × {name}"),
            Some(first) => text += &format!("\n{count} × {name}, robot {}", first.robot),
            None => {}
        }
    }
    text
}

/// Paints the timeline at a time.
pub(super) fn paint(
    panel: &TimelinePanel,
    painter: &Painter,
    rect: Rect,
    timeline: &Timeline<'_>,
    now: u64,
    colours: &ThemeColours,
) {
    let x = |time: u64| rect.left() + timeline.part(time) * rect.width();
    let lanes = LANE * KINDS.len() as f32;
    let bar = Rect::from_min_max(
        pos2(rect.left(), rect.top() + lanes + 2.0),
        pos2(rect.right(), rect.bottom() - 2.0),
    );
    painter.rect_filled(bar, 3.0, colours.field);
    painter.rect_filled(bar.with_max_x(x(now)), 3.0, colours.accent.gamma_multiply(0.55));
    if let Some((from, to)) = panel.repeated {
        let part = Rect::from_min_max(pos2(x(from), rect.top()), pos2(x(to), rect.bottom()));
        painter.rect_filled(part, 2.0, colours.accent.gamma_multiply(0.16));
        for end in [from, to] {
            painter.vline(x(end), rect.y_range(), (1.5, colours.accent));
        }
    }
    if let Some(start) = panel.loop_start {
        painter.vline(x(start), rect.y_range(), (1.5, colours.accent));
    }
    for (lane, (kind, _)) in KINDS.into_iter().enumerate() {
        let top = rect.top() + lane as f32 * LANE;
        paint_marks(painter, timeline, kind, (top, &x), colours);
    }
    painter.vline(x(now), rect.y_range(), (2.0, colours.text));
    painter.circle_filled(Pos2::new(x(now), bar.center().y), 5.0, colours.text);
    if timeline.live.is_none() && timeline.marks.is_empty() && timeline.searched >= timeline.end {
        let font = FontId::proportional(10.0);
        painter.text(
            rect.left_top(),
            Align2::LEFT_TOP,
            "no contacts, faults, stops or notes",
            font,
            colours.faint,
        );
    }
}

/// Paints the marks of a kind, one for each point of the bar.
fn paint_marks(
    painter: &Painter,
    timeline: &Timeline<'_>,
    kind: MarkKind,
    (top, x): (f32, &dyn Fn(u64) -> f32),
    colours: &ThemeColours,
) {
    let mut last = f32::NEG_INFINITY;
    for mark in timeline.marks.iter().filter(|mark| mark.kind() == Some(kind)) {
        let at = x(mark.time_nanos).round();
        if at - last >= 1.0 {
            last = at;
            let size = vec2(if kind == MarkKind::Note { 4.0 } else { 2.0 }, LANE - 0.5);
            painter.rect_filled(
                Rect::from_min_size(pos2(at - size.x / 2.0, top), size),
                0.5,
                colour_of(kind, colours),
            );
        }
    }
}

/// The colour of marks of a kind.
pub(crate) fn colour_of(kind: MarkKind, colours: &ThemeColours) -> egui::Color32 {
    match kind {
        MarkKind::Contact => colours.bad,
        MarkKind::Fault => colours.warn,
        MarkKind::Stop => colours.accent,
        MarkKind::Note => colours.good,
    }
}
