//! The rules for comparing answers with sent lines.

use core::time::Duration;

use super::sent::SentLine;
use crate::line::{AngleUnit, LineFormat, PoseLine};

/// The rules of an [`EchoCheck`](super::EchoCheck).
#[derive(Clone, Copy, Debug)]
pub struct EchoRules {
    /// The largest accepted difference of x and y in metres, in addition to the rounding of an
    /// `f32`.
    pub tolerance: f64,
    /// The largest accepted difference of theta in `unit`, in addition to the rounding of an `f32`.
    pub theta_tolerance: f64,
    /// The unit of theta in sent lines and answers.
    pub unit: AngleUnit,
    /// The offset that the visualiser adds to x and y, in metres.
    pub offset: [f64; 2],
    /// The time within which a line has to be answered.
    pub deadline: Duration,
}

impl EchoRules {
    /// Creates the rules for sent lines with `format` and answers with `decimals` decimals. The
    /// tolerances are one unit of the last decimal that both have.
    pub fn new(
        format: LineFormat,
        decimals: usize,
        unit: AngleUnit,
        offset: [f64; 2],
        deadline: Duration,
    ) -> Self {
        let last_decimal = |sent: usize| 10_f64.powi(-(sent.min(decimals) as i32));
        let (tolerance, theta_tolerance) =
            (last_decimal(format.decimals), last_decimal(format.theta_decimals));
        Self { tolerance, theta_tolerance, unit, offset, deadline }
    }

    /// Whether an answer has the pose of a sent line.
    pub(super) fn matches(&self, sent: &SentLine, answer: &PoseLine) -> bool {
        let near = |sent: f32, answer: f32, offset: f64| {
            let rounding = f64::from(answer.abs().max(sent.abs())) * 2.0 * f64::from(f32::EPSILON);
            (f64::from(answer) - offset - f64::from(sent)).abs()
                <= self.tolerance * 1.001 + rounding
        };
        let turn = (f64::from(answer.theta) - f64::from(sent.theta)).rem_euclid(self.unit.turn());
        let turn = turn.min(self.unit.turn() - turn);
        let rounding = f64::from(answer.theta.abs()) * 2.0 * f64::from(f32::EPSILON);
        near(sent.x, answer.x, self.offset[0])
            && near(sent.y, answer.y, self.offset[1])
            && turn <= self.theta_tolerance * 1.001 + rounding
    }
}
