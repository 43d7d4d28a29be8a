//! The command-line options of the viewer.

mod values;

use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgGroup, Args};
use glam::{UVec2, Vec2};
use regatta_gpu::renderer::Renderer;
pub use regatta_interface::cameras::{Bookmark, CameraOption};
use regatta_interface::settings::FloorPlacement;
use regatta_plugin::{Error, FleetName, Result};
use regatta_scene::camera::Bounds;
use regatta_scene::heat::Heat;
use regatta_scene::palette::{Colouring, Theme};
use regatta_scene::{Light, MAX_LIGHTS, Scene, TRAIL_INTERVAL, Trails};

use crate::{floor_picture, mesh_file};
pub use values::MeshOption;

/// The groups of options in the help.
const PICTURES: &str = "Pictures and films";
const CAMERA: &str = "Camera";
const ROBOTS: &str = "Robots";
const PLANT: &str = "Plant and floor";
const CAPTIONS: &str = "Captions of pictures";
const STYLE: &str = "Style";
const MEASUREMENT: &str = "Measurement";

/// Options of `regatta viewer`.
#[derive(Args, Clone, Debug)]
#[command(group = ArgGroup::new("offscreen").args(["headless", "film"]).multiple(true))]
#[command(group = ArgGroup::new("moving").args(["record", "film"]).multiple(true))]
#[command(group = ArgGroup::new("unattended").multiple(true))]
pub struct Options {
    /// Recording to show (MCAP), with a timeline, instead of a fleet that runs
    #[arg(value_name = "FILE", conflicts_with = "fleet")]
    pub recording: Option<PathBuf>,
    /// Name of the fleet to show
    #[arg(long, value_name = "NAME", default_value_t)]
    pub fleet: FleetName,
    /// Render without a window
    #[arg(long, group = "unattended", help_heading = PICTURES)]
    pub headless: bool,
    /// Write a plan with its scale to this SVG file, without a window
    #[arg(long, value_name = "FILE", group = "unattended",
        conflicts_with_all = ["screenshot", "record", "heat", "plans", "waits"])]
    #[arg(help_heading = PICTURES)]
    pub svg: Option<PathBuf>,
    /// Scale of the plan: 200 for 1:200 [default: one at which it fits on A3]
    #[arg(long, value_name = "N", requires = "svg", value_parser = values::scale)]
    #[arg(help_heading = PICTURES)]
    pub svg_scale: Option<f32>,
    /// Write one picture to this PNG file
    #[arg(long, value_name = "FILE", requires = "headless", help_heading = PICTURES)]
    pub screenshot: Option<PathBuf>,
    /// Show all levels (floors) side by side, in the window or the screenshot, each with its name
    #[arg(long, conflicts_with_all = ["level", "follow", "record", "film", "svg", "bench"])]
    #[arg(help_heading = PLANT)]
    pub levels: bool,
    /// Simulated time of the picture, for example 12.5s or 3min [default: that of the first frame]
    #[arg(long, value_name = "TIME", help_heading = PICTURES)]
    pub at: Option<humantime::Duration>,
    /// Longest wait for the fleet, for example 10s or 1h
    #[arg(long, value_name = "TIME", default_value = "1min", requires = "unattended")]
    #[arg(help_heading = PICTURES)]
    pub timeout: humantime::Duration,
    /// Record PNG files into this folder, or a video into this file if it ends in .mp4 (requires
    /// the program ffmpeg)
    #[arg(long, value_name = "PATH", requires = "headless", conflicts_with = "screenshot")]
    #[arg(help_heading = PICTURES)]
    pub record: Option<PathBuf>,
    /// Film the recording in simulated time, one picture per step: an MP4 file
    /// (requires the program ffmpeg), or a folder for PNG files
    #[arg(long, value_name = "PATH", group = "unattended", requires = "recording",
        conflicts_with_all = ["screenshot", "record", "at", "svg"])]
    #[arg(help_heading = PICTURES)]
    pub film: Option<PathBuf>,
    /// Start of the film, for example 12.5s or 3min [default: that of the recording]
    #[arg(long, value_name = "TIME", requires = "film", help_heading = PICTURES)]
    pub from: Option<humantime::Duration>,
    /// End of the film [default: that of the recording]
    #[arg(long, value_name = "TIME", requires = "film", help_heading = PICTURES)]
    pub to: Option<humantime::Duration>,
    /// Simulated seconds per second of the film, from 0.001 to 1000
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, requires = "film")]
    #[arg(value_parser = values::film_speed, help_heading = PICTURES)]
    pub speed: f32,
    /// Replace files that exist
    #[arg(long, requires = "unattended", help_heading = PICTURES)]
    pub force: bool,
    /// Pictures per second of a recording or a film
    #[arg(long, value_name = "N", default_value_t = 30, requires = "moving",
        value_parser = clap::value_parser!(u32).range(1..=240))]
    #[arg(help_heading = PICTURES)]
    pub fps: u32,
    /// Duration of the recording, for example 10s or 1min
    #[arg(long = "for", value_name = "TIME", default_value = "10s", requires = "record",
        value_parser = values::duration_above_zero)]
    #[arg(help_heading = PICTURES)]
    pub for_: humantime::Duration,
    /// Width and height of the picture or of the window in pixels [default: 1920x1080; a window
    /// opens with its last size]
    #[arg(long, value_name = "WxH", value_parser = values::size, help_heading = PICTURES)]
    pub size: Option<UVec2>,
    /// Camera: fit, top, plan (orthographic), the name of a --bookmark, x,y,z,yaw,pitch: the
    /// position in metres and the view direction in radians (yaw counter-clockwise from east, pitch
    /// below the horizon); or x,y,height: a plan around x,y, with the height of the ground in
    /// metres
    #[arg(long, value_name = "VIEW", default_value = "fit", allow_hyphen_values = true)]
    #[arg(help_heading = CAMERA)]
    pub camera: CameraOption,
    /// Named camera, for --camera and the View panel; VIEW as above
    #[arg(long, value_name = "NAME=VIEW", help_heading = CAMERA)]
    pub bookmark: Vec<Bookmark>,
    /// Follow this robot from behind
    #[arg(long, value_name = "ID", conflicts_with = "camera", help_heading = CAMERA)]
    pub follow: Option<u32>,
    /// The content and the style of pictures
    #[command(flatten)]
    pub look: LookOptions,
    /// Measure the rendering speed with this number of robots (0: the running fleet, or with a FILE
    /// the time of jumps in it); several numbers measure one after the other
    #[arg(long, value_name = "N", num_args = 1.., conflicts_with_all = ["screenshot", "record"])]
    #[arg(help_heading = MEASUREMENT)]
    pub bench: Vec<u32>,
}

/// Options of what is drawn, and how.
#[derive(Args, Clone, Debug)]
pub struct LookOptions {
    /// Colour robots by state, speed, type or a column that a plugin publishes [default: activity
    /// or collision if it is published, else state]
    #[arg(long, value_name = "SOURCE", help_heading = ROBOTS)]
    pub colour: Option<Colouring>,
    /// Colour theme [default: dark]
    #[arg(long, value_parser = values::theme(), help_heading = STYLE)]
    pub theme: Option<Theme>,
    /// Offset of robots and graph in metres; the floor stays in place [default: 0,0]
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, value_parser = values::pair)]
    #[arg(help_heading = PLANT)]
    pub offset: Option<Vec2>,
    /// Width and height of the floor around the origin, in metres [default: up to the horizon]
    #[arg(long, value_name = "W,H", value_parser = values::pair, help_heading = PLANT)]
    pub floor: Option<Vec2>,
    /// Picture on the floor: an image (PNG, JPEG, BMP), stretched over --floor or else over the
    /// graph; or a ROS map (map.yaml), placed at its own origin
    #[arg(long, value_name = "FILE", help_heading = PLANT)]
    pub floor_image: Option<PathBuf>,
    /// Place of the floor picture, also of a map: x and y of its lower left corner in metres,
    /// metres per pixel, yaw in degrees
    #[arg(
        long,
        value_name = "X,Y,RESOLUTION[,YAW]",
        requires = "floor_image",
        allow_hyphen_values = true,
        value_parser = values::floor_at
    )]
    #[arg(help_heading = PLANT)]
    pub floor_at: Option<FloorPlacement>,
    /// Draw robots of one type, or of all types, as this mesh (STL, OBJ, glTF), scaled, lifted by z
    /// metres and turned by degrees counter-clockwise
    #[arg(long, value_name = "[TYPE=]FILE[,SCALE[,Z[,YAW]]]", help_heading = ROBOTS)]
    pub mesh: Vec<MeshOption>,
    /// Add a light at x,y,z in metres with the colour r,g,b (0 to 1 or above; default white); up to
    /// eight lights
    #[arg(long, value_name = "X,Y,Z[,R,G,B]", allow_hyphen_values = true,
        value_parser = values::light)]
    #[arg(help_heading = STYLE)]
    pub light: Vec<Light>,
    /// Number of points of the trail behind each robot [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=4096))]
    #[arg(help_heading = ROBOTS)]
    pub trails: Option<u32>,
    /// Draw trails only for the robots in --select
    #[arg(long, help_heading = ROBOTS)]
    pub trails_of_selected: bool,
    /// Samples per pixel, 1 or 4 [default: 4; 1 for a window or --bench without a graphics card]
    #[arg(long, value_name = "N", value_parser = values::samples, help_heading = STYLE)]
    pub samples: Option<u32>,
    /// Show this level (floor) only
    #[arg(long, value_name = "NAME", help_heading = PLANT)]
    pub level: Option<String>,
    /// Hide the graph
    #[arg(long, help_heading = PLANT)]
    pub no_graph: bool,
    /// Hide the ids of nodes and edges
    #[arg(long, help_heading = PLANT)]
    pub no_ids: bool,
    /// Show the ids of robots near the camera
    #[arg(long, help_heading = ROBOTS)]
    pub robot_ids: bool,
    /// Hide the legend in pictures
    #[arg(long, requires = "offscreen", help_heading = CAPTIONS)]
    pub no_legend: bool,
    /// Write this title into pictures
    #[arg(long, value_name = "TEXT", requires = "offscreen", help_heading = CAPTIONS)]
    pub title: Option<String>,
    /// Write the simulated time into pictures
    #[arg(long, requires = "offscreen", help_heading = CAPTIONS)]
    pub clock: bool,
    /// Draw a scale into pictures; it holds at the middle of the picture
    #[arg(long, requires = "offscreen", help_heading = CAPTIONS)]
    pub scale: bool,
    /// Hide the shadows
    #[arg(long, help_heading = STYLE)]
    pub no_shadows: bool,
    /// Hide the grid
    #[arg(long, help_heading = STYLE)]
    pub no_grid: bool,
    /// Draw the routes and the goals of all robots: released parts solid, planned parts dashed
    #[arg(long, help_heading = ROBOTS)]
    pub plans: bool,
    /// Draw arrows from robots that wait to those that they wait for; rings of waiting are red
    #[arg(long, help_heading = ROBOTS)]
    pub waits: bool,
    /// Colour and widen edges by a figure of the plugin traffic: occupancy, throughput, speed,
    /// waiting, contacts or routes, in a window: minute, 10min or run [default window: 10min]
    #[arg(long, value_name = "FIGURE[:WINDOW]", help_heading = PLANT)]
    pub heat: Option<Heat>,
    /// Draw every robot as a mark instead of their density
    #[arg(long, help_heading = ROBOTS)]
    pub no_density: bool,
    /// Ids of robots to highlight, with their routes and goals
    #[arg(long, value_name = "ID", value_delimiter = ',', help_heading = ROBOTS)]
    pub select: Vec<u32>,
}

impl LookOptions {
    /// Loads the meshes into a renderer. If a file can't be read, it logs a warning, and the
    /// built-in mesh is used.
    pub fn load_meshes(&self, renderer: &mut Renderer) {
        for option in &self.mesh {
            match mesh_file::load(&option.path, option.placement) {
                Ok(mesh) if renderer.set_mesh(option.robot_type.as_deref(), Some(&mesh)) => {}
                Ok(_) => tracing::warn!(
                    "{}: too many meshes; this one is not used",
                    option.path.display()
                ),
                Err(error) => tracing::warn!("{error}; the built-in mesh is used instead"),
            }
        }
    }

    /// Loads the floor picture into a renderer. An image is stretched over the floor, or without
    /// --floor over `bounds`. If the file can't be read, it logs a warning, and the floor stays
    /// plain.
    pub fn load_floor_picture(&self, renderer: &mut Renderer, bounds: Bounds) {
        let Some(path) = &self.floor_image else { return };
        let bounds = self.scene().floor.bounds.unwrap_or(bounds);
        match floor_picture::load(path, bounds, renderer.max_texture_size(), self.floor_at) {
            Ok(picture) if renderer.set_floor_picture(Some(&picture)) => {}
            Ok(_) => tracing::warn!(
                "{}: no room in the graphics memory; the floor stays plain",
                path.display()
            ),
            Err(error) => tracing::warn!("{error}; the floor stays plain"),
        }
    }

    /// Returns the scene that the options describe.
    pub fn scene(&self) -> Scene {
        let mut scene = Scene { theme: self.theme.unwrap_or_default(), ..Scene::default() };
        scene.offset = self.offset.unwrap_or_default();
        scene.floor.bounds = self.floor.map(|size| Bounds::of_size(size.abs()));
        scene.lights = self.light.iter().take(MAX_LIGHTS).copied().collect();
        scene.layers.grid = !self.no_grid;
        scene.layers.shadows = !self.no_shadows;
        if self.no_graph {
            (scene.layers.edges, scene.layers.arrows, scene.layers.nodes) = (false, false, false);
        }
        scene.layers.ids = !self.no_ids && !self.no_graph;
        scene.layers.robot_ids = self.robot_ids;
        (scene.layers.plans, scene.layers.waits) = (self.plans, self.waits);
        scene.heat = self.heat;
        scene.layers.density = !self.no_density;
        scene.trails = Trails {
            points: self.trails.unwrap_or_default(),
            only_selected: self.trails_of_selected,
        };
        scene.selected.clone_from(&self.select);
        scene.level.clone_from(&self.level);
        scene
    }
}

impl Options {
    /// The name of the recording's file, or of the fleet.
    pub fn name(&self) -> String {
        let file = self.recording.as_ref().and_then(|path| path.file_name());
        file.map_or_else(|| self.fleet.to_string(), |name| name.to_string_lossy().into_owned())
    }

    /// Width and height of a picture in pixels.
    pub fn picture_size(&self) -> UVec2 {
        self.size.unwrap_or(UVec2::new(1920, 1080))
    }

    /// The time at which a recording is paused for a picture, a plan or a film, or
    /// [`Duration::MAX`] for its start; `None` if it plays. The period of a heat map, and the time of
    /// trails, precede the picture.
    pub fn starts_at(&self) -> Option<Duration> {
        let stands = self.film.is_some() || self.screenshot.is_some() || self.svg.is_some();
        let time = if self.film.is_some() { self.from } else { self.at };
        let time = stands.then(|| time.map_or(Duration::MAX, Into::into))?;
        let trails = TRAIL_INTERVAL * self.look.trails.unwrap_or_default();
        let heat = match self.look.heat {
            None => Duration::ZERO,
            Some(heat) => heat.period.length_secs().map_or(Duration::MAX, Duration::from_secs),
        };
        let before = if self.svg.is_some() { heat } else { heat.max(trails) };
        match time == Duration::MAX || before == Duration::MAX {
            true => Some(Duration::MAX),
            false => Some(time.saturating_sub(before)),
        }
    }

    /// Checks options that need others.
    ///
    /// # Errors
    /// If the time of a picture is given, and there is none.
    pub fn check(&self) -> Result {
        match self.at {
            Some(at) if self.has_window() => Err(Error::new(format!(
                "--at {at} is the time of a picture; give --headless with --screenshot, or --svg"
            ))),
            _ => Ok(()),
        }
    }

    /// Whether a window is opened.
    pub fn has_window(&self) -> bool {
        !(self.headless || self.film.is_some() || self.svg.is_some() || !self.bench.is_empty())
    }

    /// Whether the traffic on edges is of use: a window can show it at any time.
    pub fn shows_traffic(&self) -> bool {
        self.look.heat.is_some() || self.has_window()
    }

    /// Whether a recording is played frame by frame, so that the traffic on edges is counted for a
    /// heat map.
    pub fn counts_traffic(&self) -> bool {
        self.recording.is_some() && self.look.heat.is_some() && self.starts_at().is_some()
    }

    /// Whether a recording is played up to the picture: for a heat map, or for trails.
    pub fn plays_to_picture(&self) -> bool {
        let has_trails = self.look.trails.is_some_and(|points| points > 0);
        let leads_to_picture = self.screenshot.is_some() && self.at.is_some() && has_trails;
        self.counts_traffic() || (self.recording.is_some() && leads_to_picture)
    }

    /// The camera that the options request; a named one is looked up.
    ///
    /// # Errors
    /// If no bookmark has the name.
    pub fn requested_camera(&self) -> Result<CameraOption> {
        let CameraOption::Named(name) = &self.camera else { return Ok(self.camera.clone()) };
        let found = self.bookmark.iter().find(|bookmark| bookmark.name == *name);
        found.map(|bookmark| bookmark.view.clone()).ok_or_else(|| {
            let names: Vec<_> =
                self.bookmark.iter().map(|bookmark| bookmark.name.as_str()).collect();
            let known =
                if names.is_empty() { "no camera is named".to_owned() } else { names.join(", ") };
            Error::new(format!(
                "--camera {name}: unknown; give fit, top, plan, numbers, or one of: {known}"
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        Options::augment_args(clap::Command::new("viewer")).debug_assert();
    }

    #[test]
    fn a_recording_is_played_for_the_time_of_trails() {
        let options = |args: &[&str]| -> Options {
            let args = [&["viewer", "run.mcap", "--headless"][..], args].concat();
            let command = Options::augment_args(clap::Command::new("viewer"));
            let matches = command.try_get_matches_from(args).expect("options");
            clap::FromArgMatches::from_arg_matches(&matches).expect("options")
        };
        let secs = |args: &[&str]| options(args).starts_at().map(|time| time.as_secs_f64());
        let picture = ["--screenshot", "x.png", "--at", "123.5s"];
        let with = |more: &[&str]| secs(&[&picture[..], more].concat());
        assert_eq!(with(&[]), Some(123.5));
        assert_eq!(with(&["--trails", "80"]), Some(103.5));
        assert_eq!(with(&["--trails", "4000"]), Some(0.0), "from the start");
        assert!(options(&[&picture[..], &["--trails", "80"]].concat()).plays_to_picture());
        assert!(!options(&picture).plays_to_picture());
    }
}
