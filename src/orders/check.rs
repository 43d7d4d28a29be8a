//! `regatta orders check`: the rows of a file of orders that can't be used, its rates and its
//! flows.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;

use regatta_layout::traffic::{CutOff, MainPart};
use regatta_layout::{NodeIndex, RouteGraph};
use regatta_orders::{Load, Places, Table, TimedDraft, check_orders, read_table};
use regatta_scenario::{Overrides, Scenario};
use serde_json::{Value, json};

use crate::arguments::LayoutArgs;
use crate::day::{has_dwell, places};
use crate::failure::Failure;
use crate::output::show;

/// The section of a scenario with its load.
const LOAD: &str = "load";
/// The exit code of a file with rows that can't be used.
const FOUND: u8 = 1;
/// The most flows of the text; JSON has all.
const MOST_FLOWS: usize = 20;
const HOUR_SECS: f64 = 3600.0;
/// The shortest time that is told in minutes, in seconds.
const LEAST_IN_MINUTES: f64 = 600.0;

/// Checks a file against the stations of a plant.
pub fn run(
    file: &Path,
    plant: &Path,
    layout: &LayoutArgs,
    as_json: bool,
) -> Result<ExitCode, Failure> {
    let overrides = Overrides { layout: layout.options(), ..Overrides::default() };
    let scenario = Scenario::read(plant, &overrides)?;
    let (graph, table) = (&scenario.graph, read_table(file)?);
    let places = with_storages(&scenario, plant, places(graph))?;
    let cut_off = cut_off(graph, &places, &table.orders);
    let check = Check::new(table, &places, &cut_off);
    if as_json {
        println!("{:#}", check.json());
    } else {
        show(check.text(file));
    }
    Ok(if check.problems.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(FOUND) })
}

/// Returns the places with the storages of a scenario's load.
fn with_storages(scenario: &Scenario, plant: &Path, places: Places) -> Result<Places, Failure> {
    if !scenario.source.has(LOAD) {
        return Ok(places);
    }
    let read = Load::places(scenario.source.text(), &places);
    let plant = plant.display();
    read.map_err(|error| format!("{plant}:{}: load: {}", error.line, error.reason).into())
}

/// The findings about a file.
struct Check {
    table: Table,
    /// The lines of rows that can't be used, and the reasons.
    problems: Vec<(usize, String)>,
    /// The number of orders whose rows have no problem.
    orders: usize,
    /// Orders by the hour of their creation; hours without one aren't there.
    hours: BTreeMap<u64, u64>,
    /// Orders by two stops that follow each other.
    flows: BTreeMap<[String; 2], u64>,
    /// The time without an order that is the longest between two orders: its start and its end.
    gap: Option<[f64; 2]>,
}

impl Check {
    fn new(table: Table, places: &Places, cut_off: &BTreeMap<NodeIndex, CutOff>) -> Self {
        let problems = table.problems.iter().map(|error| (error.line, error.reason.clone()));
        let mut problems: Vec<(usize, String)> = problems.collect();
        for order in &table.orders {
            problems.extend(problems_of(order, places));
            problems.extend(stops_without_way(order, places, cut_off));
        }
        let bad_lines: BTreeSet<usize> = problems.iter().map(|(line, _)| *line).collect();
        let (mut hours, mut flows) = (BTreeMap::new(), BTreeMap::new());
        let good = table.orders.iter().filter(|order| !bad_lines.contains(&order.line));
        let (mut times, names) = (Vec::new(), names(good.clone(), places));
        for order in good {
            *hours.entry((order.secs / HOUR_SECS) as u64).or_default() += 1;
            for [from, to] in stops(order, places, &names).array_windows() {
                *flows.entry([from.clone(), to.clone()]).or_default() += 1;
            }
            times.push(order.secs);
        }
        problems.sort_by_key(|(line, _)| *line);
        times.sort_by(f64::total_cmp);
        let gaps = times.windows(2).map(|pair| [pair[0], pair[1]]);
        let gap = gaps.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        Self { table, problems, orders: times.len(), hours, flows, gap }
    }

    /// The lines of the hours from the first to the last, with their orders; one line for several
    /// hours without orders.
    fn by_hour(&self) -> String {
        let (mut text, mut next) = (String::new(), None);
        for (&hour, orders) in &self.hours {
            // Writing to a `String` never fails.
            let _ = match hour - next.unwrap_or(hour) {
                0 => Ok(()),
                1 => writeln!(text, "{:>4}  {:>6}", hour - 1, 0),
                empty => writeln!(text, "{:>4} to {}: none", hour - empty, hour - 1),
            };
            let _ = writeln!(text, "{hour:>4}  {orders:>6}");
            next = Some(hour + 1);
        }
        text
    }

    /// The flows, the largest first.
    fn by_size(&self) -> Vec<(&[String; 2], u64)> {
        let mut flows: Vec<_> = self.flows.iter().map(|(ends, count)| (ends, *count)).collect();
        flows.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        flows
    }

    fn json(&self) -> Value {
        let columns: BTreeMap<&str, &str> = self
            .table
            .columns
            .guessed()
            .map(|(header, meaning)| (header, meaning.name()))
            .collect();
        let rows =
            self.problems.iter().map(|(line, reason)| json!({"line": line, "reason": reason}));
        let hours = self.hours.iter();
        let hours = hours.map(|(hour, orders)| json!({"hour": hour, "orders": orders}));
        let flows = self
            .by_size()
            .into_iter()
            .map(|([from, to], orders)| json!({"from": from, "to": to, "orders": orders}));
        json!({
            "orders": self.orders,
            "columns": columns,
            "unused_columns": self.table.columns.unused().collect::<Vec<_>>(),
            "hidden_rows": self.table.hidden_rows,
            "notes": self.table.notes,
            "midnight_line": self.table.midnight_line,
            "begin": self.table.begin.map(|begin| begin.to_string()),
            "problems": rows.collect::<Vec<_>>(),
            "hours": hours.collect::<Vec<_>>(),
            "flows": flows.collect::<Vec<_>>(),
            "longest_gap_secs": self.gap,
        })
    }

    fn text(&self, file: &Path) -> String {
        // Writing to a `String` never fails.
        let mut text = self.columns();
        for (line, reason) in &self.problems {
            let _ = writeln!(text, "{}, line {line}: {reason}", file.display());
        }
        let (orders, problems) = (self.orders, self.problems.len());
        let _ = writeln!(text, "orders        {orders}, problems {problems}");
        if let Some(begin) = &self.table.begin {
            let _ = writeln!(text, "start         {begin}, which is time 0 of a run");
        }
        if let Some(line) = self.table.midnight_line {
            let _ = writeln!(text, "midnight      from line {line} on, times are of the next day");
        }
        if let Some([from, to]) = self.gap {
            let (gap, from) = (in_words(to - from), from / HOUR_SECS);
            let _ =
                writeln!(text, "longest gap   {gap} without an order, {from:.1} h after the start");
        }
        if !has_dwell(&self.table.orders) {
            text +=
                "time at stops none in the file: robots spend 0 s there, unless a load gives it\n";
        }
        text += "\nhour  orders\n";
        text += &self.by_hour();
        text += "\norders  from → to\n";
        let flows = self.by_size();
        for ([from, to], orders) in flows.iter().take(MOST_FLOWS) {
            let _ = writeln!(text, "{orders:>6}  {from} → {to}");
        }
        if let Some(more) = flows.len().checked_sub(MOST_FLOWS).filter(|more| *more > 0) {
            let _ = writeln!(text, "        and {more} more flows: --json has all");
        }
        text
    }

    /// The columns that are used and not used.
    fn columns(&self) -> String {
        let columns = &self.table.columns;
        let guessed = columns.guessed().map(|(header, meaning)| match meaning.name() {
            name if name.eq_ignore_ascii_case(header) => name.to_owned(),
            name => format!("{header} = {name}"),
        });
        let guessed: Vec<String> = guessed.collect();
        let unused: Vec<&str> = columns.unused().collect();
        let mut text = String::new();
        if !guessed.is_empty() {
            let _ = writeln!(text, "columns       {}", guessed.join(", "));
        }
        if !unused.is_empty() {
            let _ = writeln!(text, "not used      {}", unused.join(", "));
        }
        match (columns.have_times(), self.table.has_times) {
            _ if text.is_empty() => {}
            (false, _) => text += "time          in no column: all orders come at time 0\n",
            (true, false) => text += "time          in no row: all orders come at time 0\n",
            (true, true) => {}
        }
        let sheets = &self.table.unread_sheets;
        if !sheets.is_empty() {
            let _ = writeln!(text, "not read      the sheets {}", sheets.join(", "));
        }
        if self.table.hidden_rows > 0 {
            let _ = writeln!(
                text,
                "hidden rows   {}, which a filter of the workbook hides, or someone by hand: they \
                 are read as all others",
                self.table.hidden_rows
            );
        }
        for note in &self.table.notes {
            let _ = writeln!(text, "numbers       {note}");
        }
        text
    }
}

/// Returns a time in seconds, minutes, hours or days.
fn in_words(secs: f64) -> String {
    match secs / HOUR_SECS {
        _ if secs < LEAST_IN_MINUTES => format!("{secs:.0} s"),
        ..10.0 => format!("{:.0} min", secs / 60.0),
        hours @ ..48.0 => format!("{hours:.1} h"),
        hours => format!("{:.0} days", hours / 24.0),
    }
}

/// Returns the reasons why a fleet manager refuses an order, with its line.
fn problems_of(order: &TimedDraft, places: &Places) -> Vec<(usize, String)> {
    let unknown = unknown_stations(order, places);
    match check_orders(std::slice::from_ref(order), places) {
        Err(error) if unknown.is_empty() => vec![(error.line, error.reason)],
        _ => unknown,
    }
}

/// Returns the stops of an order that the plant doesn't have, with the line of the order.
fn unknown_stations(order: &TimedDraft, places: &Places) -> Vec<(usize, String)> {
    let mut unknown = Vec::new();
    for (stop, number) in order.draft.destinations.iter().zip(1..) {
        if let Err(error) = places.find_one(&stop.location_name.to_string()) {
            unknown.push((order.line, format!("stop {number}: {error}; correct it, or the plant")));
        }
    }
    unknown
}

/// Returns the nodes that robots can't drive to from the main part of the roads and back: that with
/// the most stops of the orders, as in a study.
fn cut_off(
    graph: &RouteGraph,
    places: &Places,
    orders: &[TimedDraft],
) -> BTreeMap<NodeIndex, CutOff> {
    let stops = orders.iter().flat_map(|order| &order.draft.destinations);
    let found = stops.filter_map(|stop| places.find(&stop.location_name.to_string()));
    let nodes = found.flat_map(|node| places.nodes_at(node));
    let wanted: BTreeSet<NodeIndex> = nodes.map(NodeIndex).collect();
    let wanted: Vec<NodeIndex> = wanted.into_iter().collect();
    match MainPart::around(graph, &wanted) {
        Some(main) => main.cut_off,
        // No road leads back to where it began: each node can be served once at most.
        None => wanted.into_iter().map(|node| (node, CutOff::CannotBeLeft)).collect(),
    }
}

/// Returns the stops of an order that robots can't drive to and back, with the line of the order.
fn stops_without_way(
    order: &TimedDraft,
    places: &Places,
    cut_off: &BTreeMap<NodeIndex, CutOff>,
) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (stop, number) in order.draft.destinations.iter().zip(1..) {
        let name = stop.location_name.to_string();
        let Ok(node) = places.find_one(&name) else { continue };
        let mut nodes = places.nodes_at(node).into_iter();
        if let Some(cut_off) = nodes.find_map(|node| cut_off.get(&NodeIndex(node))) {
            let way = cut_off.missing_way();
            let reason =
                format!("stop {number}: robots can't serve `{name}`, as {way}; connect it");
            found.push((order.line, reason));
        }
    }
    found
}

/// The names of the nodes of orders: that of the file if it calls a node by one name only, and that
/// of the plant otherwise.
fn names<'a>(
    orders: impl Iterator<Item = &'a TimedDraft>,
    places: &Places,
) -> BTreeMap<u32, String> {
    let mut names: BTreeMap<u32, String> = BTreeMap::new();
    for stop in orders.flat_map(|order| &order.draft.destinations) {
        let name = stop.location_name.to_string();
        let Some(node) = places.find(&name) else { continue };
        let known = names.entry(node).or_insert_with(|| name.clone());
        if *known != name {
            *known = places.label(node);
        }
    }
    names
}

/// The stops of an order, by the names of their nodes.
fn stops(order: &TimedDraft, places: &Places, names: &BTreeMap<u32, String>) -> Vec<String> {
    let stops = order.draft.destinations.iter().map(|stop| stop.location_name.to_string());
    let named = stops.map(|name| {
        let found = places.find(&name).and_then(|node| names.get(&node));
        found.cloned().unwrap_or(name)
    });
    named.collect()
}
