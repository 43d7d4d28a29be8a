//! The terms of a directed graph that robots drive on: indices of nodes and edges, legs, and turns
//! between legs. The layout, which holds nodes and edges, and the motion kernel, which holds none
//! of them, share these.

/// The index of a node among the nodes of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeIndex(pub u32);

/// The index of an edge among the edges of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EdgeIndex(pub u32);

/// The direction of travel along an edge, which also determines the way the robot faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Gear {
    /// From origin to destination, facing in the direction of travel.
    Forward,
    /// From destination to origin with the heading of the edge: facing against the direction of
    /// travel.
    Reverse,
}

/// An edge driven in one gear: an element of a route. Files write it as the edge's id, `-ID` in
/// reverse gear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Leg {
    /// The edge.
    pub edge: EdgeIndex,
    /// The gear.
    pub gear: Gear,
}

/// A value at each end of an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ends<T> {
    /// The value at the origin.
    pub origin: T,
    /// The value at the destination.
    pub destination: T,
}

impl<T> Ends<T> {
    /// Returns the value where the edge is entered in a gear.
    pub fn start(self, gear: Gear) -> T {
        if gear == Gear::Forward { self.origin } else { self.destination }
    }

    /// Returns the value where the edge is left in a gear.
    pub fn end(self, gear: Gear) -> T {
        if gear == Gear::Forward { self.destination } else { self.origin }
    }
}

/// The largest difference in radians between the headings of consecutive legs that robots drive
/// through without a turn: 5°.
pub const SMOOTH_TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// The speed in metres per second below which a leg is no way: a centimetre a second. Files have
/// such speeds for gears that robots don't use.
pub const CRAWL: f64 = 0.01;

/// The way in which robots turn on the spot at an end of an edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Rotation {
    /// The shorter way.
    #[default]
    Shorter,
    /// To the left.
    #[strum(serialize = "ccw")]
    CounterClockwise,
    /// To the right.
    #[strum(serialize = "cw")]
    Clockwise,
    /// They don't turn: the heading jumps.
    None,
}

impl Rotation {
    /// Returns the way at a node where two edges meet. Where they contradict each other, it is the
    /// shorter one.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::None, _) | (_, Self::None) => Self::None,
            (Self::Shorter, way) | (way, Self::Shorter) => way,
            (one, other) if one == other => one,
            _ => Self::Shorter,
        }
    }
}

crate::named!(Rotation, "a rotation");
