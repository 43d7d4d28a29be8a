//! The timeline: a bar over the whole recording with marks of what happened in it, the playhead,
//! and a part that is repeated.

mod paint;

use egui::{Label, Modifiers, Rect, Response, RichText, Sense, Ui, vec2};
use regatta_plugin::control::{ControlKind, ControlRequest};
use regatta_plugin::recording::MarkKind;

use super::icons::{self, Icon};
use super::state::Interface;
use super::style;
use super::transport::clock_text;
use super::view_model::{Action, Live, Timeline, ViewModel};
use crate::text::with_plural;
pub(super) use paint::colour_of;

/// The height of the timeline, in points.
pub const HEIGHT: f32 = 72.0;
/// The height of the marks of one kind, and of the bar below them, in points.
const LANE: f32 = 4.0;
const BAR: f32 = 8.0;
/// A mark counts as reached if the frame that is shown lies at most so long before it, in
/// nanoseconds.
const REACHED: u64 = 2_000_000_000;
/// The shortest part that is repeated, in nanoseconds.
const SHORTEST_LOOP: u64 = 50_000_000;

/// The least width of a row with all texts, in points.
const WIDE: f32 = 640.0;
/// The width of the buttons of a recording's row, and the least width of its name, in points.
const BUTTONS: f32 = 260.0;
const SHORTEST_NAME: f32 = 60.0;
/// The least width of the rest of a row in which a text is shown, in points.
const LEAST_REST: f32 = 24.0;

/// The kinds of marks, from the top lane down, with their names.
const KINDS: [(MarkKind, &str); 4] = [
    (MarkKind::Contact, "contact"),
    (MarkKind::Fault, "fault"),
    (MarkKind::Stop, "stop"),
    (MarkKind::Note, "note"),
];

/// The user's choices on the timeline, and unfinished input.
#[derive(Clone, Copy, Debug, Default)]
pub struct TimelineState {
    /// The time that the pointer drags the playhead to.
    dragged: Option<u64>,
    /// The time that was asked for last.
    asked: Option<u64>,
    /// The first end of a part to repeat whose other end isn't chosen yet.
    loop_start: Option<u64>,
    /// The part that is repeated.
    pub repeated: Option<(u64, u64)>,
    /// The time of the last picture, unless the user has gone elsewhere since.
    last: Option<u64>,
    was_running: bool,
    /// Whether the bar of a live run is shown.
    pub shows_past: bool,
}

impl Timeline<'_> {
    /// The part of the bar at a time, from 0 to 1.
    fn part(&self, time: u64) -> f32 {
        let length = self.end.saturating_sub(self.start).max(1) as f64;
        (time.saturating_sub(self.start) as f64 / length).clamp(0.0, 1.0) as f32
    }

    fn time_at(&self, rect: Rect, x: f32) -> u64 {
        let part = f64::from(((x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0));
        self.start + (part * self.end.saturating_sub(self.start) as f64).round() as u64
    }
}

/// Shows a text in what is left of a row: with an ellipsis and a tooltip if that is too little, and
/// not at all if it is nothing.
fn rest(ui: &mut Ui, text: RichText) {
    if !text.is_empty() && ui.available_width() > LEAST_REST {
        ui.add(Label::new(text).truncate());
    }
}

/// Says how many marks there is no room for.
fn not_shown(left_out: u64) -> String {
    let verb = if left_out == 1 { "is" } else { "are" };
    format!("{} {verb} not shown", with_plural(left_out, "more mark"))
}

/// Returns the action that goes to a time.
fn seek(time: u64) -> Action {
    Action::Control(ControlRequest { count: time, ..ControlRequest::new(ControlKind::Seek) })
}

impl Interface {
    pub(super) fn timeline(
        &mut self,
        ui: &mut Ui,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let Some(timeline) = model.timeline else { return };
        let run = model.frame.map_or(0, |frame| frame.run_id());
        let marks = self.notes.marks(run);
        let note = self.notes.text_at(run, timeline.now.unwrap_or(timeline.end)).to_owned();
        let timeline = match timeline.live {
            None => timeline,
            Some(_) => Timeline { marks: &marks, note: &note, ..timeline },
        };
        match timeline.live {
            None => {
                self.repeat(model, &timeline, actions);
                ui.horizontal(|ui| self.timeline_title(ui, &timeline, model, actions));
            }
            Some(live) => {
                ui.horizontal(|ui| self.past_title(ui, &timeline, live, model, actions));
            }
        }
        self.timeline_bar(ui, &timeline, actions);
    }

    fn timeline_title(
        &mut self,
        ui: &mut Ui,
        timeline: &Timeline<'_>,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let (theme, colours) = (self.settings.theme(), self.colours());
        let is_wide = ui.available_width() >= WIDE;
        if is_wide {
            ui.label(RichText::new("recording").size(11.0).color(colours.accent));
        }
        ui.scope(|ui| {
            ui.set_max_width((ui.available_width() - BUTTONS).max(SHORTEST_NAME));
            ui.add(Label::new(RichText::new(timeline.name).strong()).truncate());
        });
        if is_wide {
            let ends = [timeline.start, timeline.end].map(|time| clock_text(time as f64 * 1e-9));
            ui.label(style::faint(ui, theme, ends.join(" – ")));
        }
        self.mark_buttons(ui, model, actions);
        let text = match (self.timeline.loop_start, self.timeline.repeated) {
            (Some(_), _) => "loop: end here",
            (None, Some(_)) => "end the loop",
            (None, None) => "loop from here",
        };
        let hint = "Repeat a part: once for its start, once for its end, once more to end it (Y); or drag with Shift";
        if ui.button(RichText::new(text).size(11.0)).on_hover_text(hint).clicked() {
            self.cycle_loop(model);
        }
        self.note_field(ui, model, actions);
        rest(ui, RichText::new(timeline.note).color(colour_of(MarkKind::Note, &colours)));
        if timeline.searched < timeline.end {
            let part = timeline.part(timeline.searched) * 100.0;
            rest(ui, style::faint(ui, theme, format!("looking for marks: {part:.0} %")));
        } else if timeline.left_out > 0 {
            rest(ui, style::faint(ui, theme, not_shown(timeline.left_out)));
        }
    }

    fn mark_buttons(&mut self, ui: &mut Ui, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let size = vec2(26.0, 20.0);
        for (icon, name, forward) in
            [(Icon::PreviousMark, "Previous mark", false), (Icon::NextMark, "Next mark", true)]
        {
            let key = if forward { "X" } else { "Z" };
            if icons::button(ui, icon, name, size)
                .on_hover_text(format!("{name} ({key})"))
                .clicked()
            {
                self.go_to_mark(model, forward, actions);
            }
        }
    }

    /// Tells how much of a live run is kept, and leads back to it.
    fn past_title(
        &mut self,
        ui: &mut Ui,
        timeline: &Timeline<'_>,
        live: Live,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let (theme, colours) = (self.settings.theme(), self.colours());
        let (text, colour) =
            if live.is_past { ("past", colours.warn) } else { ("live", colours.good) };
        ui.label(RichText::new(text).strong().color(colour));
        if live.is_past && ui.button(RichText::new("back to live").size(11.0)).clicked() {
            self.timeline.asked = None;
            actions.push(Action::LookBack(None));
        }
        if !timeline.marks.is_empty() {
            self.mark_buttons(ui, model, actions);
        }
        self.note_field(ui, model, actions);
        rest(ui, RichText::new(timeline.note).color(colour_of(MarkKind::Note, &colours)));
        let kept = clock_text(timeline.end.saturating_sub(timeline.start) as f64 * 1e-9);
        let megabytes = live.bytes as f64 / f64::from(1 << 20);
        let text = format!(
            "the last {kept} are kept, up to ten minutes: {megabytes:.0} of {} MB",
            Live::BUDGET >> 20
        );
        rest(ui, style::faint(ui, theme, text));
        if live.is_past {
            rest(ui, style::faint(ui, theme, "columns, contacts and routes are not kept"));
        }
    }

    /// Shows or hides the bar of a live run. Without it, the newest frame is shown.
    pub(super) fn toggle_past(&mut self, actions: &mut Vec<Action>) {
        self.timeline.shows_past = !self.timeline.shows_past;
        if !self.timeline.shows_past {
            actions.push(Action::LookBack(None));
        }
    }

    fn timeline_bar(&mut self, ui: &mut Ui, timeline: &Timeline<'_>, actions: &mut Vec<Action>) {
        let size = vec2(ui.available_width(), LANE * KINDS.len() as f32 + BAR + 4.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let now = self.timeline.dragged.or(timeline.now).unwrap_or(timeline.start);
        response.widget_info(|| {
            let mut info = egui::WidgetInfo::labeled(egui::Role::Slider, true, "Timeline");
            info.value = Some(now as f64 * 1e-9);
            info
        });
        self.drag_timeline(ui, rect, &response, timeline, actions);
        let colours = self.colours();
        self.paint_timeline(ui.painter(), rect, timeline, now);
        if let Some(pointer) = response.hover_pos() {
            let time = timeline.time_at(rect, pointer.x);
            ui.painter().vline(pointer.x, rect.y_range(), (1.0, colours.faint));
            response.on_hover_text_at_pointer(self.describe(timeline, rect, time));
        }
    }

    /// Goes where the pointer is; with Shift, marks the part to repeat.
    fn drag_timeline(
        &mut self,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        timeline: &Timeline<'_>,
        actions: &mut Vec<Action>,
    ) {
        let marks_loop = timeline.live.is_none()
            && ui.input(|input| input.modifiers.matches_logically(Modifiers::SHIFT));
        let is_down = response.is_pointer_button_down_on() || response.clicked();
        let Some(pointer) = response.interact_pointer_pos().filter(|_| is_down) else {
            self.timeline.dragged = None;
            if response.drag_stopped()
                && let (Some(_), Some((from, _))) =
                    (self.timeline.loop_start.take(), self.timeline.repeated)
            {
                self.ask_for(from, actions);
            }
            return;
        };
        let time = timeline.time_at(rect, pointer.x);
        if marks_loop {
            let start = if response.drag_started() {
                time
            } else {
                self.timeline.loop_start.unwrap_or(time)
            };
            self.timeline.loop_start = Some(start);
            self.set_loop(start, time);
        } else if self.timeline.dragged != Some(time) {
            self.timeline.dragged = Some(time);
            match timeline.live {
                Some(_) => actions.push(Action::LookBack(Some(time))),
                None => self.ask_for(time, actions),
            }
        }
    }

    fn set_loop(&mut self, one: u64, other: u64) {
        let part = (one.min(other), one.max(other));
        self.timeline.repeated = (part.1 - part.0 >= SHORTEST_LOOP).then_some(part);
    }

    fn ask_for(&mut self, time: u64, actions: &mut Vec<Action>) {
        (self.timeline.asked, self.timeline.last) = (Some(time), None);
        actions.push(seek(time));
    }

    /// Goes to a time of the shown clock: in a recording, or in what is kept of a live run.
    pub(super) fn go_to_time(
        &mut self,
        secs: f64,
        model: &ViewModel<'_>,
        actions: &mut Vec<Action>,
    ) {
        let Some(timeline) = model.timeline else { return };
        let nanos = (secs.max(0.0) * 1e9) as u64;
        match timeline.live {
            None => self.ask_for(nanos.clamp(timeline.start, timeline.end), actions),
            Some(_) if nanos >= timeline.start => {
                self.timeline.shows_past = true;
                actions.push(Action::LookBack(Some(nanos)));
            }
            Some(_) => {
                let start = clock_text(timeline.start as f64 * 1e-9);
                self.notify(format!("of this run, only what is after {start} is kept"));
            }
        }
    }

    /// Goes to the next mark, or to the previous one.
    pub(super) fn go_to_mark(
        &mut self,
        model: &ViewModel<'_>,
        forward: bool,
        actions: &mut Vec<Action>,
    ) {
        let Some(timeline) = model.timeline else { return };
        let notes = self.notes.marks(model.frame.map_or(0, |frame| frame.run_id()));
        let timeline =
            if timeline.live.is_some() { Timeline { marks: &notes, ..timeline } } else { timeline };
        let now = timeline.now.unwrap_or(timeline.start);
        // The frame of a mark may lie before it, if not every frame was recorded.
        let reached = self.timeline.asked.filter(|asked| *asked >= now && asked - now < REACHED);
        let from = reached.unwrap_or(now);
        let found = if forward {
            timeline
                .marks
                .iter()
                .map(|mark| mark.time_nanos)
                .find(|time| *time > from && *time <= timeline.end)
        } else {
            timeline
                .marks
                .iter()
                .rev()
                .map(|mark| mark.time_nanos)
                .find(|time| *time < from && *time >= timeline.start)
        };
        match found {
            Some(time) if timeline.live.is_some() => {
                (self.timeline.asked, self.timeline.shows_past) = (Some(time), true);
                actions.push(Action::LookBack(Some(time)));
            }
            Some(time) => self.ask_for(time, actions),
            None => self.notify(if forward { "no mark after this" } else { "no mark before this" }),
        }
    }

    /// Goes back by one recorded frame, and stands there.
    pub(super) fn step_back(&mut self, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let Some(timeline) = model.recording() else { return self.past_step_back(model, actions) };
        if !model.is_paused() {
            actions.push(Action::Control(ControlRequest::new(ControlKind::Pause)));
        }
        // A replay shows the newest frame at or before a time.
        match timeline.now.filter(|now| *now > timeline.start) {
            Some(now) => self.ask_for(now - 1, actions),
            None => self.notify("this is the first frame"),
        }
    }

    /// Shows the kept frame of a live run before the shown one.
    fn past_step_back(&mut self, model: &ViewModel<'_>, actions: &mut Vec<Action>) {
        let Some(timeline) = model.timeline else { return };
        self.timeline.shows_past = true;
        match timeline.now.filter(|now| *now > timeline.start) {
            Some(now) => actions.push(Action::LookBack(Some(now - 1))),
            None => self.notify("nothing older is kept"),
        }
    }

    /// Begins the part to repeat, ends it, or stops repeating.
    pub(super) fn cycle_loop(&mut self, model: &ViewModel<'_>) {
        let Some(now) = model.recording().and_then(|timeline| timeline.now) else { return };
        match (self.timeline.loop_start.take(), self.timeline.repeated.take()) {
            (Some(start), _) => {
                self.set_loop(start, now);
                self.timeline.last = Some(start.min(now));
            }
            (None, Some(_)) => {}
            (None, None) => self.timeline.loop_start = Some(now),
        }
    }

    /// Sends the playhead back at the end of the part that is repeated. At the end of the
    /// recording, the clock stands by itself.
    fn repeat(
        &mut self,
        model: &ViewModel<'_>,
        timeline: &Timeline<'_>,
        actions: &mut Vec<Action>,
    ) {
        let is_running = !model.is_paused();
        let was_running = std::mem::replace(&mut self.timeline.was_running, is_running);
        let (Some((from, to)), Some(now)) = (self.timeline.repeated, timeline.now) else { return };
        // A part that is chosen while the clock stands is repeated when it runs.
        if !(is_running || was_running) {
            return;
        }
        // Whoever goes elsewhere stays there.
        let was_inside =
            self.timeline.last.replace(now).is_some_and(|last| (from..to).contains(&last));
        if now < to || !was_inside {
            return;
        }
        self.ask_for(from, actions);
        if !is_running {
            actions.push(Action::Control(ControlRequest::new(ControlKind::Resume)));
        }
    }
}
