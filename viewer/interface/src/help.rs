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
/// The height of a window below which rows lie closer together, in points.
const LOW: f32 = 780.0;

/// The look of the rows.
#[derive(Clone, Copy, Debug)]
struct Rows {
    /// The size of the letters, in points.
    letters: f32,
    /// The space between two rows, in points.
    gap: f32,
}

impl Rows {
    fn of_window(height: f32) -> Self {
        match height < LOW {
            true => Self { letters: 11.5, gap: 2.5 },
            false => Self { letters: 13.0, gap: 4.0 },
        }
    }
}

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
                        wide(ui, groups, columns, Rows::of_window(screen.y), &colours);
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
fn wide(ui: &mut Ui, groups: Vec<HelpGroup>, columns: usize, rows: Rows, colours: &ThemeColours) {
    let Rows { letters, gap } = rows;
    ui.horizontal_top(|ui| {
        for column in in_columns(groups, columns) {
            ui.vertical(|ui| {
                for (name, keys) in column {
                    style::heading(ui, name);
                    let grid = Grid::new(("keys", name)).num_columns(2).spacing([10.0, gap]);
                    grid.min_row_height(letters).show(ui, |ui| {
                        for (input, text) in keys {
                            let input = RichText::new(input).monospace().size(letters);
                            ui.label(input.color(colours.accent));
                            ui.label(RichText::new(text).size(letters));
                            ui.end_row();
                        }
                    });
                }
            });
            ui.add_space(14.0);
        }
    });
}

/// Distributes groups, in their order, over columns, so that the longest one is as short as it can
/// be.
fn in_columns(groups: Vec<HelpGroup>, columns: usize) -> Vec<Vec<HelpGroup>> {
    let rows: Vec<_> = groups.iter().map(rows_of).collect();
    let (longest, all) = (rows.iter().copied().max().unwrap_or(0), rows.iter().sum());
    let height = (longest..=all).find(|height| columns_of(&rows, *height) <= columns);
    let mut filled: Vec<Vec<HelpGroup>> = vec![Vec::new()];
    let mut used = 0;
    for (group, size) in groups.into_iter().zip(rows) {
        if used > 0 && used + size > height.unwrap_or(all) {
            filled.push(Vec::new());
            used = 0;
        }
        used += size;
        filled.last_mut().expect("a column").push(group);
    }
    filled
}

/// The number of columns that groups of these rows fill if none is higher than `height` rows.
fn columns_of(rows: &[usize], height: usize) -> usize {
    let (mut columns, mut used) = (1, 0);
    for size in rows {
        if used > 0 && used + size > height {
            columns += 1;
            used = 0;
        }
        used += size;
    }
    columns
}

fn rows_of((_, keys): &HelpGroup) -> usize {
    keys.len() + HEADING
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_column_is_as_short_as_it_can_be() {
        for (rows, columns, longest) in [
            (&[13, 13, 12, 15, 13, 11, 7][..], 4, 27),
            (&[13, 13, 12, 15, 13, 11, 7], 3, 31),
            (&[5, 2, 2], 3, 5),
            (&[], 2, 0),
        ] {
            let keys = |rows: usize| vec![(String::new(), ""); rows - HEADING];
            let groups = rows.iter().map(|rows| ("group", keys(*rows))).collect();
            let filled = in_columns(groups, columns);
            let heights = filled.iter().map(|column| column.iter().map(rows_of).sum::<usize>());
            assert!(filled.len() <= columns);
            assert_eq!(heights.max(), Some(longest));
        }
    }
}
