//! The figures of the edge under the pointer, beside it.

use std::time::Duration;

use egui::{Area, Context, Grid, Id, Order, Pos2, Rect, RichText, Ui, vec2};
use glam::Vec2;
use regatta_plugin::traffic::{EdgeTraffic, TRAFFIC_PERIODS};
use regatta_scene::heat::{Figure, Period};

use super::edge_finder::EdgeFinder;
use super::heat::period_text;
use super::levels::PictureArea;
use super::ramp;
use super::state::Interface;
use super::style::{self, faint};
use super::view_model::ViewModel;
use crate::jams::Presence;
use crate::text::thousands;

/// The figures of an edge by period, and the length of each period so far, in seconds.
type Periods = ([EdgeTraffic; TRAFFIC_PERIODS], [f32; TRAFFIC_PERIODS]);

/// How near the pointer is to an edge, in points.
const REACH: f32 = 7.0;
/// How long the pointer rests before the figures are shown, in seconds.
const REST: f32 = 0.2;
/// The figures of an edge where no heat map is shown.
const USUAL: [Figure; 2] = [Figure::Throughput, Figure::Waiting];

/// The edge under the pointer.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeHover {
    edge: Option<u32>,
    finder: EdgeFinder,
    /// The world that the finder is of: its run and revision, its edges, and the level.
    source: Option<(u64, u64, usize, Option<String>)>,
}

impl EdgeHover {
    /// The edge whose figures are shown, by its index in the world.
    pub fn edge(&self) -> Option<u32> {
        self.edge
    }
}

impl Interface {
    /// Finds the edge under the pointer, which is over the picture, and shows its figures beside
    /// it, over no panel.
    pub(super) fn hover_edge(
        &mut self,
        context: &Context,
        area: PictureArea,
        pointer: Option<Pos2>,
        model: &ViewModel<'_>,
    ) {
        let at = pointer
            .filter(|_| self.settings.edges && self.menu.is_none() && self.measuring.is_none());
        let found = at.and_then(|at| self.edge_at(at, area.picture, model));
        let rests = context.input(|input| input.pointer.time_since_last_movement()) >= REST;
        if found.is_some() && found != self.edge_hover.edge && !rests {
            self.edge_hover.edge = None;
            context.request_repaint_after(Duration::from_secs_f32(REST));
            return;
        }
        self.edge_hover.edge = found;
        if let (Some(edge), Some(at)) = (found, at) {
            self.edge_tooltip(context, area.whole, at, edge, model);
        }
    }

    fn edge_at(&mut self, at: Pos2, picture: Rect, model: &ViewModel<'_>) -> Option<u32> {
        let world = &model.world;
        let source = (
            world.run_id(),
            world.revision(),
            world.edges().len(),
            self.level().map(str::to_owned),
        );
        if self.edge_hover.source.as_ref() != Some(&source) {
            self.edge_hover.finder = EdgeFinder::new(world, self.level());
            self.edge_hover.source = Some(source);
        }
        let (camera, size) =
            (self.camera_controller.camera(), Vec2::new(picture.width(), picture.height()));
        let ground = |at: Pos2| {
            camera.unproject(Vec2::new(at.x - picture.left(), at.y - picture.top()), size)
        };
        let place = ground(at)?;
        // Far away, a point is more metres.
        let reach = ground(at + vec2(REACH, 0.0))?.distance(place);
        self.edge_hover.finder.nearest(world, place - Vec2::from(self.settings.offset), reach)
    }

    fn edge_tooltip(
        &mut self,
        context: &Context,
        within: Rect,
        at: Pos2,
        edge: u32,
        model: &ViewModel<'_>,
    ) {
        let Some(record) = model.world.edges().get(edge as usize) else { return };
        let theme = self.settings.theme();
        let present = self.present_on_edge(model, edge);
        let title = match model.world.text(record.name) {
            "" => format!("edge {}", record.id),
            name => format!("edge {}, {name}", record.id),
        };
        // Of a time that is over, only where robots were is known.
        let traffic = model
            .jams
            .edge(edge)
            .filter(|_| !model.is_past())
            .map(|facts| facts.traffic.map(|traffic| (traffic, facts.period_secs)));
        let area =
            Area::new(Id::unique("edge under the pointer")).order(Order::Tooltip).fade_in(false);
        area.interactable(false).fixed_pos(at + vec2(14.0, 16.0)).constrain_to(within).show(
            context,
            |ui| {
                style::floating(theme).show(ui, |ui| {
                    ui.set_max_width(260.0);
                    ui.label(RichText::new(title).strong());
                    if model.closed.binary_search(&edge).is_ok() {
                        ui.label(RichText::new("closed").color(self.colours().bad));
                    }
                    self.tooltip_figures(ui, present, traffic);
                });
            },
        );
    }

    /// Shows the figures; those of the heat map first.
    fn tooltip_figures(
        &self,
        ui: &mut Ui,
        present: Option<Presence>,
        traffic: Option<Option<Periods>>,
    ) {
        let theme = self.settings.theme();
        let heat = self.settings.heat.then_some(self.settings.heat_of);
        let period = heat.map_or(Period::TenMinutes, |heat| heat.period);
        let number = Period::ALL.iter().position(|known| *known == period).unwrap_or_default();
        Grid::new("edge under the pointer").num_columns(2).spacing([10.0, 2.0]).show(ui, |ui| {
            let mut row = |name: &str, value: String, is_first: bool| {
                let value = RichText::new(value).monospace();
                ui.label(faint(ui, theme, name));
                ui.label(if is_first {
                    value.strong().color(self.colours().accent)
                } else {
                    value
                });
                ui.end_row();
            };
            if let Some((periods, _)) = traffic.flatten() {
                let figures: Vec<Figure> = match heat {
                    Some(heat) => {
                        let others =
                            Figure::ALL.into_iter().filter(|figure| *figure != heat.figure);
                        [heat.figure].into_iter().chain(others).collect()
                    }
                    None => USUAL.to_vec(),
                };
                for figure in figures {
                    let value = figure.value(&periods[number]).map_or("–".to_owned(), ramp::short);
                    row(figure.title(), value, heat.is_some_and(|heat| heat.figure == figure));
                }
            }
            if let Some(present) = present {
                row("robots now", thousands(present.robots.into()), false);
                row("waiting now", thousands(present.waiting.into()), false);
            }
        });
        match traffic {
            Some(Some((_, secs))) => {
                _ = ui.label(faint(ui, theme, period_text(period, secs[number])))
            }
            Some(None) => _ = ui.label(faint(ui, theme, "more with: regatta plugin traffic")),
            None => {}
        }
    }
}
