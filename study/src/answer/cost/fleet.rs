//! The formulas of the cost of a fleet, and the prices that each needs.

use super::CostFigure;
use crate::job::Ending;
use crate::outcome::Measured;
use crate::plan::{Prices, Variant};

/// A price, or another number of the user.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Price {
    Robot,
    Charger,
    RobotsPerCharger,
    Project,
    Interest,
    Life,
    Maintenance,
    RobotPower,
    Energy,
    Operator,
    Hours,
}

/// A fleet, with what its cost is computed from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fleet<'a> {
    prices: &'a Prices,
    robots: f64,
    /// The chargers of the layout.
    chargers: f64,
    /// The end of its runs: only days have a time of their own.
    ending: Ending,
}

/// Returns the prices that a figure needs; some may be there twice.
fn needs(figure: CostFigure) -> Vec<Price> {
    let equipment = [Price::Robot, Price::Charger, Price::RobotsPerCharger];
    match figure {
        CostFigure::Investment => [&equipment[..], &[Price::Project]].concat(),
        CostFigure::Capital => {
            [needs(CostFigure::Investment), vec![Price::Interest, Price::Life]].concat()
        }
        CostFigure::Maintenance => [&equipment[..], &[Price::Maintenance]].concat(),
        CostFigure::Energy => vec![Price::RobotPower, Price::Energy, Price::Hours],
        CostFigure::Operation => vec![Price::Operator],
        CostFigure::Year => CostFigure::PARTS.map(needs).concat(),
        CostFigure::Order => [needs(CostFigure::Year), vec![Price::Hours]].concat(),
    }
}

impl<'a> Fleet<'a> {
    pub fn new(prices: &'a Prices, variant: &Variant, robots: u32) -> Self {
        let (robots, chargers) = (f64::from(robots), variant.chargers() as f64);
        Self { prices, robots, chargers, ending: variant.ending() }
    }

    /// The number of chargers; `None` if neither the user nor the layout tells it.
    pub fn chargers(&self) -> Option<f64> {
        match self.prices.robots_per_charger {
            Some(robots) => Some((self.robots / robots.get()).ceil()),
            None => Some(self.chargers).filter(|chargers| *chargers > 0.0),
        }
    }

    /// The price of robots and chargers. Chargers without a price need no number.
    fn equipment(&self) -> Option<f64> {
        let chargers = match self.prices.charger_price?.get() {
            0.0 => 0.0,
            price => price * self.chargers()?,
        };
        Some(self.robots * self.prices.robot_price?.get() + chargers)
    }

    pub fn investment(&self) -> Option<f64> {
        Some(self.equipment()? + self.prices.project_price?.get())
    }

    /// Whether the hours of a year are those of its days, each as long as its run.
    pub fn works_by_days(&self) -> bool {
        self.prices.operating_hours_per_year.is_none() && self.ending == Ending::AfterOrders
    }

    /// The hours of operation of a year.
    pub fn hours(&self, run: &Measured) -> Option<f64> {
        let hours = self.prices.operating_hours_per_year;
        let days = self.prices.days_per_year.filter(|_| self.ending == Ending::AfterOrders);
        match (hours, days) {
            (Some(hours), _) => Some(hours.get()),
            (None, Some(days)) => Some(days.get() * run.secs / 3600.0),
            (None, None) => None,
        }
    }

    /// A part of the cost of a year.
    pub fn part(&self, part: CostFigure, run: &Measured) -> Option<f64> {
        let prices = self.prices;
        match part {
            CostFigure::Capital => Some(prices.annuity()? * self.investment()?),
            CostFigure::Maintenance => {
                Some(prices.maintenance_percent?.get() / 100.0 * self.equipment()?)
            }
            CostFigure::Energy => {
                let kilowatts = self.robots * prices.robot_kw?.get();
                Some(kilowatts * prices.energy_price_per_kwh?.get() * self.hours(run)?)
            }
            CostFigure::Operation => Some(prices.operator_per_year?.get()),
            CostFigure::Investment | CostFigure::Year | CostFigure::Order => None,
        }
    }

    /// The cost of a year.
    pub fn year(&self, run: &Measured) -> Option<f64> {
        CostFigure::PARTS.into_iter().map(|part| self.part(part, run)).sum()
    }

    /// The cost of a year over the finished orders of a year.
    pub fn order(&self, run: &Measured) -> Option<f64> {
        let orders = run.orders_per_hour * self.hours(run)?;
        Some(self.year(run)? / orders).filter(|cost| cost.is_finite())
    }

    /// The keys of the prices that a figure needs and that the user hasn't given.
    pub fn missing(&self, figure: CostFigure) -> Vec<&'static str> {
        let mut keys = Vec::new();
        for price in needs(figure) {
            let key = self.key(price);
            if !self.has(price) && !keys.contains(&key) {
                keys.push(key);
            }
        }
        keys
    }

    fn has(&self, price: Price) -> bool {
        let Prices { charger_price, robots_per_charger, days_per_year, .. } = self.prices;
        match price {
            Price::Robot => self.prices.robot_price.is_some(),
            Price::Charger => charger_price.is_some(),
            Price::RobotsPerCharger => {
                let are_free = charger_price.is_some_and(|price| price.get() == 0.0);
                are_free || robots_per_charger.is_some() || self.chargers > 0.0
            }
            Price::Project => self.prices.project_price.is_some(),
            Price::Interest => self.prices.interest_percent.is_some(),
            Price::Life => self.prices.life_years.is_some(),
            Price::Maintenance => self.prices.maintenance_percent.is_some(),
            Price::RobotPower => self.prices.robot_kw.is_some(),
            Price::Energy => self.prices.energy_price_per_kwh.is_some(),
            Price::Operator => self.prices.operator_per_year.is_some(),
            Price::Hours => {
                let has_days = days_per_year.is_some() && self.ending == Ending::AfterOrders;
                has_days || self.prices.operating_hours_per_year.is_some()
            }
        }
    }

    /// The key of a price in a study file.
    fn key(&self, price: Price) -> &'static str {
        match price {
            Price::Robot => "robot_price",
            Price::Charger => "charger_price",
            Price::RobotsPerCharger => "robots_per_charger",
            Price::Project => "project_price",
            Price::Interest => "interest_percent",
            Price::Life => "life_years",
            Price::Maintenance => "maintenance_percent",
            Price::RobotPower => "robot_kw",
            Price::Energy => "energy_price_per_kwh",
            Price::Operator => "operator_per_year",
            Price::Hours if self.ending == Ending::AfterOrders => "days_per_year",
            Price::Hours => "operating_hours_per_year",
        }
    }
}
