//! The precedence between the command line and the settings file: options hold for one start and
//! are not stored.

use super::{RobotMesh, Settings};
use crate::options::LookOptions;
use crate::palette::Theme;
use crate::scene::Light;

impl Settings {
    /// Returns the settings overridden by the options of the command line.
    #[must_use]
    pub fn overridden_by(mut self, look: &LookOptions) -> Self {
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
        if let Some(at) = look.floor_at {
            self.floor_at = Some(at.0);
        }
        if let Some(model) = look.mesh.iter().rfind(|model| model.robot_type.is_none()) {
            self.mesh = Some(RobotMesh::new(model.path.display().to_string(), model.placement));
        }
        if !look.light.is_empty() {
            let lamp = |light: &Light| {
                let ([x, y, z], [red, green, blue]) =
                    (light.position.to_array(), light.colour.to_array());
                [x, y, z, red, green, blue]
            };
            self.lamps = look.light.iter().map(|light| lamp(&light.0)).collect();
        }
        self.grid &= !look.no_grid;
        self.shadows &= !look.no_shadows;
        (self.edges, self.nodes) = (self.edges && !look.no_graph, self.nodes && !look.no_graph);
        self.ids &= !look.no_graph && !look.no_ids;
        self.robot_ids |= look.robot_ids;
        self.plans |= look.plans;
        self.waits |= look.waits;
        self.density &= !look.no_density;
        if let Some(heat) = look.heat {
            (self.heat, self.heat_of) = (true, heat);
        }
        self.sanitized()
    }

    /// Returns the settings to store. Values that the user has not changed since the start, where
    /// they were `initial`, are replaced by those in the file, `stored`, so that options of the
    /// command line are not stored.
    #[must_use]
    pub fn to_store(&self, initial: &Self, stored: &Self) -> Self {
        fn restore<T: PartialEq + Clone>(value: &mut T, initial: &T, stored: &T) {
            if value == initial {
                value.clone_from(stored);
            }
        }
        let mut result = self.clone();
        restore(&mut result.light, &initial.light, &stored.light);
        restore(&mut result.colour, &initial.colour, &stored.colour);
        restore(&mut result.grid, &initial.grid, &stored.grid);
        restore(&mut result.shadows, &initial.shadows, &stored.shadows);
        restore(&mut result.edges, &initial.edges, &stored.edges);
        restore(&mut result.nodes, &initial.nodes, &stored.nodes);
        restore(&mut result.ids, &initial.ids, &stored.ids);
        restore(&mut result.robot_ids, &initial.robot_ids, &stored.robot_ids);
        restore(&mut result.plans, &initial.plans, &stored.plans);
        restore(&mut result.waits, &initial.waits, &stored.waits);
        restore(&mut result.density, &initial.density, &stored.density);
        restore(&mut result.heat, &initial.heat, &stored.heat);
        restore(&mut result.heat_of, &initial.heat_of, &stored.heat_of);
        restore(&mut result.offset, &initial.offset, &stored.offset);
        restore(&mut result.floor, &initial.floor, &stored.floor);
        restore(&mut result.trails, &initial.trails, &stored.trails);
        restore(
            &mut result.trails_of_selected,
            &initial.trails_of_selected,
            &stored.trails_of_selected,
        );
        restore(&mut result.floor_image, &initial.floor_image, &stored.floor_image);
        restore(&mut result.floor_at, &initial.floor_at, &stored.floor_at);
        restore(&mut result.mesh, &initial.mesh, &stored.mesh);
        restore(&mut result.lamps, &initial.lamps, &stored.lamps);
        restore(&mut result.window, &initial.window, &stored.window);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;

    #[test]
    fn options_of_the_command_line_override_settings_and_are_not_stored() {
        use clap::{Args, FromArgMatches};
        let look = |args: &[&str]| {
            let command = Options::augment_args(clap::Command::new("viewer").no_binary_name(true));
            Options::from_arg_matches(&command.try_get_matches_from(args).unwrap()).unwrap().look
        };
        let stored =
            Settings { light: true, colour: "speed".into(), trails: 9, ..Settings::default() };
        let initial = stored.clone().overridden_by(&look(&[
            "--theme",
            "dark",
            "--colour",
            "collision",
            "--trails",
            "0",
            "--no-grid",
            "--plans",
            "--waits",
            "--no-density",
            "--heat",
            "speed:run",
        ]));
        assert!(initial.plans && initial.waits && initial.heat && !initial.density);
        assert_eq!(initial.heat_of.to_string(), "speed:run");
        assert_eq!(
            (initial.light, initial.colour.as_str(), initial.trails, initial.grid),
            (false, "collision", 0, false)
        );
        assert_eq!(initial.to_store(&initial, &stored), stored);
        let changed = Settings { colour: "state".into(), shadows: false, ..initial.clone() };
        let wanted = Settings { colour: "state".into(), shadows: false, ..stored.clone() };
        assert_eq!(changed.to_store(&initial, &stored), wanted);
        let lit = Settings::default().overridden_by(&look(&[
            "--light",
            "1,2,3",
            "--mesh",
            "a.stl,0.5",
            "--mesh",
            "tug=b.stl",
        ]));
        assert_eq!(lit.lamps, [[1.0, 2.0, 3.0, 1.0, 1.0, 1.0]]);
        assert_eq!(lit.mesh.map(|mesh| (mesh.file, mesh.scale)), Some(("a.stl".into(), 0.5)));
    }
}
