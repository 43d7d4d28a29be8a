//! The shapes of a plot as SVG, and SVG as pixels.

use std::sync::Arc;

use glam::DVec2;
use regatta_base::svg::{Element, Svg};
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

/// A rectangle in pixels from the top left corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Area {
    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    /// Begins a rectangle of this area.
    pub fn rect<'s>(&self, svg: &'s mut Svg) -> Element<'s> {
        svg.rect(DVec2::new(self.left, self.top), DVec2::new(self.width(), self.height()))
    }
}

/// The classes of elements.
const STYLE: &str = "
text {
  font-family: 'Inter', 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif;
  font-size: 12px; fill: #52606d;
}
.title { font-size: 26px; font-weight: 600; fill: #1f2933; }
.about { font-size: 13px; fill: #7b8794; }
.name { font-size: 13px; font-weight: 600; fill: #3e4c59; }
.right { text-anchor: end; }
.centre { text-anchor: middle; }
.mark { font-size: 11px; fill: #1f2933; }
.halo { fill: none; stroke: #fff; stroke-width: 3px; stroke-linejoin: round; }
.panel { fill: #fff; stroke: none; }
.grid { stroke: #e9edf1; stroke-width: 1; fill: none; }
.frame { stroke: #cbd2d9; stroke-width: 1; fill: none; }
.edge { stroke: #d5dbe1; stroke-width: 2; fill: none; stroke-linecap: round; }
.line { stroke-width: 1.6; fill: none; stroke-linejoin: round; stroke-linecap: round; }
.path {
  stroke: #0072b2; stroke-width: 3; fill: none; stroke-linejoin: round; stroke-linecap: round;
}
.time { fill: #fff; stroke: #0072b2; stroke-width: 1.5; }
.end { fill: #d55e00; stroke: #fff; stroke-width: 1.5; stroke-linejoin: round; }
.start { fill: #009e73; stroke: #fff; stroke-width: 1.5; }
";

/// Begins a plot of a size in pixels.
pub(super) fn begin(size: DVec2) -> Svg {
    let mut svg = Svg::new(0);
    svg.document(size, "").open();
    svg.decimals = 1;
    svg.element("style").content(STYLE);
    svg.background("#fbfcfd");
    svg
}

/// Draws a line through the points. Leaves out points that make no visible difference.
pub(super) fn polyline<'s>(svg: &'s mut Svg, points: &[DVec2], class: &str) -> Element<'s> {
    svg.element("polyline").points(simplified(points, 0.15)).class(class)
}

/// Draws an arrow head that points to `theta`, in radians, counter-clockwise from east.
pub(super) fn arrow(svg: &mut Svg, DVec2 { x, y }: DVec2, theta: f64, class: &str) {
    let turn = -theta.to_degrees();
    svg.element("path")
        .set("d", "M11 0L-7 7L-3 0L-7 -7Z")
        .set("transform", format_args!("translate({x:.1} {y:.1}) rotate({turn:.1})"))
        .class(class);
}

/// Returns the points that approximate a line within `tolerance` (the algorithm of Ramer, Douglas
/// and Peucker).
fn simplified(points: &[DVec2], tolerance: f64) -> Vec<DVec2> {
    let mut keep = vec![false; points.len()];
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    (keep[0], keep[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((first, last)) = open.pop() {
        let (mut farthest, mut largest) = (first, tolerance);
        for i in first + 1..last {
            let distance = distance(points[i], points[first], points[last]);
            if distance >= largest {
                (farthest, largest) = (i, distance);
            }
        }
        if largest > tolerance {
            keep[farthest] = true;
            open.extend([(first, farthest), (farthest, last)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(point, _)| *point).collect()
}

/// Returns a point's distance from a line segment.
fn distance(point: DVec2, from: DVec2, to: DVec2) -> f64 {
    let (segment, offset) = (to - from, point - from);
    let along = (offset.dot(segment) / segment.length_squared().max(1e-12)).clamp(0.0, 1.0);
    offset.distance(along * segment)
}

/// Pixels of the PNG per pixel of the SVG, so that text is sharp on a screen of high resolution.
const SCALE: f32 = 2.0;

/// Returns the picture of an SVG text as PNG, at twice its size. Text is drawn with the same font
/// on all machines.
///
/// # Errors
/// Returns the reason if the text isn't SVG, or the picture is empty or too large.
pub fn png(svg: &str) -> Result<Vec<u8>, String> {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
    let family = fonts.faces().flat_map(|face| face.families.clone()).map(|(name, _)| name).next();
    if let Some(family) = family {
        fonts.set_sans_serif_family(family);
    }
    let options = Options { fontdb: Arc::new(fonts), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|error| error.to_string())?;
    let size = tree.size().to_int_size().scale_by(SCALE).ok_or("the picture is empty")?;
    let mut pixels = Pixmap::new(size.width(), size.height()).ok_or("the picture is too large")?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels.encode_png().map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simplified_line_keeps_its_shape() {
        let line: Vec<_> = (0..1000)
            .map(|i| DVec2::new(f64::from(i), (f64::from(i) / 100.0).sin() * 50.0))
            .collect();
        let simple = simplified(&line, 0.15);
        assert!(
            simple.len() < 200 && simple[0] == line[0] && simple[simple.len() - 1] == line[999]
        );
        for point in &line {
            let nearest = simple
                .windows(2)
                .map(|pair| distance(*point, pair[0], pair[1]))
                .fold(f64::MAX, f64::min);
            assert!(nearest <= 0.15, "{nearest}");
        }
        assert_eq!(simplified(&[], 1.0), [DVec2::ZERO; 0]);
        assert_eq!(simplified(&[DVec2::ONE], 1.0), [DVec2::ONE]);
    }

    #[test]
    fn text_is_escaped() {
        let mut svg = begin(DVec2::splat(10.0));
        svg.text(DVec2::ZERO).class("about").content("a<b & c");
        assert!(svg.finish().contains("a&lt;b &amp; c"));
    }

    /// Returns the number of pixels that aren't white.
    fn drawn(svg: &str) -> usize {
        let picture = Pixmap::decode_png(&png(svg).unwrap()).unwrap();
        assert_eq!((picture.width(), picture.height()), (80, 40));
        picture
            .pixels()
            .iter()
            .filter(|pixel| (pixel.red(), pixel.green(), pixel.blue()) != (255, 255, 255))
            .count()
    }

    fn svg(content: &str) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"20\">\
             <style>text {{ font-family: Helvetica, sans-serif; font-size: 12px; }}</style>\
             <rect width=\"40\" height=\"20\" fill=\"#fff\"/>{content}</svg>"
        )
    }

    #[test]
    fn shapes_and_text_are_drawn() {
        assert_eq!(drawn(&svg("")), 0);
        assert_eq!(drawn(&svg("<rect x=\"1\" y=\"1\" width=\"10\" height=\"5\"/>")), 200);
        for letter in ["θ", "x", "−", "°", "·"] {
            assert!(
                drawn(&svg(&format!("<text x=\"2\" y=\"15\">{letter}</text>"))) > 3,
                "{letter}"
            );
        }
    }
}
