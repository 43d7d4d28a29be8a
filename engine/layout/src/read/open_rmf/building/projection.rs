//! Transverse Mercator projections of the ellipsoid of WGS 84, from degrees on the globe to metres
//! on a plane.

use glam::DVec2;

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
