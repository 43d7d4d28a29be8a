//! Constructs the curve of an edge from its nodes and handle lengths (equations 3.1 to 3.7).

use regatta_base::bezier::CubicBezier;

use super::angle::unit;
use super::route_graph::Node;

/// The convention that assigns the handle lengths to the ends of a `Spline` edge.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, strum::IntoStaticStr, strum::VariantArray,
)]
#[strum(serialize_all = "snake_case")]
pub enum Handles {
    /// `ParamB` at the origin, `ParamF` at the destination: equations 3.2 to 3.5. The default.
    #[default]
    BAtOrigin,
    /// `ParamF` at the origin, `ParamB` at the destination, as some navigation stacks write it.
    FAtOrigin,
}

/// The handle lengths of a `Spline` edge in metres, named as in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandleLengths {
    /// `ParamF`.
    pub forward: f64,
    /// `ParamB`.
    pub backward: f64,
}

impl Handles {
    /// Returns the other convention.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::BAtOrigin => Self::FAtOrigin,
            Self::FAtOrigin => Self::BAtOrigin,
        }
    }
}

regatta_base::named!(Handles, "a handle convention");

/// Returns the `Spline` curve between two nodes, which leaves the origin and reaches the
/// destination along their headings (equations 3.2 to 3.5).
pub fn spline(
    origin: &Node,
    destination: &Node,
    lengths: HandleLengths,
    handles: Handles,
) -> CubicBezier {
    let (at_origin, at_destination) = match handles {
        Handles::BAtOrigin => (lengths.backward, lengths.forward),
        Handles::FAtOrigin => (lengths.forward, lengths.backward),
    };
    let p1 = origin.position + unit(origin.theta) * at_origin;
    // The minus sign is the rotation of θ3' by π (equation 3.1).
    let p2 = destination.position - unit(destination.theta) * at_destination;
    CubicBezier { control_points: [origin.position, p1, p2, destination.position] }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use glam::DVec2;

    use super::*;

    fn node(x: f64, y: f64, theta: f64) -> Node {
        Node::new(1, DVec2::new(x, y), theta)
    }

    #[test]
    fn control_points_follow_the_equations() {
        let lengths = HandleLengths { forward: 2.0, backward: 3.0 };
        let [p0, p1, p2, p3] =
            spline(&node(1.0, 1.0, 0.0), &node(9.0, 6.0, FRAC_PI_2), lengths, Handles::BAtOrigin)
                .control_points;
        assert_eq!((p0, p3), (DVec2::new(1.0, 1.0), DVec2::new(9.0, 6.0)));
        assert!(p1.distance(DVec2::new(4.0, 1.0)) < 1e-12, "{p1}");
        assert!(p2.distance(DVec2::new(9.0, 4.0)) < 1e-12, "{p2}");
    }

    #[test]
    fn the_other_convention_swaps_the_handles() {
        let (from, to) = (node(0.0, 0.0, 0.3), node(5.0, 5.0, 2.0));
        let lengths = HandleLengths { forward: 2.0, backward: 3.0 };
        let swapped = HandleLengths { forward: 3.0, backward: 2.0 };
        assert_eq!(
            spline(&from, &to, lengths, Handles::FAtOrigin),
            spline(&from, &to, swapped, Handles::BAtOrigin)
        );
    }
}
