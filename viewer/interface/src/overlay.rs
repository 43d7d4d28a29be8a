//! Elements that float over the picture: the camera's position, messages, and the note that no
//! engine runs yet; and the order in which they and the others take their places.

use std::time::Duration;

use egui::{Align2, Area, Id, LayerId, Order, Rect, RichText, Ui, UiBuilder, vec2};
use regatta_scene::palette::Theme;

use super::context::PanelContext;
use super::heat::HeatLegend;
use super::hottest::Hottest;
use super::labels::{LabelView, Labels};
use super::legend::{LegendRoom, LegendView, NARROW};
use super::levels::PictureArea;
use super::placement::Placement;
use super::plan::PlanScale;
use super::robot_spots::{self, Spot};
use super::state::Interface;
use super::style;
use super::symbols::Symbols;
use super::transport::clock_text;
use super::view_cube;
use super::view_model::{EngineState, ViewModel};

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

    /// Hides a message.
    pub fn remove(&mut self, text: &str) {
        self.0.retain(|message| message.text != text);
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
        } else if let EngineState::WarmingUp(driven) = context.model.engine {
            warming_up(context, ctx, &mut placement, driven);
            self.messages.show(context, ctx, &mut placement);
        } else {
            self.levels.draw_parts(context, ctx, &mut placement);
            if context.model.engine == EngineState::Gone {
                veil(context, ctx, area.whole, &mut placement);
            }
            self.messages.show(context, ctx, &mut placement);
            let spots = self.robot_spots(context, area);
            if let Some(measuring) = &self.measuring {
                measuring.draw(context, ctx, area);
            }
            self.spots.draw_mark(context, ctx, area);
            // The help lies over the middle, and would cover halves of them.
            if !self.help.is_open {
                self.elements(context, ctx, area, &mut placement);
                self.robot_ids(context, ctx, area, (&spots, &placement));
                if let Some(hottest) = self.hottest(context) {
                    hottest.draw(ctx, area, &mut placement);
                }
                if self.settings.ids {
                    self.ids(context, ctx, area, (&spots, &placement));
                }
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
        let legend = LegendView { theme, legend: context.model.legend, symbols, title: &[] };
        self.last.legend = legend.room(ctx, placement);
        if self.legend_room(area.whole.width()) != LegendRoom::default() {
            legend.show_in_window(ctx, placement);
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

    /// The hottest places of the heat map, if one is shown.
    fn hottest<'a>(&self, context: &'a PanelContext<'_>) -> Option<Hottest<'a>> {
        let facts = context.model.jams.heat.filter(|_| self.settings.heat)?;
        Some(Hottest {
            places: &context.model.jams.hottest,
            figure: facts.heat.figure,
            world: &context.model.world,
            level: context.level(),
            offset: context.offset,
            camera: &context.camera,
            theme: context.theme,
        })
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
        (spots, placement): (&[Spot], &Placement),
    ) {
        let PictureArea { picture, visible, .. } = area;
        let (model, camera, offset) = (context.model, &context.camera, context.offset);
        let theme = context.theme;
        if self.settings.robot_ids {
            robot_spots::draw(ctx, visible, picture, theme, spots, placement);
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
    if !camera.is_plan() && area.whole.width() >= NARROW {
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

fn warming_up(
    context: &PanelContext<'_>,
    ctx: &egui::Context,
    placement: &mut Placement,
    driven: Duration,
) {
    float(ctx, placement, context.theme, "warming up", Align2::CENTER_CENTER, |ui| {
        ui.set_max_width(360.0);
        ui.vertical_centered(|ui| {
            ui.add_space(10.0);
            ui.spinner();
            ui.add_space(6.0);
            let (minutes, secs) = (driven.as_secs() / 60, driven.as_secs() % 60);
            ui.label(RichText::new(format!("Warming up: {minutes}:{secs:02}")).size(18.0));
            let text = "So much simulated time is driven so far, as fast as possible. The run \
                        begins at the end.";
            ui.label(style::faint(ui, text));
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
pub(super) fn measure(
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
