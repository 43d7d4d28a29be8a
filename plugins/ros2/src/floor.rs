//! The map of the floor, from a file of the ROS map server, as an OccupancyGrid.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use image::{GrayImage, ImageReader, Limits};
use regatta_base::file;
use regatta_base::yaml::{self, Content, Node};
use regatta_plugin::tell;

use crate::link::{Keep, Link, LinkError, Output};
use crate::message::display::{MapMetaData, OccupancyGrid};
use crate::message::geometry::{Header, Pose, Time};
use crate::poses::MAP;

/// The largest YAML, in bytes.
const MAX_YAML_BYTES: u64 = 1 << 20;
/// The largest picture: its file and its memory, in bytes.
const MAX_PICTURE_BYTES: u64 = 1 << 30;
/// The largest number of rows and of columns.
const MAX_SIDE: u32 = 8_192;
/// Cells of a message; more are put together, as DDS loses larger messages.
const CELLS: u32 = 148_000;

const FREE: i8 = 0;
const OCCUPIED: i8 = 100;
const UNKNOWN: i8 = -1;

/// The error of reading a map.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FloorError {
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    #[error("{}:{}: not a map of ROS: {}", path.display(), error.line, error.reason)]
    Yaml { path: PathBuf, error: yaml::Error },
    #[error("{}: not a picture of a map ({source}); give a PGM or PNG file", path.display())]
    Picture { path: PathBuf, source: image::ImageError },
}

/// The YAML of a map.
struct MapFile {
    image: PathBuf,
    resolution: f64,
    /// Metres, metres, radians.
    origin: [f64; 3],
    negate: bool,
    occupied: f64,
    free: f64,
}

impl MapFile {
    fn parse(text: &str) -> Result<Self, yaml::Error> {
        let root = yaml::parse(text)?;
        let fields = root.all_fields()?;
        let origin = fields.required("origin")?;
        let places: Vec<f64> = origin.list()?.iter().map(Node::number).collect::<Result<_, _>>()?;
        let [x, y, ref theta @ ..] = places[..] else {
            return Err(origin.error("expected x, y and an angle"));
        };
        let resolution = fields.required("resolution")?;
        let metres = resolution.number()?;
        if !(0.001..=10.0).contains(&metres) {
            return Err(resolution.error("expected 0.001 to 10 metres per cell"));
        }
        Ok(Self {
            image: fields.required("image")?.text()?.as_ref().into(),
            resolution: metres,
            origin: [x, y, theta.first().copied().unwrap_or_default()],
            negate: fields.optional("negate", truth)?.unwrap_or(false),
            occupied: fields.optional("occupied_thresh", Node::number)?.unwrap_or(0.65),
            free: fields.optional("free_thresh", Node::number)?.unwrap_or(0.25),
        })
    }

    /// The occupancy of a cell with a brightness.
    fn cell(&self, brightness: u8) -> i8 {
        let darkness = if self.negate { brightness } else { 255 - brightness };
        match f64::from(darkness) / 255.0 {
            part if part > self.occupied => OCCUPIED,
            part if part < self.free => FREE,
            _ => UNKNOWN,
        }
    }
}

/// Reads 0 or 1, or a truth value.
fn truth(node: &Node<'_>) -> Result<bool, yaml::Error> {
    match node.content {
        Content::Bool(truth) => Ok(truth),
        _ => node.number().map(|number| number != 0.0),
    }
}

/// Reads a map.
pub(crate) fn read(path: &Path) -> Result<OccupancyGrid, FloorError> {
    let text = file::read_text(path, MAX_YAML_BYTES).map_err(|source| unreadable(path, source))?;
    let map =
        MapFile::parse(&text).map_err(|error| FloorError::Yaml { path: path.to_owned(), error })?;
    let picture = path.parent().unwrap_or(Path::new("")).join(&map.image);
    Ok(grid(&map, &read_picture(&picture)?))
}

fn read_picture(path: &Path) -> Result<GrayImage, FloorError> {
    let file = file::open(path, MAX_PICTURE_BYTES).map_err(|source| unreadable(path, source))?;
    let reader = ImageReader::new(BufReader::new(file)).with_guessed_format();
    let mut reader = reader.map_err(|source| unreadable(path, source))?;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    limits.max_alloc = Some(MAX_PICTURE_BYTES);
    reader.limits(limits);
    match reader.decode() {
        Ok(picture) => Ok(picture.into_luma8()),
        Err(source) => Err(FloorError::Picture { path: path.to_owned(), source }),
    }
}

fn unreadable(path: &Path, source: std::io::Error) -> FloorError {
    FloorError::File { path: path.to_owned(), source }
}

/// Returns the cells, by row from the south. Of cells that are put together, one that is occupied
/// counts, else one that is unknown.
fn grid(map: &MapFile, picture: &GrayImage) -> OccupancyGrid {
    let (columns, rows) = picture.dimensions();
    let step = (f64::from(columns) * f64::from(rows) / f64::from(CELLS)).sqrt().ceil().max(1.0);
    let step = step as u32;
    let (width, height) = (columns.div_ceil(step), rows.div_ceil(step));
    let mut data = vec![FREE; (width * height) as usize];
    for (x, y, pixel) in picture.enumerate_pixels() {
        let row = (rows - 1 - y) / step;
        let cell = &mut data[(row * width + x / step) as usize];
        *cell = worse(*cell, map.cell(pixel.0[0]));
    }
    if step > 1 {
        tell!(
            "ros2: DDS loses larger messages: {step} × {step} cells of the map are combined into \
             one"
        );
    }
    let [x, y, theta] = map.origin;
    OccupancyGrid {
        header: Header::new(&Time::default(), MAP),
        info: MapMetaData {
            map_load_time: Time::default(),
            resolution: (map.resolution * f64::from(step)) as f32,
            width,
            height,
            origin: Pose::on_ground(x, y, theta),
        },
        data,
    }
}

fn worse(one: i8, other: i8) -> i8 {
    match (one, other) {
        (OCCUPIED, _) | (_, OCCUPIED) => OCCUPIED,
        (UNKNOWN, _) | (_, UNKNOWN) => UNKNOWN,
        _ => FREE,
    }
}

/// Publishes a map for as long as the output is kept.
pub(crate) fn publish(
    grid: OccupancyGrid,
    link: &mut Link,
) -> Result<Output<OccupancyGrid>, LinkError> {
    let mut output = link.output("map", Keep::Newest, CELLS as usize)?;
    output.publish(grid);
    Ok(output)
}

#[cfg(test)]
mod tests {
    use super::*;

    const YAML: &str = "image: a.pgm\nresolution: 0.5\norigin: [1, 2, 0]\nnegate: 0\n";

    #[test]
    fn the_south_comes_first_and_cells_are_put_together() {
        let map = MapFile::parse(YAML).expect("a map");
        // Black, grey, white; then white.
        let picture = GrayImage::from_raw(3, 2, vec![0, 140, 255, 255, 255, 255]).expect("pixels");
        let small = grid(&map, &picture);
        assert_eq!(small.data, [0, 0, 0, 100, -1, 0]);
        assert_eq!((small.info.width, small.info.height, small.info.resolution), (3, 2, 0.5));
        let mut picture = GrayImage::from_pixel(1_001, 500, [255].into());
        picture.put_pixel(1_000, 0, [0].into());
        let large = grid(&map, &picture);
        assert_eq!((large.info.width, large.info.height, large.info.resolution), (501, 250, 1.0));
        assert_eq!(large.data.iter().map(|cell| i32::from(*cell)).sum::<i32>(), 100);
        assert_eq!(large.data[249 * 501 + 500], 100);
    }

    #[test]
    fn a_shipped_map_is_read_and_wrong_ones_are_named() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../graphs/imported/ros-map/turtlebot3_world.yaml");
        let grid = read(&path).expect("a map");
        assert_eq!(grid.data.len(), (grid.info.width * grid.info.height) as usize);
        assert!(grid.data.contains(&100) && grid.data.contains(&0));
        for (text, message) in [
            ("image: a.pgm\nresolution: 0\norigin: [0, 0, 0]\n", "0.001 to 10"),
            ("image: a.pgm\nresolution: 1\norigin: [0]\n", "x, y and an angle"),
            ("resolution: 1\norigin: [0, 0, 0]\n", "`image` is missing"),
        ] {
            let error = MapFile::parse(text).err().expect("wrong");
            assert!(error.reason.contains(message), "{}", error.reason);
        }
    }
}
