//! The part of the legend that explains the layers of plans: lines, pins and arrows.

use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, Ui, pos2, vec2};
use regatta_scene::Layers;
use regatta_scene::palette::{CLOSED, Theme};
use regatta_scene::plans::{PlanFacts, Waiting};

use super::heat::HeatLegend;
use super::style::{self, color32};
use super::{keyed, ramp};
use crate::text::{thousands, with_plural};

/// The width and the height of a symbol, in points.
const SIZE: egui::Vec2 = vec2(26.0, 12.0);

/// The shown layers of plans, and their known facts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Symbols {
    /// Routes and goals of all robots.
    pub plans: bool,
    /// The robots that others wait for.
    pub waits: bool,
    /// The facts of the plans.
    pub facts: PlanFacts,
    /// The density of half the strength in robots per hectare, if robots are drawn as their
    /// density.
    pub density: Option<f32>,
    /// Number of closed edges; none if edges aren't shown.
    pub closed: u32,
    /// The heat map, if it is shown.
    pub heat: Option<HeatLegend>,
}

/// A drawing beside a text of the legend.
#[derive(Clone, Copy)]
enum Symbol {
    Solid,
    Dashed,
    Pin,
    Arrow,
    RingArrow,
    NoEntry,
}

impl Symbols {
    /// Returns the symbols of a picture's layers.
    pub fn new(layers: Layers, facts: PlanFacts) -> Self {
        Self { plans: layers.plans, waits: layers.waits, facts, ..Self::default() }
    }

    fn list(&self) -> Vec<(Symbol, String)> {
        let mut list = Vec::new();
        if self.plans {
            list.push((Symbol::Solid, "may drive now".to_owned()));
            list.push((Symbol::Dashed, "planned".to_owned()));
            list.push((Symbol::Pin, "goal".to_owned()));
        }
        if self.waits {
            let Waiting { robots, in_rings } = self.facts.waiting.unwrap_or_default();
            let (robots, in_rings) = (thousands(robots.into()), thousands(in_rings.into()));
            list.push((Symbol::Arrow, format!("waits for ({robots})")));
            list.push((Symbol::RingArrow, format!("ring of waiting ({in_rings})")));
        }
        match self.closed {
            0 => {}
            closed => {
                list.push((Symbol::NoEntry, format!("closed ({})", thousands(closed.into()))))
            }
        }
        list
    }

    /// Returns the facts that the picture lacks, as texts.
    fn gaps(&self) -> Vec<String> {
        let mut gaps = Vec::new();
        if let Some(routes) = self.facts.routes.filter(|_| self.plans && self.facts.lacks_routes())
        {
            let noun = if self.facts.is_filtered { "matching robot" } else { "robot" };
            let (known, robots) =
                (thousands(routes.known.into()), with_plural(routes.under_way.into(), noun));
            gaps.push(format!("routes of {known} of {robots}"));
        }
        if self.plans && !self.facts.has_goals {
            gaps.push("goals: not published".to_owned());
        }
        if self.waits && self.facts.waiting.is_none() {
            gaps.push("who waits: not published".to_owned());
        }
        gaps
    }

    /// Shows the symbols with their texts; nothing if no layer of plans is shown.
    pub fn show(&self, ui: &mut Ui, theme: Theme) {
        let colours = style::colours(theme);
        if self.plans || self.waits || self.closed > 0 {
            ui.add_space(3.0);
        }
        if self.facts.is_filtered && (self.plans || self.waits) {
            ui.label(style::faint(ui, "of matching robots:"));
        }
        for (symbol, text) in self.list() {
            let place = keyed::show(ui, SIZE, &text);
            draw(ui.painter(), symbol, place, theme);
        }
        for gap in self.gaps() {
            ui.label(egui::RichText::new(style::unbroken(&gap)).size(11.0).color(colours.warn));
        }
        if let Some(mean) = self.density {
            density(ui, theme, mean);
        }
        if let Some(heat) = self.heat {
            heat.show(ui, theme);
        }
    }
}

/// Shows the ramp of densities. The mean of the fleet's ground has half the strength.
fn density(ui: &mut Ui, theme: Theme, mean: f32) {
    ui.add_space(3.0);
    ui.label(style::faint(ui, "robots per hectare"));
    let colours = theme.colours();
    let steps: Vec<_> =
        (0..16).map(|step| colours.floor.mix(colours.unknown, step as f32 / 15.0)).collect();
    let numbers = [(0.0, 0.0), (0.5, mean), (0.75, 2.0 * mean)]
        .map(|(place, value)| (place, ramp::short(value)));
    ramp::show(ui, theme, &steps, &numbers);
}

fn draw(painter: &Painter, symbol: Symbol, place: Rect, theme: Theme) {
    let colours = theme.colours();
    let (left, right) = (place.left_center(), place.right_center());
    let route = color32(colours.route);
    match symbol {
        Symbol::Solid => {
            painter.line_segment([left, right], Stroke::new(2.5, route));
        }
        Symbol::Dashed => {
            painter.extend(Shape::dashed_line(&[left, right], Stroke::new(2.5, route), 5.0, 4.0));
        }
        Symbol::Pin => pin(painter, place.center(), route),
        Symbol::Arrow => arrow(painter, [left, right], 1.6, color32(colours.waiting)),
        Symbol::RingArrow => arrow(painter, [left, right], 3.2, color32(colours.ring)),
        Symbol::NoEntry => no_entry(painter, [left, right]),
    }
}

fn no_entry(painter: &Painter, ends: [Pos2; 2]) {
    let (red, centre) = (color32(CLOSED), ends[0].lerp(ends[1], 0.5));
    painter.extend(Shape::dashed_line(&ends, Stroke::new(2.5, red), 4.0, 3.0));
    painter.circle(centre, 5.5, red, Stroke::new(1.0, Color32::WHITE));
    painter.rect_filled(Rect::from_center_size(centre, vec2(7.0, 2.2)), 0.0, Color32::WHITE);
}

fn pin(painter: &Painter, centre: Pos2, colour: Color32) {
    let head = centre - vec2(0.0, 2.0);
    let wedge = [head + vec2(-3.5, 1.0), head + vec2(3.5, 1.0), centre + vec2(0.0, 6.0)];
    painter.add(Shape::convex_polygon(wedge.to_vec(), colour, Stroke::NONE));
    painter.circle_filled(head, 4.0, colour);
    painter.circle_filled(head, 1.6, Color32::from_gray(20));
}

fn arrow(painter: &Painter, [from, to]: [Pos2; 2], width: f32, colour: Color32) {
    let (length, half) = (width * 2.2 + 3.0, width * 1.2 + 2.0);
    painter.line_segment([from, pos2(to.x - length * 0.5, to.y)], Stroke::new(width, colour));
    let head = [to, pos2(to.x - length, to.y - half), pos2(to.x - length, to.y + half)];
    painter.add(Shape::convex_polygon(head.to_vec(), colour, Stroke::NONE));
}
