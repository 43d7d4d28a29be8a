//! Elements that float over the picture: the legend, the camera's position, messages, and the note
//! that no engine runs yet.

use egui::{Align2, Area, Id, LayerId, Order, Rect, RichText, Sense, Ui, UiBuilder, vec2};
use glam::Vec2;
use regatta_scene::camera::Window as PictureWindow;
use regatta_scene::palette::{Legend, Scale, Theme};

use super::context::PanelContext;
use super::heat::HeatLegend;
use super::hottest;
use super::labels::{LabelView, Labels};
use super::levels::PictureArea;
use super::placement::{MARGIN, Placement};
use super::plan::PlanScale;
use super::ramp;
use super::robot_spots::{self, Spot};
use super::state::Interface;
use super::style;
use super::symbols::Symbols;
use super::transport::clock_text;
use super::view_cube;
use super::view_model::{EngineState, ViewModel};

/// The name of the legend among the elements over a picture.
pub const LEGEND: &str = "legend";
/// The greatest width that a legend takes, in points, with its margins.
pub const LEGEND_ROOM: f32 = 210.0;
/// The least width beside a legend in points. In a narrower picture there is none.
const LEAST_BESIDE_LEGEND: f32 = 240.0;
/// The step of the width of a legend in points, so that nothing moves with each of its figures.
const LEGEND_STEP: f32 = 30.0;
/// The greatest width of a legend's contents, in points.
const LEGEND_TEXT: f32 = 168.0;
/// The least width of a picture that has room to spare for a legend, in points.
const WITH_LEGEND: f32 = 500.0;
/// The greatest width of messages, in points.
const WIDEST_MESSAGE: f32 = 620.0;
/// Seconds for which a message is shown.
const MESSAGE_SECONDS: f64 = 8.0;
/// The largest number of messages shown at a time.
const MAX_MESSAGES: usize = 4;

/// A message over the picture.
#[derive(Clone, Debug)]
struct Message {
    text: String,
    /// The time at which it disappears, in seconds of the egui context; set when it is first shown.
    until: Option<f64>,
}

/// The messages over the picture.
#[derive(Debug, Default)]
pub(super) struct Messages(Vec<Message>);

impl Messages {
    /// Shows a message for some seconds. A message with the same text is replaced.
    pub fn add(&mut self, text: String) {
        self.0.retain(|message| message.text != text);
        self.0.push(Message { text, until: None });
        let surplus = self.0.len().saturating_sub(MAX_MESSAGES);
        self.0.drain(..surplus);
    }

    fn show(&mut self, context: &PanelContext<'_>, ctx: &egui::Context, placement: &mut Placement) {
        let now = ctx.input(|input| input.time);
        for message in &mut self.0 {
            message.until.get_or_insert(now + MESSAGE_SECONDS);
        }
        self.0.retain(|message| message.until.is_none_or(|until| until > now));
        let Some(next) = self.0.iter().filter_map(|message| message.until).reduce(f64::min) else {
            return;
        };
        ctx.request_repaint_after_secs((next - now) as f32);
        float(ctx, placement, context.theme, "messages", Align2::CENTER_TOP, |ui| {
            ui.set_max_width(ui.available_width().min(WIDEST_MESSAGE));
            for message in &self.0 {
                ui.label(RichText::new(&message.text).color(context.colours.text));
            }
        });
    }
}

impl Interface {
    /// Shows the elements over the picture, the most important first. If there is no room for all,
    /// the last ones are left out.
    pub(super) fn overlay(
        &mut self,
        context: &PanelContext<'_>,
        ctx: &egui::Context,
        area: PictureArea,
    ) {
        let mut placement = Placement::new(area.whole);
        if context.model.engine == EngineState::Awaited {
            waiting(context, ctx, &mut placement);
            self.messages.show(context, ctx, &mut placement);
        } else {
            self.levels.draw_parts(context, ctx, &mut placement);
            if context.model.engine == EngineState::Gone {
                veil(context, ctx, area.whole, &mut placement);
            }
            self.messages.show(context, ctx, &mut placement);
            let spots = self.robot_spots(context, area);
            self.robot_ids(context, ctx, area, &spots);
            if let Some(measuring) = &self.measuring {
                measuring.draw(context, ctx, area);
            }
            self.spots.draw_mark(context, ctx, area);
            self.elements(context, ctx, area, &mut placement);
            if self.settings.ids {
                self.ids(context, ctx, area, (&spots, &placement));
            }
            if self.settings.heat {
                let taken: Vec<Rect> = placement.taken().iter().map(|(_, place)| *place).collect();
                hottest::draw(context, ctx, area, &taken);
            }
        }
        self.last.placement = placement;
    }

    /// Shows the elements that are always there, as far as there is room.
    fn elements(
        &mut self,
        context: &PanelContext<'_>,
        ctx: &egui::Context,
        area: PictureArea,
        placement: &mut Placement,
    ) {
        let PictureArea { picture, visible, .. } = area;
        let (camera, theme) = (&context.camera, context.theme);
        if let Some(measuring) = &self.measuring {
            lines(context, ctx, placement, "measurement", &measuring.text(context));
        }
        let symbols = self.symbols(context.model);
        self.last.legend = legend_width(ctx, placement, theme, context.model.legend, &symbols);
        if self.legend_room(area.whole.width()) > 0.0 {
            legend(ctx, placement, theme, context.model.legend, &symbols, None);
        }
        let scale = camera.is_plan().then(|| PlanScale::place(placement, picture, visible, camera));
        view_cube::show(context, ctx, placement);
        if self.settings.minimap {
            self.minimap.show(context, ctx, area, placement);
        }
        coordinates(context, ctx, area, placement);
        if let Some(scale) = scale {
            scale.draw(ctx, placement, picture, visible, camera, theme);
        }
    }

    /// The width in points that a picture leaves to its legend, with its margins; 0 if the picture
    /// is too narrow for one.
    pub(super) fn legend_room(&self, width: f32) -> f32 {
        let legend = self.last.legend;
        if width - legend >= LEAST_BESIDE_LEGEND { legend } else { 0.0 }
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

    /// Finds the robots in the picture, if ids are shown.
    fn robot_spots(&self, context: &PanelContext<'_>, area: PictureArea) -> Vec<Spot> {
        let frame = context.model.frame.filter(|_| self.settings.ids || self.settings.robot_ids);
        let (world, camera, offset) = (&context.model.world, &context.camera, context.offset);
        frame.map_or_else(Vec::new, |frame| {
            robot_spots::find(&frame, world, context.level(), camera, offset, area.size())
        })
    }

    /// Draws the names and ids of nodes and edges beside the robots and the elements.
    fn ids(
        &self,
        context: &PanelContext<'_>,
        ctx: &egui::Context,
        area: PictureArea,
        (robots, placement): (&[Spot], &Placement),
    ) {
        let (picture, camera) = (area.picture, &context.camera);
        let (offset, theme) = (context.offset, context.theme);
        let view = LabelView { picture, camera, offset, theme, robots, placement };
        context.model.labels.draw(ctx, area.visible, &view);
    }

    /// Draws the ids of robots.
    fn robot_ids(
        &self,
        context: &PanelContext<'_>,
        ctx: &egui::Context,
        area: PictureArea,
        spots: &[Spot],
    ) {
        let PictureArea { picture, visible, .. } = area;
        let (model, camera, offset) = (context.model, &context.camera, context.offset);
        let theme = context.theme;
        if self.settings.robot_ids {
            robot_spots::draw(ctx, visible, picture, theme, spots);
        }
        if self.settings.ids {
            let selected = context.selection.robots().into_iter();
            let places = selected
                .filter(|id| is_on_level(model, context.level(), *id))
                .filter_map(|id| Some((id, model.pose(id, offset)?.place)));
            Labels::draw_robots(ctx, picture, visible, camera, theme, places);
        }
    }
}

/// Whether a robot is on an edge of a level; any robot is without a level.
fn is_on_level(model: &ViewModel<'_>, level: Option<&str>, robot: u32) -> bool {
    let Some(level) = level else { return true };
    let edge = model.frame.and_then(|frame| frame.edge().get(robot as usize).copied());
    let edge = edge.and_then(|edge| model.world.edges().get(edge as usize));
    edge.is_some_and(|edge| model.world.text(edge.level) == level)
}

/// Shows the ground under the pointer, and where the camera is.
fn coordinates(
    context: &PanelContext<'_>,
    ctx: &egui::Context,
    area: PictureArea,
    placement: &mut Placement,
) {
    let (camera, eye) = (&context.camera, context.camera.eye());
    let pointer = ctx.pointer_hover_pos().filter(|at| area.visible.contains(*at));
    let ground = pointer.and_then(|at| area.ground(camera, at));
    let mut figures = vec![match ground {
        Some(at) => format!("x {:.2} m  y {:.2} m", at.x, at.y),
        None => "x –  y –".to_owned(),
    }];
    if !camera.is_plan() && area.whole.width() > 520.0 {
        let [yaw, pitch] = [camera.yaw, camera.pitch].map(f32::to_degrees);
        figures.push(format!(
            "camera  {:.1}  {:.1}  {:.1} m   {yaw:.0}°  {pitch:.0}°",
            eye.x, eye.y, eye.z
        ));
    }
    lines(context, ctx, placement, "coordinates", &figures);
}

/// Shows lines of figures in the lower right corner.
fn lines(
    context: &PanelContext<'_>,
    ctx: &egui::Context,
    placement: &mut Placement,
    name: &'static str,
    lines: &[String],
) {
    float(ctx, placement, context.theme, name, Align2::RIGHT_BOTTOM, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for line in lines {
            let text = RichText::new(line).monospace().size(11.0).color(context.colours.faint);
            ui.add(egui::Label::new(text).extend());
        }
    });
}

/// Greys the picture of a fleet that has ended, and shows a message. No panel covers the part
/// `visible`.
fn veil(context: &PanelContext<'_>, ctx: &egui::Context, visible: Rect, placement: &mut Placement) {
    let (model, theme, colours) = (context.model, context.theme, context.colours);
    let painter = ctx.layer_painter(LayerId::background());
    painter.with_clip_rect(visible).rect_filled(
        visible,
        0.0,
        egui::Color32::from_gray(128).gamma_multiply(0.55),
    );
    let what =
        if model.recording().is_some() { "The replay has ended" } else { "The engine has ended" };
    let last = model.frame.map_or("nothing".to_owned(), |frame| {
        let time = clock_text(frame.sim_time().as_secs_f64());
        format!("this is its last picture, at {time}")
    });
    let text = format!("{last}; the next engine is shown as soon as it runs");
    float(ctx, placement, theme, "ended", Align2::CENTER_TOP, |ui| {
        ui.set_max_width(ui.available_width().min(WIDEST_MESSAGE));
        ui.label(RichText::new(what).strong().color(colours.bad));
        ui.label(style::faint(ui, &text));
    });
}

fn waiting(context: &PanelContext<'_>, ctx: &egui::Context, placement: &mut Placement) {
    let (model, theme, colours) = (context.model, context.theme, context.colours);
    float(ctx, placement, theme, "waiting", Align2::CENTER_CENTER, |ui| {
        ui.set_max_width(360.0);
        ui.vertical_centered(|ui| {
            ui.add_space(10.0);
            ui.spinner();
            ui.add_space(6.0);
            ui.label(RichText::new(format!("Waiting for fleet '{}'", model.fleet)).size(18.0));
            ui.label(style::faint(ui, "It appears as soon as an engine runs. Start one with:"));
            let name = if model.fleet == "default" {
                String::new()
            } else {
                format!(" --fleet {}", model.fleet)
            };
            ui.label(RichText::new(format!("regatta run{name}")).monospace().color(colours.accent));
            ui.add_space(10.0);
        });
    });
}

/// Shows an element in a corner, at an edge or in the centre of the picture, or beside other
/// elements. Returns whether there is room for it. `show` is called twice: first to measure the
/// element, and then to place it.
pub(super) fn float(
    ctx: &egui::Context,
    placement: &mut Placement,
    theme: Theme,
    name: &'static str,
    at: Align2,
    mut show: impl FnMut(&mut Ui),
) -> bool {
    let frame = style::floating(theme);
    if !placement.room().is_positive() {
        return false;
    }
    let size = measure(ctx, placement.room(), theme, name, &mut show);
    let Some(place) = placement.take(name, size, at) else { return false };
    let area =
        Area::new(Id::unique(name)).order(Order::Background).interactable(false).fade_in(false);
    area.fixed_pos(place.min).show(ctx, |ui| {
        // An area keeps its last width, and would break longer lines.
        let within = UiBuilder::new()
            .max_rect(Rect::from_min_size(ui.min_rect().min, place.size() + vec2(1.0, 1.0)));
        ui.scope_builder(within, |ui| frame.show(ui, show));
    });
    true
}

/// Returns the size of an element that would have this room.
fn measure(
    ctx: &egui::Context,
    room: Rect,
    theme: Theme,
    name: &'static str,
    show: impl FnOnce(&mut Ui),
) -> egui::Vec2 {
    let unseen = UiBuilder::new().layer_id(LayerId::background()).max_rect(room).invisible();
    let mut ui = Ui::new(ctx.clone(), Id::unique(("size", name)), unseen);
    style::floating(theme).show(&mut ui, show).response.rect.size()
}

/// Returns the width of a legend with its margins, whether there is room for it or not.
fn legend_width(
    ctx: &egui::Context,
    placement: &Placement,
    theme: Theme,
    legend: &Legend,
    symbols: &Symbols,
) -> f32 {
    let room = placement.room();
    let room = room.with_max_x(room.left() + LEGEND_ROOM);
    let width = measure(ctx, room, theme, "legend's width", |ui| {
        legend_contents(ui, theme, legend, symbols, &[]);
    });
    let with_margins = width.x + 2.0 * MARGIN;
    ((with_margins / LEGEND_STEP).ceil() * LEGEND_STEP).min(LEGEND_ROOM)
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
    ctx: &egui::Context,
    placement: &mut Placement,
    theme: Theme,
    legend: &Legend,
    symbols: &Symbols,
    title: Option<&[String]>,
) -> bool {
    let title = title.unwrap_or_default();
    float(ctx, placement, theme, LEGEND, Align2::LEFT_BOTTOM, |ui| {
        legend_contents(ui, theme, legend, symbols, title);
    })
}

fn legend_contents(
    ui: &mut Ui,
    theme: Theme,
    legend: &Legend,
    symbols: &Symbols,
    title: &[String],
) {
    let colours = style::colours(theme);
    ui.set_max_width(LEGEND_TEXT);
    ui.spacing_mut().item_spacing.y = 4.0;
    for line in title {
        ui.label(RichText::new(style::unbroken(line)).size(11.0).color(colours.faint));
    }
    ui.label(RichText::new(&legend.title).strong());
    match &legend.scale {
        Scale::Categories(names) => {
            for (name, colour) in names {
                ui.horizontal(|ui| {
                    let (dot, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                    ui.painter().rect_filled(dot, 3.0, style::color32(*colour));
                    ui.add(egui::Label::new(style::faint(ui, name)).truncate());
                });
            }
        }
        Scale::Ramp { low, high, unit } => {
            ui.label(style::faint(ui, *unit));
            ramp::show(ui, theme, &legend.scale.colours(theme), &ramp::numbers(*low, *high));
        }
    }
    symbols.show(ui, theme);
}
