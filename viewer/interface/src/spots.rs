//! The hot spots panel: places where robots lose time, the worst first; a click flies there and
//! marks the place.

use egui::{Align2, Color32, FontId, LayerId, Painter, Rect, Stroke, Ui, pos2, vec2};
use glam::Vec2;
use regatta_scene::names::edge_name;

use super::context::{PanelContext, Request};
use super::levels::PictureArea;
use super::style::{self, ThemeColours};
use super::view_model::{Action, Item, ViewModel};
use super::virtual_list::{VirtualList, clickable};
use crate::jams::{Known, Spot, Trend, csv};
use crate::text::{thousands, with_plural};

/// The radius of the mark in metres, and its least one in points.
const MARK: (f32, f32) = (5.0, 14.0);

/// The longest time between two publications of a plugin that runs, in seconds.
const MUST_HAVE_COME: f64 = 10.0;
/// A history that begins within so many simulated seconds of a run is that of the whole run.
const FROM_START: f64 = 2.0;

/// The hot spots panel.
#[derive(Debug)]
pub(super) struct SpotsPanel {
    pub list: VirtualList,
    /// The file that hot spots are written to, as typed.
    file: String,
    /// The place of a hot spot that is marked, in metres.
    marked: Option<Vec2>,
}

impl Default for SpotsPanel {
    fn default() -> Self {
        Self { list: VirtualList::default(), file: "hot-spots.csv".to_owned(), marked: None }
    }
}

impl SpotsPanel {
    /// Removes the mark. Returns whether there was one.
    pub fn unmark(&mut self) -> bool {
        self.marked.take().is_some()
    }

    /// Shows the panel.
    pub fn show(&mut self, context: &PanelContext<'_>, ui: &mut Ui) {
        let colours = context.colours;
        let spots = &context.model.jams.spots;
        let total: f64 = spots.iter().map(Spot::lost_secs).sum();
        let lost = with_plural(total.round() as u64, "robot-second");
        ui.label(egui::RichText::new(format!("{lost} lost")).size(20.0));
        ui.label(style::faint(ui, "by contacts and by robots that stand and can't drive on"));
        ui.label(style::faint(ui, known_text(context.model)))
            .on_hover_text(known_hint(context.model));
        ui.horizontal(|ui| {
            let path = &mut self.file;
            ui.add(egui::TextEdit::singleline(path).desired_width(150.0)).widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::TextInput, true, "file of hot spots")
            });
            if ui
                .button("export")
                .on_hover_text("Write all hot spots to this file, as CSV")
                .clicked()
            {
                let id =
                    |edge: u32| context.model.world.edges().get(edge as usize).map(|edge| edge.id);
                context.act(Action::Write { path: path.clone().into(), text: csv(spots, &id) });
            }
            if style::copy_button(ui, "all hot spots as a table").clicked() {
                let id =
                    |edge: u32| context.model.world.edges().get(edge as usize).map(|edge| edge.id);
                ui.ctx().copy_text(csv(spots, &id));
                context.notify(format!("{} copied", with_plural(spots.len() as u64, "hot spot")));
            }
        });
        if spots.is_empty() {
            ui.label(style::faint(ui, "no robot has lost time"));
            return;
        }
        header(ui, &colours);
        let (marked, mut clicked) = (self.marked, None);
        self.list.show(ui, "hot spots", &colours, spots.len(), |ui, rect, row| {
            let spot = &spots[row];
            let is_marked = marked == Some(spot.place);
            let response = clickable(ui, rect, row as u32, is_marked, &colours, || {
                format!("hot spot {}", row + 1)
            });
            cells(ui.painter(), rect, (spot, context.model), &colours);
            if response.on_hover_text(details(spot)).clicked() {
                clicked = Some(spot.clone());
            }
        });
        if let Some(spot) = clicked {
            self.marked = Some(spot.place);
            context.ask(Request::FlyTo(spot.place + context.offset));
            let edge = spot.edges.first().map(|edge| Item::Edge(*edge));
            context.ask(Request::SelectQuietly(edge));
        }
    }

    /// Draws a ring around the marked place.
    pub fn draw_mark(&self, context: &PanelContext<'_>, ctx: &egui::Context, area: PictureArea) {
        let Some(place) = self.marked else { return };
        let (camera, size) = (context.camera, area.size());
        let place = (place + context.offset).extend(0.0);
        let Some(at) = camera.project(place, size) else { return };
        let points_per_metre =
            camera.pixels_per_radian(size.y) / place.distance(camera.eye()).max(1.0);
        let radius = (MARK.0 * points_per_metre).max(MARK.1);
        let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(area.visible);
        let centre = area.picture.min + vec2(at.x, at.y);
        painter.circle_stroke(centre, radius, Stroke::new(4.5, Color32::from_black_alpha(150)));
        painter.circle_stroke(centre, radius, Stroke::new(2.0, context.colours.accent));
    }
}

/// Right edges of the columns, as fractions of the width; the last one begins at its own. Rows have
/// no numbers: those of the heat map's labels are ranks by another figure.
const COLUMNS: [f32; 3] = [0.28, 0.47, 0.52];

fn header(ui: &mut Ui, colours: &ThemeColours) {
    let (rect, _) =
        ui.allocate_exact_size(egui::vec2(ui.available_width() - 10.0, 15.0), egui::Sense::hover());
    for (right, name) in COLUMNS.into_iter().zip(["lost s", "since"]) {
        write(ui.painter(), rect, (right, Align2::RIGHT_CENTER), name.to_owned(), colours.faint);
    }
    write(ui.painter(), rect, (COLUMNS[2], Align2::LEFT_CENTER), "edges".to_owned(), colours.faint);
}

fn write(
    painter: &Painter,
    rect: Rect,
    (place, align): (f32, Align2),
    text: String,
    colour: Color32,
) {
    painter.text(
        pos2(rect.left() + rect.width() * place, rect.center().y),
        align,
        text,
        FontId::monospace(12.0),
        colour,
    );
}

fn cells(
    painter: &Painter,
    rect: Rect,
    (spot, model): (&Spot, &ViewModel<'_>),
    colours: &ThemeColours,
) {
    let right = Align2::RIGHT_CENTER;
    let lost = if spot.contact_secs > 0.0 { colours.bad } else { colours.text };
    write(painter, rect, (COLUMNS[0], right), thousands(spot.lost_secs().round() as u64), lost);
    write(painter, rect, (COLUMNS[1], right), clock(spot.seen[0]), colours.faint);
    let edges = spot.edges.iter().filter_map(|edge| model.world.edges().get(*edge as usize));
    let names: Vec<_> = edges.map(|edge| edge_name(&model.world, edge)).take(2).collect();
    write(painter, rect, (COLUMNS[2], Align2::LEFT_CENTER), names.join(" "), colours.text);
    trend(painter, pos2(rect.right() - 10.0, rect.center().y), spot.trend, colours);
}

/// Draws a sign for a trend: a triangle up or down, a bar, or nothing.
fn trend(painter: &Painter, at: egui::Pos2, trend: Trend, colours: &ThemeColours) {
    let (left, right) = (at - vec2(4.5, 0.0), at + vec2(4.5, 0.0));
    let (tip, colour) = match trend {
        Trend::Growing => (4.0, colours.bad),
        Trend::Easing => (-4.0, colours.good),
        Trend::Steady => {
            painter.line_segment([left, right], Stroke::new(2.0, colours.warn));
            return;
        }
        Trend::Over => return,
    };
    let tip = vec2(0.0, tip);
    let points = vec![left + tip, right + tip, at - tip];
    painter.add(egui::Shape::convex_polygon(points, colour, Stroke::NONE));
}

fn details(spot: &Spot) -> String {
    format!(
        "{:.0} s in contact, {:.0} s standing; from {} to {}; {}",
        spot.contact_secs,
        spot.standing_secs,
        clock(spot.seen[0]),
        clock(spot.seen[1]),
        spot.trend.name()
    )
}

/// Returns the part of the run that the hot spots and the figures over time are about, as a text.
pub(super) fn known_text(model: &ViewModel<'_>) -> String {
    let Known { from_secs, until_secs, is_published } = model.jams.known;
    let (from, until) = (clock(from_secs), clock(until_secs.round()));
    let is_old = is_published
        && model.clock_secs().is_some_and(|now| now > until_secs + MUST_HAVE_COME * speed(model));
    match (model.recording().is_some(), is_published) {
        (true, true) => format!("of the recording, {from} to {until}"),
        (true, false) => format!("of what was replayed since {from}"),
        (false, true) if is_old => {
            format!("from {from} to {until}, when regatta plugin traffic ended")
        }
        (false, _) if from_secs < FROM_START => "since the start of the run".to_owned(),
        (false, true) => format!("since {from}, when regatta plugin traffic began"),
        (false, false) => format!("since {from}, when this window began to watch"),
    }
}

/// The measured speed, in simulated seconds per second; at least 1.
fn speed(model: &ViewModel<'_>) -> f64 {
    model.status.map_or(1.0, |status| f64::from(status.real_time_factor)).max(1.0)
}

/// Returns a hint about the source of the history.
pub(super) fn known_hint(model: &ViewModel<'_>) -> &'static str {
    match model.recording() {
        Some(_) => {
            "a replay reads all of its recording in the background, and publishes what it has \
             read so far"
        }
        None => {
            "regatta plugin traffic keeps all that it has seen of the run, for windows that open \
             later"
        }
    }
}

/// Formats a simulated time as hours, minutes and seconds.
pub(super) fn clock(secs: f64) -> String {
    let secs = secs.max(0.0) as u64;
    let (hours, minutes, seconds) = (secs / 3600, secs / 60 % 60, secs % 60);
    if hours > 0 {
        format!("{hours}:{minutes:02}:{seconds:02}")
    } else {
        format!("{minutes}:{seconds:02}")
    }
}
