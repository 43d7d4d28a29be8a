//! Distributions of times.
//!
//! ```yaml
//! dwell: 8                                        # always this
//! dwell: {min: 5, max: 15}                        # uniform
//! dwell: {min: 5, mode: 7, max: 20}               # triangular
//! dwell: {mean: 12, sd: 3}                        # normal, cut at 0, or at min and max if given
//! dwell: {mean: 12, sd: 9, shape: lognormal}      # likewise cut at min and max if given
//! dwell: {samples: [6.2, 7.0, 7.0, 31.5]}         # measured ones, each with the same probability
//! ```
//!
//! Numbers are drawn with basic operations and the functions of `libm` only, so that they have the
//! same bits on every machine.

use std::f64::consts::TAU;
use std::sync::Arc;

use regatta_base::ln;
use regatta_base::random::Random;
use regatta_base::yaml::{self, Fields, Node};

/// The number of draws after which a value outside of the bounds is moved to the nearer one.
const MOST_DRAWS: u64 = 1_000;

/// A distribution of times in seconds, none of them negative.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Distribution {
    Uniform {
        min: f64,
        max: f64,
    },
    Triangular {
        min: f64,
        mode: f64,
        max: f64,
    },
    Normal {
        mean: f64,
        deviation: f64,
        bounds: Bounds,
    },
    /// The exponential of a normal distribution.
    Lognormal {
        mean_of_log: f64,
        deviation_of_log: f64,
        bounds: Bounds,
    },
    /// One of these, which are at least one.
    Samples(Arc<[f64]>),
}

/// The bounds at which a distribution is cut: values outside are drawn again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    min: f64,
    max: f64,
}

/// No time at all.
impl Default for Distribution {
    fn default() -> Self {
        Self::Uniform { min: 0.0, max: 0.0 }
    }
}

impl Distribution {
    /// Reads a distribution.
    pub(super) fn read(value: &Node) -> Result<Self, yaml::Error> {
        if !value.is_map() {
            return value.non_negative().map(|secs| Self::Uniform { min: secs, max: secs });
        }
        let fields = value.fields(&["min", "mode", "max", "mean", "sd", "shape", "samples"])?;
        let given: Vec<&str> = fields.pairs().iter().map(|(key, _)| key.as_ref()).collect();
        if given.contains(&"samples") {
            only(value, &given, &["samples"])?;
            return samples(fields.required("samples")?);
        }
        if given.contains(&"mean") || given.contains(&"sd") {
            only(value, &given, &["mean", "sd", "shape", "min", "max"])?;
            return around_mean(value, &fields);
        }
        only(value, &given, &["min", "mode", "max"])?;
        between(value, &fields)
    }

    /// Returns a time in seconds. The same draw gives the same time.
    pub(super) fn secs(&self, random: Random, draw: u64) -> f64 {
        match self {
            Self::Uniform { min, max } => min + (max - min) * random.unit(draw),
            Self::Triangular { min, mode, max } => triangular(*min, *mode, *max, random.unit(draw)),
            Self::Normal { mean, deviation, bounds } => {
                bounds.cut(random.part(draw), |normal| mean + deviation * normal)
            }
            Self::Lognormal { mean_of_log, deviation_of_log, bounds } => bounds
                .cut(random.part(draw), |normal| {
                    libm::exp(mean_of_log + deviation_of_log * normal)
                }),
            Self::Samples(samples) => samples[random.below(draw, samples.len())],
        }
    }

    /// Whether all times are 0.
    pub(super) fn is_zero(&self) -> bool {
        match self {
            Self::Uniform { max, .. } | Self::Triangular { max, .. } => *max == 0.0,
            Self::Normal { bounds, .. } | Self::Lognormal { bounds, .. } => bounds.max == 0.0,
            Self::Samples(samples) => samples.iter().all(|secs| *secs == 0.0),
        }
    }
}

impl Bounds {
    /// Draws values of a standard normal number until one is within the bounds.
    fn cut(self, random: Random, value: impl Fn(f64) -> f64) -> f64 {
        let mut last = 0.0;
        for draw in 0..MOST_DRAWS {
            last = value(standard_normal(random.part(draw)));
            if (self.min..=self.max).contains(&last) {
                break;
            }
        }
        last.clamp(self.min, self.max)
    }
}

/// Returns a normally distributed number with mean 0 and standard deviation 1 (Box and Muller,
/// Annals of Mathematical Statistics 29, 1958).
fn standard_normal(random: Random) -> f64 {
    (-2.0 * ln(random.unit(0))).sqrt() * libm::cos(TAU * random.unit(1))
}

/// Returns the value of a triangular distribution below which a part of all values is.
fn triangular(min: f64, mode: f64, max: f64, part: f64) -> f64 {
    let (rise, width) = (mode - min, max - min);
    if part * width <= rise {
        min + (part * width * rise).sqrt()
    } else {
        max - ((1.0 - part) * width * (max - mode)).sqrt()
    }
}

/// Refuses keys of another kind of distribution.
fn only(value: &Node, given: &[&str], of_kind: &[&str]) -> Result<(), yaml::Error> {
    match given.iter().find(|key| !of_kind.contains(key)) {
        None => Ok(()),
        Some(key) => Err(value.error(format!(
            "`{key}` doesn't belong to a distribution with `{}`; give min and max, min, mode and \
             max, mean and sd, or samples",
            given.iter().find(|key| of_kind.contains(key)).unwrap_or(key)
        ))),
    }
}

fn between(value: &Node, fields: &Fields<'_, '_>) -> Result<Distribution, yaml::Error> {
    let min = fields.required("min")?.non_negative()?;
    let max = fields.required("max")?.non_negative()?;
    if min > max {
        return Err(value.error("`min` is above `max`"));
    }
    let Some(mode) = fields.optional("mode", Node::non_negative)? else {
        return Ok(Distribution::Uniform { min, max });
    };
    if !(min..=max).contains(&mode) {
        return Err(value.error("`mode` isn't between `min` and `max`"));
    }
    Ok(Distribution::Triangular { min, mode, max })
}

fn around_mean(value: &Node, fields: &Fields<'_, '_>) -> Result<Distribution, yaml::Error> {
    let mean = fields.required("mean")?.non_negative()?;
    let deviation = fields.required("sd")?.non_negative()?;
    let min = fields.optional("min", Node::non_negative)?.unwrap_or(0.0);
    let max = fields.optional("max", Node::non_negative)?.unwrap_or(f64::MAX);
    if !(min..=max).contains(&mean) {
        return Err(value.error("`mean` isn't between `min` and `max`"));
    }
    let bounds = Bounds { min, max };
    let Some(shape) = fields.get("shape") else {
        return Ok(Distribution::Normal { mean, deviation, bounds });
    };
    match shape.text()?.as_ref() {
        "normal" => Ok(Distribution::Normal { mean, deviation, bounds }),
        "lognormal" if mean > 0.0 => {
            let relative = deviation / mean;
            let variance_of_log = ln(1.0 + relative * relative);
            Ok(Distribution::Lognormal {
                mean_of_log: ln(mean) - variance_of_log / 2.0,
                deviation_of_log: variance_of_log.sqrt(),
                bounds,
            })
        }
        "lognormal" => Err(value.error("the mean of a lognormal distribution is above 0")),
        other => {
            Err(shape.error(format!("unknown shape `{other}`; there are normal and lognormal")))
        }
    }
}

fn samples(value: &Node) -> Result<Distribution, yaml::Error> {
    let mut samples = Vec::new();
    for sample in value.list()? {
        samples.push(sample.non_negative()?);
    }
    if samples.is_empty() {
        return Err(value.error("there are no samples"));
    }
    Ok(Distribution::Samples(samples.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Distribution, String> {
        let document = yaml::parse(text).map_err(|error| error.to_string())?;
        Distribution::read(&document).map_err(|error| error.to_string())
    }

    /// The mean and the standard deviation of many draws, and all of them in ascending order.
    fn draws(text: &str) -> (f64, f64, Vec<f64>) {
        let distribution = read(text).expect("a distribution");
        let random = Random::new(5);
        let mut all: Vec<f64> =
            (0..200_000).map(|draw| distribution.secs(random.part(draw), 3)).collect();
        all.sort_by(f64::total_cmp);
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let squares = all.iter().map(|secs| (secs - mean) * (secs - mean)).sum::<f64>();
        (mean, (squares / all.len() as f64).sqrt(), all)
    }

    /// The value below which a part of the draws are.
    fn quantile(all: &[f64], part: f64) -> f64 {
        all[(part * all.len() as f64) as usize]
    }

    #[test]
    fn means_and_deviations_are_those_of_the_textbook() {
        let (mean, deviation, all) = draws("{min: 5, max: 15}");
        assert!((mean - 10.0).abs() < 0.03 && (deviation - 10.0 / 12_f64.sqrt()).abs() < 0.02);
        assert!(all[0] >= 5.0 && all[all.len() - 1] <= 15.0);
        // (a + b + c) / 3, and (a² + b² + c² − ab − ac − bc) / 18.
        let (mean, deviation, all) = draws("{min: 5, mode: 7, max: 20}");
        assert!((mean - 32.0 / 3.0).abs() < 0.03, "{mean}");
        assert!((deviation - (199.0_f64 / 18.0).sqrt()).abs() < 0.03, "{deviation}");
        assert!((quantile(&all, 2.0 / 15.0) - 7.0).abs() < 0.06);
        let (mean, deviation, _) = draws("{mean: 60, sd: 5}");
        assert!((mean - 60.0).abs() < 0.05 && (deviation - 5.0).abs() < 0.05);
        let (mean, deviation, all) = draws("{mean: 12, sd: 9, shape: lognormal}");
        assert!((mean - 12.0).abs() < 0.1 && (deviation - 9.0).abs() < 0.2, "{mean} {deviation}");
        // The median is mean / √(1 + sd² / mean²).
        assert!((quantile(&all, 0.5) - 9.6).abs() < 0.1);
    }

    #[test]
    fn a_cut_distribution_keeps_its_shape_within_the_bounds() {
        // Cut at its mean: the half-normal distribution, with mean √(2 / π).
        let (mean, _, all) = draws("{mean: 10, sd: 4, min: 10}");
        assert!((mean - 10.0 - 4.0 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 0.03, "{mean}");
        assert!(all[0] >= 10.0);
        let (_, _, all) = draws("{mean: 1, sd: 5}");
        assert!(all[0] >= 0.0, "no negative times");
        let (mean, deviation, _) = draws("{mean: 7, sd: 0}");
        assert_eq!((mean, deviation), (7.0, 0.0));
    }

    #[test]
    fn samples_have_the_same_probability() {
        let (mean, _, all) = draws("{samples: [4, 4, 10]}");
        let tens = all.iter().filter(|secs| **secs == 10.0).count();
        assert!((66_000..67_400).contains(&tens), "{tens}");
        assert!((mean - 6.0).abs() < 0.02);
    }

    #[test]
    fn the_first_numbers_are_these_on_every_machine() {
        let bits = |text: &str| {
            let distribution = read(text).expect("a distribution");
            (0..100).fold(0_u64, |hash, draw| {
                let secs = distribution.secs(Random::new(3), draw);
                hash.wrapping_mul(0x100_0000_01b3) ^ secs.to_bits()
            })
        };
        let found = [bits("{mean: 60, sd: 5}"), bits("{mean: 12, sd: 9, shape: lognormal}")];
        assert_eq!(found, GOLDEN);
    }

    const GOLDEN: [u64; 2] = [15_133_508_849_160_658_155, 7_054_535_581_030_214_219];

    #[test]
    fn what_is_no_distribution_is_refused_with_the_reason() {
        for (text, reason) in [
            ("{min: 5}", "`max` is missing"),
            ("{min: 9, max: 5}", "`min` is above `max`"),
            ("{min: 1, mode: 9, max: 5}", "`mode` isn't between"),
            ("{mean: 5}", "`sd` is missing"),
            ("{mean: 5, sd: 1, max: 4}", "`mean` isn't between"),
            ("{mean: 5, sd: 1, shape: gamma}", "unknown shape `gamma`"),
            ("{mean: 0, sd: 1, shape: lognormal}", "above 0"),
            ("{mean: 5, sd: 1, mode: 4}", "`mode` doesn't belong to a distribution with `mean`"),
            ("{samples: []}", "no samples"),
            ("{samples: [1], min: 0}", "`min` doesn't belong to a distribution with `samples`"),
            ("-3", "-3"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
