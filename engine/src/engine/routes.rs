//! The remaining routes of robots, reported between ticks.

use regatta_plugin::producer::Session;
use regatta_plugin::route::RouteResponse;

use super::{EngineError, Simulation};
use crate::graph::Gear;

/// The largest number of routes that are reported between two ticks. More requests wait for the next.
const MAX_ROUTES: usize = 16;

impl Simulation {
    /// Answers the requests that have arrived since the last call.
    pub(super) fn answer_routes(&mut self, session: &Session) -> Result<(), EngineError> {
        let Self { routes, fleet, .. } = self;
        routes.answer(MAX_ROUTES, |request| {
            let response = RouteResponse::unknown(session.run_id(), session.tick(), request.robot);
            let Some(ahead) = fleet.ahead(request.robot) else { return response };
            let edges = ahead.legs().map(|leg| (leg.edge.0, leg.gear == Gear::Reverse));
            response.with_legs(ahead.released(), ahead.len(), edges)
        })?;
        Ok(())
    }
}
