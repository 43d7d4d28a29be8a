//! The command line of the viewer.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use clap::Args;
use glam::{UVec2, Vec2, Vec3};
use regatta_plugin::FleetName;

use crate::camera::{Bounds, Camera};
use crate::floor_picture::FloorPicture;
use crate::gpu::frame::Renderer;
use crate::model;
use crate::palette::{Colouring, Theme};
use crate::scene::{Light, MAX_LIGHTS, Scene, Trails};

/// What `regatta viewer` takes.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// The fleet to see
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Draw without a window
    #[arg(long)]
    pub headless: bool,
    /// Draw one picture into this file (PNG)
    #[arg(long, value_name = "FILE", requires = "headless")]
    pub screenshot: Option<PathBuf>,
    /// Simulated time of the picture: 12.5s, 3min … [default: the first that there is]
    #[arg(long, value_name = "TIME", requires = "headless")]
    pub at: Option<humantime::Duration>,
    /// Draw pictures into this folder (PNG), or into this file if it ends in .mp4 (needs the program ffmpeg)
    #[arg(long, value_name = "PATH", requires = "headless", conflicts_with = "screenshot")]
    pub record: Option<PathBuf>,
    /// Pictures a second to record
    #[arg(long, value_name = "N", default_value_t = 30, requires = "record",
        value_parser = clap::value_parser!(u32).range(1..=240))]
    pub fps: u32,
    /// Record for so long: 10s, 1min …
    #[arg(long = "for", value_name = "TIME", default_value = "10s", requires = "record")]
    pub for_: humantime::Duration,
    /// Width and height of the picture in pixels, or of the window [default: 1920x1080; a window's is the last one's]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// From where to look: fit, top, or the eye's x,y,z in metres and the look's yaw,pitch in radians (yaw
    /// counter-clockwise from east, pitch below the horizon)
    #[arg(long, value_name = "VIEW", default_value = "fit", allow_hyphen_values = true)]
    pub camera: View,
    /// Look at this robot, from behind
    #[arg(long, value_name = "ID", conflicts_with = "camera")]
    pub follow: Option<u32>,
    /// What is drawn and how
    #[command(flatten)]
    pub look: LookOptions,
    /// Measure the speed of drawing so many robots (0: the running fleet); several numbers, several tables
    #[arg(long, value_name = "N", num_args = 1.., conflicts_with_all = ["screenshot", "record"])]
    pub bench: Vec<u32>,
}

/// What is drawn and how.
#[derive(Args, Clone, Debug)]
pub struct LookOptions {
    /// Colour robots by state, speed, type or a column that a plugin publishes [default: collision]
    #[arg(long, value_name = "WHAT")]
    pub colour: Option<Colouring>,
    /// Dark or light [default: dark]
    #[arg(long, value_enum)]
    pub theme: Option<Theme>,
    /// Metres added to all positions of robots and graph [default: 0,0]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    pub offset: Option<Pair>,
    /// Width and height of the floor in metres, around the origin [default: up to the horizon]
    #[arg(long, value_name = "W,H")]
    pub floor: Option<Pair>,
    /// What lies on the floor: an image (PNG, JPEG, BMP), stretched over --floor or over the graph; or a ROS map
    /// (map.yaml), which says itself where it lies
    #[arg(long, value_name = "FILE")]
    pub floor_image: Option<PathBuf>,
    /// Draw robots as this mesh (STL, OBJ, glTF), scaled and lifted by z metres; those of one type or all
    #[arg(long, value_name = "[TYPE=]FILE[,SCALE[,Z]]")]
    pub mesh: Vec<ModelOption>,
    /// A lamp at x,y,z in metres, with red,green,blue (0 to 1 and above) if it isn't white; up to eight
    #[arg(long, value_name = "X,Y,Z[,R,G,B]", allow_hyphen_values = true)]
    pub light: Vec<LightOption>,
    /// Points of the trail behind each robot [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=4096))]
    pub trails: Option<u32>,
    /// Draw only the trails of the robots in --select
    #[arg(long)]
    pub trails_of_selected: bool,
    /// Samples of a pixel: 1 or 4 [default: 4; 1 for a window that the processor draws by itself]
    #[arg(long, value_name = "N", value_parser = samples)]
    pub samples: Option<u32>,
    /// Leave the graph out
    #[arg(long)]
    pub no_graph: bool,
    /// Leave the ids of nodes and edges out
    #[arg(long)]
    pub no_ids: bool,
    /// Leave the legend out of pictures
    #[arg(long, requires = "headless")]
    pub no_legend: bool,
    /// Leave the shadows out
    #[arg(long)]
    pub no_shadows: bool,
    /// Leave the grid out
    #[arg(long)]
    pub no_grid: bool,
    /// Ids of robots to mark
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    pub select: Vec<u32>,
}

/// What a text should have been.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is not {wanted}")]
pub struct OptionError {
    text: String,
    wanted: &'static str,
}

/// Width and height, as 1920x1080.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub UVec2);

/// Two numbers, as 1.5,-2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair(pub Vec2);

/// A lamp, as x,y,z or x,y,z,r,g,b.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightOption(pub Light);

/// A mesh for robots, as `tug=tug.stl,0.001,0.1`.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelOption {
    /// Of which type; of all if none.
    pub robot_type: Option<String>,
    /// The file.
    pub path: PathBuf,
    /// Metres per unit of the file.
    pub scale: f32,
    /// How far it is lifted, in metres.
    pub z: f32,
}

/// From where to look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// All of the graph, from an angle.
    Fit,
    /// All of the graph, straight down.
    Top,
    /// From a point, with yaw and pitch.
    Eye(Camera),
}

fn numbers(text: &str, wanted: &'static str) -> Result<Vec<f32>, OptionError> {
    let number = |part: &str| part.trim().parse::<f32>().ok().filter(|number| number.is_finite() && number.abs() < 1e6);
    text.split(',').map(number).collect::<Option<_>>().ok_or(OptionError { text: text.to_owned(), wanted })
}

fn samples(text: &str) -> Result<u32, OptionError> {
    let wanted = "1 or 4";
    text.parse().ok().filter(|count| [1, 4].contains(count)).ok_or(OptionError { text: text.to_owned(), wanted })
}

impl FromStr for Size {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let side = |text: &str| text.parse::<u32>().ok().filter(|side| (1..=32_768).contains(side));
        text.split_once('x')
            .and_then(|(width, height)| Some(Self(UVec2::new(side(width)?, side(height)?))))
            .ok_or(OptionError { text: text.to_owned(), wanted: "a size such as 1920x1080" })
    }
}

impl FromStr for Pair {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let wanted = "two numbers such as 1.5,-2";
        match numbers(text, wanted)?[..] {
            [x, y] => Ok(Self(Vec2::new(x, y))),
            _ => Err(OptionError { text: text.to_owned(), wanted }),
        }
    }
}

impl FromStr for LightOption {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let wanted = "a lamp such as 0,0,5 or 0,0,5,1,0.8,0.6";
        let (position, colour) = match numbers(text, wanted)?[..] {
            [x, y, z] => (Vec3::new(x, y, z), Vec3::ONE),
            [x, y, z, red, green, blue] => (Vec3::new(x, y, z), Vec3::new(red, green, blue).max(Vec3::ZERO)),
            _ => return Err(OptionError { text: text.to_owned(), wanted }),
        };
        Ok(Self(Light { position, colour }))
    }
}

impl FromStr for ModelOption {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let wanted = "a mesh such as box.stl, box.stl,0.001 or tug=box.stl,0.001,0.1";
        let (robot_type, rest) = text.split_once('=').map_or((None, text), |(kind, rest)| (Some(kind), rest));
        let mut parts = rest.split(',');
        let path = parts.next().filter(|path| !path.is_empty());
        let mut number = |default: f32, (low, high): (f32, f32)| {
            let number = parts.next().map_or(Ok(default), |part| part.trim().parse());
            number.ok().filter(|number| (low..=high).contains(number))
        };
        let (scale, z) = (number(1.0, (1e-6, 1e6)), number(0.0, (-100.0, 100.0)));
        match (path, scale, z, parts.next()) {
            (Some(path), Some(scale), Some(z), None) => {
                Ok(Self { robot_type: robot_type.map(str::to_owned), path: path.into(), scale, z })
            }
            _ => Err(OptionError { text: text.to_owned(), wanted }),
        }
    }
}

impl FromStr for View {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let wanted = "fit, top or x,y,z,yaw,pitch";
        match text {
            "fit" => Ok(Self::Fit),
            "top" => Ok(Self::Top),
            eye => match numbers(eye, wanted)?[..] {
                [x, y, z, yaw, pitch] => Ok(Self::Eye(Camera::at(Vec3::new(x, y, z), yaw, pitch))),
                _ => Err(OptionError { text: text.to_owned(), wanted }),
            },
        }
    }
}

impl View {
    /// The camera, for a fleet that is to be seen within `bounds`.
    pub fn camera(self, bounds: Bounds, size: UVec2) -> Camera {
        let aspect = size.x as f32 / size.y as f32;
        match self {
            Self::Fit => Camera::fit(bounds, aspect),
            Self::Top => Camera::top(bounds, aspect),
            Self::Eye(camera) => camera,
        }
    }
}

impl LookOptions {
    /// Gives a renderer the files that are named. One that can't be read is told, and what is built in stands in its
    /// place.
    pub fn furnish(&self, renderer: &mut Renderer) {
        for option in &self.mesh {
            match model::load(&option.path, option.scale, option.z) {
                Ok(mesh) if renderer.set_model(option.robot_type.as_deref(), Some(&mesh)) => {}
                Ok(_) => tracing::warn!("{}: too many meshes; it isn't used", option.path.display()),
                Err(error) => tracing::warn!("{error}; the built-in robot stands in its place"),
            }
        }
    }

    /// Lays the picture that is named on the floor; over `bounds` if nothing else says where.
    pub fn lay_floor(&self, renderer: &mut Renderer, bounds: Bounds) {
        let Some(path) = &self.floor_image else { return };
        let bounds = self.scene().floor.bounds.unwrap_or(bounds);
        match FloorPicture::load(path, bounds, renderer.max_texture_size()) {
            Ok(picture) => renderer.lay_picture(Some(&picture)),
            Err(error) => tracing::warn!("{error}; the floor stays plain"),
        }
    }

    /// The scene that they describe.
    pub fn scene(&self) -> Scene {
        let mut scene = Scene { theme: self.theme.unwrap_or_default(), ..Scene::default() };
        scene.colouring = self.colour.clone().unwrap_or_default();
        scene.offset = self.offset.map_or(Vec2::ZERO, |Pair(metres)| metres);
        scene.floor.bounds = self.floor.map(|Pair(size)| Bounds { low: -size.abs() / 2.0, high: size.abs() / 2.0 });
        scene.lights = self.light.iter().take(MAX_LIGHTS).map(|light| light.0).collect();
        scene.layers.grid = !self.no_grid;
        scene.layers.shadows = !self.no_shadows;
        if self.no_graph {
            (scene.layers.edges, scene.layers.arrows, scene.layers.nodes) = (false, false, false);
        }
        scene.layers.ids = !self.no_ids && !self.no_graph;
        scene.trails = Trails { points: self.trails.unwrap_or_default(), only_selected: self.trails_of_selected };
        scene.selected.clone_from(&self.select);
        scene
    }
}

impl Options {
    /// Width and height of a picture.
    pub fn picture_size(&self) -> UVec2 {
        self.size.map_or(UVec2::new(1920, 1080), |Size(size)| size)
    }

    /// How long to record.
    pub fn record_for(&self) -> Duration {
        self.for_.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_sound() {
        Options::augment_args(clap::Command::new("viewer")).debug_assert();
    }

    #[test]
    fn texts_are_parsed_or_refused() {
        assert_eq!("640x480".parse(), Ok(Size(UVec2::new(640, 480))));
        assert_eq!("1.5,-2".parse(), Ok(Pair(Vec2::new(1.5, -2.0))));
        assert_eq!("top".parse(), Ok(View::Top));
        assert!("0,0,5,1.57,0.5".parse::<View>().is_ok());
        for bad in ["", "640", "0x5", "640x480x2", "640x-1", "99999x1"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        for bad in ["", "side", "1,2,3", "1,2,3,4,nan", "1,2,3,4,5,6"] {
            assert!(bad.parse::<View>().is_err(), "{bad}");
        }
        assert!("0,0".parse::<LightOption>().is_err());
        let model: ModelOption = "tug=a/b.stl,0.001,0.1".parse().unwrap();
        assert_eq!((model.robot_type.as_deref(), model.scale, model.z), (Some("tug"), 0.001, 0.1));
        for bad in ["", "tug=", "a.stl,0", "a.stl,x", "a.stl,1,2,3"] {
            assert!(bad.parse::<ModelOption>().is_err(), "{bad}");
        }
    }
}
