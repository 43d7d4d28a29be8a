//! The values of the viewer's options, parsed from text.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::{UVec2, Vec2, Vec3};
use regatta_interface::cameras::{ParseError, numbers};
use regatta_interface::settings::{FloorPlacement, MeshPlacement};
use regatta_scene::Light;
use regatta_scene::palette::Theme;

/// A mesh for robots, for example `tug=tug.stl,0.001,0.1,90`.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshOption {
    /// Name of the robot type; `None` for all types.
    pub robot_type: Option<String>,
    /// The file.
    pub path: PathBuf,
    /// The placement on the robot.
    pub placement: MeshPlacement,
}

/// Parses the name of a theme.
pub fn theme() -> impl TypedValueParser<Value = Theme> {
    let names = [
        PossibleValue::new("dark").help("Light objects on a dark floor"),
        PossibleValue::new("light").help("Dark objects on a light floor"),
    ];
    PossibleValuesParser::new(names)
        .map(|name| if name == "light" { Theme::Light } else { Theme::Dark })
}

/// Parses a duration that is not zero.
pub fn duration_above_zero(text: &str) -> Result<humantime::Duration, ParseError> {
    let duration = text.parse::<humantime::Duration>().ok().filter(|duration| !duration.is_zero());
    duration.ok_or(ParseError {
        text: text.to_owned(),
        expected: "a duration above 0, for example 10s or 1min",
    })
}

/// Parses the speed of a film.
pub fn film_speed(text: &str) -> Result<f32, ParseError> {
    let factor = text.parse().ok().filter(|factor| (0.001..=1000.0).contains(factor));
    factor.ok_or(ParseError { text: text.to_owned(), expected: "a factor from 0.001 to 1000" })
}

/// Parses the scale of a plan.
pub fn scale(text: &str) -> Result<f32, ParseError> {
    let expected = "a scale from 1 to 1000000 such as 200, for 1:200";
    let scale = text
        .strip_prefix("1:")
        .unwrap_or(text)
        .parse::<f32>()
        .ok()
        .filter(|scale| (1.0..=1e6).contains(scale));
    scale.ok_or(ParseError { text: text.to_owned(), expected })
}

/// Parses a number of samples per pixel.
pub fn samples(text: &str) -> Result<u32, ParseError> {
    let expected = "1 or 4";
    text.parse()
        .ok()
        .filter(|count| [1, 4].contains(count))
        .ok_or(ParseError { text: text.to_owned(), expected })
}

/// Parses a width and height in pixels.
pub fn size(text: &str) -> Result<UVec2, ParseError> {
    text.split_once('x')
        .and_then(|(width, height)| Some(UVec2::new(side(width)?, side(height)?)))
        .ok_or(ParseError { text: text.to_owned(), expected: "a size such as 1920x1080" })
}

fn side(text: &str) -> Option<u32> {
    text.parse().ok().filter(|side| (1..=32_768).contains(side))
}

/// Parses two numbers.
pub fn pair(text: &str) -> Result<Vec2, ParseError> {
    let expected = "two numbers such as 1.5,-2";
    match numbers(text, expected)?[..] {
        [x, y] => Ok(Vec2::new(x, y)),
        _ => Err(ParseError { text: text.to_owned(), expected }),
    }
}

/// Parses a light: its position, and its colour, which is white by default.
pub fn light(text: &str) -> Result<Light, ParseError> {
    let expected = "a light such as 0,0,5 or 0,0,5,1,0.8,0.6";
    let (position, colour) = match numbers(text, expected)?[..] {
        [x, y, z] => (Vec3::new(x, y, z), Vec3::ONE),
        [x, y, z, red, green, blue] => {
            (Vec3::new(x, y, z), Vec3::new(red, green, blue).max(Vec3::ZERO))
        }
        _ => return Err(ParseError { text: text.to_owned(), expected }),
    };
    Ok(Light { position, colour })
}

/// Parses the placement of a picture on the floor.
pub fn floor_at(text: &str) -> Result<FloorPlacement, ParseError> {
    let expected = "x,y,resolution or x,y,resolution,yaw such as -10,-5.5,0.05";
    let failed = || ParseError { text: text.to_owned(), expected };
    let (x, y, metres_per_pixel, yaw_degrees) = match numbers(text, expected)?[..] {
        [x, y, resolution] => (x, y, resolution, 0.0),
        [x, y, resolution, yaw] => (x, y, resolution, yaw),
        _ => return Err(failed()),
    };
    let at = FloorPlacement { x, y, metres_per_pixel, yaw_degrees };
    if (1e-4..=100.0).contains(&metres_per_pixel) { Ok(at) } else { Err(failed()) }
}

impl FromStr for MeshOption {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        let expected = "a mesh such as box.stl, box.stl,0.001 or tug=box.stl,0.001,0.1,90";
        let (robot_type, rest) =
            text.split_once('=').map_or((None, text), |(name, rest)| (Some(name), rest));
        let mut parts = rest.split(',');
        let path = parts.next().filter(|path| !path.is_empty());
        let mut number = |default: f32, (low, high): (f32, f32)| {
            let number = parts.next().map_or(Ok(default), |part| part.trim().parse());
            number.ok().filter(|number| (low..=high).contains(number))
        };
        let (scale, z) = (number(1.0, (1e-6, 1e6)), number(0.0, (-100.0, 100.0)));
        let yaw = number(0.0, (-360.0, 360.0)).map(f32::to_radians);
        match (path, scale, z, yaw, parts.next()) {
            (Some(path), Some(scale), Some(z), Some(yaw), None) => {
                let placement = MeshPlacement { scale, z, yaw };
                Ok(Self { robot_type: robot_type.map(str::to_owned), path: path.into(), placement })
            }
            _ => Err(ParseError { text: text.to_owned(), expected }),
        }
    }
}

#[cfg(test)]
mod tests {
    use regatta_interface::cameras::{Bookmark, CameraOption};
    use regatta_scene::camera::{Bounds, Window};

    use super::*;

    #[test]
    fn valid_values_are_parsed_and_invalid_ones_rejected() {
        assert_eq!(size("640x480"), Ok(UVec2::new(640, 480)));
        assert_eq!(pair("1.5,-2"), Ok(Vec2::new(1.5, -2.0)));
        assert_eq!("top".parse(), Ok(CameraOption::Top));
        assert!("0,0,5,1.57,0.5".parse::<CameraOption>().is_ok());
        for bad in ["", "640", "0x5", "640x480x2", "640x-1", "99999x1"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        for bad in ["", "2side", "1,2,-3", "1,2", "1,2,3,4,nan", "1,2,3,4,5,6"] {
            assert!(bad.parse::<CameraOption>().is_err(), "{bad}");
        }
        assert!(light("0,0").is_err());
        let mesh: MeshOption = "tug=a/b.stl,0.001,0.1".parse().unwrap();
        let MeshPlacement { scale, z, yaw } = mesh.placement;
        assert_eq!((mesh.robot_type.as_deref(), scale, z, yaw), (Some("tug"), 0.001, 0.1, 0.0));
        let turned: MeshOption = "box.stl,1,0,90".parse().expect("a mesh");
        assert!((turned.placement.yaw - core::f32::consts::FRAC_PI_2).abs() < 1e-6);
        let plan: CameraOption = "20,-10,60".parse().expect("a plan");
        let camera = plan.camera(Bounds::default(), Window::whole(1.0));
        assert!(camera.is_plan() && camera.target == Vec3::new(20.0, -10.0, 0.0));
        assert_eq!(
            CameraOption::entry(&camera),
            "  - {name: here, x: 20.00, y: -10.00, height: 60.00}"
        );
        assert_eq!("dock".parse(), Ok(CameraOption::Named("dock".into())));
        let bookmark: Bookmark = "west hall = 1,2,3,0,0.5".parse().expect("a bookmark");
        assert_eq!(bookmark.name, "west hall");
        for bad in ["=fit", "dock", "a=b", "a=1,2", "a=1,2,-3"] {
            assert!(bad.parse::<Bookmark>().is_err(), "{bad}");
        }
        let at = FloorPlacement { x: -10.0, y: 5.0, metres_per_pixel: 0.05, yaw_degrees: 0.0 };
        assert_eq!(floor_at("-10,5,0.05"), Ok(at));
        assert!(floor_at("1,2").is_err() && floor_at("1,2,0").is_err());
        assert_eq!((super::scale("200"), super::scale("1:50")), (Ok(200.0), Ok(50.0)));
        assert!(super::scale("0.5").is_err());
        for bad in ["", "tug=", "a.stl,0", "a.stl,x", "a.stl,1,2,3,4"] {
            assert!(bad.parse::<MeshOption>().is_err(), "{bad}");
        }
    }
}
