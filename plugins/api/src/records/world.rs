//! The world: the route graph and the robot types, published once per change on `regatta/F/world`.
//!
//! A sample is a block of lines with sixteen sections: nodes, edges, curves, robot types, texts,
//! zones, their members, other names of nodes, doors, lifts, levels of lifts, the members of
//! facilities, stations, their nodes, lines of the background, and their points. Each section
//! starts on a whole line. Readers get them as a [`World`]; producers fill in a [`WorldData`].

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

use super::sequence::Sequenced;
use super::{padded, text};
pub use background::{BackgroundLineRecord, MAX_BACKGROUND_POINTS};
pub use data::WorldData;
pub use facilities::{DoorRecord, LiftLevelRecord, LiftRecord};
pub use levels::{Level, Levels};
pub use stations::StationRecord;
pub use texts::Texts;
pub use view::World;
pub use zones::{ZoneRecord, ZoneRule};

mod background;
mod bytes;
mod data;
mod facilities;
mod levels;
mod stations;
mod texts;
mod view;
mod zones;

/// The iceoryx2 user header of `regatta/F/world`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_WorldHeader"))]
pub struct WorldHeader {
    /// The run that this world belongs to.
    pub run_id: u64,
    /// Counts the worlds of a run, from 1.
    pub revision: u64,
    /// Metres east and north of (0, 0) of the fleet's positions, on the map of the route graph's
    /// file: a position on that map is `origin` + position. Double precision, because such maps may
    /// have coordinates of millions of metres.
    pub origin: [f64; 2],
    /// Number of [`NodeRecord`]s.
    pub nodes: u32,
    /// Number of [`EdgeRecord`]s.
    pub edges: u32,
    /// Number of [`CurveRecord`]s.
    pub curves: u32,
    /// Number of [`RobotTypeRecord`]s.
    pub robot_types: u32,
    /// Length of the [`Texts`] in bytes.
    pub text_bytes: u32,
    /// Number of [`ZoneRecord`]s.
    pub zones: u32,
    /// Number of the members of all zones.
    pub zone_members: u32,
    /// Number of [`OtherNameRecord`]s.
    pub other_names: u32,
    /// Number of [`DoorRecord`]s.
    pub doors: u32,
    /// Number of [`LiftRecord`]s.
    pub lifts: u32,
    /// Number of [`LiftLevelRecord`]s.
    pub lift_levels: u32,
    /// Number of the members of all doors and lifts.
    pub facility_members: u32,
    /// Number of [`StationRecord`]s.
    pub stations: u32,
    /// Number of the nodes of all stations.
    pub station_nodes: u32,
    /// Number of [`BackgroundLineRecord`]s.
    pub background_lines: u32,
    /// Number of the points of all lines of the background.
    pub background_points: u32,
}

/// Another name of a node: that of a station there, or of a node at the same place that the layout
/// was read without.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_OtherNameRecord"))]
pub struct OtherNameRecord {
    /// Offset of the name in the [`Texts`].
    pub name: u32,
    /// Index of the node.
    pub node: u32,
}

/// A node of the route graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_NodeRecord"))]
pub struct NodeRecord {
    /// Id in the route graph's file.
    pub id: u32,
    /// Metres east of the world's origin.
    pub x: f32,
    /// Metres north of the world's origin.
    pub y: f32,
    /// Radians in (-π, π].
    pub theta: f32,
    /// Offset of the name in the [`Texts`]; 0 for none.
    pub name: u32,
    /// Offset of the name of its level (floor) in the [`Texts`]; 0 for none.
    pub level: u32,
    /// Offset of the name of its zone in the [`Texts`]; 0 for none.
    pub zone: u32,
    /// A [`Role`].
    pub role: u32,
}

numbered! {
    /// The purpose of a node.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
    pub enum Role: u32 {
        /// Nothing in particular.
        #[default]
        None = 0,
        /// Pick a load up.
        Pick = 1,
        /// Drop a load.
        Drop = 2,
        /// Park.
        Park = 3,
        /// Charge.
        Charge = 4,
        /// Pick a load up, or drop one.
        Transfer = 5,
    }
}

/// An edge of the route graph: one or more cubic Bézier curves, end to end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_EdgeRecord"))]
pub struct EdgeRecord {
    /// Id in the route graph's file.
    pub id: u32,
    /// Index of the origin in the world's nodes.
    pub origin: u32,
    /// Index of the destination in the world's nodes.
    pub destination: u32,
    /// Arc length of all its curves in metres.
    pub length: f32,
    /// Index of the first of its curves in the world's curves.
    pub first_curve: u32,
    /// Number of its curves; at least 1.
    pub curves: u32,
    /// Metres per second from origin to destination.
    pub speed: f32,
    /// Metres per second from destination to origin in reverse gear; 0 if that is not allowed.
    pub reverse_speed: f32,
    /// Offset of the name in the [`Texts`]; 0 for none.
    pub name: u32,
    /// Offset of the name of its level (floor) in the [`Texts`]; 0 for none.
    pub level: u32,
    /// Offset of the name of its zone in the [`Texts`]; 0 for none.
    pub zone: u32,
    /// The heading of robots along the edge: 0 for the tangent's, 1 for `orientation_angle` to the
    /// tangent, 2 for `orientation_angle` on the map. See [`orientation`](Self::orientation()).
    pub orientation: u32,
    /// Radians in (-π, π]; 0 if `orientation` is 0.
    pub orientation_angle: f32,
    /// Zero.
    pub reserved: [u32; 3],
}

/// The heading of robots along an edge, in both gears. Angles are in radians, in (-π, π].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Orientation {
    /// That of the edge's tangent, from origin to destination.
    #[default]
    Tangential,
    /// At this angle to the tangent.
    Offset(f32),
    /// This heading on the map.
    Fixed(f32),
}

/// A cubic Bézier curve: an edge or a part of one. It starts where the edge's curve before it ends.
/// Straight lines are curves with evenly spaced control points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_CurveRecord"))]
pub struct CurveRecord {
    /// Control points P0 to P3, each metres east and north of the world's origin.
    pub control_points: [[f32; 2]; 4],
}

/// A robot type.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_RobotTypeRecord"))]
pub struct RobotTypeRecord {
    /// Name in UTF-8, padded with zeros.
    pub name: [u8; MAX_TYPE_NAME_BYTES],
    /// A [`Shape`].
    pub shape: u32,
    /// Metres along the heading; of a circle, its diameter.
    pub length: f32,
    /// Metres across it.
    pub width: f32,
    /// Metres per second; `f32::INFINITY` for no limit.
    pub max_speed: f32,
    /// Metres per second squared; `f32::INFINITY` for no limit.
    pub max_acceleration: f32,
    /// Radians per second, of a turn on the spot; 0 if the type can't turn on the spot,
    /// `f32::INFINITY` for no limit.
    pub max_rotation_speed: f32,
    /// Radians per second squared, of a turn on the spot; `f32::INFINITY` for no limit.
    pub max_rotation_acceleration: f32,
    /// Watt-hours that its battery holds; 0 if it has none, and then so are the powers.
    pub battery_capacity: f32,
    /// Watts that it takes from its battery while it moves.
    pub drain_moving: f32,
    /// Watts that it takes from its battery while it stands.
    pub drain_standing: f32,
    /// Watts by which the charge of its battery grows while it stands idle at a node with the role
    /// `charge`.
    pub charge_rate: f32,
}

/// The longest name of a robot type, in bytes.
pub const MAX_TYPE_NAME_BYTES: usize = 36;

/// The footprint of a robot, about its pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Shape {
    /// `length` along the heading, `width` across it.
    #[default]
    Rectangle = 0,
    /// A circle of diameter `length`.
    Circle = 1,
}

impl NodeRecord {
    /// The purpose of the node. An unknown number counts as nothing in particular.
    pub fn role(&self) -> Role {
        Role::from_number(self.role).unwrap_or_default()
    }
}

impl Role {
    /// The name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Pick => "pick",
            Self::Drop => "drop",
            Self::Park => "park",
            Self::Charge => "charge",
            Self::Transfer => "transfer",
        }
    }

    /// Whether loads are picked up there.
    pub fn is_pick(self) -> bool {
        matches!(self, Self::Pick | Self::Transfer)
    }

    /// Whether loads are dropped there.
    pub fn is_drop(self) -> bool {
        matches!(self, Self::Drop | Self::Transfer)
    }
}

impl EdgeRecord {
    /// The heading of robots along the edge. An unknown number, or an angle that is no number,
    /// counts as the tangent.
    pub fn orientation(&self) -> Orientation {
        match self.orientation {
            1 if self.orientation_angle.is_finite() => Orientation::Offset(self.orientation_angle),
            2 if self.orientation_angle.is_finite() => Orientation::Fixed(self.orientation_angle),
            _ => Orientation::Tangential,
        }
    }

    /// Returns the edge with another heading of robots along it.
    #[must_use]
    pub fn with_orientation(self, orientation: Orientation) -> Self {
        let (orientation, orientation_angle) = match orientation {
            Orientation::Tangential => (0, 0.0),
            Orientation::Offset(angle) => (1, angle),
            Orientation::Fixed(angle) => (2, angle),
        };
        Self { orientation, orientation_angle, ..self }
    }
}

impl Orientation {
    /// Returns the heading, in radians in (-π, π], where the tangent of the edge has the angle
    /// `tangent`, in the same range.
    pub fn heading(self, tangent: f32) -> f32 {
        use core::f32::consts::{PI, TAU};
        match self {
            Self::Tangential => tangent,
            Self::Fixed(heading) => heading,
            Self::Offset(offset) => match tangent + offset {
                sum if sum > PI => sum - TAU,
                sum if sum <= -PI => sum + TAU,
                sum => sum,
            },
        }
    }
}

impl CurveRecord {
    /// Returns a straight line between two points, each metres east and north.
    pub fn straight(from: [f32; 2], to: [f32; 2]) -> Self {
        let [second, third] = [1.0 / 3.0, 2.0 / 3.0]
            .map(|part| [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis])));
        Self { control_points: [from, second, third, to] }
    }
}

impl RobotTypeRecord {
    /// Returns a rectangular type without a battery and without limits of speed and acceleration,
    /// which can't turn on the spot. Length and width are in metres; the name is cut to
    /// [`MAX_TYPE_NAME_BYTES`].
    pub fn new(name: &str, length: f32, width: f32) -> Self {
        Self {
            name: Self::padded_name(name),
            shape: Shape::Rectangle as u32,
            length,
            width,
            max_speed: f32::INFINITY,
            max_acceleration: f32::INFINITY,
            max_rotation_speed: 0.0,
            max_rotation_acceleration: f32::INFINITY,
            battery_capacity: 0.0,
            drain_moving: 0.0,
            drain_standing: 0.0,
            charge_rate: 0.0,
        }
    }

    /// The name, up to the first byte that is not UTF-8.
    pub fn name(&self) -> &str {
        text(&self.name)
    }

    /// The footprint. An unknown number counts as a rectangle.
    pub fn shape(&self) -> Shape {
        if self.shape == Shape::Circle as u32 { Shape::Circle } else { Shape::Rectangle }
    }

    /// Returns `name` as the record holds it: cut to [`MAX_TYPE_NAME_BYTES`], padded with zeros.
    pub fn padded_name(name: &str) -> [u8; MAX_TYPE_NAME_BYTES] {
        padded(name)
    }
}

super::sequence::sequenced!(WorldHeader: revision);

#[cfg(test)]
mod tests {
    use core::f32::consts::{FRAC_PI_2, PI};

    use super::*;

    #[test]
    fn records_have_their_sizes() {
        let sizes = [size_of::<NodeRecord>(), size_of::<EdgeRecord>(), size_of::<CurveRecord>()];
        assert_eq!((sizes, size_of::<RobotTypeRecord>()), ([32, 64, 32], 80));
    }

    #[test]
    fn orientations_and_roles_are_read_as_they_were_written() {
        for orientation in
            [Orientation::Tangential, Orientation::Offset(PI), Orientation::Fixed(-1.5)]
        {
            assert_eq!(
                EdgeRecord::default().with_orientation(orientation).orientation(),
                orientation
            );
        }
        let edge = EdgeRecord { orientation: 77, orientation_angle: 1.0, ..EdgeRecord::default() };
        assert_eq!(edge.orientation(), Orientation::Tangential);
        let edge =
            EdgeRecord { orientation: 1, orientation_angle: f32::NAN, ..EdgeRecord::default() };
        assert_eq!(edge.orientation(), Orientation::Tangential);
        for role in Role::ALL {
            assert_eq!(NodeRecord { role: role as u32, ..NodeRecord::default() }.role(), role);
        }
        assert_eq!(NodeRecord { role: 9, ..NodeRecord::default() }.role().name(), "none");
    }

    #[test]
    fn headings_are_within_half_a_turn() {
        assert_eq!(Orientation::Tangential.heading(1.0), 1.0);
        assert_eq!(Orientation::Fixed(2.0).heading(1.0), 2.0);
        assert!((Orientation::Offset(PI).heading(FRAC_PI_2) + FRAC_PI_2).abs() < 1e-6);
        assert!((Orientation::Offset(-FRAC_PI_2).heading(-3.0) - (1.5 * PI - 3.0)).abs() < 1e-6);
    }
}
