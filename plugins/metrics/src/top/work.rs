//! The work of a fleet manager: robots by activity, and tasks.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use regatta_plugin::activity::Activity;

use super::theme::section;
use super::{format, theme};
use crate::snapshot::{TaskFigures, Work};
use crate::task_times::TimeSummary;

/// The number of lines of the section.
pub const HEIGHT: u16 = 4;

/// The display order of the activities, the most important first.
const ORDER: [Activity; Activity::ALL.len()] = [
    Activity::Carrying,
    Activity::ToPick,
    Activity::Handling,
    Activity::Waiting,
    Activity::Parked,
    Activity::OutOfService,
    Activity::Charging,
    Activity::Idle,
];

/// Draws the counts of tasks, the robots of each activity that has any, and the times of tasks.
pub fn draw(frame: &mut Frame<'_>, area: Rect, work: &Work) {
    let area = section(frame, area, "tasks", counts(&work.tasks));
    frame.render_widget(Paragraph::new(vec![robots(work), times(&work.tasks), effort(work)]), area);
}

/// Formats the numbers of tasks. Those of failed and cancelled ones are shown only if there are
/// any.
fn counts(tasks: &TaskFigures) -> Line<'static> {
    let per_hour = tasks.finished_per_second.map(|rate| (rate * 3600.0).round() as u64);
    let if_any = |count: u64| (count > 0).then_some(count);
    let counts = [
        (tasks.open, "open", theme::quiet()),
        (Some(tasks.finished), "finished", theme::quiet()),
        (per_hour, "an hour", theme::strong()),
        (if_any(tasks.failed), "failed", theme::text(theme::BAD)),
        (if_any(tasks.cancelled), "cancelled", theme::text(theme::WARNING)),
    ];
    let known = counts.into_iter().filter_map(|(count, what, style)| Some((count?, what, style)));
    let spans = known.map(|(count, what, style)| {
        Span::styled(format!("{} {what}", format::count(count)), style)
    });
    Line::from(separated(spans, ", "))
}

/// Formats the numbers of robots, without activities of none.
fn robots(work: &Work) -> Line<'static> {
    let counted = ORDER.map(|activity| (activity, work.robots[activity as usize]));
    let some = counted.into_iter().filter(|(_, robots)| *robots > 0).map(|(activity, robots)| {
        Span::styled(
            format!("{} {}", format::count(robots), activity.name()),
            theme::text(colour(activity)),
        )
    });
    Line::from(separated(some, "  "))
}

fn colour(activity: Activity) -> Color {
    match activity {
        Activity::ToPick | Activity::Carrying | Activity::Handling => theme::GOOD,
        Activity::Waiting => theme::WAITING,
        Activity::Parked => theme::WARNING,
        Activity::OutOfService => theme::BAD,
        Activity::Charging => theme::NEUTRAL,
        Activity::Idle => theme::QUIET,
    }
}

/// Formats the times of tasks: mean, median, 99th percentile and longest.
fn times(tasks: &TaskFigures) -> Line<'static> {
    let times = [("service", tasks.service), ("waiting", tasks.waiting)];
    let mut spans: Vec<_> =
        times.into_iter().flat_map(|(name, times)| time(name, &times)).collect();
    spans.push(Span::styled("(mean, p50, p99, longest)", theme::quiet()));
    Line::from(spans)
}

fn time(name: &str, times: &TimeSummary) -> [Span<'static>; 2] {
    let values =
        times.mean().map(|mean| [mean, times.p50, times.p99, times.longest].map(seconds).join(" "));
    let value = values.map_or_else(|| "–".to_owned(), |values| format!("{values} s"));
    [Span::styled(format!("{name} "), theme::quiet()), format!("{value}  ").into()]
}

/// Formats the part of the robots' time that is work, the part of their metres without a load, and
/// the time that the manager spends on a frame.
fn effort(work: &Work) -> Line<'static> {
    let percent = |part: f64| format!("{:.0} %", 100.0 * part);
    let millis = |secs: f64| format!("{:.1}", 1e3 * secs);
    let cycle = work.cycle.mean().map(|mean| {
        let [mean, p99, longest] = [mean, work.cycle.p99, work.cycle.longest].map(millis);
        (format!("{mean} {p99} {longest} ms"), " (mean, p99, longest)")
    });
    let (cycle, what) = cycle.unzip();
    let values = [
        ("utilisation ", work.effort.utilisation().map(percent), "  "),
        ("empty ", work.effort.empty_part().map(percent), "  "),
        ("cycle ", cycle, what.unwrap_or_default()),
    ];
    let value = |(name, value, after): (&'static str, Option<String>, &'static str)| {
        let quiet = |text| Span::styled(text, theme::quiet());
        [quiet(name), value.unwrap_or_else(|| "–".to_owned()).into(), quiet(after)]
    };
    Line::from_iter(values.into_iter().flat_map(value))
}

/// Formats seconds of simulated time with one decimal below ten.
fn seconds(seconds: f64) -> String {
    if seconds < 9.95 { format!("{seconds:.1}") } else { format::count(seconds.round() as u64) }
}

fn separated(
    spans: impl Iterator<Item = Span<'static>>,
    separator: &'static str,
) -> Vec<Span<'static>> {
    let separate = |(index, span)| {
        let before = if index > 0 { separator } else { "" };
        [Span::styled(before, theme::quiet()), span]
    };
    spans.enumerate().flat_map(separate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn each_activity_is_shown_once_and_only_with_robots() {
        let work = Work { robots: [1, 2, 3, 4, 5, 6, 7, 8], ..Work::default() };
        let line = robots(&work).to_string();
        for (activity, robots) in Activity::ALL.into_iter().zip(1..) {
            assert_eq!(line.matches(&format!("{robots} {}", activity.name())).count(), 1, "{line}");
        }
        assert_eq!(robots(&Work::default()).width(), 0);
    }

    #[test]
    fn unknown_figures_are_left_out() {
        let tasks = TaskFigures::default();
        assert_eq!(counts(&tasks).to_string(), "0 finished");
        assert!(times(&tasks).to_string().starts_with("service –  waiting –"));
        let tasks = testing::work().tasks;
        assert_eq!(
            counts(&tasks).to_string(),
            "58 open, 4,321 finished, 450 an hour, 3 failed, 7 cancelled"
        );
        let text = effort(&testing::work()).to_string();
        assert_eq!(
            text,
            "utilisation 90 %  empty 40 %  cycle 3.0 12.0 31.4 ms (mean, p99, longest)"
        );
        assert!(effort(&Work::default()).to_string().starts_with("utilisation –  empty –"));
        assert!(times(&tasks).to_string().starts_with("service 61 55 120 300 s  waiting 8.4 "));
    }
}
