//! The strip under the top bar: the figures of the fleet's work, as its manager publishes them.

use std::borrow::Cow;

use egui::{FontId, Label, RichText, Ui};
use regatta_plugin::work::WorkFigures;

use super::context::PanelContext;
use super::style;
use super::text::{thousands, with_plural};
use super::transport::clock_text;
use super::view_model::ViewModel;

/// The height of the strip, in points.
pub const HEIGHT: f32 = 28.0;
/// The least height of a window that has room for the strip, in points.
pub const LEAST_WINDOW: f32 = 360.0;
/// The room between two figures, in points.
const GAP: f32 = 18.0;
/// The room between a figure's name and its value, in points.
const WITHIN: f32 = 5.0;
/// The size of its text, in points.
const TEXT: f32 = 12.5;

/// A figure: its name, its value, and an explanation.
struct Item {
    name: &'static str,
    value: String,
    hint: Cow<'static, str>,
}

/// Whether a window has the strip: if the figures are known, or a fleet manager is about to publish
/// them. A recording and the past of a live run have none.
pub fn is_shown(model: &ViewModel<'_>) -> bool {
    let is_live = model.recording().is_none() && !model.is_past();
    model.work().is_some() || is_live && model.activity_column.is_some()
}

/// Shows the figures, the most important first. Those without room are left out; those of a manager
/// that hasn't published any are unknown.
pub fn show(context: &PanelContext<'_>, ui: &mut Ui) {
    let figures = context.model.work();
    let is_known = figures.is_some();
    ui.horizontal_centered(|ui| {
        ui.spacing_mut().item_spacing.x = WITHIN;
        let mut is_first = true;
        for mut item in items(&figures.unwrap_or_default()) {
            if !is_known {
                (item.value, item.hint) =
                    (unknown(), "The fleet manager hasn't told it yet".into());
            }
            let gap = if is_first { 0.0 } else { GAP };
            if width(ui, item.name) + width(ui, &item.value) + WITHIN + gap > ui.available_width() {
                return;
            }
            ui.add_space(gap);
            let name = RichText::new(item.name).size(TEXT).color(context.colours.faint);
            ui.add(Label::new(name).extend()).on_hover_text(&*item.hint);
            let value = RichText::new(item.value).size(TEXT).strong().color(context.colours.text);
            ui.add(Label::new(value).extend()).on_hover_text(&*item.hint);
            is_first = false;
        }
    });
}

/// The width of a text, in points.
fn width(ui: &Ui, text: &str) -> f32 {
    style::one_line(ui, text, f32::INFINITY, FontId::proportional(TEXT), egui::Color32::WHITE)
        .size()
        .x
}

fn items(figures: &WorkFigures) -> [Item; 6] {
    let since = clock_text(figures.secs);
    let service = figures.service_secs();
    let [p50, p99] = [0, 1].map(|at| service.map_or_else(unknown, |secs| seconds(secs[at])));
    let rate = figures.rate().map_or_else(unknown, |rate| thousands(rate.round() as u64));
    let waits = format!("{:.0} %", 100.0 * figures.waiting);
    [
        Item {
            name: "orders an hour",
            value: rate,
            hint: format!(
                "The current rate: finished orders an hour of the last 10 min. In the first \
                 minutes of a run, since its start or the end of its warm-up. {} finished in \
                 {since} of simulated time.",
                with_plural(figures.finished, "order")
            )
            .into(),
        },
        Item {
            name: "service p50",
            value: p50,
            hint: "Half of the finished orders took no longer than this".into(),
        },
        Item {
            name: "p99",
            value: p99,
            hint: "99 of 100 finished orders took no longer than this".into(),
        },
        Item {
            name: "waiting",
            value: waits,
            hint: "The part of the robots' time so far that they waited for room to drive on"
                .into(),
        },
        Item {
            name: "busy",
            value: format!(
                "{} of {}",
                thousands(figures.busy.into()),
                with_plural(figures.robots.into(), "robot")
            ),
            hint: "Robots that have an order now".into(),
        },
        Item {
            name: "open",
            value: with_plural(figures.open, "order"),
            hint: "Orders that aren't finished, failed or cancelled".into(),
        },
    ]
}

/// The sign for a figure that isn't known yet.
fn unknown() -> String {
    "–".to_owned()
}

/// Formats seconds of simulated time.
fn seconds(secs: f32) -> String {
    match secs {
        short if short < 9.95 => format!("{short:.1} s"),
        secs if secs < 599.5 => format!("{secs:.0} s"),
        long => format!("{:.0} min", long / 60.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_told_in_plain_words() {
        let figures = WorkFigures {
            secs: 3600.0,
            finished: 7_654,
            open: 1,
            orders_per_hour: 7_654.4,
            service_p50_secs: 8.04,
            service_p99_secs: 660.0,
            waiting: 0.126,
            busy: 340,
            robots: 1_400,
            ..WorkFigures::default()
        };
        let texts = items(&figures).map(|item| format!("{} {}", item.name, item.value));
        assert_eq!(
            texts,
            [
                "orders an hour 7,654",
                "service p50 8.0 s",
                "p99 11 min",
                "waiting 13 %",
                "busy 340 of 1,400 robots",
                "open 1 order"
            ]
        );
        assert_eq!(
            items(&figures)[0].hint,
            "The current rate: finished orders an hour of the last 10 min. In the first minutes of \
             a run, since its start or the end of its warm-up. 7,654 orders finished in 1:00:00.0 \
             of simulated time."
        );
        let begun = WorkFigures { orders_per_hour: f32::NAN, ..figures };
        assert_eq!(items(&begun)[0].value, "–", "in the first minute");
        let begun = WorkFigures { service_p50_secs: f32::NAN, ..figures };
        assert_eq!(items(&begun)[1].value, "–", "no order is finished");
    }
}
