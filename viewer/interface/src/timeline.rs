//! The timeline: a bar over the whole recording with marks of what happened in it, the playhead,
//! and a part that is repeated.

use egui::{
    FontId, Label, Modifiers, Painter, Pos2, Rect, Response, RichText, Sense, Ui, pos2, vec2,
};
use regatta_plugin::control::{ControlKind, ControlRequest};
use regatta_plugin::recording::{MarkKind, RecordingMark};

use super::context::PanelContext;
use super::heat::duration_text;
use super::icons::{self, Icon};
use super::notes::Notes;
use super::style::{self, ThemeColours};
use super::transport::clock_text;
use super::view_model::{Action, Live, Timeline};
use crate::text::{thousands, with_plural};

/// The height of the timeline, in points.
pub const HEIGHT: f32 = 72.0;
/// The height of the marks of one kind, and of the bar below them, in points.
pub(super) const LANE: f32 = 4.0;
const BAR: f32 = 8.0;
/// A mark counts as reached if the shown frame is at most this time before it, in nanoseconds.
const REACHED: u64 = 2_000_000_000;
/// The shortest part that is repeated, in nanoseconds.
const SHORTEST_LOOP: u64 = 50_000_000;

/// The least width of a row with all texts, in points.
const WIDE: f32 = 640.0;
/// The width of the buttons of a recording's row, of its first and last time, and the least width
/// of its name, in points.
const BUTTONS: f32 = 260.0;
const ENDS: f32 = 150.0;
const SHORTEST_NAME: f32 = 60.0;
/// The least width of the rest of a row in which a text is shown, in points.
const LEAST_REST: f32 = 60.0;

/// The kinds of marks, from the top lane down, with their names.
pub(super) const KINDS: [(MarkKind, &str); 4] = [
    (MarkKind::Contact, "contact"),
    (MarkKind::Fault, "fault"),
    (MarkKind::Stop, "stop"),
    (MarkKind::Note, "note"),
];

/// The timeline: the user's choices, and unfinished input.
#[derive(Clone, Debug, Default)]
pub(super) struct TimelinePanel {
    notes: Notes,
    /// The time that the pointer drags the playhead to.
    dragged: Option<u64>,
    /// The time that was asked for last.
    asked: Option<u64>,
    /// The first end of a part to repeat whose other end isn't chosen yet.
    pub loop_start: Option<u64>,
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
    pub(super) fn part(&self, time: u64) -> f32 {
        let length = self.end.saturating_sub(self.start).max(1) as f64;
        (time.saturating_sub(self.start) as f64 / length).clamp(0.0, 1.0) as f32
    }

    fn time_at(&self, rect: Rect, x: f32) -> u64 {
        let part = f64::from(((x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0));
        self.start + (part * self.end.saturating_sub(self.start) as f64).round() as u64
    }
}

/// Shows a text in the rest of a row: with an ellipsis and a tooltip if the rest is too narrow, and
/// not at all without any room.
fn rest(ui: &mut Ui, text: RichText) {
    if !text.is_empty() && ui.available_width() > LEAST_REST {
        ui.add(Label::new(text).truncate());
    }
}

/// Returns how much of a live run is kept, as a text.
fn kept_text(nanos: u64) -> String {
    format!(
        "The last {} of the run are kept: ten minutes, or less of a large fleet.",
        duration_text(nanos as f32 * 1e-9)
    )
}

/// Returns the number of marks that there is no room for, as a text.
fn not_shown(left_out: u64) -> String {
    let verb = if left_out == 1 { "is" } else { "are" };
    format!("{} {verb} not shown", with_plural(left_out, "more mark"))
}

impl TimelinePanel {
    /// Shows the timeline.
    pub fn show(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let Some(timeline) = context.model.timeline else { return };
        let run = context.model.frame.map_or(0, |frame| frame.run_id());
        let marks = self.notes.marks(run);
        let note = self.notes.text_at(run, timeline.now.unwrap_or(timeline.end)).to_owned();
        let timeline = match timeline.live {
            None => timeline,
            Some(_) => Timeline { marks: &marks, note: &note, ..timeline },
        };
        match timeline.live {
            None => {
                self.repeat(context, &timeline);
                ui.horizontal(|ui| self.recording_title(context, ui, &timeline));
            }
            Some(live) => {
                ui.horizontal(|ui| self.past_title(context, ui, &timeline, live));
            }
        }
        self.bar(context, ui, &timeline);
    }

    fn recording_title(
        &mut self,
        context: &PanelContext<'_>,
        ui: &mut Ui,
        timeline: &Timeline<'_>,
    ) {
        let colours = context.colours;
        let is_wide = ui.available_width() >= WIDE;
        if is_wide {
            ui.label(RichText::new("recording").size(11.0).color(colours.accent));
        }
        let others = if is_wide { BUTTONS + ENDS } else { BUTTONS };
        ui.scope(|ui| {
            ui.set_max_width((ui.available_width() - others).max(SHORTEST_NAME));
            ui.add(Label::new(RichText::new(timeline.name).strong()).truncate());
        });
        if is_wide {
            let ends = [timeline.start, timeline.end].map(|time| clock_text(time as f64 * 1e-9));
            ui.label(style::faint(ui, ends.join(" – ")));
        }
        self.mark_buttons(context, ui);
        let text = match (self.loop_start, self.repeated) {
            (Some(_), _) => "loop: end here",
            (None, Some(_)) => "end the loop",
            (None, None) => "loop from here",
        };
        let hint = "Repeat a part: once for its start, once for its end, once more to end it (Y); \
                    or drag with Shift";
        if ui.button(RichText::new(text).size(11.0)).on_hover_text(hint).clicked() {
            self.cycle_loop(context);
        }
        self.shows_past |= self.notes.field(context, ui);
        rest(ui, RichText::new(timeline.note).color(colour_of(MarkKind::Note, &colours)));
        if timeline.searched < timeline.end {
            let part = timeline.part(timeline.searched) * 100.0;
            rest(ui, style::faint(ui, format!("looking for marks: {part:.0} %")));
        } else if timeline.left_out > 0 {
            rest(ui, style::faint(ui, not_shown(timeline.left_out)));
        }
    }

    fn mark_buttons(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let size = vec2(26.0, 20.0);
        for (icon, name, forward) in
            [(Icon::PreviousMark, "Previous mark", false), (Icon::NextMark, "Next mark", true)]
        {
            let key = if forward { "X" } else { "Z" };
            if icons::button(ui, icon, name, size)
                .on_hover_text(format!("{name} ({key})"))
                .clicked()
            {
                self.go_to_mark(context, forward);
            }
        }
    }

    /// Shows the kept part of a live run, and a button that leads back to the newest frame.
    fn past_title(
        &mut self,
        context: &PanelContext<'_>,
        ui: &mut Ui,
        timeline: &Timeline<'_>,
        live: Live,
    ) {
        let colours = context.colours;
        let (text, colour) =
            if live.is_past { ("past", colours.warn) } else { ("live", colours.good) };
        ui.label(RichText::new(text).strong().color(colour));
        if live.is_past && ui.button(RichText::new("back to live").size(11.0)).clicked() {
            self.asked = None;
            context.act(Action::LookBack(None));
        }
        if !timeline.marks.is_empty() {
            self.mark_buttons(context, ui);
        }
        self.shows_past |= self.notes.field(context, ui);
        rest(ui, RichText::new(timeline.note).color(colour_of(MarkKind::Note, &colours)));
        rest(ui, style::faint(ui, kept_text(timeline.end.saturating_sub(timeline.start))));
        if live.is_past {
            rest(
                ui,
                style::faint(ui, "Contacts, routes and other columns than activities aren't kept."),
            );
        }
    }

    /// Shows or hides the bar of a live run. Without it, the newest frame is shown.
    pub fn toggle_past(&mut self, context: &PanelContext<'_>) {
        self.shows_past = !self.shows_past;
        if !self.shows_past {
            context.act(Action::LookBack(None));
        }
    }

    fn bar(&mut self, context: &PanelContext<'_>, ui: &mut Ui, timeline: &Timeline<'_>) {
        let size = vec2(ui.available_width(), LANE * KINDS.len() as f32 + BAR + 4.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let now = self.dragged.or(timeline.now).unwrap_or(timeline.start);
        response.widget_info(|| {
            let mut info = egui::WidgetInfo::labeled(egui::Role::Slider, true, "Timeline");
            info.value = Some(now as f64 * 1e-9);
            info
        });
        self.drag(context, ui, rect, &response, timeline);
        paint(self, ui.painter(), rect, timeline, now, &context.colours);
        if let Some(pointer) = response.hover_pos() {
            let time = timeline.time_at(rect, pointer.x);
            ui.painter().vline(pointer.x, rect.y_range(), (1.0, context.colours.faint));
            response.on_hover_text_at_pointer(describe(timeline, rect, time));
        }
    }

    /// Goes where the pointer is; with Shift, marks the part to repeat.
    fn drag(
        &mut self,
        context: &PanelContext<'_>,
        ui: &Ui,
        rect: Rect,
        response: &Response,
        timeline: &Timeline<'_>,
    ) {
        let marks_loop = timeline.live.is_none()
            && ui.input(|input| input.modifiers.matches_logically(Modifiers::SHIFT));
        let is_down = response.is_pointer_button_down_on() || response.clicked();
        let Some(pointer) = response.interact_pointer_pos().filter(|_| is_down) else {
            self.dragged = None;
            if response.drag_stopped()
                && let (Some(_), Some((from, _))) = (self.loop_start.take(), self.repeated)
            {
                self.seek(context, from);
            }
            return;
        };
        let time = timeline.time_at(rect, pointer.x);
        if marks_loop {
            let start =
                if response.drag_started() { time } else { self.loop_start.unwrap_or(time) };
            self.loop_start = Some(start);
            self.set_loop(start, time);
        } else if self.dragged != Some(time) {
            self.dragged = Some(time);
            match timeline.live {
                Some(_) => context.act(Action::LookBack(Some(time))),
                None => self.seek(context, time),
            }
        }
    }

    fn set_loop(&mut self, one: u64, other: u64) {
        let part = (one.min(other), one.max(other));
        self.repeated = (part.1 - part.0 >= SHORTEST_LOOP).then_some(part);
    }

    fn seek(&mut self, context: &PanelContext<'_>, time: u64) {
        (self.asked, self.last) = (Some(time), None);
        let seek = ControlRequest { count: time, ..ControlRequest::new(ControlKind::Seek) };
        context.act(Action::Control(seek));
    }

    /// Goes to a time of the shown clock, in a recording or in the kept part of a live run.
    pub fn go_to_time(&mut self, context: &PanelContext<'_>, secs: f64) {
        let Some(timeline) = context.model.timeline else { return };
        let nanos = (secs.max(0.0) * 1e9) as u64;
        match timeline.live {
            None => self.seek(context, nanos.clamp(timeline.start, timeline.end)),
            Some(_) if nanos >= timeline.start => {
                self.shows_past = true;
                context.act(Action::LookBack(Some(nanos)));
            }
            Some(_) => {
                let start = clock_text(timeline.start as f64 * 1e-9);
                context.notify(format!("only the part of this run after {start} is kept"));
            }
        }
    }

    /// Goes to the next mark, or to the previous one.
    pub fn go_to_mark(&mut self, context: &PanelContext<'_>, forward: bool) {
        let Some(timeline) = context.model.timeline else { return };
        let notes = self.notes.marks(context.model.frame.map_or(0, |frame| frame.run_id()));
        let timeline =
            if timeline.live.is_some() { Timeline { marks: &notes, ..timeline } } else { timeline };
        let now = timeline.now.unwrap_or(timeline.start);
        // The frame of a mark may lie before it, if not every frame was recorded.
        let reached = self.asked.filter(|asked| *asked >= now && asked - now < REACHED);
        let from = reached.unwrap_or(now);
        let mut times = timeline.marks.iter().map(|mark| mark.time_nanos);
        let found = match forward {
            true => times.find(|time| *time > from && *time <= timeline.end),
            false => times.rfind(|time| *time < from && *time >= timeline.start),
        };
        match found {
            Some(time) if timeline.live.is_some() => {
                (self.asked, self.shows_past) = (Some(time), true);
                context.act(Action::LookBack(Some(time)));
            }
            Some(time) => self.seek(context, time),
            None => {
                context.notify(if forward { "no mark after this" } else { "no mark before this" })
            }
        }
    }

    /// Goes back by one recorded frame, and stands there.
    pub fn step_back(&mut self, context: &PanelContext<'_>) {
        let Some(timeline) = context.model.recording() else { return self.past_step_back(context) };
        if !context.model.is_paused() {
            context.act(Action::Control(ControlRequest::new(ControlKind::Pause)));
        }
        // A replay shows the newest frame at or before a time.
        match timeline.now.filter(|now| *now > timeline.start) {
            Some(now) => self.seek(context, now - 1),
            None => context.notify("this is the first frame"),
        }
    }

    /// Shows the kept frame of a live run before the shown one.
    fn past_step_back(&mut self, context: &PanelContext<'_>) {
        let Some(timeline) = context.model.timeline else { return };
        self.shows_past = true;
        match timeline.now.filter(|now| *now > timeline.start) {
            Some(now) => context.act(Action::LookBack(Some(now - 1))),
            None => context.notify("nothing older is kept"),
        }
    }

    /// Opens the field for a note at the shown time.
    pub fn begin_note(&mut self, context: &PanelContext<'_>) {
        self.shows_past |= self.notes.begin(context);
    }

    /// Begins the part to repeat, ends it, or stops repeating.
    pub fn cycle_loop(&mut self, context: &PanelContext<'_>) {
        let Some(now) = context.model.recording().and_then(|timeline| timeline.now) else { return };
        match (self.loop_start.take(), self.repeated.take()) {
            (Some(start), _) => {
                self.set_loop(start, now);
                self.last = Some(start.min(now));
            }
            (None, Some(_)) => {}
            (None, None) => self.loop_start = Some(now),
        }
    }

    /// Sends the playhead back at the end of the part that is repeated. At the end of the
    /// recording, the clock stands by itself.
    fn repeat(&mut self, context: &PanelContext<'_>, timeline: &Timeline<'_>) {
        let is_running = !context.model.is_paused();
        let was_running = std::mem::replace(&mut self.was_running, is_running);
        let (Some((from, to)), Some(now)) = (self.repeated, timeline.now) else { return };
        // A part that is chosen while the clock stands is repeated when it runs.
        if !(is_running || was_running) {
            return;
        }
        // A user who goes elsewhere stays there.
        let was_inside = self.last.replace(now).is_some_and(|last| (from..to).contains(&last));
        if now < to || !was_inside {
            return;
        }
        self.seek(context, from);
        if !is_running {
            context.act(Action::Control(ControlRequest::new(ControlKind::Resume)));
        }
    }
}

/// Returns a time, and what happened near it.
pub(super) fn describe(timeline: &Timeline<'_>, rect: Rect, time: u64) -> String {
    let near =
        (timeline.end.saturating_sub(timeline.start) as f32 / rect.width().max(1.0) * 3.0) as u64;
    let mut text = clock_text(time as f64 * 1e-9);
    for (kind, name) in KINDS {
        let marks = timeline.marks.iter().filter(|mark| mark.kind() == Some(kind));
        let near: Vec<&RecordingMark> =
            marks.filter(|mark| mark.time_nanos.abs_diff(time) <= near).collect();
        let count = thousands(near.iter().map(|mark| u64::from(mark.count)).sum());
        match near.first() {
            Some(_) if kind == MarkKind::Note => text += &format!("\n{count} × {name}"),
            Some(first) => text += &format!("\n{count} × {name}, robot {}", first.robot),
            None => {}
        }
    }
    text
}

/// The least distance of a text from the playhead, in points.
const PLAYHEAD_GAP: f32 = 6.0;

/// Paints the timeline at a time.
pub(super) fn paint(
    panel: &TimelinePanel,
    painter: &Painter,
    rect: Rect,
    timeline: &Timeline<'_>,
    now: u64,
    colours: &ThemeColours,
) {
    let x = |time: u64| rect.left() + timeline.part(time) * rect.width();
    let lanes = LANE * KINDS.len() as f32;
    let bar = Rect::from_min_max(
        pos2(rect.left(), rect.top() + lanes + 2.0),
        pos2(rect.right(), rect.bottom() - 2.0),
    );
    painter.rect_filled(bar, 3.0, colours.field);
    painter.rect_filled(bar.with_max_x(x(now)), 3.0, colours.accent.gamma_multiply(0.55));
    if let Some((from, to)) = panel.repeated {
        let part = Rect::from_min_max(pos2(x(from), rect.top()), pos2(x(to), rect.bottom()));
        painter.rect_filled(part, 2.0, colours.accent.gamma_multiply(0.16));
        for end in [from, to] {
            painter.vline(x(end), rect.y_range(), (1.5, colours.accent));
        }
    }
    if let Some(start) = panel.loop_start {
        painter.vline(x(start), rect.y_range(), (1.5, colours.accent));
    }
    for (lane, (kind, _)) in KINDS.into_iter().enumerate() {
        let top = rect.top() + lane as f32 * LANE;
        paint_marks(painter, timeline, kind, (top, &x), colours);
    }
    painter.vline(x(now), rect.y_range(), (2.0, colours.text));
    painter.circle_filled(Pos2::new(x(now), bar.center().y), 5.0, colours.text);
    if timeline.live.is_none() && timeline.marks.is_empty() && timeline.searched >= timeline.end {
        let font = FontId::proportional(10.0);
        let text = "no contacts, faults, stops or notes".to_owned();
        let text = painter.layout_no_wrap(text, font, colours.faint);
        let at = pos2(beside_playhead(rect, x(now), text.size().x), rect.top());
        painter.galley(at, text, colours.faint);
    }
}

/// Returns where a text of a width begins, so that the playhead doesn't run through it.
fn beside_playhead(rect: Rect, playhead: f32, width: f32) -> f32 {
    let is_clear = playhead < rect.left() || playhead > rect.left() + width + PLAYHEAD_GAP;
    let right = playhead + PLAYHEAD_GAP;
    match is_clear || right + width > rect.right() {
        true => rect.left(),
        false => right,
    }
}

/// Paints the marks of a kind, one for each point of the bar.
fn paint_marks(
    painter: &Painter,
    timeline: &Timeline<'_>,
    kind: MarkKind,
    (top, x): (f32, &dyn Fn(u64) -> f32),
    colours: &ThemeColours,
) {
    let mut last = f32::NEG_INFINITY;
    for mark in timeline.marks.iter().filter(|mark| mark.kind() == Some(kind)) {
        let at = x(mark.time_nanos).round();
        if at - last >= 1.0 {
            last = at;
            let size = vec2(if kind == MarkKind::Note { 4.0 } else { 2.0 }, LANE - 0.5);
            painter.rect_filled(
                Rect::from_min_size(pos2(at - size.x / 2.0, top), size),
                0.5,
                colour_of(kind, colours),
            );
        }
    }
}

/// The colour of marks of a kind.
pub(crate) fn colour_of(kind: MarkKind, colours: &ThemeColours) -> egui::Color32 {
    match kind {
        MarkKind::Contact => colours.bad,
        MarkKind::Fault => colours.warn,
        MarkKind::Stop => colours.accent,
        MarkKind::Note => colours.good,
    }
}
