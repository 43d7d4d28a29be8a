//! What is drawn and how: everything that a person can choose about a picture, but the camera.

use glam::{Vec2, Vec3};

use crate::palette::{Colouring, Theme};

/// Most lights beside the sun.
pub const MAX_LIGHTS: usize = 8;
/// Most robots that can be selected.
pub const MAX_SELECTED: usize = 256;

/// All choices about a picture but the camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Dark or light.
    pub theme: Theme,
    /// What the robots' colours tell.
    pub colouring: Colouring,
    /// Which layers are drawn.
    pub layers: Layers,
    /// Added to the positions of robots and graph, in metres; the floor stays where it is.
    pub offset: Vec2,
    /// The floor.
    pub floor: Floor,
    /// Lights beside the sun, at most [`MAX_LIGHTS`].
    pub lights: Vec<Light>,
    /// From which size on robots are drawn how.
    pub detail: Detail,
    /// Trails behind the robots.
    pub trails: Trails,
    /// Ids of robots that are marked by a ring.
    pub selected: Vec<u32>,
}

/// What there is to draw.
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
    /// Ids of nodes and edges, when near.
    pub ids: bool,
    /// Robots.
    pub robots: bool,
    /// Shadows under the robots.
    pub shadows: bool,
    /// Trails behind the robots, if there are any.
    pub trails: bool,
}

/// Trails behind robots. A point is taken every quarter of a simulated second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Trails {
    /// Points of each; 0 for none. Fewer if the adapter hasn't room for as many.
    pub points: u32,
    /// Only those of the selected robots are drawn.
    pub only_selected: bool,
}

/// The floor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Floor {
    /// Its rectangle in metres; without one it reaches to the horizon.
    pub bounds: Option<crate::camera::Bounds>,
}

/// A lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it hangs, in metres.
    pub position: Vec3,
    /// Red, green and blue, linear, 1 for a lamp that is as bright as the sun two metres below it.
    pub colour: Vec3,
}

/// Sizes in pixels, of a robot's or an edge's length in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// From this on, robots have their mesh.
    pub mesh: f32,
    /// From this on, they are boxes; below it, flat marks.
    pub block: f32,
    /// Marks are drawn no smaller than this.
    pub mark: f32,
    /// Below it, edges are lines a pixel wide.
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
            robots: true,
            shadows: true,
            trails: true,
        }
    }
}

impl Default for Detail {
    fn default() -> Self {
        Self { mesh: 22.0, block: 7.0, mark: 3.0, thin: 8.0 }
    }
}

impl Detail {
    /// What a processor that draws by itself keeps up with.
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
            offset: Vec2::ZERO,
            floor: Floor::default(),
            lights: Vec::new(),
            detail: Detail::default(),
            trails: Trails::default(),
            selected: Vec::new(),
        }
    }
}
