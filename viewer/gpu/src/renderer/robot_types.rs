//! The robot types, and the meshes that replace their built-in ones.

use regatta_plugin::world::RobotTypeRecord;

use super::Renderer;
use crate::columns::RobotTypeUniform;
use crate::mesh::Mesh;

/// A mesh that replaces the built-in one for a robot type.
#[derive(Debug)]
pub(super) struct MeshAssignment {
    /// Name of the type; `None` for all types without a mesh of their own.
    robot_type: Option<String>,
    /// The mesh's number in [`Robots`](crate::robots::Robots).
    mesh: usize,
    is_shown: bool,
}

impl Renderer {
    /// Sets or removes the mesh of a robot type, or with `None` of all types that have no mesh of
    /// their own. Returns false if there are too many meshes.
    pub fn set_mesh(&mut self, robot_type: Option<&str>, mesh: Option<&Mesh>) -> bool {
        let existing = self
            .assignments
            .iter_mut()
            .find(|assignment| assignment.robot_type.as_deref() == robot_type);
        match (existing, mesh) {
            (Some(assignment), Some(mesh)) => {
                self.robots.replace_mesh(&self.gpu, assignment.mesh, mesh);
                assignment.is_shown = true;
            }
            (Some(assignment), None) => assignment.is_shown = false,
            (None, Some(mesh)) => {
                let Some(mesh) = self.robots.add_mesh(&self.gpu, mesh) else { return false };
                self.assignments.push(MeshAssignment {
                    robot_type: robot_type.map(str::to_owned),
                    mesh,
                    is_shown: true,
                });
            }
            (None, None) => {}
        }
        self.upload_robot_types();
        true
    }

    /// Sets the records of the robot types.
    pub fn set_robot_types(&mut self, robot_types: &[RobotTypeRecord]) {
        self.robot_types = robot_types.to_vec();
        self.upload_robot_types();
    }

    fn upload_robot_types(&mut self) {
        let find = |name: Option<&str>| {
            self.assignments
                .iter()
                .find(|assignment| assignment.is_shown && assignment.robot_type.as_deref() == name)
        };
        let uniform = |record: &RobotTypeRecord| {
            let assignment = find(Some(record.name())).or_else(|| find(None));
            let uniform = RobotTypeUniform::new(record);
            assignment.map_or(uniform, |assignment| uniform.with_mesh(assignment.mesh))
        };
        let uniforms: Vec<_> = self.robot_types.iter().map(uniform).collect();
        self.robots.set_any_round(uniforms.iter().any(|uniform| uniform.is_round()));
        self.columns.set_robot_types(&self.gpu, &uniforms);
    }
}
