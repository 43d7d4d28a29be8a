//! The current collisions, the edges at which robots wait the longest, and the processes.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Scrollbar, ScrollbarOrientation, ScrollbarState, Wrap};
use regatta_base::thousands;
use regatta_plugin::contact::{ContactHeader, ContactLevel, ContactRecord};

use super::table::Column;
use super::theme::section;
use super::view::View;
use super::{format, table, theme};
use crate::snapshot::{Jam, Process, Run, Snapshot};

/// The largest width of a pair, in columns of text. A wide list shows several pairs side by side.
const PAIR_WIDTH: u16 = 64;

/// Draws pairs that touch or may touch, from the `scroll`th on, or from the last one that fills the
/// list. Returns the number of the first pair that is drawn.
pub fn draw_collisions(
    frame: &mut Frame<'_>,
    area: Rect,
    snapshot: &Snapshot,
    run: &Run,
    scroll: usize,
) -> usize {
    let collisions = &snapshot.collisions;
    let note = collisions.pairs.as_ref().map(totals).unwrap_or_default();
    let area = section(frame, area, "collisions", note);
    if collisions.pairs.is_none() {
        draw_hint(frame, area, "No checker runs: start `regatta plugin collision`.");
        return 0;
    }
    if collisions.list.is_empty() {
        draw_hint(frame, area, "No robots touch, or are about to.");
        return 0;
    }
    let columns = usize::from((area.width / PAIR_WIDTH).max(1));
    let rows = usize::from(area.height.saturating_sub(1));
    let max_scroll = collisions.list.len().saturating_sub(rows * columns);
    let scroll = scroll.min(max_scroll);
    let areas = Layout::horizontal(vec![Constraint::Fill(1); columns])
        .split(Rect { width: area.width.saturating_sub(2), ..area });
    for (column, pairs) in areas.iter().zip(collisions.list[scroll..].chunks(rows.max(1))) {
        draw_column(frame, *column, pairs, run);
    }
    draw_scrollbar(frame, area, scroll, max_scroll);
    scroll
}

fn draw_column(frame: &mut Frame<'_>, area: Rect, pairs: &[ContactRecord], run: &Run) {
    let pairs = &pairs[..pairs.len().min(area.height.into())];
    let robots = pairs.iter().map(|pair| format!("{} {}", pair.robots[0], pair.robots[1]).into());
    let places = pairs.iter().map(|pair| format!("{:.1}, {:.1}", pair.x, pair.y).into());
    let since = pairs.iter().map(|pair| {
        let secs = run.sim_time.as_secs_f64() - pair.since_nanos as f64 * 1e-9;
        format::seconds(secs.max(0.0)).into()
    });
    let speeds = pairs.iter().map(|pair| format!("{:.1}", pair.relative_speed).into());
    let columns = vec![
        Column::names("level", pairs.iter().map(level)),
        Column::names("robots", robots),
        Column::numbers("x, y (m)", places),
        Column::numbers("since", since),
        Column::numbers("m/s", speeds),
    ];
    table::draw(frame, area, columns);
}

/// Formats the numbers of pairs.
fn totals(pairs: &ContactHeader) -> Line<'static> {
    let touching = format!("{} touching", thousands(pairs.touching.into()));
    let capped = if pairs.capped != 0 { ", and more" } else { "" };
    let possible = format!(", {} possible{capped}", thousands(pairs.possible.into()));
    let style = if pairs.touching > 0 { theme::text(theme::BAD) } else { theme::text(theme::GOOD) };
    Line::from(vec![Span::styled(touching, style), Span::styled(possible, theme::quiet())])
}

/// Draws a scrollbar at the right edge of a list, if it is longer than the area.
fn draw_scrollbar(frame: &mut Frame<'_>, area: Rect, scroll: usize, max_scroll: usize) {
    if max_scroll > 0 {
        let area = Rect { y: area.y + 1, height: area.height.saturating_sub(1), ..area };
        let mut state = ScrollbarState::new(max_scroll + 1).position(scroll);
        let bar =
            Scrollbar::new(ScrollbarOrientation::VerticalRight).begin_symbol(None).end_symbol(None);
        frame.render_stateful_widget(
            bar.style(theme::quiet()).track_symbol(Some("│")),
            area,
            &mut state,
        );
    }
}

fn level(pair: &ContactRecord) -> Span<'static> {
    let (word, colour) = match ContactLevel::from_number(pair.level) {
        Some(ContactLevel::Touching) => ("touching", theme::BAD),
        Some(ContactLevel::Possible) => ("possible", theme::WARNING),
        None => ("unknown", theme::QUIET),
    };
    Span::styled(word, theme::text(colour))
}

/// Draws the edges at which robots waited the longest in the last ten minutes; `None` if no plugin
/// publishes them.
pub fn draw_jams(frame: &mut Frame<'_>, area: Rect, jams: Option<&[Jam]>) {
    let area = section(
        frame,
        area,
        "edges with jams",
        Span::styled("of the last ten minutes", theme::quiet()),
    );
    let Some(jams) = jams else {
        return draw_hint(frame, area, "No traffic is published: start `regatta plugin traffic`.");
    };
    if jams.is_empty() {
        return draw_hint(frame, area, "No robot has waited.");
    }
    let figures = || jams.iter().map(|jam| &jam.figures);
    let waited = figures().map(|edge| format::seconds(edge.waiting_secs.into()).into());
    let entered = figures().map(|edge| thousands(edge.entered_per_hour.round() as u64).into());
    let robots = figures().map(|edge| format!("{:.1}", edge.occupancy).into());
    let speed = figures().map(|edge| format!("{:.0} %", 100.0 * edge.relative_speed).into());
    let columns = vec![
        Column::names("edge", jams.iter().map(edge_name)),
        Column::numbers("waited", waited),
        Column::numbers("robots/h", entered),
        Column::numbers("robots", robots),
        Column::numbers("speed", speed),
    ];
    table::draw(frame, area, columns);
}

fn edge_name(jam: &Jam) -> Span<'static> {
    match &*jam.name {
        "" => jam.edge.to_string().into(),
        name => format!("{} {name}", jam.edge).into(),
    }
}

/// Draws the processes of the fleet with their processor time and memory.
pub fn draw_processes(frame: &mut Frame<'_>, area: Rect, view: &View) {
    let processes = &view.snapshot.processes;
    // The first lines are the border and the titles.
    let shown = processes.len().min(area.height.saturating_sub(2).into());
    let area = section(frame, area, "processes", shown_of(shown, processes.len()));
    if let Some(error) = &view.process_error {
        return draw_hint(frame, area, error);
    }
    let memory = processes.iter().map(|process| format::bytes(process.resident_bytes).into());
    let columns = vec![
        Column::names("name", processes.iter().map(|process| process.name.clone().into())),
        Column::numbers("cpu", processes.iter().map(busy)),
        Column::numbers("memory", memory),
        Column::numbers("pid", processes.iter().map(|process| process.pid.to_string().into())),
    ];
    table::draw(frame, area, columns);
}

/// Formats the number of processes, after that of the shown ones if there is no room for all.
fn shown_of(shown: usize, all: usize) -> Line<'static> {
    let all_in_words = Span::styled(thousands(all as u64), theme::strong());
    match shown < all {
        true => {
            Line::from(vec![Span::styled(format!("{shown} of "), theme::quiet()), all_in_words])
        }
        false => all_in_words.into(),
    }
}

fn busy(process: &Process) -> Span<'static> {
    match process.stopped {
        true => Span::styled("halted", theme::text(theme::BAD)),
        false => format!("{:.0} %", 100.0 * process.cpu_cores).into(),
    }
}

fn draw_hint(frame: &mut Frame<'_>, area: Rect, text: &str) {
    frame.render_widget(Paragraph::new(text).style(theme::quiet()).wrap(Wrap { trim: true }), area);
}
