//! The work of a fleet manager: robots by activity, and orders.

use std::time::Duration;

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use regatta_base::thousands;
use regatta_plugin::activity::Activity;
use regatta_plugin::work::WorkFigures;

use super::table::fitted;
use super::theme::section;
use super::{format, theme};
use crate::snapshot::{OrderFigures, Work};

/// The number of lines of the section without the robots of each activity.
const HEIGHT: u16 = 3;

/// The display order of the activities, the most important first.
pub const ORDER: [Activity; Activity::COUNT] = [
    Activity::Carrying,
    Activity::Fetching,
    Activity::Handling,
    Activity::Waiting,
    Activity::Queued,
    Activity::Moving,
    Activity::Rotating,
    Activity::Broken,
    Activity::Faulted,
    Activity::Stalled,
    Activity::Held,
    Activity::Charging,
    Activity::Idle,
];

/// Returns the number of lines of the section, given the number of activities that are shown
/// elsewhere: with more of them, the section lists all.
pub fn height(work: &Work, shown: usize) -> u16 {
    let activities = work.robots.iter().filter(|robots| **robots > 0).count();
    HEIGHT + u16::from(activities > shown)
}

/// Draws the counts of orders and their times, and the robots of each activity that has any if
/// there is a line for them.
pub fn draw(frame: &mut Frame<'_>, area: Rect, work: &Work) {
    let (title, counts, times) = match &work.run {
        Some(run) => ("orders".to_owned(), run_counts(run, &work.orders), run_times(run)),
        None => (title(&work.orders), counts(&work.orders), times(&work.orders)),
    };
    let lists_robots = area.height > HEIGHT;
    let area = section(frame, area, title, counts);
    let robots = lists_robots.then(|| robots(work));
    let lines = robots.into_iter().chain([times, effort(work)]);
    let lines: Vec<_> = lines.map(|line| fitted(line, area.width)).collect();
    frame.render_widget(Paragraph::new(lines), area);
}

/// The title of the section: it tells the time from which the orders are counted, unless it is the
/// start of the run.
fn title(orders: &OrderFigures) -> String {
    match orders.since_secs {
        Some(secs) => {
            format!("orders since t {}", format::clock(Duration::from_secs_f64(secs.max(0.0))))
        }
        None => "orders".to_owned(),
    }
}

/// Formats the numbers of orders.
fn counts(orders: &OrderFigures) -> Line<'static> {
    let rate = orders.finished_per_second.map(|rate| format!("{} an hour", whole(rate * 3600.0)));
    numbers(orders, rate)
}

/// Formats the numbers of orders of the run, as its manager publishes them.
fn run_counts(run: &WorkFigures, read: &OrderFigures) -> Line<'static> {
    let orders =
        OrderFigures { open: Some(run.open), finished: run.finished, failed: run.failed, ..*read };
    let rate = run.rate().map_or_else(|| "–".to_owned(), |rate| whole(rate.into()));
    numbers(&orders, Some(format!("{rate} an hour (last 10 min)")))
}

/// Formats a number without its fraction.
fn whole(value: f64) -> String {
    thousands(value.round() as u64)
}

/// Formats numbers of orders. Those of failed and cancelled ones are shown only if there are any.
/// `rate` tells the finished orders an hour.
fn numbers(orders: &OrderFigures, rate: Option<String>) -> Line<'static> {
    let counts = [
        (orders.open, "open", theme::quiet()),
        (Some(orders.finished), "finished", theme::quiet()),
    ];
    let exceptions = [
        (Some(orders.failed).filter(|count| *count > 0), "failed", theme::text(theme::BAD)),
        (
            Some(orders.cancelled).filter(|count| *count > 0),
            "cancelled",
            theme::text(theme::WARNING),
        ),
    ];
    let mut spans = known(counts);
    spans.extend(rate.map(|rate| Span::styled(rate, theme::strong())));
    spans.extend(known(exceptions));
    separated(spans, ", ")
}

/// Formats the counts that are known.
fn known(counts: [(Option<u64>, &'static str, Style); 2]) -> Vec<Span<'static>> {
    let mut spans = Vec::new();
    for (count, what, style) in counts {
        if let Some(count) = count {
            spans.push(Span::styled(format!("{} {what}", thousands(count)), style));
        }
    }
    spans
}

/// Formats the numbers of robots, without activities of none.
fn robots(work: &Work) -> Line<'static> {
    let mut line = Line::default();
    for activity in ORDER {
        let robots = work.robots[activity as usize];
        if robots > 0 {
            let text = format!("{} {}", thousands(robots), activity.name());
            let mark = Span::styled("■", theme::text(theme::of_activity(activity)));
            line.push_span(Span::raw(if line.spans.is_empty() { "" } else { "  " }));
            line.spans.extend([mark, Span::raw(" "), Span::from(text)]);
        }
    }
    line
}

/// Formats the times of orders: mean, median, 99th percentile and longest.
fn times(orders: &OrderFigures) -> Line<'static> {
    let mut spans = Vec::new();
    for (name, times) in [("service ", orders.service), ("until assigned ", orders.waiting)] {
        let text = times.mean().map(|mean| {
            let values = [mean, times.p50, times.p99, times.longest].map(seconds);
            match values.iter().all(|value| value == "0.0") {
                true => "none".to_owned(),
                false => format!("{} s", values.join(" ")),
            }
        });
        add_figure(&mut spans, name, text, "  ");
    }
    spans.push(Span::styled("(mean, p50, p99, longest)", theme::quiet()));
    Line::from(spans)
}

/// Formats the service times of the run and the work of its robots, as its manager publishes them.
fn run_times(run: &WorkFigures) -> Line<'static> {
    let service = run.service_secs();
    let [p50, p99] =
        [0, 1].map(|at| service.map(|secs| format!("{} s", seconds(f64::from(secs[at])))));
    let mut spans = Vec::new();
    add_figure(&mut spans, "service p50 ", p50, "  ");
    add_figure(&mut spans, "p99 ", p99, "  ");
    add_figure(&mut spans, "waiting ", Some(percent(f64::from(run.waiting))), "  ");
    let busy = format!("{} of {}", thousands(run.busy.into()), thousands(run.robots.into()));
    let robots = if run.robots == 1 { " robot" } else { " robots" };
    add_figure(&mut spans, "busy ", Some(busy), robots);
    Line::from(spans)
}

/// Formats the time that the manager spends on a frame; and if the manager publishes no figures of
/// the run, the busy part of the robots' time and the part of their metres without a load. All are
/// since `top` began to read, so those of robots don't stand beside figures of the run.
fn effort(work: &Work) -> Line<'static> {
    let mut spans = Vec::new();
    if work.run.is_none() {
        spans.push(Span::styled("since top began: ", theme::quiet()));
        add_figure(&mut spans, "busy ", work.effort.utilisation().map(percent), "  ");
        add_figure(&mut spans, "empty ", work.effort.empty_part().map(percent), "  ");
    }
    let cycle = work.cycle.mean().map(|mean| {
        let millis = [mean, work.cycle.p99, work.cycle.longest].map(|secs| 1e3 * secs);
        format!("{:.1} {:.1} {:.1} ms", millis[0], millis[1], millis[2])
    });
    let what = match (&cycle, work.run) {
        (None, _) => "",
        (Some(_), None) => " (mean, p99, longest)",
        (Some(_), Some(_)) => " (mean, p99, longest while top reads)",
    };
    add_figure(&mut spans, "cycle ", cycle, what);
    Line::from(spans)
}

fn add_figure(
    spans: &mut Vec<Span<'static>>,
    name: &'static str,
    value: Option<String>,
    after: &'static str,
) {
    spans.push(Span::styled(name, theme::quiet()));
    spans.push(value.unwrap_or_else(|| "–".to_owned()).into());
    spans.push(Span::styled(after, theme::quiet()));
}

fn percent(part: f64) -> String {
    format!("{:.0} %", 100.0 * part)
}

/// Formats seconds of simulated time with one decimal below ten.
fn seconds(seconds: f64) -> String {
    if seconds < 9.95 { format!("{seconds:.1}") } else { thousands(seconds.round() as u64) }
}

fn separated(spans: Vec<Span<'static>>, separator: &'static str) -> Line<'static> {
    let mut line = Line::default();
    for span in spans {
        if !line.spans.is_empty() {
            line.push_span(Span::styled(separator, theme::quiet()));
        }
        line.push_span(span);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn each_activity_is_shown_once_and_only_with_robots() {
        let robots_by_activity = core::array::from_fn(|number| number as u64 + 1);
        let work = Work { robots: robots_by_activity, ..Work::default() };
        let line = robots(&work).to_string();
        for (activity, robots) in Activity::ALL.into_iter().zip(1..) {
            let text = format!("■ {robots} {}", activity.name());
            assert_eq!(line.matches(&text).count(), 1, "{line}");
        }
        assert_eq!(robots(&Work::default()).width(), 0);
    }

    #[test]
    fn figures_of_the_run_are_those_of_its_manager() {
        let run = WorkFigures {
            finished: 9_000,
            open: 40,
            orders_per_hour: 7_654.4,
            service_p50_secs: 61.2,
            service_p99_secs: 240.0,
            waiting: 0.126,
            busy: 340,
            robots: 1_400,
            ..WorkFigures::default()
        };
        let read = testing::work().orders;
        assert_eq!(
            run_counts(&run, &read).to_string(),
            "40 open, 9,000 finished, 7,654 an hour (last 10 min), 7 cancelled"
        );
        assert_eq!(
            run_times(&run).to_string(),
            "service p50 61 s  p99 240 s  waiting 13 %  busy 340 of 1,400 robots"
        );
        let begun = WorkFigures { service_p50_secs: f32::NAN, orders_per_hour: f32::NAN, ..run };
        let text = run_counts(&begun, &read).to_string();
        assert!(text.contains("– an hour (last 10 min)"), "{text}");
        assert!(run_times(&begun).to_string().starts_with("service p50 –  p99 –"));
    }

    #[test]
    fn unknown_figures_are_left_out() {
        let orders = OrderFigures::default();
        assert_eq!(counts(&orders).to_string(), "0 finished");
        assert!(times(&orders).to_string().starts_with("service –  until assigned –"));
        let orders = testing::work().orders;
        assert_eq!(
            counts(&orders).to_string(),
            "58 open, 4,321 finished, 450 an hour, 3 failed, 7 cancelled"
        );
        let text = effort(&testing::work()).to_string();
        assert_eq!(
            text,
            "since top began: busy 90 %  empty 40 %  cycle 3.0 12.0 31.4 ms (mean, p99, longest)"
        );
        let none = effort(&Work::default()).to_string();
        assert!(none.starts_with("since top began: busy –  empty –"), "{none}");
        let published = Work { run: Some(WorkFigures::default()), ..testing::work() };
        assert_eq!(
            effort(&published).to_string(),
            "cycle 3.0 12.0 31.4 ms (mean, p99, longest while top reads)"
        );
        assert!(
            times(&orders).to_string().starts_with("service 61 55 120 300 s  until assigned 8.4 ")
        );
    }
}
