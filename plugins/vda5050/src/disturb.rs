//! Disturbances of a virtual fleet, as a seed draws them: a master has to bear them.

use core::str::FromStr;

use regatta_base::random::Random;
use strum::{EnumString, IntoStaticStr, VariantNames};

/// The shortest and the longest time that a disturbance lasts, in seconds.
const SHORTEST_SECS: f64 = 10.0;
const LONGEST_SECS: f64 = 60.0;

/// A kind of disturbance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, EnumString, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Kind {
    /// Actions of orders fail: a share of them.
    FailedActions,
    /// New orders are refused: a share of them.
    RefusedOrders,
    /// Messages with quality of service 0 are lost, either way: a share of them.
    LostMessages,
    /// Messages come twice, either way: a share of them.
    DoubledMessages,
    /// Messages come late, either way: by so many seconds in the mean.
    Delay,
    /// A vehicle loses its connection: so often an hour.
    LostConnections,
    /// An operator drives a vehicle: so often an hour.
    ManualMode,
    /// A vehicle stops for its safety devices: so often an hour.
    EmergencyStops,
    /// A vehicle doesn't know where it is: so often an hour.
    LostPositions,
}

/// The unit of the value of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Share,
    Secs,
    PerHour,
}

impl Kind {
    const fn unit(self) -> Unit {
        match self {
            Self::FailedActions
            | Self::RefusedOrders
            | Self::LostMessages
            | Self::DoubledMessages => Unit::Share,
            Self::Delay => Unit::Secs,
            Self::LostConnections
            | Self::ManualMode
            | Self::EmergencyStops
            | Self::LostPositions => Unit::PerHour,
        }
    }
}

/// A disturbance and how often it comes, as `KIND=VALUE`: `failed-actions=2%`, `delay=0.5s`,
/// `manual-mode=1/h`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    kind: Kind,
    /// A share from 0 to 1, seconds, or times an hour.
    value: f64,
}

impl FromStr for Disturbance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or("give KIND=VALUE, as in manual-mode=1/h")?;
        let kind = Kind::from_str(name).map_err(|_| {
            format!("unknown kind '{name}'; the kinds are {}", Kind::VARIANTS.join(", "))
        })?;
        let (unit, factor, most, example) = match kind.unit() {
            Unit::Share => ("%", 0.01, 1.0, "2%"),
            Unit::Secs => ("s", 1.0, 60.0, "0.5s"),
            Unit::PerHour => ("/h", 1.0, 3600.0, "1/h"),
        };
        let number: Option<f64> = value.strip_suffix(unit).and_then(|text| text.parse().ok());
        let value = number.map(|number| number * factor);
        match value.filter(|value| (0.0..=most).contains(value)) {
            Some(value) => Ok(Self { kind, value }),
            None => {
                let most = most / factor;
                Err(format!("give {name} from 0{unit} to {most}{unit}, as in {name}={example}"))
            }
        }
    }
}

/// The disturbances of a fleet.
#[derive(Clone, Debug, Default)]
pub struct Disturbances {
    list: Vec<Disturbance>,
    seed: u64,
}

impl Disturbances {
    /// Collects disturbances. Of two of a kind, the later one counts.
    pub fn new(list: &[Disturbance], seed: u64) -> Self {
        Self { list: list.to_vec(), seed }
    }

    /// Returns the value of a kind: 0 if it isn't wanted.
    pub fn value(&self, kind: Kind) -> f64 {
        let found = self.list.iter().rev().find(|disturbance| disturbance.kind == kind);
        found.map_or(0.0, |disturbance| disturbance.value)
    }

    /// Returns the draws of a part of the fleet.
    pub fn draws(&self, part: u64) -> Draws {
        Draws { random: Random::new(self.seed).part(part), count: 0 }
    }
}

/// A row of random draws.
#[derive(Clone, Copy, Debug)]
pub struct Draws {
    random: Random,
    count: u64,
}

impl Draws {
    fn next(&mut self) -> u64 {
        self.count += 1;
        self.count
    }

    /// Whether an event comes true whose probability is `share`.
    pub fn comes_true(&mut self, share: f64) -> bool {
        let draw = self.next();
        share > 0.0 && self.random.unit(draw) <= share
    }

    /// Returns a time, exponentially distributed with a mean.
    pub fn time(&mut self, mean_secs: f64) -> f64 {
        let draw = self.next();
        self.random.exponential(draw) * mean_secs
    }

    fn duration(&mut self) -> f64 {
        let draw = self.next();
        SHORTEST_SECS + (LONGEST_SECS - SHORTEST_SECS) * self.random.unit(draw)
    }
}

/// A disturbance that begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strike {
    /// Its kind: one that comes so often an hour.
    pub kind: Kind,
    /// The time that it lasts, in seconds.
    pub secs: f64,
}

/// The fate of a vehicle: a function of the seed, its robot, its actions and simulated time.
#[derive(Clone, Debug)]
pub struct Fate {
    draws: Draws,
    failed_actions: f64,
    refused_orders: f64,
    strikes: Vec<Timer>,
}

/// A disturbance that comes again and again.
#[derive(Clone, Copy, Debug)]
struct Timer {
    kind: Kind,
    per_hour: f64,
    draws: Draws,
    /// Simulated seconds at which it comes next; `None` before the first look.
    next: Option<f64>,
}

impl Fate {
    /// Returns the fate of a vehicle by the id of its robot.
    pub fn new(disturbances: &Disturbances, robot: usize) -> Self {
        let kinds =
            [Kind::LostConnections, Kind::ManualMode, Kind::EmergencyStops, Kind::LostPositions];
        // Four parts for each robot, and one more for its actions.
        let first_part = robot as u64 * (kinds.len() as u64 + 1);
        let mut strikes = Vec::new();
        for (kind, part) in kinds.into_iter().zip(first_part + 1..) {
            let per_hour = disturbances.value(kind);
            if per_hour > 0.0 {
                strikes.push(Timer { kind, per_hour, draws: disturbances.draws(part), next: None });
            }
        }
        Self {
            draws: disturbances.draws(first_part),
            failed_actions: disturbances.value(Kind::FailedActions),
            refused_orders: disturbances.value(Kind::RefusedOrders),
            strikes,
        }
    }

    /// Whether the next action fails.
    pub fn fails_action(&mut self) -> bool {
        self.failed_actions > 0.0 && self.draws.comes_true(self.failed_actions)
    }

    /// Whether the next order is refused.
    pub fn refuses_order(&mut self) -> bool {
        self.refused_orders > 0.0 && self.draws.comes_true(self.refused_orders)
    }

    /// Returns a disturbance that begins at a simulated time.
    pub fn strike(&mut self, time: f64) -> Option<Strike> {
        for timer in &mut self.strikes {
            let mean = 3600.0 / timer.per_hour;
            let next = *timer.next.get_or_insert_with(|| time + timer.draws.time(mean));
            if next <= time {
                let secs = timer.draws.duration();
                timer.next = Some(time + secs + timer.draws.time(mean));
                return Some(Strike { kind: timer.kind, secs });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disturbances(texts: &[&str], seed: u64) -> Disturbances {
        let list: Vec<Disturbance> =
            texts.iter().map(|text| text.parse().expect("a disturbance")).collect();
        Disturbances::new(&list, seed)
    }

    #[test]
    fn disturbances_are_read_with_their_units() {
        let list = disturbances(&["failed-actions=2%", "delay=0.5s", "manual-mode=3/h"], 1);
        assert_eq!(list.value(Kind::FailedActions), 0.02);
        assert_eq!((list.value(Kind::Delay), list.value(Kind::ManualMode)), (0.5, 3.0));
        assert_eq!(list.value(Kind::LostMessages), 0.0);
        for (text, error) in [
            ("delay", "give KIND=VALUE"),
            ("rain=1%", "the kinds are failed-actions, refused-orders"),
            ("lost-messages=0.1", "give lost-messages from 0% to 100%, as in lost-messages=2%"),
            ("lost-messages=101%", "from 0% to 100%"),
            ("manual-mode=-1/h", "from 0/h to 3600/h"),
            ("delay=NaNs", "from 0s to 60s"),
        ] {
            let told = text.parse::<Disturbance>().expect_err(text);
            assert!(told.contains(error), "{told}");
        }
    }

    #[test]
    fn a_seed_draws_the_same_fate_again_and_its_rates_hold() {
        let list = disturbances(&["failed-actions=10%", "emergency-stops=6/h"], 7);
        let fate = |list: &Disturbances, robot: usize| {
            let mut fate = Fate::new(list, robot);
            let failed = (0..10_000).filter(|_| fate.fails_action()).count();
            let strikes: Vec<(u64, Strike)> =
                (0..360_000).filter_map(|time| Some((time, fate.strike(time as f64)?))).collect();
            (failed, strikes)
        };
        let (failed, strikes) = fate(&list, 3);
        assert_eq!((failed, &strikes), (fate(&list, 3).0, &fate(&list, 3).1));
        assert_ne!(strikes, fate(&list, 4).1);
        assert_ne!(strikes, fate(&disturbances(&["emergency-stops=6/h"], 8), 3).1);
        assert!((900..1_100).contains(&failed), "{failed}");
        // One in ten minutes and the 35 s that it lasts, in a hundred hours.
        assert!((500..630).contains(&strikes.len()), "{}", strikes.len());
        let lasts = strikes.iter().all(|(_, strike)| (10.0..=60.0).contains(&strike.secs));
        assert!(lasts && strikes.iter().all(|(_, strike)| strike.kind == Kind::EmergencyStops));
    }

    #[test]
    fn a_vehicle_without_disturbances_has_none() {
        let mut fate = Fate::new(&Disturbances::default(), 0);
        assert!(!fate.fails_action() && !fate.refuses_order());
        assert_eq!(fate.strike(1e9), None);
    }
}
