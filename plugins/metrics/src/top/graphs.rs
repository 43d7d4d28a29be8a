//! The sparklines: tick cost, real-time factor, frame age. The newest bar is at the right.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Color;
use ratatui::text::{Line, Span};
use ratatui::widgets::{RenderDirection, Sparkline, SparklineBar};

use super::theme::section;
use super::view::{History, Slot};
use super::{format, theme};
use crate::snapshot::Run;

/// The value of the highest bar, as bars are integers.
const MAX_BAR: f64 = 1e6;

/// A sparkline.
struct Graph<'a> {
    title: &'a str,
    /// The newest figures as text, from the longest to the shortest; the first that fits is shown.
    notes: Vec<Line<'a>>,
    /// Height and colour of the bar of a slot.
    bar: fn(&Slot) -> Option<(f64, Color)>,
    /// Height of the graph, unless a bar is higher.
    top: f64,
}

/// Draws all three graphs side by side.
pub fn draw(frame: &mut Frame<'_>, area: Rect, history: &History, run: &Run) {
    let areas: [Rect; 3] = Layout::horizontal([Constraint::Fill(1); 3]).spacing(2).areas(area);
    let newest = history.newest();
    let wanted = f64::from(run.speed);
    let graphs = [
        Graph { title: "tick cost", notes: times(newest.tick_cost), bar: tick_cost, top: 0.0 },
        Graph {
            title: "real time",
            notes: factor(run),
            bar: real_time,
            top: if wanted.is_finite() { wanted } else { 0.0 },
        },
        Graph { title: "frame age", notes: times(newest.frame_age), bar: frame_age, top: 0.0 },
    ];
    for (area, graph) in areas.into_iter().zip(graphs) {
        draw_graph(frame, area, history, graph);
    }
}

/// Returns the longest tick of the slot, coloured by the share of the tick period that it took.
fn tick_cost(slot: &Slot) -> Option<(f64, Color)> {
    let (_, max) = slot.tick_cost?;
    let colour = match max {
        _ if slot.budget <= 0.0 => theme::GOOD,
        max if max < 0.5 * slot.budget => theme::GOOD,
        max if max < slot.budget => theme::WARNING,
        _ => theme::BAD,
    };
    Some((max, colour))
}

fn real_time(slot: &Slot) -> Option<(f64, Color)> {
    let factor = slot.real_time_factor?;
    let enough = slot.wanted.is_infinite() || factor >= 0.95 * slot.wanted;
    Some((factor, if enough { theme::GOOD } else { theme::WARNING }))
}

/// Returns the oldest frame of the slot. A frame older than a tick has been superseded.
fn frame_age(slot: &Slot) -> Option<(f64, Color)> {
    let (_, max) = slot.frame_age?;
    let is_fresh = slot.budget <= 0.0 || max < slot.budget;
    Some((max, if is_fresh { theme::NEUTRAL } else { theme::WARNING }))
}

/// Formats the mean and the maximum, or only the maximum.
fn times<'a>(mean_and_max: Option<(f64, f64)>) -> Vec<Line<'a>> {
    let Some((mean, max)) = mean_and_max else { return Vec::new() };
    let mean = Span::styled(format::seconds(mean), theme::strong());
    let max = Span::styled(format!("≤ {}", format::seconds(max)), theme::quiet());
    vec![Line::from(vec![mean, " ".into(), max.clone()]), Line::from(max)]
}

fn factor<'a>(run: &Run) -> Vec<Line<'a>> {
    let Some(factor) = run.real_time_factor else { return Vec::new() };
    let factor = Span::styled(format::factor(factor), theme::strong());
    let wanted = Span::styled(format!(" of {}", format::speed(run.speed)), theme::quiet());
    vec![Line::from(vec![factor.clone(), wanted]), Line::from(factor)]
}

fn draw_graph(frame: &mut Frame<'_>, area: Rect, history: &History, graph: Graph<'_>) {
    let room = usize::from(area.width).saturating_sub(graph.title.len() + 3);
    let note = graph.notes.into_iter().find(|note| note.width() <= room);
    let area = section(frame, area, graph.title, note.unwrap_or_default());
    let bars: Vec<_> = history.newest_first().take(area.width.into()).map(graph.bar).collect();
    let top =
        bars.iter().flatten().map(|bar| bar.0).fold(graph.top, f64::max).max(f64::MIN_POSITIVE);
    let bars = bars.into_iter().map(|bar| match bar {
        // Every measured value is visible.
        Some((value, colour)) => SparklineBar::from(Some(((value / top * MAX_BAR) as u64).max(1)))
            .style(theme::text(colour)),
        None => SparklineBar::from(None),
    });
    let sparkline = Sparkline::default().data(bars).max(MAX_BAR as u64);
    frame.render_widget(
        sparkline.direction(RenderDirection::RightToLeft).absent_value_symbol(" "),
        area,
    );
}
