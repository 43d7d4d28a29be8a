//! The plain data of a picture of the fleet: the scene (all choices about what is drawn and how),
//! the camera, colours, and the lists of routes, goals and heat to draw. Panels set it and a
//! renderer draws it; it knows neither of them.

pub mod background;
pub mod camera;
pub mod curves;
pub mod facilities;
pub mod heat;
pub mod names;
pub mod palette;
pub mod plans;
pub mod route;
pub mod stations;
pub mod zones;

use core::time::Duration;

use glam::{Vec2, Vec3};
use regatta_plugin::World;
use serde::{Deserialize, Serialize};

use heat::Heat;
use palette::{Colouring, Theme};

/// The maximum number of lights beside the sun.
pub const MAX_LIGHTS: usize = 8;
/// The maximum number of robots that can be selected.
pub const MAX_SELECTED: usize = 256;

/// All choices about a picture except the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The colours of everything except robots.
    pub theme: Theme,
    /// The data that robots are coloured by.
    pub colouring: Colouring,
    /// The layers that are drawn.
    pub layers: Layers,
    /// The heat map of the edges, if there is one.
    pub heat: Option<Heat>,
    /// Added to the positions of robots and graph, in metres; the floor stays where it is.
    pub offset: Vec2,
    /// The floor.
    pub floor: Floor,
    /// Lights beside the sun, at most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// The sizes at which the level of detail changes.
    pub detail: Detail,
    /// Trails behind the robots.
    pub trails: Trails,
    /// Ids of the selected robots, which are highlighted by a ring.
    pub selected: Vec<u32>,
    /// The level (floor) that alone is shown; `None` for all.
    pub level: Option<String>,
    /// The selected edge or node, which has an outline.
    pub marked: Option<Marked>,
}

/// Whether a node or an edge, whose text `level_of` names its level, is on a level; with `None` on
/// any.
pub fn is_on_level(world: &World<'_>, level_of: u32, level: Option<&str>) -> bool {
    level.is_none_or(|level| world.text(level_of) == level)
}

/// An item that can be picked and selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// A robot, by its id.
    Robot(u32),
    /// An edge, by its index in the world.
    Edge(u32),
    /// A node, by its index in the world.
    Node(u32),
}

/// An edge or a node of the route graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marked {
    /// An edge, by its index in the world.
    Edge(u32),
    /// A node, by its index in the world.
    Node(u32),
}

/// The layers of a picture that can be hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layers {
    /// Lines of the floor's grid.
    pub grid: bool,
    /// Edges.
    pub edges: bool,
    /// Arrows on the edges.
    pub arrows: bool,
    /// Nodes.
    pub nodes: bool,
    /// Ids of nodes and edges near the camera.
    pub ids: bool,
    /// Ids of robots near the camera.
    pub robot_ids: bool,
    /// Robots.
    pub robots: bool,
    /// Whether many robots that are small in the picture are drawn as their density.
    pub density: bool,
    /// Shadows under the robots.
    pub shadows: bool,
    /// Trails behind the robots, if there are any.
    pub trails: bool,
    /// Routes and goals of all robots; those of selected ones are always drawn.
    pub plans: bool,
    /// Arrows from robots that wait to those that they wait for.
    pub waits: bool,
}

/// The simulated time between two points of a trail.
pub const TRAIL_INTERVAL: Duration = Duration::from_millis(250);

/// Trails behind robots. They get a point at each [`TRAIL_INTERVAL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Trails {
    /// Points of each trail; 0 for no trails. There are fewer if the adapter lacks the memory.
    pub points: u32,
    /// Whether only the trails of selected robots are drawn.
    pub only_selected: bool,
}

/// The floor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Floor {
    /// The floor's rectangle in metres; without one it reaches to the horizon.
    pub bounds: Option<crate::camera::Bounds>,
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f32; 6]", into = "[f32; 6]")]
pub struct Light {
    /// Position in metres.
    pub position: Vec3,
    /// Linear red, green and blue; 1 is as bright as the sun at a distance of two metres.
    pub colour: Vec3,
}

/// A file has position and colour as one array.
impl From<[f32; 6]> for Light {
    fn from([x, y, z, red, green, blue]: [f32; 6]) -> Self {
        Self { position: Vec3::new(x, y, z), colour: Vec3::new(red, green, blue) }
    }
}

impl From<Light> for [f32; 6] {
    fn from(Light { position: at, colour }: Light) -> Self {
        [at.x, at.y, at.z, colour.x, colour.y, colour.z]
    }
}

/// The thresholds of the levels of detail: lengths of robots and edges in the picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// Robots from this length on are drawn as their mesh.
    pub mesh: f32,
    /// Robots from this length on are drawn as blocks, smaller ones as flat marks.
    pub block: f32,
    /// The least length of marks.
    pub mark: f32,
    /// Edges below this length are lines of one pixel.
    pub thin: f32,
}

impl Default for Layers {
    fn default() -> Self {
        Self {
            grid: true,
            edges: true,
            arrows: true,
            nodes: true,
            ids: true,
            robot_ids: false,
            robots: true,
            density: true,
            shadows: true,
            trails: true,
            plans: false,
            waits: false,
        }
    }
}

impl Default for Detail {
    fn default() -> Self {
        Self { mesh: 22.0, block: 7.0, mark: 3.0, thin: 8.0 }
    }
}

impl Detail {
    /// Returns thresholds that suit a software adapter.
    pub fn software() -> Self {
        Self { mesh: 44.0, block: 14.0, mark: 3.0, thin: 48.0 }
    }
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            theme: Theme::default(),
            colouring: Colouring::default(),
            layers: Layers::default(),
            heat: None,
            offset: Vec2::ZERO,
            floor: Floor::default(),
            lights: Vec::new(),
            detail: Detail::default(),
            trails: Trails::default(),
            selected: Vec::new(),
            level: None,
            marked: None,
        }
    }
}
