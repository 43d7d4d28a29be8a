//! Notes that the user writes: a text at the shown time. Those of a recording are kept in the file
//! beside it, those of a live run in this window.

use egui::{Key, RichText, TextEdit, Ui};
use regatta_plugin::recording::{MarkKind, RecordingMark};

use super::state::Interface;
use super::timeline::colour_of;
use super::transport::clock_text;
use super::view_model::{Action, ViewModel};

/// The most bytes of a note.
const LONGEST: usize = 200;
/// The most notes of a live run.
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
        let mark = |(time_nanos, _): &(u64, String)| RecordingMark {
            time_nanos: *time_nanos,
            kind: MarkKind::Note as u32,
            count: 1,
            ..RecordingMark::default()
        };
        if run == self.run { self.live.iter().map(mark).collect() } else { Vec::new() }
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
}

impl Interface {
    /// Opens the field for a note at the shown time, in the timeline.
    pub(super) fn begin_note(&mut self, model: &ViewModel<'_>) {
        let Some(time) = model.timeline.and_then(|timeline| timeline.now) else {
            return self.notify("nothing is shown that a note could be about");
        };
        self.timeline.shows_past |= model.recording().is_none();
        self.notes.draft = Some(Draft { time, text: String::new(), had_focus: false });
    }

    /// Shows the button that begins a note, or the field. Enter writes the note, Escape drops it.
    pub(super) fn note_field(
        &mut self,
        ui: &mut Ui,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let colour = colour_of(MarkKind::Note, &self.colours());
        let Some(draft) = &mut self.notes.draft else {
            let hint = "Write a note about the shown time (Shift+N)";
            if ui.button(RichText::new("note").size(11.0)).on_hover_text(hint).clicked() {
                self.begin_note(model);
            }
            return;
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
        let is_written = response.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
        let is_dropped = response.lost_focus() && !is_written;
        if (is_written || is_dropped)
            && let Some(draft) = self.notes.draft.take().filter(|_| is_written)
        {
            self.write_note(model, draft, actions);
        }
    }

    fn write_note(&mut self, model: &ViewModel<'_>, draft: Draft, actions: &mut Vec<Action>) {
        let (time, text) = (draft.time, draft.text.trim().to_owned());
        match model.frame {
            _ if text.is_empty() => {}
            _ if model.recording().is_some() => actions.push(Action::Note { time, text }),
            Some(frame) => self.notes.add(frame.run_id(), time, text),
            None => {}
        }
    }
}
