//! The heat map in the interface: its switch, its legend, and the figures of an edge.

use egui::{ComboBox, Grid, RichText, Ui};
use regatta_scene::heat::{Figure, Heat, HeatFacts, Period};
use regatta_scene::palette::{Theme, heat_ramp};

use super::context::PanelContext;
use super::ramp;
use super::settings::Settings;
use super::style::{self, faint, heading, line};
use crate::text::with_plural;

/// The part of the legend about the heat map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatLegend {
    /// The figure and the period that the user has chosen.
    pub heat: Heat,
    /// The shown figures; `None` if no plugin publishes them.
    pub facts: Option<HeatFacts>,
}

impl HeatLegend {
    /// Shows the ramp with its numbers and their meaning.
    pub fn show(&self, ui: &mut Ui, theme: Theme) {
        ui.add_space(3.0);
        ui.label(RichText::new(self.heat.figure.title()).strong());
        let colours = style::colours(theme);
        let Some(facts) = self.facts.filter(|facts| facts.heat.figure == self.heat.figure) else {
            ui.label(
                RichText::new("no figures: regatta plugin traffic").size(11.0).color(colours.warn),
            );
            return;
        };
        Self::lacks(ui, theme, &facts);
        if facts.edges == 0 {
            ui.label(faint(ui, "no edge has a value yet"));
            return;
        }
        let [cold, hot] = facts.ends;
        let mut numbers = ramp::numbers(cold, hot);
        if let Some((_, text)) = numbers.last_mut().filter(|_| facts.is_exceeded) {
            text.insert_str(0, "≥ ");
        }
        ramp::show(ui, theme, &heat_ramp(theme), &numbers);
        ui.label(faint(ui, period_text(facts.heat.period, facts.secs)));
    }

    /// Shows the plugins that the figure lacks.
    fn lacks(ui: &mut Ui, theme: Theme, facts: &HeatFacts) {
        let colours = style::colours(theme);
        if facts.heat.figure == Figure::Contacts && !facts.has_contacts {
            ui.label(
                RichText::new("no collision checker runs: regatta plugin collision")
                    .size(11.0)
                    .color(colours.warn),
            );
        }
        if facts.heat.figure == Figure::Routes && !facts.has_routes {
            let text = "no routes: not available in lockstep and in recordings";
            ui.label(RichText::new(text).size(11.0).color(colours.warn));
        }
    }
}

/// Formats a time of some seconds or minutes.
pub(super) fn duration_text(secs: f32) -> String {
    let secs = secs.round() as u32;
    let (minutes, rest) = (secs / 60, secs % 60);
    match (minutes, rest) {
        (0..2, _) => format!("{secs} s"),
        (_, 0) => format!("{minutes} min"),
        _ => format!("{minutes} min {rest} s"),
    }
}

/// Returns the time that the figures are about, as a text: the periods are longer than their names
/// by a part that isn't over yet.
pub(super) fn period_text(period: Period, secs: f32) -> String {
    let length = duration_text(secs);
    match period {
        Period::Minute | Period::TenMinutes => format!("last {length}"),
        Period::Run => format!("the run so far ({length})"),
    }
}

/// Shows the switch of the heat map and the choice of its figure and its window.
pub(super) fn layer(context: &PanelContext<'_>, settings: &mut Settings, ui: &mut Ui) {
    ui.checkbox(&mut settings.heat, "heat map of the edges").on_hover_text("Shift+H");
    if !settings.heat {
        return;
    }
    let heat = &mut settings.heat_of;
    ui.horizontal(|ui| {
        let combo =
            ComboBox::from_id_salt("heat figure").selected_text(heat.figure.name()).width(96.0);
        style::choice(ui, "heat map: figure", combo, |ui| {
            for figure in Figure::ALL {
                ui.selectable_value(&mut heat.figure, figure, figure.name());
            }
        });
        let combo =
            ComboBox::from_id_salt("heat window").selected_text(heat.period.title()).width(120.0);
        style::choice(ui, "heat map: window", combo, |ui| {
            for period in Period::ALL {
                ui.selectable_value(&mut heat.period, period, period.title());
            }
        });
    });
    match context.model.jams.heat {
        Some(facts) => {
            let verb = if facts.edges == 1 { "has" } else { "have" };
            let text = format!("{} {verb} a value", with_plural(facts.edges.into(), "edge"));
            ui.label(faint(ui, text));
        }
        None => no_traffic(context, ui),
    }
}

/// Shows the command that publishes the figures of edges.
fn no_traffic(context: &PanelContext<'_>, ui: &mut Ui) {
    let text = format!("regatta plugin traffic --fleet {}", context.model.fleet);
    ui.label(RichText::new(text).monospace().size(11.0).color(context.colours.accent))
        .on_hover_text("No process publishes figures of edges: this command starts one");
}

/// Switches the heat map to its next figure.
pub(super) fn next_figure(settings: &mut Settings) {
    let figure = &mut settings.heat_of.figure;
    let now = Figure::ALL.iter().position(|known| known == figure).unwrap_or_default();
    // The first time, the key shows the figure that is chosen.
    if settings.heat {
        *figure = Figure::ALL[(now + 1) % Figure::ALL.len()];
    }
    settings.heat = true;
}

/// Shows what happens on the selected edge: the robots that are there, and the traffic.
pub(super) fn edge_traffic(context: &PanelContext<'_>, ui: &mut Ui, edge: u32) {
    let Some(facts) = context.model.jams.edge(edge) else { return };
    heading(ui, "traffic");
    line(ui, "waiting now", facts.present.waiting.to_string());
    match &facts.traffic {
        None => no_traffic(context, ui),
        Some(periods) => {
            Grid::new("traffic").num_columns(4).spacing([10.0, 3.0]).show(ui, |ui| {
                ui.label("");
                for name in ["1 min", "10 min", "run"] {
                    ui.label(faint(ui, name));
                }
                ui.end_row();
                for figure in Figure::ALL {
                    ui.label(faint(ui, figure.title().trim_end_matches(" of the limit")));
                    for edge in periods {
                        let text = figure.value(edge).map_or("–".to_owned(), ramp::short);
                        ui.label(RichText::new(text).monospace());
                    }
                    ui.end_row();
                }
            });
        }
    }
}
