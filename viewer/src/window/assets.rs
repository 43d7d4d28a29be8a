//! The files that the user chose: the picture on the floor, and the mesh of the robots.

use std::path::Path;

use crate::camera::Bounds;
use crate::floor_picture::FloorPicture;
use crate::interface::settings::{RobotMesh, Settings};
use crate::mesh_file;
use crate::stage::Stage;

/// The loaded files.
#[derive(Debug, Default)]
pub struct Assets {
    /// The path of the picture, and the size of the floor in metres.
    floor: (String, Option<[f32; 2]>),
    mesh: Option<RobotMesh>,
}

impl Assets {
    /// Loads the files of the settings that are not loaded yet. Where one can't be read, the built-in look is used, and a
    /// message is returned.
    pub fn update(&mut self, settings: &Settings, stage: &mut Stage) -> Vec<String> {
        let mut messages = Vec::new();
        if (&self.floor.0, self.floor.1) != (&settings.floor_image, settings.floor) {
            let was_bare = self.floor.0.is_empty();
            self.floor = (settings.floor_image.clone(), settings.floor);
            if !(was_bare && self.floor.0.is_empty()) {
                messages.extend(self.load_floor(stage));
            }
        }
        if self.mesh != settings.mesh {
            self.mesh.clone_from(&settings.mesh);
            messages.extend(self.load_mesh(stage));
        }
        messages
    }

    fn load_floor(&self, stage: &mut Stage) -> Option<String> {
        let (file, size) = &self.floor;
        stage.renderer.set_floor_picture(None);
        if file.is_empty() {
            return None;
        }
        let bounds = size.map_or(stage.bounds(), Bounds::of_size);
        match FloorPicture::load(Path::new(file), bounds, stage.renderer.max_texture_size()) {
            Ok(picture) => {
                stage.renderer.set_floor_picture(Some(&picture));
                None
            }
            Err(error) => Some(format!("{error}; the floor stays plain")),
        }
    }

    fn load_mesh(&self, stage: &mut Stage) -> Option<String> {
        let Some(RobotMesh { file, scale, z }) = &self.mesh else {
            stage.renderer.set_mesh(None, None);
            return None;
        };
        match mesh_file::load(Path::new(file), *scale, *z) {
            Ok(mesh) if stage.renderer.set_mesh(None, Some(&mesh)) => None,
            Ok(_) => Some(format!("{file}: too many meshes; this one is not used")),
            Err(error) => {
                stage.renderer.set_mesh(None, None);
                Some(format!("{error}; the built-in robot is used"))
            }
        }
    }
}
