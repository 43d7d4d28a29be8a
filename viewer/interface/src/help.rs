//! The help: all keyboard shortcuts and pointer gestures, by group.

use egui::{Align2, Grid, RichText, ScrollArea, Ui, Window};

use super::context::PanelContext;
use super::keys::{self, HelpGroup};
use super::style::{self, ThemeColours};

/// The width of a column, in points.
const COLUMN: f32 = 305.0;
/// The height of the bars above and below, which stay in sight, in points: twice the larger one.
const BARS: f32 = 152.0;
/// The rows that the heading of a group takes.
const HEADING: usize = 2;

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
                ui.set_max_size(egui::vec2(screen.x - 60.0, screen.y - BARS));
                ui.label(RichText::new("Keys and mouse").size(17.0));
                ui.add_space(8.0);
                let columns = ((screen.x - 60.0) / COLUMN).clamp(1.0, 4.0) as usize;
                let groups = keys::help(ctx);
                // It would keep the width that it had before its columns were known.
                let scrolled = ScrollArea::vertical().auto_shrink([false, true]);
                scrolled.max_height(screen.y - BARS - 60.0).show(ui, |ui| {
                    if columns == 1 {
                        narrow(ui, &groups, &colours);
                    } else {
                        wide(ui, groups, columns, &colours);
                    }
                });
            });
        // A click outside closes the help.
        self.is_open = response.is_none_or(|shown| !shown.response.clicked_elsewhere());
    }
}

/// Shows the groups below each other, in a window too narrow for columns.
fn narrow(ui: &mut Ui, groups: &[HelpGroup], colours: &ThemeColours) {
    for (name, keys) in groups {
        style::heading(ui, name);
        for (input, text) in keys {
            ui.horizontal_wrapped(|ui| {
                ui.label(RichText::new(input).monospace().color(colours.accent));
                ui.label(*text);
            });
        }
    }
}

/// Shows the groups in columns of about the same height.
fn wide(ui: &mut Ui, groups: Vec<HelpGroup>, columns: usize, colours: &ThemeColours) {
    ui.horizontal_top(|ui| {
        for column in in_columns(groups, columns) {
            ui.vertical(|ui| {
                for (name, keys) in column {
                    style::heading(ui, name);
                    Grid::new(("keys", name)).num_columns(2).spacing([12.0, 5.0]).show(ui, |ui| {
                        for (input, text) in keys {
                            ui.label(RichText::new(input).monospace().color(colours.accent));
                            ui.label(text);
                            ui.end_row();
                        }
                    });
                }
            });
            ui.add_space(14.0);
        }
    });
}

/// Distributes groups, in their order, over columns.
fn in_columns(groups: Vec<HelpGroup>, columns: usize) -> Vec<Vec<HelpGroup>> {
    let height = groups.iter().map(rows_of).sum::<usize>().div_ceil(columns);
    let mut filled: Vec<Vec<HelpGroup>> = vec![Vec::new()];
    let (mut used, mut taken) = (0, 0);
    for group in groups {
        let (begun, size) = (filled.len(), rows_of(&group));
        // A group belongs to the column in which its middle lies.
        if begun < columns && used > 0 && taken + size / 2 >= begun * height {
            filled.push(Vec::new());
            used = 0;
        }
        used += size;
        taken += size;
        filled.last_mut().expect("a column").push(group);
    }
    filled
}

fn rows_of((_, keys): &HelpGroup) -> usize {
    keys.len() + HEADING
}
