//! Texts that a browser shows while the pointer is on a part of a plot.

use regatta_base::grouped;
use regatta_base::svg::escape;

/// A text for an area of a plot.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hint {
    /// The left upper corner, in pixels.
    pub corner: (i32, i32),
    /// The width and the height, in pixels.
    pub size: (i32, i32),
    /// The text.
    pub text: String,
}

/// The half of the width of the area of a point, in pixels.
const HALF: i32 = 8;

impl Hint {
    /// Returns the hint of a point.
    pub fn of_point((x, y): (i32, i32), text: String) -> Self {
        Self { corner: (x - HALF, y - HALF), size: (2 * HALF, 2 * HALF), text }
    }
}

/// Adds hints to a plot: areas that can't be seen, on top of all else.
pub(super) fn add_hints(svg: &mut String, hints: &[Hint]) {
    let Some(end) = svg.rfind("</svg>") else { return };
    let mut areas = String::new();
    for Hint { corner: (x, y), size: (width, height), text } in hints {
        areas += &format!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
             fill-opacity=\"0\"><title>{}</title></rect>\n",
            escape(text)
        );
    }
    svg.insert_str(end, &areas);
}

/// A value with three digits or so.
pub(super) fn value(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        ..10.0 => format!("{value:.2}"),
        ..100.0 => format!("{value:.1}"),
        _ => grouped(value, 0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hints_are_in_the_picture_and_escaped() {
        let mut svg = "<svg>\n</svg>\n".to_owned();
        add_hints(&mut svg, &[Hint::of_point((20, 30), "a < b: 3".to_owned())]);
        let area = "<rect x=\"12\" y=\"22\" width=\"16\" height=\"16\" fill-opacity=\"0\">";
        assert_eq!(svg, format!("<svg>\n{area}<title>a &lt; b: 3</title></rect>\n</svg>\n"));
        assert_eq!([0.0, 0.123, 12.34, 1234.5].map(value), ["0", "0.12", "12.3", "1,234"]);
    }
}
