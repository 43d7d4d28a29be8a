//! Robots by state, and the figures of the run.

use ratatui::Frame;
use ratatui::layout::{Constraint, Flex, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use regatta_plugin::activity::Activity;
use regatta_plugin::frame::RobotState;

use super::theme::section;
use super::view::View;
use super::{format, theme};
use crate::snapshot::Run;
use crate::state_counts::{STATE_NAMES, STATES, StateCounts};

/// The display order of the states, the most important first.
const ORDER: [usize; STATES] = [1, 5, 0, 2, 3, 4, 6, 7];

/// The largest width of a figure with its name, in columns, at which the eye can follow.
const MAX_FIGURE_WIDTH: u16 = 34;

/// The ends of a bar, in eighths of a column.
const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];

/// Draws a bar for each state, or for those with robots if there is no room for all.
pub fn draw_robots(frame: &mut Frame<'_>, area: Rect, state_counts: &StateCounts) {
    let robots = state_counts.robots();
    let area = section(frame, area, "robots", Span::styled(format::count(robots), theme::strong()));
    let digits = format::count(robots).len().max(3);
    let width = usize::from(area.width).saturating_sub(8 + digits + 2);
    let mut shown = ORDER.to_vec();
    // If there is no room for all, states without robots are left out.
    while shown.len() > usize::from(area.height)
        && let Some(empty) = shown.iter().rposition(|state| state_counts.by_state[*state] == 0)
    {
        shown.remove(empty);
    }
    let mut lines = Vec::new();
    for state in shown {
        let count = state_counts.by_state[state];
        let bar = bar(count as f64 / robots.max(1) as f64, width);
        let style = if count > 0 { Style::new() } else { theme::quiet() };
        lines.push(Line::from(vec![
            Span::styled(format!("{:<8}", STATE_NAMES[state]), theme::quiet()),
            Span::styled(bar, theme::text(state_colour(state))),
            Span::styled(format!("  {:>digits$}", format::count(count)), style),
        ]));
    }
    frame.render_widget(Paragraph::new(lines), area);
}

/// Returns the colour of a state, by its number: that of its activity.
fn state_colour(state: usize) -> Color {
    let activity = Activity::of_state(RobotState::from_number(state as u8));
    activity.map_or(theme::QUIET, theme::of_activity)
}

/// Formats a bar of that share of `width` columns. Shares above 0 are always visible.
fn bar(share: f64, width: usize) -> String {
    let least = f64::from(u8::from(share > 0.0));
    let eighths = (share * width as f64 * 8.0).round().max(least).min(width as f64 * 8.0) as usize;
    let bar = "█".repeat(eighths / 8) + EIGHTHS[eighths % 8];
    format!("{bar:<width$}")
}

/// The name and the value of a figure.
type Figure = (&'static str, Span<'static>);

/// Draws two columns of figures.
pub fn draw_figures(frame: &mut Frame<'_>, area: Rect, view: &View, run: &Run) {
    let area =
        section(frame, area, "run", Span::styled(format!("{:016x}", run.run_id), theme::quiet()));
    let columns: [Rect; 2] = Layout::horizontal([Constraint::Max(MAX_FIGURE_WIDTH); 2])
        .spacing(3)
        .flex(Flex::Start)
        .areas(area);
    for (area, figures) in
        columns.into_iter().zip([time_figures(view, run), distance_figures(view, run)])
    {
        let width = usize::from(area.width);
        let lines = figures.map(|(name, value)| {
            // The name is truncated rather than the value.
            let room = width.saturating_sub(value.width() + 1);
            Line::from(vec![Span::styled(format!("{name:<room$.room$} "), theme::quiet()), value])
        });
        frame.render_widget(Paragraph::new(lines.to_vec()), area);
    }
}

fn time_figures(view: &View, run: &Run) -> [Figure; 5] {
    let (mean, max) = view.history.newest().jitter.unzip();
    let [mean, max] = [mean, max]
        .map(|seconds| Span::from(seconds.map_or_else(|| "–".to_owned(), format::seconds)));
    let totals = &view.snapshot.totals;
    [
        ("tick period", format::seconds(run.tick_period.as_secs_f64()).into()),
        ("late ticks", problem_count(run.late_ticks, theme::WARNING)),
        ("jitter", mean),
        ("worst jitter", max),
        ("frames skipped", format::count(totals.frames_skipped).into()),
    ]
}

fn distance_figures(view: &View, run: &Run) -> [Figure; 5] {
    let collisions = &view.snapshot.collisions;
    let lag = collisions
        .tick()
        .map(|tick| run.tick.saturating_sub(tick) as f64 * run.tick_period.as_secs_f64());
    [
        ("mean speed", format!("{:.2} m/s", run.state_counts.mean_speed()).into()),
        ("driven", format::metres(view.snapshot.totals.driven_metres).into()),
        ("frames read", format::count(view.snapshot.totals.frames_read).into()),
        (
            "collisions ever",
            collisions
                .pairs
                .map_or_else(unknown, |pairs| problem_count(pairs.touching_ever, theme::BAD)),
        ),
        ("checker lag", lag.map_or_else(unknown, |lag| format::seconds(lag).into())),
    ]
}

fn unknown() -> Span<'static> {
    Span::styled("–", theme::quiet())
}

/// Formats a count of problems, coloured unless it is 0.
fn problem_count(count: u64, colour: Color) -> Span<'static> {
    Span::styled(format::count(count), if count > 0 { theme::text(colour) } else { Style::new() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_have_the_length_of_their_share() {
        assert_eq!(bar(0.0, 4), "    ");
        assert_eq!(bar(1.0, 4), "████");
        assert_eq!(bar(0.5, 4), "██  ");
        assert_eq!(bar(0.55, 4), "██▎ ");
        assert_eq!(bar(1e-9, 4), "▏   ");
        assert_eq!(bar(0.5, 0), "");
    }
}
