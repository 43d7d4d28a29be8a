//! The help: all keyboard shortcuts and pointer gestures.

use egui::{Align2, Grid, RichText, ScrollArea, Window};

use super::context::PanelContext;
use super::keys;
use super::style;

/// The width of a column, in points.
const COLUMN: f32 = 400.0;

/// The help, as far as it is open.
#[derive(Debug, Default)]
pub(super) struct Help {
    pub is_open: bool,
}

impl Help {
    /// Shows the open help.
    pub fn show(&mut self, context: &PanelContext<'_>, ctx: &egui::Context) {
        if !self.is_open {
            return;
        }
        let colours = context.colours;
        let response = Window::new("Keys")
            .title_bar(false)
            .collapsible(false)
            .resizable(false)
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .frame(style::floating(context.theme).fill(colours.panel).inner_margin(18.0))
            .show(ctx, |ui| {
                let screen = ctx.content_rect().size();
                ui.set_max_size(egui::vec2(screen.x - 60.0, screen.y - 60.0));
                ui.label(RichText::new("Keys and mouse").size(17.0));
                ui.add_space(8.0);
                let columns = ((screen.x - 60.0) / COLUMN).clamp(1.0, 3.0) as usize;
                let gestures = keys::POINTER_GESTURES
                    .iter()
                    .map(|(gesture, text)| ((*gesture).to_owned(), *text));
                let all: Vec<_> = gestures.chain(keys::list(ctx)).collect();
                let rows = all.len().div_ceil(columns);
                ScrollArea::vertical().max_height(screen.y - 120.0).show(ui, |ui| {
                    if columns == 1 {
                        for (input, text) in &all {
                            ui.horizontal_wrapped(|ui| {
                                ui.label(RichText::new(input).monospace().color(colours.accent));
                                ui.label(*text);
                            });
                        }
                        return;
                    }
                    ui.horizontal_top(|ui| {
                        for (i, column) in all.chunks(rows).enumerate() {
                            Grid::new(("keys", i)).num_columns(2).spacing([12.0, 5.0]).show(
                                ui,
                                |ui| {
                                    for (input, text) in column {
                                        ui.label(
                                            RichText::new(input).monospace().color(colours.accent),
                                        );
                                        ui.label(*text);
                                        ui.end_row();
                                    }
                                },
                            );
                            ui.add_space(14.0);
                        }
                    });
                });
            });
        // A click outside closes the help.
        self.is_open = response.is_none_or(|shown| !shown.response.clicked_elsewhere());
    }
}
