//! Tests that colours can be distinguished with any colour vision. Vision is simulated as by
//! Machado, Oliveira and Fernandes (2009) for a complete lack of one kind of cones; the distance is
//! that of CIE 1976, in which 20 is a plain difference.

use glam::{Mat3, Vec3};

use super::*;

const LEAST: f32 = 20.0;

/// Normal vision, protanopia, deuteranopia and tritanopia, on linear colours; by columns.
fn visions() -> [Mat3; 4] {
    let rows = |rows: [[f32; 3]; 3]| Mat3::from_cols_array_2d(&rows).transpose();
    [
        Mat3::IDENTITY,
        rows([
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ]),
        rows([
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ]),
        rows([
            [1.255_528, -0.076_749, -0.178_779],
            [-0.078_411, 0.930_809, 0.147_602],
            [0.004_733, 0.691_367, 0.303_9],
        ]),
    ]
}

/// The colour in CIE L*a*b* under daylight.
fn lab(linear: Vec3) -> Vec3 {
    let xyz_from = Mat3::from_cols_array_2d(&[
        [0.412_4 / 0.950_47, 0.212_6, 0.019_3 / 1.088_83],
        [0.357_6 / 0.950_47, 0.715_2, 0.119_2 / 1.088_83],
        [0.180_5 / 0.950_47, 0.072_2, 0.950_5 / 1.088_83],
    ]);
    let xyz = xyz_from * linear.clamp(Vec3::ZERO, Vec3::ONE);
    let [x, y, z] =
        xyz.to_array().map(|t| if t > 0.008_856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 });
    Vec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// The smallest distance of two colours for any vision.
fn distance(one: Rgb, other: Rgb) -> f32 {
    let apart = |vision: Mat3| lab(vision * one.linear()).distance(lab(vision * other.linear()));
    visions().map(apart).into_iter().fold(f32::INFINITY, f32::min)
}

fn assert_apart(named: &[(String, Rgb)]) {
    for (i, (name, colour)) in named.iter().enumerate() {
        for (other_name, other) in &named[..i] {
            let distance = distance(*colour, *other);
            assert!(distance >= LEAST, "{name} and {other_name}: {distance:.1}");
        }
    }
}

#[test]
fn categories_are_told_apart_with_any_colour_vision() {
    for theme in [Theme::Dark, Theme::Light] {
        for scale in [states(theme), activities(theme), collisions(theme)] {
            let Scale::Categories(mut categories) = scale else { panic!("categories") };
            categories.push(("the floor".to_owned(), theme.colours().floor));
            assert_apart(&categories);
        }
    }
}

#[test]
fn activities_are_told_apart_from_heat_and_routes_with_any_colour_vision() {
    for theme in [Theme::Dark, Theme::Light] {
        for activity in Activity::ALL {
            let colour = theme.activity_colour(activity);
            let route = distance(colour, theme.colours().route);
            assert!(route >= 12.0, "{theme:?}: {} and routes: {route:.1}", activity.name());
            for heat in heat_ramp(theme) {
                // A ramp passes between many colours, and robots have edges.
                let heat = distance(colour, heat);
                assert!(heat >= 7.0, "{theme:?}: {} and heat: {heat:.1}", activity.name());
            }
            // Most roads are cold: the ramp's low end is not to look like robots.
            let least = if theme == Theme::Dark { 0.10 } else { 0.075 };
            for (step, heat) in heat_ramp(theme).into_iter().enumerate() {
                let apart = oklab(colour).distance(oklab(heat));
                let name = activity.name();
                assert!(apart >= least, "{theme:?}: {name} and step {step} of heat: {apart:.3}");
            }
        }
    }
}

#[test]
fn lines_are_told_apart_with_any_colour_vision() {
    for theme in [Theme::Dark, Theme::Light] {
        let colours = theme.colours();
        let lines = [
            ("route", colours.route),
            ("waiting", colours.waiting),
            ("ring", colours.ring),
            ("floor", colours.floor),
        ];
        assert_apart(&lines.map(|(name, colour)| (name.to_owned(), colour)));
    }
}

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
        let steps: Vec<f32> = colours.windows(2).map(|pair| pair[0].distance(pair[1])).collect();
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

#[test]
fn ramps_increase_in_lightness() {
    let scale = Scale::Ramp { low: 0.0, high: 1.0, unit: "" };
    let lightness = scale
        .colours(Theme::Dark)
        .map(|colour| colour.linear().dot(Vec3::new(0.2126, 0.7152, 0.0722)));
    assert!(lightness.is_sorted(), "{lightness:?}");
}

#[test]
fn colourings_are_parsed_as_they_are_printed() {
    for text in ["state", "speed", "type", "collision", "battery"] {
        assert_eq!(text.parse::<Colouring>().unwrap().to_string(), text);
    }
    assert!("no such/name".parse::<Colouring>().is_err());
}
