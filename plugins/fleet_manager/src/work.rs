//! The figures of the fleet's work, for those who watch it: the same as at the end of the run, but
//! for the current rate of orders.

use regatta_orders::Figures;
use regatta_plugin::activity::Activity;
use regatta_plugin::work::WorkFigures;
use regatta_plugin::{Frame, Participant, Result, WorkPublisher};

use crate::run_figures::{Doing, RunFigures};

/// The time between two samples, in simulated seconds.
const PERIOD_SECS: f64 = 1.0;

/// Publishes the figures about once in a simulated second, if anybody reads them.
pub(crate) struct Work {
    publisher: WorkPublisher,
    /// The run and the simulated time in seconds of the last sample.
    last: Option<(u64, f64)>,
}

impl Work {
    /// Opens the figures of a fleet.
    pub(crate) fn open_on(fleet: &Participant) -> Result<Self> {
        Ok(Self { publisher: WorkPublisher::open_on(fleet)?, last: None })
    }

    /// Gives the newest figures to readers that have joined since.
    pub(crate) fn update(&self) {
        self.publisher.update();
    }

    /// Whether figures are due at a frame.
    pub(crate) fn is_due(&self, frame: &Frame<'_>) -> bool {
        let now_secs = frame.sim_time().as_secs_f64();
        let is_recent = self.last.is_some_and(|(run_id, secs)| {
            run_id == frame.run_id() && (secs..secs + PERIOD_SECS).contains(&now_secs)
        });
        !is_recent && self.publisher.readers() > 0
    }

    /// Publishes the figures of orders and robots up to a frame. `doing` has the robots that are
    /// there.
    pub(crate) fn publish(
        &mut self,
        frame: &Frame<'_>,
        orders: &Figures,
        run: &RunFigures,
        doing: impl Iterator<Item = Doing>,
    ) -> Result {
        let (mut robots, mut busy) = (0, 0);
        for doing in doing {
            robots += 1;
            busy += u32::from(doing.has_order);
        }
        let waiting = run.share(Activity::Waiting);
        let figures = WorkFigures { robots, busy, ..figures(orders, waiting) };
        self.publisher.publish(frame.run_id(), frame.tick(), figures)?;
        self.last = Some((frame.run_id(), frame.sim_time().as_secs_f64()));
        Ok(())
    }
}

/// The figures of orders, as the contract has them. `waiting` is the part of the robots' time that
/// they waited.
fn figures(orders: &Figures, waiting: f64) -> WorkFigures {
    let by_state = &orders.orders;
    let open = by_state.created
        + by_state.waiting
        + by_state.travelling
        + by_state.handling
        + by_state.unroutable
        + by_state.unplaced;
    let [service_p50_secs, service_p99_secs] = match by_state.finished {
        0 => [f32::NAN; 2],
        _ => [orders.service.p50_secs as f32, orders.service.p99_secs as f32],
    };
    WorkFigures {
        secs: orders.secs,
        finished: by_state.finished as u64,
        open: open as u64,
        failed: by_state.failed as u64,
        orders_per_hour: orders.recent_orders_per_hour.map_or(f32::NAN, |rate| rate as f32),
        service_p50_secs,
        service_p99_secs,
        waiting: waiting as f32,
        ..WorkFigures::default()
    }
}

#[cfg(test)]
mod tests {
    use regatta_orders::{ByState, Durations};

    use super::*;

    #[test]
    fn open_orders_are_all_that_are_not_over() {
        let by_state = ByState {
            created: 1,
            waiting: 2,
            travelling: 4,
            handling: 8,
            finished: 16,
            failed: 32,
            cancelled: 64,
            unroutable: 128,
            unplaced: 256,
        };
        let service = Durations { p50_secs: 60.0, p99_secs: 90.0, ..Durations::default() };
        let orders = Figures {
            orders: by_state,
            service,
            orders_per_hour: 3_000.0,
            recent_orders_per_hour: Some(6_500.0),
            ..Figures::default()
        };
        let found = figures(&orders, 0.25);
        assert_eq!(found.rate(), Some(6_500.0), "the current rate");
        assert_eq!((found.open, found.finished, found.failed), (399, 16, 32));
        assert_eq!((found.service_secs(), found.waiting), (Some([60.0, 90.0]), 0.25));
        let begun = Figures { orders: ByState::default(), recent_orders_per_hour: None, ..orders };
        let begun = figures(&begun, 0.0);
        assert_eq!(begun.rate(), None, "in the first minute");
        assert_eq!(begun.service_secs(), None, "no order is finished yet");
    }
}
