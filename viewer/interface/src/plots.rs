//! The figures of the fleet over time, in a row of plots. Hovering over one shows its time in all
//! of them. A click goes to that time, in a recording or in the kept part of a live run.

use egui::text::{LayoutJob, TextFormat};
use egui::{Color32, FontId, Label, Rangef, Role, Ui, Vec2, WidgetInfo, pos2, vec2};
use egui_plot::{AxisHints, GridMark, Line, Plot, PlotPoint, PlotPoints};
use regatta_plugin::activity::Activity;
use regatta_plugin::history::FleetSample as Sample;

use super::context::{PanelContext, Request};
use super::plan::round_step;
use super::spots::{clock, known_hint, known_text};
use super::style::{self, activity_colour};
use crate::text::thousands;

/// The least distance between two marks of the axis of time, in points.
const TIME_POINTS: f32 = 85.0;
/// The height of an axis of time, in points.
const TIME_AXIS: f32 = 18.0;
/// The least distance of two numbers of an upright axis, in points.
const NUMBER_POINTS: f32 = 24.0;
/// The distances of two texts of an axis between which they fade in, in points: below those of all
/// marks, so that none is faint.
const OPAQUE_TIMES: Rangef = Rangef { min: 40.0, max: 50.0 };
const OPAQUE_NUMBERS: Rangef = Rangef { min: 12.0, max: 16.0 };
/// Distances between marks of the axis of time, in seconds.
const STEPS: [f64; 18] = [
    1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 900.0, 1_800.0, 3_600.0, 7_200.0,
    14_400.0, 21_600.0, 43_200.0, 86_400.0,
];

/// The heights of the panel in points from which on there is room for the axis of time, and for the
/// values of several lines in rows of their own.
const FULL_HEIGHT: f32 = 80.0;
const HIGH_HEIGHT: f32 = 125.0;
/// The least size of a plot without its title, in points.
const LEAST_PLOT: Vec2 = vec2(64.0, 12.0);

/// The parts of a plot that are shown.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Detail {
    /// The title, the value of a single line, and the lines. Other values are shown on hovering.
    Low,
    /// The axis of time, too.
    Full,
    /// The values of several lines, too.
    High,
}

impl Detail {
    /// Returns what there is room for in a panel of some height in points.
    fn of(height: f32) -> Self {
        match height {
            HIGH_HEIGHT.. => Self::High,
            FULL_HEIGHT.. => Self::Full,
            _ => Self::Low,
        }
    }

    /// Whether the values of so many lines are shown beside the title.
    fn has_values(self, lines: usize) -> bool {
        self == Self::High || lines == 1
    }
}

/// A plot: its title, and its lines.
struct Figure {
    title: &'static str,
    lines: Vec<NamedLine>,
}

/// A line of a plot.
struct NamedLine {
    name: &'static str,
    colour: Color32,
    /// Times in seconds, and values.
    points: Vec<[f64; 2]>,
}

/// The panel of the plots.
#[derive(Debug, Default)]
pub(super) struct PlotsPanel {
    /// The time under the pointer in a plot, in seconds.
    hovered_secs: Option<f64>,
}

impl PlotsPanel {
    /// Shows the panel.
    pub fn show(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let samples = &context.model.jams.series;
        if samples.len() < 2 {
            ui.label(style::faint(ui, "no figures yet"));
            return;
        }
        let ends = [samples[0].secs, samples[samples.len() - 1].secs];
        let figures = figures(context, samples);
        let hovered = self.hovered_secs;
        // The history of a recording, and of the past of a live run, is longer than the shown part.
        let is_within = context.model.recording().is_some() || context.model.is_past();
        let shown = context.model.clock_secs().filter(|_| is_within);
        let (mut now_hovered, mut clicked) = (None, None);
        ui.spacing_mut().item_spacing.y = 2.0;
        let detail = Detail::of(ui.available_height());
        if detail >= Detail::Full {
            ui.label(style::faint(ui, known_text(context.model)))
                .on_hover_text(known_hint(context.model));
        }
        ui.columns(figures.len(), |columns| {
            for (ui, figure) in columns.iter_mut().zip(&figures) {
                let times = Times { ends, shown, hovered };
                let found = plot(context, ui, figure, samples, times, detail);
                now_hovered = found.0.or(now_hovered);
                clicked = found.1.or(clicked);
            }
        });
        self.hovered_secs = now_hovered;
        if let Some(secs) = clicked {
            context.ask(Request::GoToTime(secs));
        }
    }
}

fn figures(context: &PanelContext<'_>, samples: &[Sample]) -> Vec<Figure> {
    let colours = context.colours;
    let waiting = activity_colour(Activity::Waiting, context.theme);
    vec![
        Figure { title: "robots by activity", lines: activities(context, samples) },
        one("waiting", waiting, samples, |sample| Some(sample.count(Activity::Waiting).into())),
        one("touching pairs", colours.bad, samples, |sample| sample.touching().map(f64::from)),
        one("edges entered per hour", colours.good, samples, |sample| {
            sample.throughput().map(f64::from)
        }),
        one("mean speed, m/s", colours.accent, samples, |sample| Some(sample.mean_speed.into())),
    ]
}

/// A line for each activity that robots have had.
fn activities(context: &PanelContext<'_>, samples: &[Sample]) -> Vec<NamedLine> {
    let mut lines = Vec::new();
    for activity in Activity::ALL {
        if samples.iter().any(|sample| sample.count(activity) > 0) {
            let colour = activity_colour(activity, context.theme);
            lines.push(line(activity.name(), colour, samples, |sample| {
                Some(sample.count(activity).into())
            }));
        }
    }
    lines
}

/// A figure of one line.
fn one(
    title: &'static str,
    colour: Color32,
    samples: &[Sample],
    value: impl Fn(&Sample) -> Option<f64>,
) -> Figure {
    Figure { title, lines: vec![line("", colour, samples, value)] }
}

fn line(
    name: &'static str,
    colour: Color32,
    samples: &[Sample],
    value: impl Fn(&Sample) -> Option<f64>,
) -> NamedLine {
    let points = samples.iter().filter_map(|sample| Some([sample.secs, value(sample)?]));
    NamedLine { name, colour, points: points.collect() }
}

/// The times of plots, in seconds.
#[derive(Clone, Copy)]
struct Times {
    /// The first and the last time.
    ends: [f64; 2],
    /// The time that the picture of the fleet shows, if it isn't the present.
    shown: Option<f64>,
    /// The time under the pointer in one of the plots.
    hovered: Option<f64>,
}

/// Shows a plot, with lines at the shown time and at the one that the pointer is over. Returns
/// the times at which the pointer is over it, and at which it was clicked.
fn plot(
    context: &PanelContext<'_>,
    ui: &mut Ui,
    figure: &Figure,
    samples: &[Sample],
    times: Times,
    detail: Detail,
) -> (Option<f64>, Option<f64>) {
    values(context, ui, figure, samples, times, detail);
    if figure.lines.iter().all(|line| line.points.is_empty()) {
        ui.label(style::faint(ui, "not published"));
        return (None, None);
    }
    let colours = context.colours;
    let plotted = axes(ui, figure, times, detail).show(ui, |axes| {
        for NamedLine { name, colour, points } in &figure.lines {
            axes.line(Line::new(*name, PlotPoints::from(points.clone())).color(*colour).width(1.5));
        }
        for (name, secs, colour) in
            [("shown", times.shown, colours.accent), ("pointer", times.hovered, colours.faint)]
        {
            if let Some(secs) = secs {
                axes.vline(egui_plot::VLine::new(name, secs).color(colour).width(1.0));
            }
        }
        axes.pointer_coordinate().map(|PlotPoint { x, .. }| x)
    });
    let mut response = plotted.response;
    let name = format!("plot of {}", figure.title);
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, &name));
    if !detail.has_values(figure.lines.len()) {
        response = response.on_hover_ui_at_pointer(|ui| {
            values(context, ui, figure, samples, times, Detail::High);
        });
    }
    let pointer = plotted.inner.filter(|_| response.hovered());
    (pointer, pointer.filter(|_| response.clicked()))
}

/// Shows the title of a plot, and its values at the time under the pointer, else at the shown one.
fn values(
    context: &PanelContext<'_>,
    ui: &mut Ui,
    figure: &Figure,
    samples: &[Sample],
    times: Times,
    detail: Detail,
) {
    let near = times.hovered.or(times.shown).and_then(|secs| {
        samples.iter().min_by(|a, b| (a.secs - secs).abs().total_cmp(&(b.secs - secs).abs()))
    });
    let at = near.map_or(times.ends[1], |sample| sample.secs);
    let has_room = detail.has_values(figure.lines.len());
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 5.0;
        ui.label(style::faint(ui, figure.title));
        for NamedLine { name, colour, points } in figure.lines.iter().filter(|_| has_room) {
            let value = points
                .iter()
                .rfind(|point| point[0] <= at)
                .map_or("–".to_owned(), |point| number(point[1]));
            let text = if name.is_empty() { value } else { format!("{name} {value}") };
            // In their own colours, some texts would be hard to read.
            let mut job = LayoutJob::default();
            let format = TextFormat::simple(FontId::proportional(11.0), context.colours.text);
            job.append(&text, 10.0, format);
            let place = ui.add(Label::new(job).extend()).rect;
            ui.painter().circle_filled(pos2(place.left() + 3.5, place.center().y), 3.5, *colour);
        }
        if let Some(sample) = near.filter(|_| has_room) {
            ui.add(Label::new(style::faint(ui, format!("at {}", clock(sample.secs)))).extend());
        }
    });
}

/// Returns the axes of a plot.
fn axes<'a>(ui: &Ui, figure: &Figure, times: Times, detail: Detail) -> Plot<'a> {
    let room = ui.available_width() - 40.0;
    let time_axis = if detail >= Detail::Full { TIME_AXIS } else { 0.0 };
    let height = ui.available_height() - time_axis;
    Plot::new(figure.title)
        .include_x(times.ends[0])
        .include_x(times.ends[1])
        .include_y(0.0)
        .include_y(1.0)
        .show_axes([detail >= Detail::Full, true])
        .min_size(LEAST_PLOT)
        .custom_x_axes(vec![AxisHints::new_x().label_spacing(OPAQUE_TIMES)])
        .custom_y_axes(vec![AxisHints::new_y().label_spacing(OPAQUE_NUMBERS)])
        .y_axis_min_width(34.0)
        .y_grid_spacer(move |input| marks(input.bounds, height))
        .x_grid_spacer(move |input| time_marks(input.bounds, room))
        .y_axis_formatter(|mark, _| number(mark.value))
        .x_axis_formatter(|mark, _| clock(mark.value))
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .show_background(false)
        .show_x(false)
        .show_y(false)
}

/// Returns the marks of an upright axis of some points, at round values: two or three, for whose
/// numbers there is room.
fn marks((low, high): (f64, f64), points: f32) -> Vec<GridMark> {
    let mut step_size = f64::from(round_step((high - low) as f32));
    let least = (high - low) * f64::from(NUMBER_POINTS / points.max(NUMBER_POINTS));
    while step_size < least && 2.0 * step_size <= high - low {
        step_size *= 2.0;
    }
    let range = (low / step_size).ceil() as i64..=(high / step_size).floor() as i64;
    range.map(|i| GridMark { value: i as f64 * step_size, step_size }).collect()
}

/// Returns the marks of a plot's axis of time, at round times, in an axis of some points.
fn time_marks((low, high): (f64, f64), points: f32) -> Vec<GridMark> {
    let least = (high - low) * f64::from(TIME_POINTS / points.max(TIME_POINTS));
    let days = (least / 86_400.0).ceil() * 86_400.0;
    let step_size = STEPS.into_iter().find(|step| *step >= least).unwrap_or(days);
    let range = (low / step_size).ceil() as i64..=(high / step_size).floor() as i64;
    range.map(|i| GridMark { value: i as f64 * step_size, step_size }).collect()
}

/// Formats a value beside a plot.
fn number(value: f64) -> String {
    if value.fract() == 0.0 || value >= 1000.0 {
        thousands(value.max(0.0) as u64)
    } else {
        super::ramp::short(value as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_round_and_have_room() {
        let values = |high, points| {
            time_marks((0.0, high), points).into_iter().map(|mark| mark.value).collect::<Vec<_>>()
        };
        assert_eq!(values(875.0, 200.0), [0.0, 600.0]);
        assert_eq!(values(875.0, 400.0), [0.0, 300.0, 600.0]);
        assert_eq!(values(4.2, 400.0), [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(values(3.0 * 86_400.0, 200.0), [0.0, 172_800.0]);
        assert_eq!(time_marks((120.0, 130.0), 0.0).len(), 2, "a plot without room");
    }

    #[test]
    fn an_axis_has_two_or_three_marks() {
        for high in [1.0, 1.04, 1.9, 2.0, 4.9, 5.0, 7.0, 9.99, 10.0, 123.0, 377_881.0] {
            let values = marks((0.0, high), 100.0);
            assert!((2..=3).contains(&values.len()), "{high}: {values:?}");
            assert!(
                values.iter().all(|mark| (0.0..=high).contains(&mark.value)),
                "{high}: {values:?}"
            );
        }
    }

    #[test]
    fn the_texts_of_all_marks_are_opaque() {
        const { assert!(OPAQUE_TIMES.max < TIME_POINTS && OPAQUE_NUMBERS.max < NUMBER_POINTS) };
    }

    #[test]
    fn a_low_axis_has_no_more_marks_than_numbers_with_room() {
        let values = |high, points| {
            marks((0.0, high), points).into_iter().map(|mark| mark.value).collect::<Vec<_>>()
        };
        assert_eq!(values(400.0, 100.0), [0.0, 200.0, 400.0]);
        assert_eq!(values(400.0, 38.0), [0.0, 400.0]);
        assert_eq!(values(260.0, 38.0), [0.0, 200.0]);
        assert_eq!(values(1.0, 10.0), [0.0, 1.0]);
    }
}
