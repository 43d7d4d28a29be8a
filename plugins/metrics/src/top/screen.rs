//! The screen of `top`. Everything fits into 80 columns and 24 lines; more space makes the graphs
//! taller and the lists longer.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Stylize;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Padding, Paragraph, Wrap};
use regatta_base::thousands;
use regatta_plugin::frame::ClockState;

use super::table::fitted;
use super::view::View;
use super::{figures, format, graphs, lists, theme, work};
use crate::snapshot::Run;

/// The least size of the terminal, in columns and lines.
const MIN_SIZE: (u16, u16) = (72, 20);

const KEYS: [(&str, &str); 10] = [
    ("space", "pause or resume"),
    ("s", "pause, and step one tick"),
    ("+  -", "faster, slower"),
    ("m", "as fast as possible"),
    ("1", "real time"),
    ("e", "list collisions, or edges with jams"),
    ("↑ ↓ PgUp PgDn", "scroll the collisions"),
    ("Home End", "first, last collision"),
    ("?", "this list"),
    ("q  Esc  Ctrl-C", "quit"),
];

/// Draws the whole screen. Limits the scroll position to the length of the list.
pub fn draw(frame: &mut Frame<'_>, view: &mut View) {
    let area = frame.area();
    if area.width < MIN_SIZE.0 || area.height < MIN_SIZE.1 {
        return centred(
            frame,
            area,
            vec![Line::from("This window is too small."), Line::from("80 × 24 shows all.")],
        );
    }
    let [head, body, foot] =
        Layout::vertical([Constraint::Length(1), Constraint::Min(0), Constraint::Length(1)])
            .areas(area);
    frame.render_widget(fitted(head_line(view), head.width), head);
    match view.snapshot.run {
        Some(run) if run.clock == ClockState::WarmingUp => draw_warm_up(frame, body, view, &run),
        Some(run) => view.scroll = draw_run(frame, body, view, &run),
        None => draw_waiting(frame, body, view),
    }
    // Of a long outcome, the beginning is worth more than nothing.
    let line = foot_line(view);
    let line = if view.outcome.is_some() { line } else { fitted(line, foot.width) };
    frame.render_widget(line, foot);
    if view.help {
        draw_help(frame, body);
    }
}

/// The number of lines of the robots, and of the figures of the run.
const MIDDLE_HEIGHT: u16 = 7;

/// Draws a fleet that has an engine. Returns the scroll position of its collisions.
fn draw_run(frame: &mut Frame<'_>, area: Rect, view: &View, run: &Run) -> usize {
    let graphs = (area.height / 5).clamp(5, 14);
    // One line is the title.
    let shown = usize::from(MIDDLE_HEIGHT - 1);
    let orders = view.snapshot.work.as_ref().map_or(0, |work| work::height(work, shown));
    let [above, middle, below] = Layout::vertical([
        Constraint::Length(graphs),
        Constraint::Length(MIDDLE_HEIGHT + orders),
        Constraint::Min(0),
    ])
    .spacing(1)
    .areas(inset(area));
    let [middle, orders] =
        Layout::vertical([Constraint::Length(MIDDLE_HEIGHT), Constraint::Length(orders)])
            .areas(middle);
    graphs::draw(frame, above, &view.history, run);
    let [left, right] =
        Layout::horizontal([Constraint::Fill(2), Constraint::Fill(3)]).spacing(2).areas(middle);
    let groups = figures::groups(&view.snapshot, run);
    figures::draw_robots(frame, left, groups, run.state_counts.robots());
    figures::draw_figures(frame, right, view, run);
    if let Some(work) = &view.snapshot.work {
        work::draw(frame, orders, work);
    }
    let processes = (area.width / 4).clamp(31, 60);
    let [left, right] = Layout::horizontal([Constraint::Fill(1), Constraint::Length(processes)])
        .spacing(2)
        .areas(below);
    lists::draw_processes(frame, right, view);
    if view.shows_jams {
        lists::draw_jams(frame, left, view.snapshot.jams.as_deref());
        return view.scroll;
    }
    lists::draw_collisions(frame, left, &view.snapshot, run, view.scroll)
}

/// Draws a fleet without an engine: a hint, and the processes that wait for one.
fn draw_waiting(frame: &mut Frame<'_>, area: Rect, view: &View) {
    let fleet = &view.snapshot.fleet;
    let flag =
        if fleet.as_str() == "default" { String::new() } else { format!(" --fleet {fleet}") };
    let lines = vec![
        Line::from(format!("No engine runs the fleet '{fleet}'.")).style(theme::strong()),
        Line::default(),
        Line::from(vec!["Start one:  ".into(), Span::from(format!("regatta run{flag}")).bold()]),
        Line::from("This view continues as soon as there is one.").style(theme::quiet()),
    ];
    let [above, below] =
        Layout::vertical([Constraint::Fill(1), Constraint::Fill(1)]).areas(inset(area));
    centred(frame, above, lines);
    lists::draw_processes(frame, below, view);
}

/// Draws a fleet in its warm-up: its figures aren't those of the run, which begins afterwards.
fn draw_warm_up(frame: &mut Frame<'_>, area: Rect, view: &View, run: &Run) {
    let time = format::clock(run.sim_time);
    let lines = vec![
        Line::from(format!("Warming up: {time} of simulated time driven so far.")).bold(),
        Line::default(),
        Line::from("The run begins at the end of its warm-up, in real time.").style(theme::quiet()),
    ];
    let [above, below] =
        Layout::vertical([Constraint::Fill(1), Constraint::Fill(1)]).areas(inset(area));
    centred(frame, above, lines);
    lists::draw_processes(frame, below, view);
}

fn head_line(view: &View) -> Line<'_> {
    let mut spans = vec![" regatta ".bold(), Span::from(format!(" {}   ", view.snapshot.fleet))];
    if let Some(run) = &view.snapshot.run {
        let (colour, word) = match run.clock {
            ClockState::Running => (theme::GOOD, "running"),
            ClockState::Paused => (theme::WARNING, "paused"),
            ClockState::Stopped => (theme::BAD, "stopped"),
            ClockState::WarmingUp => (theme::WARNING, "warming up"),
        };
        spans.push(Span::from(format!("● {word}")).style(theme::text(colour)).bold());
        spans.push(Span::from(format!("  {}   ", format::speed(run.speed))));
        spans.extend([Span::styled("t ", theme::quiet()), format::clock(run.sim_time).into()]);
        spans.extend([Span::styled("   tick ", theme::quiet()), thousands(run.tick).into()]);
    }
    Line::from(spans)
}

/// Returns the list of keys, or for some seconds the outcome of the last one.
fn foot_line(view: &View) -> Line<'_> {
    match &view.outcome {
        Some(Ok(text)) => Line::from(format!(" {text}")).style(theme::text(theme::GOOD)),
        Some(Err(text)) => Line::from(format!(" {text}")).style(theme::text(theme::BAD)),
        None => {
            let keys = [
                ("space", "pause"),
                ("s", "step"),
                ("+ -", "speed"),
                ("m", "max"),
                ("1", "real time"),
            ];
            let more = [("↑ ↓", "scroll"), ("?", "help"), ("q", "quit")];
            let spans = keys.into_iter().chain(more).flat_map(|(key, what)| {
                [
                    Span::from(format!(" {key}")).bold(),
                    Span::styled(format!(" {what} "), theme::quiet()),
                ]
            });
            Line::from_iter(spans)
        }
    }
}

fn draw_help(frame: &mut Frame<'_>, area: Rect) {
    let lines = KEYS
        .into_iter()
        .map(|(key, what)| Line::from(vec![format!("{key:<15}").bold(), what.into()]));
    let popup = area.centered(Constraint::Length(46), Constraint::Length(KEYS.len() as u16 + 4));
    let block = Block::bordered()
        .border_style(theme::quiet())
        .title(Span::styled(" keys ", theme::strong()))
        .padding(Padding::new(2, 2, 1, 1));
    frame.render_widget(Clear, popup);
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()).block(block), popup);
}

fn centred(frame: &mut Frame<'_>, area: Rect, lines: Vec<Line<'_>>) {
    let centre = area.centered_vertically(Constraint::Length(lines.len() as u16));
    frame.render_widget(Paragraph::new(lines).centered().wrap(Wrap { trim: true }), centre);
}

fn inset(area: Rect) -> Rect {
    Rect { x: area.x + 1, width: area.width.saturating_sub(2), ..area }
}

#[cfg(test)]
mod tests;
