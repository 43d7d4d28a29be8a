//! The measuring tool: the distance between two places or robots, and the clearance between the
//! robots' outlines.

use egui::{Align2, Color32, FontId, LayerId, Stroke};
use glam::Vec2;
use regatta_plugin::frame::RobotState;

use super::context::PanelContext;
use super::levels::PictureArea;
use super::view_model::ViewModel;
use crate::footprint::Footprint;

/// One end of a measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// A robot, wherever it drives.
    Robot(u32),
    /// A place on the ground, in metres.
    Place(Vec2),
}

/// The ends of a measurement: up to two.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measuring(pub Vec<End>);

/// The result of measuring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// Metres from one end to the other; of robots, from their poses.
    pub distance: f32,
    /// Metres between the outlines of robots, or between an outline and a place; `None` between two
    /// places.
    pub clearance: Option<f32>,
    /// The direction from the first end to the second one, in radians counter-clockwise from east.
    pub bearing: f32,
    /// The ends of the distance.
    pub ends: [Vec2; 2],
    /// The ends of the clearance.
    pub nearest: [Vec2; 2],
}

impl Measuring {
    /// Adds an end. A third end starts a new measurement.
    pub fn add(&mut self, end: End) {
        if self.0.len() >= 2 {
            self.0.clear();
        }
        self.0.push(end);
    }

    /// Returns the result; `None` if an end is missing, or is a robot that is not in the fleet.
    pub fn measure(&self, model: &ViewModel<'_>, offset: Vec2) -> Option<Measurement> {
        let [a, b] = self.0[..] else { return None };
        let ([from, to], [one, other]) = (
            [a.place(model, offset)?, b.place(model, offset)?],
            [a.outline(model, offset)?, b.outline(model, offset)?],
        );
        let has_outline = [a, b].iter().any(|end| matches!(end, End::Robot(_)));
        let (clearance, nearest) = one.clearance(other);
        let bearing = (to - from).to_angle();
        let clearance = has_outline.then_some(clearance);
        Some(Measurement {
            distance: from.distance(to),
            clearance,
            bearing,
            ends: [from, to],
            nearest,
        })
    }
}

impl End {
    fn place(self, model: &ViewModel<'_>, offset: Vec2) -> Option<Vec2> {
        match self {
            Self::Place(place) => Some(place),
            Self::Robot(id) => {
                let is_here = model.frame?.state_of(id as usize) != RobotState::Absent;
                model.pose(id, offset).filter(|_| is_here).map(|pose| pose.place)
            }
        }
    }

    fn outline(self, model: &ViewModel<'_>, offset: Vec2) -> Option<Footprint> {
        let Self::Robot(id) = self else {
            return Some(Footprint::Circle { centre: self.place(model, offset)?, radius: 0.0 });
        };
        let pose = model.pose(id, offset)?;
        let index = model
            .robot_type_column
            .and_then(|column| column.get(id as usize))
            .map_or(0, |index| *index as usize);
        let robot_type = model.world.robot_types().get(index)?;
        Some(Footprint::of(robot_type, pose.place, pose.theta))
    }

    fn name(self) -> String {
        match self {
            Self::Robot(id) => format!("robot {id}"),
            Self::Place(place) => format!("{:.2}, {:.2} m", place.x, place.y),
        }
    }
}

impl Measuring {
    /// Returns the text of the measurement: what to do next, or the result.
    pub(super) fn text(&self, context: &PanelContext<'_>) -> Vec<String> {
        let Some(result) = self.measure(context.model, context.offset) else {
            return match self.0.first() {
                None => vec!["measure: click a robot or a place".to_owned()],
                Some(first) => vec![format!("from {}: click the other end", first.name())],
            };
        };
        let names = [self.0[0], self.0[1]].map(End::name);
        let mut lines = vec![format!("{} to {}", names[0], names[1])];
        let [along, up] = (result.ends[1] - result.ends[0]).to_array();
        lines.push(format!(
            "distance {:.3} m, {:.1}°",
            result.distance,
            result.bearing.to_degrees()
        ));
        lines.push(format!("east {along:.3} m, north {up:.3} m"));
        lines.extend(result.clearance.map(|metres| match metres {
            0.0 => "clearance 0 m: the outlines overlap".to_owned(),
            metres => format!("clearance {metres:.3} m"),
        }));
        lines
    }

    /// Draws the measured line over the picture.
    pub(super) fn draw(&self, context: &PanelContext<'_>, ctx: &egui::Context, area: PictureArea) {
        let (model, offset, colours) = (context.model, context.offset, context.colours);
        let at = |place: Vec2| area.place(&context.camera, place.extend(0.0));
        let painter = ctx.layer_painter(LayerId::background()).with_clip_rect(area.visible);
        for place in self.0.iter().filter_map(|end| end.place(model, offset)) {
            if let Some(at) = at(place) {
                painter.circle_filled(at, 4.5, Color32::BLACK);
                painter.circle_filled(at, 3.0, colours.accent);
            }
        }
        let Some(result) = self.measure(model, offset) else { return };
        let mut lines = vec![(result.ends, Stroke::new(1.0, colours.accent))];
        if result.clearance.is_some() {
            lines.push((result.nearest, Stroke::new(2.5, colours.text)));
        }
        for ([from, to], stroke) in lines {
            if let (Some(from), Some(to)) = (at(from), at(to)) {
                let border = Stroke::new(stroke.width + 2.0, Color32::from_black_alpha(160));
                painter.line_segment([from, to], border);
                painter.line_segment([from, to], stroke);
            }
        }
        let shown = result.clearance.unwrap_or(result.distance);
        let ends = if result.clearance.is_some() { result.nearest } else { result.ends };
        if let Some(middle) = at((ends[0] + ends[1]) / 2.0) {
            let text = painter.layout_no_wrap(
                format!("{shown:.2} m"),
                FontId::monospace(12.0),
                colours.text,
            );
            let place =
                Align2::CENTER_BOTTOM.anchor_size(middle - egui::vec2(0.0, 6.0), text.size());
            painter.rect_filled(place.expand2(egui::vec2(4.0, 2.0)), 4.0, colours.panel);
            painter.galley(place.min, text, colours.text);
        }
    }
}
