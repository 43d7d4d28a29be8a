//! The files that the user chose: the picture on the floor, and the mesh of the robots.

use std::path::Path;

use glam::Vec2;
use regatta_gpu::floor::FloorPicture;
use regatta_interface::settings::{FloorPlacement, RobotMesh, Settings};
use regatta_scene::camera::Bounds;

use crate::stage::Stage;
use crate::{floor_picture, mesh_file};

/// The loaded files.
#[derive(Debug, Default)]
pub struct Assets {
    floor: FloorFile,
    mesh: Option<RobotMesh>,
}

/// The picture on the floor.
#[derive(Clone, Debug, Default, PartialEq)]
struct FloorFile {
    /// Empty for no picture.
    path: String,
    /// The size of the floor in metres.
    size: Option<Vec2>,
    placement: Option<FloorPlacement>,
}

impl FloorFile {
    fn of(settings: &Settings) -> Self {
        let Settings { floor_image, floor, floor_at, .. } = settings;
        Self { path: floor_image.clone(), size: *floor, placement: *floor_at }
    }
}

/// A file of the settings that could not be loaded.
#[derive(Debug)]
pub struct Unloadable {
    /// The path, as in the settings.
    pub file: String,
    /// The error, and the picture or mesh that is shown instead.
    pub message: String,
}

impl Assets {
    /// Loads the files of the settings that are not loaded yet. One that can't be loaded is
    /// returned, and replaced in the settings by the one before, which stays in use.
    pub fn update(&mut self, settings: &mut Settings, stage: &mut Stage) -> Vec<Unloadable> {
        let mut failures = Vec::new();
        if self.floor != FloorFile::of(settings) {
            failures.extend(self.update_floor(settings, stage));
        }
        if self.mesh != settings.mesh {
            failures.extend(self.update_mesh(settings, stage));
        }
        failures
    }

    fn update_floor(&mut self, settings: &mut Settings, stage: &mut Stage) -> Option<Unloadable> {
        let loaded = load_floor(&FloorFile::of(settings), stage);
        let failure = loaded.err().map(|error| {
            let message = format!("{error}; the floor stays as it is");
            let before = std::mem::take(&mut self.floor.path);
            let file = std::mem::replace(&mut settings.floor_image, before);
            // The file of the shown picture no longer exists.
            if file == settings.floor_image {
                settings.floor_image.clear();
            }
            if settings.floor_image.is_empty() {
                set_floor(stage, None);
            }
            Unloadable { file, message }
        });
        self.floor = FloorFile::of(settings);
        failure
    }

    fn update_mesh(&mut self, settings: &mut Settings, stage: &mut Stage) -> Option<Unloadable> {
        match load_mesh(settings.mesh.as_ref(), stage) {
            Ok(()) => {
                self.mesh.clone_from(&settings.mesh);
                None
            }
            Err(error) => {
                let rejected = std::mem::replace(&mut settings.mesh, self.mesh.clone());
                let file = rejected.map(|mesh| mesh.file).unwrap_or_default();
                Some(Unloadable { file, message: format!("{error}; the robots stay as they are") })
            }
        }
    }
}

fn load_floor(floor: &FloorFile, stage: &mut Stage) -> Result<(), String> {
    let file = &floor.path;
    if file.is_empty() {
        set_floor(stage, None);
        return Ok(());
    }
    let bounds = floor.size.map_or(stage.bounds(), Bounds::of_size);
    let max_size = stage.renderer.max_texture_size();
    let picture = floor_picture::load(Path::new(file), bounds, max_size, floor.placement);
    let picture = picture.map_err(|error| error.to_string())?;
    let has_room = set_floor(stage, Some(&picture));
    has_room.then_some(()).ok_or_else(|| format!("{file}: no room in the graphics memory"))
}

/// Sets or removes the picture on the floor of all levels that are shown. Returns false if one of
/// them has no room for it.
fn set_floor(stage: &mut Stage, picture: Option<&FloorPicture>) -> bool {
    let mut has_room = true;
    for renderer in stage.renderers() {
        has_room &= renderer.set_floor_picture(picture);
    }
    has_room
}

fn load_mesh(mesh: Option<&RobotMesh>, stage: &mut Stage) -> Result<(), String> {
    let mesh =
        mesh.map(|mesh| mesh_file::load(Path::new(&mesh.file), mesh.placement())).transpose();
    let mesh = mesh.map_err(|error| error.to_string())?;
    let mut has_room = true;
    for renderer in stage.renderers() {
        has_room &= renderer.set_mesh(None, mesh.as_ref());
    }
    has_room.then_some(()).ok_or_else(|| "too many meshes; this one is not used".to_owned())
}
