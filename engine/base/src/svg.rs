//! SVG, written element by element.
//!
//! ```
//! use glam::DVec2;
//! use regatta_base::svg::Svg;
//!
//! let mut svg = Svg::new(1);
//! svg.document(DVec2::new(40.0, 20.0), "mm").set("font-size", 3).open();
//! svg.element("g").stroke("#30363d", 0.5).open();
//! let roof = [(0.0, 0.0), (20.0, 9.96), (40.0, 0.0)];
//! svg.element("path").polylines([roof]);
//! svg.close();
//! svg.text(DVec2::new(20.0, 15.0)).fill("#000").content("A & B");
//! let picture = r##"<g stroke="#30363d" stroke-width="0.50">
//! <path d="M0.0 0.0L20.0 10.0L40.0 0.0"/>
//! </g>
//! <text x="20.0" y="15.0" fill="#000">A &amp; B</text>
//! </svg>
//! "##;
//! assert!(svg.finish().ends_with(picture));
//! ```

use std::fmt::{Display, Write as _};

use glam::DVec2;
pub use quick_xml::escape::escape;
use quick_xml::escape::partial_escape;

/// A picture that is being written. Positions and lengths are in units of its view box, with x to
/// the right and y down.
#[derive(Clone, Debug)]
pub struct Svg {
    /// The number of decimals of positions and lengths that are written from now on.
    pub decimals: usize,
    text: String,
    open: Vec<&'static str>,
}

impl Svg {
    /// Creates an empty picture, whose positions and lengths get so many decimals.
    pub fn new(decimals: usize) -> Self {
        Self { decimals, text: String::new(), open: Vec::new() }
    }

    /// Begins the element `svg` of a picture from (0, 0) to `size`. The width and the height are in
    /// `unit`, which is empty for pixels.
    pub fn document(&mut self, size: impl Into<DVec2>, unit: &str) -> Element<'_> {
        let (DVec2 { x, y }, decimals) = (size.into(), self.decimals);
        self.element("svg")
            .set("xmlns", "http://www.w3.org/2000/svg")
            .set("viewBox", format_args!("0 0 {x:.decimals$} {y:.decimals$}"))
            .set("width", format_args!("{x:.decimals$}{unit}"))
            .set("height", format_args!("{y:.decimals$}{unit}"))
    }

    /// Begins an element.
    pub fn element(&mut self, name: &'static str) -> Element<'_> {
        self.text.push('<');
        self.text.push_str(name);
        Element { svg: self, name, end: "/>\n" }
    }

    /// Begins a circle.
    pub fn circle(&mut self, centre: impl Into<DVec2>, radius: impl Into<f64>) -> Element<'_> {
        self.element("circle").point("cx", "cy", centre).number("r", radius)
    }

    /// Begins a rectangle, given its left upper corner.
    pub fn rect(&mut self, corner: impl Into<DVec2>, size: impl Into<DVec2>) -> Element<'_> {
        self.element("rect").point("x", "y", corner).point("width", "height", size)
    }

    /// Writes a rectangle that fills the picture.
    pub fn background(&mut self, colour: impl Display) {
        self.element("rect").set("width", "100%").set("height", "100%").fill(colour);
    }

    /// Begins a straight line.
    pub fn line(&mut self, from: impl Into<DVec2>, to: impl Into<DVec2>) -> Element<'_> {
        self.element("line").point("x1", "y1", from).point("x2", "y2", to)
    }

    /// Begins a text at a position, which [`Element::content`] writes.
    pub fn text(&mut self, at: impl Into<DVec2>) -> Element<'_> {
        self.element("text").point("x", "y", at)
    }

    /// Ends the element that was opened last.
    pub fn close(&mut self) {
        if let Some(name) = self.open.pop() {
            self.text.extend(["</", name, ">\n"]);
        }
    }

    fn push_line(&mut self, points: impl IntoIterator<Item = impl Into<DVec2>>) {
        for (index, point) in points.into_iter().enumerate() {
            self.push(if index == 0 { "M" } else { "L" }, point, " ");
        }
    }

    fn push(&mut self, before: &str, point: impl Into<DVec2>, separator: &str) {
        let (DVec2 { x, y }, decimals) = (point.into(), self.decimals);
        // Writing to a String never fails.
        let _ = write!(self.text, "{before}{x:.decimals$}{separator}{y:.decimals$}");
    }

    /// Ends all open elements, and returns the text.
    pub fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }
}

/// An element that is being written. It is empty, unless [`open`](Self::open) or
/// [`content`](Self::content) ends it.
#[derive(Debug)]
pub struct Element<'a> {
    svg: &'a mut Svg,
    name: &'static str,
    /// The text that ends the tag.
    end: &'static str,
}

impl Element<'_> {
    /// Writes an attribute, escaped.
    pub fn set(self, name: &str, value: impl Display) -> Self {
        let value = value.to_string();
        self.svg.text.extend([" ", name, "=\"", &escape(&value), "\""]);
        self
    }

    /// Writes an attribute that is a length, with the decimals of the picture.
    pub fn number(self, name: &str, value: impl Into<f64>) -> Self {
        let (value, decimals) = (value.into(), self.svg.decimals);
        self.set(name, format_args!("{value:.decimals$}"))
    }

    /// Writes the two attributes of a position or a size.
    pub fn point(self, x: &str, y: &str, point: impl Into<DVec2>) -> Self {
        let point = point.into();
        self.number(x, point.x).number(y, point.y)
    }

    /// Writes the names of classes in a style sheet.
    pub fn class(self, names: &str) -> Self {
        self.set("class", names)
    }

    /// Writes the colour of the area.
    pub fn fill(self, colour: impl Display) -> Self {
        self.set("fill", colour)
    }

    /// Writes the colour and the width of lines, the latter with one more decimal than positions.
    pub fn stroke(self, colour: impl Display, width: impl Into<f64>) -> Self {
        let (width, decimals) = (width.into(), self.svg.decimals + 1);
        self.set("stroke", colour).set("stroke-width", format_args!("{width:.decimals$}"))
    }

    /// Writes the points of a `polyline` or a `polygon`.
    pub fn points(self, points: impl IntoIterator<Item = impl Into<DVec2>>) -> Self {
        self.list("points", |svg| {
            for (index, point) in points.into_iter().enumerate() {
                svg.push(if index == 0 { "" } else { " " }, point, ",");
            }
        })
    }

    /// Writes the lines of a `path`, each through its points.
    pub fn polylines<L: IntoIterator<Item: Into<DVec2>>>(
        self,
        lines: impl IntoIterator<Item = L>,
    ) -> Self {
        self.list("d", |svg| {
            for line in lines {
                svg.push_line(line);
            }
        })
    }

    /// Writes the areas of a `path`, each with its corners.
    pub fn polygons<L: IntoIterator<Item: Into<DVec2>>>(
        self,
        areas: impl IntoIterator<Item = L>,
    ) -> Self {
        self.list("d", |svg| {
            for area in areas {
                svg.push_line(area);
                svg.text.push('Z');
            }
        })
    }

    /// Writes the lines of a `path`, each of cubic Bézier curves, which are given by their control
    /// points and begin where the one before ends.
    pub fn curves<P: Into<DVec2>, L: IntoIterator<Item = [P; 4]>>(
        self,
        lines: impl IntoIterator<Item = L>,
    ) -> Self {
        self.list("d", |svg| {
            for line in lines {
                for (index, [a, b, c, d]) in line.into_iter().enumerate() {
                    if index == 0 {
                        svg.push_line([a]);
                    }
                    svg.push("C", b, " ");
                    svg.push(" ", c, " ");
                    svg.push(" ", d, " ");
                }
            }
        })
    }

    fn list(self, name: &str, write: impl FnOnce(&mut Svg)) -> Self {
        self.svg.text.extend([" ", name, "=\""]);
        write(self.svg);
        self.svg.text.push('"');
        self
    }

    /// Ends the start tag. What is written next is in the element, until [`Svg::close`] ends it.
    pub fn open(mut self) {
        self.end = ">\n";
        self.svg.open.push(self.name);
    }

    /// Ends the element with a text as its content, which is escaped.
    pub fn content(mut self, text: impl Display) {
        self.svg.text.extend([">", &partial_escape(text.to_string()), "</", self.name]);
        self.end = ">\n";
    }
}

impl Drop for Element<'_> {
    fn drop(&mut self) {
        self.svg.text.push_str(self.end);
    }
}
