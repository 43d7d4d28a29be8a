//! The file of a study.
//!
//! ```yaml
//! plant: ../warehouse.yaml      # a layout of any format, or a scenario
//! robots: 1..1000               # doubling, then refined round the knee; or a list
//! duration: 30min               # simulated time of a run
//! seeds: {least: 3, most: 10}
//! interval: 0.02                # seeds are added at the knee until the 95 % interval is within ± 2 %
//! knee: 0.01                    # one more robot brings less than 1 % of what one brings alone
//! reliefs: 6                    # changes that are tried for a relief
//! targets: ['p99 service < 6min', 'late < 1%']  # asks for the least number of robots that meets them
//! orders: day.csv               # a day's orders in place of the load
//! prices: {currency: EUR, robot_price: 48000}  # and others: the cost of a year and an order
//! vary:                         # every combination is a variant; the first values are what the others are compared with
//!   max_speed: [1.5, 2.0]
//!   planner: [lanes, pibt]
//! ```

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use regatta_scenario::document;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::{Axis, PlanError, Precision, Prices, Robots, Target};

/// A study file. The command line provides the rest.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudyFile {
    /// A layout of any format or a scenario, relative to the study's folder.
    pub plant: PathBuf,
    /// The title of the page; the plant's name by default.
    pub title: Option<String>,
    /// The numbers of robots.
    pub robots: Option<Robots>,
    /// The simulated time of a run: seconds, or a text with a unit.
    pub duration: Option<Value>,
    /// The numbers of seeds.
    #[serde(default)]
    pub seeds: SeedsEntry,
    /// Half of the 95 % interval of the throughput at the knee, as a part of it.
    pub interval: Option<f64>,
    /// The part of a lone robot's throughput that one more robot brings at the knee.
    pub knee: Option<f64>,
    /// The number of changes that are tried for a relief.
    pub reliefs: Option<usize>,
    /// The targets that a fleet must meet.
    #[serde(default)]
    pub targets: Vec<Target>,
    /// A file with a day's orders, relative to the study's folder.
    pub orders: Option<PathBuf>,
    /// Orders for each of the file.
    pub scale: Option<f64>,
    /// The block of which each seed's day is drawn: a time, or `none` for the day as it is.
    pub resample: Option<Value>,
    /// The prices of what is bought and of operation.
    pub prices: Option<Prices>,
    /// Settings and their values. Their order is that of their names.
    #[serde(default)]
    pub vary: BTreeMap<String, Vec<Value>>,
}

/// The numbers of seeds.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeedsEntry {
    /// Of each point.
    pub least: Option<u64>,
    /// Of the point at the knee.
    pub most: Option<u64>,
}

/// The size of the largest study file.
const MAX_STUDY_BYTES: usize = 16 << 20;

/// Whether a text is a study rather than a scenario or a layout. Only studies have the key `plant`.
pub fn is_study(text: &str) -> bool {
    // Only layouts are larger.
    let may_be = text.len() <= MAX_STUDY_BYTES && text.contains("plant");
    let keys = may_be.then(|| document::<BTreeMap<String, IgnoredAny>>(text, Path::new("")));
    keys.is_some_and(|keys| keys.is_ok_and(|keys| keys.contains_key("plant")))
}

impl StudyFile {
    /// Returns the settings and their values.
    ///
    /// # Errors
    /// [`PlanError::Setting`] if a setting is unknown or has no values.
    pub fn axes(&self) -> Result<Vec<Axis>, PlanError> {
        let axes = self.vary.iter().map(|(name, values)| Axis::new(name, values.clone()));
        axes.collect::<Result<_, _>>().map_err(|error| PlanError::setting("vary", error))
    }

    /// Returns the precision of the answer.
    ///
    /// # Errors
    /// [`PlanError::Setting`] if a number is out of range.
    pub fn precision(&self) -> Result<Precision, PlanError> {
        let default = Precision::default();
        let least_seeds = self.seeds.least.unwrap_or(default.least_seeds);
        let most_seeds = self.seeds.most.unwrap_or(default.most_seeds.max(least_seeds));
        if least_seeds < 2 || most_seeds < least_seeds {
            return Err(PlanError::setting(
                "seeds",
                "give at least 2 as `least`, and no less than that as `most`",
            ));
        }
        Ok(Precision {
            least_seeds,
            most_seeds,
            interval: part("interval", self.interval.unwrap_or(default.interval))?,
            knee: part("knee", self.knee.unwrap_or(default.knee))?,
            ..default
        })
    }
}

fn part(name: &str, value: f64) -> Result<f64, PlanError> {
    if value > 0.0 && value < 1.0 {
        return Ok(value);
    }
    Err(PlanError::setting(name, format!("{value}: give a part, above 0 and below 1")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_is_told_from_a_scenario_and_a_layout() {
        assert!(is_study("plant: a.yaml\nrobots: 1..10\n"));
        for text in
            ["graph: plant.yaml\nrobots: []\n", "Edges: []\n# plant\n", "id,x\nplant,1\n", ""]
        {
            assert!(!is_study(text), "{text}");
        }
    }

    #[test]
    fn a_file_says_what_is_wrong_with_it() {
        let read = |text: &str| {
            document::<StudyFile>(text, Path::new("s.yaml")).map_err(|error| error.to_string())
        };
        let file = read(
            "plant: a.yaml\nrobots: [5, 3]\nseeds: {least: 4}\nvary: {planner: [lanes, pibt]}\n",
        )
        .expect("a study");
        assert_eq!(file.robots, Some(Robots::List(vec![3, 5])));
        let precision = file.precision().expect("a precision");
        assert_eq!(
            (precision.least_seeds, precision.most_seeds, precision.interval),
            (4, 10, 0.02)
        );
        assert_eq!(file.axes().expect("axes").len(), 1);
        for (text, reason) in [
            ("plant: a\nrobot: 3\n", "robot"),
            ("plant: a\nrobots: 9..1\n", "9..1"),
            ("robots: 1..2\n", "plant"),
            ("plant: a\ntargets: [p98 service < 3min]\n", "no known figure"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(reason) && !error.contains('\n'), "{error}");
        }
        for text in ["plant: a\nseeds: {least: 1}\n", "plant: a\ninterval: 2\n"] {
            assert!(read(text).expect("a study").precision().is_err(), "{text}");
        }
    }
}
