//! What a person has chosen, kept in a small file from one start to the next.

use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;
use glam::Vec2;
use serde::{Deserialize, Serialize};

use crate::camera::Bounds;
use crate::options::LookOptions;
use crate::palette::{Colouring, Theme};
use crate::scene::Scene;

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
    /// Shadows.
    pub shadows: bool,
    /// Metres added to all positions, east and north.
    pub offset: [f32; 2],
    /// Width and height of the floor in metres; without them it reaches to the horizon.
    pub floor: Option<[f32; 2]>,
    /// Points of the trail behind each robot.
    pub trails: u32,
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
            shadows: true,
            offset: [0.0; 2],
            floor: None,
            trails: 0,
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
        if self.colour.parse::<Colouring>().is_err() {
            self.colour = usual.colour;
        }
        self
    }

    /// With what the command line says otherwise.
    #[must_use]
    pub fn with(mut self, look: &LookOptions) -> Self {
        if look.theme != Theme::default() {
            self.light = look.theme == Theme::Light;
        }
        if look.colour != Colouring::default() {
            self.colour = look.colour.to_string();
        }
        if look.offset.0 != Vec2::ZERO {
            self.offset = look.offset.0.to_array();
        }
        if let Some(size) = look.floor {
            self.floor = Some(size.0.abs().to_array());
        }
        if look.trails > 0 {
            self.trails = look.trails;
        }
        self.grid &= !look.no_grid;
        (self.edges, self.nodes) = (self.edges && !look.no_graph, self.nodes && !look.no_graph);
        self.sane()
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
        scene.floor.bounds =
            self.floor.map(|size| Bounds { low: Vec2::from(size) / -2.0, high: Vec2::from(size) / 2.0 });
        scene.layers.grid = self.grid;
        (scene.layers.edges, scene.layers.arrows, scene.layers.nodes) = (self.edges, self.edges, self.nodes);
        scene.layers.shadows = self.shadows;
        scene.trails.points = self.trails;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
