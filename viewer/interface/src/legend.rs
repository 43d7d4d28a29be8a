//! The legend: the robots' colours, and the symbols of layers. It is a column in the lower left
//! corner of a picture, and in a narrow window lines along its lower side.

use egui::{Align2, Context, Label, RichText, Ui};
use glam::Vec2;
use regatta_scene::camera::Window;
use regatta_scene::palette::{Legend, Scale, Theme};

use super::overlay::{float, measure};
use super::placement::{MARGIN, Placement};
use super::state::Interface;
use super::style;
use super::symbols::Symbols;
use super::{keyed, ramp};

/// The name of the legend among the elements over a picture.
pub const LEGEND: &str = "legend";
/// The greatest width that a column takes, in points, with its margins.
pub const LEGEND_ROOM: f32 = 210.0;
/// The width of a picture below which its legend is lines, in points.
pub(super) const NARROW: f32 = 800.0;
/// The width beside the lines that other elements have, in points.
const BESIDE_LINES: f32 = 220.0;
/// The least width of a picture with lines, in points, and the greatest part of its height that
/// they take.
const LEAST_FOR_LINES: f32 = 480.0;
const MOST_BELOW: f32 = 0.3;
/// The least width of a picture beside a column, in points.
const LEAST_BESIDE: f32 = 240.0;
/// The step of the width of a column in points, so that nothing moves with each of its figures.
const STEP: f32 = 30.0;
/// The greatest width of a column's contents, in points.
const COLUMN: f32 = 168.0;
/// The least width of a picture that has room to spare for a legend, in points.
const WITH_LEGEND: f32 = 500.0;
/// The side of a square of colour, in points.
const SQUARE: f32 = 10.0;

/// The room that a legend takes from a picture, in points, with its margins.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LegendRoom {
    /// From the left: that of a column.
    pub left: f32,
    /// From below: that of lines.
    pub below: f32,
}

/// The parts of a legend.
#[derive(Clone, Debug)]
pub struct LegendView<'a> {
    /// The theme.
    pub theme: Theme,
    /// The robots' colours.
    pub legend: &'a Legend,
    /// The symbols of layers.
    pub symbols: Symbols,
    /// Lines over all that.
    pub title: &'a [String],
}

impl LegendView<'_> {
    /// Shows the legend of a picture, a column. Returns whether there is room for it.
    pub fn show(&self, ctx: &Context, placement: &mut Placement) -> bool {
        float(ctx, placement, self.theme, LEGEND, Align2::LEFT_BOTTOM, |ui| self.column(ui))
    }

    /// Shows the legend of a window, which is lines in a narrow picture.
    pub(super) fn show_in_window(&self, ctx: &Context, placement: &mut Placement) {
        if is_narrow(placement) {
            let width = placement.room().width() - BESIDE_LINES;
            float(ctx, placement, self.theme, LEGEND, Align2::LEFT_BOTTOM, |ui| {
                self.lines(ui, width);
            });
        } else {
            self.show(ctx, placement);
        }
    }

    /// The room of the legend of a window, whether it has it or not.
    pub(super) fn room(&self, ctx: &Context, placement: &Placement) -> LegendRoom {
        let room = placement.room();
        if is_narrow(placement) {
            if room.width() < LEAST_FOR_LINES {
                return LegendRoom::default();
            }
            let width = room.width() - BESIDE_LINES;
            let size = measure(ctx, room, self.theme, "legend's lines", |ui| self.lines(ui, width));
            match size.y <= MOST_BELOW * room.height() {
                true => LegendRoom { left: 0.0, below: size.y + 2.0 * MARGIN },
                false => LegendRoom::default(),
            }
        } else {
            let room = room.with_max_x(room.left() + LEGEND_ROOM);
            let size = measure(ctx, room, self.theme, "legend's width", |ui| self.column(ui));
            let steps = ((size.x + 2.0 * MARGIN) / STEP).ceil();
            LegendRoom { left: (steps * STEP).min(LEGEND_ROOM), below: 0.0 }
        }
    }

    fn column(&self, ui: &mut Ui) {
        ui.set_max_width(COLUMN);
        ui.spacing_mut().item_spacing.y = 4.0;
        self.contents(ui);
    }

    fn lines(&self, ui: &mut Ui, width: f32) {
        ui.set_max_width(width);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(10.0, 2.0);
            self.contents(ui);
        });
    }

    fn contents(&self, ui: &mut Ui) {
        let (theme, colours) = (self.theme, style::colours(self.theme));
        for line in self.title {
            ui.label(RichText::new(style::unbroken(line)).size(11.0).color(colours.faint));
        }
        ui.add(Label::new(RichText::new(&self.legend.title).strong()).extend());
        match &self.legend.scale {
            Scale::Categories(names) => {
                for (name, colour) in names {
                    let place = keyed::show(ui, egui::vec2(SQUARE, SQUARE), name);
                    ui.painter().rect_filled(place, 3.0, style::color32(*colour));
                }
            }
            Scale::Ramp { low, high, unit } => {
                ui.label(style::faint(ui, *unit));
                let numbers = ramp::numbers(*low, *high);
                ramp::show(ui, theme, &self.legend.scale.colours(theme), &numbers);
            }
        }
        self.symbols.show(ui, theme);
    }
}

impl Interface {
    /// The room that a picture leaves to its legend; none if it is too narrow for one.
    pub(super) fn legend_room(&self, width: f32) -> LegendRoom {
        let room = self.last.legend;
        if width - room.left >= LEAST_BESIDE { room } else { LegendRoom::default() }
    }
}

/// Whether the part of a window that no panel covers is too narrow for a column beside the plant.
fn is_narrow(placement: &Placement) -> bool {
    placement.room().width() < NARROW - 2.0 * MARGIN
}

/// Returns the part of a picture, from 0 to 1, in which everything is to fit so that nothing of it
/// lies under the legend. `size` is that of the picture in points. A small picture has no room to
/// spare.
pub fn beside_legend(size: Vec2) -> Window {
    let whole = Window::whole(size.x / size.y);
    match has_room_for_legend(size.x) {
        true => Window { low: Vec2::new(LEGEND_ROOM / size.x, 0.0), ..whole },
        false => whole,
    }
}

/// Whether a picture is wide enough to spare the room for a legend. `width` is in points.
pub fn has_room_for_legend(width: f32) -> bool {
    width >= WITH_LEGEND
}
