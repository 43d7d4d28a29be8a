//! The cells of a map.

use std::borrow::Cow;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::DVec2;
use image::{DynamicImage, ImageReader, Limits};
use regatta_base::file;
use regatta_base::yaml::{self, Content, Node};

use crate::read::file::{Ignored, SyntaxError};

/// The largest number of rows and of columns.
const MAX_SIDE: u32 = 8192;

/// The largest memory for the picture in bytes.
const MAX_PICTURE_BYTES: u64 = 1 << 30;

/// The YAML of a map.
#[derive(Debug)]
pub struct MapFile {
    image: PathBuf,
    /// Metres per cell.
    resolution: f64,
    /// x and y of the bottom left corner in metres, and the map's rotation in radians.
    origin: Vec<f64>,
    negate: bool,
    occupied_thresh: f64,
    free_thresh: f64,
    mode: Option<String>,
}

/// The keys of a map that are used.
const KEYS: [&str; 7] =
    ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];

impl MapFile {
    /// Returns the path of the picture of a map in a folder.
    pub fn image(&self, folder: &Path) -> PathBuf {
        folder.join(&self.image)
    }

    /// Reads YAML.
    ///
    /// # Errors
    /// If keys are missing or values out of range.
    pub fn read(text: &str, ignored: &mut Ignored) -> Result<Self, SyntaxError> {
        let map = Self::parse(text, ignored).map_err(|error| {
            SyntaxError::new(error.line, format!("not a map of ROS: {}", error.reason))
        })?;
        map.check().map_err(|message| SyntaxError::new(1, message))?;
        Ok(map)
    }

    fn parse(text: &str, ignored: &mut Ignored) -> Result<Self, yaml::Error> {
        let root = yaml::parse(text)?;
        let fields = root.all_fields()?;
        for (key, value) in fields.pairs().iter().filter(|(key, _)| !KEYS.contains(&key.as_ref())) {
            ignored.add_key(value.offset as u32, key, "the map");
        }
        let origin = fields.required("origin")?.list()?;
        let mode = fields.optional("mode", Node::text)?;
        Ok(Self {
            image: fields.required("image")?.text()?.as_ref().into(),
            resolution: fields.required("resolution")?.number()?,
            origin: origin.iter().map(Node::number).collect::<Result<_, _>>()?,
            negate: fields.optional("negate", truth)?.unwrap_or(false),
            occupied_thresh: fields.optional("occupied_thresh", Node::number)?.unwrap_or(0.65),
            free_thresh: fields.optional("free_thresh", Node::number)?.unwrap_or(0.25),
            mode: mode.map(Cow::into_owned),
        })
    }

    fn check(&self) -> Result<(), String> {
        if !(0.001..=10.0).contains(&self.resolution) {
            return Err(format!(
                "`resolution` is {}: it must be 0.001 to 10 metres per cell",
                self.resolution
            ));
        }
        let finite = self.origin.iter().all(|value| value.is_finite() && value.abs() <= 1e7);
        if !(2..=3).contains(&self.origin.len()) || !finite {
            return Err("`origin` must be x and y in metres and the angle in radians".to_owned());
        }
        let mode = self.mode.as_deref().unwrap_or("trinary").to_ascii_lowercase();
        if !["trinary", "scale", "raw"].contains(&mode.as_str()) {
            return Err(format!(
                "`mode` is `{}`: it must be trinary, scale or raw",
                mode.escape_debug()
            ));
        }
        Ok(())
    }

    /// Returns the state of a cell with a brightness, 0 to 255.
    fn cell(&self, brightness: u8) -> Cell {
        if self.mode.as_deref().is_some_and(|mode| mode.eq_ignore_ascii_case("raw")) {
            // The brightness is the percentage. 101 and above mean unknown.
            return match f64::from(brightness) / 100.0 {
                percentage if percentage > 1.0 => Cell::Unknown,
                percentage => self.state(percentage),
            };
        }
        let darkness = if self.negate { brightness } else { 255 - brightness };
        self.state(f64::from(darkness) / 255.0)
    }

    fn state(&self, occupancy: f64) -> Cell {
        if occupancy > self.occupied_thresh {
            Cell::Occupied
        } else if occupancy < self.free_thresh {
            Cell::Free
        } else {
            Cell::Unknown
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

/// The state of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    Free,
    Occupied,
    Unknown,
}

/// The cells of a map, with a border of unknown cells around them.
#[derive(Debug)]
pub struct Grid {
    /// The columns and rows, the border included.
    pub width: usize,
    pub height: usize,
    /// By row from the bottom, then by column.
    pub cells: Vec<Cell>,
    /// Metres per cell.
    pub resolution: f64,
    origin: DVec2,
    rotation: DVec2,
}

impl Grid {
    /// Reads the picture of a map.
    ///
    /// # Errors
    /// If it can't be read.
    pub fn read(map: &MapFile, folder: &Path) -> Result<Self, String> {
        let path = folder.join(&map.image);
        let picture = read_picture(&path)
            .map_err(|reason| format!("the picture {}: {reason}", path.display()))?;
        Ok(Self::new(map, &picture))
    }

    fn new(map: &MapFile, picture: &DynamicImage) -> Self {
        let (columns, rows) = (picture.width() as usize, picture.height() as usize);
        let (width, height) = (columns + 2, rows + 2);
        let states: Vec<Cell> = (0..=u8::MAX).map(|brightness| map.cell(brightness)).collect();
        let mut cells = vec![Cell::Unknown; width * height];
        let pixels = brightness(picture);
        for (row, pixels) in pixels.chunks_exact(columns.max(1)).enumerate() {
            let start = (rows - row) * width + 1;
            for (cell, pixel) in cells[start..start + columns].iter_mut().zip(pixels) {
                *cell = pixel.map_or(Cell::Unknown, |brightness| states[usize::from(brightness)]);
            }
        }
        let origin = DVec2::new(map.origin[0], map.origin[1]);
        let rotation = DVec2::from_angle(map.origin.get(2).copied().unwrap_or_default());
        Self { width, height, cells, resolution: map.resolution, origin, rotation }
    }

    /// Converts a point in cells from the corner of the border to metres.
    pub fn metres(&self, point: DVec2) -> DVec2 {
        self.origin + self.rotation.rotate((point - DVec2::ONE) * self.resolution)
    }

    pub fn has_few_free_cells(&self) -> bool {
        self.cells.iter().filter(|&&cell| cell == Cell::Free).count() < self.cells.len() / 100
    }
}

fn read_picture(path: &Path) -> Result<DynamicImage, String> {
    // The largest picture without compression is about as large as its memory.
    let file = file::open(path, MAX_PICTURE_BYTES);
    let reader = file.and_then(|file| ImageReader::new(BufReader::new(file)).with_guessed_format());
    let mut reader = reader.map_err(|error| {
        format!("can't be read: {error}; correct `image` in the map's YAML, or add the picture")
    })?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_PICTURE_BYTES);
    reader.limits(limits);
    let picture =
        reader.decode().map_err(|error| format!("can't be read: {error}; PGM and PNG can"))?;
    // Not every decoder observes the limits.
    if picture.width().max(picture.height()) > MAX_SIDE {
        return Err(format!("larger than {MAX_SIDE} × {MAX_SIDE} cells"));
    }
    Ok(picture)
}

/// Returns the mean of the colours of each pixel from the top left; `None` where it is transparent.
fn brightness(picture: &DynamicImage) -> Vec<Option<u8>> {
    match picture {
        DynamicImage::ImageLuma8(grey) => grey.pixels().map(|pixel| Some(pixel.0[0])).collect(),
        other => other.to_rgba8().pixels().map(|pixel| mean(pixel.0)).collect(),
    }
}

fn mean([red, green, blue, alpha]: [u8; 4]) -> Option<u8> {
    let sum = u16::from(red) + u16::from(green) + u16::from(blue);
    (alpha != 0).then_some((sum / 3) as u8)
}
