//! The levels of a plant: all on top of each other, one alone, or all side by side. Side by side,
//! all have the same camera, so that what is above each other is at the same place of each part of
//! the picture. Mouse and panels act on one level, that of the part that was clicked last.

use egui::{Align2, ComboBox, Event, FontId, LayerId, Pos2, Rect, Stroke, StrokeKind, Ui, vec2};
use glam::{Vec2, Vec3};
use regatta_base::parts::columns;
use regatta_scene::camera::{Bounds, Camera};

use super::context::{PanelContext, Request};
use super::legend::LegendRoom;
use super::placement::Placement;
use super::state::Interface;
use super::style;
use super::view_model::Action;

/// The levels of a world, and the choice of how they are shown.
#[derive(Debug, Default)]
pub(super) struct Levels {
    names: Vec<String>,
    /// Whether all are shown side by side, if there are several.
    is_on: bool,
    /// Whether the filter has been changed by something else than its own panel.
    pub is_refiltered: bool,
    /// The parts of the last picture, in points.
    parts: Vec<(String, Rect)>,
    /// Clicks into a level that was not shown in the part of the last picture yet.
    late_clicks: Vec<Action>,
}

/// The place of the picture of the fleet, in points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureArea {
    /// The picture that mouse and panels act on. It continues under the panels.
    pub picture: Rect,
    /// The part of it that no panel covers.
    pub visible: Rect,
    /// The part that no panel covers of the pictures of all levels.
    pub whole: Rect,
}

impl PictureArea {
    /// The size of the picture.
    pub fn size(&self) -> Vec2 {
        Vec2::new(self.picture.width(), self.picture.height())
    }

    /// Returns the place in the window of a point of the world; `None` behind the camera.
    pub fn place(&self, camera: &Camera, point: Vec3) -> Option<Pos2> {
        let at = camera.project(point, self.size())?;
        Some(self.picture.min + vec2(at.x, at.y))
    }

    /// Returns the place on the ground at a point of the window; `None` above the horizon.
    pub fn ground(&self, camera: &Camera, at: Pos2) -> Option<Vec2> {
        let at = at - self.picture.min;
        camera.unproject(Vec2::new(at.x, at.y), self.size())
    }
}

/// Divides a picture for levels, from the upper left corner on. All parts have the same number of
/// whole pixels.
fn divide(
    levels: &[String],
    whole: Rect,
    extent: Vec2,
    pixels_per_point: f32,
) -> Vec<(String, Rect)> {
    let number = levels.len() as u32;
    let columns = columns(number, Vec2::new(whole.width(), whole.height()), extent);
    let part = whole.size() / vec2(columns as f32, number.div_ceil(columns) as f32);
    let size = (part * pixels_per_point).floor() / pixels_per_point;
    let parts = levels.iter().zip(0..).map(|(level, part)| {
        let at = vec2((part % columns) as f32, (part / columns) as f32);
        (level.clone(), Rect::from_min_size(whole.min + at * size, size))
    });
    parts.collect()
}

impl Interface {
    /// The level that alone is shown, or that mouse and panels are about.
    pub fn level(&self) -> Option<&str> {
        self.filter.level.as_deref()
    }

    /// Takes the names of a world's levels. If the shown one isn't among them, all are shown.
    pub fn set_levels(&mut self, levels: Vec<String>) {
        let unknown = self.filter.level.take_if(|level| !levels.contains(level));
        self.levels.is_refiltered |= unknown.is_some();
        if let Some(level) = unknown.filter(|_| !self.levels.is_on) {
            self.notify(format!("there is no level '{level}'; all are shown"));
        }
        self.levels.names = levels;
    }

    /// Shows one level only, or all.
    pub fn show_level(&mut self, level: Option<String>) {
        self.levels.is_refiltered |= self.filter.level != level;
        self.filter.level = level;
    }

    /// Shows all levels side by side, as soon as a world with several levels is known, or no
    /// longer.
    pub fn show_side_by_side(&mut self, is_on: bool) {
        self.levels.is_refiltered |= self.levels.is_on != is_on;
        self.levels.is_on = is_on;
    }

    /// The levels that are shown beside the one that mouse and panels act on.
    pub fn levels_beside(&self) -> impl Iterator<Item = &str> {
        let beside = self.levels.names.iter().filter(|_| self.levels.is_side_by_side());
        beside.map(String::as_str).filter(|level| Some(*level) != self.level())
    }

    /// The levels and their parts of the last picture, in points; none unless they are side by
    /// side. All parts have the same size.
    pub fn parts(&self) -> &[(String, Rect)] {
        &self.levels.parts
    }

    /// Returns the area of the picture. `picture` continues under the panels, and `whole` is its
    /// visible part. With levels side by side, it is the area of one level. Pressing a mouse button
    /// or turning the wheel in another one changes to that level.
    pub(super) fn area(
        &mut self,
        ui: &Ui,
        picture: Rect,
        whole: Rect,
        bounds: Bounds,
    ) -> PictureArea {
        self.levels.parts.clear();
        if !self.levels.is_side_by_side() || !whole.is_positive() {
            return PictureArea { picture, visible: whole, whole };
        }
        // The legend lies beside the levels, where there is room.
        let LegendRoom { left, below } = self.legend_room(whole.width());
        let beside = whole.with_min_x(whole.left() + left).with_max_y(whole.bottom() - below);
        let parts =
            divide(&self.levels.names, beside, bounds.high - bounds.low, ui.pixels_per_point());
        let wanted = self.pressed_part(ui, &parts).or_else(|| self.level().map(str::to_owned));
        let (level, part) = parts
            .iter()
            .find(|(level, _)| Some(level) == wanted.as_ref())
            .unwrap_or(&parts[0])
            .clone();
        self.show_level(Some(level));
        self.levels.parts = parts;
        PictureArea { picture: part, visible: part, whole }
    }

    fn pressed_part(&self, ui: &Ui, parts: &[(String, Rect)]) -> Option<String> {
        let at = ui.input(|input| {
            let mut places = input.events.iter().filter_map(|event| match event {
                Event::PointerButton { pos, pressed: true, .. } => Some(*pos),
                Event::MouseWheel { .. } => input.pointer.hover_pos(),
                _ => None,
            });
            places.next_back()
        });
        let on_picture = at.filter(|at| {
            ui.ctx().layer_id_at(*at) == Some(ui.layer_id()) && !self.pointer.is_dragging()
        });
        let part = on_picture.and_then(|at| parts.iter().find(|(_, part)| part.contains(at)));
        part.map(|(level, _)| level.clone())
    }

    /// Keeps the clicks into a level that the picture doesn't show yet, and returns those that can
    /// be carried out now.
    pub(super) fn timely(
        &mut self,
        level_before: Option<&str>,
        actions: Vec<Action>,
    ) -> Vec<Action> {
        let mut timely = std::mem::take(&mut self.levels.late_clicks);
        let is_early = !self.levels.parts.is_empty() && self.level() != level_before;
        let (late, now): (Vec<_>, Vec<_>) =
            actions.into_iter().partition(|action| is_early && is_click(action));
        timely.extend(now);
        self.levels.late_clicks = late;
        timely
    }
}

fn is_click(action: &Action) -> bool {
    matches!(action, Action::Pick { .. } | Action::Menu { .. } | Action::Measure { .. })
}

impl Levels {
    fn is_side_by_side(&self) -> bool {
        self.is_on && self.names.len() > 1
    }

    /// Draws frames around the parts, and writes their names.
    pub fn draw_parts(
        &self,
        context: &PanelContext<'_>,
        ctx: &egui::Context,
        placement: &mut Placement,
    ) {
        let (painter, colours) = (ctx.layer_painter(LayerId::background()), context.colours);
        for (level, part) in &self.parts {
            let is_current = Some(level.as_str()) == context.level();
            let (width, colour) =
                if is_current { (2.0, colours.accent) } else { (1.0, colours.faint) };
            painter.rect_stroke(*part, 0.0, Stroke::new(width, colour), StrokeKind::Inside);
            let text =
                painter.layout_no_wrap(level.clone(), FontId::proportional(13.0), colours.text);
            let place = Align2::LEFT_TOP.anchor_size(part.min + vec2(10.0, 7.0), text.size());
            let framed = place.expand2(vec2(5.0, 2.0));
            if part.contains_rect(framed) && placement.take_exactly("level", framed) {
                painter.rect_filled(framed, 4.0, colours.panel);
                painter.galley(place.min, text, colours.text);
            }
        }
    }

    /// Shows the choice of a level, if the world has several.
    pub fn choice(&self, context: &PanelContext<'_>, ui: &mut Ui) {
        if self.names.len() < 2 && context.filter.level.is_none() {
            return;
        }
        let (is_beside, level) = (self.is_side_by_side(), context.level());
        let name = if is_beside { "side by side" } else { level.unwrap_or("all levels") };
        let combo = ComboBox::from_id_salt("level").selected_text(name);
        style::choice(ui, "level", combo, |ui| {
            let is_all = !is_beside && level.is_none();
            if ui.selectable_label(is_all, "all levels").clicked() {
                context.ask(Request::ShowSideBySide(false));
                context.ask(Request::ShowLevel(None));
            }
            if ui.selectable_label(is_beside, "side by side").clicked() {
                context.ask(Request::ShowSideBySide(true));
            }
            for name in &self.names {
                let is_chosen = !is_beside && level == Some(name);
                if ui.selectable_label(is_chosen, name).clicked() {
                    context.ask(Request::ShowSideBySide(false));
                    context.ask(Request::ShowLevel(Some(name.clone())));
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn parts_have_the_same_whole_number_of_pixels_and_lie_within_the_picture() {
        let levels = ["cellar", "ground", "first"].map(str::to_owned);
        for (scale, width) in [(1.0, 1001.0), (1.5, 733.3), (1.25, 640.1)] {
            let whole = Rect::from_min_size(pos2(30.0, 42.0), vec2(width, 401.7));
            let parts = divide(&levels, whole, Vec2::new(40.0, 60.0), scale);
            for (_, part) in &parts {
                assert!(whole.expand(1e-3).contains_rect(*part), "{part}");
                let pixels = part.size() * scale;
                let difference = part.size() - parts[0].1.size();
                assert!(
                    (pixels - pixels.round()).length() < 1e-2 && difference.length() < 1e-2,
                    "{pixels} {difference}"
                );
            }
            let [first, second] = [parts[0].1, parts[1].1];
            assert!(
                (second.left() - first.right()).abs() < 1e-3 && second.top() == first.top(),
                "beside each other"
            );
        }
    }
}
