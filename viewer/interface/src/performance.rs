//! The durations of the last pictures, and the panel that shows what they were spent on.

use std::collections::VecDeque;
use std::time::Duration;

use egui::{Color32, Rect, RichText, Sense, Ui, pos2, vec2};

use super::context::PanelContext;
use super::style::{self, heading, line};
use crate::text::thousands;

/// The number of pictures over which durations are kept.
const PICTURES: usize = 120;

/// The durations of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureTime {
    /// The time since the picture before.
    pub period: Duration,
    /// Reading the fleet.
    pub reading: Duration,
    /// Uploads to the GPU.
    pub uploads: Duration,
    /// Encoding the commands of the GPU.
    pub encoding: Duration,
    /// Showing the panels.
    pub interface: Duration,
    /// Waiting for the screen.
    pub waiting: Duration,
}

/// A part of a picture's duration, in seconds.
type Part = fn(&PictureTime) -> f32;

/// The parts of a picture's duration. The last one takes no time of the processor.
const PARTS: [(&str, Part); 5] = [
    ("reading", |time| time.reading.as_secs_f32()),
    ("uploads", |time| time.uploads.as_secs_f32()),
    ("encoding", |time| time.encoding.as_secs_f32()),
    ("interface", |time| time.interface.as_secs_f32()),
    ("waiting for the screen", |time| time.waiting.as_secs_f32()),
];

/// The durations of the last pictures.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// The name of the graphics adapter.
    pub adapter: String,
    /// The oldest picture first.
    pictures: VecDeque<PictureTime>,
    /// GPU seconds of the pictures for which they were measured.
    gpu: VecDeque<f32>,
}

impl Timing {
    /// Creates an empty record.
    pub fn new(adapter: String) -> Self {
        Self { adapter, ..Self::default() }
    }

    /// Adds a picture.
    pub fn push(&mut self, picture: PictureTime) {
        if self.pictures.len() == PICTURES {
            self.pictures.pop_front();
        }
        self.pictures.push_back(picture);
    }

    /// Adds the seconds that the GPU spent on one picture of the fleet.
    pub fn push_gpu(&mut self, seconds: f32) {
        if self.gpu.len() == PICTURES {
            self.gpu.pop_front();
        }
        self.gpu.push_back(seconds);
    }

    /// Returns the mean GPU seconds of a picture of the fleet; `None` where the adapter doesn't
    /// measure them.
    fn gpu(&self) -> Option<f32> {
        (!self.gpu.is_empty()).then(|| self.gpu.iter().sum::<f32>() / self.gpu.len() as f32)
    }

    /// Returns the pictures per second, over the last 30 pictures.
    fn rate(&self) -> f32 {
        let (mut count, mut secs) = (0.0, 0.0);
        for picture in self.pictures.iter().rev().take(30) {
            count += 1.0;
            secs += picture.period.as_secs_f32();
        }
        if secs > 0.0 { count / secs } else { 0.0 }
    }

    /// Returns the mean seconds of a part.
    fn mean(&self, part: Part) -> f32 {
        self.pictures.iter().map(part).sum::<f32>() / self.pictures.len().max(1) as f32
    }
}

/// Shows the panel.
pub(super) fn show(context: &PanelContext<'_>, ui: &mut Ui) {
    let (colours, timing) = (context.colours, context.model.timing);
    ui.label(RichText::new(format!("{:.0} pictures/s", timing.rate())).size(20.0));
    ui.label(style::faint(ui, &timing.adapter));
    let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), 60.0), Sense::hover());
    let part_colours = [colours.accent, colours.good, colours.warn, colours.bad, colours.line];
    bars(ui, area, timing, &part_colours);
    heading(ui, "mean time per picture");
    for ((name, part), colour) in PARTS.into_iter().zip(part_colours) {
        ui.horizontal(|ui| {
            let (dot, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
            ui.painter().rect_filled(dot, 2.0, colour);
            line(ui, name, millis(timing.mean(part)));
        });
    }
    let cpu: f32 = PARTS[..3].iter().map(|(_, part)| timing.mean(*part)).sum();
    line(ui, "CPU, without the interface", millis(cpu));
    let gpu = timing.gpu().map_or("not measured".to_owned(), millis);
    line(ui, "GPU, the fleet", gpu);
    heading(ui, "frames");
    line(ui, "read", thousands(context.model.counts.read));
    line(ui, "skipped", thousands(context.model.counts.skipped));
    let lag = context.model.lag.map_or("–".to_owned(), |lag| format!("{:.1} ms", lag * 1e3));
    line(ui, "lag", lag);
    ui.label(style::faint(
        ui,
        "Frames are skipped when the engine publishes more of them than the screen shows.",
    ));
}

/// Draws a stacked bar for each picture, without the time spent waiting for the screen.
fn bars(ui: &Ui, area: Rect, timing: &Timing, colours: &[Color32]) {
    ui.painter().rect_filled(area, 4.0, ui.visuals().extreme_bg_color);
    let busy = &PARTS[..4];
    let totals =
        timing.pictures.iter().map(|time| busy.iter().map(|(_, part)| part(time)).sum::<f32>());
    let highest = totals.fold(0.002, f32::max);
    let width = area.width() / PICTURES as f32;
    for (i, time) in timing.pictures.iter().enumerate() {
        let left = area.left() + i as f32 * width;
        let mut bottom = area.bottom();
        for ((_, part), colour) in busy.iter().zip(colours) {
            let top = bottom - part(time) / highest * area.height();
            let bar = Rect::from_min_max(pos2(left, top), pos2(left + width * 0.9, bottom));
            ui.painter().rect_filled(bar, 0.0, *colour);
            bottom = top;
        }
    }
}

/// Formats seconds as milliseconds. The sum of nothing is a negative zero.
fn millis(secs: f32) -> String {
    format!("{:.2} ms", secs * 1e3 + 0.0)
}
