//! The values of the viewer's options, parsed from text.

use std::path::PathBuf;
use std::str::FromStr;

use glam::{UVec2, Vec2, Vec3};

use crate::camera::{Bounds, Camera};
use crate::scene::Light;

/// The error of parsing an option's value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is not {expected}")]
pub struct OptionError {
    text: String,
    expected: &'static str,
}

/// Width and height in pixels, for example `1920x1080`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub UVec2);

/// Two numbers, for example `1.5,-2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair(pub Vec2);

/// A light: `x,y,z` or `x,y,z,r,g,b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightOption(pub Light);

/// A mesh for robots, for example `tug=tug.stl,0.001,0.1`.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshOption {
    /// Name of the robot type; `None` for all types.
    pub robot_type: Option<String>,
    /// The file.
    pub path: PathBuf,
    /// Metres per unit of the file.
    pub scale: f32,
    /// Height by which the mesh is lifted, in metres.
    pub z: f32,
}

/// The initial camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraOption {
    /// Shows the whole graph from an angle.
    Fit,
    /// Shows the whole graph straight from above.
    Top,
    /// A camera with a given position and view direction.
    Eye(Camera),
}

/// Parses finite numbers below a million, separated by commas.
fn numbers(text: &str, expected: &'static str) -> Result<Vec<f32>, OptionError> {
    let number = |part: &str| part.trim().parse::<f32>().ok().filter(|number| number.is_finite() && number.abs() < 1e6);
    text.split(',').map(number).collect::<Option<_>>().ok_or(OptionError { text: text.to_owned(), expected })
}

/// Parses the speed of a film.
pub fn film_speed(text: &str) -> Result<f32, OptionError> {
    let factor = text.parse().ok().filter(|factor| (0.001..=1000.0).contains(factor));
    factor.ok_or(OptionError { text: text.to_owned(), expected: "a factor from 0.001 to 1000" })
}

/// Parses a number of samples per pixel.
pub fn samples(text: &str) -> Result<u32, OptionError> {
    let expected = "1 or 4";
    text.parse().ok().filter(|count| [1, 4].contains(count)).ok_or(OptionError { text: text.to_owned(), expected })
}

impl FromStr for Size {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let side = |text: &str| text.parse::<u32>().ok().filter(|side| (1..=32_768).contains(side));
        text.split_once('x')
            .and_then(|(width, height)| Some(Self(UVec2::new(side(width)?, side(height)?))))
            .ok_or(OptionError { text: text.to_owned(), expected: "a size such as 1920x1080" })
    }
}

impl FromStr for Pair {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let expected = "two numbers such as 1.5,-2";
        match numbers(text, expected)?[..] {
            [x, y] => Ok(Self(Vec2::new(x, y))),
            _ => Err(OptionError { text: text.to_owned(), expected }),
        }
    }
}

impl FromStr for LightOption {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let expected = "a light such as 0,0,5 or 0,0,5,1,0.8,0.6";
        let (position, colour) = match numbers(text, expected)?[..] {
            [x, y, z] => (Vec3::new(x, y, z), Vec3::ONE),
            [x, y, z, red, green, blue] => (Vec3::new(x, y, z), Vec3::new(red, green, blue).max(Vec3::ZERO)),
            _ => return Err(OptionError { text: text.to_owned(), expected }),
        };
        Ok(Self(Light { position, colour }))
    }
}

impl FromStr for MeshOption {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let expected = "a mesh such as box.stl, box.stl,0.001 or tug=box.stl,0.001,0.1";
        let (robot_type, rest) = text.split_once('=').map_or((None, text), |(name, rest)| (Some(name), rest));
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
            _ => Err(OptionError { text: text.to_owned(), expected }),
        }
    }
}

impl FromStr for CameraOption {
    type Err = OptionError;

    fn from_str(text: &str) -> Result<Self, OptionError> {
        let expected = "fit, top or x,y,z,yaw,pitch";
        match text {
            "fit" => Ok(Self::Fit),
            "top" => Ok(Self::Top),
            eye => match numbers(eye, expected)?[..] {
                [x, y, z, yaw, pitch] => Ok(Self::Eye(Camera::from_eye(Vec3::new(x, y, z), yaw, pitch))),
                _ => Err(OptionError { text: text.to_owned(), expected }),
            },
        }
    }
}

impl CameraOption {
    /// Returns the camera for a picture of `size` pixels of a fleet within `bounds`.
    pub fn camera(self, bounds: Bounds, size: UVec2) -> Camera {
        let aspect = size.x as f32 / size.y as f32;
        match self {
            Self::Fit => Camera::fit(bounds, aspect),
            Self::Top => Camera::top(bounds, aspect),
            Self::Eye(camera) => camera,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn valid_values_are_parsed_and_invalid_ones_rejected() {
        assert_eq!("640x480".parse(), Ok(Size(UVec2::new(640, 480))));
        assert_eq!("1.5,-2".parse(), Ok(Pair(Vec2::new(1.5, -2.0))));
        assert_eq!("top".parse(), Ok(CameraOption::Top));
        assert!("0,0,5,1.57,0.5".parse::<CameraOption>().is_ok());
        for bad in ["", "640", "0x5", "640x480x2", "640x-1", "99999x1"] {
            assert!(bad.parse::<Size>().is_err(), "{bad}");
        }
        for bad in ["", "side", "1,2,3", "1,2,3,4,nan", "1,2,3,4,5,6"] {
            assert!(bad.parse::<CameraOption>().is_err(), "{bad}");
        }
        assert!("0,0".parse::<LightOption>().is_err());
        let mesh: MeshOption = "tug=a/b.stl,0.001,0.1".parse().unwrap();
        assert_eq!((mesh.robot_type.as_deref(), mesh.scale, mesh.z), (Some("tug"), 0.001, 0.1));
        for bad in ["", "tug=", "a.stl,0", "a.stl,x", "a.stl,1,2,3"] {
            assert!(bad.parse::<MeshOption>().is_err(), "{bad}");
        }
    }
}
