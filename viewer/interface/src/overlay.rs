//! Elements that float over the picture: the legend, the camera's position, messages, and the note
//! that no engine runs yet.

use egui::{Align2, Area, Context, Id, LayerId, Order, Rect, RichText, Sense, Ui, UiBuilder, vec2};
use glam::Vec2;
use regatta_scene::camera::Window as PictureWindow;
use regatta_scene::palette::{Legend, Scale, Theme};

use super::heat::HeatLegend;
use super::labels::{LabelView, Labels};
use super::levels::PictureArea;
use super::placement::Placement;
use super::plan::PlanScale;
use super::ramp;
use super::robot_spots;
use super::state::Interface;
use super::style;
use super::symbols::Symbols;
use super::view_model::{EngineState, ViewModel};

/// The name of the legend among what is placed over a picture.
pub const LEGEND: &str = "legend";
/// The width that a legend takes, in points, with its margins.
const LEGEND_ROOM: f32 = 210.0;
/// The least width of what is free of a picture with a legend, which would cover its middle, in
/// points.
const LEAST_WITH_LEGEND: f32 = 240.0;
/// The greatest width of a legend's contents, in points.
const LEGEND_TEXT: f32 = 168.0;
/// The least width of a picture that has room to spare for a legend, in points.
const WITH_LEGEND: f32 = 500.0;
/// The greatest width of messages, in points.
const WIDEST_MESSAGE: f32 = 620.0;
/// Seconds for which a message is shown.
const MESSAGE_SECONDS: f64 = 8.0;

impl Interface {
    /// Shows what floats over the picture, the most important first: where there is no room, the
    /// last ones are left out.
    pub(super) fn overlay(&mut self, context: &Context, area: PictureArea, model: &ViewModel<'_>) {
        let PictureArea { picture, visible, whole } = area;
        let mut placement = Placement::new(whole);
        if model.engine == EngineState::Awaited {
            self.waiting(context, &mut placement, model);
            self.messages(context, &mut placement);
        } else {
            self.draw_parts(context, &mut placement);
            if model.engine == EngineState::Gone {
                self.veil(context, whole, &mut placement, model);
            }
            self.messages(context, &mut placement);
            self.ids(context, picture, visible, model);
            self.draw_measurement(context, picture, visible, model);
            self.draw_mark(context, picture, visible);
            self.elements(context, area, &mut placement, model);
        }
        self.placement = placement;
    }

    /// Shows the elements that are always there, as far as there is room.
    fn elements(
        &mut self,
        context: &Context,
        area: PictureArea,
        placement: &mut Placement,
        model: &ViewModel<'_>,
    ) {
        let PictureArea { picture, visible, .. } = area;
        let (camera, theme) = (self.camera_controller.camera(), self.settings.theme());
        let measurement = self.measuring_text(model);
        if let Some(lines) = &measurement {
            self.lines(context, placement, "measurement", lines);
        }
        if visible.width() >= LEAST_WITH_LEGEND {
            legend(context, placement, theme, model.legend, &self.symbols(model), None);
        }
        let scale =
            camera.is_plan().then(|| PlanScale::place(placement, picture, visible, &camera));
        self.view_cube(context, placement);
        self.minimap(context, area, placement, model);
        self.coordinates(context, area, placement);
        if let Some(scale) = scale {
            scale.draw(context, placement, picture, visible, &camera, theme);
        }
    }

    /// The layers that the legend explains.
    fn symbols(&self, model: &ViewModel<'_>) -> Symbols {
        Symbols {
            plans: self.settings.plans,
            waits: self.settings.waits,
            facts: model.plans,
            heat: self
                .settings
                .heat
                .then_some(HeatLegend { heat: self.settings.heat_of, facts: model.jams.heat }),
            density: model.density,
            closed: if self.settings.edges { model.closed.len() as u32 } else { 0 },
        }
    }

    /// The names and the places of what is over the picture, in points.
    pub fn placed(&self) -> &[(&'static str, Rect)] {
        self.placement.taken()
    }

    /// Draws the ids of nodes, edges and robots.
    fn ids(&self, context: &Context, picture: Rect, visible: Rect, model: &ViewModel<'_>) {
        let (ids, robot_ids) = (self.settings.ids, self.settings.robot_ids);
        if !ids && !robot_ids {
            return;
        }
        let (camera, offset, theme) = (
            &self.camera_controller.camera(),
            Vec2::from(self.settings.offset),
            self.settings.theme(),
        );
        let size = Vec2::new(picture.width(), picture.height());
        let find =
            |frame| robot_spots::find(&frame, &model.world, self.level(), camera, offset, size);
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
                self.level().is_none_or(|level| {
                    edge.is_some_and(|edge| model.world.text(edge.level) == level)
                })
            };
            let place = |id| Some((id, model.pose(id, offset)?.place));
            let robots = self.robots().into_iter().filter(is_shown).filter_map(place);
            Labels::draw_robots(context, picture, visible, camera, theme, robots);
        }
    }

    /// Shows the ground under the pointer, and where the camera is.
    fn coordinates(&self, context: &Context, area: PictureArea, placement: &mut Placement) {
        let PictureArea { picture, visible, whole } = area;
        let camera = self.camera_controller.camera();
        let (eye, size) = (camera.eye(), Vec2::new(picture.width(), picture.height()));
        let pointer = context
            .pointer_hover_pos()
            .filter(|at| visible.contains(*at))
            .map(|at| at - picture.min);
        let ground = pointer.and_then(|at| camera.unproject(Vec2::new(at.x, at.y), size));
        let mut lines = vec![match ground {
            Some(at) => format!("x {:.2} m  y {:.2} m", at.x, at.y),
            None => "x –  y –".to_owned(),
        }];
        if !camera.is_plan() && whole.width() > 520.0 {
            let [yaw, pitch] = [camera.yaw, camera.pitch].map(f32::to_degrees);
            lines.push(format!(
                "camera  {:.1}  {:.1}  {:.1} m   {yaw:.0}°  {pitch:.0}°",
                eye.x, eye.y, eye.z
            ));
        }
        self.lines(context, placement, "coordinates", &lines);
    }

    /// Shows lines of figures in the lower right corner.
    fn lines(
        &self,
        context: &Context,
        placement: &mut Placement,
        name: &'static str,
        lines: &[String],
    ) {
        float(context, placement, self.settings.theme(), name, Align2::RIGHT_BOTTOM, |ui| {
            ui.spacing_mut().item_spacing.y = 2.0;
            for line in lines {
                let text = RichText::new(line).monospace().size(11.0).color(self.colours().faint);
                ui.add(egui::Label::new(text).extend());
            }
        });
    }

    /// Greys the picture of a fleet that has ended, of which no panel covers `visible`, and says
    /// so.
    fn veil(
        &self,
        context: &Context,
        visible: Rect,
        placement: &mut Placement,
        model: &ViewModel<'_>,
    ) {
        let (theme, colours) = (self.settings.theme(), self.colours());
        let painter = context.layer_painter(LayerId::background());
        painter.with_clip_rect(visible).rect_filled(
            visible,
            0.0,
            egui::Color32::from_gray(128).gamma_multiply(0.55),
        );
        let what = if model.recording().is_some() {
            "The replay has ended"
        } else {
            "The engine has ended"
        };
        let time = model.frame.map(|frame| frame.sim_time().as_secs_f64());
        let last = time.map_or("nothing", |_| "this is its last picture, of ").to_owned();
        let text = last + &time.map(super::transport::clock_text).unwrap_or_default();
        let text = text + "; a new one is shown as soon as it runs";
        float(context, placement, theme, "ended", Align2::CENTER_TOP, |ui| {
            ui.set_max_width(ui.available_width().min(WIDEST_MESSAGE));
            ui.label(RichText::new(what).strong().color(colours.bad));
            ui.label(style::faint(ui, theme, &text));
        });
    }

    fn waiting(&self, context: &Context, placement: &mut Placement, model: &ViewModel<'_>) {
        let (theme, colours) = (self.settings.theme(), self.colours());
        float(context, placement, theme, "waiting", Align2::CENTER_CENTER, |ui| {
            ui.set_max_width(360.0);
            ui.vertical_centered(|ui| {
                ui.add_space(10.0);
                ui.spinner();
                ui.add_space(6.0);
                ui.label(RichText::new(format!("Waiting for fleet '{}'", model.fleet)).size(18.0));
                ui.label(style::faint(
                    ui,
                    theme,
                    "It appears as soon as an engine runs. Start one with:",
                ));
                let name = if model.fleet == "default" {
                    String::new()
                } else {
                    format!(" --fleet {}", model.fleet)
                };
                ui.label(
                    RichText::new(format!("regatta run{name}")).monospace().color(colours.accent),
                );
                ui.add_space(10.0);
            });
        });
    }

    fn messages(&mut self, context: &Context, placement: &mut Placement) {
        let now = context.input(|input| input.time);
        for message in &mut self.messages {
            message.until.get_or_insert(now + MESSAGE_SECONDS);
        }
        self.messages.retain(|message| message.until.is_none_or(|until| until > now));
        let Some(next) = self.messages.iter().filter_map(|message| message.until).reduce(f64::min)
        else {
            return;
        };
        context.request_repaint_after_secs((next - now) as f32);
        float(context, placement, self.settings.theme(), "messages", Align2::CENTER_TOP, |ui| {
            ui.set_max_width(ui.available_width().min(WIDEST_MESSAGE));
            for message in &self.messages {
                ui.label(RichText::new(&message.text).color(self.colours().text));
            }
        });
    }
}

/// Shows an element in a corner, at an edge or in the centre of the picture, or beside what is
/// there already. Returns whether there is room for it. `show` is called twice: what it shows is
/// measured, and then placed.
pub(super) fn float(
    context: &Context,
    placement: &mut Placement,
    theme: Theme,
    name: &'static str,
    at: Align2,
    mut show: impl FnMut(&mut Ui),
) -> bool {
    let (room, frame) = (placement.room(), style::floating(theme));
    if !room.is_positive() {
        return false;
    }
    let unseen = UiBuilder::new().layer_id(LayerId::background()).max_rect(room).invisible();
    let mut ui = Ui::new(context.clone(), Id::unique(("size", name)), unseen);
    let size = frame.show(&mut ui, |ui| show(ui)).response.rect.size();
    let Some(place) = placement.take(name, size, at) else { return false };
    let area =
        Area::new(Id::unique(name)).order(Order::Background).interactable(false).fade_in(false);
    area.fixed_pos(place.min).show(context, |ui| {
        // An area is as wide as what it showed the last time, and would break longer lines.
        let within = UiBuilder::new()
            .max_rect(Rect::from_min_size(ui.min_rect().min, place.size() + vec2(1.0, 1.0)));
        ui.scope_builder(within, |ui| frame.show(ui, show));
    });
    true
}

/// Returns the part of a picture, from 0 to 1, in which everything is to fit so that nothing of it
/// lies under the legend. `size` is that of the picture in points. A small picture has no room to
/// spare.
pub fn beside_legend(size: Vec2) -> PictureWindow {
    let whole = PictureWindow::whole(size.x / size.y);
    match has_room_for_legend(size.x) {
        true => PictureWindow { low: Vec2::new(LEGEND_ROOM / size.x, 0.0), ..whole },
        false => whole,
    }
}

/// Whether a picture is wide enough to spare the room for a legend. `width` is in points.
pub fn has_room_for_legend(width: f32) -> bool {
    width >= WITH_LEGEND
}

/// Shows the legend: the robots' colours, and the symbols of layers. Pictures have the fleet, the
/// time and the number of robots above it. Returns whether there is room for it.
pub fn legend(
    context: &Context,
    placement: &mut Placement,
    theme: Theme,
    legend: &Legend,
    symbols: &Symbols,
    title: Option<&[String]>,
) -> bool {
    let colours = style::colours(theme);
    float(context, placement, theme, LEGEND, Align2::LEFT_BOTTOM, |ui| {
        ui.set_max_width(LEGEND_TEXT);
        ui.spacing_mut().item_spacing.y = 4.0;
        for line in title.unwrap_or_default() {
            ui.label(RichText::new(style::unbroken(line)).size(11.0).color(colours.faint));
        }
        ui.label(RichText::new(&legend.title).strong());
        match &legend.scale {
            Scale::Categories(names) => {
                for (name, colour) in names {
                    ui.horizontal(|ui| {
                        let (dot, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                        ui.painter().rect_filled(dot, 3.0, style::color32(*colour));
                        ui.add(egui::Label::new(style::faint(ui, theme, name)).truncate());
                    });
                }
            }
            Scale::Ramp { low, high, unit } => {
                ui.label(style::faint(ui, theme, *unit));
                ramp::show(ui, theme, &legend.scale.colours(theme), &ramp::numbers(*low, *high));
            }
        }
        symbols.show(ui, theme);
    })
}
