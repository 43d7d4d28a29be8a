//! The report's tables, each figure beside the bar that it is to reach.

use std::fmt::Write as _;

use super::measurement::{MAX_ACCELERATION, Measured, STALL_SECS, STALLS_PER_HOUR, Setup};
use super::parts::{self, Part, Row};
use super::{Plan, Results};

/// A bar that a row should reach.
enum Bar {
    /// At least this part of the bound.
    OfBound(f64),
    /// At least so many goals a second.
    Goals(f64),
}

/// The bars of throughput, by the number of robots.
const THROUGHPUT: [(u32, Bar); 4] = [
    (200, Bar::OfBound(0.95)),
    (300, Bar::OfBound(0.9)),
    (500, Bar::Goals(3.6)),
    (1000, Bar::Goals(3.2)),
];
/// The fleet whose breakdowns and speed have bars.
const USUAL_ROBOTS: u32 = 300;
/// The bars of breakdowns: the part of the undisturbed figure, by the number of broken robots.
const UNDISTURBED: [(u32, f64); 3] = [(1, 0.95), (5, 0.92), (20, 0.75)];
/// The longest time that a robot may go without finishing an order, in seconds.
const UNSERVED_SECS: f64 = 1200.0;
/// Of a thousand robots and of ten thousand: the part of a core that the manager may take at 10 Hz.
const BUSY: [(u32, f64); 2] = [(1000, 0.05), (10_000, 0.5)];
const LONGEST_CYCLE_MS: f64 = 100.0;
const REAL_TIME_FACTOR: f64 = 300.0;
/// Cycles a second.
const MANAGER_HZ: f64 = 10.0;

pub fn markdown(plan: &Plan, results: &Results, site: &str, environment: &str) -> String {
    let seeds: Vec<_> = plan.seeds.iter().map(u64::to_string).collect();
    let setup = Setup { secs: plan.secs, ..Setup::of(1) };
    let mut text = format!(
        "# The fleet manager\n\n{environment}\n\n\
         Engine, fleet manager and validator are separate processes in lockstep, at `--speed \
         max`. {site}; {} s a run, of which the first {} s don't count for throughput; seeds {}. \
         Figures are means over the seeds, with the lowest and the highest in brackets; longest \
         times are the longest of all seeds, contacts the sum. Robots of 0.9 m × 0.6 m drive from \
         one random node to the next (the load `endless: robots`, without dwell) as fast as the \
         roads allow. Robots get orders in turn, wherever they are. By default the nearest robot \
         gets an order, which would give several times as many. Some have an acceleration limit \
         of {MAX_ACCELERATION} m/s². 'Bound' is the same run with conflicts switched off: robots \
         drive through each other. 'Busy' is the part of a core that the cycles of the manager \
         take at 10 Hz, by wall time. It is too high on a machine that does other work. The bars \
         are those that the project has set itself.\n",
        plan.secs,
        setup.warm_up_secs(),
        seeds.join(", "),
    );
    for part in &plan.parts {
        text.push_str(&match part {
            Part::Throughput => throughput(plan, results),
            Part::Stalls => stalls(plan, results),
            Part::Breakdowns => breakdowns(plan, results),
            Part::Hour => hour(plan, results),
            Part::Large => large(plan, results),
        });
    }
    if !results.failed.is_empty() {
        text.push_str("\n## Runs that failed\n\nThe figures leave these runs out.\n\n");
        for (setup, reason) in &results.failed {
            let _ = writeln!(text, "- {setup}: {reason}");
        }
    }
    text
}

/// The figures of a row: those of all seeds that there are.
fn runs<'a>(results: &'a Results, row: &Row) -> Vec<&'a Measured> {
    row.iter().filter_map(|setup| results.measured.get(setup)).collect()
}

/// The mean of a figure over a row; `None` if no run of it succeeded.
pub fn mean_of(results: &Results, row: &Row, select: impl Fn(&Measured) -> f64) -> Option<f64> {
    mean(&runs(results, row), select)
}

fn mean(runs: &[&Measured], select: impl Fn(&Measured) -> f64) -> Option<f64> {
    (!runs.is_empty()).then(|| runs.iter().map(|run| select(run)).sum::<f64>() / runs.len() as f64)
}

fn longest(runs: &[&Measured], select: impl Fn(&Measured) -> f64) -> f64 {
    runs.iter().map(|run| select(run)).fold(0.0, f64::max)
}

/// The mean with the lowest and the highest.
fn spread(runs: &[&Measured], select: impl Fn(&Measured) -> f64) -> String {
    let Some(mean) = mean(runs, &select) else { return "–".to_owned() };
    let lowest = runs.iter().map(|run| select(run)).fold(f64::INFINITY, f64::min);
    match runs.len() {
        1 => format!("{mean:.2}"),
        _ => format!("{mean:.2} ({lowest:.2} to {:.2})", longest(runs, &select)),
    }
}

fn verdict(bar: &str, is_met: bool) -> String {
    format!("{bar}: {}", if is_met { "met" } else { "**missed**" })
}

fn goals(run: &Measured) -> f64 {
    run.goals_per_sec
}

fn contacts(runs: &[&Measured]) -> String {
    if runs.is_empty() {
        return "–".to_owned();
    }
    let contacts: u64 = runs.iter().map(|run| run.contacts).sum();
    if contacts == 0 { "0".to_owned() } else { format!("**{contacts}**") }
}

/// All findings but contacts, added up over a row.
fn others(runs: &[&Measured]) -> String {
    let mut sums: Vec<(&str, u64)> = Vec::new();
    for (kind, count) in runs.iter().flat_map(|run| &run.other_findings) {
        match sums.iter_mut().find(|(known, _)| known == kind) {
            Some((_, sum)) => *sum += count,
            None => sums.push((kind, *count)),
        }
    }
    if runs.is_empty() {
        return "–".to_owned();
    }
    let texts: Vec<_> = sums.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
    if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
}

fn limit(setup: &Setup) -> String {
    if setup.limited { format!("{MAX_ACCELERATION} m/s²") } else { "at once".to_owned() }
}

fn percent(part: Option<f64>) -> String {
    part.map_or("–".to_owned(), |part| format!("{:.0} %", part * 100.0))
}

fn unserved(runs: &[&Measured]) -> String {
    if runs.is_empty() {
        return "–".to_owned();
    }
    let secs = longest(runs, |run| run.longest_without_finish_secs);
    let mark = if secs <= UNSERVED_SECS { "" } else { " (**missed**)" };
    format!("{:.1} min{mark}", secs / 60.0)
}

fn busy(runs: &[&Measured], robots: u32) -> String {
    let Some(busy) = mean(runs, |run| run.mean_cycle_ms * 1e-3 * MANAGER_HZ) else {
        return "–".to_owned();
    };
    let text = format!("{:.1} %", busy * 100.0);
    match BUSY.iter().find(|(size, _)| *size == robots) {
        Some((_, bar)) => format!("{text} ({})", verdict(&percent(Some(*bar)), busy <= *bar)),
        None => text,
    }
}

fn throughput(plan: &Plan, results: &Results) -> String {
    let mut text = String::from(
        "\n## Throughput\n\n\
         | robots | acceleration | goals/s | bound | of it | bar | longest without a finished \
         order (bar: 20 min) | a cycle | longest cycle | busy | contacts | other findings |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for limited in [false, true] {
        let bounds = parts::throughput_rows(plan, limited, false);
        for (row, bound) in parts::throughput_rows(plan, limited, true).iter().zip(bounds) {
            throughput_row(&mut text, &row[0], &runs(results, row), &runs(results, &bound));
        }
    }
    text.push_str("\n![Throughput and effort over the number of robots](management.svg)\n");
    text
}

fn throughput_row(text: &mut String, setup: &Setup, runs: &[&Measured], bound: &[&Measured]) {
    let part = mean(runs, goals).zip(mean(bound, goals)).map(|(goals, bound)| goals / bound);
    let bar = THROUGHPUT.iter().find(|(robots, _)| *robots == setup.robots && !setup.limited);
    let bar = bar.map_or("–".to_owned(), |(_, bar)| match bar {
        Bar::OfBound(bar) => verdict(&percent(Some(*bar)), part >= Some(*bar)),
        Bar::Goals(bar) => verdict(&bar.to_string(), mean(runs, goals) >= Some(*bar)),
    });
    let _ = writeln!(
        text,
        "| {} | {} | {} | {} | {} | {bar} | {} | {} ms | {:.1} ms | {} | {} | {} |",
        setup.robots,
        limit(setup),
        spread(runs, goals),
        spread(bound, goals),
        percent(part),
        unserved(runs),
        spread(runs, |run| run.mean_cycle_ms),
        longest(runs, |run| run.longest_cycle_ms),
        busy(runs, if setup.limited { 0 } else { setup.robots }),
        contacts(runs),
        others(runs),
    );
}

fn stalls(plan: &Plan, results: &Results) -> String {
    let mut text = format!(
        "\n## Stalls\n\nA part of the robots stops {STALLS_PER_HOUR} times an hour each, for \
         {STALL_SECS} s on average. Bar: no contact.\n\n\
         | robots | acceleration | stall | goals/s | longest without a finished order (bar: 20 \
         min) | contacts | other findings |\n\
         |---|---|---|---|---|---|---|\n"
    );
    for row in parts::stall_rows(plan) {
        let (setup, runs) = (row[0], runs(results, &row));
        let _ = writeln!(
            text,
            "| {} | {} | {} % | {} | {} | {} | {} |",
            setup.robots,
            limit(&setup),
            setup.stalling_percent,
            spread(&runs, goals),
            unserved(&runs),
            contacts(&runs),
            others(&runs),
        );
    }
    text
}

fn breakdowns(plan: &Plan, results: &Results) -> String {
    let mut text = String::from(
        "\n## Breakdowns\n\nRobots break down at the end of the warm-up, where they are, and are \
         not repaired.\n\n\
         | robots | broken | goals/s | of the undisturbed figure | bar | contacts | other \
         findings |\n|---|---|---|---|---|---|---|\n",
    );
    let rows = parts::breakdown_rows(plan);
    for row in &rows {
        let (setup, runs) = (row[0], runs(results, row));
        let undisturbed =
            rows.iter().find(|other| other[0].robots == setup.robots && other[0].broken == 0);
        let undisturbed = undisturbed.and_then(|row| mean_of(results, row, goals));
        let part =
            mean(&runs, goals).zip(undisturbed).map(|(goals, undisturbed)| goals / undisturbed);
        let bar = UNDISTURBED
            .iter()
            .find(|(broken, _)| *broken == setup.broken && setup.robots == USUAL_ROBOTS);
        let bar = bar
            .map_or("–".to_owned(), |(_, bar)| verdict(&percent(Some(*bar)), part >= Some(*bar)));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {bar} | {} | {} |",
            setup.robots,
            setup.broken,
            spread(&runs, goals),
            percent(part),
            contacts(&runs),
            others(&runs),
        );
    }
    text
}

fn hour(plan: &Plan, results: &Results) -> String {
    let mut text = String::from(
        "\n## Speed in lockstep\n\n| robots | times real time | bar | a cycle of the manager | \
         contacts |\n|---|---|---|---|---|\n",
    );
    for row in parts::hour_rows(plan) {
        let runs = runs(results, &row);
        let is_met = mean(&runs, |run| run.real_time_factor) >= Some(REAL_TIME_FACTOR);
        let has_bar = row[0].robots == USUAL_ROBOTS;
        let bar =
            if has_bar { verdict(&REAL_TIME_FACTOR.to_string(), is_met) } else { "–".to_owned() };
        let cycle = spread(&runs, |run| run.mean_cycle_ms);
        let _ = writeln!(
            text,
            "| {} | {} | {bar} | {cycle} ms | {} |",
            row[0].robots,
            spread(&runs, |run| run.real_time_factor),
            contacts(&runs)
        );
    }
    text
}

fn large(plan: &Plan, results: &Results) -> String {
    let mut text = String::from(
        "\n## A large fleet\n\nIn a generated warehouse of 122,158 edges. 'Process' is all \
         processor time of the manager's process over simulated time, its start included; at the \
         start it works the roads out, before its first cycle.\n\n\
         | robots | simulated | goals/s | busy | process | start | a cycle | longest cycle | \
         times real time | contacts | other findings \
         |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in parts::large_rows(plan) {
        let (setup, runs) = (row[0], runs(results, &row));
        let longest_cycle_ms = longest(&runs, |run| run.longest_cycle_ms);
        let _ = writeln!(
            text,
            "| {} | {} s | {} | {} | {} | {:.1} s | {} ms | {longest_cycle_ms:.0} ms ({}) | {} | \
             {} | {} |",
            setup.robots,
            setup.secs,
            spread(&runs, goals),
            busy(&runs, setup.robots),
            percent(mean(&runs, |run| run.manager_cores.unwrap_or(f64::NAN))),
            longest(&runs, |run| run.start_ms) * 1e-3,
            spread(&runs, |run| run.mean_cycle_ms),
            verdict("100", longest_cycle_ms <= LONGEST_CYCLE_MS),
            spread(&runs, |run| run.real_time_factor),
            contacts(&runs),
            others(&runs),
        );
    }
    text
}
