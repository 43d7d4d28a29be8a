//! The sections of a scenario that belong to the viewer: lights and named cameras.

use std::collections::BTreeSet;

use regatta_scene::MAX_LIGHTS;
use serde::Deserialize;

/// The sections of a scenario that belong to the viewer.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Sections {
    /// The lights besides the sun; at most [`MAX_LIGHTS`].
    pub lights: Vec<LightEntry>,
    /// The named cameras.
    pub cameras: Vec<CameraEntry>,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightEntry {
    /// Metres to the east.
    pub x: f32,
    /// Metres to the north.
    pub y: f32,
    /// Metres above the floor.
    pub z: f32,
    /// Linear red, green and blue, 0 to 1 and above; white by default.
    #[serde(default = "white")]
    pub colour: [f32; 3],
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

/// A named camera: in perspective from a place, with `z`, `yaw` and `pitch`, or a plan, with
/// `height`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraEntry {
    /// The name.
    pub name: String,
    /// Metres to the east: of the eye, or of the middle of a plan.
    pub x: f32,
    /// Metres to the north.
    pub y: f32,
    /// The eye's metres above the floor.
    pub z: Option<f32>,
    /// The view's direction in radians counter-clockwise from east.
    pub yaw: Option<f32>,
    /// The angle of the view's direction below the horizon, in radians.
    pub pitch: Option<f32>,
    /// The height of the ground in the picture of a plan, in metres.
    pub height: Option<f32>,
}

/// The error of a section with an invalid entry.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{section}: {message}")]
pub struct SectionError {
    /// The name of the section.
    pub section: &'static str,
    /// The entry, its problem and the solution.
    pub message: String,
}

impl Sections {
    /// Checks the sections and returns them as arguments of the viewer.
    ///
    /// # Errors
    /// If a number is out of range, a name can't be given to a camera, or there are too many
    /// lights.
    ///
    /// ```
    /// use regatta_viewer::sections::{LightEntry, Sections};
    ///
    /// let light = LightEntry { x: 4.0, y: -2.5, z: 6.0, colour: [1.0, 0.5, 0.0] };
    /// let sections = Sections { lights: vec![light], cameras: vec![] };
    /// assert_eq!(sections.to_args()?, ["--light", "4,-2.5,6,1,0.5,0"]);
    /// # Ok::<(), regatta_viewer::sections::SectionError>(())
    /// ```
    pub fn to_args(&self) -> Result<Vec<String>, SectionError> {
        self.check_lights().map_err(|message| SectionError { section: "lights", message })?;
        self.check_cameras().map_err(|message| SectionError { section: "cameras", message })?;
        let mut args = Vec::new();
        for LightEntry { x, y, z, colour: [red, green, blue] } in &self.lights {
            args.extend(["--light".to_owned(), format!("{x},{y},{z},{red},{green},{blue}")]);
        }
        for camera in &self.cameras {
            let view: Vec<_> = camera.numbers().map(|number| number.to_string()).collect();
            args.extend(["--bookmark".to_owned(), format!("{}={}", camera.name, view.join(","))]);
        }
        Ok(args)
    }

    fn check_lights(&self) -> Result<(), String> {
        let count = self.lights.len();
        if count > MAX_LIGHTS {
            return Err(format!("{count} lights are too many; give at most {MAX_LIGHTS}"));
        }
        for (number, light) in (1..).zip(&self.lights) {
            light.check().map_err(|message| format!("entry {number}: {message}"))?;
        }
        Ok(())
    }

    fn check_cameras(&self) -> Result<(), String> {
        let mut names = BTreeSet::new();
        for (number, camera) in (1..).zip(&self.cameras) {
            camera.check().map_err(|message| format!("entry {number}: {message}"))?;
            if !names.insert(&camera.name) {
                let name = &camera.name;
                return Err(format!("entry {number}: the name '{name}' is used twice"));
            }
        }
        Ok(())
    }
}

impl LightEntry {
    /// Checks the ranges, which are those of the option `--light`.
    fn check(&self) -> Result<(), String> {
        for (name, metres) in [("x", self.x), ("y", self.y), ("z", self.z)] {
            if !metres.is_finite() || metres.abs() >= 1e6 {
                return Err(format!("{name} is {metres}; give metres, less than a million"));
            }
        }
        for component in self.colour {
            if !(0.0..1e6).contains(&component) {
                return Err(format!(
                    "colour has {component}; give red, green and blue, each 0 to 1 or a little \
                     above"
                ));
            }
        }
        Ok(())
    }
}

impl CameraEntry {
    /// Checks that the option `--bookmark` can be given the camera.
    fn check(&self) -> Result<(), String> {
        let Self { name, z, yaw, pitch, height, .. } = self;
        // The viewer tells names from fit, top, plan and numbers.
        let is_name = name.starts_with(char::is_alphabetic)
            && !name.contains([',', '='])
            && name.trim() == name;
        if !is_name || ["fit", "top", "plan"].contains(&name.as_str()) {
            return Err(format!(
                "name is '{name}'; give a name that begins with a letter, without , and =, and \
                 not fit, top or plan"
            ));
        }
        if let Some(bad) = self.numbers().find(|number| !number.is_finite() || number.abs() >= 1e6)
        {
            return Err(format!("{bad} is out of range; give numbers below a million"));
        }
        match (z, yaw, pitch, height) {
            (Some(_), Some(_), Some(_), None) => Ok(()),
            (None, None, None, Some(height)) if *height > 0.0 => Ok(()),
            _ => Err("give either z, yaw and pitch, or height (above 0) for a plan".to_owned()),
        }
    }

    /// The numbers that are given, in the order of the option `--bookmark`.
    fn numbers(&self) -> impl Iterator<Item = f32> {
        let Self { x, y, z, yaw, pitch, height, .. } = *self;
        [Some(x), Some(y), z, yaw, pitch, height].into_iter().flatten()
    }
}
