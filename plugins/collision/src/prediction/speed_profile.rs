//! The speed of a robot along its path: it accelerates to the speed of each leg, and brakes in time
//! for slower ones, for a change of gear, and for the end of its route. The engine drives by the
//! same equations, tick by tick.

use super::Intent;
use super::path::{PathLeg, RouteEnd, Start};
use super::tracer::Tracer;
use crate::leg_table::LegTable;

/// The largest distance between an accelerating robot and its segments, in metres.
const MAX_DEVIATION: f32 = 0.01;
/// The largest number of segments of one acceleration.
const MAX_SLICES: f32 = 64.0;

/// A leg of a path with its limits.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    /// Metres that are driven on it.
    length: f32,
    /// The speed to accelerate or brake to, in metres per second.
    cruise: f32,
    /// The highest speed at its end, in metres per second.
    exit: f32,
}

/// The stretches of a path; kept to reuse its memory.
#[derive(Debug, Default)]
pub(super) struct SpeedProfile(Vec<Stretch>);

impl SpeedProfile {
    /// Drives on along the present edge until the horizon.
    pub(super) fn drive_on<'table>(
        &mut self,
        start: &Start<'table>,
        tracer: &mut Tracer<'_, 'table>,
    ) {
        let cruise = start.cruise(start.leg_speed());
        let speed = start.speed(cruise);
        tracer.enter_at(start.chords(), start.motion.s);
        if speed == cruise {
            // Most robots: at a constant speed, there is nothing to plan.
            let seconds = tracer.rest();
            return tracer.advance(speed * seconds, seconds);
        }
        let only = Stretch { length: f32::INFINITY, cruise, exit: f32::INFINITY };
        drive_stretch(tracer, only, speed, start.acceleration());
    }

    /// Drives the rest of the present edge, in metres, and the path after it.
    pub(super) fn drive<'table>(
        &mut self,
        start: &Start<'table>,
        rest: f32,
        (path, end): (&[PathLeg], RouteEnd),
        table: &'table LegTable,
        tracer: &mut Tracer<'_, 'table>,
    ) {
        if path.is_empty() && end == RouteEnd::Open {
            return self.drive_on(start, tracer);
        }
        self.plan(start, rest, path, end);
        let mut speed = start.speed(self.0[0].cruise);
        tracer.enter_at(start.chords(), start.motion.s);
        for (number, stretch) in self.0.iter().enumerate() {
            if let Some(next) = number.checked_sub(1).and_then(|before| path.get(before)) {
                let Some(leg) = table.get(next.leg) else { break };
                tracer.enter_next(leg.chords, leg.length, next.sign());
            }
            speed = drive_stretch(tracer, *stretch, speed, start.acceleration());
            if tracer.rest() <= 0.0 {
                break;
            }
        }
    }

    /// Computes the stretches of a path. The speed at the end of each is limited by all that comes
    /// after it.
    fn plan(&mut self, start: &Start, rest: f32, path: &[PathLeg], end: RouteEnd) {
        let legs = path.iter().map(|leg| (leg.length, leg.speed));
        self.0.clear();
        self.0.extend(std::iter::once((rest, start.leg_speed())).chain(legs).map(
            |(length, speed)| Stretch { length, cruise: start.cruise(speed), exit: f32::INFINITY },
        ));
        let mut sign = path.last().map_or(start.sign, |leg| leg.sign());
        let mut exit = if end == RouteEnd::Stop { 0.0 } else { f32::INFINITY };
        if let Some(last) = self.0.last_mut().filter(|_| end == RouteEnd::Open) {
            last.length = f32::INFINITY;
        }
        for number in (0..self.0.len()).rev() {
            self.0[number].exit = exit;
            let before = number.checked_sub(2).map_or(start.sign, |before| path[before].sign());
            let Stretch { length, cruise, .. } = self.0[number];
            let brake = (exit * exit + 2.0 * start.acceleration() * length).sqrt();
            // A held robot drives no leg faster than it comes in.
            let entry = if start.motion.intent == Intent::Hold { f32::INFINITY } else { cruise };
            exit = if before == sign { entry.min(brake) } else { 0.0 };
            sign = before;
        }
    }
}

/// Drives a stretch, and returns the speed at its end.
fn drive_stretch(tracer: &mut Tracer, stretch: Stretch, speed: f32, acceleration: f32) -> f32 {
    let Stretch { mut length, cruise, exit } = stretch;
    if acceleration == f32::INFINITY {
        drive_phase(tracer, length, cruise, cruise);
        return cruise;
    }
    let mut speed = speed;
    if speed > cruise {
        let braking = ((speed * speed - cruise * cruise) / (2.0 * acceleration)).min(length);
        let slower = (speed * speed - 2.0 * acceleration * braking).max(0.0).sqrt();
        drive_phase(tracer, braking, speed, slower);
        (length, speed) = (length - braking, slower);
    }
    if exit < speed && speed * speed - exit * exit > 2.0 * acceleration * length {
        // Too late: it brakes harder, because it never leaves its base.
        drive_phase(tracer, length, speed, exit);
        return exit;
    }
    let fastest = speed * speed + 2.0 * acceleration * length;
    let slowest_exit = (exit * exit).min(fastest);
    let peak = (0.5 * (fastest + slowest_exit)).sqrt().min(cruise).max(speed);
    let exit = slowest_exit.sqrt().min(peak);
    let [rising, falling] =
        [speed, exit].map(|slow| (peak * peak - slow * slow) / (2.0 * acceleration));
    drive_phase(tracer, rising.min(length), speed, peak);
    drive_phase(tracer, length - rising - falling, peak, peak);
    drive_phase(tracer, falling, peak, exit);
    exit
}

/// Drives so many metres while the speed changes evenly.
fn drive_phase(tracer: &mut Tracer, metres: f32, from: f32, to: f32) {
    let whole = 2.0 * metres / (from + to);
    let seconds = whole.min(tracer.rest());
    if !(metres > 0.0 && seconds > 0.0 && from + to > 0.0) {
        return;
    }
    let acceleration = (to - from) / whole;
    let slices = (seconds * (acceleration.abs() * (0.125 / MAX_DEVIATION)).sqrt())
        .ceil()
        .clamp(1.0, MAX_SLICES);
    let slice = seconds / slices;
    for number in 0..slices as u32 {
        let middle = from + acceleration * slice * (number as f32 + 0.5);
        tracer.advance(middle * slice, slice);
    }
}
