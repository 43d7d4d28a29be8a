//! Badges of stations in drawings: discs with a sign for the work of robots there. Pictures of the
//! viewer have the same ones (`stations.wgsl`).

use std::f64::consts::TAU;

use glam::{DVec2, dvec2};

use crate::svg::Svg;

/// The width of a badge's rim, in radii.
const RIM: f64 = 0.16;
/// The corners of a triangle that points up, in radii, with y upwards.
const TRIANGLE: [DVec2; 3] = [dvec2(0.0, 0.6), dvec2(-0.5, -0.4), dvec2(0.5, -0.4)];
/// The triangles of a transfer station: their scale, and their distance from the centre.
const SMALL: f64 = 1.0 / 1.8;
const APART: f64 = 0.3;
/// The stem of a P, and the centre, the radius and the width of its bow.
const STEM: [DVec2; 2] = [dvec2(-0.22, -0.5), dvec2(-0.22, 0.5)];
const BOW: DVec2 = dvec2(0.02, 0.2);
const BOW_RADIUS: f64 = 0.28;
const P_WIDTH: f64 = 0.23;
/// The number of parts of the bow, and the part of a turn that it takes to either side.
const BOW_PARTS: i32 = 12;
const BOW_TURN: f64 = 0.415;
/// The corners of a flash, and its width.
const FLASH: [DVec2; 4] =
    [dvec2(0.14, 0.6), dvec2(-0.22, -0.02), dvec2(0.22, 0.04), dvec2(-0.14, -0.6)];
const FLASH_WIDTH: f64 = 0.2;

/// The sign of a badge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sign {
    /// None: a station without a role.
    #[default]
    None,
    /// Robots pick loads up: a triangle that points up.
    Pick,
    /// Robots drop loads: a triangle that points down.
    Drop,
    /// Robots park: a P.
    Park,
    /// Robots charge: a flash.
    Charge,
    /// Robots pick loads up and drop them: both triangles.
    Transfer,
}

/// The drawing of a badge.
#[derive(Clone, Copy, Debug)]
pub struct Badge<'a> {
    /// The radius.
    pub radius: f64,
    /// The colour of the disc.
    pub paper: &'a str,
    /// The colour of the rim and of the sign.
    pub ink: &'a str,
    /// Whether y of the picture is upwards.
    pub is_y_up: bool,
}

impl Badge<'_> {
    /// Draws a badge with a tooltip.
    pub fn draw(&self, svg: &mut Svg, centre: DVec2, sign: Sign, tooltip: &str) {
        svg.element("g").open();
        svg.element("title").content(tooltip);
        let disc = svg.circle(centre, self.radius * (1.0 - RIM / 2.0)).fill(self.paper);
        disc.stroke(self.ink, self.radius * RIM);
        match sign {
            Sign::None => {}
            Sign::Pick => self.areas(svg, centre, [TRIANGLE]),
            Sign::Drop => self.areas(svg, centre, [TRIANGLE.map(mirrored)]),
            Sign::Transfer => {
                let up = TRIANGLE.map(|corner| corner * SMALL + APART * DVec2::Y);
                self.areas(svg, centre, [up, up.map(mirrored)]);
            }
            Sign::Park => {
                let bow = (-BOW_PARTS..=BOW_PARTS).map(|part| {
                    let turn = TAU * BOW_TURN * f64::from(part) / f64::from(BOW_PARTS);
                    BOW + BOW_RADIUS * DVec2::from_angle(turn)
                });
                self.lines(svg, centre, P_WIDTH, [STEM.to_vec(), bow.collect()]);
            }
            Sign::Charge => self.lines(svg, centre, FLASH_WIDTH, [FLASH.to_vec()]),
        }
        svg.close();
    }

    fn areas<const N: usize>(&self, svg: &mut Svg, centre: DVec2, areas: [[DVec2; 3]; N]) {
        let areas = areas.map(|corners| corners.map(|corner| self.place(centre, corner)));
        svg.element("path").fill(self.ink).polygons(areas);
    }

    fn lines<const N: usize>(
        &self,
        svg: &mut Svg,
        centre: DVec2,
        width: f64,
        lines: [Vec<DVec2>; N],
    ) {
        let lines = lines.map(|line| line.into_iter().map(|point| self.place(centre, point)));
        let path = svg.element("path").fill("none").stroke(self.ink, self.radius * width);
        path.polylines(lines);
    }

    /// The place of a point of a sign.
    fn place(&self, centre: DVec2, point: DVec2) -> DVec2 {
        let point = if self.is_y_up { point } else { mirrored(point) };
        centre + self.radius * point
    }
}

/// A point with up and down exchanged.
fn mirrored(point: DVec2) -> DVec2 {
    point * dvec2(1.0, -1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(sign: Sign, is_y_up: bool) -> String {
        let mut svg = Svg::new(1);
        let badge = Badge { radius: 10.0, paper: "#fff", ink: "#000", is_y_up };
        badge.draw(&mut svg, dvec2(20.0, 20.0), sign, "Dock <1>");
        svg.finish()
    }

    #[test]
    fn each_sign_has_a_shape_of_its_own() {
        let signs = [Sign::None, Sign::Pick, Sign::Drop, Sign::Park, Sign::Charge, Sign::Transfer];
        let badges = signs.map(|sign| drawn(sign, false));
        for (index, badge) in badges.iter().enumerate() {
            assert!(badge.contains("<title>Dock &lt;1&gt;</title>"), "{badge}");
            assert!(badge.contains("<circle cx=\"20.0\" cy=\"20.0\" r=\"9.2\""), "{badge}");
            assert!(!badges[..index].contains(badge), "{badge}");
        }
    }

    #[test]
    fn a_pick_points_up_in_either_picture() {
        let path = "<path fill=\"#000\" d=\"M20.0 ";
        for (is_y_up, y) in [(false, "14.0"), (true, "26.0")] {
            let badge = drawn(Sign::Pick, is_y_up);
            assert!(badge.contains(&format!("{path}{y}")), "{badge}");
        }
        assert!(drawn(Sign::Drop, false).contains(&format!("{path}26.0")));
    }
}
