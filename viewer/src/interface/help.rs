//! What keys and hands do.

use egui::{Align2, Context, Grid, RichText, Window};

use super::Interface;
use super::keys;
use super::style;

impl Interface {
    pub(super) fn help(&mut self, context: &Context) {
        if !self.help {
            return;
        }
        let (theme, tones) = (self.settings.theme(), self.tones());
        let response = Window::new("Keys")
            .title_bar(false)
            .collapsible(false)
            .resizable(false)
            .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
            .frame(style::floating(theme).fill(tones.panel).inner_margin(18.0))
            .show(context, |ui| {
                ui.label(RichText::new("Keys and hands").size(17.0));
                ui.add_space(8.0);
                let all = keys::list(context);
                let third = (all.len() + keys::HANDS.len()).div_ceil(3);
                let hands = keys::HANDS.iter().map(|(hand, what)| ((*hand).to_owned(), *what));
                let all: Vec<_> = hands.chain(all).collect();
                ui.horizontal_top(|ui| {
                    for (i, column) in all.chunks(third).enumerate() {
                        Grid::new(("keys", i)).num_columns(2).spacing([12.0, 5.0]).show(ui, |ui| {
                            for (keys, what) in column {
                                ui.label(RichText::new(keys).monospace().color(tones.accent));
                                ui.label(*what);
                                ui.end_row();
                            }
                        });
                        ui.add_space(14.0);
                    }
                });
            });
        // A click beside it closes it.
        self.help = response.is_none_or(|shown| !shown.response.clicked_elsewhere());
    }
}
