//! The exact curve, sampled and integrated independently of the code under test.

use glam::DVec2;
use regatta_base::bezier::CubicBezier;

/// A point of the exact curve.
pub struct ExactPoint {
    /// The arc length from the curve's start in metres.
    pub s: f64,
    pub position: DVec2,
    pub tangent: DVec2,
    /// The radius of curvature in metres; less near a point where the curve stops.
    pub radius: f64,
}

/// Samples the curve in steps that shrink where |p'| is small, integrating |p'| by Simpson's rule.
pub fn sample(curve: &CubicBezier, steps: u32) -> Vec<ExactPoint> {
    let steps = if cfg!(miri) { steps.min(60) } else { steps };
    let finest = if cfg!(miri) { 20 } else { 160 };
    let speed = |lambda: f64| curve.derivative(lambda).length();
    let mut cuts: Vec<f64> = (0..=steps).map(|i| f64::from(i) / f64::from(steps)).collect();
    // Geometrically finer towards both ends and towards the minima of |p'|.
    let slowest = (1..steps as usize)
        .filter(|&i| speed(cuts[i]) <= speed(cuts[i - 1]) && speed(cuts[i]) <= speed(cuts[i + 1]))
        .map(|i| minimise(speed, cuts[i - 1], cuts[i + 1]))
        .collect::<Vec<_>>();
    for centre in slowest.into_iter().chain([0.0, 1.0]) {
        let offsets = (0..finest).map(|i| 0.8_f64.powi(i) / f64::from(steps));
        cuts.extend(offsets.flat_map(|offset| [centre - offset, centre + offset]).chain([centre]));
    }
    cuts.retain(|cut| (0.0..=1.0).contains(cut));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let mut s = 0.0;
    let mut previous = 0.0;
    let exact = cuts.into_iter().map(|lambda| {
        s += simpson(&speed, previous, lambda);
        previous = lambda;
        let (first, second) = (curve.derivative(lambda), curve.second_derivative(lambda));
        let radius = first.length().powi(3) / first.perp_dot(second).abs();
        // The distance to a point where the curve stops; the radius of curvature is meaningless
        // there.
        let distance_to_stop = first.length_squared() / second.length();
        let radius = radius.min(distance_to_stop);
        ExactPoint {
            s,
            position: curve.position(lambda),
            tangent: first.normalize_or_zero(),
            radius,
        }
    });
    exact.collect()
}

fn simpson(speed: &impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    const PANELS: u32 = 4;
    let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(2 * PANELS);
    let panel = |i: u32| speed(at(2 * i)) + 4.0 * speed(at(2 * i + 1)) + speed(at(2 * i + 2));
    (0..PANELS).map(panel).sum::<f64>() * (to - from) / f64::from(6 * PANELS)
}

/// Finds a minimum by ternary search.
fn minimise(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..120 {
        let third = (high - low) / 3.0;
        if value(low + third) < value(high - third) { high -= third } else { low += third }
    }
    (low + high) / 2.0
}
