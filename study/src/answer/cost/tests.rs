use std::path::Path;
use std::sync::Arc;

use regatta_layout::ReadOptions;
use regatta_scenario::document;

use super::*;
use crate::outcome::Measured;
use crate::plan::Day;
use crate::sweep::tests::measured;

/// The prices of the case that was calculated by hand.
const PRICES: &str = "currency: EUR\nrobot_price: 50000\ncharger_price: 8000\n\
    robots_per_charger: 4\nproject_price: 100000\ninterest_percent: 10\nlife_years: 2\n\
    maintenance_percent: 5\nrobot_kw: 0.5\nenergy_price_per_kwh: 0.2\noperator_per_year: 60000\n\
    operating_hours_per_year: 4000\n";

fn prices(text: &str) -> Prices {
    document(text, Path::new("prices.yaml")).expect("prices")
}

fn variant() -> Variant {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ring.csv");
    let ring = "id,x,y,role\nA,0,0,pick\nB,10,0,\nC,10,10,drop\n\nfrom,to\nA,B\nB,C\nC,A\n";
    std::fs::write(&path, ring).expect("written");
    Variant::read(&path, &ReadOptions::default()).expect("a variant")
}

/// A point of two runs with 99 and 101 orders an hour.
fn point(robots: u32) -> Point {
    let runs = [99.0, 101.0].map(|orders| Measured { secs: 7200.0, ..measured(orders) });
    Point { robots, seeds: vec![1, 2], runs: runs.to_vec() }
}

fn cost(text: &str, points: Vec<Point>) -> CostAnswer {
    let curve = Curve { points, ..Curve::default() };
    CostAnswer::new(&prices(text), &variant(), &[], &curve, None)
}

#[track_caller]
fn is_near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-6 * expected, "{value} instead of {expected}");
}

#[test]
fn the_cost_is_that_of_the_case_by_hand() {
    // Ten robots, three chargers: 500,000 + 24,000 + 100,000. The annuity of two years at 10 % is
    // 0.1 · 1.21 / 0.21 = 121 / 210. 10 · 0.5 kW · 4000 h are 20,000 kWh.
    let answer = cost(PRICES, vec![point(10)]);
    assert_eq!(answer.missing, []);
    let ten = &answer.points[0];
    assert_eq!((ten.chargers, ten.investment), (Some(3.0), Some(624_000.0)));
    let parts: Vec<f64> = ten.year_parts.iter().map(|part| part.value.mean).collect();
    for (part, expected) in parts.iter().zip([624_000.0 * 121.0 / 210.0, 26_200.0, 4000.0, 6e4]) {
        is_near(*part, expected);
    }
    let year = 624_000.0 * 121.0 / 210.0 + 26_200.0 + 4000.0 + 60_000.0;
    is_near(ten.per_year.expect("a cost").mean, year);
    // 396,000 and 404,000 orders a year.
    let order = (year / 396_000.0 + year / 404_000.0) / 2.0;
    is_near(ten.per_order.expect("a cost").mean, order);
}

#[test]
fn the_cost_of_an_order_is_no_more_exact_than_its_count() {
    let equal = [5.0, 5.0].map(|orders| Measured { secs: 3600.0, ..measured(orders) });
    let answer = cost(PRICES, vec![Point { runs: equal.to_vec(), ..point(10) }]);
    let cost = answer.points[0].per_order.expect("a cost");
    is_near(cost.half_width.expect("two runs"), cost.mean / 5.0);
}

#[test]
fn the_cost_of_an_order_of_a_day_is_that_of_all_its_orders() {
    // Both runs finish all 90 orders, one of them in a longer time.
    let day = [3600.0, 4000.0].map(|secs| Measured { secs, ..measured(90.0 * 3600.0 / secs) });
    let curve =
        Curve { points: vec![Point { runs: day.to_vec(), ..point(10) }], ..Curve::default() };
    let text = PRICES.replace("operating_hours_per_year: 4000", "days_per_year: 250");
    let text = text.replace("robot_kw: 0.5", "robot_kw: 0");
    let file = Day { stops: ["A".to_owned(), "C".to_owned()].into(), ..Day::default() };
    let variant = variant().with_day(&Arc::new(file)).expect("stops on the ring");
    let answer = CostAnswer::new(&prices(&text), &variant, &[], &curve, None);
    let [year, order] = [answer.points[0].per_year, answer.points[0].per_order];
    let (year, order) = (year.expect("a cost"), order.expect("a cost"));
    is_near(order.mean, year.mean / (90.0 * 250.0));
    assert!(order.half_width.expect("two runs") < 1e-6 * order.mean, "{order:?}");
}

#[test]
fn a_figure_is_missing_where_one_of_its_prices_is() {
    for line in PRICES.lines().skip(1) {
        let key = line.split(':').next().expect("a key");
        let answer = cost(&PRICES.replace(&format!("{line}\n"), ""), vec![point(10)]);
        let is_missing = |figure: CostFigure| {
            let mut missing = answer.missing.iter();
            missing.any(|missing| missing.figure == figure && missing.keys == [key])
        };
        let ten = &answer.points[0];
        assert_eq!(ten.investment.is_none(), is_missing(CostFigure::Investment), "{key}");
        assert_eq!(ten.per_year.is_none(), is_missing(CostFigure::Year), "{key}");
        assert_eq!(ten.per_order.is_none(), is_missing(CostFigure::Order), "{key}");
        for part in CostFigure::PARTS {
            let has = ten.year_parts.iter().any(|known| known.name == part.name());
            assert_eq!(has, !is_missing(part), "{key}: {part:?}");
        }
        assert!(is_missing(CostFigure::Order), "the cost of an order needs {key}");
    }
}

#[test]
fn the_cheapest_fleet_counts_and_has_the_least_cost_of_an_order() {
    let mut busy = point(20);
    for run in &mut busy.runs {
        run.orders_per_hour *= 4.0;
    }
    let answer = cost(PRICES, vec![point(10), busy.clone(), point(30)]);
    let cheapest = answer.cheapest.expect("one is the cheapest");
    assert_eq!((cheapest.robots, cheapest.by), (20, CostFigure::Order));
    assert!(!cheapest.is_open);
    // A day that isn't over at its limit isn't carried.
    busy.runs[0].end = RunEnd::Overdue;
    let answer = cost(PRICES, vec![point(10), busy, point(30)]);
    assert_eq!(answer.cheapest.map(|cheapest| cheapest.robots), Some(10));
    assert!(cost("currency: EUR", vec![point(10)]).cheapest.is_none());
}
