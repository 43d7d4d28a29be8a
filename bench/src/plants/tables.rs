//! The report's text and figures.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::measure::Run;
use super::summary::{BEHIND, Cell, Comparison, Group, Plant, Summary, Total};
use super::{Limit, Plan, Results};

pub fn markdown(plan: &Plan, results: &Results, summary: &Summary, environment: &str) -> String {
    let mut text = format!("# The fleet manager on many plants\n\n{environment}\n\n");
    text += &explanation(plan, results);
    text += &table(plan, &results.plants);
    text += &behind(plan, summary);
    for group in &summary.groups {
        text += &totals(group);
        text += &comparisons(plan, group);
    }
    let failures = results.plants.iter().flat_map(|plant| {
        plant.failures.iter().map(|failure| format!("{}: {failure}", plant.name))
    });
    text += &list("Runs that failed", failures);
    let refused = results.refused.iter();
    text += &list("Refused", refused.map(|plant| format!("{}: {}", plant.name, plant.reason)));
    text
}

fn explanation(plan: &Plan, results: &Results) -> String {
    format!(
        "{} plants, {} runs of {} simulated minutes for each number of robots and each planner, by \
         `regatta study`.{} Each robot has an order at any time, and stands for 4 to 12 s at each \
         stop. Columns with a number of robots have the orders an hour after the warm-up, the mean \
         of the runs; '–' where the plant holds fewer robots. In brackets: {} relative to the best \
         of the other planners. A run is a standstill if robots with orders made no progress for \
         five minutes, as the validator found, or if no order is finished after its warm-up, which \
         is at most its first half, although orders are open. Late orders waited for 20 minutes. \
         Generated plants are counted apart.\n\n",
        results.plants.len(),
        plan.seeds,
        plan.minutes,
        match plan.limit {
            Limit::Room => "",
            Limit::HalfOfNodes => " No plant has more robots than half of its nodes.",
        },
        plan.planners[0],
    )
}

fn table(plan: &Plan, plants: &[Plant]) -> String {
    let robots: String = plan.robots.iter().map(|robots| format!(" {robots} |")).collect();
    let mut text = format!(
        "| plant | planner |{robots} standstills | contacts | longest without an order |\n\
         |---|---|{}---|---|---|\n",
        "---|".repeat(plan.robots.len()),
    );
    for plant in plants {
        for planner in &plan.planners {
            text += &row(plan, plant, planner);
        }
    }
    text
}

fn row(plan: &Plan, plant: &Plant, planner: &str) -> String {
    let mut text = format!("| {} | {planner} |", escaped(&plant.name));
    for &robots in &plan.robots {
        let _ = write!(text, " {} |", figure(plan, plant, planner, robots));
    }
    let total = Total::of_plant(planner, plant);
    let _ = writeln!(
        text,
        " {} | {} | {} |",
        of_runs(&total),
        total.contacts,
        minutes(total.longest_gap_secs)
    );
    text
}

/// Returns the text of a cell. That of the first planner has its ratio to the best of the others.
fn figure(plan: &Plan, plant: &Plant, planner: &str, robots: u32) -> String {
    let Some(orders) = plant.orders_per_hour(planner, robots) else {
        return if plant.holds(robots) { "**failed**" } else { "–" }.to_owned();
    };
    let cell = plant.cell(&plan.planners, robots).filter(|_| planner == plan.planners[0]);
    match cell {
        Some(cell) => format!("{} ({})", number(orders), ratio(&cell)),
        None => number(orders),
    }
}

fn behind(plan: &Plan, summary: &Summary) -> String {
    if plan.planners.len() < 2 {
        return String::new();
    }
    let first = &plan.planners[0];
    let cells: Vec<&Cell> = summary.cells.iter().filter(|cell| cell.is_behind()).collect();
    let mut text = format!(
        "\n## Cells of {first} below {:.0} % of the best\n\n{} of {} cells.\n",
        BEHIND * 100.0,
        cells.len(),
        summary.cells.len()
    );
    if !cells.is_empty() {
        let _ = write!(text, "\n| plant | robots | {first} | best | |\n|---|---|---|---|---|\n");
    }
    for cell in cells {
        let (plant, best) = (escaped(&cell.plant), number(cell.best));
        let (robots, orders) = (cell.robots, number(cell.first));
        let planner = &cell.best_planner;
        let ratio = ratio(cell);
        let _ = writeln!(text, "| {plant} | {robots} | {orders} | {best} ({planner}) | {ratio} |");
    }
    text
}

fn totals(group: &Group) -> String {
    let mut text = format!(
        "\n## {}: standstills and contacts\n\n\
         | planner | standstills | contacts | late orders | other findings | orders given up |\n\
         |---|---|---|---|---|---|\n",
        group.kind.words()
    );
    for total in &group.totals {
        let Total { planner, contacts, unserved, other_findings, failed_orders, .. } = total;
        let standstills = of_runs(total);
        let _ = writeln!(
            text,
            "| {planner} | {standstills} | {contacts} | {unserved} | {other_findings} | \
             {failed_orders} |"
        );
    }
    text
}

fn comparisons(plan: &Plan, group: &Group) -> String {
    if group.comparisons.is_empty() {
        return String::new();
    }
    let first = &plan.planners[0];
    let mut text = format!(
        "\n## {}: {first} relative to the other planners\n\n\
         The geometric mean over plants, each of which counts with the geometric mean over its \
         numbers of robots. Only cells where both planners carry orders are in it; the others are \
         counted apart, in the last three columns.\n\n\
         | relative to | mean | plants | cells | only {first} carries | only the other | neither \
         |\n\
         |---|---|---|---|---|---|---|\n",
        group.kind.words()
    );
    for comparison in &group.comparisons {
        let Comparison { other, plants, both, only_first, only_other, neither, .. } = comparison;
        let ratio = comparison.ratio.map_or("–".to_owned(), |ratio| format!("{ratio:.3}"));
        let _ = writeln!(
            text,
            "| {other} | {ratio} | {plants} | {both} | {only_first} | {only_other} | {neither} |"
        );
    }
    text
}

/// Returns a section with a list, or nothing if it has no items.
fn list(heading: &str, items: impl Iterator<Item = String>) -> String {
    let items: String = items.map(|item| format!("- {item}\n")).collect();
    if items.is_empty() { items } else { format!("\n## {heading}\n\n{items}") }
}

pub fn json(plan: &Plan, results: &Results, summary: &Summary, machine: Value) -> Value {
    let plants: Vec<Value> = results.plants.iter().map(|plant| plant_json(plan, plant)).collect();
    let refused = results.refused.iter();
    let refused: Vec<Value> =
        refused.map(|plant| json!({"plant": plant.name, "reason": plant.reason})).collect();
    let behind = summary.cells.iter().filter(|cell| cell.is_behind());
    json!({
        "machine": machine, "robots": plan.robots, "planners": plan.planners, "seeds": plan.seeds,
        "minutes": plan.minutes, "plants": plants, "refused": refused,
        "summary": {
            "cells": summary.cells.len(),
            "behind": behind.map(cell_json).collect::<Vec<_>>(),
            "groups": summary.groups.iter().map(group_json).collect::<Vec<_>>(),
        },
    })
}

fn plant_json(plan: &Plan, plant: &Plant) -> Value {
    let mut cells = Vec::new();
    for planner in &plan.planners {
        for &robots in &plan.robots {
            let orders = plant.orders_per_hour(planner, robots);
            cells.push(json!({
                "planner": planner, "robots": robots, "orders_per_hour": orders,
            }));
        }
    }
    json!({
        "plant": plant.name, "cells": cells, "failures": plant.failures,
        "runs": plant.runs.iter().map(run_json).collect::<Vec<_>>(),
    })
}

fn run_json(run: &Run) -> Value {
    json!({
        "planner": run.planner, "robots": run.robots, "seed": run.seed,
        "orders_per_hour": run.orders_per_hour, "standstill": run.is_standstill(),
        "waiting": run.waiting, "contacts": run.contacts, "stalls": run.stalls,
        "unserved": run.unserved, "other_findings": run.other_findings,
        "failed_orders": run.failed_orders, "open_orders": run.open_orders,
        "longest_gap_secs": run.longest_gap_secs, "wall_secs": run.wall_secs,
    })
}

fn cell_json(cell: &Cell) -> Value {
    json!({
        "plant": cell.plant, "robots": cell.robots, "first": cell.first, "best": cell.best,
        "best_planner": cell.best_planner, "ratio": cell.ratio(),
    })
}

fn group_json(group: &Group) -> Value {
    json!({
        "kind": group.kind.words(),
        "totals": group.totals.iter().map(total_json).collect::<Vec<_>>(),
        "comparisons": group.comparisons.iter().map(comparison_json).collect::<Vec<_>>(),
    })
}

fn total_json(total: &Total) -> Value {
    json!({
        "planner": total.planner, "runs": total.runs, "standstills": total.standstills,
        "contacts": total.contacts, "unserved": total.unserved,
        "other_findings": total.other_findings,
        "failed_orders": total.failed_orders, "longest_gap_secs": total.longest_gap_secs,
    })
}

fn comparison_json(comparison: &Comparison) -> Value {
    json!({
        "other": comparison.other, "ratio": comparison.ratio, "plants": comparison.plants,
        "both": comparison.both, "only_first": comparison.only_first,
        "only_other": comparison.only_other, "neither": comparison.neither,
    })
}

/// Returns a cell's ratio in words.
fn ratio(cell: &Cell) -> String {
    match cell.ratio() {
        Some(ratio) => format!("{:.0} %", ratio * 100.0),
        None if cell.first > 0.0 => "others 0".to_owned(),
        None => "all 0".to_owned(),
    }
}

/// Returns a number, with a decimal if it is below a hundred.
fn number(value: f64) -> String {
    if value >= 100.0 || value == 0.0 { format!("{value:.0}") } else { format!("{value:.1}") }
}

fn minutes(secs: f64) -> String {
    format!("{:.1} min", secs / 60.0)
}

/// Returns the number of standstills, in bold if there are any.
fn of_runs(total: &Total) -> String {
    let Total { standstills, runs, .. } = total;
    if *standstills == 0 { format!("0 of {runs}") } else { format!("**{standstills}** of {runs}") }
}

/// Returns a name as the text of a cell of a table.
fn escaped(name: &str) -> String {
    name.replace('|', "\\|")
}

/// Returns a text of at most so many characters, with '…' in place of the rest.
pub fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plants::manifest::Kind;

    fn cell(first: f64, best: f64) -> Cell {
        let (plant, best_planner) = ("p".to_owned(), "b".to_owned());
        Cell { plant, robots: 1, first, best, best_planner }
    }

    #[test]
    fn ratios_to_nothing_are_words() {
        assert_eq!(ratio(&cell(19.0, 20.0)), "95 %");
        assert_eq!((&*ratio(&cell(1.0, 0.0)), &*ratio(&cell(0.0, 0.0))), ("others 0", "all 0"));
    }

    #[test]
    fn a_plant_that_holds_fewer_has_a_dash_and_a_failed_run_says_so() {
        let planners = ["a", "b"].map(str::to_owned).to_vec();
        let (robots, limit) = (vec![1, 2, 4], Limit::Room);
        let plan = Plan { robots, limit, planners, seeds: 2, minutes: 60, jobs: None };
        let mut runs = Vec::new();
        for (planner, robots, orders_per_hour) in [("a", 1, 120.0), ("b", 1, 96.0), ("b", 2, 50.0)]
        {
            let planner = planner.to_owned();
            runs.push(Run { planner, robots, orders_per_hour, ..Run::default() });
        }
        let (name, kind) = ("p".to_owned(), Kind::File);
        let plant = Plant { name, kind, runs, failures: Vec::new() };
        let text = table(&plan, &[plant]);
        let rows: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(
            rows,
            [
                "| p | a | 120 (125 %) | **failed** | – | 0 of 1 | 0 | 0.0 min |",
                "| p | b | 96.0 | 50.0 | – | 0 of 2 | 0 | 0.0 min |",
            ]
        );
    }

    #[test]
    fn a_long_text_is_shortened_between_characters() {
        assert_eq!((&*shortened("für", 3), &*shortened("für", 2)), ("für", "fü…"));
    }
}
