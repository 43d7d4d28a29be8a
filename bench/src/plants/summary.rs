//! The arithmetic of the report: the first planner beside the others, on all plants.

use super::Plan;
use super::manifest::Kind;
use super::measure::Run;

/// The first planner is behind if it carries less than this part of the best of the others.
pub const BEHIND: f64 = 0.95;

/// A plant that was measured.
pub struct Plant {
    pub name: String,
    pub kind: Kind,
    pub runs: Vec<Run>,
    pub failures: Vec<String>,
}

/// The first planner and the best of the others on a plant with a number of robots.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    pub plant: String,
    pub robots: u32,
    /// Orders an hour with the first planner.
    pub first: f64,
    /// The same with the best of the others.
    pub best: f64,
    pub best_planner: String,
}

/// All runs with a planner, added up.
#[derive(Debug, Default, PartialEq)]
pub struct Total {
    pub planner: String,
    pub runs: usize,
    pub standstills: usize,
    pub contacts: u64,
    pub unserved: u64,
    pub other_findings: u64,
    pub failed_orders: u64,
    pub longest_gap_secs: f64,
}

/// The first planner beside another one. Each cell is in one of the four counts.
#[derive(Debug, Default, PartialEq)]
pub struct Comparison {
    pub other: String,
    /// The geometric mean over plants of the geometric means over their cells where both carry
    /// orders; `None` if there are no such cells.
    pub ratio: Option<f64>,
    /// Plants with such cells.
    pub plants: usize,
    /// Cells where both carry orders.
    pub both: usize,
    pub only_first: usize,
    pub only_other: usize,
    pub neither: usize,
}

/// The figures of all plants of a kind.
pub struct Group {
    pub kind: Kind,
    pub totals: Vec<Total>,
    pub comparisons: Vec<Comparison>,
}

/// The figures of all plants.
pub struct Summary {
    /// Cells where the first planner and another one were measured.
    pub cells: Vec<Cell>,
    /// One for each kind of which there are plants.
    pub groups: Vec<Group>,
}

impl Run {
    /// Whether robots with orders made no progress for a long time, or nothing was carried after
    /// the warm-up, although there were orders.
    pub fn is_standstill(&self) -> bool {
        self.stalls > 0 || (self.orders_per_hour == 0.0 && self.open_orders > 0)
    }
}

impl Plant {
    /// Returns all runs with a planner.
    pub fn runs_with<'a>(&'a self, planner: &'a str) -> impl Iterator<Item = &'a Run> {
        self.runs.iter().filter(move |run| run.planner == planner)
    }

    /// Returns the mean orders an hour of a cell; `None` if no run has ended.
    pub fn orders_per_hour(&self, planner: &str, robots: u32) -> Option<f64> {
        let runs = self.runs_with(planner).filter(|run| run.robots == robots);
        mean(runs.map(|run| run.orders_per_hour))
    }

    /// Whether a run with this number of robots has ended.
    pub fn holds(&self, robots: u32) -> bool {
        self.runs.iter().any(|run| run.robots == robots)
    }

    /// Compares the first planner with the others; `None` if one side wasn't measured.
    pub fn cell(&self, planners: &[String], robots: u32) -> Option<Cell> {
        let (first, others) = planners.split_first()?;
        let figures = others
            .iter()
            .filter_map(|other| Some((other, self.orders_per_hour(other, robots)?)))
            // Of equal ones, the first one.
            .reduce(|best, other| if other.1 > best.1 { other } else { best });
        let (best_planner, best) = figures?;
        Some(Cell {
            plant: self.name.clone(),
            robots,
            first: self.orders_per_hour(first, robots)?,
            best,
            best_planner: best_planner.clone(),
        })
    }
}

impl Cell {
    /// Returns the first planner's part of the best; `None` if the others carry nothing.
    pub fn ratio(&self) -> Option<f64> {
        (self.best > 0.0).then(|| self.first / self.best)
    }

    /// Whether the first planner carries clearly less than the best of the others.
    pub fn is_behind(&self) -> bool {
        self.first < BEHIND * self.best
    }
}

impl Total {
    fn new(planner: &str, plants: &[&Plant]) -> Self {
        let mut total = Self { planner: planner.to_owned(), ..Self::default() };
        for run in plants.iter().flat_map(|plant| plant.runs_with(planner)) {
            total.add(run);
        }
        total
    }

    /// Returns the runs of one plant, added up.
    pub fn of_plant(planner: &str, plant: &Plant) -> Self {
        Self::new(planner, &[plant])
    }

    fn add(&mut self, run: &Run) {
        self.runs += 1;
        self.standstills += usize::from(run.is_standstill());
        self.contacts += run.contacts;
        self.unserved += run.unserved;
        self.other_findings += run.other_findings;
        self.failed_orders += run.failed_orders;
        self.longest_gap_secs = self.longest_gap_secs.max(run.longest_gap_secs);
    }
}

impl Comparison {
    fn new(first: &str, other: &str, robots: &[u32], plants: &[&Plant]) -> Self {
        let mut comparison = Self { other: other.to_owned(), ..Self::default() };
        let mut of_plants = Vec::new();
        for plant in plants {
            let mut ratios = Vec::new();
            for &robots in robots {
                let figures = [first, other].map(|name| plant.orders_per_hour(name, robots));
                if let [Some(first), Some(other)] = figures {
                    ratios.extend(comparison.count(first, other));
                }
            }
            of_plants.extend(geometric_mean(&ratios));
        }
        comparison.plants = of_plants.len();
        comparison.ratio = geometric_mean(&of_plants);
        comparison
    }

    /// Counts a cell, and returns its ratio if both carry orders.
    fn count(&mut self, first: f64, other: f64) -> Option<f64> {
        let count = match (first > 0.0, other > 0.0) {
            (true, true) => &mut self.both,
            (true, false) => &mut self.only_first,
            (false, true) => &mut self.only_other,
            (false, false) => &mut self.neither,
        };
        *count += 1;
        (first > 0.0 && other > 0.0).then(|| first / other)
    }
}

impl Summary {
    pub fn new(plan: &Plan, plants: &[Plant]) -> Self {
        let mut cells = Vec::new();
        for plant in plants {
            cells.extend(plan.robots.iter().filter_map(|&n| plant.cell(&plan.planners, n)));
        }
        let kinds = [Kind::File, Kind::Generated].into_iter();
        Self { cells, groups: kinds.filter_map(|kind| Group::new(plan, kind, plants)).collect() }
    }
}

impl Group {
    fn new(plan: &Plan, kind: Kind, plants: &[Plant]) -> Option<Self> {
        let plants: Vec<&Plant> = plants.iter().filter(|plant| plant.kind == kind).collect();
        if plants.is_empty() {
            return None;
        }
        let totals = plan.planners.iter().map(|planner| Total::new(planner, &plants));
        let (first, others) = plan.planners.split_at(1.min(plan.planners.len()));
        let comparisons =
            others.iter().map(|other| Comparison::new(&first[0], other, &plan.robots, &plants));
        Some(Self { kind, totals: totals.collect(), comparisons: comparisons.collect() })
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn geometric_mean(values: &[f64]) -> Option<f64> {
    mean(values.iter().map(|value| value.ln())).map(f64::exp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plants::Limit;

    /// A plant with one run per planner and number of robots, from 1 on.
    fn plant(name: &str, figures: [&[f64]; 3]) -> Plant {
        let mut runs = Vec::new();
        for (planner, figures) in ["a", "b", "c"].iter().zip(figures) {
            for (robots, orders_per_hour) in (1..).zip(figures) {
                let (planner, orders_per_hour) = ((*planner).to_owned(), *orders_per_hour);
                let run =
                    Run { planner, robots, orders_per_hour, open_orders: 1, ..Run::default() };
                runs.push(run);
            }
        }
        Plant { name: name.to_owned(), kind: Kind::File, runs, failures: Vec::new() }
    }

    fn plan() -> Plan {
        let planners = ["a", "b", "c"].map(str::to_owned).to_vec();
        let (robots, limit) = (vec![1, 2, 3], Limit::Room);
        Plan { robots, limit, planners, seeds: 2, minutes: 60, jobs: None }
    }

    #[test]
    fn cells_are_means_over_seeds_and_missing_if_no_run_has_ended() {
        let mut plant = plant("p", [&[10.0], &[20.0], &[]]);
        plant.runs.push(Run { orders_per_hour: 40.0, ..plant.runs[0].clone() });
        assert_eq!(plant.orders_per_hour("a", 1), Some(25.0));
        assert_eq!(plant.orders_per_hour("a", 2), None);
        assert!(plant.holds(1) && !plant.holds(2));
    }

    #[test]
    fn the_first_planner_is_beside_the_best_of_the_others() {
        let plant = plant("p", [&[94.0, 0.0, 5.0], &[100.0, 0.0, 0.0], &[90.0, 0.0, 0.0]]);
        let cells = Summary::new(&plan(), &[plant]).cells;
        let best: Vec<&str> = cells.iter().map(|cell| &*cell.best_planner).collect();
        assert_eq!(best, ["b", "b", "b"]);
        assert_eq!(cells[0].ratio(), Some(0.94));
        assert_eq!((cells[1].ratio(), cells[2].ratio()), (None, None));
        let behind: Vec<bool> = cells.iter().map(Cell::is_behind).collect();
        assert_eq!(behind, [true, false, false]);
    }

    #[test]
    fn plants_count_alike_and_cells_without_orders_are_counted_apart() {
        let plants = [
            // Ratios to b of 2 and 8: 4 on this plant. Neither carries with 3 robots.
            plant("p", [&[20.0, 80.0, 0.0], &[10.0, 10.0, 0.0], &[]]),
            // A ratio of 1; a cell each that only one of them carries in.
            plant("q", [&[7.0, 7.0, 0.0], &[7.0, 0.0, 7.0], &[]]),
            // No cell where both carry.
            plant("r", [&[0.0], &[7.0], &[]]),
        ];
        let comparisons = &Summary::new(&plan(), &plants).groups[0].comparisons;
        let Comparison { ratio, plants, both, only_first, only_other, neither, .. } =
            &comparisons[0];
        assert!((ratio.expect("cells") - 2.0).abs() < 1e-12, "{ratio:?}");
        assert_eq!((*plants, *both, *only_first, *only_other, *neither), (2, 3, 1, 2, 1));
        assert_eq!(comparisons[1], Comparison { other: "c".to_owned(), ..Comparison::default() });
    }

    #[test]
    fn a_run_without_orders_is_no_standstill() {
        let mut plant = plant("p", [&[0.0, 0.0, 3.0], &[], &[]]);
        plant.runs[1].open_orders = 0;
        let total = Total::of_plant("a", &plant);
        assert_eq!((total.runs, total.standstills), (3, 1));
    }
}
