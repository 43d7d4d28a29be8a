//! The prices of a study file, as far as the user gives them.
//!
//! ```yaml
//! prices:
//!   currency: EUR                  # a word of your own
//!   robot_price: 48000
//!   charger_price: 6000
//!   robots_per_charger: 5          # without it, the chargers of the layout, if it has any
//!   project_price: 180000          # planning, software, installation: once
//!   interest_percent: 5            # a year
//!   life_years: 8                  # of all that is bought
//!   maintenance_percent: 4         # a year, of robots and chargers
//!   robot_kw: 0.6                  # mean power of a robot over its hours of operation
//!   energy_price_per_kwh: 0.24
//!   operator_per_year: 65000       # people and all that doesn't depend on the number of robots
//!   operating_hours_per_year: 4000 # or, with the orders of a day, days_per_year: 250
//! ```

use serde::{Deserialize, Serialize};

/// Defines numbers within a range, and of another property if there is one, with the words that
/// ask for one.
macro_rules! numbers {
    ($(
        $(#[doc = $doc:literal])*
        $name:ident($range:expr $(, $also:expr)?): $wanted:literal,
    )*) => {$(
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(try_from = "f64")]
        pub struct $name(f64);

        impl $name {
            /// Returns the number.
            pub const fn get(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = String;

            fn try_from(value: f64) -> Result<Self, String> {
                match $range.contains(&value) $(&& $also(value))? {
                    true => Ok(Self(value)),
                    false => Err(format!("{value}: give {}", $wanted)),
                }
            }
        }
    )*};
}

numbers! {
    /// An amount of money.
    Amount(0.0..=1e12): "an amount from 0 to 1e12, without a currency",
    /// Per cent.
    Percent(0.0..=100.0): "per cent from 0 to 100, as a number",
    /// Whole years.
    Years(1.0..=100.0, is_whole): "whole years from 1 to 100",
    /// A power in kilowatts.
    Kilowatts(0.0..=1000.0): "kilowatts from 0 to 1000",
    /// Robots that share a charger.
    RobotsPerCharger(0.1..=1000.0): "0.1 to 1000 robots",
    /// Hours of a year.
    HoursPerYear(1.0..=8784.0): "1 to 8784 hours",
    /// Days of a year.
    DaysPerYear(1.0..=366.0): "1 to 366 days",
}

fn is_whole(value: f64) -> bool {
    value.fract() == 0.0
}

/// The longest name of a currency, in letters.
const CURRENCY_LETTERS: usize = 20;

/// The name of a currency.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String")]
pub struct Currency(String);

impl Currency {
    /// Returns the name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl TryFrom<String> for Currency {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let letters = text.chars().count();
        let is_word = text.chars().all(|letter| letter.is_alphabetic() || "$€£¥₹".contains(letter));
        if is_word && (1..=CURRENCY_LETTERS).contains(&letters) {
            return Ok(Self(text));
        }
        Err(format!("'{}': give a word or sign, such as EUR or €", text.escape_debug()))
    }
}

/// The prices of a plant. All amounts are in one currency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Prices {
    /// The currency.
    pub currency: Currency,
    /// Of a robot, of whatever type.
    pub robot_price: Option<Amount>,
    /// Of a charger.
    pub charger_price: Option<Amount>,
    /// The robots for each charger; by default, the chargers are those of the layout.
    pub robots_per_charger: Option<RobotsPerCharger>,
    /// Of planning, software and installation, once.
    pub project_price: Option<Amount>,
    /// The interest of a year.
    pub interest_percent: Option<Percent>,
    /// The life of all that is bought, in whole years.
    pub life_years: Option<Years>,
    /// The maintenance of a year, in per cent of the price of robots and chargers.
    pub maintenance_percent: Option<Percent>,
    /// The mean power that a robot takes from the grid during operation.
    pub robot_kw: Option<Kilowatts>,
    /// Of a kilowatt hour.
    pub energy_price_per_kwh: Option<Amount>,
    /// The cost of a year that doesn't depend on the number of robots, such as that of people.
    pub operator_per_year: Option<Amount>,
    /// The hours of operation.
    pub operating_hours_per_year: Option<HoursPerYear>,
    /// The days like that of the study, in place of the hours.
    pub days_per_year: Option<DaysPerYear>,
}

impl Prices {
    /// Returns the part of an investment that is due each year, so that its life pays for it with
    /// interest: i (1 + i)ⁿ / ((1 + i)ⁿ − 1). Products alone give the same bits on all machines.
    pub fn annuity(&self) -> Option<f64> {
        let (interest, years) = (self.interest_percent?.get() / 100.0, self.life_years?.get());
        if interest == 0.0 {
            return Some(1.0 / years);
        }
        let growth = (0..years as u32).fold(1.0, |growth, _| growth * (1.0 + interest));
        Some(interest * growth / (growth - 1.0))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use regatta_scenario::document;

    use super::*;

    fn read(text: &str) -> Result<Prices, String> {
        document(text, Path::new("prices.yaml")).map_err(|error| error.to_string())
    }

    #[test]
    fn the_annuity_pays_for_an_investment_with_interest() {
        let annuity = |text: &str| read(&format!("currency: EUR\n{text}")).expect(text).annuity();
        // A loan of 1000 at 5 % is paid back after 8 years of this amount.
        let part = annuity("interest_percent: 5\nlife_years: 8").expect("an annuity");
        let left = (0..8).fold(1000.0, |debt, _| debt * 1.05 - 1000.0 * part);
        assert!(left.abs() < 1e-9, "{left} of 1000 is left");
        assert_eq!(annuity("interest_percent: 0\nlife_years: 8"), Some(0.125));
        assert_eq!(annuity("life_years: 8"), None);
    }

    #[test]
    fn what_is_no_price_is_refused_in_one_line() {
        for (text, reason) in [
            ("robot_price: 3", "currency"),
            ("currency: ''", "give a word"),
            ("currency: '<b>'", "give a word"),
            ("currency: EUR\nrobot_price: -1", "give an amount"),
            ("currency: EUR\nrobot_price: .inf", "give an amount"),
            ("currency: EUR\nrobot_price: 48.000 EUR", "robot_price"),
            ("currency: EUR\ninterest_percent: 500", "per cent from 0 to 100"),
            ("currency: EUR\nlife_years: 0", "whole years"),
            ("currency: EUR\nlife_years: 2.5", "whole years"),
            ("currency: EUR\noperating_hours_per_year: 9000", "8784"),
            ("currency: EUR\nrobots_price: 3", "robots_price"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(reason) && !error.contains('\n'), "{text}: {error}");
        }
    }
}
