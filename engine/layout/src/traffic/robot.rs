//! The robots that a certificate is about.

use std::f64::consts::FRAC_PI_4;

use regatta_base::sweep::Footprint;
use serde::Serialize;

use crate::ReadOptions;
use crate::model::route_graph::RouteGraph;

/// The smallest and the largest side of a robot, in metres.
const SIDES: std::ops::RangeInclusive<f64> = 0.001..=100.0;

/// Whether robots turn on the spot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Turning {
    /// They do, at nodes where the heading changes by more than 5°, and need the circle around
    /// them.
    OnTheSpot,
    /// They don't: they need no room beside that of their ways.
    Never,
}

/// The outline of robots, about their poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outline {
    /// A rectangle.
    Rectangle,
    /// A circle, whose diameter is both the length and the width.
    Circle,
}

/// A type of robots.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RobotType {
    #[serde(rename = "shape")]
    outline: Outline,
    length: f64,
    width: f64,
    turning: Turning,
}

/// The error of making a [`RobotType`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a robot of {length} m × {width} m: its length and its width must be {} to {} m",
    SIDES.start(),
    SIDES.end()
)]
pub struct RobotTypeError {
    length: f64,
    width: f64,
}

/// The sides of the default type, in metres.
const DEFAULT_LENGTH: f64 = 0.9;
const DEFAULT_WIDTH: f64 = 0.6;
/// The side of the largest square robot that turns in a cell without leaving it, with some room, as
/// a part of the cell's length.
const PART_OF_CELL: f64 = 0.6;

impl Default for RobotType {
    /// 0.9 m × 0.6 m, turning on the spot.
    fn default() -> Self {
        let (length, width) = (DEFAULT_LENGTH, DEFAULT_WIDTH);
        Self { outline: Outline::Rectangle, length, width, turning: Turning::OnTheSpot }
    }
}

impl RobotType {
    /// Makes a type of rectangles of a length along and a width across the heading, in metres.
    ///
    /// # Errors
    /// [`RobotTypeError`] if a side is no number from 0.001 to 100.
    pub fn new(length: f64, width: f64, turning: Turning) -> Result<Self, RobotTypeError> {
        match SIDES.contains(&length) && SIDES.contains(&width) {
            true => Ok(Self { outline: Outline::Rectangle, length, width, turning }),
            false => Err(RobotTypeError { length, width }),
        }
    }

    /// Makes a type of circles of a diameter in metres.
    ///
    /// # Errors
    /// [`RobotTypeError`] if the diameter is no number from 0.001 to 100.
    pub fn round(diameter: f64, turning: Turning) -> Result<Self, RobotTypeError> {
        Ok(Self { outline: Outline::Circle, ..Self::new(diameter, diameter, turning)? })
    }

    /// The same type with another way of turning.
    #[must_use]
    pub fn with_turning(self, turning: Turning) -> Self {
        Self { turning, ..self }
    }

    /// Returns the type of a layout's robots if nobody gives one: the default type; as wide as a
    /// roadmap was made for, if the layout is one, and small enough to turn in a cell, if it is a
    /// grid of cells. `options` are those with which the layout was read.
    pub fn of_layout(graph: &RouteGraph, options: &ReadOptions) -> Self {
        let width = options.skeleton.map_or(DEFAULT_WIDTH, |width| f64::from(width.0) / 1000.0);
        let length = width * DEFAULT_LENGTH / DEFAULT_WIDTH;
        let most = cell_length(graph).map_or(f64::INFINITY, |length| PART_OF_CELL * length);
        let [length, width] = [length, width]
            .map(|side| micrometres(side.min(most).clamp(*SIDES.start(), *SIDES.end())));
        Self { length, width, ..Self::default() }
    }

    /// The outline.
    pub fn outline(&self) -> Outline {
        self.outline
    }

    /// Square metres that it covers.
    pub fn area(&self) -> f64 {
        let around = self.length * self.width;
        match self.outline {
            Outline::Rectangle => around,
            Outline::Circle => FRAC_PI_4 * around,
        }
    }

    /// The diameter of the circle around it, in metres.
    pub fn diameter(&self) -> f64 {
        match self.outline {
            Outline::Rectangle => self.length.hypot(self.width),
            Outline::Circle => self.length,
        }
    }

    /// Robots of the type in words: `robots of 0.9 m × 0.6 m`, `round robots of 0.9 m`.
    pub fn in_words(&self) -> String {
        match self.outline {
            Outline::Rectangle => format!("robots of {} m × {} m", self.length, self.width),
            Outline::Circle => format!("round robots of {} m", self.length),
        }
    }

    /// Metres along the heading.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Metres across the heading.
    pub fn width(&self) -> f64 {
        self.width
    }

    /// Whether it turns on the spot.
    pub fn turning(&self) -> Turning {
        self.turning
    }

    pub(super) fn footprint(&self) -> Footprint {
        match self.outline {
            Outline::Rectangle => Footprint::rectangle(self.length as f32, self.width as f32),
            Outline::Circle => Footprint::circle(self.length as f32),
        }
    }
}

/// Rounds metres to micrometres.
fn micrometres(metres: f64) -> f64 {
    (metres * 1e6).round() / 1e6
}

/// Returns the length of a cell in metres if the layout is a grid of cells: all edges are equally
/// long, and lead along an axis.
fn cell_length(graph: &RouteGraph) -> Option<f64> {
    let mut length = None;
    for edge in graph.edges() {
        let along = graph.node(edge.destination).position - graph.node(edge.origin).position;
        let metres = along.abs().max_element();
        let is_same = length.is_none_or(|length: f64| (length - metres).abs() < 1e-6);
        if along.abs().min_element() > 1e-6 || !is_same {
            return None;
        }
        length = Some(metres);
    }
    length
}
