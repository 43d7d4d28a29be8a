//! The effort of robots: time by activity, and metres with and without a load.

use regatta_plugin::activity::Activity;
use serde_json::{Map, Value, json};

/// The activity of a robot in a frame.
#[derive(Clone, Copy, Debug)]
pub struct Doing {
    /// Its activity.
    pub activity: Activity,
    /// Whether it has an order.
    pub has_order: bool,
    /// Whether it has picked something up, and not dropped the last of it.
    pub is_loaded: bool,
    /// Metres per second.
    pub speed: f32,
}

/// Time and metres of all robots so far.
#[derive(Clone, Debug, Default)]
pub struct Effort {
    /// Robot seconds by activity, in the order of [`Activity::ALL`].
    secs: [f64; Activity::ALL.len()],
    /// Robot seconds with an order.
    ordered_secs: f64,
    loaded_metres: f64,
    empty_metres: f64,
}

impl Effort {
    /// Adds what a robot does for some seconds.
    pub fn add(&mut self, doing: &Doing, secs: f64) {
        self.secs[doing.activity as usize] += secs;
        self.ordered_secs += if doing.has_order { secs } else { 0.0 };
        let metres = f64::from(doing.speed.abs()) * secs;
        *(if doing.is_loaded { &mut self.loaded_metres } else { &mut self.empty_metres }) += metres;
    }

    fn robot_secs(&self) -> f64 {
        self.secs.iter().sum()
    }

    /// The part of the robots' time in which they had an order, from 0 to 1.
    pub fn utilisation(&self) -> f64 {
        ratio(self.ordered_secs, self.robot_secs())
    }

    /// The part of the robots' time that they spent on an activity, from 0 to 1.
    pub fn share(&self, activity: Activity) -> f64 {
        ratio(self.secs[activity as usize], self.robot_secs())
    }

    /// The figures as JSON.
    pub fn json(&self) -> Value {
        let secs = Activity::ALL.map(|activity| {
            (activity.name().replace(' ', "_"), json!(self.secs[activity as usize]))
        });
        json!({
            "robot_secs": Map::from_iter(secs),
            "utilisation": self.utilisation(),
            "loaded_metres": self.loaded_metres,
            "empty_metres": self.empty_metres,
        })
    }

    /// The figures as a table in Markdown.
    pub fn markdown(&self) -> String {
        let metres = self.loaded_metres + self.empty_metres;
        let shares = Activity::ALL.into_iter().filter(|activity| self.share(*activity) > 0.0);
        let shares: Vec<_> = shares
            .map(|activity| format!("{} {:.1} %", activity.name(), 100.0 * self.share(activity)))
            .collect();
        format!(
            "| robots | |\n|---|---|\n| utilisation | {:.1} % |\n| time | {} |\n| driven | {:.1} km, {:.1} % of it empty |\n",
            100.0 * self.utilisation(),
            shares.join(", "),
            metres / 1e3,
            100.0 * ratio(self.empty_metres, metres),
        )
    }
}

fn ratio(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_and_metres_add_up() {
        let mut effort = Effort::default();
        let doing =
            |activity, has_order, is_loaded, speed| Doing { activity, has_order, is_loaded, speed };
        effort.add(&doing(Activity::ToPick, true, false, 2.0), 10.0);
        effort.add(&doing(Activity::Carrying, true, true, -1.0), 40.0);
        effort.add(&doing(Activity::Idle, false, false, 0.0), 50.0);
        assert_eq!((effort.utilisation(), effort.share(Activity::Carrying)), (0.5, 0.4));
        let json = effort.json();
        assert_eq!((&json["loaded_metres"], &json["empty_metres"]), (&json!(40.0), &json!(20.0)));
        assert_eq!(json["robot_secs"]["to_pick"], 10.0);
        let text = effort.markdown();
        assert!(
            text.contains("utilisation | 50.0 %") && text.contains("0.1 km, 33.3 % of it empty"),
            "{text}"
        );
        assert_eq!(Effort::default().utilisation(), 0.0);
    }
}
