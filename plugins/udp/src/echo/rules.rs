//! What counts as the same pose.

use core::time::Duration;

use super::Sent;
use crate::line::{AngleUnit, LineFormat, PoseLine};

/// How answers are judged.
#[derive(Clone, Copy, Debug)]
pub struct EchoRules {
    /// An answer may differ by so many metres, besides the rounding of an `f32`.
    pub tolerance: f64,
    /// The same for theta, in `unit`.
    pub theta_tolerance: f64,
    /// The unit of theta in sent lines and answers.
    pub unit: AngleUnit,
    /// What the visualiser adds to x and y, in metres.
    pub offset: [f64; 2],
    /// How long an answer may take.
    pub deadline: Duration,
}

impl EchoRules {
    /// The rules for lines of that form, answered with so many decimals: one unit of the last decimal is allowed.
    pub fn new(format: LineFormat, decimals: usize, unit: AngleUnit, offset: [f64; 2], deadline: Duration) -> Self {
        let last_decimal = |sent: usize| 10_f64.powi(-(sent.min(decimals) as i32));
        let (tolerance, theta_tolerance) = (last_decimal(format.decimals), last_decimal(format.theta_decimals));
        Self { tolerance, theta_tolerance, unit, offset, deadline }
    }

    /// Whether an answer has the pose that was sent.
    pub(super) fn matches(&self, sent: &Sent, answer: &PoseLine) -> bool {
        let near = |sent: f32, answer: f32, offset: f64| {
            let rounding = f64::from(answer.abs().max(sent.abs())) * 2.0 * f64::from(f32::EPSILON);
            (f64::from(answer) - offset - f64::from(sent)).abs() <= self.tolerance * 1.001 + rounding
        };
        let turned = (f64::from(answer.theta) - f64::from(sent.theta)).rem_euclid(self.unit.turn());
        let turned = turned.min(self.unit.turn() - turned);
        let rounding = f64::from(answer.theta.abs()) * 2.0 * f64::from(f32::EPSILON);
        near(sent.x, answer.x, self.offset[0])
            && near(sent.y, answer.y, self.offset[1])
            && turned <= self.theta_tolerance * 1.001 + rounding
    }
}
