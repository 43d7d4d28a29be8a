//! Transforms from the coordinates of a building map to metres, and transverse Mercator projections
//! of the ellipsoid of WGS 84, from degrees on the globe to metres on a plane.

use std::collections::BTreeMap;

use glam::DVec2;

use super::{Tree, parameter, plain, point};
use crate::model::finding::Report;
use crate::model::value::shorten;
use crate::read::file::SyntaxError;

/// The relative difference between measurements of a level that gives a warning.
const SPREAD: f64 = 0.05;

/// The coordinate system of a map.
#[derive(Clone, Copy, Debug)]
pub(super) enum CoordinateSystem {
    /// Pixels of a picture, y down.
    ReferenceImage,
    /// Metres, y up.
    CartesianMeters,
    /// Degrees: longitude, latitude.
    Wgs84(Projection),
}

impl CoordinateSystem {
    pub fn of(
        root: &Tree<'_>,
        levels: &[(&str, &Tree<'_>)],
        report: &mut Report<'_>,
    ) -> Result<Self, SyntaxError> {
        let name = root.text_of("coordinate_system").unwrap_or_default();
        match name.as_str() {
            "" | "reference_image" => Ok(Self::ReferenceImage),
            "cartesian_meters" => Ok(Self::CartesianMeters),
            "wgs84" => Ok(Self::Wgs84(projection(root, levels, report))),
            other => {
                let message = format!(
                    "the coordinate system `{}` can't be read: use reference_image, \
                     cartesian_meters or wgs84, or read the navigation graph that \
                     building_map_generator makes of the map",
                    shorten(other)
                );
                let at = root.get("coordinate_system").map_or(0, |tree| tree.at);
                Err(SyntaxError::new(report.line(at) as usize, message))
            }
        }
    }
}

/// Returns the projection that the map names, or one around its first vertex.
fn projection(
    root: &Tree<'_>,
    levels: &[(&str, &Tree<'_>)],
    report: &mut Report<'_>,
) -> Projection {
    let name = parameter(root, "generate_crs").unwrap_or_default();
    if let Some(projection) = Projection::by_name(&name) {
        return projection;
    }
    let mut vertices = levels.iter().flat_map(|(_, level)| level.items_of("vertices"));
    let centre = vertices.find_map(|vertex| point(vertex.items())).unwrap_or_default();
    let message = format!(
        "the map projection `{}` isn't known (EPSG:3414 and UTM, EPSG:326NN and EPSG:327NN, are): \
         positions are in metres from the first vertex",
        shorten(&name)
    );
    report.file_warning(root.get("parameters").map_or(0, |tree| tree.at), message);
    Projection::around(centre)
}

/// A rotation, a scale and a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Similarity {
    rotation: DVec2,
    scale: f64,
    translation: DVec2,
}

impl Similarity {
    fn scale(scale: f64) -> Self {
        Self { rotation: DVec2::X, scale, translation: DVec2::ZERO }
    }

    fn apply(&self, point: DVec2) -> DVec2 {
        self.rotation.rotate(point) * self.scale + self.translation
    }

    /// Returns the transform that takes the second point of each pair to about `reference_scale`
    /// times the first: mean bearing, mean scale, mean translation. `None` for fewer than two
    /// different pairs.
    fn from_pairs(pairs: &[[DVec2; 2]], reference_scale: f64) -> Option<Self> {
        let (mut turn, mut relative, mut count) = (DVec2::ZERO, 0.0, 0.0);
        for (index, one) in pairs.iter().enumerate() {
            for other in pairs.iter().skip(index + 1) {
                let [reference, target] = [other[0] - one[0], other[1] - one[1]];
                let (reference_distance, target_distance) = (reference.length(), target.length());
                if reference_distance == 0.0 || target_distance == 0.0 {
                    continue;
                }
                turn += DVec2::from_angle(reference.to_angle() - target.to_angle());
                relative += target_distance / reference_distance;
                count += 1.0;
            }
        }
        let rotation = turn.try_normalize()?;
        let relative = relative / count;
        let offsets = pairs.iter().map(|pair| pair[0] - rotation.rotate(pair[1] / relative));
        let translation = offsets.sum::<DVec2>() * (reference_scale / pairs.len() as f64);
        Some(Self { rotation, scale: reference_scale / relative, translation })
    }
}

/// The transforms of all levels.
#[derive(Debug)]
pub(super) struct Transforms {
    system: CoordinateSystem,
    /// By index of the level, for pictures only.
    levels: Vec<Similarity>,
}

/// The largest number of fiducials of a level, all pairs of which are compared.
const MAX_FIDUCIALS: usize = 300;

impl Transforms {
    pub fn new(
        root: &Tree<'_>,
        levels: &[(&str, &Tree<'_>)],
        system: CoordinateSystem,
        report: &mut Report<'_>,
    ) -> Self {
        if !matches!(system, CoordinateSystem::ReferenceImage) {
            return Self { system, levels: Vec::new() };
        }
        let name = root.text_of("reference_level_name");
        let named = name.and_then(|name| levels.iter().position(|(level, _)| *level == name));
        let reference = named.unwrap_or_default();
        let Some((name, tree)) = levels.get(reference) else {
            return Self { system, levels: Vec::new() };
        };
        let scale = measured_scale(name, tree, report).unwrap_or_else(|| {
            let message =
                format!("level `{name}` has no measurements: one pixel is read as one metre");
            report.file_warning(tree.at, message);
            1.0
        });
        let fiducials = fiducials(tree);
        let others = levels.iter().enumerate().map(|(index, (name, level))| {
            if index == reference {
                Similarity::scale(scale)
            } else {
                aligned(name, level, &fiducials, scale, report)
            }
        });
        Self { system, levels: others.collect() }
    }

    /// Returns a point of a level in metres.
    pub fn apply(&self, level: usize, point: DVec2) -> DVec2 {
        match self.system {
            CoordinateSystem::CartesianMeters => point,
            CoordinateSystem::Wgs84(projection) => projection.apply(point),
            CoordinateSystem::ReferenceImage => {
                let point = DVec2::new(point.x, -point.y);
                self.levels.get(level).map_or(point, |transform| transform.apply(point))
            }
        }
    }
}

/// Returns the transform of a level to the reference level, by the fiducials of both.
fn aligned(
    name: &str,
    level: &Tree<'_>,
    reference: &BTreeMap<String, DVec2>,
    scale: f64,
    report: &mut Report<'_>,
) -> Similarity {
    let own = fiducials(level);
    let pairs: Vec<[DVec2; 2]> =
        reference.iter().filter_map(|(name, at)| Some([*at, *own.get(name)?])).collect();
    let has_lanes = !level.items_of("lanes").is_empty();
    let measured = measured_scale(name, level, report);
    if let Some(transform) = Similarity::from_pairs(&pairs, scale) {
        if let Some(measured) =
            measured.filter(|measured| (measured / transform.scale - 1.0).abs() > SPREAD)
        {
            let message = format!(
                "level `{name}` is {:.5} m per pixel by its fiducials, which are used, but \
                 {measured:.5} by its measurements",
                transform.scale
            );
            report.file_warning(level.at, message);
        }
        return transform;
    }
    if has_lanes {
        let message = format!(
            "level `{name}` has {} fiducials in common with the reference level, 2 are needed: it \
             isn't aligned with it",
            pairs.len()
        );
        report.file_warning(level.at, message);
    }
    Similarity::scale(measured.unwrap_or(scale))
}

fn fiducials(level: &Tree<'_>) -> BTreeMap<String, DVec2> {
    level.items_of("fiducials").iter().take(MAX_FIDUCIALS).filter_map(fiducial).collect()
}

/// Returns the name and the position of a fiducial.
fn fiducial(tree: &Tree<'_>) -> Option<(String, DVec2)> {
    let point = point(tree.items())?;
    Some((tree.items().get(2)?.text()?, DVec2::new(point.x, -point.y)))
}

/// Returns the scale of a measurement in metres per pixel.
fn scale(measurement: &Tree<'_>, vertices: &[Tree<'_>]) -> Option<f64> {
    let [start, end, map, ..] = measurement.items() else { return None };
    let [start, end] = [start, end].map(|end| point(vertices.get(end.index()?)?.items()));
    let distance: f64 = map.get("distance").and_then(plain)?.parse().ok()?;
    let scale = distance / start?.distance(end?);
    (scale.is_finite() && scale > 0.0).then_some(scale)
}

/// Returns the mean scale of the measurements of a level in metres per pixel.
fn measured_scale(name: &str, level: &Tree<'_>, report: &mut Report<'_>) -> Option<f64> {
    let vertices = level.items_of("vertices");
    let measurements = level.items_of("measurements");
    let scales: Vec<f64> =
        measurements.iter().filter_map(|measurement| scale(measurement, vertices)).collect();
    if scales.len() < measurements.len() {
        let message = format!(
            "{} measurements of level `{name}` have no length: not used",
            measurements.len() - scales.len()
        );
        report.file_warning(level.at, message);
    }
    let mean = scales.iter().sum::<f64>() / scales.len() as f64;
    let (least, most) = scales.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), scale| {
        (least.min(*scale), most.max(*scale))
    });
    if most > least * (1.0 + SPREAD) {
        let message = format!(
            "the measurements of level `{name}` disagree: {least:.5} to {most:.5} m per pixel; \
             the mean is used, {mean:.5}"
        );
        report.file_warning(level.at, message);
    }
    mean.is_finite().then_some(mean)
}

/// The equatorial radius in metres and the flattening of WGS 84.
const RADIUS: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// A transverse Mercator projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Projection {
    /// Longitude and latitude of the natural origin in degrees.
    origin: DVec2,
    /// The scale on the central meridian.
    scale: f64,
    /// The coordinates of the natural origin in metres: easting, northing.
    offset: DVec2,
}

impl Projection {
    /// Returns the projection of a coordinate system such as `EPSG:32632`.
    pub fn by_name(name: &str) -> Option<Self> {
        let (authority, code) = name.trim().split_once(':')?;
        if !authority.eq_ignore_ascii_case("epsg") {
            return None;
        }
        match code.trim().parse::<u32>().ok()? {
            // SVY21, Singapore.
            3414 => Some(Self {
                origin: DVec2::new(103.0 + 50.0 / 60.0, 1.0 + 22.0 / 60.0),
                scale: 1.0,
                offset: DVec2::new(28_001.642, 38_744.572),
            }),
            code @ 32601..=32660 => Some(Self::utm(code - 32600, 0.0)),
            code @ 32701..=32760 => Some(Self::utm(code - 32700, 10_000_000.0)),
            _ => None,
        }
    }

    /// Returns a projection to metres from a point in degrees.
    pub fn around(origin: DVec2) -> Self {
        Self { origin, scale: 1.0, offset: DVec2::ZERO }
    }

    fn utm(zone: u32, northing: f64) -> Self {
        let origin = DVec2::new(f64::from(zone) * 6.0 - 183.0, 0.0);
        Self { origin, scale: 0.9996, offset: DVec2::new(500_000.0, northing) }
    }

    /// Returns the easting and northing in metres of a longitude and latitude in degrees.
    pub fn apply(&self, degrees: DVec2) -> DVec2 {
        let plane = krueger(degrees.x - self.origin.x, degrees.y) - krueger(0.0, self.origin.y);
        self.offset + plane * self.scale
    }
}

/// Krüger's series to the fourth power of the third flattening. Its error is below a millimetre
/// within thousands of kilometres of the meridian.
fn krueger(longitude: f64, latitude: f64) -> DVec2 {
    let (lambda, phi) = (longitude.to_radians(), latitude.to_radians());
    let n = FLATTENING / (2.0 - FLATTENING);
    let eccentricity = 2.0 * n.sqrt() / (1.0 + n);
    let sine = phi.sin();
    let t = (sine.atanh() - eccentricity * (eccentricity * sine).atanh()).sinh();
    let (xi, eta) = (t.atan2(lambda.cos()), (lambda.sin() / t.hypot(lambda.cos())).asinh());
    let radius = RADIUS / (1.0 + n) * (1.0 + n.powi(2) / 4.0 + n.powi(4) / 64.0);
    let alpha = [
        n / 2.0 - 2.0 / 3.0 * n.powi(2) + 5.0 / 16.0 * n.powi(3) + 41.0 / 180.0 * n.powi(4),
        13.0 / 48.0 * n.powi(2) - 3.0 / 5.0 * n.powi(3) + 557.0 / 1440.0 * n.powi(4),
        61.0 / 240.0 * n.powi(3) - 103.0 / 140.0 * n.powi(4),
        49561.0 / 161_280.0 * n.powi(4),
    ];
    let series = alpha.iter().zip([2.0, 4.0, 6.0, 8.0]).map(|(alpha, k)| {
        DVec2::new((k * xi).cos() * (k * eta).sinh(), (k * xi).sin() * (k * eta).cosh()) * *alpha
    });
    (DVec2::new(eta, xi) + series.sum::<DVec2>()) * radius
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utm_agrees_with_published_coordinates() {
        // The CN Tower: 43°38′33.24″ N, 79°23′13.7″ W is 17T 630084 4833438 (rounded to metres).
        let tower =
            DVec2::new(-(79.0 + 23.0 / 60.0 + 13.7 / 3600.0), 43.0 + 38.0 / 60.0 + 33.24 / 3600.0);
        let projection = Projection::by_name("EPSG:32617").expect("a zone");
        assert!(projection.apply(tower).distance(DVec2::new(630_084.0, 4_833_438.0)) < 1.5);
        assert_eq!(Projection::by_name("EPSG:3857"), None);
    }
}
