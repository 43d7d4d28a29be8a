//! What comes from files that a person chose: the picture on the floor, and what robots look like.

use std::path::Path;

use crate::camera::Bounds;
use crate::floor_picture::FloorPicture;
use crate::interface::settings::{RobotMesh, Settings};
use crate::mesh_file;
use crate::stage::Stage;

/// What stands there now.
#[derive(Debug, Default)]
pub struct Furniture {
    /// The image, and the floor it lies on.
    floor: (String, Option<[f32; 2]>),
    mesh: Option<RobotMesh>,
}

impl Furniture {
    /// Brings what the settings name and isn't there yet; what can't be read is told, and what is built in stands in its
    /// place.
    pub fn renew(&mut self, settings: &Settings, stage: &mut Stage) -> Vec<String> {
        let mut complaints = Vec::new();
        if (&self.floor.0, self.floor.1) != (&settings.floor_image, settings.floor) {
            let was_bare = self.floor.0.is_empty();
            self.floor = (settings.floor_image.clone(), settings.floor);
            if !(was_bare && self.floor.0.is_empty()) {
                complaints.extend(self.lay(stage));
            }
        }
        if self.mesh != settings.mesh {
            self.mesh.clone_from(&settings.mesh);
            complaints.extend(self.dress(stage));
        }
        complaints
    }

    fn lay(&self, stage: &mut Stage) -> Option<String> {
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

    fn dress(&self, stage: &mut Stage) -> Option<String> {
        let Some(RobotMesh { file, scale, z }) = &self.mesh else {
            stage.renderer.set_mesh(None, None);
            return None;
        };
        match mesh_file::load(Path::new(file), *scale, *z) {
            Ok(mesh) if stage.renderer.set_mesh(None, Some(&mesh)) => None,
            Ok(_) => Some(format!("{file}: too many meshes; it isn't used")),
            Err(error) => {
                stage.renderer.set_mesh(None, None);
                Some(format!("{error}; the built-in robot stands in its place"))
            }
        }
    }
}
