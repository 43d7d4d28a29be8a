//! The colours of the heat map, from little to much: equal steps of a value are equal steps of
//! colour.
//!
//! Both ramps were computed in OKLab (Björn Ottosson, 2020): lightness is linear, hue goes from
//! violet by red to yellow, and the sixteen colours are at equal distances along that way. Much is
//! what differs most from the floor: bright on a dark floor, dark on a light one.

use super::{COLOURS, Rgb, Theme};

const DARK: [u32; COLOURS] = [
    0x4a237a, 0x622583, 0x7b2687, 0x932687, 0xac2683, 0xc32b7d, 0xd63a76, 0xe8496f, 0xf85a67,
    0xff7365, 0xff8b68, 0xffa26c, 0xffb875, 0xffce81, 0xffe386, 0xf8f8a8,
];
const LIGHT: [u32; COLOURS] = [
    0xeee180, 0xf0cb5d, 0xf2b43b, 0xf39c19, 0xee8401, 0xe66c03, 0xe0520a, 0xd6371f, 0xc71e34,
    0xb50044, 0x9e014f, 0x860055, 0x6f005b, 0x58005c, 0x400059, 0x2a044e,
];

/// Returns the colours of the heat map, from cold to hot.
pub fn heat_ramp(theme: Theme) -> [Rgb; COLOURS] {
    if theme == Theme::Dark { DARK.map(Rgb) } else { LIGHT.map(Rgb) }
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Vec3};

    use super::*;

    /// The conversion from linear sRGB, as published by its author.
    fn oklab(colour: Rgb) -> Vec3 {
        let lms = Mat3::from_cols_array(&[
            0.412_221_46,
            0.211_903_5,
            0.088_302_46,
            0.536_332_55,
            0.680_699_5,
            0.281_718_85,
            0.051_445_995,
            0.107_396_96,
            0.629_978_7,
        ]);
        let lab = Mat3::from_cols_array(&[
            0.210_454_26,
            1.977_998_5,
            0.025_904_037,
            0.793_617_8,
            -2.428_592_2,
            0.782_771_77,
            -0.004_072_047,
            0.450_593_7,
            -0.808_675_77,
        ]);
        lab * Vec3::from((lms * colour.linear()).to_array().map(f32::cbrt))
    }

    #[test]
    fn steps_of_colour_are_equal_and_lightness_changes_in_one_direction() {
        for theme in [Theme::Dark, Theme::Light] {
            let colours = heat_ramp(theme).map(oklab);
            let steps: Vec<f32> =
                colours.windows(2).map(|pair| pair[0].distance(pair[1])).collect();
            let (least, most) = steps
                .iter()
                .fold((f32::MAX, 0.0_f32), |(low, high), step| (low.min(*step), high.max(*step)));
            assert!(most < 1.08 * least, "{theme:?}: from {least} to {most}");
            let lightness = colours.map(|colour| colour.x);
            let rises = lightness.is_sorted();
            assert!(
                rises == (theme == Theme::Dark) && (rises || lightness.iter().rev().is_sorted()),
                "{lightness:?}"
            );
            let floor = oklab(theme.colours().floor);
            let away = colours.map(|colour| colour.distance(floor));
            assert!(away[0] > 0.1 && away[15] > away[0], "{theme:?}: {away:?}");
        }
    }
}
