//! The performance panel: the rate of the pictures, and what their time is spent on.

use egui::{Color32, Rect, RichText, Sense, Ui, pos2, vec2};

use super::context::PanelContext;
use super::style::{self, heading, line};
use super::timing::{PARTS, PICTURES, Timing};
use crate::text::thousands;

/// Shows the panel.
pub(super) fn show(context: &PanelContext<'_>, ui: &mut Ui) {
    let (colours, timing) = (context.colours, context.model.timing);
    ui.label(RichText::new(format!("{:.0} pictures/s", timing.rate())).size(20.0));
    ui.label(style::faint(ui, &timing.adapter));
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), 60.0), Sense::hover());
    let part_colours = [colours.accent, colours.good, colours.warn, colours.bad, colours.line];
    bars(ui, area, timing, part_colours);
    heading(ui, "mean time per picture");
    for (part, (name, colour)) in PARTS.into_iter().zip(part_colours).enumerate() {
        ui.horizontal(|ui| {
            let (dot, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
            ui.painter().rect_filled(dot, 2.0, colour);
            line(ui, name, format!("{:.2} ms", timing.mean(part) * 1e3));
        });
    }
    let cpu: f32 = (0..3).map(|part| timing.mean(part)).sum();
    line(ui, "CPU, without the interface", format!("{:.2} ms", cpu * 1e3));
    let gpu = timing.gpu().map_or("not measured".to_owned(), |gpu| format!("{:.2} ms", gpu * 1e3));
    line(ui, "GPU, the fleet", gpu);
    heading(ui, "frames");
    line(ui, "read", thousands(context.model.counts.read));
    line(ui, "skipped", thousands(context.model.counts.skipped));
    let lag = context.model.lag.map_or("–".to_owned(), |lag| format!("{:.1} ms", lag * 1e3));
    line(ui, "lag", lag);
    ui.label(style::faint(
        ui,
        "Frames are skipped when the engine publishes more of them than the screen shows.",
    ));
}

/// Draws a stacked bar for each picture, without the time spent waiting for the screen.
fn bars(ui: &Ui, area: Rect, timing: &Timing, colours: [Color32; 5]) {
    ui.painter().rect_filled(area, 4.0, ui.visuals().extreme_bg_color);
    let totals = timing.parts().map(|parts| parts[..4].iter().sum());
    let highest = totals.fold(0.002, f32::max);
    let width = area.width() / PICTURES as f32;
    for (i, parts) in timing.parts().enumerate() {
        let left = area.left() + i as f32 * width;
        let mut bottom = area.bottom();
        for (part, colour) in parts[..4].iter().zip(colours) {
            let top = bottom - part / highest * area.height();
            let bar = Rect::from_min_max(pos2(left, top), pos2(left + width * 0.9, bottom));
            ui.painter().rect_filled(bar, 0.0, colour);
            bottom = top;
        }
    }
}
