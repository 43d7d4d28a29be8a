//! A picture in parts of equal size, such as the levels of a building side by side.

use glam::Vec2;

/// Returns into how many columns a picture is best divided for so many parts that show things of
/// some width and height.
pub fn columns(parts: u32, size: Vec2, extent: Vec2) -> u32 {
    let mut best = (0.0, 1);
    for columns in 1..=parts {
        let part = size / Vec2::new(columns as f32, parts.div_ceil(columns) as f32);
        let scale = (part / extent.max(Vec2::splat(0.1))).min_element();
        if scale > best.0 {
            best = (scale, columns);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_as_large_as_possible() {
        let size = Vec2::new(1200.0, 800.0);
        assert_eq!(columns(2, size, Vec2::new(100.0, 10.0)), 1, "wide ones below each other");
        assert_eq!(columns(2, size, Vec2::new(10.0, 100.0)), 2);
        assert_eq!(columns(4, size, Vec2::new(30.0, 20.0)), 2);
        assert_eq!(columns(1, size, Vec2::ZERO), 1);
    }
}
