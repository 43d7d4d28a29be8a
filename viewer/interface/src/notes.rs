//! Notes that the user writes: a text at the shown time. Those of a recording are kept in the file
//! beside it, those of a live run in this window.

use egui::{Key, RichText, TextEdit, Ui};
use regatta_plugin::recording::{MarkKind, RecordingMark};

use super::context::PanelContext;
use super::timeline::colour_of;
use super::transport::clock_text;
use super::view_model::Action;

/// The maximum number of bytes of a note.
const LONGEST: usize = 200;
/// The maximum number of notes of a live run.
const MOST: usize = 1000;

/// Notes of a live run, and one that is being written.
#[derive(Clone, Debug, Default)]
pub(super) struct Notes {
    draft: Option<Draft>,
    /// The run that the notes are of.
    run: u64,
    /// Simulated times in nanoseconds, and texts, sorted.
    live: Vec<(u64, String)>,
}

/// A note that is being written.
#[derive(Clone, Debug)]
struct Draft {
    time: u64,
    text: String,
    had_focus: bool,
}

impl Notes {
    /// The notes of a live run as marks.
    pub fn marks(&self, run: u64) -> Vec<RecordingMark> {
        let notes = self.live.iter().filter(|_| run == self.run);
        let marks = notes.map(|(time_nanos, _)| RecordingMark {
            time_nanos: *time_nanos,
            kind: MarkKind::Note as u32,
            count: 1,
            ..RecordingMark::default()
        });
        marks.collect()
    }

    /// The text of the last note of a live run at or before a time; empty for none.
    pub fn text_at(&self, run: u64, time: u64) -> &str {
        let before = self.live.iter().rev().find(|(at, _)| run == self.run && *at <= time);
        before.map_or("", |(_, text)| text)
    }

    fn add(&mut self, run: u64, time: u64, text: String) {
        if self.run != run {
            (self.run, self.live) = (run, Vec::new());
        }
        let place = self.live.partition_point(|(at, _)| *at <= time);
        self.live.insert(place, (time, text));
        if self.live.len() > MOST {
            self.live.remove(0);
        }
    }

    /// Opens the field for a note at the shown time. Returns whether that is one of a live run.
    pub fn begin(&mut self, context: &PanelContext<'_>) -> bool {
        let Some(time) = context.model.timeline.and_then(|timeline| timeline.now) else {
            context.notify("a note needs the time of a frame, and none is shown");
            return false;
        };
        self.draft = Some(Draft { time, text: String::new(), had_focus: false });
        context.model.recording().is_none()
    }

    /// Shows the button that begins a note, or the field. Enter writes the note, Escape drops it.
    /// Returns whether a note of a live run has begun.
    pub fn field(&mut self, context: &PanelContext<'_>, ui: &mut Ui) -> bool {
        let colour = colour_of(MarkKind::Note, &context.colours);
        let Some(draft) = &mut self.draft else {
            let hint = "Write a note about the shown time (Shift+N)";
            let button = ui.button(RichText::new("note").size(11.0)).on_hover_text(hint);
            return button.clicked() && self.begin(context);
        };
        ui.label(RichText::new(clock_text(draft.time as f64 * 1e-9)).size(11.0).color(colour));
        let room = (ui.available_width() - 60.0).clamp(40.0, 260.0);
        let field = TextEdit::singleline(&mut draft.text)
            .hint_text("note")
            .char_limit(LONGEST)
            .desired_width(room);
        let response = ui.add(field);
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::TextInput, true, "text of the note")
        });
        if !draft.had_focus {
            response.request_focus();
            draft.had_focus = true;
        }
        if response.lost_focus() {
            let is_written = ui.input(|input| input.key_pressed(Key::Enter));
            if let Some(draft) = self.draft.take().filter(|_| is_written) {
                self.write(context, draft);
            }
        }
        false
    }

    fn write(&mut self, context: &PanelContext<'_>, draft: Draft) {
        let (time, text) = (draft.time, draft.text.trim().to_owned());
        match context.model.frame {
            _ if text.is_empty() => {}
            _ if context.model.recording().is_some() => context.act(Action::Note { time, text }),
            Some(frame) => self.add(frame.run_id(), time, text),
            None => {}
        }
    }
}
