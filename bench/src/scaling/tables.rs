//! Tables and plots of growing costs.

use std::fmt::Write as _;

use regatta::experiment::plot::{self, Chart, Scale, Series};
use regatta::failure::Failure;
use serde_json::{Value, json};

use super::engine::Cost;

/// A line of a table: a quantity, and what it costs.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// The quantity: robots, threads, …
    amount: u64,
    /// The milliseconds of a tick, or of a run.
    each_ms: f64,
    kind: Kind,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    Tick(Cost),
    Study { secs: f64 },
}

/// The lines of a quantity, in one series or several.
pub struct Table {
    title: &'static str,
    /// The name of the quantity.
    quantity: &'static str,
    note: String,
    /// The columns after the quantity.
    columns: &'static str,
    series: Vec<Lines>,
}

/// The lines of a series.
#[derive(Default)]
struct Lines {
    name: String,
    lines: Vec<Line>,
}

impl Line {
    /// The cost of a tick with so many robots, threads, …
    pub fn of_tick(amount: u64, cost: Cost) -> Self {
        Self { amount, each_ms: cost.p50_ms, kind: Kind::Tick(cost) }
    }

    /// The wall time of a study of so many runs, in seconds.
    pub fn of_study(runs: u64, secs: f64) -> Self {
        Self { amount: runs, each_ms: secs * 1e3 / runs as f64, kind: Kind::Study { secs } }
    }

    /// The milliseconds of a tick, or of a whole study.
    fn total_ms(&self) -> f64 {
        match self.kind {
            Kind::Tick(_) => self.each_ms,
            Kind::Study { secs } => secs * 1e3,
        }
    }

    /// The microseconds that each further robot, thread, … has cost since the line before.
    fn slope_us(&self, before: &Self) -> f64 {
        let more = self.amount.saturating_sub(before.amount);
        (self.total_ms() - before.total_ms()) * 1e3 / more as f64
    }

    fn cells(&self, before: Option<&Self>) -> String {
        let slope = before.map_or_else(String::new, |before| rounded(self.slope_us(before)));
        match self.kind {
            Kind::Tick(cost) => format!(
                "{} | {} ms | {} ms | {} of {} | {:.0} MB | {slope} |",
                self.amount,
                rounded(cost.p50_ms),
                rounded(cost.p99_ms),
                cost.late_ticks,
                cost.ticks,
                cost.megabytes
            ),
            Kind::Study { secs } => {
                format!("{} | {secs:.1} s | {} ms | {slope} |", self.amount, rounded(self.each_ms))
            }
        }
    }

    fn json(&self) -> Value {
        match self.kind {
            Kind::Tick(cost) => json!({
                "amount": self.amount, "tick_cost_p50_ms": cost.p50_ms,
                "tick_cost_p99_ms": cost.p99_ms, "late_ticks": cost.late_ticks,
                "ticks": cost.ticks, "resident_megabytes": cost.megabytes,
            }),
            Kind::Study { secs } => json!({"amount": self.amount, "secs": secs}),
        }
    }
}

impl Table {
    /// A table of the cost of ticks.
    pub fn of_ticks(title: &'static str, quantity: &'static str, note: &str) -> Self {
        let columns = "tick p50 | tick p99 | late ticks | memory | each further one, µs |\n\
                       |---|---|---|---|---|---|---|\n";
        Self { title, quantity, note: note.to_owned(), columns, series: Vec::new() }
    }

    /// A table of the time of studies.
    pub fn of_studies(note: &str) -> Self {
        let columns = "study | a run | each further one, µs |\n|---|---|---|---|---|\n";
        let note = note.to_owned();
        Self { title: "Runs of a study", quantity: "runs", note, columns, series: Vec::new() }
    }

    /// Names a series.
    pub fn name(&mut self, series: usize, name: String) {
        self.series_mut(series).name = name;
    }

    /// Adds a line to a series.
    pub fn add(&mut self, series: usize, line: Line) {
        self.series_mut(series).lines.push(line);
    }

    fn series_mut(&mut self, series: usize) -> &mut Lines {
        self.series.resize_with(self.series.len().max(series + 1), Lines::default);
        &mut self.series[series]
    }

    /// Returns the figures.
    pub fn json(&self) -> Value {
        let series = self.series.iter().map(|series| {
            let lines: Vec<_> = series.lines.iter().map(Line::json).collect();
            json!({"name": series.name, "lines": lines})
        });
        let series: Vec<_> = series.collect();
        json!({"quantity": self.quantity, "series": series})
    }

    fn markdown(&self) -> String {
        let Self { title, quantity, note, columns, .. } = self;
        let mut text = format!("## {title}\n\n{note}\n\n| | {quantity} | {columns}");
        for Lines { name, lines } in &self.series {
            let mut before = None;
            for line in lines {
                let _ = writeln!(text, "| {name} | {}", line.cells(before));
                before = Some(line);
            }
        }
        text + "\n"
    }

    fn chart(&self) -> Chart<'_> {
        let series = self.series.iter().map(|Lines { name, lines }| Series {
            name: if name.is_empty() { "median".to_owned() } else { name.clone() },
            points: lines.iter().map(|line| (line.amount as f64, line.each_ms)).collect(),
        });
        let y = match self.series.first().and_then(|series| series.lines.first()) {
            Some(Line { kind: Kind::Study { .. }, .. }) => "milliseconds for a run",
            _ => "milliseconds for a tick",
        };
        Chart {
            caption: self.title,
            x: self.quantity,
            y,
            scale: Scale::Logarithmic,
            series: series.collect(),
        }
    }
}

/// Returns a figure with three digits.
fn rounded(value: f64) -> String {
    let digits = match value.abs() {
        value if value >= 100.0 => 0,
        value if value >= 10.0 => 1,
        value if value >= 1.0 => 2,
        value if value >= 0.1 => 3,
        _ => 4,
    };
    format!("{value:.digits$}")
}

/// Returns the report's text.
pub fn markdown(tables: &[Table], environment: &str) -> String {
    let mut text = format!(
        "# Scaling\n\n{environment}\n\nFleets on random routes of generated warehouses. A tick is \
         late when it ends after the next one is due.\n\n"
    );
    text.extend(tables.iter().map(Table::markdown));
    text + "![Scaling](scaling.svg)\n"
}

/// Draws a chart for each table, two in a row.
pub fn plot(tables: &[Table]) -> Result<String, Failure> {
    let charts: Vec<_> = tables.iter().map(Table::chart).collect();
    plot::grid(&charts.iter().collect::<Vec<_>>())
}
