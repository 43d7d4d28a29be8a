//! Draws an SVG picture as pixels.

use std::sync::Arc;

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

/// Pixels of the PNG per pixel of the SVG, so that text is sharp on a screen of high resolution.
const SCALE: f32 = 2.0;

/// Returns the picture of an SVG text as PNG, at twice its size. Text is drawn with the same font
/// on all machines.
///
/// # Errors
/// If the text isn't SVG, or the picture is empty or too large.
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
