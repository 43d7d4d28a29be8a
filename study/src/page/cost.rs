//! The cost of fleets: sentences, plots, a table and the definitions.

use regatta_base::grouped;

use super::chart::{COLOURS, Chart, ChartPoint, Series, chart};
use super::content::NONE;
use super::stack::{Bar, Part, stack};
use super::verdict::prefix;
use super::{Block, Picture};
use crate::answer::{Answer, CostAnswer, CostFigure, Missing, PointCost, VariantAnswer};
use crate::plan::{Prices, robots_in_words};
use crate::statistics::Interval;
use crate::words::{Kind, in_words};

/// Returns what the answer says about cost, for each variant, and about the cheapest of several.
pub(super) fn findings(answer: &Answer) -> Vec<Block> {
    let Some(prices) = &answer.prices else { return Vec::new() };
    let currency = prices.currency.as_str();
    let mut blocks = Vec::new();
    for variant in &answer.variants {
        let Some(cost) = &variant.cost else { continue };
        if let Some(text) = cheapest(variant, cost, currency) {
            blocks.push(Block::Finding(format!("{}{text}", prefix(variant))));
        }
        if !cost.missing.is_empty() {
            let text = format!("{}**Not computed**: {}", prefix(variant), lacks(&cost.missing));
            blocks.push(Block::Caveat(text));
        }
    }
    blocks.extend(cheapest_variant(answer).map(Block::Finding));
    blocks
}

/// Tells the cheapest number of robots, and the cost of the number of the answer.
fn cheapest(variant: &VariantAnswer, cost: &CostAnswer, currency: &str) -> Option<String> {
    let cheapest = cost.cheapest.as_ref()?;
    let point = at(cost, cheapest.robots)?;
    let tried = match cheapest.by {
        CostFigure::Year => "the cheapest of those that were tried and meet the targets",
        _ => "the cheapest per order of those that were tried",
    };
    let verb = if cheapest.robots == 1 { "is" } else { "are" };
    let mut text = format!(
        "Cost: {} {verb} {tried}: {}.",
        robots_in_words(cheapest.robots),
        both(point, currency)?
    );
    if cheapest.is_open && cheapest.by == CostFigure::Order {
        text += " It is the largest number that counts: more robots may be cheaper.";
    }
    let answered = variant.robots().filter(|robots| *robots != cheapest.robots);
    if let Some(point) = answered.and_then(|robots| at(cost, robots)) {
        let robots = robots_in_words(point.robots);
        text += &format!(" With {robots}, it is {}.", both(point, currency)?);
    }
    Some(text)
}

fn at(cost: &CostAnswer, robots: u32) -> Option<&PointCost> {
    cost.points.iter().find(|point| point.robots == robots)
}

/// The cost of a year with a number of robots, for a cell of a table.
pub(super) fn year_of(cost: &CostAnswer, robots: Option<u32>) -> String {
    let year = robots.and_then(|robots| at(cost, robots)?.per_year);
    year.map_or_else(|| NONE.to_owned(), |year| with_interval(&year))
}

/// The cost of a year and of an order, as far as they are known.
fn both(point: &PointCost, currency: &str) -> Option<String> {
    let year = point.per_year.map(|cost| format!("{} {currency} a year", with_interval(&cost)));
    let order = point.per_order.map(|cost| format!("{} {currency} an order", with_interval(&cost)));
    let known: Vec<String> = year.into_iter().chain(order).collect();
    (!known.is_empty()).then(|| known.join(", "))
}

/// Tells the prices that each figure lacks; figures that lack only those of others come last.
fn lacks(missing: &[Missing]) -> String {
    let (mut texts, mut others) = (Vec::new(), Vec::new());
    let mut told: Vec<&str> = Vec::new();
    for Missing { figure, keys } in missing {
        let new: Vec<&str> = keys.iter().copied().filter(|key| !told.contains(key)).collect();
        if new.is_empty() {
            others.push(figure.name());
            continue;
        }
        let keys: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
        texts.push(format!("{} lacks {}", figure.name(), keys.join(", ")));
        told.extend(new);
    }
    if !others.is_empty() {
        texts.push(format!("therefore also {}", others.join(", ")));
    }
    texts.join("; ") + ". Add them to `prices` in the study file."
}

/// Tells the cheapest of several variants.
fn cheapest_variant(answer: &Answer) -> Option<String> {
    let mut costs = Vec::new();
    for variant in &answer.variants {
        costs.extend(variant.cost.as_ref()?.cheapest.as_ref().map(|cheapest| (variant, cheapest)));
    }
    let (variant, least) =
        costs.iter().min_by(|(_, a), (_, b)| a.cost.mean.total_cmp(&b.cost.mean))?;
    let unit = if least.by == CostFigure::Year { "a year" } else { "an order" };
    (costs.len() > 1).then(|| {
        format!(
            "Cost: of the variants, {} is the cheapest, with {}: {} {} {unit}.",
            variant.name,
            robots_in_words(least.robots),
            with_interval(&least.cost),
            answer.prices.as_ref().map_or("", |prices| prices.currency.as_str())
        )
    })
}

/// Returns the part of the page about cost.
pub(super) fn cost(answer: &Answer) -> Vec<Block> {
    let Some(prices) = &answer.prices else { return Vec::new() };
    let mut blocks = vec![Block::Heading(2, "Cost".to_owned())];
    blocks.extend(year_picture(answer, prices));
    blocks.extend(order_picture(answer, prices));
    for variant in &answer.variants {
        let Some(cost) = &variant.cost else { continue };
        if answer.variants.len() > 1 {
            blocks.push(Block::Heading(3, variant.name.clone()));
        }
        blocks.push(table(cost, prices.currency.as_str(), variant.robots()));
    }
    blocks.push(definitions(prices));
    blocks.push(given(prices));
    blocks
}

/// The parts of the cost of a year, of the first variant.
fn year_picture(answer: &Answer, prices: &Prices) -> Option<Block> {
    let variant = answer.variants.first()?;
    let mut bars = Vec::new();
    for point in variant.cost.as_ref()?.points.iter().filter(|point| point.per_year.is_some()) {
        let parts = point.year_parts.iter().zip(COLOURS.into_iter().cycle());
        let parts =
            parts.map(|(part, colour)| Part { name: part.name, colour, value: part.value.mean });
        bars.push(Bar { robots: point.robots, parts: parts.collect() });
    }
    let svg = stack(&bars, &format!("{} a year", prices.currency.as_str()));
    let caption = format!("{}Cost of a year over robots", prefix(variant));
    let picture = Picture { name: "cost-year", caption, svg };
    (!bars.is_empty()).then_some(Block::Picture(picture))
}

fn order_picture(answer: &Answer, prices: &Prices) -> Option<Block> {
    let mut series = Vec::new();
    for variant in &answer.variants {
        let mut points = Vec::new();
        for (cost, point) in variant.cost.as_ref()?.points.iter().zip(&variant.points) {
            let is_stalled = point.stalled().next().is_some();
            points.extend(cost.per_order.map(|interval| ChartPoint {
                robots: f64::from(cost.robots),
                mean: interval.mean,
                half_width: interval.half_width.unwrap_or(0.0),
                is_stalled,
            }));
        }
        series.push(Series { name: variant.name.clone(), points });
    }
    series.retain(|line| !line.points.is_empty());
    let y = format!("{} an order", prices.currency.as_str());
    let knee = answer.variants.first().and_then(VariantAnswer::robots).map(f64::from);
    let caption = "Cost of an order over robots".to_owned();
    let is_empty = series.is_empty();
    let svg = chart(&Chart { x: "robots", y: &y, series, knee, most: None });
    (!is_empty).then_some(Block::Picture(Picture { name: "cost-order", caption, svg }))
}

fn table(cost: &CostAnswer, currency: &str, answer: Option<u32>) -> Block {
    let mut head = vec!["robots".to_owned(), "chargers".to_owned()];
    let figures = CostFigure::ALL.iter();
    head.extend(figures.map(|figure| format!("{}, {currency}", figure.name())));
    let mut rows = vec![head];
    for point in &cost.points {
        let mark = if answer == Some(point.robots) { "**" } else { "" };
        let mut row = vec![format!("{mark}{}{mark}", point.robots)];
        row.push(point.chargers.map_or_else(|| NONE.to_owned(), |number| number.to_string()));
        row.push(point.investment.map_or_else(|| NONE.to_owned(), money));
        for part in CostFigure::PARTS {
            let part = point.year_parts.iter().find(|known| known.name == part.name());
            row.push(part.map_or_else(|| NONE.to_owned(), |part| money(part.value.mean)));
        }
        for figure in [point.per_year, point.per_order] {
            row.push(figure.map_or_else(|| NONE.to_owned(), |cost| with_interval(&cost)));
        }
        rows.push(row);
    }
    Block::Table(rows)
}

/// The definitions of the figures.
const DEFINITIONS: [[&str; 2]; 8] = [
    [
        "investment",
        "robots × `robot_price` + chargers × `charger_price` + `project_price`; all robots have \
         one price, whatever their type",
    ],
    [
        "chargers",
        "robots / `robots_per_charger`, rounded up; without that, those of the layout, if it has \
         any",
    ],
    ["capital a year", "investment × i (1 + i)ⁿ / ((1 + i)ⁿ − 1), the annuity (VDI 2710-4)"],
    [
        "maintenance a year",
        "`maintenance_percent` × (robots × `robot_price` + chargers × `charger_price`)",
    ],
    ["energy a year", "robots × `robot_kw` × hours × `energy_price_per_kwh`"],
    ["operation a year", "`operator_per_year`"],
    ["cost a year", "capital + maintenance + energy + operation"],
    [
        "cost an order",
        "cost a year / (finished orders an hour × hours), of each run; then the mean \
         over the seeds",
    ],
];

fn definitions(prices: &Prices) -> Block {
    let hours = match (prices.operating_hours_per_year, prices.days_per_year) {
        (None, Some(_)) => {
            "`days_per_year` × the day of a run, from its beginning to the end of its last order"
        }
        _ => "`operating_hours_per_year`",
    };
    let mut rows = vec![["figure", "formula"].map(str::to_owned).to_vec()];
    rows.extend(DEFINITIONS.map(|row| row.map(str::to_owned).to_vec()));
    rows.push(vec!["hours".to_owned(), hours.to_owned()]);
    rows.push(vec![
        "i, n".to_owned(),
        "`interest_percent` / 100, `life_years`: of all that is bought".to_owned(),
    ]);
    if let Some(annuity) = prices.annuity() {
        rows.push(vec!["annuity factor".to_owned(), format!("{annuity:.5} a year")]);
    }
    Block::Table(rows)
}

/// The prices that the user gave.
fn given(prices: &Prices) -> Block {
    let mut rows = vec![["price", "given"].map(str::to_owned).to_vec()];
    let values = serde_json::to_value(prices).unwrap_or_default();
    for (key, value) in values.as_object().into_iter().flatten() {
        let value = match (value.as_str(), value.as_f64()) {
            (Some(text), _) => text.to_owned(),
            (None, Some(number)) => number.to_string(),
            (None, None) => NONE.to_owned(),
        };
        rows.push(vec![format!("`{key}`"), value]);
    }
    Block::Table(rows)
}

/// The amount from which on amounts are written without decimals.
const LEAST_WHOLE: f64 = 1000.0;
/// The largest half of an interval that two decimals don't show.
const LEAST_SPREAD: f64 = 0.005;

/// An amount: whole from 1000 on, with commas, or else with two decimals.
fn money(amount: f64) -> String {
    if amount.abs() < 999.995 {
        return format!("{amount:.2}");
    }
    grouped(amount, 0)
}

/// A mean with its interval, if there is a spread.
fn with_interval(interval: &Interval) -> String {
    let is_whole = interval.mean >= LEAST_WHOLE;
    let interval = interval.without_spread_up_to(LEAST_SPREAD);
    in_words(&interval, Kind::Estimate, "", |amount| match is_whole {
        true => money(amount.round()).trim_end_matches(".00").to_owned(),
        false => money(amount),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_read_at_a_glance() {
        let amounts = [0.0, 1.4, 999.99, 1000.0, 12_345.6, 1_234_567.8].map(money);
        assert_eq!(amounts, ["0.00", "1.40", "999.99", "1,000", "12,346", "1,234,568"]);
        let interval = |mean, half_width| {
            with_interval(&Interval { mean, half_width: Some(half_width), values: 3 })
        };
        assert_eq!(interval(1.434, 0.021), "1.43 ± 0.02");
        assert_eq!(interval(412_345.0, 0.0), "412,345");
        assert_eq!(interval(412_345.0, 20.4), "412,345 ± 20");
        assert_eq!(interval(1.43, 2.0), "not known (0.00 to 3.43)");
    }
}
