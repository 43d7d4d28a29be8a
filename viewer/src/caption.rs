//! Text over pictures that are rendered without a window: the legend, and the ids of nodes, edges
//! and robots.

use egui::{Context, FullOutput, RawInput, Rect, pos2, vec2};
use glam::{UVec2, Vec2};
use regatta_gpu::device::Gpu;
use regatta_gpu::painter::{Drawing, Painter};
use regatta_interface::banner::Banner;
use regatta_interface::heat::HeatLegend;
use regatta_interface::hottest::Hottest;
use regatta_interface::labels::{LabelView, Labels};
use regatta_interface::legend::{LEGEND, LegendView};
use regatta_interface::levels::PictureArea;
use regatta_interface::placement::Placement;
use regatta_interface::plan::PlanScale;
use regatta_interface::symbols::Symbols;
use regatta_interface::{robot_spots, style};
use regatta_plugin::{Frame, World};
use regatta_scene::Scene;
use regatta_scene::camera::Camera;
use regatta_scene::heat::{HeatFacts, HotEdge};
use regatta_scene::palette::Legend;
use regatta_scene::plans::PlanFacts;
use wgpu::{CommandEncoder, TextureView};

use crate::picture::OVERLAY_FORMAT;

/// The height in pixels up to which pictures have text of the default size; text grows with larger
/// pictures.
const DEFAULT_HEIGHT: f32 = 1080.0;

/// Draws text over pictures.
pub struct Caption {
    context: Context,
    painter: Painter,
    is_styled: bool,
    /// The ids of nodes and edges.
    pub labels: Labels,
}

/// The contents of a picture's caption.
pub struct Annotations<'a> {
    /// The picture's camera.
    pub camera: &'a Camera,
    /// The picture's scene.
    pub scene: &'a Scene,
    /// The legend, if it is shown.
    pub legend: Option<&'a Legend>,
    /// Whether a plan has its coordinates, its scale and the direction to the north.
    pub plan: bool,
    /// The counts of plans.
    pub plans: PlanFacts,
    /// The fleet, the time and the number of robots, a line each; shown with the legend.
    pub title: Vec<String>,
    /// The robots that are near enough for ids; empty if no ids are shown.
    pub frame: Option<Frame<'a>>,
    /// The world; empty if it isn't known.
    pub world: World<'a>,
    /// The scale of the heat map.
    pub heat: Option<HeatFacts>,
    /// The hottest places of the heat map, which are labelled as far as names and ids are shown.
    pub hottest: &'a [HotEdge],
    /// Number of closed edges.
    pub closed: u32,
    /// The density of half the strength in robots per hectare, if robots are drawn as their
    /// density.
    pub density: Option<f32>,
    /// Robots whose ids are shown, with their positions in metres.
    pub robots: Vec<(u32, Vec2)>,
    /// The title, the clock and the scale.
    pub banner: Banner,
}

/// Pixels per point of text in a picture.
pub fn pixels_per_point(size: UVec2) -> f32 {
    (size.y as f32 / DEFAULT_HEIGHT).max(1.0)
}

impl Caption {
    /// Creates a caption for pictures in the [`OVERLAY_FORMAT`].
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            context: Context::default(),
            painter: Painter::new(gpu, OVERLAY_FORMAT),
            is_styled: false,
            labels: Labels::default(),
        }
    }

    /// Draws the annotations over the picture in `target`. Returns the names of the annotations for
    /// which the picture has no room.
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        target: (&TextureView, UVec2),
        annotations: &Annotations<'_>,
    ) -> Vec<&'static str> {
        let (view, size) = target;
        let pixels_per_point = pixels_per_point(size);
        if !self.is_styled {
            self.is_styled = true;
            style::apply(&self.context, annotations.scene.theme);
            // egui measures a new area in a first pass and places it in a second one.
            for _ in 0..2 {
                let (output, _) = self.lay_out(size, pixels_per_point, annotations);
                self.painter.upload(gpu, &output.textures_delta);
                self.painter.free(output.textures_delta);
            }
        }
        let (mut output, left_out) = self.lay_out(size, pixels_per_point, annotations);
        let changes = std::mem::take(&mut output.textures_delta);
        self.painter.upload(gpu, &changes);
        let triangles = self.context.tessellate(output.shapes, pixels_per_point);
        self.painter.draw(gpu, encoder, view, &Drawing { triangles, pixels_per_point, size });
        self.painter.free(changes);
        left_out
    }

    /// Returns the annotations to draw, and the names of those that are left out.
    fn lay_out(
        &self,
        size: UVec2,
        scale: f32,
        annotations: &Annotations<'_>,
    ) -> (FullOutput, Vec<&'static str>) {
        let Annotations { camera, scene, world, .. } = annotations;
        let picture =
            Rect::from_min_size(pos2(0.0, 0.0), vec2(size.x as f32, size.y as f32) / scale);
        let mut input = RawInput { screen_rect: Some(picture), ..RawInput::default() };
        input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point =
            Some(scale);
        let mut left_out = Vec::new();
        let output = self.context.run_ui(input, |ui| {
            let mut placement = Placement::new(picture);
            let (layers, theme, size) =
                (scene.layers, scene.theme, Vec2::new(picture.width(), picture.height()));
            let near = annotations.frame.filter(|_| layers.ids || layers.robot_ids);
            let level = scene.level.as_deref();
            let spots = near.map_or_else(Vec::new, |frame| {
                robot_spots::find(&frame, world, level, camera, scene.offset, size)
            });
            left_out = annotations.banner.show(ui.ctx(), picture, &mut placement, camera, theme);
            if let Some(legend) = annotations.legend {
                let facts = annotations.heat;
                let heat = scene.heat.map(|heat| HeatLegend { heat, facts });
                let closed = if layers.edges { annotations.closed } else { 0 };
                let density = annotations.density;
                let symbols = Symbols::new(layers, annotations.plans);
                let symbols = Symbols { heat, density, closed, ..symbols };
                let legend = LegendView { theme, legend, symbols, title: &annotations.title };
                let is_shown = legend.show(ui.ctx(), &mut placement);
                left_out.extend((!is_shown).then_some(LEGEND));
            }
            if annotations.plan && camera.is_plan() {
                let scale = PlanScale::place(&mut placement, picture, picture, camera);
                scale.draw(ui.ctx(), &placement, picture, picture, camera, theme);
            }
            if layers.robot_ids {
                robot_spots::draw(ui.ctx(), picture, picture, theme, &spots, &placement);
            }
            let robots = annotations.robots.iter().copied();
            Labels::draw_robots(ui.ctx(), picture, picture, camera, theme, robots);
            if let Some(facts) = annotations.heat.filter(|_| layers.ids) {
                let hottest = Hottest {
                    places: annotations.hottest,
                    figure: facts.heat.figure,
                    world,
                    level,
                    offset: scene.offset,
                    camera,
                    theme,
                };
                let area = PictureArea { picture, visible: picture, whole: picture };
                hottest.draw(ui.ctx(), area, &mut placement);
            }
            if layers.ids {
                let (robots, placement) = (&spots[..], &placement);
                let offset = scene.offset;
                let view = LabelView { picture, camera, offset, theme, robots, placement };
                self.labels.draw(ui.ctx(), picture, &view);
            }
        });
        (output, left_out)
    }
}
