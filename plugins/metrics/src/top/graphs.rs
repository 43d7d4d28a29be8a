//! The sparklines: tick cost, real-time factor, frame age. The newest bar is at the right.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Color;
use ratatui::text::{Line, Span};
use ratatui::widgets::{RenderDirection, Sparkline, SparklineBar};

use super::history::{History, Slot};
use super::screen::heading;
use super::{format, theme};
use crate::snapshot::Run;

/// Bars are whole numbers: so many make the highest one.
const STEPS: f64 = 1e6;

/// One sparkline.
struct Graph<'a> {
    title: &'a str,
    /// The newest figures, in words.
    note: Line<'a>,
    /// Height and colour of each bar, newest first.
    bars: Vec<Option<(f64, Color)>>,
    /// What reaches the top, unless a bar is higher.
    top: f64,
}

/// Draws all three side by side.
pub fn draw(frame: &mut Frame<'_>, area: Rect, history: &History, run: &Run) {
    let areas: [Rect; 3] = Layout::horizontal([Constraint::Fill(1); 3]).spacing(2).areas(area);
    let width = usize::from(areas[0].width);
    for (area, graph) in areas.into_iter().zip([tick_cost, real_time_factor, frame_age]) {
        draw_graph(frame, area, graph(history, run, width));
    }
}

/// The wall time that there is for a tick, in seconds; none at full speed.
fn budget(run: &Run) -> f64 {
    run.tick_period.as_secs_f64() / f64::from(run.speed)
}

/// The longest of each slot, by how much of its time it took.
fn tick_cost<'a>(history: &History, run: &Run, width: usize) -> Graph<'a> {
    let budget = budget(run);
    let colour = |cost: f64| match cost / budget {
        _ if budget <= 0.0 => theme::GOOD,
        share if share < 0.5 => theme::GOOD,
        share if share < 1.0 => theme::WARNING,
        _ => theme::BAD,
    };
    Graph {
        title: "tick cost",
        note: times(history.newest().tick_cost),
        bars: bars(history, width, |slot| slot.tick_cost.map(|(_, max)| max), colour),
        top: 0.0,
    }
}

fn real_time_factor<'a>(history: &History, run: &Run, width: usize) -> Graph<'a> {
    let wanted = f64::from(run.speed);
    let colour = |factor| if wanted.is_infinite() || factor >= 0.95 * wanted { theme::GOOD } else { theme::WARNING };
    let note = run.real_time_factor.map(|factor| {
        let of = if wanted.is_finite() { format!(" of {}", format::speed(run.speed)) } else { String::new() };
        Line::from(vec![Span::styled(format::factor(factor), theme::strong()), Span::styled(of, theme::quiet())])
    });
    Graph {
        title: "real time",
        note: note.unwrap_or_default(),
        bars: bars(history, width, |slot| slot.real_time_factor, colour),
        top: if wanted.is_finite() { wanted } else { 0.0 },
    }
}

/// The longest of each slot; a frame that is older than a tick was overtaken.
fn frame_age<'a>(history: &History, run: &Run, width: usize) -> Graph<'a> {
    let budget = budget(run);
    let colour = |age| if budget <= 0.0 || age < budget { theme::NEUTRAL } else { theme::WARNING };
    Graph {
        title: "frame age",
        note: times(history.newest().frame_age),
        bars: bars(history, width, |slot| slot.frame_age.map(|(_, max)| max), colour),
        top: 0.0,
    }
}

/// Mean and longest in words.
fn times<'a>(mean_and_max: Option<(f64, f64)>) -> Line<'a> {
    let Some((mean, max)) = mean_and_max else { return Line::default() };
    Line::from(vec![
        Span::styled(format::seconds(mean), theme::strong()),
        Span::styled(format!(" ≤ {}", format::seconds(max)), theme::quiet()),
    ])
}

fn bars(
    history: &History,
    width: usize,
    figure: impl Fn(&Slot) -> Option<f64>,
    colour: impl Fn(f64) -> Color,
) -> Vec<Option<(f64, Color)>> {
    history.newest_first(figure).take(width).map(|value| value.map(|value| (value, colour(value)))).collect()
}

fn draw_graph(frame: &mut Frame<'_>, area: Rect, graph: Graph<'_>) {
    let area = heading(frame, area, graph.title, graph.note);
    let top = graph.bars.iter().flatten().map(|bar| bar.0).fold(graph.top, f64::max).max(f64::MIN_POSITIVE);
    let bar = |bar: &Option<(f64, Color)>| match bar {
        // Whatever was measured shows.
        Some((value, colour)) => {
            SparklineBar::from(Some(((value / top * STEPS) as u64).max(1))).style(theme::text(*colour))
        }
        None => SparklineBar::from(None),
    };
    let sparkline = Sparkline::default().data(graph.bars.iter().map(bar)).max(STEPS as u64);
    frame.render_widget(sparkline.direction(RenderDirection::RightToLeft).absent_value_symbol(" "), area);
}
