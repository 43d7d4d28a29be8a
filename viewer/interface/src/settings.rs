//! The user's choices, stored in a small file from one start to the next.

use glam::Vec2;
use regatta_scene::camera::Bounds;
use regatta_scene::heat::Heat;
use regatta_scene::palette::{Colouring, Theme};
use regatta_scene::{Light, MAX_LIGHTS, Scene, Trails};
use serde::{Deserialize, Serialize};

/// The name of the colouring that follows what the fleet publishes.
pub const AUTOMATIC: &str = "automatic";

/// The settings of the viewer. The names of the fields are the keys of the settings file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Whether the theme is light.
    pub light: bool,
    /// The [`Colouring`] of the robots, as text, or [`AUTOMATIC`].
    pub colour: String,
    /// Whether the floor's grid is shown.
    pub grid: bool,
    /// Whether edges and their arrows are shown.
    pub edges: bool,
    /// Whether nodes are shown.
    pub nodes: bool,
    /// Whether the ids of nodes and edges are shown when near.
    pub ids: bool,
    /// Whether the ids of robots are shown when near.
    pub robot_ids: bool,
    /// Whether the minimap is shown.
    pub minimap: bool,
    /// Whether shadows are shown.
    pub shadows: bool,
    /// Whether the routes and goals of all robots are shown.
    pub plans: bool,
    /// Whether arrows show who waits for whom.
    pub waits: bool,
    /// Whether many robots that are small in the picture are drawn as their density.
    pub density: bool,
    /// Whether the heat map of the edges is shown.
    pub heat: bool,
    /// The figure and the window of the heat map.
    pub heat_of: Heat,
    /// Metres added to all positions, east and north.
    pub offset: Vec2,
    /// Width and height of the floor in metres; `None` for a floor up to the horizon.
    pub floor: Option<Vec2>,
    /// The number of points of the trail behind each robot.
    pub trails: u32,
    /// Whether only selected robots have trails.
    pub trails_of_selected: bool,
    /// The path of an image or a ROS map for the floor; empty for none.
    pub floor_image: String,
    /// The placement of an image on the floor. `None` stretches an image over the floor, and places
    /// a map at the origin in its file.
    pub floor_at: Option<FloorPlacement>,
    /// The mesh of the robots; `None` for the built-in one.
    pub mesh: Option<RobotMesh>,
    /// The lamps.
    pub lamps: Vec<Light>,
    /// Whether the figures over time are shown.
    pub plots: bool,
    /// The open panel on the left.
    pub left: Option<LeftPanel>,
    /// The open panel on the right.
    pub right: Option<RightPanel>,
    /// The scale of the interface, 1 for the default of the screen.
    pub scale: f32,
    /// Width and height of the window, in points.
    pub window: Vec2,
    /// The addresses for UDP.
    pub udp: UdpSettings,
}

/// A panel on the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LeftPanel {
    /// All robots.
    Fleet,
    /// Pairs of robots that touch or may touch.
    Collisions,
    /// Places where robots lose time.
    Spots,
    /// Alarms and past events.
    Log,
}

/// A panel on the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RightPanel {
    /// The selected item.
    Selection,
    /// The look of the picture.
    View,
    /// Rates and durations.
    Performance,
    /// The engine and UDP.
    Connection,
}

/// The mesh of all robots whose type has no mesh of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotMesh {
    /// The path of an STL, OBJ or glTF file.
    pub file: String,
    /// Metres per unit of the file.
    pub scale: f32,
    /// The height by which the mesh is lifted, in metres.
    pub z: f32,
    /// The angle by which it is turned about the vertical axis, in degrees counter-clockwise.
    #[serde(default)]
    pub yaw: f32,
}

impl RobotMesh {
    /// Returns the mesh of a file.
    pub fn new(file: String, MeshPlacement { scale, z, yaw }: MeshPlacement) -> Self {
        Self { file, scale, z, yaw: yaw.to_degrees() }
    }

    /// Returns the placement of the mesh on its robot.
    pub fn placement(&self) -> MeshPlacement {
        MeshPlacement { scale: self.scale, z: self.z, yaw: self.yaw.to_radians() }
    }
}

/// The placement of a mesh on its robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshPlacement {
    /// Metres per unit of the file.
    pub scale: f32,
    /// The height by which it is lifted, in metres.
    pub z: f32,
    /// The angle by which it is turned about the vertical axis, in radians counter-clockwise.
    pub yaw: f32,
}

/// The placement of a picture on the floor: x and y of its lower left corner in metres, metres per
/// pixel, and the yaw in degrees. The settings file has these numbers as an array.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f32; 4]", into = "[f32; 4]")]
pub struct FloorPlacement {
    /// Metres east.
    pub x: f32,
    /// Metres north.
    pub y: f32,
    /// The width of a pixel in metres.
    pub metres_per_pixel: f32,
    /// Counter-clockwise, about the lower left corner.
    pub yaw_degrees: f32,
}

impl From<[f32; 4]> for FloorPlacement {
    fn from([x, y, metres_per_pixel, yaw_degrees]: [f32; 4]) -> Self {
        Self { x, y, metres_per_pixel, yaw_degrees }
    }
}

impl From<FloorPlacement> for [f32; 4] {
    fn from(at: FloorPlacement) -> Self {
        [at.x, at.y, at.metres_per_pixel, at.yaw_degrees]
    }
}

/// The hosts and ports for UDP, as typed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct UdpSettings {
    /// The address at which the UDP source receives.
    pub listen: String,
    /// Whether the UDP source answers.
    pub echo: bool,
    /// The address to which the UDP source answers.
    pub echo_to: String,
    /// The address to which the UDP sender sends.
    pub send_to: String,
}

impl Default for UdpSettings {
    fn default() -> Self {
        Self {
            listen: "127.0.0.1:9870".into(),
            echo: false,
            echo_to: "127.0.0.1:9871".into(),
            send_to: "127.0.0.1:9870".into(),
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            light: false,
            colour: AUTOMATIC.to_owned(),
            grid: true,
            edges: true,
            nodes: true,
            ids: true,
            robot_ids: false,
            minimap: false,
            shadows: true,
            plans: false,
            waits: false,
            density: true,
            heat: false,
            heat_of: Heat::default(),
            offset: Vec2::ZERO,
            floor: None,
            trails: 0,
            trails_of_selected: false,
            floor_image: String::new(),
            floor_at: None,
            mesh: None,
            lamps: Vec::new(),
            plots: false,
            left: None,
            right: None,
            scale: 1.0,
            window: Vec2::new(1280.0, 720.0),
            udp: UdpSettings::default(),
        }
    }
}

/// Returns a value limited to a range; `fallback` for one that isn't finite.
fn within(value: f32, low: f32, high: f32, fallback: f32) -> f32 {
    if value.is_finite() { value.clamp(low, high) } else { fallback }
}

impl Settings {
    /// Returns the settings with all values limited to valid ranges.
    #[must_use]
    pub fn sanitized(mut self) -> Self {
        let default = Self::default();
        self.offset = self.offset.map(|metres| within(metres, -1e6, 1e6, 0.0));
        self.floor = self.floor.map(|size| size.map(|metres| within(metres, 1.0, 1e6, 100.0)));
        if let Some(at) = &mut self.floor_at {
            (at.x, at.y) = (within(at.x, -1e6, 1e6, 0.0), within(at.y, -1e6, 1e6, 0.0));
            at.metres_per_pixel = within(at.metres_per_pixel, 1e-4, 100.0, 0.05);
            at.yaw_degrees = within(at.yaw_degrees, -360.0, 360.0, 0.0);
        }
        self.scale = within(self.scale, 0.5, 3.0, default.scale);
        self.window.x = within(self.window.x, 320.0, 16e3, default.window.x);
        self.window.y = within(self.window.y, 240.0, 16e3, default.window.y);
        self.trails = self.trails.min(4096);
        if let Some(mesh) = &mut self.mesh {
            (mesh.scale, mesh.z) =
                (within(mesh.scale, 1e-6, 1e6, 1.0), within(mesh.z, -100.0, 100.0, 0.0));
            mesh.yaw = within(mesh.yaw, -360.0, 360.0, 0.0);
        }
        self.lamps.truncate(MAX_LIGHTS);
        for lamp in &mut self.lamps {
            lamp.position = lamp.position.map(|metres| within(metres, -1e6, 1e6, 0.0));
            lamp.colour = lamp.colour.map(|part| within(part, 0.0, 1e3, 1.0));
        }
        if self.colour.parse::<Colouring>().is_err() {
            self.colour = default.colour;
        }
        self
    }

    /// Returns the theme.
    pub fn theme(&self) -> Theme {
        if self.light { Theme::Light } else { Theme::Dark }
    }

    /// Returns the colouring of the robots; `None` if it follows what the fleet publishes.
    pub fn colouring(&self) -> Option<Colouring> {
        if self.colour == AUTOMATIC { None } else { self.colour.parse().ok() }
    }

    /// Applies the settings to a scene.
    pub fn apply(&self, scene: &mut Scene) {
        scene.theme = self.theme();
        scene.offset = self.offset;
        scene.floor.bounds = self.floor.map(Bounds::of_size);
        scene.layers.grid = self.grid;
        (scene.layers.edges, scene.layers.arrows, scene.layers.nodes) =
            (self.edges, self.edges, self.nodes);
        (scene.layers.ids, scene.layers.shadows) = (self.ids, self.shadows);
        scene.layers.robot_ids = self.robot_ids;
        (scene.layers.plans, scene.layers.waits) = (self.plans, self.waits);
        scene.layers.density = self.density;
        scene.heat = self.heat.then_some(self.heat_of);
        scene.trails = Trails { points: self.trails, only_selected: self.trails_of_selected };
        scene.lights.clear();
        scene.lights.extend(self.lamps.iter().take(MAX_LIGHTS));
    }

    /// Returns the settings to store. Values that the user has not changed since the start, where
    /// they were `initial`, are replaced by those in the file, `stored`, so that options of the
    /// command line are not stored.
    #[must_use]
    pub fn to_store(&self, initial: &Self, stored: &Self) -> Self {
        let mut result = self.clone();
        macro_rules! restore {
            ($($field:ident)+) => {$(
                if result.$field == initial.$field {
                    result.$field.clone_from(&stored.$field);
                }
            )+};
        }
        restore!(light colour grid shadows edges nodes ids robot_ids plans waits density heat);
        restore!(heat_of offset floor trails trails_of_selected floor_image floor_at);
        restore!(mesh lamps window);
        result
    }
}
