//! The figures of the edge under the pointer, beside it.

use std::time::Duration;

use egui::{Area, Id, Order, Pos2, Rect, RichText, Ui, vec2};
use regatta_scene::heat::{Figure, Heat, Period};
use regatta_scene::names::edge_name;

use super::context::PanelContext;
use super::edge_finder::EdgeFinder;
use super::heat::period_text;
use super::levels::PictureArea;
use super::places::PresenceCounter;
use super::ramp;
use super::style::{self, faint, line};
use crate::jams::Presence;
use crate::text::thousands;

/// The largest distance of the pointer from an edge, in points.
const REACH: f32 = 7.0;
/// The time that the pointer rests before the figures are shown, in seconds.
const REST: f32 = 0.2;
/// The width of the figures, in points.
const WIDTH: f32 = 220.0;
/// The figures of an edge where no heat map is shown.
const USUAL: [Figure; 2] = [Figure::Throughput, Figure::Waiting];

/// The edge under the pointer.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeHover {
    edge: Option<u32>,
    finder: EdgeFinder,
    /// The edges that the finder finds.
    source: Option<Source>,
    presence: PresenceCounter,
}

/// The edges of one level of a world, or of all levels.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Source {
    run: u64,
    revision: u64,
    edges: usize,
    level: Option<String>,
}

impl EdgeHover {
    /// The edge whose figures are shown, by its index in the world.
    pub fn edge(&self) -> Option<u32> {
        self.edge
    }

    /// Finds the edge under the pointer, which is over the picture, and shows its figures beside
    /// it, over no panel; those of the heat map first.
    pub fn show(
        &mut self,
        context: &PanelContext<'_>,
        ctx: &egui::Context,
        area: PictureArea,
        pointer: Option<Pos2>,
        heat: Option<Heat>,
    ) {
        let found = pointer.and_then(|at| self.find(context, area, at));
        let rests = ctx.input(|input| input.pointer.time_since_last_movement()) >= REST;
        if found.is_some() && found != self.edge && !rests {
            self.edge = None;
            ctx.request_repaint_after(Duration::from_secs_f32(REST));
            return;
        }
        self.edge = found;
        if let (Some(edge), Some(at)) = (found, pointer) {
            let present = self.presence.on_edge(context.model, edge);
            tooltip(context, ctx, (area.whole, at), edge, |ui| {
                figures(context, ui, edge, present.as_ref(), heat);
            });
        }
    }

    fn find(&mut self, context: &PanelContext<'_>, area: PictureArea, at: Pos2) -> Option<u32> {
        let world = &context.model.world;
        let source = Source {
            run: world.run_id(),
            revision: world.revision(),
            edges: world.edges().len(),
            level: context.filter.level.clone(),
        };
        if self.source.as_ref() != Some(&source) {
            self.finder = EdgeFinder::new(world, context.level());
            self.source = Some(source);
        }
        let place = area.ground(&context.camera, at)?;
        // Far away, a point is more metres.
        let reach = area.ground(&context.camera, at + vec2(REACH, 0.0))?.distance(place);
        self.finder.nearest(world, place - context.offset, reach)
    }
}

/// Shows a tooltip about an edge, within a rectangle, beside a point.
fn tooltip(
    context: &PanelContext<'_>,
    ctx: &egui::Context,
    (within, at): (Rect, Pos2),
    edge: u32,
    contents: impl FnOnce(&mut Ui),
) {
    let model = context.model;
    let Some(record) = model.world.edges().get(edge as usize) else { return };
    let title = format!("edge {}", edge_name(&model.world, record));
    let area = Area::new(Id::unique("edge under the pointer")).order(Order::Tooltip);
    let area = area.fade_in(false).interactable(false).fixed_pos(at + vec2(14.0, 16.0));
    area.constrain_to(within).show(ctx, |ui| {
        style::floating(context.theme).show(ui, |ui| {
            // An area keeps its last width, and would put the columns over each other.
            ui.set_width(WIDTH);
            ui.label(RichText::new(title).strong());
            if model.closed.binary_search(&edge).is_ok() {
                ui.label(RichText::new("closed").color(context.colours.bad));
            }
            contents(ui);
        });
    });
}

/// Shows the figures of an edge; those of the heat map first.
fn figures(
    context: &PanelContext<'_>,
    ui: &mut Ui,
    edge: u32,
    present: Option<&Presence>,
    heat: Option<Heat>,
) {
    // For the past, only the places of robots are known.
    let facts = context.model.jams.edge(edge).filter(|_| !context.model.is_past());
    let period = heat.map_or(Period::TenMinutes, |heat| heat.period);
    let number = Period::ALL.iter().position(|known| *known == period).unwrap_or_default();
    if let Some(periods) = facts.and_then(|facts| facts.traffic) {
        for figure in shown_figures(heat) {
            let value = figure.value(&periods[number]).map_or("–".to_owned(), ramp::short);
            line(ui, figure.title(), value);
        }
    }
    if let Some(present) = present {
        for (name, robots) in [("robots now", present.robots), ("waiting now", present.waiting)] {
            line(ui, name, thousands(robots.into()));
        }
    }
    if let Some(facts) = facts {
        let text = match facts.traffic {
            Some(_) => period_text(period, facts.period_secs[number]),
            None => "more with: regatta plugin traffic".to_owned(),
        };
        ui.label(faint(ui, text));
    }
}

/// Returns the figures to show, that of the heat map first.
fn shown_figures(heat: Option<Heat>) -> Vec<Figure> {
    let Some(heat) = heat else { return USUAL.to_vec() };
    let mut figures = Figure::ALL.to_vec();
    figures.sort_by_key(|figure| *figure != heat.figure);
    figures
}
