//! The figures of the fleet, for plots.

use prost::Message;
use regatta_messages::schema::regatta::{ContactCounts, Figures, RobotCounts, WorkFigures};
use regatta_plugin::activity::Activity;
use regatta_plugin::contact::ContactHeader;
use regatta_plugin::frame::FrameHeader;
use regatta_plugin::history::FleetSample;
use regatta_plugin::{Frame, work};

/// Makes figures; it remembers the clocks of those before.
#[derive(Debug, Default)]
pub(crate) struct FigureMaker {
    before: FrameHeader,
}

impl FigureMaker {
    /// Returns the figures of a frame, with those of contacts and of a fleet manager if there are
    /// some of its run. `activities` are the values of the column `activity`, if it is published.
    pub fn encode(
        &mut self,
        frame: &Frame<'_>,
        activities: &[f32],
        contacts: Option<&ContactHeader>,
        work: Option<&work::WorkFigures>,
    ) -> Vec<u8> {
        let header = *frame.header();
        let before = std::mem::replace(&mut self.before, header);
        let sample = FleetSample::of(frame, activities);
        Figures {
            run_id: header.run_id,
            tick: header.tick,
            sim_time_secs: sample.secs,
            real_time_factor: real_time_factor(&before, &header),
            late_ticks: header.late_ticks,
            tick_cost_secs: header.tick_cost_nanos as f64 * 1e-9,
            robots: Some(robots(&sample)),
            mean_speed: f64::from(sample.mean_speed),
            contacts: contacts.filter(|contacts| contacts.run_id == header.run_id).map(counts),
            work: work.map(work_figures),
        }
        .encode_to_vec()
    }
}

/// Simulated seconds per wall second between two frames; 0 if the clock has stood, or jumped.
fn real_time_factor(before: &FrameHeader, now: &FrameHeader) -> f64 {
    if (before.run_id, before.jumps) != (now.run_id, now.jumps) {
        return 0.0;
    }
    let simulated = now.sim_time_nanos.saturating_sub(before.sim_time_nanos);
    let wall = now.wall_time_nanos.saturating_sub(before.wall_time_nanos);
    if wall == 0 { 0.0 } else { simulated as f64 / wall as f64 }
}

fn robots(sample: &FleetSample) -> RobotCounts {
    RobotCounts {
        idle: sample.count(Activity::Idle),
        fetching: sample.count(Activity::Fetching),
        carrying: sample.count(Activity::Carrying),
        handling: sample.count(Activity::Handling),
        waiting: sample.count(Activity::Waiting),
        queued: sample.count(Activity::Queued),
        charging: sample.count(Activity::Charging),
        held: sample.count(Activity::Held),
        broken: sample.count(Activity::Broken),
        faulted: sample.count(Activity::Faulted),
        stalled: sample.count(Activity::Stalled),
        moving: sample.count(Activity::Moving),
        rotating: sample.count(Activity::Rotating),
        all: sample.robots(),
    }
}

fn counts(contacts: &ContactHeader) -> ContactCounts {
    ContactCounts {
        touching: contacts.touching,
        possible: contacts.possible,
        touching_ever: contacts.touching_ever,
    }
}

fn work_figures(work: &work::WorkFigures) -> WorkFigures {
    let [p50, p99] =
        work.service_secs().map_or([None; 2], |secs| secs.map(|secs| Some(secs.into())));
    WorkFigures {
        finished: work.finished,
        open: work.open,
        failed: work.failed,
        orders_per_hour: work.rate().map(f64::from),
        service_p50_secs: p50,
        service_p99_secs: p99,
        waiting: work.waiting.into(),
        busy: work.busy,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_is_simulated_by_wall_time() {
        let before = FrameHeader {
            run_id: 1,
            sim_time_nanos: 1_000,
            wall_time_nanos: 5_000,
            ..FrameHeader::default()
        };
        let now = FrameHeader { sim_time_nanos: 4_000, wall_time_nanos: 6_000, ..before };
        assert_eq!(real_time_factor(&before, &now), 3.0);
        assert_eq!(real_time_factor(&before, &before), 0.0, "no time has passed");
        assert_eq!(real_time_factor(&before, &FrameHeader { jumps: 1, ..now }), 0.0);
        assert_eq!(real_time_factor(&before, &FrameHeader { run_id: 2, ..now }), 0.0);
    }
}
