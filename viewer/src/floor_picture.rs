//! Pictures on the floor: an image, or a ROS map (`map.yaml` and the image that it refers to).

use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::Vec2;
use image::{ImageReader, RgbaImage};
use regatta_base::yaml::{self, Node};
use regatta_gpu::floor::FloorPicture;
use regatta_interface::settings::FloorPlacement;
use regatta_scene::camera::Bounds;

use crate::files;

/// The maximum memory for one picture, in bytes.
const MAX_BYTES: u64 = 1 << 30;
/// The colour of a map's occupied cells: red, green, blue, alpha.
const OCCUPIED: [u8; 4] = [120, 136, 152, 255];
/// The colour of a map's free cells.
const FREE: [u8; 4] = [128, 140, 152, 36];

/// The error of loading a floor picture.
#[derive(Debug, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct FloorPictureError {
    /// The file.
    pub path: PathBuf,
    /// The reason.
    pub reason: String,
}

/// Reads a ROS map if the name ends in `.yaml` or `.yml`, else an image that is stretched over
/// `bounds`. A picture with more than `limit` pixels in either direction is scaled down.
/// `placed` overrides the placement.
///
/// # Errors
/// [`FloorPictureError`] if a file can't be read or is malformed.
pub fn load(
    path: &Path,
    bounds: Bounds,
    limit: u32,
    placed: Option<FloorPlacement>,
) -> Result<FloorPicture, FloorPictureError> {
    let is_map =
        path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml");
    let picture = if is_map {
        load_map(path)?
    } else {
        let pixels =
            read(path).map_err(|reason| FloorPictureError { path: path.to_owned(), reason })?;
        FloorPicture { pixels, corner: bounds.low, turn: 0.0, size: bounds.high - bounds.low }
    };
    let picture = match placed {
        None => picture,
        Some(at) => FloorPicture {
            corner: Vec2::new(at.x, at.y),
            turn: at.yaw_degrees.to_radians(),
            size: Vec2::new(picture.pixels.width() as f32, picture.pixels.height() as f32)
                * at.metres_per_pixel,
            ..picture
        },
    };
    Ok(limited(picture, limit))
}

fn limited(picture: FloorPicture, limit: u32) -> FloorPicture {
    let (width, height) = picture.pixels.dimensions();
    let longest = width.max(height);
    if longest <= limit {
        return picture;
    }
    tracing::warn!(
        "the floor picture of {width}x{height} pixels exceeds the adapter's limit of {limit} and \
         is scaled down"
    );
    let scaled =
        |side: u32| (u64::from(side) * u64::from(limit) / u64::from(longest)).max(1) as u32;
    FloorPicture {
        pixels: image::imageops::thumbnail(&picture.pixels, scaled(width), scaled(height)),
        ..picture
    }
}

fn read(path: &Path) -> Result<RgbaImage, String> {
    let mut reader = ImageReader::new(BufReader::new(files::open(path)?))
        .with_guessed_format()
        .map_err(|error| error.to_string())?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| error.to_string())?;
    if u64::from(picture.width()) * u64::from(picture.height()) * 4 > MAX_BYTES {
        return Err(format!(
            "the image of {}x{} pixels is too large",
            picture.width(),
            picture.height()
        ));
    }
    Ok(picture.into_rgba8())
}

/// The contents of a `map.yaml`.
#[derive(Debug, PartialEq)]
struct Map {
    image: String,
    resolution: f64,
    origin: [f64; 3],
    negate: bool,
    occupied_thresh: f64,
    free_thresh: f64,
}

fn load_map(path: &Path) -> Result<FloorPicture, FloorPictureError> {
    let failed = |reason: String| FloorPictureError { path: path.to_owned(), reason };
    let text = files::read_text(path).map_err(failed)?;
    let map = parse_map(&text).map_err(|error| failed(error.to_string()))?;
    let image = path.parent().unwrap_or(Path::new("")).join(&map.image);
    let mut pixels = read(&image).map_err(|reason| FloorPictureError { path: image, reason })?;
    for pixel in pixels.pixels_mut() {
        let [red, green, blue, alpha] = pixel.0.map(f64::from);
        let light = (red + green + blue) / (3.0 * 255.0);
        let occupied = if map.negate { light } else { 1.0 - light };
        pixel.0 = match occupied {
            _ if alpha == 0.0 => [0; 4],
            occupied if occupied > map.occupied_thresh => OCCUPIED,
            occupied if occupied < map.free_thresh => FREE,
            _ => [0; 4],
        };
    }
    let size = Vec2::new(pixels.width() as f32, pixels.height() as f32) * map.resolution as f32;
    let [x, y, turn] = map.origin.map(|part| part as f32);
    Ok(FloorPicture { pixels, corner: Vec2::new(x, y), turn, size })
}

fn parse_map(text: &str) -> Result<Map, yaml::Error> {
    let root = yaml::parse(text)?;
    let fields = root.all_fields()?;
    let resolution = fields.required("resolution")?;
    if !(1e-4..=100.0).contains(&resolution.number()?) {
        return Err(resolution.error("resolution must be metres per pixel, from 0.0001 to 100"));
    }
    let origin = fields.required("origin")?;
    let [x, y, yaw] = origin.list()? else {
        return Err(origin.error("origin must be [x, y, yaw] of the lower left pixel"));
    };
    Ok(Map {
        image: fields.required("image")?.text()?.into_owned(),
        resolution: resolution.number()?,
        origin: [x.number()?, y.number()?, yaw.number()?],
        negate: fields.optional("negate", Node::number)?.is_some_and(|negate| negate != 0.0),
        occupied_thresh: fields.optional("occupied_thresh", Node::number)?.unwrap_or(0.65),
        free_thresh: fields.optional("free_thresh", Node::number)?.unwrap_or(0.25),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_file_is_read() {
        let text = "image: hall.pgm\nresolution: 0.05\norigin: [-10, -5.5, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
        let map = parse_map(text).unwrap();
        assert_eq!(
            (map.image.as_str(), map.resolution, map.origin),
            ("hall.pgm", 0.05, [-10.0, -5.5, 0.0])
        );
        assert!(!map.negate && map.free_thresh == 0.196);
    }

    #[test]
    fn a_malformed_map_is_reported_in_one_line() {
        let good = [
            ("image", "image: a.pgm"),
            ("resolution", "resolution: 0.1"),
            ("origin", "origin: [0, 0, 0]"),
        ];
        for (missing, _) in good {
            let text: Vec<_> =
                good.iter().filter(|(key, _)| *key != missing).map(|(_, line)| *line).collect();
            let error = parse_map(&text.join("\n")).unwrap_err().to_string();
            assert!(error.contains(missing) && !error.contains('\n'), "{error}");
        }
        for bad in [
            "",
            "- 1",
            "image: [",
            "image: a\nresolution: 0\norigin: [0,0,0]",
            "image: a\nresolution: 1\norigin: [0,0,x]",
        ] {
            assert!(parse_map(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_map_is_placed_at_its_origin() {
        let folder = std::env::temp_dir().join(format!("regatta-map-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("made");
        std::fs::write(folder.join("m.pgm"), b"P5\n3 2\n255\n\x00\xff\xcd\xff\xff\xff")
            .expect("written");
        std::fs::write(
            folder.join("m.yaml"),
            "image: m.pgm\nresolution: 0.5\norigin: [-1, 2, 0]\n",
        )
        .expect("written");
        let picture = load(&folder.join("m.yaml"), Bounds::default(), 4096, None);
        let placed =
            Some(FloorPlacement { x: 7.0, y: -8.0, metres_per_pixel: 0.1, yaw_degrees: 90.0 });
        let moved = load(&folder.join("m.yaml"), Bounds::default(), 4096, placed).unwrap();
        assert_eq!((moved.corner, moved.size), (Vec2::new(7.0, -8.0), Vec2::new(0.3, 0.2)));
        assert!((moved.turn - core::f32::consts::FRAC_PI_2).abs() < 1e-6);
        std::fs::remove_dir_all(&folder).expect("removed");
        let picture = picture.unwrap();
        assert_eq!((picture.corner, picture.size), (Vec2::new(-1.0, 2.0), Vec2::new(1.5, 1.0)));
        let first: Vec<_> = picture.pixels.pixels().take(3).map(|pixel| pixel.0).collect();
        assert_eq!(first, [OCCUPIED, FREE, FREE]);
    }

    #[test]
    fn large_pictures_are_scaled_down() {
        let pixels = RgbaImage::new(300, 20);
        let picture =
            limited(FloorPicture { pixels, corner: Vec2::ZERO, turn: 0.0, size: Vec2::ONE }, 100);
        assert_eq!(picture.pixels.dimensions(), (100, 6));
    }
}
