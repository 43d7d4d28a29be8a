//! How fast pictures come, and what takes the time.

use std::collections::VecDeque;

use egui::{Rect, RichText, Sense, Ui, pos2, vec2};

use super::Interface;
use super::facts::Facts;
use super::style::{self, heading, line, thousands};

/// Pictures that the bars show.
const PICTURES: usize = 120;
/// What a picture's time goes into.
const PARTS: [&str; 5] = ["reading", "uploads", "encoding", "interface", "waiting for the screen"];

/// Times of the last pictures.
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// The adapter, for a person.
    adapter: String,
    /// Seconds of one picture: what the parts took, and from one picture to the next.
    pictures: VecDeque<([f32; 5], f32)>,
    /// Seconds that the GPU took for some of them.
    gpu: VecDeque<f32>,
}

impl Timing {
    /// Without pictures yet.
    pub fn new(adapter: String) -> Self {
        Self { adapter, ..Self::default() }
    }

    /// Takes one picture: seconds of its parts, and since the one before.
    pub fn push(&mut self, parts: [f32; 5], period: f32) {
        if self.pictures.len() == PICTURES {
            self.pictures.pop_front();
        }
        self.pictures.push_back((parts, period));
    }

    /// Takes the seconds that the GPU took for one picture of the fleet.
    pub fn push_gpu(&mut self, seconds: f32) {
        if self.gpu.len() == PICTURES {
            self.gpu.pop_front();
        }
        self.gpu.push_back(seconds);
    }

    /// Mean seconds of the GPU for a picture of the fleet; `None` where it doesn't tell.
    pub fn gpu(&self) -> Option<f32> {
        (!self.gpu.is_empty()).then(|| self.gpu.iter().sum::<f32>() / self.gpu.len() as f32)
    }

    /// Pictures a second over the last ones.
    pub fn rate(&self) -> f32 {
        let last = self.pictures.iter().rev().take(30);
        let (count, time) = last.fold((0.0, 0.0), |(count, time), (_, period)| (count + 1.0, time + period));
        if time > 0.0 { count / time } else { 0.0 }
    }

    /// Mean seconds of a part over the last pictures.
    fn mean(&self, part: usize) -> f32 {
        self.pictures.iter().map(|(parts, _)| parts[part]).sum::<f32>() / self.pictures.len().max(1) as f32
    }
}

impl Interface {
    pub(super) fn performance(&mut self, ui: &mut Ui, facts: &Facts<'_>) {
        let (theme, tones, timing) = (self.settings.theme(), self.tones(), facts.timing);
        ui.label(RichText::new(format!("{:.0} pictures/s", timing.rate())).size(20.0));
        ui.label(style::faint(ui, theme, &timing.adapter));
        let (area, _) = ui.allocate_exact_size(vec2(ui.available_width(), 60.0), Sense::hover());
        let colours = [tones.accent, tones.good, tones.warn, tones.bad, tones.line];
        bars(ui, area, timing, colours);
        heading(ui, theme, "mean of a picture");
        for (part, (name, colour)) in PARTS.into_iter().zip(colours).enumerate() {
            ui.horizontal(|ui| {
                let (dot, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
                ui.painter().rect_filled(dot, 2.0, colour);
                line(ui, theme, name, format!("{:.2} ms", timing.mean(part) * 1e3));
            });
        }
        let own: f32 = (0..3).map(|part| timing.mean(part)).sum();
        line(ui, theme, "processor, without interface", format!("{:.2} ms", own * 1e3));
        let gpu = timing.gpu().map_or("not told".to_owned(), |gpu| format!("{:.2} ms", gpu * 1e3));
        line(ui, theme, "graphics card, the fleet", gpu);
        heading(ui, theme, "frames");
        line(ui, theme, "read", thousands(facts.counts.read));
        line(ui, theme, "skipped", thousands(facts.counts.skipped));
        let lag = facts.lag.map_or("–".to_owned(), |lag| format!("{:.1} ms", lag * 1e3));
        line(ui, theme, "age when read", lag);
        ui.label(style::faint(
            ui,
            theme,
            "Frames are skipped whenever the engine makes more of them than the screen shows.",
        ));
    }
}

/// A stack for each picture. The waiting is left out: it is what is left of the screen's period.
fn bars(ui: &Ui, area: Rect, timing: &Timing, colours: [egui::Color32; 5]) {
    ui.painter().rect_filled(area, 4.0, ui.visuals().extreme_bg_color);
    let own = |parts: &[f32; 5]| parts[..4].iter().sum::<f32>();
    let most = timing.pictures.iter().map(|(parts, _)| own(parts)).fold(0.002, f32::max);
    let width = area.width() / PICTURES as f32;
    for (i, (parts, _)) in timing.pictures.iter().enumerate() {
        let left = area.left() + i as f32 * width;
        let mut bottom = area.bottom();
        for (part, colour) in parts[..4].iter().zip(colours) {
            let top = bottom - part / most * area.height();
            let bar = Rect::from_min_max(pos2(left, top), pos2(left + width * 0.9, bottom));
            ui.painter().rect_filled(bar, 0.0, colour);
            bottom = top;
        }
    }
}
