//! Elements that float over the picture: the legend, the camera's position, messages, and the note that no engine runs
//! yet.

use egui::{Align2, Area, Context, Id, Order, Rect, RichText, Sense, Ui, vec2};

use glam::Vec2;

use super::heat::HeatLegend;
use super::labels::{LabelView, Labels};
use super::levels::PictureArea;
use super::plan;
use super::ramp;
use super::robot_spots;
use super::state::Interface;
use super::style;
use super::symbols::Symbols;
use super::view_model::{EngineState, ViewModel};
use crate::camera::Window as PictureWindow;
use crate::palette::{Legend, Scale, Theme};

/// The distance from the edge of the picture, in points.
const MARGIN: f32 = 10.0;
/// The name of the legend's area.
const LEGEND: &str = "legend";
/// The width that a legend takes, in points, with its margins.
const LEGEND_ROOM: f32 = 205.0;
/// Seconds for which a message is shown.
const MESSAGE_SECONDS: f64 = 8.0;

impl Interface {
    /// Shows what floats over the picture.
    pub(super) fn overlay(&mut self, context: &Context, area: PictureArea, model: &ViewModel<'_>) {
        let PictureArea { picture, visible, whole } = area;
        if model.engine == EngineState::Awaited {
            self.waiting(context, whole, model);
        } else {
            if model.engine == EngineState::Gone {
                self.veil(context, whole, model);
            }
            self.ids(context, picture, visible, model);
            let (camera, theme) = (self.camera_controller.camera(), self.settings.theme());
            if camera.is_plan() && visible.is_positive() {
                plan::draw(context, picture, visible, legend_place(context), &camera, theme);
            }
            self.draw_measurement(context, picture, visible, model);
            let heat = self.settings.heat.then_some(HeatLegend { heat: self.settings.heat_of, facts: model.jams.heat });
            let symbols = Symbols {
                plans: self.settings.plans,
                waits: self.settings.waits,
                facts: model.plans,
                heat,
                density: model.density,
                closed: if self.settings.edges { model.closed.len() as u32 } else { 0 },
            };
            self.draw_parts(context);
            legend(context, whole, theme, model.legend, &symbols, None);
            self.draw_mark(context, picture, visible);
            self.coordinates(context, area, model);
        }
        self.messages(context, whole);
    }

    /// Draws the ids of nodes, edges and robots.
    fn ids(&self, context: &Context, picture: Rect, visible: Rect, model: &ViewModel<'_>) {
        let (ids, robot_ids) = (self.settings.ids, self.settings.robot_ids);
        if !ids && !robot_ids {
            return;
        }
        let (camera, offset, theme) =
            (&self.camera_controller.camera(), Vec2::from(self.settings.offset), self.settings.theme());
        let size = Vec2::new(picture.width(), picture.height());
        let find = |frame| robot_spots::find(&frame, &model.world, self.level(), camera, offset, size);
        let spots = model.frame.map(find).unwrap_or_default();
        if ids {
            let view = LabelView { picture, camera, offset, theme, robots: &spots };
            model.labels.draw(context, visible, &view);
        }
        if robot_ids {
            robot_spots::draw(context, visible, picture, theme, &spots);
        }
        if ids {
            let is_shown = |id: &u32| {
                let edge = model.frame.and_then(|frame| frame.edge().get(*id as usize).copied());
                let edge = edge.and_then(|edge| model.world.edges().get(edge as usize));
                self.level().is_none_or(|level| edge.is_some_and(|edge| model.world.text(edge.level) == level))
            };
            let place = |id| Some((id, model.pose(id, offset)?.place));
            let robots = self.robots().into_iter().filter(is_shown).filter_map(place);
            Labels::draw_robots(context, picture, visible, camera, theme, robots);
        }
    }

    fn float(&self, context: &Context, picture: Rect, name: &str, place: Align2, show: impl FnOnce(&mut Ui)) {
        float(context, picture, self.settings.theme(), name, place, show);
    }

    /// Shows the ground under the pointer, where the camera is, and what is measured.
    fn coordinates(&self, context: &Context, area: PictureArea, model: &ViewModel<'_>) {
        let PictureArea { picture, visible, whole } = area;
        let camera = self.camera_controller.camera();
        let (eye, size) = (camera.eye(), Vec2::new(picture.width(), picture.height()));
        let mut lines = self.measuring_text(model).unwrap_or_default();
        let pointer = context.pointer_hover_pos().filter(|at| visible.contains(*at)).map(|at| at - picture.min);
        let ground = pointer.and_then(|at| camera.unproject(Vec2::new(at.x, at.y), size));
        lines.push(match ground {
            Some(at) => format!("x {:.2} m  y {:.2} m", at.x, at.y),
            None => "x –  y –".to_owned(),
        });
        if !camera.is_plan() && whole.width() > 520.0 {
            let [yaw, pitch] = [camera.yaw, camera.pitch].map(f32::to_degrees);
            lines.push(format!("camera  {:.1}  {:.1}  {:.1} m   {yaw:.0}°  {pitch:.0}°", eye.x, eye.y, eye.z));
        }
        self.float(context, whole, "camera", Align2::RIGHT_BOTTOM, |ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            for line in lines {
                let text = RichText::new(line).monospace().size(11.0).color(self.colours().faint);
                ui.add(egui::Label::new(text).extend());
            }
        });
    }

    /// Greys the picture of a fleet that has ended, of which no panel covers `visible`, and says so.
    fn veil(&self, context: &Context, visible: Rect, model: &ViewModel<'_>) {
        let (theme, colours) = (self.settings.theme(), self.colours());
        let painter = context.layer_painter(egui::LayerId::background());
        painter.with_clip_rect(visible).rect_filled(visible, 0.0, egui::Color32::from_gray(128).gamma_multiply(0.55));
        let what = if model.recording().is_some() { "The replay has ended" } else { "The engine has ended" };
        let time = model.frame.map(|frame| frame.sim_time().as_secs_f64());
        self.float(context, visible, "ended", Align2::CENTER_BOTTOM, |ui| {
            ui.label(RichText::new(what).strong().color(colours.bad));
            let last = time.map_or("nothing", |_| "this is its last picture, of ").to_owned();
            let text = last + &time.map(super::transport::clock_text).unwrap_or_default();
            ui.label(style::faint(ui, theme, text + "; a new one is shown as soon as it runs"));
        });
    }

    fn waiting(&self, context: &Context, picture: Rect, model: &ViewModel<'_>) {
        let (theme, colours) = (self.settings.theme(), self.colours());
        self.float(context, picture, "waiting", Align2::CENTER_CENTER, |ui| {
            ui.set_max_width(360.0);
            ui.vertical_centered(|ui| {
                ui.add_space(10.0);
                ui.spinner();
                ui.add_space(6.0);
                ui.label(RichText::new(format!("Waiting for fleet '{}'", model.fleet)).size(18.0));
                ui.label(style::faint(ui, theme, "It appears as soon as an engine runs. Start one with:"));
                let name = if model.fleet == "default" { String::new() } else { format!(" --fleet {}", model.fleet) };
                ui.label(RichText::new(format!("regatta run{name}")).monospace().color(colours.accent));
                ui.add_space(10.0);
            });
        });
    }

    fn messages(&mut self, context: &Context, picture: Rect) {
        let now = context.input(|input| input.time);
        for message in &mut self.messages {
            message.until.get_or_insert(now + MESSAGE_SECONDS);
        }
        self.messages.retain(|message| message.until.is_none_or(|until| until > now));
        let Some(next) = self.messages.iter().filter_map(|message| message.until).reduce(f64::min) else { return };
        context.request_repaint_after_secs((next - now) as f32);
        self.float(context, picture, "messages", Align2::CENTER_TOP, |ui| {
            ui.set_max_width((picture.width() - 4.0 * MARGIN).clamp(120.0, 620.0));
            for message in &self.messages {
                ui.label(RichText::new(&message.text).color(self.colours().text));
            }
        });
    }
}

/// Shows an element in a corner, at an edge or in the centre of the picture.
pub(super) fn float(
    context: &Context,
    picture: Rect,
    theme: Theme,
    name: &str,
    place: Align2,
    show: impl FnOnce(&mut Ui),
) {
    let inside = picture.shrink(MARGIN);
    if !inside.is_positive() {
        return;
    }
    let area = Area::new(Id::unique(name)).order(Order::Background).interactable(false).fade_in(false);
    area.pivot(place).fixed_pos(place.pos_in_rect(&inside)).show(context, |ui| {
        style::floating(theme).show(ui, show);
    });
}

/// Where the legend is, as far as it was shown in the last picture; nothing otherwise.
pub fn legend_place(context: &Context) -> Rect {
    context.memory(|memory| memory.area_rect(Id::unique(LEGEND))).unwrap_or(Rect::NOTHING)
}

/// Returns the part of a picture, from 0 to 1, in which everything is to fit so that nothing of it lies under the legend. `size` is
/// that of the picture in points. A small picture has no room to spare.
pub fn beside_legend(size: Vec2) -> PictureWindow {
    let whole = PictureWindow::whole(size.x / size.y);
    match size.x >= 800.0 {
        true => PictureWindow { low: Vec2::new(LEGEND_ROOM / size.x, 0.0), ..whole },
        false => whole,
    }
}

/// Shows the legend: the robots' colours, and the symbols of layers. Pictures have the fleet, the time and the number of robots
/// above it.
pub fn legend(
    context: &Context,
    picture: Rect,
    theme: Theme,
    legend: &Legend,
    symbols: &Symbols,
    title: Option<&[String]>,
) {
    let colours = style::colours(theme);
    float(context, picture, theme, LEGEND, Align2::LEFT_BOTTOM, |ui| {
        ui.spacing_mut().item_spacing.y = 4.0;
        for line in title.unwrap_or_default() {
            ui.label(RichText::new(line).size(11.0).color(colours.faint));
        }
        ui.label(RichText::new(&legend.title).strong());
        match &legend.scale {
            Scale::Categories(names) => {
                for (name, colour) in names {
                    ui.horizontal(|ui| {
                        let (dot, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                        ui.painter().rect_filled(dot, 3.0, style::color32(*colour));
                        ui.label(style::faint(ui, theme, name));
                    });
                }
            }
            Scale::Ramp { low, high, unit } => {
                ui.label(style::faint(ui, theme, *unit));
                ramp::show(ui, theme, &legend.scale.colours(theme), &ramp::numbers(*low, *high));
            }
        }
        symbols.show(ui, theme);
    });
}
