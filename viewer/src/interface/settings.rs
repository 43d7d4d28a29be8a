//! What a person has chosen, kept in a small file from one start to the next.

use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::camera::Bounds;
use crate::options::LookOptions;
use crate::palette::{Colouring, Theme};
use crate::scene::{Light, MAX_LIGHTS, Scene, Trails};

/// All that is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// The light theme.
    pub light: bool,
    /// A [`Colouring`], as text.
    pub colour: String,
    /// Lines of the floor's grid.
    pub grid: bool,
    /// Edges and their arrows.
    pub edges: bool,
    /// Nodes.
    pub nodes: bool,
    /// Ids of nodes and edges, when near.
    pub ids: bool,
    /// Shadows.
    pub shadows: bool,
    /// Metres added to all positions, east and north.
    pub offset: [f32; 2],
    /// Width and height of the floor in metres; without them it reaches to the horizon.
    pub floor: Option<[f32; 2]>,
    /// Points of the trail behind each robot.
    pub trails: u32,
    /// Only selected robots have one.
    pub trails_of_selected: bool,
    /// An image or a ROS map on the floor; empty for none.
    pub floor_image: String,
    /// What robots look like, if not as they are built in.
    pub mesh: Option<RobotMesh>,
    /// Lamps: x, y and z in metres; red, green and blue.
    pub lamps: Vec<[f32; 6]>,
    /// What the panel on the left shows, if it is open.
    pub left: Option<Left>,
    /// What the panel on the right shows, if it is open.
    pub right: Option<Right>,
    /// How large the interface is, 1 for what the screen says.
    pub scale: f32,
    /// Size of the window, in points.
    pub window: [f32; 2],
    /// Where UDP goes to and comes from.
    pub udp: Udp,
}

/// What the panel on the left can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Left {
    /// All robots.
    Fleet,
    /// Robots that touch, or may.
    Collisions,
}

/// What the panel on the right can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Right {
    /// What was picked.
    Selection,
    /// How things are drawn.
    View,
    /// How fast, and what takes the time.
    Performance,
    /// The engine, and UDP.
    Connection,
}

/// A mesh for all robots whose type has none of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotMesh {
    /// STL, OBJ or glTF.
    pub file: String,
    /// Metres per unit of the file.
    pub scale: f32,
    /// How far it is lifted, in metres.
    pub z: f32,
}

/// Hosts and ports, as typed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Udp {
    /// Where the source receives.
    pub listen: String,
    /// Whether it answers.
    pub echo: bool,
    /// Where it answers to.
    pub echo_to: String,
    /// Where the sender sends to.
    pub send_to: String,
}

impl Default for Udp {
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
            colour: Colouring::default().to_string(),
            grid: true,
            edges: true,
            nodes: true,
            ids: true,
            shadows: true,
            offset: [0.0; 2],
            floor: None,
            trails: 0,
            trails_of_selected: false,
            floor_image: String::new(),
            mesh: None,
            lamps: Vec::new(),
            left: None,
            right: None,
            scale: 1.0,
            window: [1280.0, 720.0],
            udp: Udp::default(),
        }
    }
}

/// Why settings were not read or written.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// It isn't what this program writes.
    #[error("{} is no settings file ({reason}); the usual settings are taken", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The system refuses.
    #[error("settings can't be kept in {}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
}

/// The settings' file in the user's folder for such files; `None` for a user without a home.
pub fn path() -> Option<PathBuf> {
    Some(etcetera::choose_base_strategy().ok()?.config_dir().join("regatta").join("viewer.json"))
}

impl Settings {
    /// Reads a file. One that isn't there is no error.
    ///
    /// # Errors
    /// [`SettingsError`].
    pub fn load(path: &Path) -> Result<Self, SettingsError> {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Self::default()),
            Err(error) => return Err(SettingsError::File { path: path.into(), reason: error.to_string() }),
        };
        let settings = serde_json::from_str::<Self>(&text);
        settings.map(Self::sane).map_err(|error| SettingsError::Broken { path: path.into(), reason: error.to_string() })
    }

    /// Writes a file, whole or not at all.
    ///
    /// # Errors
    /// [`SettingsError::File`].
    pub fn save(&self, path: &Path) -> Result<(), SettingsError> {
        let failed = |error: std::io::Error| SettingsError::File { path: path.into(), reason: error.to_string() };
        let text = serde_json::to_string_pretty(self).map_err(|error| failed(error.into()))?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(failed)?;
        }
        let draft = path.with_extension(format!("{}.tmp", std::process::id()));
        std::fs::write(&draft, text + "\n").map_err(failed)?;
        std::fs::rename(&draft, path).map_err(failed)
    }

    /// With numbers that can be drawn.
    #[must_use]
    pub fn sane(mut self) -> Self {
        let usual = Self::default();
        let within = |value: f32, low: f32, high: f32, usual: f32| {
            if value.is_finite() { value.clamp(low, high) } else { usual }
        };
        self.offset = self.offset.map(|metres| within(metres, -1e6, 1e6, 0.0));
        self.floor = self.floor.map(|size| size.map(|metres| within(metres, 1.0, 1e6, 100.0)));
        self.scale = within(self.scale, 0.5, 3.0, usual.scale);
        self.window = [
            within(self.window[0], 320.0, 16e3, usual.window[0]),
            within(self.window[1], 240.0, 16e3, usual.window[1]),
        ];
        self.trails = self.trails.min(4096);
        if let Some(mesh) = &mut self.mesh {
            (mesh.scale, mesh.z) = (within(mesh.scale, 1e-6, 1e6, 1.0), within(mesh.z, -100.0, 100.0, 0.0));
        }
        self.lamps.truncate(MAX_LIGHTS);
        for lamp in &mut self.lamps {
            let [x, y, z, colour @ ..] = *lamp;
            let [x, y, z] = [x, y, z].map(|metres| within(metres, -1e6, 1e6, 0.0));
            let [red, green, blue] = colour.map(|part| within(part, 0.0, 1e3, 1.0));
            *lamp = [x, y, z, red, green, blue];
        }
        if self.colour.parse::<Colouring>().is_err() {
            self.colour = usual.colour;
        }
        self
    }

    /// With what the command line says otherwise.
    #[must_use]
    pub fn with(mut self, look: &LookOptions) -> Self {
        if let Some(theme) = look.theme {
            self.light = theme == Theme::Light;
        }
        if let Some(colour) = &look.colour {
            self.colour = colour.to_string();
        }
        if let Some(offset) = look.offset {
            self.offset = offset.0.to_array();
        }
        if let Some(size) = look.floor {
            self.floor = Some(size.0.abs().to_array());
        }
        if let Some(points) = look.trails {
            self.trails = points;
        }
        self.trails_of_selected |= look.trails_of_selected;
        if let Some(path) = &look.floor_image {
            self.floor_image = path.display().to_string();
        }
        if let Some(model) = look.mesh.iter().rfind(|model| model.robot_type.is_none()) {
            self.mesh = Some(RobotMesh { file: model.path.display().to_string(), scale: model.scale, z: model.z });
        }
        if !look.light.is_empty() {
            let lamp = |light: &Light| {
                let ([x, y, z], [red, green, blue]) = (light.position.to_array(), light.colour.to_array());
                [x, y, z, red, green, blue]
            };
            self.lamps = look.light.iter().map(|light| lamp(&light.0)).collect();
        }
        self.grid &= !look.no_grid;
        self.shadows &= !look.no_shadows;
        (self.edges, self.nodes) = (self.edges && !look.no_graph, self.nodes && !look.no_graph);
        self.ids &= !look.no_graph && !look.no_ids;
        self.sane()
    }

    /// What is to be kept of these settings: what the command line said for this once gives way to what was stored,
    /// where a person has left it as it was `told`.
    #[must_use]
    pub fn kept(&self, told: &Self, stored: &Self) -> Self {
        fn keep<T: PartialEq + Clone>(now: &mut T, told: &T, stored: &T) {
            if now == told {
                now.clone_from(stored);
            }
        }
        let mut kept = self.clone();
        keep(&mut kept.light, &told.light, &stored.light);
        keep(&mut kept.colour, &told.colour, &stored.colour);
        keep(&mut kept.grid, &told.grid, &stored.grid);
        keep(&mut kept.shadows, &told.shadows, &stored.shadows);
        keep(&mut kept.edges, &told.edges, &stored.edges);
        keep(&mut kept.nodes, &told.nodes, &stored.nodes);
        keep(&mut kept.ids, &told.ids, &stored.ids);
        keep(&mut kept.offset, &told.offset, &stored.offset);
        keep(&mut kept.floor, &told.floor, &stored.floor);
        keep(&mut kept.trails, &told.trails, &stored.trails);
        keep(&mut kept.trails_of_selected, &told.trails_of_selected, &stored.trails_of_selected);
        keep(&mut kept.floor_image, &told.floor_image, &stored.floor_image);
        keep(&mut kept.mesh, &told.mesh, &stored.mesh);
        keep(&mut kept.lamps, &told.lamps, &stored.lamps);
        keep(&mut kept.window, &told.window, &stored.window);
        kept
    }

    /// The theme.
    pub fn theme(&self) -> Theme {
        if self.light { Theme::Light } else { Theme::Dark }
    }

    /// What the robots' colours tell.
    pub fn colouring(&self) -> Colouring {
        self.colour.parse().unwrap_or_default()
    }

    /// Makes a scene show what is chosen here.
    pub fn apply(&self, scene: &mut Scene) {
        scene.theme = self.theme();
        scene.colouring = self.colouring();
        scene.offset = self.offset.into();
        scene.floor.bounds = self.floor.map(Bounds::of_size);
        scene.layers.grid = self.grid;
        (scene.layers.edges, scene.layers.arrows, scene.layers.nodes) = (self.edges, self.edges, self.nodes);
        (scene.layers.ids, scene.layers.shadows) = (self.ids, self.shadows);
        scene.trails = Trails { points: self.trails, only_selected: self.trails_of_selected };
        scene.lights.clear();
        scene.lights.extend(self.lamps.iter().take(MAX_LIGHTS).map(|[x, y, z, red, green, blue]| Light {
            position: Vec3::new(*x, *y, *z),
            colour: Vec3::new(*red, *green, *blue),
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;

    fn file(test: &str) -> PathBuf {
        std::env::temp_dir().join(format!("regatta-settings-{test}-{}", std::process::id())).join("viewer.json")
    }

    #[test]
    fn what_is_saved_is_loaded() {
        let path = file("saved");
        let settings = Settings {
            light: true,
            colour: "speed".into(),
            offset: [1.5, -2.0],
            floor: Some([40.0, 30.0]),
            left: Some(Left::Fleet),
            right: Some(Right::View),
            ..Settings::default()
        };
        settings.save(&path).unwrap();
        assert_eq!(Settings::load(&path).unwrap(), settings);
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn what_the_command_line_says_holds_and_is_not_kept() {
        use clap::{Args, FromArgMatches};
        let look = |args: &[&str]| {
            let command = Options::augment_args(clap::Command::new("viewer").no_binary_name(true));
            Options::from_arg_matches(&command.try_get_matches_from(args).unwrap()).unwrap().look
        };
        let stored = Settings { light: true, colour: "speed".into(), trails: 9, ..Settings::default() };
        let told =
            stored.clone().with(&look(&["--theme", "dark", "--colour", "collision", "--trails", "0", "--no-grid"]));
        assert_eq!((told.light, told.colour.as_str(), told.trails, told.grid), (false, "collision", 0, false));
        assert_eq!(told.kept(&told, &stored), stored);
        let changed = Settings { colour: "state".into(), shadows: false, ..told.clone() };
        let wanted = Settings { colour: "state".into(), shadows: false, ..stored.clone() };
        assert_eq!(changed.kept(&told, &stored), wanted);
        let lit = Settings::default().with(&look(&["--light", "1,2,3", "--mesh", "a.stl,0.5", "--mesh", "tug=b.stl"]));
        assert_eq!(lit.lamps, [[1.0, 2.0, 3.0, 1.0, 1.0, 1.0]]);
        assert_eq!(lit.mesh.map(|mesh| (mesh.file, mesh.scale)), Some(("a.stl".into(), 0.5)));
    }

    #[test]
    fn a_missing_file_is_no_error_and_a_broken_one_says_where() {
        let path = file("broken");
        assert_eq!(Settings::load(&path).unwrap(), Settings::default());
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        for text in ["", "{", "[1]", "{\"light\": 3}", "\u{0}\u{1}"] {
            std::fs::write(&path, text).unwrap();
            let message = Settings::load(&path).unwrap_err().to_string();
            assert!(message.contains("viewer.json"), "{message}");
        }
        std::fs::write(&path, "{\"trails\": 4000000, \"scale\": 90, \"colour\": \"no/name\", \"later\": 1}").unwrap();
        let settings = Settings::load(&path).unwrap();
        assert_eq!((settings.trails, settings.scale, settings.colour.as_str()), (4096, 3.0, "collision"));
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }
}
