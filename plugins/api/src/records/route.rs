//! Routes: the legs that a robot is going to drive. Request-response on `regatta/F/routes`. A
//! producer that knows no routes (a replay, a UDP source) has no server there.

use core::cmp::Ordering;

use bytemuck::{Pod, Zeroable};
#[cfg(feature = "shared-memory")]
use iceoryx2::prelude::ZeroCopySend;

/// The largest number of legs that one answer lists. A longer route is cut; its total length is
/// still reported.
pub const LISTED_LEGS: usize = 256;

/// The value of [`RouteResponse::found`] for a robot that drives on beyond the listed legs.
const DRIVES_ON: u32 = 2;

/// The bit of a leg that marks reverse gear: from destination to origin.
const REVERSE: u32 = 1 << 31;

/// A request for the route of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_RouteRequest"))]
pub struct RouteRequest {
    /// The robot, by id.
    pub robot: u32,
    /// Zero.
    pub reserved: u32,
}

/// The remaining route of a robot, as it was between two ticks.
///
/// The first leg is the one that the robot is on, unless it stands at its end or on a node. For a
/// loop, the response lists one lap from there; the part up to the end of the route's list is
/// released. For a random walk, it lists the leg that the robot is on and the next ones, as far as
/// they are drawn. A robot without a route has no legs.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[cfg_attr(feature = "shared-memory", derive(ZeroCopySend))]
#[repr(C)]
#[cfg_attr(feature = "shared-memory", type_name("regatta_RouteResponse"))]
pub struct RouteResponse {
    /// The run. Edges are those of its world.
    pub run_id: u64,
    /// Ticks since its start.
    pub tick: u64,
    /// The requested robot.
    pub robot: u32,
    /// 0 if there is no such robot; 1 if there is; 2 if it also drives on beyond the listed legs,
    /// without another command: on a loop or a random walk.
    pub found: u32,
    /// The number of remaining legs.
    pub legs: u32,
    /// The number of released legs, which come first: the robot may drive them now, the last of
    /// them as far as `released_metres`. The others are horizon.
    pub released: u32,
    /// Metres of the last released leg that are released, from where it is entered; infinity for
    /// all of it.
    pub released_metres: f32,
    /// Zero.
    pub reserved: u32,
    /// The first [`LISTED_LEGS`] remaining legs; zero beyond. Each is the index of an edge in the
    /// world, and bit 31 is set if it is driven in reverse gear. [`legs`](Self::legs()) reads them.
    pub listed: [u32; LISTED_LEGS],
}

/// A leg that a robot has still to drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegAhead {
    /// Index of the edge in the world.
    pub edge: u32,
    /// Whether it is driven from destination to origin, in reverse gear.
    pub reverse: bool,
    /// Whether the robot may drive it now, at least a part of it; if not, it is horizon.
    pub released: bool,
    /// Metres that the robot may drive now, from where the leg is entered: infinity for all of it,
    /// 0 for horizon.
    pub released_metres: f32,
}

impl RouteRequest {
    /// Creates a request for the route of a robot.
    pub const fn new(robot: u32) -> Self {
        Self { robot, reserved: 0 }
    }
}

impl RouteResponse {
    /// Returns the response for a robot that doesn't exist.
    pub fn unknown(run_id: u64, tick: u64, robot: u32) -> Self {
        Self { run_id, tick, robot, ..Self::default() }
    }

    /// Turns this into a response with a route of `legs` legs, of which the first `released` are
    /// released. `edges` are the legs in order: the index of the edge (less than 2³¹), and whether
    /// it is driven in reverse gear.
    #[must_use]
    pub fn with_legs(
        self,
        released: usize,
        legs: usize,
        edges: impl Iterator<Item = (u32, bool)>,
    ) -> Self {
        let mut response = Self {
            found: 1,
            released: released as u32,
            legs: legs as u32,
            released_metres: f32::INFINITY,
            ..self
        };
        for (place, (edge, reverse)) in response.listed.iter_mut().zip(edges.take(legs)) {
            *place = edge | if reverse { REVERSE } else { 0 };
        }
        response
    }

    /// Turns this into a response with the released metres of the last released leg.
    #[must_use]
    pub fn up_to(self, released_metres: f32) -> Self {
        Self { released_metres, ..self }
    }

    /// Turns this into a response for a robot that drives on beyond the listed legs.
    #[must_use]
    pub fn and_on(self) -> Self {
        Self { found: DRIVES_ON, ..self }
    }

    /// Whether the robot drives all listed legs and then on, without another command: on a loop or
    /// a random walk.
    pub fn drives_on(&self) -> bool {
        self.found == DRIVES_ON
    }

    /// Whether the robot exists.
    pub fn is_found(&self) -> bool {
        self.found != 0
    }

    /// The listed legs in driving order: all, or the first [`LISTED_LEGS`].
    pub fn legs(&self) -> impl ExactSizeIterator<Item = LegAhead> + '_ {
        let listed = &self.listed[..(self.legs as usize).min(LISTED_LEGS)];
        listed.iter().enumerate().map(|(place, leg)| LegAhead {
            edge: leg & !REVERSE,
            reverse: leg & REVERSE != 0,
            released: place < self.released as usize,
            released_metres: match (place + 1).cmp(&(self.released as usize)) {
                Ordering::Less => f32::INFINITY,
                Ordering::Equal => self.released_metres,
                Ordering::Greater => 0.0,
            },
        })
    }
}

impl Default for RouteResponse {
    /// Returns a response of zeros: no such robot.
    fn default() -> Self {
        Self::zeroed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legs_are_read_as_they_were_written() {
        let edges = [(3, false), (0, true), (REVERSE - 1, true)];
        let response = RouteResponse::unknown(1, 2, 7).with_legs(2, 3, edges.into_iter());
        let leg = |edge, reverse, released_metres: f32| LegAhead {
            edge,
            reverse,
            released: released_metres > 0.0,
            released_metres,
        };
        let all = f32::INFINITY;
        let wanted = [leg(3, false, all), leg(0, true, all), leg(REVERSE - 1, true, 0.0)];
        assert_eq!(response.legs().collect::<Vec<_>>(), wanted);
        let wanted = [leg(3, false, all), leg(0, true, 1.5), leg(REVERSE - 1, true, 0.0)];
        assert_eq!(response.up_to(1.5).legs().collect::<Vec<_>>(), wanted);
        assert_eq!((response.robot, response.legs, response.released), (7, 3, 2));
        assert!(response.is_found() && !response.drives_on());
        assert!(response.and_on().is_found() && response.and_on().drives_on());
    }

    #[test]
    fn the_first_legs_of_a_long_route_are_listed() {
        let edges = (0..1_250).map(|edge| (edge, false));
        let response = RouteResponse::unknown(1, 2, 7).with_legs(250, 1_250, edges);
        assert_eq!(
            (response.legs, response.released, response.legs().len()),
            (1_250, 250, LISTED_LEGS)
        );
        assert_eq!(response.legs().filter(|leg| leg.released).count(), 250);
        assert_eq!(response.legs().last().map(|leg| leg.edge), Some(255));
        assert_eq!(RouteResponse::unknown(1, 2, 7).legs().len(), 0);
    }
}
