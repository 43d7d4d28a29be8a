//! Robots by activity or by state, and the figures of the run.

use ratatui::Frame;
use ratatui::layout::{Constraint, Flex, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;

use regatta_base::thousands;
use regatta_plugin::activity::Activity;
use regatta_plugin::frame::RobotState;

use super::theme::section;
use super::view::View;
use super::{format, theme, work};
use crate::snapshot::{Run, Snapshot, Work};
use crate::state_counts::{STATE_NAMES, STATES, StateCounts};

/// The display order of the states, the most important first.
const ORDER: [usize; STATES] = [1, 5, 0, 2, 3, 4, 6, 7];

/// The number of robots of an activity: by their states while no manager publishes activities.
#[derive(Clone, Copy)]
pub struct Group {
    name: &'static str,
    colour: Color,
    robots: u64,
}

/// The largest width of a figure with its name, in columns, at which the eye can follow.
const MAX_FIGURE_WIDTH: u16 = 34;

/// The width of a group's name, with the space before its bar, in columns.
const NAME_WIDTH: usize = 9;

/// The ends of a bar, in eighths of a column.
const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];

/// Returns the robots by activity if a manager publishes them, else by state; the most important
/// first.
pub fn groups(snapshot: &Snapshot, run: &Run) -> Vec<Group> {
    match &snapshot.work {
        Some(work) => work::ORDER.into_iter().map(|activity| of_activity(work, activity)).collect(),
        None => ORDER.into_iter().map(|state| of_state(&run.state_counts, state)).collect(),
    }
}

fn of_activity(work: &Work, activity: Activity) -> Group {
    let robots = work.robots[activity as usize];
    Group { name: activity.name(), colour: theme::of_activity(activity), robots }
}

fn of_state(state_counts: &StateCounts, state: usize) -> Group {
    let activity = Activity::of_state(RobotState::from_number(state as u8));
    Group {
        name: activity.map_or(STATE_NAMES[state], Activity::name),
        colour: activity.map_or(theme::QUIET, theme::of_activity),
        robots: state_counts.by_state[state],
    }
}

/// Draws a bar for each group, or for those with robots if there is no room for all.
pub fn draw_robots(frame: &mut Frame<'_>, area: Rect, mut groups: Vec<Group>, robots: u64) {
    let area = section(frame, area, "robots", Span::styled(thousands(robots), theme::strong()));
    let digits = thousands(robots).len().max(3);
    let width = usize::from(area.width).saturating_sub(NAME_WIDTH + digits + 2);
    // If there is no room for all, groups without robots are left out.
    while groups.len() > usize::from(area.height)
        && let Some(empty) = groups.iter().rposition(|group| group.robots == 0)
    {
        groups.remove(empty);
    }
    let mut lines = Vec::new();
    for group in groups {
        let bar = bar(group.robots as f64 / robots.max(1) as f64, width);
        let style = if group.robots > 0 { Style::new() } else { theme::quiet() };
        lines.push(Line::from(vec![
            Span::styled(format!("{:<NAME_WIDTH$}", group.name), theme::quiet()),
            Span::styled(bar, theme::text(group.colour)),
            Span::styled(format!("  {:>digits$}", thousands(group.robots)), style),
        ]));
    }
    frame.render_widget(Paragraph::new(lines), area);
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

fn time_figures(view: &View, run: &Run) -> [Figure; 4] {
    let (mean, max) = view.history.newest().jitter.unzip();
    let [mean, max] = [mean, max]
        .map(|seconds| Span::from(seconds.map_or_else(|| "–".to_owned(), format::seconds)));
    [
        ("tick period", format::seconds(run.tick_period.as_secs_f64()).into()),
        ("late ticks", problem_count(run.late_ticks, theme::WARNING)),
        ("jitter", mean),
        ("worst jitter", max),
    ]
}

fn distance_figures(view: &View, run: &Run) -> [Figure; 4] {
    let collisions = &view.snapshot.collisions;
    let lag = collisions
        .tick()
        .map(|tick| run.tick.saturating_sub(tick) as f64 * run.tick_period.as_secs_f64());
    [
        ("mean speed", format!("{:.2} m/s", run.state_counts.mean_speed()).into()),
        ("frames", thousands(run.frames).into()),
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
    Span::styled(thousands(count), if count > 0 { theme::text(colour) } else { Style::new() })
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
