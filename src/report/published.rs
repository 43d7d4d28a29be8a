//! The values that the dissertation published in its tables 5.1, 5.3 and 5.5 to 5.7.

/// A pose: x and y in metres, θ in degrees.
pub type Pose = [f64; 3];

/// A route of tables 5.1 and 5.3, with the end pose that the dissertation's system reached and the
/// wanted end pose.
pub struct EndPose {
    pub route: &'static [u32],
    pub simulated: Pose,
    pub wanted: Pose,
}

const fn row(route: &'static [u32], simulated: Pose, wanted: Pose) -> EndPose {
    EndPose { route, simulated, wanted }
}

/// The rows of tables 5.1 (single edges) and 5.3 (routes).
pub const END_POSES: &[EndPose] = &[
    row(&[45], [13.00, 13.55, 90.03], [13.00, 13.50, 90.0]),
    row(&[34], [-5.01, -8.02, -180.0], [-5.0, -8.0, -180.0]),
    row(&[16], [28.99, -15.54, -90.0], [29.00, -15.5, -90.0]),
    row(&[12], [26.97, 17.51, 180.0], [27.00, 17.50, 180.0]),
    row(&[11], [16.51, 10.47, -180.0], [16.52, 10.47, -180.0]),
    row(&[13], [12.97, 17.50, 180.0], [12.99, 17.50, 180.0]),
    row(&[23], [35.01, 18.50, 0.005], [35.00, 18.50, 0.0]),
    row(&[31], [36.14, 29.99, 90.03], [36.14, 29.94, 90.0]),
    row(&[29], [17.16, 23.35, 90.03], [17.16, 23.34, 90.0]),
    row(&[27], [-5.02, -8.00, -180.0], [-5.00, -8.00, -180.0]),
    row(&[34, 45], [13.01, 13.55, 90.03], [13.00, 13.50, 90.03]),
    row(&[13, 34], [-5.03, -8.01, -180.0], [-5.00, -8.00, -180.0]),
    row(&[23, 16], [29.00, -15.51, -90.0], [29.00, -15.5, -90.0]),
    row(&[11, 13, 34], [-5.033, -8.01, -180.0], [-5.00, -8.00, -180.0]),
    row(&[23, 16, 12, 11], [16.49, 10.47, -180.0], [16.52, 10.47, -180.0]),
    row(&[29, 31], [36.14, 29.94, 90.03], [36.14, 29.94, 90.03]),
    row(&[23, 16, 12, 11, 13], [12.98, 17.50, 180.0], [12.99, 17.50, 180.0]),
    row(&[23, 16, 12, 11, 13, 34, 45], [13.01, 13.55, 90.03], [13.00, 13.5, 90.03]),
];

/// The average success rates of x, y and θ in per cent: of single edges, then of routes.
pub const AVERAGE_RATES: [Pose; 2] = [[99.90, 99.91, 99.98], [99.79, 99.87, 99.99]];

/// The seconds until all robots have driven a route, for each of [`FLEET_SIZES`] (tables 5.5 to
/// 5.7).
pub struct Duration {
    pub route: &'static [u32],
    pub secs: [f64; 4],
}

/// The fleet sizes of tables 5.5 to 5.7.
pub const FLEET_SIZES: [u32; 4] = [1, 10, 20, 30];

/// The rows of tables 5.5 to 5.7.
pub const DURATIONS: &[Duration] = &[
    Duration { route: &[23, 16, 12], secs: [15.57, 16.58, 31.58, 66.56] },
    Duration { route: &[84, 85], secs: [10.31, 11.06, 19.76, 43.07] },
    Duration { route: &[64, 65], secs: [10.05, 11.07, 19.82, 43.49] },
];

/// Returns the success rate of equation 5.1 in per cent, or `None` if the wanted value is 0, where
/// the formula has no value. Angles that differ by whole turns are equal.
pub fn success_rate(simulated: f64, wanted: f64, is_angle: bool) -> Option<f64> {
    let difference = simulated - wanted;
    let error = if is_angle { (difference + 180.0).rem_euclid(360.0) - 180.0 } else { difference };
    (wanted != 0.0).then(|| (1.0 - (error / wanted).abs()) * 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_formula_reproduces_the_published_averages() {
        let (edges, routes) = END_POSES.split_at(10);
        for (rows, published) in [(edges, AVERAGE_RATES[0]), (routes, AVERAGE_RATES[1])] {
            for (column, published) in published.into_iter().take(2).enumerate() {
                let rates = rows.iter().map(|row| {
                    success_rate(row.simulated[column], row.wanted[column], false).unwrap()
                });
                let mean = rates.sum::<f64>() / rows.len() as f64;
                assert!(
                    (mean - published).abs() < 0.06,
                    "column {column}: {mean} instead of {published}"
                );
            }
        }
    }

    #[test]
    fn half_turns_in_either_direction_are_equal() {
        assert_eq!(success_rate(180.0, -180.0, true), Some(100.0));
        assert_eq!(success_rate(0.005, 0.0, true), None);
    }
}
