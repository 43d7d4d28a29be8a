//! Marks robots that collide, now or soon.
//!
//! For every frame, the [`Detector`] determines for each robot whether it is clear (0), a possible
//! collision (1) or touching another (2). The plugin publishes that as the column `collision`, the
//! pairs as contacts, and the changes as contact events (see [`regatta_plugin::contact`]).
//!
//! # Definitions
//!
//! A robot covers its type's rectangle around its pose, or its circle. Two robots
//!
//! - *touch* if their footprints have a point in common;
//! - are a *possible* collision if their footprints are at most the margin apart, or will have a
//!   point in common at some time within the horizon, if both robots continue.
//!
//! Distances are computed in `f64` from the frame's `f32`; headings are exact to 2·10⁻⁷.
//!
//! **Continuing** means driving the route as far as it is released, and stopping where it ends. A
//! robot of a type with limited acceleration speeds up to the speed of each leg, and brakes in time
//! for the next legs, as in the engine. A held robot brakes to a stop; without a limit, it stands
//! at once. Robots that neither drive nor are held keep their speed. Speeds above 50 m/s count as
//! 50 m/s, and those that are not numbers as 0.
//!
//! If a robot's route is not known, or ends with its known part, the robot may take any leg from
//! each node in the same gear, except straight back if there is another. Of legs that differ in
//! speed, it takes none for which it is already too fast. A pair is possible if it is on one of the
//! ways. At a node that more than 4 legs leave, after 8 ways, and where no leg leaves, a robot
//! drives straight on along the tangent.
//!
//! A robot without an edge, or with one that the world doesn't have, drives straight on along its
//! heading. The route only determines the motion from the present pose: a pose beside the edge
//! stays beside it, and a heading that differs from the edge's keeps its angle to it. An edge's
//! heading is that of its orientation: its tangent's, one at an angle to that, or a fixed one. A
//! robot that turns on the spot stands, and is not predicted to drive before it has turned.
//!
//! An edge is approximated by chords, from which it deviates by at most 2 cm and along each of
//! which it turns by at most 0.2 radians, evenly. An acceleration is cut into parts of constant
//! speed that deviate by at most 1 cm. In each of these segments both robots move straight. Whether
//! rectangles or circles that don't turn collide has an exact answer then (separating axes over
//! time); segments with a turn are cut until no corner is off by more than 1 cm. No instants are
//! sampled: however small and fast two robots are, no collision is missed, and none depends on the
//! times of the frames.
//!
//! **Hysteresis.** A pair reaches a level when the definition holds, and leaves it when it no
//! longer holds with a tolerance of 2 cm: when the footprints are more than 2 cm apart, or more
//! than the margin and 2 cm apart and on the predicted trajectories not overlapping even if both
//! are 1 cm larger on all sides. So no pair flickers at a boundary.
//!
//! **Events.** A pair that touches is also possible. Each level that a pair reaches has one `began`
//! event, and one `ended` event when the pair leaves it: a sudden contact is two events, `possible`
//! and `touching`. A pair ends where it was last seen. A new run (another run id, or a tick before
//! the last one) resets everything.
//!
//! # Exclusions
//!
//! Absent robots are excluded, as are poses that are not numbers, or beyond 10⁶ m or 1000 radians,
//! and types whose size is not a number, negative or above 1000 m. Such robots are clear, and the
//! number of invalid ones is reported. Without the column `type`, robots are of the first type;
//! without robot types, they are 0.9 m × 0.6 m.
//!
//! # Modules
//!
//! A frame passes through these stages:
//!
//! 1. `frame_context` and `chunk` read the frame block by block; with a horizon, `prediction`
//!    computes each robot's trajectories along its legs in the `leg_table` and their chords in the
//!    `edge_table`, and `swept_path` their summaries. `routes` knows the routes that
//!    `route_requests` has asked for.
//! 2. `strip_index` enters the robots into strips of the plane.
//! 3. The broad phase, `sweep`, finds the robots of a strip whose bounding boxes overlap.
//! 4. The narrow phase, `narrow_phase`, checks those pairs exactly: now by `body`, and within the
//!    horizon by `continuous`. `criteria` holds the result, and `overlap` finds the point at which
//!    a pair touches.
//! 5. The `tracker` follows pairs from frame to frame, and adds up the run's `totals`.
//!
//! # Cost and limits
//!
//! Time grows with the number of robots and of nearby pairs. If all robots are in one pile, those
//! are all pairs, so there are limits: 64 checks, 512 comparisons and 8 pairs for each robot on
//! average, plus some hundred thousand for any fleet. When one is exceeded, the frame is processed
//! again with the pairs known from before and 8 neighbours of each robot. That is reported as
//! `capped`: all pairs in the list are real, but there may be more.

mod body;
mod bounds;
mod chunk;
mod continuous;
mod criteria;
mod detector;
mod edge_table;
mod frame_context;
#[cfg(test)]
mod geometry_reference;
mod grid;
mod heading;
mod leg_table;
mod log;
mod narrow_phase;
mod overlap;
mod plugin;
mod prediction;
mod radix;
mod relative_motion;
mod route_requests;
mod routes;
mod skips;
mod strip_index;
mod sweep;
mod swept_path;
mod totals;
mod tracker;

pub use criteria::{HYSTERESIS, MAX_HORIZON, MAX_MARGIN, Settings, SettingsError};
pub use detector::{Detector, FrameInput};
pub use log::{HEADER as LOG_HEADER, LogError};
pub use plugin::{Cli, plugin, run_from};
pub use routes::Routes;
pub use totals::{RunTotals, Score};
