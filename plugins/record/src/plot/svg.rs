//! Writes the shapes of a plot as SVG.

use std::fmt::Write;

/// A point in pixels from the top left corner.
pub(super) type Point = (f64, f64);

/// A rectangle in pixels.
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
}

/// The writer of a picture. `class` arguments name classes of [`STYLE`].
pub(super) struct Svg {
    text: String,
    clips: usize,
}

const STYLE: &str = "
text { font-family: 'Inter', 'Helvetica Neue', Helvetica, Arial, 'DejaVu Sans', sans-serif; font-size: 12px; fill: #52606d; }
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
.path { stroke: #0072b2; stroke-width: 3; fill: none; stroke-linejoin: round; stroke-linecap: round; }
.time { fill: #fff; stroke: #0072b2; stroke-width: 1.5; }
.end { fill: #d55e00; stroke: #fff; stroke-width: 1.5; stroke-linejoin: round; }
.start { fill: #009e73; stroke: #fff; stroke-width: 1.5; }
";

impl Svg {
    pub fn new((width, height): Point) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\">\n<style>{STYLE}</style>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#fbfcfd\"/>\n"
        );
        Self { text, clips: 0 }
    }

    pub fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    fn push(&mut self, arguments: std::fmt::Arguments<'_>) {
        self.text.write_fmt(arguments).expect("writing to a String never fails");
        self.text.push('\n');
    }

    pub fn text(&mut self, (x, y): Point, class: &str, text: &str) {
        let text = regatta_kit::escape_xml(text);
        self.push(format_args!("<text x=\"{x:.1}\" y=\"{y:.1}\" class=\"{class}\">{text}</text>"));
    }

    pub fn rect(&mut self, area: Area, class: &str) {
        let Area { left, top, .. } = area;
        let (width, height) = (area.width(), area.height());
        self.push(format_args!(
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" class=\"{class}\"/>"
        ));
    }

    /// Draws a rectangle that is filled with the given colour.
    pub fn bar(&mut self, area: Area, colour: &str) {
        let Area { left, top, .. } = area;
        let (width, height) = (area.width(), area.height());
        self.push(format_args!(
            "<rect x=\"{left:.2}\" y=\"{top:.1}\" width=\"{width:.2}\" height=\"{height:.1}\" fill=\"{colour}\"/>"
        ));
    }

    pub fn line(&mut self, from: Point, to: Point, class: &str) {
        let [(x1, y1), (x2, y2)] = [from, to];
        self.push(format_args!(
            "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" class=\"{class}\"/>"
        ));
    }

    /// Draws a line through the points with an additional CSS style. Leaves out points that make no
    /// visible difference.
    pub fn polyline(&mut self, points: &[Point], class: &str, style: &str) {
        let points = simplified(points, 0.15);
        let points: Vec<_> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        self.push(format_args!(
            "<polyline points=\"{}\" class=\"{class}\" style=\"{style}\"/>",
            points.join(" ")
        ));
    }

    /// Draws a cubic Bézier curve.
    pub fn curve(&mut self, [a, b, c, d]: [Point; 4], class: &str) {
        let part = |(x, y): Point| format!("{x:.1} {y:.1}");
        let (a, b, c, d) = (part(a), part(b), part(c), part(d));
        self.push(format_args!("<path d=\"M{a}C{b} {c} {d}\" class=\"{class}\"/>"));
    }

    pub fn circle(&mut self, (x, y): Point, radius: f64, class: &str) {
        self.push(format_args!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" class=\"{class}\"/>"
        ));
    }

    /// Draws an arrow head that points to `theta`, in radians, counter-clockwise from east.
    pub fn arrow(&mut self, (x, y): Point, theta: f64, class: &str) {
        let turn = -theta.to_degrees();
        self.push(format_args!(
            "<path d=\"M11 0L-7 7L-3 0L-7 -7Z\" transform=\"translate({x:.1} {y:.1}) rotate({turn:.1})\" class=\"{class}\"/>"
        ));
    }

    /// Calls `draw` and clips its shapes to an area.
    pub fn clipped(&mut self, area: Area, draw: impl FnOnce(&mut Self)) {
        self.clips += 1;
        let id = self.clips;
        self.push(format_args!("<clipPath id=\"c{id}\">"));
        self.rect(area, "panel");
        self.push(format_args!("</clipPath><g clip-path=\"url(#c{id})\">"));
        draw(self);
        self.push(format_args!("</g>"));
    }
}

/// Returns the points that approximate a line within `tolerance` (the algorithm of Ramer, Douglas
/// and Peucker).
fn simplified(points: &[Point], tolerance: f64) -> Vec<Point> {
    let mut keep = vec![false; points.len()];
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    (keep[0], keep[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((first, last)) = open.pop() {
        let between = first + 1..last;
        let far = |i: usize| distance(points[i], points[first], points[last]);
        let Some(farthest) = between.max_by(|a, b| far(*a).total_cmp(&far(*b))) else { continue };
        if far(farthest) > tolerance {
            keep[farthest] = true;
            open.extend([(first, farthest), (farthest, last)]);
        }
    }
    points.iter().zip(keep).filter(|(_, keep)| *keep).map(|(point, _)| *point).collect()
}

/// Returns a point's distance from a line segment.
fn distance(point: Point, from: Point, to: Point) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (px, py) = (point.0 - from.0, point.1 - from.1);
    let along = ((px * dx + py * dy) / (dx * dx + dy * dy).max(1e-12)).clamp(0.0, 1.0);
    (px - along * dx).hypot(py - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simplified_line_keeps_its_shape() {
        let line: Vec<_> =
            (0..1000).map(|i| (f64::from(i), (f64::from(i) / 100.0).sin() * 50.0)).collect();
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
        assert_eq!(simplified(&[], 1.0), []);
        assert_eq!(simplified(&[(1.0, 2.0)], 1.0), [(1.0, 2.0)]);
    }

    #[test]
    fn text_is_escaped() {
        let mut svg = Svg::new((10.0, 10.0));
        svg.text((0.0, 0.0), "about", "a<b & c");
        assert!(svg.finish().contains("a&lt;b &amp; c"));
    }
}
